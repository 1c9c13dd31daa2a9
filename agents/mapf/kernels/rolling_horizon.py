"""Rolling horizon: paths of all robots through a window, with a round for each step.

Each round runs PIBT, EPIBT or a circulation. A robot that reaches its goal gives way from
then on, since its next goal is unknown. All three functions take the same arguments: the robots,
the state of the algorithm, the distance fields, and the first and last time.
"""

from __future__ import annotations

from agents.mapf.kernels.auction import Auction
from agents.mapf.kernels.auction import choose as choose_by_circulation
from agents.mapf.kernels.buffers import Table
from agents.mapf.kernels.epibt import Epibt
from agents.mapf.kernels.epibt import choose as choose_by_epibt
from agents.mapf.kernels.pibt import Pibt
from agents.mapf.kernels.pibt import choose as choose_by_pibt
from agents.mapf.kernels.places import ACTIONS, FAR, NONE, STAY, Places
from agents.mapf.kernels.robots import NOBODY, UNDECIDED, Robots
from agents.mapf.kernels.space_time_astar import CLOSED_STEPS, Paths
from warehouse_core.compiled import kernel


@kernel
def route_cost(floor: Places, routes: Paths, fields: Table, robot: int) -> int:
    """Return the cost of a path up to the goal; if it ends elsewhere, add the distance left."""
    first, row, goal = robot * routes.times, routes.rows[robot], routes.goals[robot]
    cost, place = 0, routes.places[first]
    if fields[row + place] >= FAR:
        return 0
    for time in range(1, routes.times):
        if place % floor.size == goal:
            return cost
        after = routes.places[first + time]
        for action in range(ACTIONS):
            if floor.near[place * ACTIONS + action] == after:
                cost += floor.price[place * ACTIONS + action]
                break
        place = after
    return cost + fields[row + place]


@kernel
def place_robots(routes: Paths, robots: Robots, time: int) -> None:
    """Place the robots where their paths are at a time."""
    for robot in range(len(robots.places)):
        robots.places[robot] = routes.places[robot * routes.times + time]


@kernel
def begin_step(routes: Paths, robots: Robots, time: int) -> None:
    """Reset the choices of the robots before a step, and close cells early in the window."""
    for robot in range(len(robots.places)):
        place, stays = robots.places[robot], time == 0 and robots.stays[robot] == 1
        robots.robot_in[place % robots.size] = robot
        robots.chosen[robot] = place if stays else UNDECIDED
    for cell in routes.closed:
        robots.is_closed[cell] = time < CLOSED_STEPS


@kernel
def end_step(routes: Paths, robots: Robots, time: int) -> None:
    """Move robots to the places that they have chosen, and write these into their paths."""
    for robot in range(len(robots.places)):
        robots.robot_in[robots.places[robot] % robots.size] = NOBODY
    for robot in range(len(robots.places)):
        robots.places[robot] = robots.chosen[robot]
        routes.places[robot * routes.times + time + 1] = robots.chosen[robot]
    for cell in routes.closed:
        robots.is_closed[cell] = 1
    # Robots that are at their goals come last.
    order, spare, count, rest = robots.order, robots.stack, 0, 0
    for at in range(len(order)):
        robot = order[at]
        if robots.places[robot] % robots.size == robots.goals[robot]:
            spare[rest] = robot
            rest += 1
        else:
            order[count] = robot
            count += 1
    for at in range(rest):
        order[count + at] = spare[at]


@kernel
def roll_pibt(
    floor: Places, routes: Paths, robots: Robots, pibt: Pibt, fields: Table, first: int, last: int
) -> None:
    """Write the places at the times ``first + 1`` to ``last``, with a round of PIBT for each step.

    Robots that have to stay do so in the step from time 0. The initial order of the robots is their
    order at the time ``first``.
    """
    place_robots(routes, robots, first)
    for time in range(first, last):
        begin_step(routes, robots, time)
        choose_by_pibt(floor, robots, pibt, fields)
        end_step(routes, robots, time)


@kernel
def roll_epibt(
    floor: Places, routes: Paths, robots: Robots, epibt: Epibt, fields: Table, first: int,
    last: int,
) -> None:  # fmt: skip
    """Do the same as ``roll_pibt`` with a round of EPIBT for each step."""
    place_robots(routes, robots, first)
    for time in range(first, last):
        begin_step(routes, robots, time)
        choose_by_epibt(robots, epibt, fields)
        end_step(routes, robots, time)


@kernel
def roll_circulation(
    floor: Places, routes: Paths, robots: Robots, auction: Auction, fields: Table, first: int,
    last: int,
) -> None:  # fmt: skip
    """Do the same as ``roll_pibt`` with a circulation for each step.

    A robot that has been at its goal by the time ``first`` has no reason to move from then on.
    """
    place_robots(routes, robots, first)
    for robot in range(len(robots.places)):
        auction.targets[robot], auction.is_there[robot], auction.actions[robot] = NONE, 0, STAY
        for time in range(first + 1):
            place = routes.places[robot * routes.times + time]
            if place % robots.size == robots.goals[robot]:
                auction.is_there[robot] = 1
    for time in range(first, last):
        begin_step(routes, robots, time)
        choose_by_circulation(robots, auction, fields)
        end_step(routes, robots, time)


@kernel
def write_costs(floor: Places, routes: Paths, fields: Table) -> int:
    """Write the costs of all paths, and return their sum."""
    total = 0
    for robot in range(len(routes.costs)):
        routes.costs[robot] = route_cost(floor, routes, fields, robot)
        total += routes.costs[robot]
    return total
