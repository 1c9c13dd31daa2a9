"""Loops over the robots of fleets, which replace NumPy in ``FleetEngine`` if Numba is installed.

``N`` is the number of robots on ``B`` floors. The rules are tables of ``verdicts.py``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warehouse_core.compiled import Block, Matrix, Vector, kernel
from warehouse_core.world.actions import WAIT
from warehouse_core.world.moves import FORWARD, TURN_ACTIONS

TURN_WAIT = TURN_ACTIONS.index("WAIT")

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
        sides: number of each cell's open sides, see ``verdicts.sides_number``.
        codes: code of each spot below robots and people.
        ends: ``[2, N]`` cells of the pickup and the dropoff of each robot's order, or ``NO_CELL``.
        under: ``[N]`` index into ``STATION_KINDS`` of each robot's cell; see ``find_stations``.
        has_orders: ``True`` if orders determine the stations.
    """

    base: Vector[np.intp]
    corner: Vector[np.intp]
    spots: Vector[np.int32]
    tiles: Vector[np.int16]
    stations: Vector[np.int16]
    sides: Vector[np.uint8]
    codes: Vector[np.uint8]
    ends: Matrix[np.intp]
    under: Vector[np.int16]
    has_orders: bool


class Verdicts(NamedTuple):
    """The verdicts of ``task/rules.py`` by number; see ``verdicts.verdict_numbers``.

    Attributes:
        stations: number of ``STATION_KINDS``.
        rewards, has_item, delivered, charges: fields of each verdict.
        masks: flags of actions with an effect, by sides, station and item.
    """

    stations: int
    rewards: Vector[np.float64]
    has_item: Vector[np.bool_]
    delivered: Vector[np.bool_]
    charges: Vector[np.bool_]
    masks: Matrix[np.int8]


class Kinds(NamedTuple):
    """The kinds of steps that ``Tally`` counts, and its sums.

    Attributes:
        by_action: kind of each action.
        by_obstacle: kind of a blocked move for each ``stopped_by``.
        waited, busy, charged, ended: kinds, see ``tally.MOVED``.
        counts: ``[N, kinds]`` steps of each kind.
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
    counts: Matrix[np.int64]
    joules: Vector[np.float64]
    seconds: Vector[np.float64]
    deliveries: Vector[np.int64]


class Fleets(NamedTuple):
    """The state of ``FleetEngine``, which ``judge_robots`` changes.

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


class Views(NamedTuple):
    """What robots see, with codes as in ``CELL_CODES``; see ``FleetFloor``.

    Attributes:
        radius: cells seen in each direction.
        windows: ``[cells, K * K]`` window around each cell without anything on top of the tiles.
        places, chargers: ``[cells, 2]`` row and column of each cell and of its nearest charger.
        strides: ``[N]`` offset from a spot to the spot below it on each robot's floor.
        on_top: code of each spot.
        covered: spots with robots, and then with people.
        stations: ``[2, N, 2]`` row and column of each robot's pickup and dropoff.
        robots, others: codes of the robot itself and of others, without and with an item.
        codes: codes of a pickup and a dropoff.
        person: code of a person.
        is_bare: ``True`` if nothing is on top of the tiles.
        floors, corners: ``[B]`` first cell and first spot of each floor.
    """

    radius: int
    windows: Matrix[np.uint8]
    places: Matrix[np.int32]
    chargers: Matrix[np.int32]
    strides: Vector[np.intp]
    on_top: Vector[np.uint8]
    covered: Vector[np.intp]
    stations: Block[np.int32]
    robots: Vector[np.uint8]
    others: Vector[np.uint8]
    codes: Vector[np.uint8]
    person: int
    is_bare: bool
    floors: Vector[np.intp]
    corners: Vector[np.intp]


class Seen(NamedTuple):
    """The fields of ``FleetArrays``. Those that a fleet does not have are empty by default."""

    local_grid: Matrix[np.uint8]
    robot_pos: Matrix[np.int32]
    has_item: Vector[np.int64]
    battery: Matrix[np.int32]
    steps: Matrix[np.int32]
    pickup_pos: Matrix[np.int32]
    dropoff_pos: Matrix[np.int32]
    heading: Vector[np.int64] = np.empty(0, np.int64)
    due: Matrix[np.int32] = np.empty((0, 1), np.int32)
    charger_pos: Matrix[np.int32] = np.empty((0, 2), np.int32)


@kernel
def find_stations(ground: Ground, cells: Vector[np.intp]) -> None:
    """Set the kind of each robot's cell for this robot."""
    base, corner, spots, codes = ground.base, ground.corner, ground.spots, ground.codes
    if not ground.has_orders:
        for robot in range(len(cells)):
            ground.under[robot] = ground.tiles[base[robot] + cells[robot]]
        return
    for robot in range(len(cells)):
        cell = cells[robot]
        own = 1 if cell == ground.ends[0, robot] else 0
        own += 2 if cell == ground.ends[1, robot] else 0
        spot = corner[robot] + spots[base[robot] + cell]
        ground.under[robot] = own | int(ground.stations[codes[spot]])


@kernel
def judge_robots(
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
    find_stations(ground, motions.cells)
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
                station = int(ground.under[robot])
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
            kinds.counts[robot, did] += 1
            kinds.joules[robot] += motions.joules[robot]
            longest = max(longest, motions.seconds[robot])
            events[robot] = event
            every |= event
        kinds.seconds[floor] += longest
    return every


@kernel
def mask_all(
    fleets: Fleets,
    ground: Ground,
    verdicts: Verdicts,
    cells: Vector[np.intp],
    headings: Vector[np.intp],
    masks: Matrix[np.int8],
) -> None:
    """Fill in the masks ``[N, 7]``, or ``[N, 6]`` for robots with headings."""
    find_stations(ground, cells)
    for robot in range(len(cells)):
        sides = int(ground.sides[ground.base[robot] + cells[robot]])
        row = sides * verdicts.stations + int(ground.under[robot])
        row = row * 2 + (1 if fleets.has_item[robot] else 0)
        for action in range(masks.shape[1]):
            if len(headings) == 0:
                masks[robot, action] = verdicts.masks[row, action]
            elif action == FORWARD:
                masks[robot, action] = verdicts.masks[row, headings[robot]]
            elif action < TURN_WAIT:
                masks[robot, action] = 1
            else:
                masks[robot, action] = verdicts.masks[row, action - TURN_WAIT + WAIT]


@kernel
def show_all(
    fleets: Fleets, ground: Ground, views: Views, cells: Vector[np.intp], people: Matrix[np.intp]
) -> None:
    """Show robots and people in their cells, and nothing in the cells that they have left."""
    on_top, covered, count = views.on_top, views.covered, len(cells)
    for place in range(len(covered)):
        on_top[covered[place]] = ground.codes[covered[place]]
    for robot in range(count):
        spot = ground.corner[robot] + ground.spots[ground.base[robot] + cells[robot]]
        covered[robot] = spot
        on_top[spot] = views.others[1 if fleets.has_item[robot] else 0]
    for floor in range(people.shape[0]):
        for person in range(people.shape[1]):
            spot = views.corners[floor] + ground.spots[views.floors[floor] + people[floor, person]]
            covered[count] = spot
            on_top[spot] = views.person
            count += 1


@kernel
def look_around(
    ground: Ground,
    views: Views,
    cells: Vector[np.intp],
    rows: Vector[np.intp],
    windows: Matrix[np.uint8],
) -> None:
    """Fill in the windows ``[M, K * K]`` of some robots, except for the robots in the middle."""
    radius, side, stations = views.radius, 2 * views.radius + 1, views.stations
    on_top, tiles, strides, covered = views.on_top, views.windows, views.strides, views.covered
    base, places, codes, ends = ground.base, views.places, views.codes, 0
    if ground.has_orders:
        ends = len(codes)
    if views.is_bare:
        for at in range(len(rows)):
            number = base[rows[at]] + cells[rows[at]]
            for place in range(windows.shape[1]):
                windows[at, place] = tiles[number, place]
        return
    for at in range(len(rows)):
        robot = rows[at]
        number, stride = base[robot] + cells[robot], strides[robot]
        corner = covered[robot] - radius * (stride + 1)
        for down in range(side):
            for right in range(side):
                place = down * side + right
                code, tile = on_top[corner + down * stride + right], tiles[number, place]
                windows[at, place] = code if code > tile else tile
        for end in range(ends):  # these tiles are below everything on top, but above the floor
            down = stations[end, robot, 0] - places[number, 0] + radius
            right = stations[end, robot, 1] - places[number, 1] + radius
            if stations[end, robot, 0] >= 0 and 0 <= down < side and 0 <= right < side:
                code, tile = on_top[corner + down * stride + right], codes[end]
                windows[at, down * side + right] = code if code > tile else tile


@kernel
def observe_all(
    fleets: Fleets,
    ground: Ground,
    views: Views,
    cells: Vector[np.intp],
    due: Vector[np.int32],
    headings: Vector[np.intp],
    rows: Vector[np.intp],
    seen: Seen,
) -> None:
    """Fill in the observations of some robots, after ``show_all``.

    Args:
        fleets: state of the robots.
        ground: stations of the floors.
        views: tables of what robots see.
        cells: ``[N]`` cells of the robots.
        due: ``[N]`` steps by which orders are due.
        headings: ``[N]`` headings.
        rows: ``[M]`` rows of the observed robots.
        seen: ``[M]`` observations, to be filled in.
    """
    look_around(ground, views, cells, rows, seen.local_grid)
    base, places, stations = ground.base, views.places, views.stations
    middle = seen.local_grid.shape[1] // 2
    for at in range(len(rows)):
        robot = rows[at]
        number = base[robot] + cells[robot]
        has_item = 1 if fleets.has_item[robot] else 0
        seen.local_grid[at, middle] = views.robots[has_item]
        seen.has_item[at] = has_item
        seen.battery[at, 0] = int(fleets.battery[robot])
        seen.steps[at, 0] = fleets.steps[robot // fleets.robots]
        for part in range(2):
            seen.robot_pos[at, part] = places[number, part]
            seen.pickup_pos[at, part] = stations[0, robot, part]
            seen.dropoff_pos[at, part] = stations[1, robot, part]
    for at in range(len(seen.charger_pos)):
        number = base[rows[at]] + cells[rows[at]]
        seen.charger_pos[at, 0] = views.chargers[number, 0]
        seen.charger_pos[at, 1] = views.chargers[number, 1]
    for at in range(len(seen.due)):
        seen.due[at, 0] = due[rows[at]]
    for at in range(len(seen.heading)):
        seen.heading[at] = headings[rows[at]]
