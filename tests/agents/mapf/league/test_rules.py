"""Moves of the League."""

import numpy as np
import pytest

from agents.mapf.graph import Graph
from agents.mapf.league.rules import LETTERS, ActionError, action_error, result_of
from warehouse_core import Layout

GRAPH = Graph(Layout(["...", "#.."]))
NORTH, EAST, SOUTH, WEST = range(4)


def actions_of(text: str) -> np.ndarray:
    return np.array([*map(LETTERS.index, text)])


def test_robots_drive_forward_turn_and_wait() -> None:
    cells, headings = np.array([0, 1, 2, 4]), np.array([EAST, SOUTH, SOUTH, NORTH])
    reached, turned = result_of(GRAPH, cells, headings, actions_of("FRWC"))
    assert reached.tolist() == [1, 1, 2, 4]
    assert turned.tolist() == [EAST, WEST, SOUTH, WEST]


@pytest.mark.parametrize(
    ("cells", "headings", "text", "error"),
    [
        ([0, 1, 4], [EAST, EAST, EAST], "FFF", None),
        ([1, 2, 5, 4], [EAST, SOUTH, WEST, NORTH], "FFFF", None),  # a ring
        ([0, 1], [NORTH, EAST], "FW", (0, -1, "unallowed move")),
        ([1, 4], [EAST, WEST], "WF", (1, -1, "unallowed move")),
        ([0, 1], [EAST, EAST], "FW", (1, 0, "vertex conflict")),
        ([2, 1, 0], [WEST, EAST, EAST], "FFW", (1, 0, "edge conflict")),
        ([1, 2], [EAST, WEST], "F", (-1, -1, "incorrect vector size")),
    ],
)
def test_what_robots_may_not_do_together_is_named(
    cells: list[int], headings: list[int], text: str, error: ActionError | None
) -> None:
    assert action_error(GRAPH, np.array(cells), np.array(headings), actions_of(text)) == error
