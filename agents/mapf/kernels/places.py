"""The places of a floor, the steps between them, and distance fields.

Places are numbers as in ``graph.py``: cells, or four times as many where robots have headings. The
cell of a place is its remainder by the number of cells.
"""

from __future__ import annotations

from typing import NamedTuple

from agents.mapf.kernels.buffers import Buffer, Table, kernel

STAY = 4
"""Number of the action that stays; there are ``ACTIONS`` actions, N, E, S, W and this."""

ACTIONS = 5

FORWARD, TURNS = 0, 3
"""Number of the move of a robot with a heading, and number of no action: the numbers between them
turn it to the right and to the left.
"""

NONE = -1
"""Number in place of an entry, a configuration or a cost where there is none."""

FAR = 1 << 30
"""Distance of a place that no way leads from."""


class Places(NamedTuple):
    """The places of a floor and the steps between them.

    Attributes:
        size: number of cells.
        closed: number of places, which stands for where no step leads.
        near: ``[places * 5]``, place that each action leads to from each place, or ``closed``. With
            headings the actions are ``FORWARD``, two turns, one that leads nowhere, and ``STAY``.
        price: ``[places * 5]``, cost of each of these steps.
        cell: ``[places]``, cell of each place.
        degree: ``[size]``, cells beside each cell.
        through: ``[size]``, cells beside each cell that are no dead ends.
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
    """Write the cost of the cheapest way from each place to a goal into a field.

    Args:
        floor: floor whose places are cells.
        goal: cell that has the distance 0.
        field: ``[places]``, all ``FAR`` before.
        heads: last entry of each bucket, one more than the highest price, all ``NONE``. The
            buckets are used in turn, as Dial (1969) does.
        entries: ``[places * 4 + 4]``, places in buckets.
        below: ``[places * 4 + 4]``, entry before each in its bucket, or ``NONE``.
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
            continue  # a cheaper way was found since
        for number in range(STAY):
            before = near[place * ACTIONS + number]
            step = before * ACTIONS + (number ^ 2)  # back again
            if before == floor.closed or near[step] != place:
                continue
            reached = distance + price[step]
            if reached < field[before]:
                field[before] = reached
                entries[count], below[count] = before, heads[reached % span]
                heads[reached % span] = count
                count, waiting = count + 1, waiting + 1


class Turning(NamedTuple):
    """Steps that lead to the places of robots with headings, and what ``measure_turning`` uses.

    The place of a robot is ``4 * n + heading`` here, where the open cells have numbers ``n``.

    Attributes:
        turn: cost of a quarter turn.
        behind: ``[places]``, place from which a move leads to each place, or ``NONE``.
        price: ``[places]``, cost of that move.
        heads: last entry of each bucket, one more than the highest price, all ``NONE``. The
            buckets are used in turn, as Dial (1969) does.
        entries: ``[places * 4]``, places in buckets.
        below: ``[places * 4]``, entry before each in its bucket, or ``NONE``.
    """

    turn: int
    behind: Table
    price: Table
    heads: Buffer
    entries: Table
    below: Table


@kernel
def measure_turning(turning: Turning, goal: int, field: Table) -> None:
    """Write the cost of the cheapest way from each place to a goal into a field.

    Args:
        turning: steps between places.
        goal: number of an open cell, all places of which have the distance 0.
        field: ``[places]``, of any numbers before.
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
            continue  # a cheaper way was found since
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
