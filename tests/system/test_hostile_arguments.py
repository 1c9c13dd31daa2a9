"""Every public callable answers arguments that nobody expects by an error in words, or takes them.

Such an error is of a documented class, names the argument and is short; what is taken also works
in the next reset and step; and neither takes much memory.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.hostile import HOSTILE, Target, faults, named_targets, targets, use


@pytest.fixture(autouse=True)
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.filterwarnings("ignore")
def test_hostile_arguments_are_answered_in_words() -> None:
    called = [*targets(), *named_targets()]
    names = {target.name for target in called}
    assert names > {"WarehouseEnv", "FleetEnv.assign", "BatchEnv.row", "RobotSpec", "shelf_layout"}
    assert names > {"parallel_env.step", "WarehouseVectorEnv", "PIBT", "replay_episode"}
    assert [fault for target in called for fault in faults(target)] == []


class Kept:
    """Something that fails when it is used."""

    def __init__(self, size: object) -> None:
        self.size = size

    def act(self, _: object) -> None:
        raise RuntimeError("it was used")

    def reset(self) -> None:
        pass


def grown(size: Any) -> object:
    return bytearray(2**40)


def unnamed(size: Any) -> object:
    raise ValueError("this is wrong")


def undocumented(size: Any) -> object:
    raise KeyError(size)


def wordy(size: Any) -> object:
    raise TypeError("size" * 1000)


@pytest.mark.parametrize(
    ("call", "fault"),
    [
        (Kept, "it was accepted, and then raised RuntimeError("),
        (grown, "it raised MemoryError("),
        (unnamed, "the message does not name it: this is wrong"),
        (undocumented, "it raised "),
        (wordy, "4000 characters: sizesize"),
    ],
)
def test_a_bad_answer_is_found(call: Callable[..., Any], fault: str) -> None:
    found = faults(Target(call.__name__, call, use))
    assert len(found) == len(HOSTILE)
    assert all(line.startswith(f"{call.__name__}(size=") and fault in line for line in found)
