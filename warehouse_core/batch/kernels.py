"""Loops over the robots of fleets, which replace NumPy in ``FleetEngine`` if Numba is installed.

``N`` is the number of robots on ``B`` floors. The rules are tables of ``verdicts.py``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warehouse_core.compiled import Vector, kernel

PICKED, DELIVERED, CHARGES, OUT, OVER = (1 << place for place in range(5))
"""Events of a robot in a step, and of the step if any robot has them.

``OUT`` is a robot that can no longer drive, unless it still charges. ``OVER`` is a floor that has
reached the limit of steps.
"""


class Ground(NamedTuple):
    """What the cells of ``FleetFloor`` are to the robots.

    Attributes:
        base: ``[N]`` index in the tables of the first cell of each robot's layout.
        corner: ``[N]`` first spot of each robot's floor.
        spots: spot of each cell on its floor.
        tiles: index into ``STATION_KINDS`` of each cell's tile.
        stations: index into ``STATION_KINDS`` of each code.
        codes: code of each spot below robots and people.
        pickups, dropoffs: ``[N]`` cells of each robot's order, or ``NO_CELL``.
        has_orders: ``True`` if orders determine the stations.
    """

    base: Vector[np.intp]
    corner: Vector[np.intp]
    spots: Vector[np.int32]
    tiles: Vector[np.int16]
    stations: Vector[np.int16]
    codes: Vector[np.uint8]
    pickups: Vector[np.intp]
    dropoffs: Vector[np.intp]
    has_orders: bool


class Verdicts(NamedTuple):
    """The verdicts of ``task/rules.py`` by number; see ``verdicts.verdict_numbers``."""

    stations: int
    rewards: Vector[np.float64]
    has_item: Vector[np.bool_]
    delivered: Vector[np.bool_]
    charges: Vector[np.bool_]


class Kinds(NamedTuple):
    """The kinds of steps that ``Tally`` counts, and its sums.

    Attributes:
        by_action: kind of each action.
        by_obstacle: kind of a blocked move for each ``stopped_by``.
        waited, busy, charged, ended: kinds, see ``tally.MOVED``.
        number: number of kinds.
        counts: ``[N * number]`` steps of each kind.
        joules: ``[N]`` energy of all motions.
        seconds: ``[B]`` simulated time.
        deliveries: ``[B]`` number of deliveries.
    """

    by_action: Vector[np.intp]
    by_obstacle: Vector[np.intp]
    waited: int
    busy: int
    charged: int
    ended: int
    number: int
    counts: Vector[np.int64]
    joules: Vector[np.float64]
    seconds: Vector[np.float64]
    deliveries: Vector[np.int64]


class Fleets(NamedTuple):
    """The state of ``FleetEngine``, which ``judge_all`` changes.

    Attributes:
        robots: number of robots on each floor.
        max_steps: limit of an episode.
        costs_joules: ``True`` if steps cost the energy of their motion, otherwise one unit.
        steps: ``[B]`` steps taken.
        has_item: ``[N]`` flags of robots that hold an item.
        battery: ``[N]`` units left.
        ended, failed: ``[N]`` flags of robots; see ``FleetEngine``.
    """

    robots: int
    max_steps: int
    costs_joules: bool
    steps: Vector[np.int32]
    has_item: Vector[np.bool_]
    battery: Vector[np.float64]
    ended: Vector[np.bool_]
    failed: Vector[np.bool_]


class Motions(NamedTuple):
    """The fields of a ``BatchOutcome``; ``driving`` is empty if all robots are at rest."""

    cells: Vector[np.intp]
    blocked: Vector[np.bool_]
    seconds: Vector[np.float64]
    joules: Vector[np.float64]
    stopped_by: Vector[np.intp]
    driving: Vector[np.bool_]


@kernel
def station_at(ground: Ground, robot: int, cell: int) -> int:
    """Return the kind of a cell for a robot, as an index into ``STATION_KINDS``."""
    number = ground.base[robot] + cell
    if not ground.has_orders:
        return int(ground.tiles[number])
    code = ground.codes[ground.corner[robot] + ground.spots[number]]
    own = (1 if cell == ground.pickups[robot] else 0) + (2 if cell == ground.dropoffs[robot] else 0)
    return own | int(ground.stations[code])


@kernel
def judge_all(
    fleets: Fleets,
    ground: Ground,
    verdicts: Verdicts,
    kinds: Kinds,
    motions: Motions,
    actions: Vector[np.intp],
    judged: Vector[np.intp],
    rewards: Vector[np.float64],
    events: Vector[np.uint8],
) -> int:
    """Apply the rules to each robot in its new cell, except for charging, and count the step.

    Args:
        fleets: state of the robots, which is changed.
        ground: stations of the floors.
        verdicts: tables of the rules.
        kinds: sums, which are changed.
        motions: outcome of the motion.
        actions: ``[N]`` actions of the robots.
        judged: ``[N]`` index in ``ACTIONS`` as which each action counts.
        rewards: ``[N]`` rewards, to be filled in.
        events: ``[N]`` events of the robots, to be filled in.

    Returns:
        All events together.
    """
    every = 0
    for floor in range(len(fleets.steps)):
        fleets.steps[floor] += 1
        if fleets.steps[floor] >= fleets.max_steps:
            every |= OVER
        longest = 0.0
        for robot in range(floor * fleets.robots, (floor + 1) * fleets.robots):
            has_ended, is_blocked = fleets.ended[robot], motions.blocked[robot]
            is_driving = len(motions.driving) > 0 and motions.driving[robot]
            had_item, station = fleets.has_item[robot], 0
            if not is_driving:
                station = station_at(ground, robot, motions.cells[robot])
            number = judged[robot] * verdicts.stations + station
            number = (number * 2 + (1 if had_item else 0)) * 2 + (1 if is_blocked else 0)
            rewards[robot] = 0.0 if has_ended else verdicts.rewards[number]
            fleets.has_item[robot] = verdicts.has_item[number]
            event = PICKED if verdicts.has_item[number] and not had_item else 0
            did = kinds.by_action[actions[robot]]
            if is_driving and did == kinds.waited:
                did = kinds.busy
            if verdicts.delivered[number]:
                event |= DELIVERED
                kinds.deliveries[floor] += 1
            if not has_ended:
                units = motions.joules[robot] if fleets.costs_joules else 1.0
                fleets.battery[robot] -= units
            if verdicts.charges[number] and not has_ended:
                event |= CHARGES
                did = kinds.charged
            elif fleets.battery[robot] <= 0.0:
                fleets.battery[robot] = 0.0  # the last step may cost more than is left
                event |= OUT
            if fleets.failed[robot]:
                event |= OUT
            if is_blocked:
                did = kinds.by_obstacle[motions.stopped_by[robot]]
            if has_ended:
                did = kinds.ended
            kinds.counts[robot * kinds.number + did] += 1
            kinds.joules[robot] += motions.joules[robot]
            longest = max(longest, motions.seconds[robot])
            events[robot] = event
            every |= event
        kinds.seconds[floor] += longest
    return every
