"""The results of ``warehouse pogema``: a line of CSV for each episode, written as it finishes.

The same command with the same file does what is missing.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from importlib.metadata import version
from io import StringIO
from pathlib import Path
from typing import NamedTuple

from agents.errors import StoreError
from agents.lab.commands.pogema.benchmark import SETS, Instance, Kind
from agents.lab.commands.pogema.trial import Outcome
from agents.lab.runs.programs import fingerprint, program_for
from agents.mapf.kernels.buffers import IS_COMPILED
from agents.registry import agent_file, agent_module
from warehouse_core.files.reading import read_file

MAX_BYTES = 64 * 1024 * 1024
"""Limit on the bytes of a file of results; all episodes of a planner take about a megabyte."""


class Key(NamedTuple):
    """What a planner was to do: an episode, and the seconds for a plan or a step."""

    kind: Kind
    collection: str
    robots: int
    episode: int
    planner: str
    limit: float


COLUMNS = (
    "kind", "set", "robots", "episode", "planner", "plan_seconds", "map", "seed", "program",
    *Outcome._fields,
)  # fmt: skip


def key_of(instance: Instance, planner: str, limit: float) -> Key:
    """Return the key of an episode."""
    return Key(instance.kind, instance.collection, instance.robots, instance.number, planner, limit)


class Results:
    """Outcomes by key; with a path they are read from its file, and added to it.

    Raises:
        StoreError: the file has other lines than this program writes.
        OSError: the file cannot be read or written.
    """

    def __init__(self, path: Path | None) -> None:
        self.path, self.outcomes = path, dict[Key, Outcome]()
        self._programs = dict[Key, str]()
        if path is None:
            return
        if path.exists():
            self._read(path)
        else:
            path.write_text(_line(COLUMNS), encoding="utf-8")

    def add(self, instance: Instance, planner: str, limit: float, outcome: Outcome) -> None:
        """Add an outcome, and write it to the file."""
        key = key_of(instance, planner, limit)
        self.outcomes[key] = outcome
        if self.path is not None:
            words = (*key, instance.map_name, instance.seed, program_of(planner), *outcome)
            with self.path.open("a", encoding="utf-8") as file:
                file.write(_line(words))

    def check_program(self, planner: str) -> None:
        """Raise ``StoreError`` if another program has run episodes of a planner."""
        for key, program in self._programs.items():
            if key.planner == planner and program != program_of(planner):
                raise StoreError(
                    f"{self.path}: the episodes of planner {planner!r} were run by {program}, and "
                    f"new ones would be run by {program_of(planner)}; write to another file"
                )

    def _read(self, path: Path) -> None:
        text = read_file(path, MAX_BYTES).decode("utf-8", "replace")
        whole, end, rest = text.rpartition("\n")
        if rest:  # a line that was being written when the machine stopped
            path.write_text(whole + end, encoding="utf-8")
        lines = csv.reader(StringIO(whole + end))
        if tuple(next(lines, ())) != COLUMNS:
            raise StoreError(f"{path}: it was not written by warehouse pogema")
        for number, line in enumerate(lines, start=2):
            try:
                key, program, outcome = _parsed(line)
            except ValueError as error:
                raise StoreError(f"{path}, line {number}: {error}") from error
            self.outcomes[key], self._programs[key] = outcome, program


def program_of(planner: str) -> str:
    """Return the name of the program that runs a planner here, as the results have it."""
    digest = fingerprint(agent_file(planner), agent_module(planner))
    return ", ".join([program_for("grid"), *_compiler(), *([digest[:10]] if digest else [])])


def _compiler() -> Iterator[str]:
    if IS_COMPILED:
        yield f"numba {version('numba')}"


def _line(words: tuple[object, ...]) -> str:
    file = StringIO()
    csv.writer(file, lineterminator="\n").writerow(words)
    return file.getvalue()


def _parsed(line: list[str]) -> tuple[Key, str, Outcome]:
    if len(line) != len(COLUMNS):
        raise ValueError(f"it has {len(line)} fields; needed: {len(COLUMNS)}")
    kind, collection, robots, episode, planner, limit, _, _, program, *rest = line
    if collection not in SETS:
        raise ValueError(f"no set is called {collection!r}; allowed: {', '.join(SETS)}")
    key = Key(Kind(kind), collection, int(robots), int(episode), planner, float(limit))
    steps, costs, bound, proved, goals, late = map(int, rest[:-1])
    return key, program, Outcome(steps, costs, bound, proved, goals, late, float(rest[-1]))
