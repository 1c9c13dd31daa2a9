"""Rules: what one robot must do and must not do, by all constraints of a node of a search."""

from __future__ import annotations

from collections import defaultdict
from math import inf
from typing import NamedTuple

from agents.mapf.cell_sets import CellSets

Moves = dict[int, dict[int, int]]
"""Cells that no move joins to a cell in a step, by time and cell."""


class Constraint(NamedTuple):
    """A statement on a robot's way, and whether it holds.

    Attributes:
        robot: number of the robot.
        time: number of the joint step.
        cell: cell of the robot after the step; ``None`` states that it has arrived by then.
        before: cell of the robot before the step; ``None`` states nothing on it.
        holds: true if the statement is; then other robots keep out of the way.
    """

    robot: int
    time: int
    cell: int | None
    before: int | None = None
    holds: bool = False


class Rules:
    """The rules of a robot, which is in its start at the time 0 and stays in its goal at last.

    Attributes:
        least: time before which the robot has not arrived for good.
        most: time by which the robot has arrived for good.
        closed: cells in which the robot is not at a time.
        ends: cells in which the robot is not from a time on.
        into: cells from which the robot does not reach a cell, by time of arrival.
        out_of: cells that the robot does not reach from a cell, by time of arrival.
        latest: time after which the rules do not change.
    """

    def __init__(self) -> None:
        self.least, self.most, self.latest = 0, inf, 0
        self.closed = defaultdict[int, int](int)
        self.ends = defaultdict[int, int](int)
        self.into: Moves = {}
        self.out_of: Moves = {}

    def add(self, sets: CellSets, rule: Constraint, is_own: bool, goal: int) -> None:
        """Add what follows for the robot from a constraint.

        Args:
            sets: sets of the floor.
            rule: constraint on this robot, or one that holds for another robot.
            is_own: true for a constraint on this robot.
            goal: goal of the constraint's robot.
        """
        time, must = rule.time, is_own and rule.holds
        self.latest = max(self.latest, time)
        if rule.cell is None:
            if not is_own:
                self.ends[time] |= goal
            elif must:
                self.most = min(self.most, time)
            else:
                self.least = max(self.least, time + 1)
            return
        places = [(time, sets.bits[rule.cell])]
        if rule.before is not None:
            places.append((time - 1, sets.bits[rule.before]))
            if not must:
                (_, to), (_, before) = reversed(places) if rule.holds else places
                for moves, one, other in ((self.into, to, before), (self.out_of, before, to)):
                    here = moves.setdefault(time, {})
                    here[one] = here.get(one, 0) | other
        if rule.before is None or rule.holds:
            for when, cell in places:
                self.closed[when] |= sets.open ^ cell if must else cell

    def arrival(self, goal: int) -> int:
        """Return the first time from which on the robot can stay in its goal."""
        return max([self.least, *(time + 1 for time, each in self.closed.items() if each & goal)])


def step(sets: CellSets, cells: int, barred: dict[int, int] | None) -> int:
    """Return where a robot can be after a step, or, with ``out_of``, where it was before.

    Args:
        sets: sets of the floor.
        cells: cells of the robot, one of which it is in.
        barred: moves that are not allowed in the step.
    """
    reached = sets.spread(cells)
    for cell, others in barred.items() if barred else ():
        if not sets.spread(cell) & cells & ~others:
            reached &= ~cell
    return reached
