"""LNS, large neighborhood search: replan a group of robots, and keep the result if it is no worse.

A neighborhood is a group of random robots, of robots that delay a late one, or of robots that are
near one another. Kinds and sizes of groups that saved more cost per unit of work are chosen more
often (adaptive LNS).

Sources: Li, Chen, Harabor, Stuckey and Koenig (2021), Anytime multi-agent path finding via large
neighborhood search, IJCAI. The weights follow Ropke and Pisinger (2006), An adaptive large
neighborhood search heuristic, Transportation Science 40.
"""

from __future__ import annotations

from time import perf_counter
from typing import NamedTuple

from agents.mapf.kernels.buffers import Buffer, Table, buffer
from agents.mapf.kernels.places import ACTIONS, FAR, NONE, STAY, Places
from agents.mapf.kernels.robots import draw, first_random
from agents.mapf.kernels.space_time_astar import Frontier, Paths, find_route, reserve
from warehouse_core.compiled import kernel

AT_RANDOM, LATE, NEAR = range(3)
"""Kinds of groups: random robots, a late robot and those that delay it, or robots nearby."""

KINDS, SIZES = 3, 4
"""Numbers of kinds and of sizes. The sizes are the powers of 2 from 2 to 16."""

PORTION = 10
"""Number of groups that are replanned between two looks at the clock."""

MOST = 16
"""Largest size of a group."""

WEIGHT, MOST_WEIGHT = 1 << 18, 1 << 26
"""Initial and largest weight of a kind and size. Their sum times 32 random bits fits 64 bits."""

SHARE, FLOOR_SHARE = 10, 20
"""Each result changes a weight by 1/10, and no weight falls below 1/20 of the largest."""


class Groups(NamedTuple):
    """Buffers of the search, for ``R`` robots and paths of ``T`` times.

    Attributes:
        members: ``[MOST + 1]``, the robots of a group. The last entry is their number.
        is_in: ``[R]``, 1 for robots in the group, and for robots that no group replans.
        saved: ``[MOST * T]``, the previous paths of the group.
        costs: ``[MOST]``, costs of the new paths of the group.
        weights: ``[KINDS * SIZES]``, probability weight of each kind and size.
        random: ``[1]``, state of the random numbers, not 0.
    """

    members: Buffer
    is_in: Buffer
    saved: Buffer
    costs: Buffer
    weights: Buffer
    random: Buffer


def new_groups(robots: int, times: int, seed: int | None) -> Groups:
    """Return the buffers of a search."""
    return Groups(
        members=buffer(MOST + 1), is_in=buffer(robots), saved=buffer(MOST * times),
        costs=buffer(MOST), weights=buffer(KINDS * SIZES, WEIGHT),
        random=first_random(seed),
    )  # fmt: skip


@kernel
def join(groups: Groups, robot: int, size: int) -> bool:
    """Add a robot to the group unless it is a member; return whether the group is complete."""
    if groups.members[MOST] < size and groups.is_in[robot] == 0:
        groups.members[groups.members[MOST]] = robot
        groups.members[MOST] += 1
        groups.is_in[robot] = 1
    return groups.members[MOST] >= size


@kernel
def delay(routes: Paths, fields: Table, robot: int) -> int:
    """Return how much more the path of a robot costs than its cheapest path."""
    left = fields[routes.rows[robot] + routes.places[robot * routes.times]]
    return 0 if left >= FAR else routes.costs[robot] - left


@kernel
def delay_of_all(routes: Paths, fields: Table) -> int:
    """Return how much more the paths of all robots cost than their cheapest paths."""
    whole = 0
    for robot in range(len(routes.costs)):
        whole += delay(routes, fields, robot)
    return whole


@kernel
def gather_late(floor: Places, routes: Paths, groups: Groups, fields: Table, size: int) -> None:
    """Gather the most delayed of eight random robots, and robots that delay it.

    The latter are those that block random walks which would bring it to its goal sooner.
    """
    times, random, near = routes.times, groups.random, floor.near
    robot = draw(random) % len(routes.costs)
    for _ in range(7):
        other = draw(random) % len(routes.costs)
        if delay(routes, fields, other) > delay(routes, fields, robot):
            robot = other
    goal_row, cost = routes.rows[robot], routes.costs[robot]
    join(groups, robot, size)
    for _ in range(4 * size):
        time = draw(random) % times
        if time * floor.step > cost:
            time = draw(random) % (cost // floor.step + 1)
        place = routes.places[robot * times + time]
        while time + 1 < times:
            action, to = draw(random) % ACTIONS, floor.closed
            for turn in range(ACTIONS):
                to = near[place * ACTIONS + (action + turn) % ACTIONS]
                if to != floor.closed:
                    if (time + 1) * floor.step + fields[goal_row + to] < cost:
                        break
                    to = floor.closed
            if to == floor.closed:
                break
            cell, after = to % floor.size, (time + 1) * floor.size
            holder = routes.reserved[after + cell]
            if holder == 0:
                other = routes.reserved[time * floor.size + cell]
                if other != 0 and other == routes.reserved[after + place % floor.size]:
                    holder = other
            if 0 < holder <= len(routes.costs) and join(groups, holder - 1, size):
                return
            place, time = to, time + 1


@kernel
def gather_near(floor: Places, routes: Paths, groups: Groups, size: int) -> None:
    """Gather robots that pass near a random place of one robot at about the same time."""
    times, random = routes.times, groups.random
    robot = draw(random) % len(routes.costs)
    join(groups, robot, size)
    span = min(times - 1, routes.costs[robot] // floor.step)
    time = draw(random) % (span + 1)
    first = routes.places[robot * times + time]
    for _ in range(size):
        place = first
        for _ in range(16):
            cell = place % floor.size
            for late in range(-2, 3):
                if 0 <= time + late < times:
                    holder = routes.reserved[(time + late) * floor.size + cell]
                    if 0 < holder <= len(routes.costs) and join(groups, holder - 1, size):
                        return
            to = floor.near[place * ACTIONS + draw(random) % STAY]
            if to != floor.closed:
                place = to


@kernel
def gather(
    floor: Places, routes: Paths, groups: Groups, fields: Table, kind: int, size: int
) -> None:
    """Gather a group of at most ``size`` robots, in random order."""
    members, random, robots = groups.members, groups.random, len(routes.costs)
    members[MOST] = 0
    free = robots
    for robot in range(robots):
        free -= groups.is_in[robot]
    size = min(size, free)
    if size == 0:
        return
    if kind == LATE:
        gather_late(floor, routes, groups, fields, size)
    elif kind == NEAR:
        gather_near(floor, routes, groups, size)
    else:
        while not join(groups, draw(random) % robots, size):
            pass
    for at in range(members[MOST]):
        groups.is_in[members[at]] = 0
    for at in range(members[MOST] - 1, 0, -1):
        other = draw(random) % (at + 1)
        members[at], members[other] = members[other], members[at]


@kernel
def plan_anew(
    floor: Places, routes: Paths, frontier: Frontier, groups: Groups, fields: Table
) -> int:
    """Replan the robots of the group one after the other, and return the cost saved, 0 or more."""
    members, saved, times, costs = groups.members, groups.saved, routes.times, routes.costs
    number, left, least, done = members[MOST], 0, 0, 0
    for at in range(number):
        left += costs[members[at]]
        least += costs[members[at]] - delay(routes, fields, members[at])
    if left == least:
        return 0  # nobody is late
    for at in range(number):
        robot = members[at]
        reserve(floor, routes, robot, 0)
        for time in range(times):
            saved[at * times + time] = routes.places[robot * times + time]
    while done < number:
        robot = members[done]
        least -= costs[robot] - delay(routes, fields, robot)
        turn = draw(groups.random) & 3
        cost = find_route(floor, routes, frontier, fields, robot, left - least, turn)
        if cost == NONE:
            break
        left, groups.costs[done] = left - cost, cost
        reserve(floor, routes, robot, robot + 1)
        done += 1
    if done == number:
        for at in range(number):
            costs[members[at]] = groups.costs[at]
        return left
    for at in range(done):
        reserve(floor, routes, members[at], 0)
    for at in range(number):
        robot = members[at]
        for time in range(times):
            routes.places[robot * times + time] = saved[at * times + time]
        reserve(floor, routes, robot, robot + 1)
    return 0


@kernel
def renew(
    floor: Places, routes: Paths, frontier: Frontier, groups: Groups, fields: Table, robots: Buffer
) -> None:
    """Replan some robots, each as a group of its own."""
    for robot in robots:
        groups.members[0], groups.members[MOST] = robot, 1
        plan_anew(floor, routes, frontier, groups, fields)


@kernel
def improve(
    floor: Places, routes: Paths, frontier: Frontier, groups: Groups, fields: Table, trials: int
) -> None:
    """Choose and replan ``trials`` groups."""
    weights = groups.weights
    for _ in range(trials):
        most = 0
        for arm in range(KINDS * SIZES):
            most = max(most, weights[arm])
        whole = 0
        for arm in range(KINDS * SIZES):
            weights[arm] = max(weights[arm], most // FLOOR_SHARE + 1)
            whole += weights[arm]
        chance, arm = draw(groups.random) * whole >> 32, 0
        while chance >= weights[arm]:
            chance -= weights[arm]
            arm += 1
        gather(floor, routes, groups, fields, arm % KINDS, 2 << arm // KINDS)
        before = frontier.serial[1]
        gained = plan_anew(floor, routes, frontier, groups, fields)
        work = max(frontier.serial[1] - before + groups.members[MOST] * routes.times, 1)
        weights[arm] += (min((gained << 24) // work, MOST_WEIGHT) - weights[arm]) // SHARE


def improve_until(
    floor: Places, routes: Paths, frontier: Frontier, groups: Groups, fields: Table,
    deadline: float, trials: float,
) -> int:  # fmt: skip
    """Replan ``trials`` groups or stop at a ``perf_counter`` deadline; return the number.

    It stops at once when no robot is late, because no plan is better then.
    """
    tried = 0
    while tried < trials and perf_counter() < deadline and delay_of_all(routes, fields):
        number = int(min(PORTION, trials - tried))
        improve(floor, routes, frontier, groups, fields, number)
        tried += number
    return tried
