"""Rows of sweeps that are killed, and of sweeps with several workers, programs and interpreters.

``WAREHOUSE_PYTHONS`` names the interpreters, separated as in ``PATH``; the package must be
installed for each with the extras ``physics`` and ``cluster``. Default: the running one.
"""

import hashlib
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from helpers.dask_cluster import dask_cluster
from helpers.sweeps import FLAGS, Sweep, kill_sweeps, table, uninterrupted

PYTHONS = os.environ.get("WAREHOUSE_PYTHONS", sys.executable).split(os.pathsep)
KILLED = {"lone robots": (100, 6_000, FLAGS), "fleets": (100, 1_500, [
    "robots=2,4", "planner=pibt", "order_rate=0.2", "max_steps=100", "battery=60",
])}  # fmt: skip
"""Kills, episodes of each case, and cases of sweeps that are killed."""

EARLY_SHARE = 0.5
"""Share of the episodes that are there before a sweep is killed, so that it is killed late too."""
ALL_FLAGS, EPISODES = [*FLAGS, "backend=grid,physics"], 100
SECONDS = 600
"""Of a sweep, at most."""

WAYS = ("1 worker", "2 workers", "two sweeps at once", "Dask with a kill")


def version_of(python: str) -> str:
    words = [python, "-c", "import platform; print(platform.python_version())"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


def compared(path: Path, expected: list) -> tuple[int, int, int]:
    """Return how many rows are lost, doubled and different."""
    found, wanted = table(path), dict(keyed(expected))
    counts = Counter(key for key, _ in keyed(found))
    differing = sum(wanted[key] != row for key, row in keyed(found))
    return len(wanted.keys() - counts.keys()), counts.total() - len(counts), differing


def keyed(rows: list) -> list:
    return [(row[:2], row) for row in rows]


@pytest.mark.parametrize("python", PYTHONS, ids=version_of)
@pytest.mark.parametrize("kind", KILLED)
def test_kill_9(tmp_path, measured, kind: str, python: str) -> None:
    kills, episodes, flags = KILLED[kind]
    path = tmp_path / "r.sqlite"
    assert Sweep(path, int(EARLY_SHARE * episodes), flags, python=python).end(SECONDS)[0] == 0
    begun = len(table(path))
    killed = kill_sweeps(path, episodes, kills, flags, python)
    left = len(table(path))
    assert Sweep(path, episodes, flags, python=python).end(SECONDS)[0] == 0
    expected = uninterrupted(tmp_path / "expected.sqlite", episodes, flags)
    lost, doubled, different = compared(path, expected)
    measured(
        f"a sweep of {kind} that is killed with -9, {kills} times, Python {version_of(python)}",
        f"{killed} of them while it ran, from {begun:,} to {left:,} of {len(expected):,} rows: "
        f"{lost} lost, {doubled} doubled, {different} different",
    )
    assert (lost, doubled, different) == (0, 0, 0)


def run(way: str, path: Path, python: str) -> None:
    if way == "Dask with a kill":
        with dask_cluster(path.parent, "--no-nanny", python=python) as (address, processes):
            sweep = Sweep(path, EPISODES, ALL_FLAGS, "--cluster", address, python=python)
            sweep.wait_for_rows()
            processes[-1].kill()
            assert sweep.end(SECONDS)[0] == 0
        return
    count = 2 if way == "two sweeps at once" else 1
    workers = 2 if way == "2 workers" else 1
    sweeps = [
        Sweep(path, EPISODES, ALL_FLAGS, workers=workers, python=python) for _ in range(count)
    ]
    assert [sweep.end(SECONDS)[0] for sweep in sweeps] == [0] * count


@pytest.mark.parametrize("python", PYTHONS, ids=version_of)
def test_rows_of_workers_programs_and_interpreters(tmp_path, measured, python: str) -> None:
    """All have to be those of one process of the running interpreter."""
    expected = uninterrupted(tmp_path / "expected.sqlite", EPISODES, ALL_FLAGS)
    for number, way in enumerate(WAYS):
        folder = tmp_path / str(number)
        folder.mkdir()
        run(way, folder / "r.sqlite", python)
        found = compared(folder / "r.sqlite", expected)
        digest = hashlib.sha256(repr(table(folder / "r.sqlite")).encode()).hexdigest()[:12]
        lost, doubled, different = found
        measured(
            f"rows of a sweep, Python {version_of(python)}, {way}",
            f"{len(expected):,}: {lost} lost, {doubled} doubled, {different} different, digest "
            f"{digest}",
        )
        assert found == (0, 0, 0)
