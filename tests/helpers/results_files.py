"""Files of results with given episodes and settings."""

import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from agents.lab.experiments.case import make_case
from agents.lab.experiments.store import Store
from agents.lab.reports.results import LONE, Experiment, ReportKind
from agents.lab.trials.rows import AnyRow, FleetRow, Row
from agents.lab.trials.scores import Scores


def row(seed: int, mode: str = "delivered", steps: int = 20, **others: Any) -> Row:
    """Return the row of an episode that ended with ``mode`` after ``steps`` steps."""
    plain = Row(seed, mode, steps, 10, 5.0, 100, float(steps), 2.0 * steps, 1, 1)
    return plain._replace(**others)


Cases = Sequence[tuple[Mapping[str, Any], Sequence[AnyRow]]]
ON, OFF = {"escape": True}, {"escape": False}


def fill(path: Path, cases: Cases) -> Path:
    """Write the episodes of some cases, each given by its settings."""
    with Store(path) as store:
        for settings, rows in cases:
            # The agent need not exist, because it is not run.
            case = {**make_case({**settings, "agent": "greedy"}), **settings}
            store.add(store.case_ids([case])[0], rows)
    return path


@contextmanager
def experiment_of(cases: Cases, kind: ReportKind = LONE) -> Iterator[Experiment]:
    """Yield the results of some cases, in a file of their own."""
    with TemporaryDirectory() as folder:
        path = fill(Path(folder, "r.sqlite"), cases)
        with Store(path, read_only=True) as store:
            yield Experiment(store, kind)


def change(path: Path, script: str, *values: object) -> None:
    """Change a file of results with one statement and its values, or with several statements."""
    with closing(sqlite3.connect(path)) as connection:
        if values:
            connection.execute(script, values)
            connection.commit()
        else:
            connection.executescript(script)


def outcomes(words: str, seed: int = 0, steps: int = 20) -> list[Row]:
    """Return a row for each letter: ``d`` delivered, ``o`` oscillation, ``w`` wandering."""
    modes = {"d": "delivered", "o": "oscillation", "w": "wandering"}
    return [row(number, modes[each], steps) for number, each in enumerate(words, start=seed)]


def hall(folder: Path, length: int) -> str:
    """Write a layout with a hall of some cells between its stations, and return its file."""
    file, wall = folder / f"hall{length}.txt", "#" * (length + 4)
    file.write_text(f"{wall}\n#P{'.' * length}D#\n{wall}")
    return str(file)


GOOD = row(0, steps=20, seconds=40.0, joules=900.0)
BAD = row(0, "oscillation", 200, seconds=400.0, joules=9000.0)


def scores_of(rows: Sequence[Row]) -> Scores:
    """Return the scores of an agent that expands 5 nodes in a delivery and 95 in a failure."""
    return Scores(rows, [5 if each.mode == "delivered" else 95 for each in rows])


def fleet_row(seed: int, mode: str = "served", **others: Any) -> FleetRow:
    """Return the row of an episode of a fleet that ended with ``mode``."""
    plain = FleetRow(
        seed, mode, 100, 100.0, 10, 5, 180.0, 4.0, 8.0, 0.5, 5000.0, 1000.0, 0, 10, 0, 3, 4, 90, 0
    )
    return plain._replace(**others)
