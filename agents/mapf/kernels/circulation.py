"""One joint step as a circulation: all robots choose at once who goes where.

In a step the robots move in chains, each of which ends in an empty cell, and in rings. Here they
are chosen together, so that the sum of what all robots gain is most: robots are matched to the
cells in which and beside which they are, by an auction. Where two would change places, one of the
two moves is forbidden, and the auction is held again. On floors that are nearly full, where robots
that choose one after the other soon block one another, more robots reach their goals so.

A robot gains the logarithm of the distances before and after, so that those near their goals go
first, times its weight. A robot that has a move goes on with it until it is made: it turns, and
waits for those before it to turn, and nobody else can have the two cells. A robot without one turns
to where it would like to go.

Sources: Bertsekas (1988), The auction algorithm: a distributed relaxation method for the assignment
problem, Annals of Operations Research 14. One-step plans as flows are of Yu and LaValle (2013),
Planning optimal paths for multiple robots on graphs, ICRA.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.mapf.kernels.buffers import Buffer, Table, buffer, buffer_of, kernel, table_of
from agents.mapf.kernels.floor import ACTIONS, NONE, STAY
from agents.mapf.kernels.rounds import NOBODY, draw
from warehouse_core.world.tables import Integers

WORTH, MAX_DISTANCE, PARTS = 1 << 16, 20_000, 8
"""Gain of a robot of weight 1 that halves its distance, the steps that all longer distances count
as, and the parts of a step by which distances differ.
"""

CHANCE, CHANCES = 4, 128
"""Chance adds a fourth of a gain at most, or takes it, and there are so many amounts of each."""

RAISE, ARRIVAL = WORTH // 1000, WORTH * 2
"""Least by which a price rises, and what a robot gains beside by arriving, for a weight of 1."""

ALONE, LEAST = 1 << 44, -(1 << 62)
"""Most by which a price rises at once, which is more than any gain, and less than any value."""

AUCTIONS = 7
"""Auctions in a step, after which robots that would change places stay."""

AGAINST = 5
"""Pairs of moves of which one pair has the move forbidden that gains more, and the others the one
that gains less.
"""


class Crowd(NamedTuple):
    """Robots in a step; all buffers are ``[R]`` but for those that say so.

    Attributes:
        size: number of cells; the cell of a place is its remainder by it.
        step: distance of a step.
        has_headings: 1 if robots drive forward and turn.
        unit: weight of a robot that counts once.
        ahead: ``[size * 4]``, cell that a move N, E, S or W leads to, or ``NONE``.
        worth: ``[MAX_DISTANCE * PARTS + 1]``, what a robot gains by its way from each distance.
        here: places before the first step.
        aims: cells to which robots have moves then, or ``NONE``.
        rests: 1 for robots that go nowhere then.
        places: places before a step.
        targets: cells to which robots have moves, or ``NONE``.
        is_there: 1 for robots that go nowhere, as those that were at their goals.
        goals: goal cells.
        rows: index of the distance field of each goal in the table of fields.
        weights: factors of gains.
        is_fixed: 1 for robots that stay in the first step.
        is_closed: ``[size]``, 1 for cells that nobody can enter.
        is_claimed: ``[size]``, 1 for cells that no robot without a move can have.
        robot_in: ``[size]``, robot in each cell, or ``NOBODY``.
        options: ``[R * 5]``, cells that the moves and staying lead to, or ``NONE``.
        gains: ``[R * 5]``, what is gained by each.
        chosen: action of each robot.
        wanted: heading to which each turns if it has no move, or ``NONE``.
        moves: 1 for robots that move in this step.
        prices: ``[size]``, prices of cells.
        holder: ``[size]``, robot that has bid most for each cell, or ``NOBODY``.
        stack: robots that have yet to bid.
        random: ``[1]``, state of the random numbers, not 0.
    """

    size: int
    step: int
    has_headings: int
    unit: int
    ahead: Table
    worth: Buffer
    here: Buffer
    aims: Buffer
    rests: Buffer
    places: Buffer
    targets: Buffer
    is_there: Buffer
    goals: Buffer
    rows: Buffer
    weights: Buffer
    is_fixed: Buffer
    is_closed: Buffer
    is_claimed: Buffer
    robot_in: Buffer
    options: Buffer
    gains: Buffer
    chosen: Buffer
    wanted: Buffer
    moves: Buffer
    prices: Buffer
    holder: Buffer
    stack: Buffer
    random: Buffer


def crowd_of(ahead: Integers, robots: int, step: int, has_headings: bool, unit: int) -> Crowd:
    """Return the buffers of robots, which count once each; ``ahead`` is ``[size, 4]``."""
    size, worth = len(ahead), WORTH * np.log2(np.arange(MAX_DISTANCE * PARTS + 1) / PARTS + 1)
    return Crowd(
        size=size, step=step, has_headings=int(has_headings), unit=unit,
        ahead=table_of(ahead.astype(np.int32)), worth=buffer_of(np.rint(worth).astype(np.int64)),
        here=buffer(robots), aims=buffer(robots, NONE), rests=buffer(robots),
        places=buffer(robots), targets=buffer(robots, NONE), is_there=buffer(robots),
        goals=buffer(robots), rows=buffer(robots), weights=buffer(robots, unit),
        is_fixed=buffer(robots), is_closed=buffer(size), is_claimed=buffer(size),
        robot_in=buffer(size, NOBODY), options=buffer(robots * ACTIONS, NONE),
        gains=buffer(robots * ACTIONS), chosen=buffer(robots, STAY), wanted=buffer(robots, NONE),
        moves=buffer(robots), prices=buffer(size), holder=buffer(size, NOBODY),
        stack=buffer(robots), random=buffer(1, 1),
    )  # fmt: skip


@kernel
def loss(crowd: Crowd, fields: Table, robot: int, cell: int, heading: int) -> int:
    """Return what a robot has yet to gain in a cell, by its distance from the goal."""
    if crowd.is_there[robot]:
        return 0
    left = fields[crowd.rows[robot] + heading * crowd.size + cell] + 0
    parts = (left * PARTS + crowd.step - 1) // crowd.step
    return crowd.worth[min(parts, MAX_DISTANCE * PARTS)] * crowd.weights[robot]


@kernel
def claim(crowd: Crowd, is_first: bool) -> None:
    """Claim the cells of robots that have moves or are fixed, and where they go."""
    for cell in range(crowd.size):
        crowd.is_claimed[cell] = crowd.is_closed[cell]
    for robot in range(len(crowd.places)):
        if crowd.targets[robot] != NONE:
            crowd.is_claimed[crowd.targets[robot]] = 1
        if crowd.targets[robot] != NONE or (is_first and crowd.is_fixed[robot]):
            crowd.is_claimed[crowd.places[robot] % crowd.size] = 1


@kernel
def offer(crowd: Crowd, fields: Table, robot: int, is_fixed: bool) -> None:
    """Write the options of a robot without a move, what it gains by each, and where it turns."""
    cell, heading = crowd.places[robot] % crowd.size, crowd.places[robot] // crowd.size
    first, most, lost = robot * ACTIONS, 0, loss(crowd, fields, robot, cell, heading)
    crowd.options[first + STAY], crowd.gains[first + STAY] = cell, 0
    crowd.wanted[robot] = NONE
    for action in range(STAY):
        to = crowd.ahead[cell * STAY + action] + 0
        crowd.options[first + action] = NONE
        if to == NONE or is_fixed:
            continue
        gain = lost - loss(crowd, fields, robot, to, action if crowd.has_headings else 0)
        if gain > most:
            most, crowd.wanted[robot] = gain, action
        if not crowd.is_claimed[to]:
            chance = draw(crowd.random) % (2 * CHANCES + 1) - CHANCES
            gain += gain * chance // (CHANCE * CHANCES)
            crowd.options[first + action], crowd.gains[first + action] = to, gain


@kernel
def hold_auction(crowd: Crowd) -> None:
    """Match robots without a move to cells, so that nearly as much is gained as can be.

    Robots that gain nothing by a move begin with their own cells. The others bid for the cell that
    is best for them at its price, which rises to where the second best is as good. Whoever had the
    cell bids again.
    """
    options, gains, prices, holder = crowd.options, crowd.gains, crowd.prices, crowd.holder
    stack, count = crowd.stack, 0
    for cell in range(crowd.size):
        prices[cell], holder[cell] = 0, NOBODY
    for robot in range(len(crowd.places)):
        if crowd.targets[robot] != NONE:
            continue
        first, is_better_off = robot * ACTIONS, False
        for at in range(first, first + STAY):
            is_better_off = is_better_off or (options[at] != NONE and gains[at] > 0)
        crowd.chosen[robot] = STAY
        if is_better_off:
            stack[count] = robot
            count += 1
        else:
            holder[options[first + STAY]] = robot
    while count > 0:
        count -= 1
        robot = stack[count]
        first, best, second, choice = robot * ACTIONS, LEAST, LEAST, STAY
        for action in range(ACTIONS):
            cell = options[first + action] + 0
            if cell == NONE:
                continue
            value = gains[first + action] - prices[cell]
            if value > best:
                second, best, choice = best, value, action
            elif value > second:
                second = value
        cell = options[first + choice]
        prices[cell] += min(best - second, ALONE) + RAISE * crowd.unit
        before = holder[cell] + 0
        holder[cell], crowd.chosen[robot] = robot, choice
        if before != NOBODY:
            stack[count] = before
            count += 1


@kernel
def part(crowd: Crowd, is_last: bool) -> bool:
    """Part robots that would change places, and return whether there are any.

    They stay if there is no other auction, and else one of them may not move there.
    """
    is_found = False
    for robot in range(len(crowd.places)):
        if crowd.targets[robot] != NONE or crowd.chosen[robot] == STAY:
            continue
        move = robot * ACTIONS + crowd.chosen[robot]
        other = crowd.robot_in[crowd.options[move]] + 0
        if other == NOBODY or crowd.chosen[other] == STAY:
            continue
        back = other * ACTIONS + crowd.chosen[other]
        if crowd.options[back] != crowd.places[robot] % crowd.size:
            continue
        is_found = True
        crowd.chosen[robot] = crowd.chosen[other] = STAY
        if not is_last:
            is_less = crowd.gains[move] < crowd.gains[back]
            forbids = is_less != (draw(crowd.random) % AGAINST == 0)
            crowd.options[move if forbids else back] = NONE
    return is_found


@kernel
def turn_to(crowd: Crowd, robot: int, to: int) -> bool:
    """Turn a robot by a quarter to a heading, and return whether it had to turn."""
    cell, heading = crowd.places[robot] % crowd.size, crowd.places[robot] // crowd.size
    turn = (to - heading) & 3
    if not crowd.has_headings or turn == 0:
        return False
    crowd.places[robot] = ((heading + (3 if turn == 3 else 1)) & 3) * crowd.size + cell
    return True


@kernel
def advance(crowd: Crowd) -> None:
    """Let robots turn, and let those move that head for cells which are or become empty."""
    size, moves, robot_in = crowd.size, crowd.moves, crowd.robot_in
    for robot in range(len(crowd.places)):
        moves[robot] = 0
        if crowd.targets[robot] == NONE:
            if crowd.wanted[robot] != NONE:
                turn_to(crowd, robot, crowd.wanted[robot])
            continue
        first, way = crowd.places[robot] % size * STAY, 0
        while crowd.ahead[first + way] != crowd.targets[robot]:
            way += 1
        moves[robot] = 0 if turn_to(crowd, robot, way) else 1
    is_changed = True
    while is_changed:
        is_changed = False
        for robot in range(len(crowd.places)):
            if moves[robot]:
                before = robot_in[crowd.targets[robot]] + 0
                if before != NOBODY and not moves[before]:
                    moves[robot], is_changed = 0, True
    for robot in range(len(crowd.places)):
        if moves[robot]:
            robot_in[crowd.places[robot] % size] = NOBODY
    for robot in range(len(crowd.places)):
        if moves[robot]:
            target = crowd.targets[robot] + 0
            crowd.places[robot] += target - crowd.places[robot] % size
            robot_in[target], crowd.targets[robot] = robot, NONE


@kernel
def circulate(crowd: Crowd, fields: Table, is_first: bool) -> None:
    """Take a joint step, in which fixed robots stay if it is the first."""
    claim(crowd, is_first)
    for robot in range(len(crowd.places)):
        if crowd.targets[robot] == NONE:
            offer(crowd, fields, robot, is_first and crowd.is_fixed[robot] == 1)
    for auction in range(AUCTIONS):
        hold_auction(crowd)
        if not part(crowd, auction == AUCTIONS - 1):
            break
    for robot in range(len(crowd.places)):
        if crowd.targets[robot] == NONE and crowd.chosen[robot] != STAY:
            crowd.targets[robot] = crowd.options[robot * ACTIONS + crowd.chosen[robot]]
    advance(crowd)
    for robot in range(len(crowd.places)):
        if crowd.places[robot] % crowd.size == crowd.goals[robot]:
            crowd.is_there[robot] = 1


@kernel
def stand(crowd: Crowd) -> None:
    """Let all robots be where they are before the first step."""
    for cell in range(crowd.size):
        crowd.robot_in[cell] = NOBODY
    for robot in range(len(crowd.places)):
        crowd.robot_in[crowd.here[robot] % crowd.size] = robot
        crowd.places[robot], crowd.targets[robot] = crowd.here[robot], crowd.aims[robot]
        crowd.is_there[robot], crowd.chosen[robot] = crowd.rests[robot], STAY


@kernel
def foresee(crowd: Crowd, fields: Table, draws: Buffer) -> int:
    """Take a step for each draw, and return what robots have yet to gain after the last.

    The first numbers of the random numbers of each step are the draws.
    """
    total = 0
    stand(crowd)
    for time in range(len(draws)):
        crowd.random[0] = draws[time]
        circulate(crowd, fields, time == 0)
    for robot in range(len(crowd.places)):
        place = crowd.places[robot]
        total += loss(crowd, fields, robot, place % crowd.size, place // crowd.size)
        total -= ARRIVAL * crowd.unit * (crowd.is_there[robot] - crowd.rests[robot])
    return total
