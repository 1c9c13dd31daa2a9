"""Calls of a function, or questions to a dictionary, whose answers a rubric knows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isclose
from pathlib import Path
from typing import Any, NamedTuple

from agents.lab.grading.child import as_tuples

MAX_SHOWN = 300
"""Most characters of a value that are told."""

TOLERANCE = 1e-6
"""Difference by which a number may miss the answer, absolute and relative."""


class Call(NamedTuple):
    """The arguments of a call, and the right answer; both are as JSON has them."""

    arguments: Sequence[Any]
    answer: Any


@dataclass(frozen=True, slots=True)
class CallCase:
    """Calls of one function of a submission, as a table of the rubric asks for them.

    Attributes:
        function: name of the function, or of a dictionary that is looked up by the arguments.
        visible: the report may tell the calls and their answers.
    """

    name: str
    function: str
    calls: tuple[Call, ...]
    visible: bool = True

    @property
    def seeds(self) -> range:
        """The numbers of the calls."""
        return range(len(self.calls))

    @property
    def episodes(self) -> int:
        """The number of calls."""
        return len(self.calls)

    @property
    def files(self) -> list[Path]:
        """No files, as a case of episodes may have."""
        return []

    def command(self, agent: str, seed: int) -> str:
        """Return no command: a call has no replay."""
        return ""

    def shown(self, number: int) -> str:
        """Return a call as it would be typed, with the tuples that the function gets."""
        arguments = map(as_tuples, self.calls[number].arguments)
        return f"{self.function}({', '.join(map(_shown, arguments))})"

    def told(self, number: int, answer: object) -> str:
        """Return a call, its answer and the right one, in words."""
        return f"{self.shown(number)} is {_shown(answer)}, not {_shown(self.calls[number].answer)}"


def is_right(answer: object, wanted: object) -> bool:
    """Return whether an answer is the right one; numbers may differ by ``TOLERANCE``."""
    if isinstance(answer, bool) or isinstance(wanted, bool):
        return answer is wanted
    if isinstance(answer, int | float) and isinstance(wanted, int | float):
        try:
            return isclose(answer, wanted, rel_tol=TOLERANCE, abs_tol=TOLERANCE)
        except OverflowError:  # an int that no float can hold
            return answer == wanted
    if isinstance(answer, list) and isinstance(wanted, list):
        return len(answer) == len(wanted) and all(map(is_right, answer, wanted))
    if isinstance(answer, dict) and isinstance(wanted, dict):
        same = answer.keys() == wanted.keys()
        return same and all(is_right(answer[key], wanted[key]) for key in answer)
    return answer == wanted


def _shown(value: object) -> str:
    """Return a value as it would be typed, cut short if it is long."""
    text = repr(value)
    return text if len(text) <= MAX_SHOWN else f"{text[:MAX_SHOWN]}..."
