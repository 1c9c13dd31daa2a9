"""The command ``warehouse sweep``, which keeps finished episodes and resumes."""

import os
import pickle
import re
import signal
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import nullcontext, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from helpers.command_line import Warehouse
from helpers.sweeps import (
    AGENT,
    Here,
    Sweep,
    check_is_usable,
    kill_sweeps,
    run_missing,
    table,
    uninterrupted,
    words,
)

from agents.errors import WorkerError
from agents.lab.experiments import sweep as sweep_command
from agents.lab.experiments.case import run_task
from agents.lab.experiments.plan import SweepPlan, make_plan
from agents.lab.experiments.store import Store
from agents.lab.experiments.sweep import MAX_FAILURES, MAX_TASK_EPISODES, TASK_SECONDS, paced
from agents.lab.parameters import PARAMETERS
from agents.lab.trials.rows import Row
from agents.lab.trials.workers import Processes
from warehouse_core.batch.fleet_settings import MAX_BODIES
from warehouse_core.world.generators import MAX_DENSITY


@pytest.fixture
def path(tmp_path: Path) -> Iterator[Path]:
    yield tmp_path / "r.sqlite"
    # After the file has been closed, no other files are left.
    assert {each.name for each in tmp_path.iterdir()} <= {"r.sqlite", "expected.sqlite"}


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run the episodes of commands in this process, with the function that workers use."""
    monkeypatch.setattr(sweep_command, "Processes", lambda count: nullcontext(Here()))


@pytest.fixture(autouse=True)
def no_sweep_is_left() -> Iterator[None]:
    """Kill the sweeps of a test that has failed."""
    yield
    while Sweep.started:
        process = Sweep.started.pop().process
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


def test_a_sweep_counts_stored_episodes_and_adds_missing_ones(
    warehouse: Warehouse, path: Path, tmp_path: Path, here: None
) -> None:
    assert warehouse(*words(path, 3)) == (
        0,
        f"4 combinations, 3 episodes each, 0 done\n"
        f"12 episodes done; see the results with: warehouse report {path}\n",
        "",
    )
    before = path.read_bytes()
    assert "12 done\n" in warehouse(*words(path, 3)).out
    assert path.read_bytes() == before
    assert "5 episodes each, 12 done\n20 episodes" in warehouse(*words(path, 5)).out
    assert table(path) == uninterrupted(tmp_path / "expected.sqlite", 5)


def test_flags_and_options_override_the_plan_file(
    warehouse: Warehouse, tmp_path: Path, here: None
) -> None:
    plan, path = tmp_path / "plan.toml", tmp_path / "r.sqlite"
    plan.write_text("episodes = 50\nseed = 7\n[settings]\nbattery = [20, 30]\nmemory = [1, 2]\n")
    warehouse("sweep", plan, "-n", 2, "--set", "battery=40", "-o", path, "--jobs", 1)
    with Store(path, read_only=True) as store:
        cases = [(case["battery"], case["memory"]) for case in store.cases().values()]
        assert sorted(cases) == [(40, 1), (40, 2)]
        assert {seed for (seed,) in store.query("SELECT seed FROM episodes")} == {7, 8}


def test_a_killed_sweep_loses_and_repeats_no_rows(path: Path, tmp_path: Path) -> None:
    """``bench_sweep.py`` kills sweeps of lone robots and of fleets 100 times each."""
    episodes = 150
    assert kill_sweeps(path, episodes, 1) == 1
    before = table(path)
    assert before
    sweep = Sweep(path, episodes)
    code, out, err = sweep.end()
    assert (code, err) == (0, "")
    assert f" {len(before):,} done\n" in out
    assert table(path) == uninterrupted(tmp_path / "expected.sqlite", episodes)


def test_an_interrupted_sweep_prints_one_line_and_can_be_resumed(path: Path) -> None:
    sweep = Sweep(path, 100_000)
    sweep.wait_for_rows()
    for _ in range(20):
        with suppress(ProcessLookupError):
            os.killpg(sweep.process.pid, signal.SIGINT)  # as a terminal does
        time.sleep(0.005)
    code, out, err = sweep.end()
    assert (code, err) == (130, "warehouse: interrupted\n")
    check_is_usable(path)
    left = f"{path} now has {len(table(path)):,} of 400,000 episodes"
    assert f"\n{left}; run the same command again to resume\n" in out


DEADLY = """
        if self.seed == 13:
            os.kill(os.getpid(), 9)  # as a system that runs out of memory does
        if self.seed == 15:
            raise KeyError"""


def test_agents_that_fail_or_end_their_process_are_named_and_the_others_continue(
    warehouse: Warehouse, path: Path
) -> None:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "deadly.py"
        file.write_text("import os\n" + AGENT.format(name="Deadly", begin="pass", act=DEADLY))
        choice = ["--set", f"agent={file}:Deadly,greedy", "--set", "max_steps=5", "-o", path]
        result = warehouse("sweep", *choice, "-n", 20, "--jobs", 2)
    assert result.code == 1
    flags = f"with agent={file}:Deadly, max_steps=5"
    *failures, last = result.err.splitlines()
    assert sorted(failures) == [
        f"warehouse: seed 13 {flags}: its process was ended by signal 9 (Killed), "
        "perhaps because memory ran out, twice",
        f"warehouse: seed 15 {flags}: step 1, agent {file}:Deadly: KeyError (deadly.py, line 16)",
    ]
    assert last == (
        f"warehouse: 2 episodes failed (in 1 of 2 combinations); {path} now has 38 of 40 episodes; "
        "run the same command again to run the missing ones"
    )
    assert "done; see" not in result.out
    check_is_usable(path)
    assert len(table(path)) == 38


def test_the_help_names_every_parameter(warehouse: Warehouse) -> None:
    lines = [line.split() for line in warehouse("sweep", "--help").out.splitlines()]
    shown = {words[0]: " ".join(words[1:]) for words in lines if len(words) > 1}
    assert PARAMETERS.keys() <= shown.keys()
    assert shown["density"] == f"0..{MAX_DENSITY:g}, for layout random"
    assert (shown["people"], shown["battery"]) == (f"0..{MAX_BODIES}, for fleets", "1..1000000000")
    assert shown["robot.NAME"] == "and disturbances.NAME, for physics"


# The run of missing episodes.

PATH = Path("r.sqlite")
PLAN = make_plan({"escape": [True, False], "battery": [20, 60], "layout": "random"}, 12, 5)


def run(
    executor: Executor, plan: SweepPlan = PLAN, workers: int = 2, path: Path = PATH
) -> list[Any]:
    with Store(path) as store:
        run_missing(plan, store, executor, workers)
    return table(path)


def failures_of(executor: Executor, plan: SweepPlan, workers: int = 1) -> list[str]:
    """Run a plan and return the messages of failures."""
    messages: list[str] = []

    def report(rows: Sequence[Row], failure: str) -> None:
        messages.extend([failure] if failure else [])

    with Store(PATH) as store:
        failed = run_missing(plan, store, executor, workers, report)
    assert failed.total() == len(messages)
    return messages


def seeds_done(plan: SweepPlan) -> list[set[int]]:
    """Return the stored seeds of each case of a plan."""
    with Store(PATH) as store:
        return [store.seeds_done(each, plan.seeds) for each in store.case_ids(plan.cases)]


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> list[Any]:
    return run(Here(), path=tmp_path_factory.mktemp("here") / "r.sqlite")


def test_the_table_has_the_rows_of_the_episodes(expected: list[Any]) -> None:
    rows = [row for case in PLAN.cases for row in run_task(case, PLAN.seeds).rows]
    assert sorted(found[1 : 1 + len(Row._fields)] for found in expected) == sorted(map(tuple, rows))
    assert len(expected) == PLAN.total == 48
    assert len({found[1:] for found in expected}) > 20


def test_processes_and_any_order_of_cases_give_the_same_rows(expected: list[Any]) -> None:
    with Processes(2) as processes:
        assert run(processes, path=Path("p.sqlite")) == expected
    backwards = SweepPlan(PLAN.cases[::-1], PLAN.episodes, PLAN.seed)
    assert run(Here(), backwards, path=Path("backwards.sqlite")) == expected


def test_only_new_seeds_and_new_cases_are_run() -> None:
    seeds, cases = Here(), Here()
    before = run(Here(), make_plan({"battery": [20]}, 3, 10))
    after = run(seeds, make_plan({"battery": [20]}, 6, 8))
    assert seeds.seeds == [8, 9, 13]
    assert set(before) < set(after)
    more = run(cases, make_plan({"battery": [20, 30]}, 6, 8))
    assert cases.seeds == [8, 9, 10, 11, 12, 13]
    assert len(more) == 12


def plan_of(begin: str = "pass", act: str = "pass") -> SweepPlan:
    """Return a plan of ten episodes for two agents; with seed 7 the second runs this code."""
    file = Path("agent.py")
    begin, act = f"if seed == 7: {begin}", f"if self.seed == 7: {act}"
    file.write_text(AGENT.format(name="Own", begin=begin, act=act))
    return make_plan({"agent": ["greedy", f"{file}:Own"], "max_steps": 5}, 10, 0)


@pytest.mark.parametrize(
    ("begin", "act", "reason"),
    [
        ("pass", "raise KeyError('lost')", r"step 1, .*: KeyError: 'lost' \(agent.py, line 11\)"),
        ("raise ValueError('no')", "pass", r"agent '.*' cannot be made: .*: no \(.*4\)"),
    ],
    ids=["acting", "being made"],
)  # fmt: skip
def test_a_failing_agent_is_reported_with_case_seed_and_step_and_the_others_continue(
    begin: str, act: str, reason: str
) -> None:
    plan = plan_of(begin, act)
    [message] = failures_of(Here(), plan)
    assert re.fullmatch(f"seed 7 with agent=agent.py:Own, max_steps=5: {reason}", message)
    assert seeds_done(plan) == [set(range(10)), set(range(10)) - {7}]


def test_an_error_that_cannot_be_pickled_is_reported_too() -> None:
    plan = plan_of(act="raise type('Odd', (Exception,), {})(lambda: 1)")
    done = pickle.loads(pickle.dumps(run_task(plan.cases[1], [7])))
    assert "Odd: <function " in done.failure


def test_a_slow_episode_is_reported_once_with_the_line_of_the_agent(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("agents.lab.experiments.case.SLOW_SECONDS", 0.2)
    monkeypatch.setattr("agents.lab.console.watch.LOOK_SECONDS", 0.01)
    plan = plan_of(act="__import__('time').sleep(0.5)")
    run(Here(), plan)
    said = re.sub(r"[\d.]+ s ", "some s ", capsys.readouterr().err)  # a busy machine looks later
    assert said == (
        "warehouse: seed 7 with agent=agent.py:Own, max_steps=5 has run for "
        "some s (agent.py, line 11)\n"
    )


class Dying(Here):
    """An executor whose workers end in some calls, counted from 0, or with some seeds."""

    def __init__(self, calls: Collection[int] = (), seeds: Collection[int] = ()) -> None:
        super().__init__()
        self.calls, self.deadly = calls, seeds
        self.tasks: list[list[int]] = []

    def submit(self, call: Callable[..., Any], /, *args: Any, **named: Any) -> Future[Any]:
        self.tasks.append(args[1])
        if len(self.tasks) - 1 not in self.calls and not set(args[1]) & set(self.deadly):
            return super().submit(call, *args, **named)
        future = Future[Any]()
        future.set_exception(WorkerError("it ended"))
        return future


def test_a_worker_that_ends_once_loses_nothing_and_is_not_a_failure(expected: list[Any]) -> None:
    assert failures_of(Dying(calls=(0, 3)), PLAN) == []
    assert table(PATH) == expected


def test_a_seed_whose_worker_ends_twice_has_failed_and_the_others_continue() -> None:
    plan, executor = make_plan({}, 60, 0), Dying(seeds=(7, 41))
    messages = failures_of(executor, plan)
    assert sorted(messages) == [
        f"seed {seed} with the defaults: it ended, twice" for seed in (41, 7)
    ]
    assert seeds_done(plan) == [set(range(60)) - {7, 41}]
    assert [len(task) for task in executor.tasks if 7 in task][-1] == 1


def test_a_case_that_always_fails_ends_after_a_few_and_the_others_continue() -> None:
    file = Path("agent.py")
    file.write_text(AGENT.format(name="Own", begin="pass", act="raise KeyError"))
    plan = make_plan({"agent": [f"{file}:Own", "greedy"], "max_steps": 5}, 1000, 0)
    messages = failures_of(Here(), plan)
    assert len(messages) == MAX_FAILURES
    assert messages[-1].endswith(
        f"; its other seeds are skipped after MAX_FAILURES = {MAX_FAILURES}"
    )
    assert [len(done) for done in seeds_done(plan)] == [0, 1000]


def test_the_pace_grows_gradually_to_tasks_of_about_half_a_second() -> None:
    sizes = [1]
    for _ in range(12):
        sizes.append(paced(sizes[-1], sizes[-1] * 0.001))
    assert sizes[:5] == [1, 4, 16, 64, 256]
    assert sizes[-1] == TASK_SECONDS / 0.001
    assert (paced(500, 50), paced(5, 500), paced(9_999, 0)) == (5, 1, MAX_TASK_EPISODES)
    executor = Dying()
    run(executor, make_plan({"max_steps": 1}, 600, 0), workers=1)
    assert max(map(len, executor.tasks[2:])) > 4
