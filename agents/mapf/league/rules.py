"""The moves of the League: robots drive forward, turn by a quarter, or wait.

An action is its index in ``LETTERS``, which the first ``TURN_ACTIONS`` of a fleet share. Headings
are 0 to 3 for N, E, S and W; ``R`` is the number of robots.

Source: ``src/ActionModel.cpp`` of the League's Start-Kit, 2.1.2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.mapf.graph import CLOSED, Graph, robots_in
from warehouse_core.world.moves import FORWARD, HEADING_AFTER
from warehouse_core.world.tables import Integers

LETTERS = "FRCWT"
"""Letters of the actions in results; ``T`` stands for a plan that was late."""

WAITING, LOST = LETTERS.index("W"), LETTERS.index("T")

NOBODY = -1
"""Stands for a robot or a task where there is none."""


class ActionError(NamedTuple):
    """Why a joint action is not allowed; all robots wait instead.

    Attributes:
        robot, other: robots that are concerned, or ``NOBODY``.
        text: words of the League.
    """

    robot: int
    other: int
    text: str


def result_of(
    graph: Graph, cells: Integers, headings: Integers, actions: Integers
) -> tuple[Integers, Integers]:
    """Return cells and headings after a joint action, all ``[R]``; ``CLOSED`` for no open cell."""
    ahead = graph.neighbours[cells, headings]
    return np.where(actions == FORWARD, ahead, cells), HEADING_AFTER[headings, actions]


def action_error(
    graph: Graph, cells: Integers, headings: Integers, actions: Integers
) -> ActionError | None:
    """Return why a joint action is not allowed, or ``None``; the other arguments are ``[R]``.

    Nobody leaves the open cells, two robots do not share a cell, and do not change places. As in
    the League, it is the error of the first robot that has one with those before it.
    """
    if len(actions) != len(cells):
        return ActionError(NOBODY, NOBODY, "incorrect vector size")
    reached, _ = result_of(graph, cells, headings, actions)
    if len(np.unique(reached)) == len(cells) and (reached != CLOSED).all():
        other = robots_in(graph.size, cells)[reached]
        if not ((reached != cells) & (other != NOBODY) & (reached[other] == cells)).any():
            return None
    first: dict[int, int] = {}
    ways: dict[tuple[int, int], int] = {}
    for robot, way in enumerate(zip(cells.tolist(), reached.tolist(), strict=True)):
        before, after = way
        if after == CLOSED:
            return ActionError(robot, NOBODY, "unallowed move")
        if after in first:
            return ActionError(robot, first[after], "vertex conflict")
        if way in ways:
            return ActionError(robot, ways[way], "edge conflict")
        first[after] = ways[after, before] = robot
    raise AssertionError("robots that meet were not found again")
