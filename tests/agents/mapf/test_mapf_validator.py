"""The validator of plans finds each fault, and joint A* gives the costs of small problems."""

import pytest
from helpers.mapf_validator import plan_conflict, step_conflict

ROWS = ["...", ".#.", "..."]
"""Cells 0 to 8, with a wall in 4."""

FAULTS = {
    "begin": ([0, 1], [0, 1], [[1, 0], [0, 1]]),
    "both in": ([0, 2], [1, 5], [[0, 2], [1, 1], [1, 5]]),
    "change places": ([0, 1], [1, 0], [[0, 1], [1, 0]]),
    "wall": ([1], [7], [[1], [4], [7]]),
    "moves 2 cells": ([0], [2], [[0], [2]]),
    "moves 3 cells": ([2], [3], [[2], [3]]),
    "goal": ([0], [2], [[0], [1]]),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_found(fault: str) -> None:
    found = plan_conflict(ROWS, *FAULTS[fault])
    assert found is not None
    assert fault in found


def test_a_step_can_have_closed_cells_and_robots_that_stay() -> None:
    assert "stay" in str(step_conflict(ROWS, [0, 2], [0, 5], stays=[False, True]))
    assert "closed" in str(step_conflict(ROWS, [0, 2], [1, 2], closed=[1]))
    assert step_conflict(ROWS, [0, 2], [1, 2], stays=[False, True], closed=[0, 2]) is None
