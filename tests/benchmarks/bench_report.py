"""A report on a million episodes: how long it takes, and how much memory."""

import resource
import subprocess
import sys
from pathlib import Path
from time import perf_counter

import numpy as np

from agents.lab.experiments.case import make_case
from agents.lab.experiments.store import Store
from agents.lab.trials.rows import Row
from warehouse_core.records.failure_modes import MODES

EPISODES, BATTERIES = 1_000_000, range(20, 220, 20)


def a_million(path: Path) -> None:
    """Write episodes of physics, so that time and energy are to be reported too."""
    stream = np.random.default_rng(0)
    settings = [
        {"battery": battery, "escape": escape, "backend": "physics"}
        for battery in BATTERIES
        for escape in (True, False)
    ]
    count = EPISODES // len(settings)
    with Store(path) as store:
        for each in settings:
            modes = stream.choice(MODES[:5], count).tolist()
            steps = stream.integers(8, 200, count).tolist()
            seconds = stream.normal(60, 20, count).tolist()
            cells = stream.integers(1, 6, count).tolist()
            rows = zip(range(count), modes, steps, seconds, cells, strict=True)
            store.add(
                store.case_id(make_case(each)),
                [Row(n, m, k, 9, 1.0, 3, s, 40 * s, cell, cell) for n, m, k, s, cell in rows],
            )


def test_a_million_episodes_take_less_than_a_minute_and_a_gibibyte(tmp_path, capsys) -> None:
    """The examples of the modes are left out: these episodes have never been run."""
    path = tmp_path / "r.sqlite"
    a_million(path)
    begin = perf_counter()
    subprocess.run(
        [sys.executable, "-m", "agents", "report", str(path),
         "--no-replays"],
        check=True,
        stdout=subprocess.DEVNULL,
    )  # fmt: skip
    seconds = perf_counter() - begin
    gibibytes = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 2**20
    with capsys.disabled():
        print(f"\nreport on {EPISODES:,} episodes: {seconds:.1f} s, {gibibytes:.2f} GiB")
    assert seconds < 60
    assert gibibytes < 1
