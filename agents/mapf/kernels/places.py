"""The places of a floor, the steps between them, and distance fields.

Places are numbered as in ``graph.py``: a place is a cell, or a cell with one of four headings. The
cell of a place is ``place % size``.
"""

from __future__ import annotations

from typing import NamedTuple

from agents.mapf.kernels.buffers import Buffer, Table
from warehouse_core.compiled import kernel

STAY = 4
"""Index of the waiting action. The ``ACTIONS`` actions are N, E, S, W and this one."""

ACTIONS = 5

FORWARD, TURNS = 0, 3
"""Actions of a robot with a heading: moving forward, and the end of the range of actions.

The numbers between them are a turn to the right and a turn to the left.
"""

NONE = -1
"""Marks a missing entry, configuration, cost, order, robot, charger or cell."""

FAR = 1 << 30
"""Distance of a place from which the goal is unreachable."""


class Places(NamedTuple):
    """The places of a floor and the steps between them.

    Attributes:
        size: number of cells.
        closed: number of places, which also marks a step that leads nowhere.
        near: ``[places * 5]``, place that each action leads to from each place, or ``closed``. With
            headings the actions are ``FORWARD``, two turns, one that leads nowhere, and ``STAY``.
        price: ``[places * 5]``, cost of each of these steps.
        cell: ``[places]``, cell of each place.
        degree: ``[size]``, number of neighbours of each cell.
        through: ``[size]``, number of neighbours of each cell that are not dead ends.
        step: cost of a step without lanes and turns, 1 or more.
    """

    size: int
    closed: int
    near: Buffer
    price: Buffer
    cell: Buffer
    degree: Buffer
    through: Buffer
    step: int


class Reverse(NamedTuple):
    """The steps between places in reverse direction, and buffers of ``measure``.

    Places have other numbers here, so that places in the same cell are next to one another.

    Attributes:
        headings: number of places in each cell: 1, or 4 with headings.
        turn: cost of a quarter turn in a cell, or 0 if robots only move.
        behind: ``[places * moves * 2]``, the places from which moves lead to each place, each with
            the cost of the move, and then ``NONE``.
        heads: last entry of each bucket, all ``NONE`` between searches. There is one bucket more
            than the highest price, and the buckets are used cyclically.
        entries: ``[places * 4 * 2]``, places in buckets, each with the previous entry in the same
            bucket, or ``NONE``.
    """

    headings: int
    turn: int
    behind: Table
    heads: Buffer
    entries: Table


@kernel
def lower(
    reverse: Reverse, field: Table, place: int, distance: int, cost: int, bucket: int, count: int
) -> int:
    """Lower the distance of a place to ``distance + cost``; return 1, or 0 if it is not higher."""
    if distance + cost >= field[place]:
        return 0
    into = bucket + cost
    if into >= len(reverse.heads):
        into -= len(reverse.heads)
    field[place], reverse.entries[2 * count] = distance + cost, place
    reverse.entries[2 * count + 1], reverse.heads[into] = reverse.heads[into], count
    return 1


@kernel
def measure(reverse: Reverse, goal: int, field: Table) -> None:
    """Write the cost of the cheapest path from each place to a goal into a field, ``[places]``.

    The search is Dijkstra's with buckets in place of a heap (Dial, 1969). All places of the cell
    ``goal`` have the distance 0.
    """
    behind, heads, entries = reverse.behind, reverse.heads, reverse.entries
    width = len(behind) // len(field)
    for place in range(len(field)):
        field[place] = FAR
    bucket, distance, count = 0, 0, 0
    for place in range(goal * reverse.headings, (goal + 1) * reverse.headings):
        count += lower(reverse, field, place, 0, 0, 0, count)
    waiting = count
    while waiting > 0:
        entry = heads[bucket]
        if entry == NONE:
            bucket, distance = bucket + 1, distance + 1
            if bucket == len(heads):
                bucket = 0
            continue
        place, heads[bucket] = entries[2 * entry], entries[2 * entry + 1]
        waiting -= 1
        if field[place] != distance:
            continue  # a cheaper path has been found since
        before = count
        for at in range(place * width, (place + 1) * width, 2):
            if behind[at] == NONE:
                break
            count += lower(reverse, field, behind[at], distance, behind[at + 1], bucket, count)
        if reverse.turn > 0:
            for turn in (1, 3):
                beside = (place & ~3) + ((place + turn) & 3)
                count += lower(reverse, field, beside, distance, reverse.turn, bucket, count)
        waiting += count - before
