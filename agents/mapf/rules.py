"""Rules: what one robot must and must not do under all constraints of a node of CBS."""

from __future__ import annotations

from collections import defaultdict
from math import inf
from typing import NamedTuple

from agents.mapf.cell_sets import CellSets

Moves = dict[int, dict[int, int]]
"""Forbidden moves by time and cell: the cells that must not be combined with this cell."""


class Constraint(NamedTuple):
    """A statement about a robot's path, and whether it must be true or false.

    Attributes:
        robot: number of the robot.
        time: number of the joint step.
        cell: cell of the robot after the step; ``None`` states that it has arrived by then.
        before: cell of the robot before the step; ``None`` states nothing about it.
        holds: true for a positive constraint, with which other robots have to keep away; false for
            a negative one.
    """

    robot: int
    time: int
    cell: int | None
    before: int | None = None
    holds: bool = False


class Rules:
    """The rules of a robot, which is at its start at the time 0 and finally stays at its goal.

    Attributes:
        least: earliest time at which the robot may have arrived for good.
        most: latest time at which the robot may have arrived for good.
        closed: cells in which the robot must not be at a time.
        ends: cells in which the robot must not be from a time on.
        into: cells from which the robot must not enter a cell, by time of arrival.
        out_of: cells that the robot must not enter from a cell, by time of arrival.
        latest: time after which the rules do not change.
    """

    def __init__(self) -> None:
        self.least, self.most, self.latest = 0, inf, 0
        self.closed = defaultdict[int, int](int)
        self.ends = defaultdict[int, int](int)
        self.into: Moves = {}
        self.out_of: Moves = {}

    def add(self, sets: CellSets, rule: Constraint, is_own: bool, goal: int) -> None:
        """Add the consequences of a constraint for the robot.

        Args:
            sets: sets of the floor.
            rule: constraint on this robot, or a positive constraint on another robot.
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
        """Return the first time from which the robot can stay at its goal."""
        return max([self.least, *(time + 1 for time, each in self.closed.items() if each & goal)])


def step(sets: CellSets, cells: int, barred: dict[int, int] | None) -> int:
    """Return the cells of a robot after a step or, given ``out_of`` moves, before the step.

    Args:
        sets: sets of the floor.
        cells: cells in one of which the robot is.
        barred: moves that are forbidden in the step.
    """
    reached = sets.spread(cells)
    for cell, others in barred.items() if barred else ():
        if not sets.spread(cell) & cells & ~others:
            reached &= ~cell
    return reached
