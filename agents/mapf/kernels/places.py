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
"""Marks a missing entry, configuration or cost."""

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


@kernel
def measure(
    floor: Places, goal: int, field: Table, heads: Buffer, entries: Buffer, below: Buffer
) -> None:
    """Write the cost of the cheapest path from each place to a goal into a field.

    The search is Dijkstra's with buckets in place of a heap (Dial, 1969).

    Args:
        floor: floor whose places are cells.
        goal: cell that has the distance 0.
        field: ``[places]``, all ``FAR`` before.
        heads: last entry of each bucket, all ``NONE`` before. There is one bucket more than the
            highest price, and the buckets are used cyclically.
        entries: ``[places * 4 + 4]``, places in buckets.
        below: ``[places * 4 + 4]``, previous entry in the same bucket, or ``NONE``.
    """
    near, price, span = floor.near, floor.price, len(heads)
    field[goal], entries[0], below[0], heads[0] = 0, goal, NONE, 0
    count, waiting, distance = 1, 1, 0
    while waiting > 0:
        entry = heads[distance % span]
        if entry == NONE:
            distance += 1
            continue
        heads[distance % span], place = below[entry], entries[entry]
        waiting -= 1
        if field[place] != distance:
            continue  # a cheaper path has been found since
        for number in range(STAY):
            before = near[place * ACTIONS + number]
            step = before * ACTIONS + (number ^ 2)  # the opposite move
            if before == floor.closed or near[step] != place:
                continue
            reached = distance + price[step]
            if reached < field[before]:
                field[before] = reached
                entries[count], below[count] = before, heads[reached % span]
                heads[reached % span] = count
                count, waiting = count + 1, waiting + 1


class Turning(NamedTuple):
    """Reverse steps between the places of robots with headings, and buffers of ``measure_turning``.

    The place of a robot is ``4 * n + heading`` here, where ``n`` numbers the open cells.

    Attributes:
        turn: cost of a quarter turn.
        behind: ``[places]``, place from which a move leads to each place, or ``NONE``.
        price: ``[places]``, cost of that move.
        heads: last entry of each bucket, all ``NONE`` between searches. There is one bucket more
            than the highest price, and the buckets are used cyclically.
        entries: ``[places * 4]``, places in buckets.
        below: ``[places * 4]``, previous entry in the same bucket, or ``NONE``.
    """

    turn: int
    behind: Table
    price: Table
    heads: Buffer
    entries: Table
    below: Table


@kernel
def measure_turning(turning: Turning, goal: int, field: Table) -> None:
    """Write the cost of the cheapest path from each place to a goal into a field.

    Args:
        turning: steps between places.
        goal: number of an open cell. All of its places have the distance 0.
        field: ``[places]``, overwritten.
    """
    behind, price, heads = turning.behind, turning.price, turning.heads
    entries, below = turning.entries, turning.below
    for place in range(len(field)):
        field[place] = FAR
    bucket, count, distance = 0, 0, 0
    for place in range(goal * STAY, (goal + 1) * STAY):
        field[place], entries[count], below[count], heads[0] = 0, place, heads[0], count
        count += 1
    waiting = count
    while waiting > 0:
        entry = heads[bucket]
        if entry == NONE:
            bucket, distance = bucket + 1, distance + 1
            if bucket == len(heads):
                bucket = 0
            continue
        heads[bucket], place = below[entry], entries[entry]
        waiting -= 1
        if field[place] != distance:
            continue  # a cheaper path has been found since
        for number in range(TURNS):
            if number == FORWARD:
                before, cost = behind[place], price[place]
                if before == NONE:
                    continue
            else:  # a turn to the right or to the left
                before, cost = (place & ~3) + ((place + 2 * number - 3) & 3), turning.turn
            if distance + cost < field[before]:
                field[before] = distance + cost
                into = bucket + cost
                if into >= len(heads):
                    into -= len(heads)
                entries[count], below[count], heads[into] = before, heads[into], count
                count, waiting = count + 1, waiting + 1
