"""A sweep against a bare loop, two workers against one, and the memory of a long sweep."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import count
from pathlib import Path
from time import perf_counter

import pytest
from helpers.sweeps import nothing

from agents.lab.experiments.case import layout_for, make_agent_for, make_case, make_env
from agents.lab.experiments.plan import SweepPlan
from agents.lab.experiments.running import run_missing
from agents.lab.experiments.store import Store
from agents.lab.trials.workers import process_pool
from warehouse_core import record_episode
from warehouse_core.records.failure_modes import diagnose

CASE = make_case({})
EPISODES = 20_000
"""In a round: about ten seconds of one worker, so that the first and last tasks matter little."""

ROUNDS = 3
WARM_UP = 400

LONG_SWEEP = """
import sys
from agents.lab.experiments.plan import make_plan
from agents.lab.experiments.running import run_missing
from agents.lab.experiments.store import Store
from agents.lab.trials.workers import process_pool

def peak_in_kb():
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))

def report(rows, failures):
    global done
    done += len(rows)
    while done >= 20_000 * (len(peaks) + 1):
        peaks.append(peak_in_kb())

done, peaks = 0, []
if __name__ == "__main__":
    plan = make_plan({"battery": 20}, 100_000, 0)
    with Store(sys.argv[1]) as store, process_pool(2) as (executor, workers):
        run_missing(plan, store, executor, workers, report)
    print(*peaks)
"""


class Sweeper:
    """Sweeps with workers that have started and have run some episodes."""

    def __init__(self, workers: int, folder: Path, stack: ExitStack) -> None:
        begin = perf_counter()
        self._executor, self._workers = stack.enter_context(process_pool(workers))
        self._paths = (folder / f"{workers}-{number}.sqlite" for number in count())
        self.run(workers)
        self.seconds_to_start = perf_counter() - begin
        self.run(WARM_UP)

    def run(self, episodes: int = EPISODES) -> None:
        with Store(next(self._paths)) as store:
            plan = SweepPlan((CASE,), episodes, 0)
            run_missing(plan, store, self._executor, self._workers, nothing)


@pytest.fixture
def one_and_two(tmp_path: Path, capsys) -> Iterator[tuple[Sweeper, Sweeper]]:
    with ExitStack() as stack:
        pair = Sweeper(1, tmp_path, stack), Sweeper(2, tmp_path, stack)
        with capsys.disabled():
            seconds = " and ".join(f"{each.seconds_to_start:.2f} s" for each in pair)
            print(f"\nfrom the start to the first rows with one worker and two: {seconds}")
        yield pair


def bare_loop() -> None:
    """Run the same episodes as they would be run without workers or a file."""
    for seed in range(EPISODES):
        layout = layout_for(CASE, seed)
        agent = make_agent_for(CASE, seed, layout)
        diagnose(record_episode(make_env(CASE, layout), agent, seed=seed))


def test_two_workers_against_one(one_and_two, times_faster) -> None:
    """On two idle cores."""
    one, two = one_and_two
    assert times_faster(two.run, one.run, rounds=ROUNDS) >= 1.7


def test_one_worker_and_a_file_against_a_bare_loop(one_and_two, times_faster) -> None:
    one, _ = one_and_two
    assert times_faster(one.run, bare_loop, rounds=ROUNDS) >= 0.8


def test_memory_does_not_grow_over_a_hundred_thousand_episodes(tmp_path, capsys) -> None:
    """The peak of the process that stores them, every 20,000 episodes."""
    done = subprocess.run(
        [sys.executable, "-c", LONG_SWEEP, str(tmp_path / "r.sqlite")],
        capture_output=True,
        text=True,
        check=True,
    )
    peaks = [int(word) for word in done.stdout.split()]
    with capsys.disabled():
        print(f"\npeak after every 20,000 episodes: {peaks} kB")
    assert len(peaks) == 5
    # A list of what has been stored would need 100 bytes an episode at the least.
    assert peaks[-1] - peaks[0] < 80_000 * 100 // 1024
