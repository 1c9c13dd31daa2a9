"""Clashes: two robots whose cheapest paths always have a conflict, whichever paths they choose.

For each cell of one robot at a time, the search keeps the set of cells of the other robot. It
detects the symmetries of rectangles, targets and corridors without testing for each of them.

Sources: Li et al. (2021), Pairwise symmetry reasoning for multi-agent path finding search,
Artificial Intelligence 301. Sharon et al. (2013), The increasing cost tree search, Artificial
Intelligence 195, for pairs of multi-valued decision diagrams.
"""

from __future__ import annotations

from agents.mapf.cell_sets import CellSets, bits_of
from agents.mapf.route import Route

MAX_CELLS = 10_000
"""Limit on the cells of a robot, summed over all times, for a comparison of two robots.

Beyond it, the two count as robots without a clash. This weakens the bound but keeps it valid.
"""

MAX_DELAY = 64
"""Largest delay of a robot that is tested."""


def delays_of(sets: CellSets, one: Route, other: Route) -> tuple[int, int] | None:
    """Return delays of two robots, such that in every plan one of them is at least that late.

    Both are 1 or more. ``None`` means that the robots do not clash.
    """
    known: dict[tuple[int, int], bool] = {}

    def clash(our: int, their: int) -> bool:
        """Return whether the robots clash even if each may be late by less than its delay."""
        if max(our, their) > MAX_DELAY:
            return False
        if (our, their) not in known:
            known[our, their] = _clash(sets, one.layers(our - 1), other.layers(their - 1))
        return known[our, their]

    if not clash(1, 1):
        return None
    ours = theirs = 1
    for a, b in ((1, 1), (1, 0), (0, 1)):
        more = 1
        while clash(ours + a * more, theirs + b * more):
            ours, theirs, more = ours + a * more, theirs + b * more, 2 * more
        while more := more // 2:
            if clash(ours + a * more, theirs + b * more):
                ours, theirs = ours + a * more, theirs + b * more
    return ours, theirs


def _clash(sets: CellSets, ours: list[int], theirs: list[int]) -> bool:
    """Return whether every two paths through layers have a conflict."""
    if sum(map(int.bit_count, ours)) > sum(map(int.bit_count, theirs)):
        ours, theirs = theirs, ours  # enumerate the cells of the robot that has fewer
    end = max(len(ours), len(theirs))
    ours, theirs = ours + ours[-1:] * (end - len(ours)), theirs + theirs[-1:] * (end - len(theirs))
    near = [
        time
        for time in range(1, end)
        if ours[time] & theirs[time]
        or (ours[time] & theirs[time - 1] and ours[time - 1] & theirs[time])
    ]
    if not near:
        return False
    begin, looked_at = near[0] - 1, 0
    with_us = dict.fromkeys(bits_of(ours[begin]), theirs[begin])
    for time in range(near[0], near[-1] + 1):
        looked_at += len(with_us)
        if looked_at > MAX_CELLS:
            return False
        with_us = _after(sets, with_us, ours[time], theirs[time])
        if not with_us:
            return True
    return False


def _after(sets: CellSets, with_us: dict[int, int], our: int, their: int) -> dict[int, int]:
    """Return the cells of the other robot for each cell of this one, a step later.

    Args:
        sets: sets of the floor.
        with_us: cells of the other robot for each cell of this one, before the step.
        our: cells that this robot may be in after the step.
        their: cells that the other robot may be in after the step.
    """
    after: dict[int, int] = {}
    for before, cells in with_us.items():
        reached = sets.spread(cells) & their
        for cell in sets.steps_from(before):
            if cell & our:
                there = reached & ~cell
                # They must not swap cells: the other must not come from this robot's new cell.
                if there & before and cell & cells and not sets.spread(before) & cells & ~cell:
                    there ^= before
                if there:
                    after[cell] = after.get(cell, 0) | there
    return after
