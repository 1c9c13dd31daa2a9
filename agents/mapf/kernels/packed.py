"""Distances from the four headings in a cell to a goal, packed into one number of 32 bits.

A turn is a step, so the distances in a cell differ by no more than a half turn. Bits 0 and 1 are
the nearest heading, the next three times five bits are by how much further the headings clockwise
of it are, and the rest is the distance of the nearest. Before it is packed, the distance of a place
stands at ``4 * cell + heading``, where open cells have numbers from 0.
"""

from __future__ import annotations

from typing import NamedTuple

from agents.mapf.kernels.buffers import Buffer, Table, kernel
from agents.mapf.kernels.floor import FAR, NONE

BASE, FURTHER, HEADINGS = 17, 5, 4
"""Bits below the distance of the nearest heading, bits of each difference, and headings."""

MOST_FURTHER, PACKED_FAR = (1 << FURTHER) - 1, (1 << 15) - 1
"""Largest difference, and distance that stands for longer ways and for none."""


ENTRIES = 3
"""Ways into a place: a move and two turns."""


class Way(NamedTuple):
    """Steps that lead to places, and where ``measure_packed`` keeps places that it has reached.

    Attributes:
        turn: cost of a quarter turn.
        behind: ``[places]``, place from which a move leads to each place, or ``NONE``.
        price: ``[places]``, cost of that move.
        entries: ``[(ENTRIES + 1) * places]``, places in buckets.
        below: likewise, entry before each in its bucket, or ``NONE``.
    """

    turn: int
    behind: Table
    price: Table
    entries: Table
    below: Table


@kernel
def pack(field: Table, packed: Table) -> None:
    """Write the distances of ``[cells * 4]`` places into a number for each cell."""
    for cell in range(len(packed)):
        first, nearest = cell * HEADINGS, 0
        for heading in range(1, HEADINGS):
            if field[first + heading] < field[first + nearest]:
                nearest = heading
        least = field[first + nearest] + 0
        number = nearest
        for turned in range(1, HEADINGS):
            further = field[first + (nearest + turned) % HEADINGS] - least
            number += min(further, MOST_FURTHER) << (2 + (turned - 1) * FURTHER)
        number += min(least, PACKED_FAR) << BASE
        packed[cell] = number - ((number >> 31) << 32)  # as a signed number


@kernel
def measure_packed(way: Way, goal: int, heads: Buffer, field: Table, packed: Table) -> None:
    """Write the cost of the cheapest way from each place to a goal into a number for each cell.

    Args:
        way: steps between places.
        goal: number of an open cell, all places of which have the distance 0.
        heads: last entry of each bucket, one more than the highest price, all ``NONE``. The
            buckets are used in turn, as Dial (1969) does.
        field: ``[cells * 4]``, for the distances of places.
        packed: ``[cells]``, the numbers.
    """
    behind, price, entries, below = way.behind, way.price, way.entries, way.below
    for place in range(len(field)):
        field[place] = FAR
    bucket, count, distance = 0, 0, 0
    for place in range(goal * HEADINGS, (goal + 1) * HEADINGS):
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
        for number in range(ENTRIES):
            if number == 0:
                before, cost = behind[place] + 0, price[place] + 0
                if before == NONE:
                    continue
            else:  # a turn to the right or to the left
                before, cost = (place & ~3) + ((place + 2 * number - 3) & 3), way.turn
            if distance + cost < field[before]:
                field[before] = distance + cost
                into = bucket + cost
                if into >= len(heads):
                    into -= len(heads)
                entries[count], below[count], heads[into] = before, heads[into], count
                count, waiting = count + 1, waiting + 1
    pack(field, packed)


@kernel
def unpack(number: int, heading: int) -> int:
    """Return the distance from one of the headings of a packed number."""
    turned = (heading - (number & 3)) & 3
    further = ((number >> 2 << FURTHER) >> (turned * FURTHER)) & MOST_FURTHER
    return ((number >> BASE) & PACKED_FAR) + further
