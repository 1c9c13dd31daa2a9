"""The scheduler of the League."""

import numpy as np
import pytest

from agents.mapf.graph import Graph
from agents.mapf.league import scheduler
from agents.mapf.league.scheduler import Scheduler
from agents.mapf.league.tasks import NO_TASK, LeagueTask
from warehouse_core import Layout

GRAPH = Graph(Layout(["......", ".####.", "......"]))
EAST, WEST = 1, 3


def assign(
    tasks: list[LeagueTask], cells: list[int], headings: list[int], schedule: list[int]
) -> list[int]:
    known = {task.number: task for task in tasks}
    made = Scheduler(GRAPH, len(tasks))
    return made.assign(np.array(cells), np.array(headings), known, np.array(schedule)).tolist()


def test_robots_get_the_tasks_that_are_done_soonest_turns_included() -> None:
    tasks = [LeagueTask(4, (1,), 0), LeagueTask(7, (5,), 0)]
    assert assign(tasks, [3], [EAST], [NO_TASK]) == [7]
    assert assign(tasks, [3], [WEST], [NO_TASK]) == [4]


def test_the_length_of_a_task_is_that_of_all_its_errands() -> None:
    tasks = [LeagueTask(0, (1, 5, 1), 0), LeagueTask(1, (3, 4), 0)]
    assert assign(tasks, [0], [EAST], [NO_TASK]) == [1]


def test_ways_to_tasks_and_their_trips_cost_what_moves_cost_the_planner() -> None:
    costs = np.ones((18, 4), np.float32)
    costs[:, WEST] = 9.0
    made = Scheduler(GRAPH.with_costs(costs), 2)
    for west, east in (((2,), (5,)), ((3, 2), (3, 5))):  # the one in the west is nearer
        known = {0: LeagueTask(0, west, 0), 1: LeagueTask(1, east, 0)}
        found = made.assign(np.array([3]), np.array([WEST]), known, np.array([NO_TASK]))
        assert found.tolist() == [1], west


def test_a_robot_changes_its_task_only_for_a_shorter_one_and_before_it_has_begun() -> None:
    tasks = [LeagueTask(0, (2,), 0), LeagueTask(1, (2,), 0), LeagueTask(2, (1,), 0)]
    assert assign(tasks[:2], [0], [EAST], [1]) == [1]
    far = [LeagueTask(0, (5,), 0), tasks[2]]
    assert assign(far, [0], [EAST], [0]) == [2]
    begun = [LeagueTask(0, (0, 5), 0, visited=1), tasks[2]]
    assert assign(begun, [0], [EAST], [0]) == [0]


def test_robots_swap_tasks_and_some_have_none() -> None:
    tasks = [LeagueTask(0, (0,), 0), LeagueTask(1, (5,), 0)]
    assert assign(tasks, [4, 1, 14], [EAST, WEST, EAST], [0, 1, NO_TASK]) == [1, 0, NO_TASK]
    assert assign([], [4], [EAST], [NO_TASK]) == [NO_TASK]


def test_on_a_crowded_floor_the_shortest_tasks_are_done(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scheduler, "BUSY_BY_CELL", 2 / 14)
    monkeypatch.setattr(scheduler, "BUSY_BY_ROBOT", 0.0)
    tasks = [LeagueTask(0, (5,), 0), LeagueTask(1, (1,), 0), LeagueTask(2, (13,), 0)]
    assert assign(tasks, [2, 0, 12], [EAST] * 3, [NO_TASK] * 3) == [NO_TASK, 1, 2]
    begun = [LeagueTask(0, (2, 5), 0, visited=1), *tasks[1:]]
    assert sorted(assign(begun, [2, 0, 12], [EAST] * 3, [0, NO_TASK, NO_TASK])) == [NO_TASK, 0, 1]


def test_on_a_full_floor_all_robots_have_tasks_and_of_a_crowd_one_at_a_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tasks = [LeagueTask(number, (number,), 0) for number in range(14)]
    cells = [*range(7), 11, *range(12, 18)]
    for robots, busy in ((14, 14), (12, 12), (11, 5)):
        schedule = assign(tasks, cells[:robots], [EAST] * robots, [NO_TASK] * robots)
        assert robots - schedule.count(NO_TASK) == busy
    monkeypatch.setattr(scheduler, "CROWD", 13)
    schedule = assign(tasks, cells, [EAST] * 14, [NO_TASK] * 14)
    assert len(schedule) - schedule.count(NO_TASK) == 1


def test_a_large_problem_has_manhattan_distances_and_small_matchings(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(scheduler, "MAX_FIELD_BYTES", 0)
    tasks = [LeagueTask(0, (12, 13), 0), LeagueTask(1, (4, 16), 0), LeagueTask(2, (14,), 0)]
    assert assign(tasks, [0, 5], [EAST, EAST], [NO_TASK, NO_TASK]) == [0, 1]
    monkeypatch.setattr(scheduler, "MAX_PAIRS", 3)
    assert assign(tasks, [0, 5], [EAST, EAST], [NO_TASK, 0]) == [2, 0]
    assert assign(tasks[:2], [12, 1], [EAST, EAST], [NO_TASK, NO_TASK]) == [0, 1]


def test_few_robots_are_on_their_way_to_one_cell(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that have begun their tasks have left it; of other tasks the shortest are done."""
    monkeypatch.setattr(scheduler, "MAX_COMING", 2)
    monkeypatch.setattr(scheduler, "BUSY_BY_CELL", 1.0)
    tasks = [
        LeagueTask(0, (5, 4), 0, visited=1), LeagueTask(1, (5, 0), 0), LeagueTask(2, (5, 4), 0),
        LeagueTask(3, (5, 3), 0), LeagueTask(4, (12,), 0),
    ]  # fmt: skip
    schedule = assign(tasks, [11, 3, 2, 1, 0], [EAST] * 5, [0, *[NO_TASK] * 4])
    assert schedule == [0, 2, 3, NO_TASK, 4]
    monkeypatch.setattr(scheduler, "MAX_PAIRS", 1)
    schedule = assign(tasks, [11, 3, 2, 1, 0], [EAST] * 5, [0, 1, *[NO_TASK] * 3])
    assert sorted(schedule) == [NO_TASK, 0, 1, 2, 4]


def test_a_large_problem_has_near_tasks_rather_than_short_ones(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tasks = [LeagueTask(0, (5, 0), 0), LeagueTask(1, (1, 2), 0)]
    assert assign(tasks, [3], [EAST], [NO_TASK]) == [1]
    monkeypatch.setattr(scheduler, "MAX_PAIRS", 1)
    assert assign(tasks, [3], [EAST], [NO_TASK]) == [0]
