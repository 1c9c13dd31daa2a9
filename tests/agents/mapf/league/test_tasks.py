"""Tasks of the League: how they are revealed, given and finished."""

import numpy as np
import pytest
from helpers.league import league_of

from agents.mapf.league.tasks import Errand, TaskPool, tasks_of

ROW = (".....",)
NONE = -1


def pool_of(year: int = 2024) -> TaskPool:
    tasks = [[4, 0], [3], [2, 1]]
    return tasks_of(league_of(ROW, [0, 2], tasks, revealed=3, year=year))


def propose(pool: TaskPool, *schedule: int) -> list[int]:
    pool.propose(np.array(schedule), 1)
    return pool.schedule.tolist()


def test_cells_of_a_task_are_visited_in_turn_and_one_a_step() -> None:
    pool = pool_of()
    assert propose(pool, 2, 0) == [2, 0]
    assert pool.goals(np.array([0, 2])).tolist() == [2, 4]
    pool.visit(np.array([2, 4]), 1)
    pool.visit(np.array([1, 0]), 2)
    assert pool.errands == [
        Errand(1, 0, 2, 1),
        Errand(1, 1, 0, 1),
        Errand(2, 0, 2, 2),
        (2, 1, 0, 2),
    ]
    assert (pool.finished, pool.schedule.tolist(), [*pool.known]) == (2, [NONE, NONE], [1])
    pool.reveal(2)
    assert [(task.number, task.cells, task.revealed) for task in pool.tasks[3:]] == [
        (3, (4, 0), 2),
        (4, (3,), 2),
    ]
    assert pool.given == [[(1, 2)], [(1, 0)]]


@pytest.mark.parametrize(
    ("schedule", "text", "repaired"),
    [
        ((1, 1), "task is already assigned by the second agent at the same time", [1, NONE]),
        ((9, 1), "task already finished", [NONE, 1]),
        ((1,), "Invalid schedule size", [NONE, NONE]),
    ],
)
def test_a_schedule_with_an_error_is_dropped_in_2024_and_repaired_in_2026(
    schedule: tuple[int, ...], text: str, repaired: list[int]
) -> None:
    pool = pool_of()
    assert propose(pool, *schedule) == [NONE, NONE]
    assert [error.text for error in pool.errors] == [text]
    assert propose(pool_of(2026), *schedule) == repaired


@pytest.mark.parametrize(
    ("schedule", "text", "repaired"),
    [
        ((1, 0), "schedule agent to another task who is already opened a task", [2, 0]),
        ((2, 2), "task is already assigned by the second agent at the same time", [2, NONE]),
        ((NONE, 2), "schedule agent to another task who is already opened a task", [2, NONE]),
    ],
)
def test_a_task_stays_with_the_robot_that_has_begun_it(
    schedule: tuple[int, int], text: str, repaired: list[int]
) -> None:
    for year, after in ((2024, [2, 0]), (2026, repaired)):
        pool = pool_of(year)
        propose(pool, 2, 0)
        pool.visit(np.array([2, 3]), 1)
        assert propose(pool, *schedule) == after
        assert pool.errors[0].text == text
        assert pool.known[2].robot == 0


def test_a_robot_does_not_get_a_task_that_a_later_one_has_begun() -> None:
    pool = pool_of(2026)
    propose(pool, 0, 2)
    pool.visit(np.array([3, 2]), 1)
    assert propose(pool, 2, 2) == [NONE, 2]
    assert pool.errors[0][1:] == (0, 1, 1, "task is already opened by other agent")


def test_robots_swap_tasks_that_they_have_not_begun() -> None:
    pool = pool_of()
    propose(pool, 2, 0)
    assert propose(pool, 0, 2) == [0, 2]
    assert [pool.known[task].robot for task in (0, 2)] == [0, 1]


def given_by(strategy: str, tasks: int, revealed: int = 2) -> TaskPool:
    cells = [[cell % 5] for cell in range(tasks)]
    return tasks_of(league_of(ROW, [0, 2], cells, revealed=revealed, strategy=strategy, year=2023))


def test_robots_of_2023_get_every_second_task_and_begin_again() -> None:
    pool = given_by("roundrobin", 3)
    seen = []
    for step in range(1, 4):
        seen.append([pool.known[task].cells[0] for task in pool.schedule.tolist()])
        pool.visit(pool.goals(np.array([0, 0])), step)
        pool.reveal(step)
    assert seen == [[0, 1], [2, 0], [1, 2]]
    assert pool.finished == 6


def test_tasks_of_2023_end_where_they_are_fixed_or_given_to_who_needs_one() -> None:
    fixed, greedy = given_by("roundrobin_fixed", 3), given_by("greedy", 3)
    for pool in (fixed, greedy):
        pool.visit(np.array([0, 3]), 1)
        pool.reveal(1)
    assert [fixed.schedule.tolist(), greedy.schedule.tolist()] == [[2, 1], [2, 1]]
    for pool in (fixed, greedy):
        pool.visit(np.array([2, 1]), 2)
        pool.reveal(2)
        assert pool.schedule.tolist() == [NONE, NONE]
        assert pool.goals(np.array([2, 1])).tolist() == [2, 1]


def test_robots_of_2023_know_several_tasks_ahead() -> None:
    pool = given_by("roundrobin", 4, revealed=4)
    assert [task.cells for task in pool.tasks] == [(0,), (2,), (1,), (3,)]
    assert pool.schedule.tolist() == [0, 2]
    pool.wait(np.array([0, 0]), 1)
    assert (pool.finished, pool.schedule.tolist(), len(pool.tasks)) == (1, [1, 2], 5)
