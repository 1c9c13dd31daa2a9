"""The entries for the Start-Kit of the League, with states of the shape that it shows them."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from helpers.league import league_crowd

from agents.mapf.epibt import EPIBT
from agents.mapf.graph import Graph
from agents.mapf.league import pyMAPFPlanner, pyTaskScheduler
from agents.mapf.league.executor import Executor
from agents.mapf.league.start_kit import view_of
from agents.mapf.league.tasks import TaskPool
from agents.mapf.league.usual import SHARE, make_usual_planner, usual_graph, usual_planner
from agents.mapf.planner import Situation
from agents.mapf.windows import WindowedPlanner
from agents.registry import make_planner
from warehouse_core import Layout
from warehouse_core.world.robot_runners import League
from warehouse_core.world.tables import Integers

EAST, TICKS, PERIOD = 1, 3, 10


class Numbers:
    """A ``VectorInt``: numbers by place and in turn, and not a list."""

    def __init__(self, numbers: Any) -> None:
        self._numbers = list(numbers)

    def __len__(self) -> int:
        return len(self._numbers)

    def __getitem__(self, place: int) -> int:
        return self._numbers[place]


class Tasks:
    """A ``TaskPool``: numbers in turn, and tasks by number."""

    def __init__(self, pool: TaskPool) -> None:
        self._tasks = {
            number: SimpleNamespace(
                task_id=number, t_completed=-1, t_revealed=task.revealed,
                agent_assigned=task.robot, locations=Numbers(task.cells),
                idx_next_loc=task.visited,
            )
            for number, task in pool.known.items()
        }  # fmt: skip

    def __iter__(self) -> Iterator[int]:
        return iter(self._tasks)

    def __getitem__(self, number: int) -> SimpleNamespace:
        return self._tasks[number]


class Action:
    """A value of ``MAPF.Action``, which is no number."""

    def __init__(self, number: int) -> None:
        self._number = number

    def __int__(self) -> int:
        return self._number


def states_of(cells: list[int], headings: list[int]) -> list[SimpleNamespace]:
    """Return states, whose orientation is 0 for east, 1 for south, 2 for west and 3 for north."""
    return [
        SimpleNamespace(location=cell, timestep=0, orientation=(heading - EAST) % 4)
        for cell, heading in zip(cells, headings, strict=True)
    ]


def env_of(problem: League, pool: TaskPool, executor: Executor, tick: int) -> SimpleNamespace:
    """Return what the Start-Kit 3.1.0 shows an entry."""
    layout = problem.layout
    return SimpleNamespace(
        num_of_agents=len(problem.starts),
        rows=layout.height,
        cols=layout.width,
        map=Numbers(int(tile == "#") for row in layout.rows for tile in row),
        curr_states=states_of(executor.ends, executor.end_headings),
        system_states=states_of(executor.cells, executor.headings),
        staged_actions=[[*map(Action, staged)] for staged in executor.staged],
        system_timestep=tick,
        curr_timestep=0,
        task_pool=Tasks(pool),
        curr_task_schedule=Numbers(pool.schedule.tolist()),
        min_planner_communication_time=1000,
        action_time=100,
        max_counter=TICKS,
    )


@pytest.fixture
def entry() -> tuple[pyTaskScheduler.pyTaskScheduler, pyMAPFPlanner.pyMAPFPlanner]:
    return pyTaskScheduler.pyTaskScheduler(), pyMAPFPlanner.pyMAPFPlanner()


def test_the_entries_finish_tasks_without_an_error(entry: Any) -> None:
    problem = league_crowd()
    pool, starts = TaskPool(problem), problem.layout.numbers(problem.starts)
    executor = Executor(Graph(problem.layout), starts, np.full(len(starts), EAST), TICKS)
    scheduler, planner = entry
    for each in entry:
        each.env = env_of(problem, pool, executor, 0)
        each.initialize(30_000)
    for tick in range(0, 300, PERIOD):
        env = scheduler.env = planner.env = env_of(problem, pool, executor, tick)
        schedule = scheduler.plan(1000)
        env.curr_task_schedule = Numbers(schedule)
        plan = planner.plan(40)
        assert {len(actions) for actions in plan} == {4}
        assert {type(action) for actions in plan for action in actions} == {int}
        held = pool.schedule.copy()
        for now in range(tick + 1, tick + PERIOD + 1):
            executor.tick(np.zeros(len(starts), np.bool_))
            pool.visit(np.array(executor.cells), now)
            pool.reveal(now)
        left = np.where((held != -1) & (pool.schedule == -1), -1, schedule)
        pool.propose(left, tick + PERIOD)
        executor.stage(np.array(plan))
    assert pool.finished > 16
    assert pool.errors == []


def test_a_plan_of_several_steps_has_the_time_limit_for_all_of_them(
    entry: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = league_crowd()
    starts = problem.layout.numbers(problem.starts)
    executor = Executor(Graph(problem.layout), starts, np.full(len(starts), EAST), TICKS)
    planner, seconds = entry[1], list[float]()
    planner.env = env_of(problem, TaskPool(problem), executor, 0)
    planner.initialize(30_000)

    def noted(self: WindowedPlanner, situation: Situation, headings: Integers) -> Integers:
        seconds.append(self.seconds)
        places: Integers = headings * self.graph.size + situation.cells
        return places

    monkeypatch.setattr(WindowedPlanner, "next_places", noted)
    for milliseconds in (3000, 1000, 1000):
        planner.plan(milliseconds)
    assert seconds == [SHARE * 3 / 4] * 4 + [SHARE / 4] * 8


def test_a_crowd_has_the_planner_that_the_command_names() -> None:
    layout = Layout([".....", ".###.", ".....", ".###.", "....."])
    name, floor, others = usual_planner(len(layout.open_cells), 2001, 1.0)
    planner = make_usual_planner(usual_graph(Graph(layout), 2001), 2001, 1.0)
    named = make_planner(f"{name}:wrong_way={floor['wrong_way']:g}", 0, layout, 2001)
    assert isinstance(planner, EPIBT)
    assert isinstance(named, EPIBT)
    assert planner.graph.costs is not None
    assert np.array_equal(planner.graph.costs, named.graph.costs)
    assert planner.tries == others["tries"]


def test_states_of_the_start_kit_are_seen_as_they_are() -> None:
    problem = league_crowd()
    pool, starts = TaskPool(problem), problem.layout.numbers(problem.starts)
    graph = Graph(problem.layout)
    executor = Executor(graph, starts, np.arange(len(starts)) % 4, TICKS)
    pool.propose(np.arange(len(starts)), 0)
    turns = np.tile([1, 3], (len(starts), 1))
    executor.stage(turns)
    view = view_of(env_of(problem, pool, executor, 7), graph)
    assert (view.step, view.cells.tolist()) == (7, executor.ends)
    assert view.headings.tolist() == executor.end_headings
    assert view.schedule.tolist() == pool.schedule.tolist()
    assert view.known == pool.known
    assert view.passed == executor.passed
