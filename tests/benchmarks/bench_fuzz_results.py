"""Damaged files of results: only documented errors, in a limited time and memory.

The number of files is ``FUZZ_ROUNDS`` of the environment, 2,000 if it is not set.
"""

import os
import random
import resource
import signal
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from time import perf_counter

from helpers.results_files import fleet_row, row

from agents.lab.commands.export.table import columns_of, lines_of
from agents.lab.experiments.case import is_fleet, make_case
from agents.lab.experiments.episodes import run_task
from agents.lab.experiments.store import Store
from agents.lab.reports.analysis.answers import answers
from agents.lab.reports.analysis.results import FLEETS, LONE, Experiment
from agents.lab.reports.examples import find_examples
from agents.lab.runs.programs import program_for
from warehouse_core.errors import WarehouseError

ROUNDS = int(os.environ.get("FUZZ_ROUNDS", "2000"))
MAX_SECONDS, MAX_MIB = 2.0, 256
MAX_CHANGES = 12
"""Bytes of a file that are changed."""

CASES = [make_case({"battery": battery}) for battery in (20, 60)]
CASES.append(make_case({"robots": 2, "max_steps": 30, "order_rate": 0.5}))
CASES.append(make_case({"layout": "random", "backend": "physics", "robot.mass": 70.0}))


def read(path: Path) -> None:
    """Read all that a report and an export read."""
    with Store(path, read_only=True) as store:
        find_examples(store)
        for kind in (LONE, FLEETS):
            answers(Experiment(store, kind))
        store.mixed(), store.episodes()
        for _ in lines_of(store, columns_of(store)):
            pass


def resume(path: Path) -> None:
    """Do what a sweep does that resumes."""
    with Store(path, mix=True) as store:
        store.add_cases(CASES)
        for case in CASES:
            number = store.case_id(case)
            store.count(case, range(100))
            store.seeds_done(number, range(100))
            rows = [fleet_row(99)] if is_fleet(case) else [row(99)]
            store.add(number, rows, "another")
        store.mixed()


def changed(data: bytes, stream: random.Random) -> bytes:
    """Return a file with a few other bytes, or without its end."""
    content = bytearray(data)
    for _ in range(stream.randint(1, MAX_CHANGES)):
        # Half of them in the header and the schema.
        end = len(content) if stream.random() < 0.5 else 4096
        content[stream.randrange(end)] = stream.choice((0, 1, 34, 127, 128, 255, *range(256)))
    if stream.random() < 0.05:
        del content[stream.randrange(len(content)) :]
    return bytes(content)


def test_damaged_files_are_read_or_refused_in_a_line(
    tmp_path: Path, measured: Callable[[str, object], None]
) -> None:
    path = tmp_path / "r.sqlite"
    with closing(Store(path)) as store:
        for case in CASES:
            rows = run_task(case, range(12)).rows
            store.add(store.case_id(case), rows, program_for(case["backend"]))
    data, stream = path.read_bytes(), random.Random(1)
    read(path)  # which imports libraries, so that these are not measured
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    ends, slowest = Counter[str](), 0.0
    for _ in range(ROUNDS):
        damaged = changed(data, stream)
        for use in (read, resume):
            for each in tmp_path.iterdir():
                each.unlink()
            path.write_bytes(damaged)
            begin = perf_counter()
            signal.alarm(60)  # ends the test
            try:
                use(path)
                ends[f"{use.__name__}: done"] += 1
            except WarehouseError as error:
                ends[f"{use.__name__}: {type(error).__name__}"] += 1
            finally:
                signal.alarm(0)
            slowest = max(slowest, perf_counter() - begin)
    mebibytes = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    found = ", ".join(f"{count:,} {end}" for end, count in ends.items())
    measured(
        f"{ROUNDS:,} damaged files of results",
        f"{found}; at most {slowest:.2f} s and {mebibytes:.0f} MiB more",
    )
    assert slowest <= MAX_SECONDS
    assert mebibytes <= MAX_MIB
