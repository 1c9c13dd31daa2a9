"""What the robots of a fleet see of the traffic on their ways, for a network that ranks moves.

A view of a move follows the way that begins with it and goes on by a shortest one, straight on
where it can. A view is therefore the same however a floor is turned or mirrored, and the same
network can judge all moves. What it shows of other robots is local: who is on the next cells of the
way, where each of these would move, and whose shortest ways lead through these cells.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.learning.layers import SingleFloats
from agents.mapf.graph import Fields
from agents.mapf.kernels.floor import ACTIONS, STAY
from agents.mapf.kernels.rounds import NOBODY
from warehouse_core.world.tables import Flags, Integers

AHEAD = 10
"""Cells of a way that a view shows."""

OF_MOVE, OF_CELL = 18, 11
"""Numbers that a view has of a move, and of each cell of its way."""

SIZE = OF_MOVE + AHEAD * OF_CELL
"""Numbers of a view."""

IS_OPEN = 0
"""Place in a view of whether the move can be made."""

MOST_DETOUR, MOST_DISTANCE, MOST_ROBOTS = 4, 20, 3
"""Steps and robots above which a view does not tell numbers apart."""

STRAIGHT = 0.5
"""Steps by which a way straight on seems shorter where ways are equally long."""

OPPOSITE = np.array([2, 3, 0, 1, STAY])
"""The action that undoes each action."""

Columns = list[NDArray[np.generic]]


class Traffic(NamedTuple):
    """Robots before a joint step; arrays are ``[R]``.

    Attributes:
        cells: cells of the robots.
        goals: cells to go to.
        rows: row of each goal in the distance fields.
        order: robots by falling priority.
    """

    cells: Integers
    goals: Integers
    rows: Integers
    order: Integers


class Others(NamedTuple):
    """What is known of the robots on the floor.

    Attributes:
        robot_in: ``[size]``, robot in each cell, or ``NOBODY``.
        ranks: ``[R]``, places in the order of priority, 0 for the highest.
        wishes: ``[R]``, first action of a shortest way of each.
        ways: ``[R, AHEAD]``, cells of this way.
        moves: ``[R, AHEAD]``, actions by which it enters them.
    """

    robot_in: Integers
    ranks: Integers
    wishes: Integers
    ways: Integers
    moves: Integers


class TrafficView:
    """Views of the robots on a floor; it remembers their cells in the last step.

    Args:
        fields: distance fields of the floor.
    """

    def __init__(self, fields: Fields) -> None:
        self._fields = fields
        self._before: Integers = np.empty(0, np.intp)
        self._read_floor()

    def look(self, traffic: Traffic) -> SingleFloats:
        """Return the views of N, E, S, W and waiting, ``[R, 5, SIZE]``, 0 for moves into walls."""
        if self._near_of is not self._fields.near:  # cells have been closed
            self._read_floor()
        cells, goals, rows, order = traffic
        last = self._last_actions(cells)
        ways, moves = self._ways(traffic)
        distances = self._fields.matrix[rows, cells][:, None]
        detours = (self._costs(rows, cells) - distances) / self._fields.step
        seeming = detours - STRAIGHT * (np.arange(ACTIONS) == last[:, None])
        wishes = np.where(cells == goals, STAY, seeming.argmin(axis=1))
        robots, robot_in = np.arange(len(cells)), np.full(len(self._near), NOBODY)
        robot_in[cells], ranks = robots, np.empty(len(cells), np.intp)
        ranks[order] = robots
        others = Others(robot_in, ranks, wishes, ways[robots, wishes], moves[robots, wishes])
        views = np.empty((len(cells), ACTIONS, SIZE), np.float32)
        for number, column in enumerate(self._of_moves(traffic, others, last, detours)):
            views[..., number] = column
        shown = views[..., OF_MOVE:].reshape(len(cells), ACTIONS, AHEAD, OF_CELL)
        start = np.broadcast_to(cells[:, None, None], (len(cells), ACTIONS, 1))
        before = np.concatenate([start, ways[..., :-1]], axis=2)
        for number, column in enumerate(self._of_cells(others, before, ways, moves)):
            shown[..., number] = column
        shown[before == goals[:, None, None]] = 0
        views[..., OF_MOVE:] = shown.reshape(len(cells), ACTIONS, -1)
        views[~self._is_open[cells]] = 0
        return views

    def _read_floor(self) -> None:
        size = self._fields.graph.size
        self._near_of = near = self._fields.near
        self._is_open: Flags = near != size
        self._near = np.where(self._is_open, near, np.arange(size)[:, None])
        self._prices = np.where(self._is_open, self._fields.prices, np.iinfo(np.int32).max)
        self._degree = self._is_open[:, :STAY].sum(axis=1) / STAY

    def _last_actions(self, cells: Integers) -> Integers:
        """Return the actions that have led to these cells; waiting in a first step."""
        before, self._before = self._before, cells.copy()
        if len(before) != len(cells):
            return np.full(len(cells), STAY)
        led_here = self._near[before] == cells[:, None]
        led_here[:, STAY] |= ~led_here.any(axis=1)
        return np.where(cells == before, STAY, led_here.argmax(axis=1))

    def _costs(self, rows: Integers, cells: Integers) -> Integers:
        """Return the costs of the ways to the goals that begin with each action, ``[..., 5]``."""
        found: Integers = self._fields.matrix[rows[..., None], self._near[cells]]
        return found + self._prices[cells]

    def _ways(self, traffic: Traffic) -> tuple[Integers, Integers]:
        """Return the cells of the ways that views follow, ``[R, 5, AHEAD]``, and the moves."""
        goals, rows = (np.repeat(each, ACTIONS) for each in (traffic.goals, traffic.rows))
        move = np.tile(np.arange(ACTIONS), len(traffic.cells))
        place = self._near[traffic.cells].ravel()
        ways, moves, each = [place], [move], np.arange(len(place))
        for _ in range(AHEAD - 1):
            seeming = self._costs(rows, place).astype(np.float32)
            seeming[each, move] -= STRAIGHT
            seeming[:, STAY] += 2 * STRAIGHT
            move = np.where(place == goals, STAY, seeming.argmin(axis=1))
            place = self._near[place, move]
            ways.append(place)
            moves.append(move)
        shape = len(traffic.cells), ACTIONS, AHEAD
        return np.stack(ways, 1).reshape(shape), np.stack(moves, 1).reshape(shape)

    def _of_moves(
        self, traffic: Traffic, others: Others, last: Integers, detours: NDArray[np.float64]
    ) -> Columns:
        """Return what views show of moves; each broadcasts to ``[R, 5]``."""
        (cells, goals, rows, _), (robot_in, ranks, wishes, ways, _) = traffic, others
        to, actions, wanted = self._near[cells], np.arange(ACTIONS), ways[:, 0]
        distances = self._fields.matrix[rows, cells] / self._fields.step
        occupant = robot_in[to]
        is_other = (occupant != NOBODY) & (actions != STAY)
        rivals = np.bincount(wanted, minlength=len(robot_in))
        first = np.full(len(robot_in), len(cells))
        np.minimum.at(first, wanted, ranks)
        is_wanted = wanted[:, None] == to
        return [
            self._is_open[cells],
            np.minimum(detours, MOST_DETOUR),
            detours == 0,
            actions == STAY,
            (actions == last[:, None]) & (actions != STAY),
            (actions == OPPOSITE[last][:, None]) & (actions != STAY),
            (last == STAY)[:, None],
            (cells == goals)[:, None],
            (np.minimum(distances, MOST_DISTANCE) / MOST_DISTANCE)[:, None],
            (ranks / len(cells))[:, None],
            is_other,
            is_other & (wanted[occupant] == cells[:, None]),
            np.minimum(rivals[to] - is_wanted, MOST_ROBOTS),
            first[to] < ranks[:, None],
            np.minimum(rivals[cells] - (wishes == STAY), MOST_ROBOTS)[:, None],
            (first[cells] < ranks)[:, None],
            self._degree[cells][:, None],
            self._degree[to],
        ]

    def _of_cells(
        self, others: Others, before: Integers, ways: Integers, moves: Integers
    ) -> Columns:
        """Return what views show of the cells of ways; each broadcasts to ``[R, 5, AHEAD]``."""
        robot_in, ranks, wishes, theirs, their_moves = others
        size, robots, times = len(robot_in), np.arange(len(ranks))[:, None, None], np.arange(AHEAD)
        occupant = robot_in[ways]
        is_other = (occupant != NOBODY) & (occupant != robots)
        wish = wishes[occupant]
        is_against = is_other & (self._near[ways, wish] == before)
        at_times = np.bincount((times * size + theirs).ravel(), minlength=AHEAD * size)
        is_mine = ways == theirs[:, None]
        enters = their_moves != STAY
        edges, through = theirs * ACTIONS + their_moves, np.bincount(theirs[enters], minlength=size)
        entered = np.bincount(edges[enters], minlength=ACTIONS * size)

        def entering(edge: Integers) -> Integers:
            """Return how many other robots enter a cell by an action on their ways."""
            mine = (edge[..., None] == edges[:, None, None]).any(axis=3)
            others: Integers = entered[edge] - (mine & (entered[edge] > 0))
            return np.minimum(others, MOST_ROBOTS)

        return [
            is_other,
            is_other & (wish == moves) & (wish != STAY) & ~is_against,
            is_against,
            is_other & (wish == STAY),
            is_other & (ranks[occupant] < ranks[robots]),
            np.minimum(at_times[times * size + ways] - is_mine, MOST_ROBOTS),
            entering(ways * ACTIONS + moves),
            entering(before * ACTIONS + OPPOSITE[moves]),
            np.minimum(through[ways], 2 * MOST_ROBOTS),
            self._degree[ways],
            np.ones(1),
        ]
