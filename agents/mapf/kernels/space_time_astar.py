"""Space-time A*: the cheapest path of one robot that avoids the reserved paths of the others.

A *state* is a place at a time. For open-ended paths, each state exists in a second layer for a
robot that has already reached its goal. Steps in this layer cost nothing. Among equally good
states, the one added last is expanded first.

Sources: Silver (2005), Cooperative pathfinding, AIIDE, for space-time A*. Dial (1969), Algorithm
360, for buckets in place of a heap.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.mapf.kernels.buffers import Buffer, Table, buffer, table_of
from agents.mapf.kernels.places import ACTIONS, FAR, NONE, STAY, Places
from warehouse_core.compiled import kernel
from warehouse_core.world.tables import Integers

CLOSED_STEPS = 5
"""Number of steps for which closed cells are expected to stay closed."""

BUCKETS = 4_000
"""Range of costs, from the lower bound up, that a path may have."""

MAX_ENTRIES = 4_000_000
"""Most states that a search may put into buckets."""

KNOWN = 4
SEEN, SPENT, CAME, TIME = range(KNOWN)
"""Fields of the record that a search keeps for each state."""


class Paths(NamedTuple):
    """The paths of ``R`` robots through ``T`` times.

    Attributes:
        times: ``T``.
        is_open: 1 if paths may end before the goal, at the cost of the distance left; 0 if each
            robot has to be at its goal in the end.
        places: ``[R * T]``, the place of each robot at each time.
        reserved: ``[T * size]``, the robot in each cell at each time plus one, or 0.
        costs: ``[R]``, the cost of each path.
        goals: ``[R]``, goal cells.
        rows: ``[R]``, index of the distance field of each goal in the table of fields.
        stays: ``[R]``, 1 for robots that have to stay in the first step.
        closed: cells that no robot can enter in the first ``CLOSED_STEPS`` steps.
        is_closed: ``[size]``, 1 for these cells.
    """

    times: int
    is_open: int
    places: Table
    reserved: Table
    costs: Buffer
    goals: Buffer
    rows: Buffer
    stays: Buffer
    closed: Buffer
    is_closed: Buffer


Routes = Paths
"""Former name of ``Paths``, without which Numba cannot load its cache of earlier kernels."""


class Frontier(NamedTuple):
    """Records of a search for a path. State numbers are ``(layer * T + time) * places + place``.

    Attributes:
        serial: ``[2]``, number of the current search, and number of states expanded in all
            searches.
        known: ``[states * 4]``, for each state: number of the last search that has seen it, cost of
            the path to it, previous state, and its time. They are used together.
        heads: ``[BUCKETS]``, last entry of each bucket, or ``NONE``.
        entries: states in buckets.
        below: previous entry in the same bucket, or ``NONE``.
    """

    serial: Buffer
    known: Table
    heads: Buffer
    entries: Table
    below: Table


def new_routes(floor: Places, robots: int, times: int, is_open: bool) -> Paths:
    """Return the buffers of paths, with nothing reserved."""
    return Paths(
        times=times, is_open=int(is_open), places=new_table(robots * times),
        reserved=new_table(times * floor.size), costs=buffer(robots),
        goals=buffer(robots), rows=buffer(robots), stays=buffer(robots), closed=buffer(0),
        is_closed=buffer(floor.size),
    )  # fmt: skip


def new_frontier(floor: Places, routes: Paths) -> Frontier:
    """Return the buffers for searches of such paths."""
    states = routes.times * floor.closed * (1 + routes.is_open)
    room = min(2 * states, MAX_ENTRIES) + ACTIONS
    return Frontier(
        serial=buffer(2), known=new_table(KNOWN * states), heads=buffer(BUCKETS, NONE),
        entries=new_table(room), below=new_table(room),
    )  # fmt: skip


def new_table(size: int) -> Table:
    """Return a table of zeros."""
    return table_of(np.zeros(size, np.int32))


@kernel
def reserve(floor: Places, routes: Paths, robot: int, holder: int) -> None:
    """Write a number into the reserved cells of a robot's path: the robot's own plus one, or 0."""
    first, size = robot * routes.times, floor.size
    for time in range(routes.times):
        routes.reserved[time * size + floor.cell[routes.places[first + time]]] = holder


def reserve_only(floor: Places, routes: Paths, robots: Integers) -> None:
    """Reserve the paths of some robots, and nothing else."""
    reserved = np.asarray(routes.reserved).reshape(routes.times, floor.size)
    cells = np.asarray(routes.places).reshape(-1, routes.times)[robots] % floor.size
    reserved[:] = 0
    reserved[np.arange(routes.times), cells] = robots[:, None] + 1


@kernel
def free_from(floor: Places, routes: Paths, cell: int) -> int:
    """Return the time from which no other robot is in a cell any more."""
    time = routes.times
    while time > 0 and routes.reserved[(time - 1) * floor.size + cell] == 0:
        time -= 1
    return time


@kernel
def find_route(
    floor: Places, routes: Paths, frontier: Frontier, fields: Table, robot: int, most: int,
    turn: int,
) -> int:  # fmt: skip
    """Write the cheapest path of a robot that avoids all reserved cells, and return its cost.

    Its first place is known, and nothing may be reserved for it. The result is ``NONE`` if each
    path costs more than ``most``. The order of equally good steps is rotated by ``turn`` positions.
    """
    size, closed, near, price = floor.size, floor.closed, floor.near, floor.price
    times, reserved, known, cells = routes.times, routes.reserved, frontier.known, floor.cell
    heads, entries, below = frontier.heads, frontier.entries, frontier.below
    goal, row, start = routes.goals[robot], routes.rows[robot], routes.places[robot * times]
    later, base = times * closed, 0
    is_there = cells[start] == goal or fields[row + start] >= FAR
    free = 0
    if routes.is_open == 0:
        free = free_from(floor, routes, goal) * floor.step
    least = max(fields[row + start], free)
    if routes.is_open == 1 and is_there:
        least, base = 0, later
    last = min(most - least, BUCKETS - 1)
    if last < 0:
        return NONE
    frontier.serial[0] += 1
    serial, count, bucket, last_state = frontier.serial[0], 1, 0, NONE
    entries[0], below[0], heads[0] = base + start, NONE, 0
    first = KNOWN * (base + start)
    known[first + SEEN], known[first + SPENT] = serial, 0
    known[first + CAME], known[first + TIME] = NONE, 0
    while bucket <= last:
        entry = heads[bucket]
        if entry == NONE:
            bucket += 1
            continue
        state, heads[bucket] = entries[entry], below[entry]
        has_arrived = state >= later
        cost, time = known[KNOWN * state + SPENT], known[KNOWN * state + TIME]
        place = state - time * closed - (later if has_arrived else 0)
        cell = cells[place]
        left = 0 if has_arrived else fields[row + place]
        if max(cost + left, free) != least + bucket:
            continue  # a cheaper path there has been found since
        if time == times - 1 if routes.is_open == 1 else cell == goal and cost >= free:
            last_state = state
            break
        if time == times - 1 or count + ACTIONS > len(entries):
            continue
        frontier.serial[1] += 1
        after = (time + 1) * size
        must_stay = time == 0 and routes.stays[robot] == 1
        for number in range(ACTIONS):
            # Waiting is added first, and so expanded last, except at the goal.
            action = STAY if number == 0 else (number + turn) & 3
            if has_arrived:
                action = STAY if number == STAY else number
            if must_stay and action != STAY:
                continue
            to = near[place * ACTIONS + action]
            if to == closed:
                continue
            there = cells[to]
            if reserved[after + there] != 0:
                continue
            if routes.is_closed[there] and time < CLOSED_STEPS and there != cell:
                continue
            other = reserved[time * size + there]
            if other != 0 and other == reserved[after + cell]:
                continue  # the two would swap cells
            reached, total, left = (time + 1) * closed + to, cost, 0
            if has_arrived:
                reached += later
            else:
                total += price[place * ACTIONS + action]
                left = fields[row + to]
                if routes.is_open == 1 and there == goal:
                    reached += later
            entry = KNOWN * reached
            if known[entry + SEEN] == serial and known[entry + SPENT] <= total:
                continue
            level = max(max(total + left, free) - least, bucket)
            if level > last:
                continue
            known[entry + SEEN], known[entry + SPENT] = serial, total
            known[entry + CAME], known[entry + TIME] = state, time + 1
            entries[count], below[count], heads[level] = reached, heads[level], count
            count += 1
    for level in range(last + 1):
        heads[level] = NONE
    if last_state == NONE:
        return NONE
    total, end = least + bucket, times
    state = last_state
    while state != NONE:
        time = known[KNOWN * state + TIME]
        place = state - time * closed - (later if state >= later else 0)
        for moment in range(time, end):
            routes.places[robot * times + moment] = place
        end, state = time, known[KNOWN * state + CAME]
    return total
