"""The robots of a round of PIBT, EPIBT or circulation, in which each chooses its next place.

Places are numbered as in ``graph.py``. The cell of a place is ``place % size``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.mapf.kernels.buffers import Buffer, buffer
from warehouse_core.compiled import kernel

NOBODY = -1
"""Marks a missing robot."""

UNDECIDED = -1
"""Next place of a robot that has not chosen yet."""

SPREAD = 0x9E3779B9
"""Multiplier of a robot's number, which gives each robot other random bits."""


class Robots(NamedTuple):
    """Robots in a round. The shape of a buffer is ``[R]`` unless stated otherwise.

    Attributes:
        size: number of cells.
        places: present places.
        goals: goal cells.
        rows: index of the distance field of each goal in the table of fields.
        order: robots by decreasing priority.
        stays: 1 for robots that have to stay in the first step of a plan.
        chosen: next places, or ``UNDECIDED``. A robot with a next place before a round keeps it.
        stack: robots that wait for a robot they push, or that have yet to choose.
        robot_in: ``[size]``, robot in each cell, or ``NOBODY``.
        is_closed: ``[size]``, 1 for cells that no robot can enter.
        random: ``[1]``, state of the random numbers, not 0. Each round uses one or more of them.
    """

    size: int
    places: Buffer
    goals: Buffer
    rows: Buffer
    order: Buffer
    stays: Buffer
    chosen: Buffer
    stack: Buffer
    robot_in: Buffer
    is_closed: Buffer
    random: Buffer


def robots_of(size: int, robots: int, seed: int | None) -> Robots:
    """Return the buffers of robots for the given number of cells, with nobody in them."""
    return Robots(
        size=size, places=buffer(robots), goals=buffer(robots), rows=buffer(robots),
        order=buffer(robots), stays=buffer(robots), chosen=buffer(robots, UNDECIDED),
        stack=buffer(robots), robot_in=buffer(size, NOBODY), is_closed=buffer(size),
        random=first_random(seed),
    )  # fmt: skip


def first_random(seed: int | None) -> Buffer:
    """Return the initial state of the random numbers for a seed."""
    return buffer(1, int(np.random.default_rng(seed).integers(1, 1 << 32)))


@kernel
def draw(random: Buffer) -> int:
    """Return the next 32-bit random number of Marsaglia's xorshift (2003)."""
    x = random[0]
    x ^= (x << 13) & 0xFFFFFFFF
    x ^= x >> 17
    x ^= (x << 5) & 0xFFFFFFFF
    random[0] = x
    return x


@kernel
def mix(number: int) -> int:
    """Return 32 pseudo-random bits that are a function of a number or an array of numbers."""
    number = ((number ^ (number >> 16)) * 0x45D9F3B) & 0xFFFFFFFF
    number = ((number ^ (number >> 16)) * 0x45D9F3B) & 0xFFFFFFFF
    return number ^ (number >> 16)
