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


class Floor(NamedTuple):
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
def step_to(floor: Floor, place: int, number: int) -> int:
    """Return the index in ``near`` of one of the steps that lead to a place, or ``NONE``.

    A step leads back from where one leads. Robots with headings enter a cell as they head.
    """
    near, half = floor.near, floor.closed // 2
    if floor.closed == floor.size:
        before, back = near[place * ACTIONS + number] + 0, number ^ 2
    elif number == FORWARD:  # the cell behind is the one ahead of a robot that has turned round
        before, back = near[(place + half) % floor.closed * ACTIONS + FORWARD] + 0, FORWARD
        before = (before + half) % floor.closed if before != floor.closed else before
    elif number < TURNS:
        before, back = near[place * ACTIONS + number] + 0, number ^ 3
    else:
        return NONE
    found = before * ACTIONS + back
    return found if before != floor.closed and near[found] == place else NONE


@kernel
def measure(
    floor: Floor, goal: int, field: Table, heads: Buffer, entries: Buffer, below: Buffer
) -> None:
    """Write the cost of the cheapest way from each place to a goal into a field.

    Args:
        floor: floor whose places are cells, or cells with headings.
        goal: cell, all places of which have the distance 0.
        field: ``[places]``, all ``FAR`` before.
        heads: last entry of each bucket, one more than the highest price, all ``NONE``. The
            buckets are used in turn, as Dial (1969) does.
        entries: ``[places * 4 + 4]``, places in buckets.
        below: ``[places * 4 + 4]``, entry before each in its bucket, or ``NONE``.
    """
    price, span = floor.price, len(heads)
    count, distance = 0, 0
    for place in range(goal, floor.closed, floor.size):
        field[place], entries[count], below[count], heads[0] = 0, place, heads[0], count
        count += 1
    waiting = count
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
            step = step_to(floor, place, number)
            if step == NONE:
                continue
            before, reached = step // ACTIONS, distance + price[step]
            if reached < field[before]:
                field[before] = reached
                entries[count], below[count] = before, heads[reached % span]
                heads[reached % span] = count
                count, waiting = count + 1, waiting + 1


@kernel
def count_steps(
    beside: Table, goal: int, field: Table, known: Buffer, fresh: Buffer, queue: Buffer
) -> None:
    """Write the steps to a goal from each place of robots with headings into a field.

    A move forward and a quarter turn are a step each. Several headings in a cell that are as far
    from the goal are looked at together, as bits of a number.

    Args:
        beside: ``[size * 5]``, cell that N, E, S, W and waiting lead to, or ``NONE``.
        goal: cell, all places of which have the distance 0.
        field: ``[4 * size]``, all ``FAR`` before.
        known: ``[size]``, used for the headings that have a distance.
        fresh: ``[size]``, used for the headings found last, in four bits for even distances and
            four for odd ones; all 0 before and after.
        queue: ``[4 * size]``, used for cells with such headings.
    """
    size, first, last, distance = len(known), 0, 1, 0
    every = (1 << STAY) - 1
    for cell in range(size):
        known[cell] = 0
    queue[0], known[goal], fresh[goal] = goal, every, every
    for place in range(goal, len(field), size):
        field[place] = 0
    while first < last:
        now, then, end = (distance & 1) * STAY, (~distance & 1) * STAY, last
        distance += 1
        while first < end:
            cell = queue[first]
            first += 1
            headings = (fresh[cell] >> now) & every
            fresh[cell] ^= headings << now
            turned = (headings << 1 | headings >> 1 | headings << 3 | headings >> 3) & every
            for heading in range(STAY):
                bit, behind = 1 << heading, NONE
                if turned & bit and known[cell] & bit == 0:
                    known[cell] |= bit
                    field[heading * size + cell] = distance
                    if fresh[cell] == 0:
                        queue[last] = cell
                        last += 1
                    fresh[cell] |= bit << then
                if headings & bit:
                    behind = beside[cell * ACTIONS + (heading ^ 2)] + 0
                if behind != NONE and known[behind] & bit == 0:
                    known[behind] |= bit
                    field[heading * size + behind] = distance
                    if (fresh[behind] >> then) & every == 0:
                        queue[last] = behind
                        last += 1
                    fresh[behind] |= bit << then
