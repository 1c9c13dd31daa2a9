"""Distances from the four headings in a cell to a goal, packed into one number of 32 bits.

A turn is a step, so the distances in a cell differ by no more than a half turn. Bits 0 and 1 are
the nearest heading, the next three times five bits are by how much further the headings clockwise
of it are, and the rest is the distance of the nearest. Before it is packed, the distance of a place
stands at ``4 * cell + heading``, where open cells have numbers from 0.
"""

from __future__ import annotations

from agents.mapf.kernels.buffers import Table, kernel

BASE, FURTHER, HEADINGS = 17, 5, 4
"""Bits below the distance of the nearest heading, bits of each difference, and headings."""

MOST_FURTHER, PACKED_FAR = (1 << FURTHER) - 1, (1 << 15) - 1
"""Largest difference, and distance that stands for longer ways and for none."""


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
def unpack(number: int, heading: int) -> int:
    """Return the distance from one of the headings of a packed number."""
    turned = (heading - (number & 3)) & 3
    further = ((number >> 2 << FURTHER) >> (turned * FURTHER)) & MOST_FURTHER
    return ((number >> BASE) & PACKED_FAR) + further
