"""Running missing episodes gives the same rows with any executor and in any order."""

import pickle
import re
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from helpers.sweeps import AGENT, Here, run_missing, table

from agents.errors import WorkerError
from agents.lab.experiments.case import run_task
from agents.lab.experiments.plan import SweepPlan, make_plan
from agents.lab.experiments.store import Store
from agents.lab.experiments.sweep import (
    MAX_FAILURES,
    MAX_TASK_EPISODES,
    TASK_SECONDS,
    paced,
)
from agents.lab.trials.rows import Row
from agents.lab.trials.workers import Processes

PATH = Path("r.sqlite")
PLAN = make_plan({"escape": [True, False], "battery": [20, 60], "layout": "random"}, 12, 5)


class LastFirst(Here):
    """An executor that runs the newest task first."""

    def __init__(self) -> None:
        super().__init__()
        self.waiting: list[tuple[Future[Any], Callable[[], Any]]] = []

    def submit(self, call: Callable[..., Any], /, *args: Any, **named: Any) -> Future[Any]:
        future = Future[Any]()
        self.waiting.append((future, lambda: call(*args)))
        if len(self.waiting) == 4 or args[1][-1] == PLAN.seeds[-1]:
            while self.waiting:
                answered, run = self.waiting.pop()
                answered.set_result(run())
        return future


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
        return [store.seeds_done(store.case_id(case), plan.seeds) for case in plan.cases]


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> list[Any]:
    return run(Here(), path=tmp_path_factory.mktemp("here") / "r.sqlite")


def test_the_table_has_the_rows_of_the_episodes(expected: list[Any]) -> None:
    rows = [row for case in PLAN.cases for row in run_task(case, PLAN.seeds).rows]
    assert sorted(found[1:] for found in expected) == sorted(map(tuple, rows))
    assert len(expected) == PLAN.total == 48
    assert len({found[1:] for found in expected}) > 20


def test_processes_threads_and_any_order_give_the_same_rows(expected: list[Any]) -> None:
    with Processes(2) as processes, ThreadPoolExecutor(3) as threads:
        for number, executor in enumerate((processes, threads, LastFirst())):
            assert run(executor, path=Path(f"{number}.sqlite")) == expected
    backwards = SweepPlan(PLAN.cases[::-1], PLAN.episodes, PLAN.seed)
    assert run(Here(), backwards, path=Path("backwards.sqlite")) == expected


def test_only_new_seeds_and_new_cases_are_run() -> None:
    seeds, cases, again = Here(), Here(), Here()
    before = run(Here(), make_plan({"battery": [20]}, 3, 10))
    after = run(seeds, make_plan({"battery": [20]}, 6, 8))
    assert seeds.seeds == [8, 9, 13]
    assert [found[1] for found in after] == [8, 9, 10, 11, 12, 13]
    assert set(before) < set(after)
    more = run(cases, make_plan({"battery": [20, 30]}, 6, 8))
    assert cases.seeds == [8, 9, 10, 11, 12, 13]
    assert len(more) == 12
    assert run(again, make_plan({"battery": [20, 30]}, 6, 8)) == more
    assert again.seeds == []


def plan_of(begin: str = "pass", act: str = "pass") -> SweepPlan:
    """Return a plan of ten episodes for two agents; with seed 7 the second runs this code."""
    file = Path("agent.py")
    begin, act = f"if seed == 7: {begin}", f"if self.seed == 7: {act}"
    file.write_text(AGENT.format(name="Own", begin=begin, act=act))
    return make_plan({"agent": ["greedy", f"{file}:Own"], "max_steps": 5}, 10, 0)


@pytest.mark.parametrize(
    ("begin", "act", "reason"),
    [
        ("pass", "raise KeyError('lost')", r".*: KeyError: 'lost' \(agent.py, line 11\)"),
        ("raise ValueError('no')", "pass", r" with .*: agent '.*' cannot be made: .*: no \(.*4\)"),
        ("pass", "raise SystemExit(0)", r", step 1, with .*: SystemExit: 0 \(agent.py, line 11\)"),
        ("pass", "return None", r".*: TypeError: action None .*"),
        ("self.reset = None", "pass", r", reset, with .*: TypeError: 'NoneType' .*"),
    ],
    ids=["acting", "being made", "an exit", "an invalid action", "a reset"],
)  # fmt: skip
def test_a_failing_agent_is_reported_with_case_seed_and_step_and_the_others_continue(
    begin: str, act: str, reason: str
) -> None:
    plan = plan_of(begin, act)
    [message] = failures_of(Here(), plan)
    assert re.fullmatch(f"seed 7{reason}", message)
    assert " with agent=agent.py:Own, max_steps=5: " in message
    assert seeds_done(plan) == [set(range(10)), set(range(10)) - {7}]


def test_an_error_that_cannot_be_pickled_is_reported_too() -> None:
    plan = plan_of(act="raise type('Odd', (Exception,), {})(lambda: 1)")
    done = pickle.loads(pickle.dumps(run_task(plan.cases[1], [7])))
    assert "Odd: <function " in done.failure


def test_a_slow_episode_is_reported_once_with_its_place(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("agents.lab.experiments.case.SLOW_SECONDS", 0.2)
    monkeypatch.setattr("agents.lab.console.watch.LOOK_SECONDS", 0.01)
    plan = plan_of(act="__import__('time').sleep(0.5)")
    run(Here(), plan)
    said = re.sub(r"[\d.]+ s ", "some s ", capsys.readouterr().err)  # a busy machine looks later
    assert said == (
        "warehouse: seed 7, step 1, with agent=agent.py:Own, max_steps=5 has run for "
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
        f"seed {seed} with the defaults: it ended; it was tried twice" for seed in (41, 7)
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


def test_rows_are_reported_once_after_they_are_stored() -> None:
    reported: list[int] = []
    plan = make_plan({}, 20, 0)
    with Store(PATH) as store, ThreadPoolExecutor(2) as executor:

        def report(rows: Sequence[Row], failure: str) -> None:
            reported.extend(row.seed for row in rows)
            assert store.count(plan.cases[0], plan.seeds) == len(reported)

        run_missing(plan, store, executor, 2, report)
    assert sorted(reported) == list(range(20))


def test_processes_end_without_warnings_while_tasks_are_waiting() -> None:
    stored = set[int]()

    def report(rows: Sequence[Row], failure: str) -> None:
        stored.update(row.seed for row in rows)
        if 6 in stored and not rows:
            raise KeyboardInterrupt

    # An error in a thread of the pool would be a warning, and that fails the test.
    sleeper = plan_of(act="__import__('time').sleep(60)").cases[1]
    plan = SweepPlan((sleeper,), 20, 0)
    with Store(PATH) as store, pytest.raises(KeyboardInterrupt):  # noqa: SIM117
        with Processes(1) as executor:
            run_missing(plan, store, executor, 20, report)


def test_the_pace_grows_gradually_to_tasks_of_about_half_a_second() -> None:
    sizes = [1]
    for _ in range(12):
        sizes.append(paced(sizes[-1], sizes[-1] * 0.001))
    assert sizes[:5] == [1, 4, 16, 64, 256]
    assert sizes[-1] == TASK_SECONDS / 0.001
    assert (paced(500, 50), paced(5, 500), paced(9_999, 0)) == (5, 1, MAX_TASK_EPISODES)
    executor = Dying()
    run(executor, make_plan({"max_steps": 1}, 600, 0), workers=1)
    assert list(map(len, executor.tasks[:2])) == [1, 1], "submitted before any is done"
    assert max(map(len, executor.tasks[2:])) > 4
