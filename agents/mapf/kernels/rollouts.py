"""Ways of all robots by rounds of PIBT or EPIBT, or by circulations, for windows of lifelong plans.

A robot that reaches its goal gives way from then on, since its next goal is not known.
"""

from __future__ import annotations

from agents.mapf.kernels.buffers import Buffer, Table, kernel
from agents.mapf.kernels.circulation import Crowd, circulate, stand
from agents.mapf.kernels.floor import ACTIONS, FAR, Floor
from agents.mapf.kernels.operations import CHOSEN as HAS_CHOSEN
from agents.mapf.kernels.operations import FREE, Crew, plan
from agents.mapf.kernels.rounds import CHOSEN, CLOSED, NOBODY, UNDECIDED, Team, choose
from agents.mapf.kernels.ways import CLOSED_STEPS, Ways


@kernel
def price_of_way(floor: Floor, ways: Ways, fields: Table, robot: int) -> int:
    """Return the cost of the way of a robot: until it is at its goal, or plus the distance left."""
    first, row, goal = robot * ways.times, ways.rows[robot], ways.goals[robot]
    cost, place = 0, ways.places[first] + 0
    if fields[row + place] >= FAR:
        return 0
    for time in range(1, ways.times):
        if place % floor.size == goal:
            return cost
        after = ways.places[first + time] + 0
        for action in range(ACTIONS):
            if floor.near[place * ACTIONS + action] == after:
                cost += floor.price[place * ACTIONS + action]
                break
        place = after
    return cost + fields[row + place]


@kernel
def roll(floor: Floor, ways: Ways, team: Team, fields: Table, first: int, last: int) -> None:
    """Write the places at the times after ``first`` to ``last``, by a round of PIBT each.

    The robots of ``ways.stays`` stay in the step from the time 0. The order of the team is that at
    the time ``first``.
    """
    robots, times, size = len(team.goals), ways.times, floor.size
    here = team.places
    for robot in range(robots):
        here[robot] = ways.places[robot * times + first]
        team.goals[robot], team.rows[robot] = ways.goals[robot], ways.rows[robot]
    for time in range(first, last):
        for robot in range(robots):
            team.robot_in[here[robot] % size] = robot
            team.chosen[robot] = UNDECIDED
        if time < CLOSED_STEPS:
            for cell in ways.closed:
                team.is_taken[cell] = CLOSED
        for robot in range(robots):
            if time == 0 and ways.stays[robot] == 1:
                team.chosen[robot] = here[robot]
                team.is_taken[here[robot] % size] = CHOSEN
        choose(floor, team, fields)
        for cell in ways.closed:
            team.is_taken[cell] = 0
        for robot in range(robots):
            team.robot_in[here[robot] % size] = NOBODY
        for robot in range(robots):
            here[robot] = team.chosen[robot]
            team.is_taken[here[robot] % size] = 0
            ways.places[robot * times + time + 1] = here[robot]
        lower(team.order, here, ways.goals, team.stack, size)


@kernel
def roll_crew(ways: Ways, crew: Crew, fields: Table, first: int, last: int) -> None:
    """Do as ``roll`` by a round of EPIBT for each step."""
    robots, times, size = len(ways.goals), ways.times, crew.size
    for robot in range(robots):
        crew.places[robot] = ways.places[robot * times + first]
        crew.rows[robot] = ways.rows[robot]
    for time in range(first, last):
        for robot in range(robots):
            crew.robot_in[crew.places[robot] % size] = robot
            is_fixed = time == 0 and ways.stays[robot] == 1
            crew.states[robot] = HAS_CHOSEN if is_fixed else FREE
        for cell in ways.closed:
            crew.is_closed[cell] = time < CLOSED_STEPS
        for at in range(len(crew.holder)):
            crew.holder[at] = NOBODY
        plan(crew, fields)
        for cell in ways.closed:
            crew.is_closed[cell] = 0
        for robot in range(robots):
            crew.robot_in[crew.places[robot] % size] = NOBODY
        for robot in range(robots):
            crew.places[robot] = crew.ways[robot * crew.window]
            ways.places[robot * times + time + 1] = crew.places[robot]
        lower(crew.order, crew.places, ways.goals, crew.stack, size)


@kernel
def roll_crowd(ways: Ways, crowd: Crowd, fields: Table, first: int, last: int) -> None:
    """Do as ``roll`` by a circulation for each step.

    A robot that has been at its goal until the time ``first`` goes nowhere from then on.
    """
    for robot in range(len(ways.goals)):
        crowd.here[robot] = ways.places[robot * ways.times + first]
    stand(crowd)
    for robot in range(len(ways.goals)):
        for time in range(first + 1):
            if ways.places[robot * ways.times + time] % crowd.size == ways.goals[robot]:
                crowd.is_there[robot] = 1
    for time in range(first, last):
        for cell in ways.closed:
            crowd.is_closed[cell] = time < CLOSED_STEPS
        circulate(crowd, fields, time == 0)
        for robot in range(len(ways.goals)):
            ways.places[robot * ways.times + time + 1] = crowd.places[robot]
    for cell in ways.closed:
        crowd.is_closed[cell] = 0


@kernel
def lower(order: Buffer, places: Buffer, goals: Buffer, spare: Buffer, size: int) -> None:
    """Put the robots that are at their goals last, else in the order of before."""
    count, rest = 0, 0
    for at in range(len(order)):
        robot = order[at]
        if places[robot] % size == goals[robot]:
            spare[rest] = robot
            rest += 1
        else:
            order[count] = robot
            count += 1
    for at in range(rest):
        order[count + at] = spare[at]


@kernel
def prices(floor: Floor, ways: Ways, fields: Table) -> int:
    """Write the costs of all ways, and return their sum."""
    total = 0
    for robot in range(len(ways.costs)):
        ways.costs[robot] = price_of_way(floor, ways, fields, robot)
        total += ways.costs[robot] * ways.weights[robot]
    return total
