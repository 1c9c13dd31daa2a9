"""Running missing episodes gives the same rows with any executor and in any order."""

import re
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from helpers.sweeps import AGENT, Here, nothing, table

from agents.errors import EpisodeError, StoreError
from agents.experiments.episodes import run_task
from agents.experiments.plan import Plan, make_plan
from agents.experiments.running import MAX_TASK_EPISODES, TASK_SECONDS, Pace, run_missing
from agents.experiments.store import Row, Store
from agents.experiments.workers import process_pool
from agents.programs import program_for

GLOBAL_STREAMS = """
import random

import numpy as np


class Own:
    def reset(self):
        self.turn = random.random()

    def act(self, observation):
        return random.choice("NESW") if self.turn < 0.5 else "NESW"[np.random.randint(4)]
"""

PLAN = make_plan({"escape": [True, False], "battery": [20, 60], "layout": "random"}, 12, 5)


class LastFirst(Here):
    """Runs the task that was submitted last before all others."""

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


def run(path: Path, executor: Executor, plan: Plan = PLAN, workers: int = 2) -> list[Any]:
    with Store(path) as store:
        run_missing(plan, store, executor, workers, nothing)
    return table(path)


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> list[Any]:
    return run(tmp_path_factory.mktemp("here") / "r.sqlite", Here())


def test_the_table_has_the_rows_of_the_episodes(expected: list[Any]) -> None:
    rows = [row for case in PLAN.cases for row in run_task(case, PLAN.seeds).rows]
    assert sorted(found[1:] for found in expected) == sorted(map(tuple, rows))
    assert len(expected) == PLAN.total == 48
    assert len({found[1:] for found in expected}) > 20


def test_processes_give_the_same_rows(tmp_path: Path, expected: list[Any]) -> None:
    with process_pool(2) as (executor, workers):
        assert workers == 2
        assert run(tmp_path / "r.sqlite", executor, workers=workers) == expected


def test_threads_give_the_same_rows(tmp_path: Path, expected: list[Any]) -> None:
    with ThreadPoolExecutor(3) as executor:
        assert run(tmp_path / "r.sqlite", executor, workers=3) == expected


def test_the_order_does_not_matter(tmp_path: Path, expected: list[Any]) -> None:
    assert run(tmp_path / "r.sqlite", LastFirst()) == expected
    backwards = Plan(PLAN.cases[::-1], PLAN.episodes, PLAN.seed)
    assert run(tmp_path / "backwards.sqlite", Here(), backwards) == expected


def test_stored_episodes_are_not_run_again(tmp_path: Path, expected: list[Any]) -> None:
    path = tmp_path / "r.sqlite"
    run(path, Here())
    again = Here()
    assert run(path, again) == expected
    assert again.seeds == []


def test_more_episodes_run_only_the_new_seeds(tmp_path: Path) -> None:
    path, more = tmp_path / "r.sqlite", Here()
    before = run(path, Here(), make_plan({}, 3, 10))
    after = run(path, more, make_plan({}, 6, 8))
    assert more.seeds == [8, 9, 13]
    assert [found[1] for found in after] == [8, 9, 10, 11, 12, 13]
    assert set(before) < set(after)


def test_further_values_run_only_the_new_cases(tmp_path: Path) -> None:
    path, more = tmp_path / "r.sqlite", Here()
    run(path, Here(), make_plan({"battery": [20]}, 3, 0))
    after = run(path, more, make_plan({"battery": [20, 30]}, 3, 0))
    assert len(more.seeds) == 3
    assert len(after) == 6


def test_after_a_worker_fails_finished_rows_are_kept_and_the_rest_can_be_run(
    tmp_path: Path, expected: list[Any]
) -> None:
    path = tmp_path / "r.sqlite"
    with pytest.raises(ArithmeticError, match="a worker failed"):
        run(path, Here(fails_at=PLAN.seeds[-2]), workers=1)
    left = table(path)
    assert 0 < len(left) < len(expected)
    assert set(left) < set(expected)
    rest = Here()
    assert run(path, rest) == expected
    assert len(rest.seeds) == len(expected) - len(left)


def test_rows_of_an_agent_that_draws_from_global_streams_depend_on_the_seed_alone(
    tmp_path: Path,
) -> None:
    file = tmp_path / "agent.py"
    file.write_text(GLOBAL_STREAMS)
    [case] = make_plan({"agent": f"{file}:Own", "max_steps": 30}, 1, 0).cases
    together = run_task(case, range(6)).rows
    assert [run_task(case, [seed]).rows[0] for seed in (5, 3, 0)] == [
        together[n] for n in (5, 3, 0)
    ]
    assert len({row.reward for row in together}) > 3


def plan_of(folder: Path, begin: str = "pass", act: str = "pass") -> Plan:
    """Return a plan of ten episodes for two agents; with seed 7 the second runs this code."""
    file = folder / "agent.py"
    begin, act = f"if seed == 7: {begin}", f"if self.seed == 7: {act}"
    file.write_text(AGENT.format(name="Own", begin=begin, act=act))
    return make_plan({"agent": ["greedy", f"{file}:Own"], "max_steps": 5}, 10, 0)


@pytest.mark.parametrize(
    ("begin", "act", "reason"),
    [
        ("pass", "raise KeyError('lost')", r"KeyError: 'lost' \(agent.py, line 11\)"),
        ("raise ValueError('no')", "pass", r"agent '.*' cannot be made: ValueError: no \(.*4\)"),
        ("pass", "raise SystemExit(0)", r"SystemExit: 0 \(agent.py, line 11\)"),
        ("pass", "raise KeyboardInterrupt", r"KeyboardInterrupt \(agent.py, line 11\)"),
        ("pass", "return None", r"TypeError: action None .*"),
    ],
    ids=["acting", "being made", "an exit", "an interrupt", "an invalid action"],
)  # fmt: skip
def test_an_agent_that_fails_is_reported_with_its_case_and_seed_and_other_rows_are_kept(
    tmp_path: Path, begin: str, act: str, reason: str
) -> None:
    path, plan = tmp_path / "r.sqlite", plan_of(tmp_path, begin, act)
    with pytest.raises(EpisodeError) as caught:
        run(path, Here(), plan, workers=1)
    about = re.escape(f"seed 7 with agent={tmp_path}/agent.py:Own, max_steps=5: ")
    assert re.fullmatch(about + reason, str(caught.value))
    with Store(path, read_only=True) as store:
        assert [store.count(case, plan.seeds) for case in plan.cases] == [10, 7]


def test_an_error_that_cannot_be_pickled_is_reported_too(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, act="raise type('Odd', (Exception,), {})(lambda: 1)")
    with process_pool(1) as (executor, _), pytest.raises(EpisodeError, match="Odd: <function "):
        run(tmp_path / "r.sqlite", executor, plan, 1)


@pytest.mark.parametrize("is_changed", [True, False])
def test_an_agent_whose_file_is_changed_or_removed_during_a_sweep_is_an_error(
    tmp_path: Path, is_changed: bool
) -> None:
    path, plan = tmp_path / "r.sqlite", plan_of(tmp_path)
    file = tmp_path / "agent.py"
    if is_changed:
        file.write_text(file.read_text() + "# changed\n")
    else:
        file.unlink()
    why = "has changed since the sweep began" if is_changed else "No such file"
    with pytest.raises(EpisodeError, match=why):
        run(path, Here(), plan)
    with Store(path, read_only=True) as store:
        assert store.count(plan.cases[1], plan.seeds) == 0


def test_an_agent_whose_import_is_changed_during_a_sweep_is_an_error(tmp_path: Path) -> None:
    file, helper = tmp_path / "agent.py", tmp_path / "helper.py"
    helper.write_text("WORD = 'N'\n")
    file.write_text("from helper import WORD\n" + GLOBAL_STREAMS)
    plan = make_plan({"agent": f"{file}:Own"}, 3, 0)
    run(tmp_path / "r.sqlite", Here(), plan)
    helper.write_text("WORD = 'S'\n")
    more = Plan(plan.cases, 5, 0)
    with pytest.raises(EpisodeError, match="or what it imports, has changed since the sweep"):
        run(tmp_path / "r.sqlite", Here(), more)
    assert make_plan({"agent": f"{file}:Own"}, 3, 0).cases != plan.cases


def test_a_worker_of_another_program_is_an_error_and_its_rows_are_not_stored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "r.sqlite"
    before = run(path, Here(), make_plan({}, 3, 0))
    # Only what runs the episodes is another program, not what stores them.
    monkeypatch.setattr("agents.experiments.episodes.program_for", lambda backend: f"new {backend}")
    with pytest.raises(StoreError, match="new ones would be of new grid; "):
        run(path, Here(), make_plan({}, 5, 0))
    assert table(path) == before
    with Store(path, read_only=True) as store:
        assert store.programs(1) == [program_for("grid")]


def test_rows_finished_at_the_same_time_as_a_failure_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "r.sqlite"
    with pytest.raises(ArithmeticError):
        run(path, Here(fails_at=5), make_plan({}, 20, 5), workers=10)
    assert [found[1] for found in table(path)] == list(range(6, 25))


def test_rows_are_reported_once_after_they_are_stored(tmp_path: Path) -> None:
    reported: list[int] = []
    plan = make_plan({}, 20, 0)
    with Store(tmp_path / "r.sqlite") as store, ThreadPoolExecutor(2) as executor:

        def report(rows: Sequence[Row]) -> None:
            reported.extend(row.seed for row in rows)
            assert store.count(plan.cases[0], plan.seeds) == len(reported)

        run_missing(plan, store, executor, 2, report)
    assert sorted(reported) == list(range(20))


def test_an_error_of_the_store_ends_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(store: Store, case_id: int, rows: Sequence[Row], program: str) -> None:
        raise StoreError("full")

    monkeypatch.setattr(Store, "add", full)
    with ThreadPoolExecutor(1) as executor, pytest.raises(StoreError, match="full"):
        run(tmp_path / "r.sqlite", executor, make_plan({}, 10**6, 0))


def test_processes_end_without_warnings_while_tasks_are_waiting(tmp_path: Path) -> None:
    stored = set[int]()

    def report(rows: Sequence[Row]) -> None:
        stored.update(row.seed for row in rows)
        if 6 in stored and not rows:
            raise KeyboardInterrupt

    # An error in a thread of the pool would be a warning, and that fails the test.
    sleeper = plan_of(tmp_path, act="__import__('time').sleep(60)").cases[1]
    plan = Plan((sleeper,), 20, 0)
    with Store(tmp_path / "r.sqlite") as store, pytest.raises(KeyboardInterrupt):  # noqa: SIM117
        with process_pool(1) as (executor, _):
            run_missing(plan, store, executor, 20, report)


def test_the_pace_grows_gradually_to_tasks_of_about_half_a_second() -> None:
    pace = Pace()
    assert pace.episodes == 1
    sizes = []
    for _ in range(12):
        pace.learn(pace.episodes, pace.episodes * 0.001)
        sizes.append(pace.episodes)
    assert sizes[:4] == [4, 16, 64, 256]
    assert sizes[-1] == TASK_SECONDS / 0.001
    pace.learn(500, 50)
    assert pace.episodes == 5
    pace.learn(5, 500)
    assert pace.episodes == 1
    for _ in range(30):
        pace.learn(pace.episodes, 0)
    assert pace.episodes == MAX_TASK_EPISODES
