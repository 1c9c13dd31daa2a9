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
from agents.mapf.kernels.places import ACTIONS, NONE, STAY
from agents.mapf.kernels.robots import NOBODY, UNDECIDED, Robots, draw
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


class Auction(NamedTuple):
    """What a circulation knows of ``R`` robots; all buffers are ``[R]`` but for those that say so.

    Attributes:
        step: distance of a step.
        has_headings: 1 if robots drive forward and turn.
        unit: weight of a robot that counts once.
        ahead: ``[size * 4]``, cell that a move N, E, S or W leads to, or ``NONE``.
        worth: ``[MAX_DISTANCE * PARTS + 1]``, what a robot gains by its way from each distance.
        here: places before the first step.
        aims: cells to which robots have moves then, or ``NONE``.
        rests: 1 for robots that go nowhere then.
        targets: cells to which robots have moves, or ``NONE``.
        is_there: 1 for robots that go nowhere, as those that were at their goals.
        weights: factors of gains.
        is_claimed: ``[size]``, 1 for cells that no robot without a move can have.
        options: ``[R * 5]``, cells that the moves and staying lead to, or ``NONE``.
        gains: ``[R * 5]``, what is gained by each.
        actions: action of each robot.
        wanted: heading to which each turns if it has no move, or ``NONE``.
        moves: 1 for robots that move in this step.
        prices: ``[size]``, prices of cells.
        holder: ``[size]``, robot that has bid most for each cell, or ``NOBODY``.
    """

    step: int
    has_headings: int
    unit: int
    ahead: Table
    worth: Buffer
    here: Buffer
    aims: Buffer
    rests: Buffer
    targets: Buffer
    is_there: Buffer
    weights: Buffer
    is_claimed: Buffer
    options: Buffer
    gains: Buffer
    actions: Buffer
    wanted: Buffer
    moves: Buffer
    prices: Buffer
    holder: Buffer


def auction_of(ahead: Integers, robots: int, step: int, has_headings: bool, unit: int) -> Auction:
    """Return the buffers of robots, which count once each; ``ahead`` is ``[size, 4]``."""
    size, worth = len(ahead), WORTH * np.log2(np.arange(MAX_DISTANCE * PARTS + 1) / PARTS + 1)
    return Auction(
        step=step, has_headings=int(has_headings), unit=unit,
        ahead=table_of(ahead.astype(np.int32)), worth=buffer_of(np.rint(worth).astype(np.int64)),
        here=buffer(robots), aims=buffer(robots, NONE), rests=buffer(robots),
        targets=buffer(robots, NONE), is_there=buffer(robots), weights=buffer(robots, unit),
        is_claimed=buffer(size), options=buffer(robots * ACTIONS, NONE),
        gains=buffer(robots * ACTIONS), actions=buffer(robots, STAY), wanted=buffer(robots, NONE),
        moves=buffer(robots), prices=buffer(size), holder=buffer(size, NOBODY),
    )  # fmt: skip


@kernel
def loss(
    robots: Robots, auction: Auction, fields: Table, robot: int, cell: int, heading: int
) -> int:
    """Return what a robot has yet to gain in a cell, by its distance from the goal."""
    if auction.is_there[robot]:
        return 0
    left = fields[robots.rows[robot] + heading * robots.size + cell]
    parts = (left * PARTS + auction.step - 1) // auction.step
    return auction.worth[min(parts, MAX_DISTANCE * PARTS)] * auction.weights[robot]


@kernel
def claim(robots: Robots, auction: Auction) -> None:
    """Claim the cells of robots that have moves or are fixed, and where they go."""
    for cell in range(robots.size):
        auction.is_claimed[cell] = robots.is_closed[cell]
    for robot in range(len(robots.places)):
        if auction.targets[robot] != NONE:
            auction.is_claimed[auction.targets[robot]] = 1
        if auction.targets[robot] != NONE or robots.chosen[robot] != UNDECIDED:
            auction.is_claimed[robots.places[robot] % robots.size] = 1


@kernel
def offer(robots: Robots, auction: Auction, fields: Table, robot: int, is_fixed: bool) -> None:
    """Write the options of a robot without a move, what it gains by each, and where it turns."""
    cell, heading = robots.places[robot] % robots.size, robots.places[robot] // robots.size
    first, most, lost = robot * ACTIONS, 0, loss(robots, auction, fields, robot, cell, heading)
    auction.options[first + STAY], auction.gains[first + STAY] = cell, 0
    auction.wanted[robot] = NONE
    for action in range(STAY):
        to = auction.ahead[cell * STAY + action]
        auction.options[first + action] = NONE
        if to == NONE or is_fixed:
            continue
        faced = action if auction.has_headings else 0
        gain = lost - loss(robots, auction, fields, robot, to, faced)
        if gain > most:
            most, auction.wanted[robot] = gain, action
        if not auction.is_claimed[to]:
            chance = draw(robots.random) % (2 * CHANCES + 1) - CHANCES
            gain += gain * chance // (CHANCE * CHANCES)
            auction.options[first + action], auction.gains[first + action] = to, gain


@kernel
def hold_auction(robots: Robots, auction: Auction) -> None:
    """Match robots without a move to cells, so that nearly as much is gained as can be.

    Robots that gain nothing by a move begin with their own cells. The others bid for the cell that
    is best for them at its price, which rises to where the second best is as good. Whoever had the
    cell bids again.
    """
    options, gains, prices, holder = auction.options, auction.gains, auction.prices, auction.holder
    stack, count = robots.stack, 0
    for cell in range(robots.size):
        prices[cell], holder[cell] = 0, NOBODY
    for robot in range(len(robots.places)):
        if auction.targets[robot] != NONE:
            continue
        first, is_better_off = robot * ACTIONS, False
        for at in range(first, first + STAY):
            is_better_off = is_better_off or (options[at] != NONE and gains[at] > 0)
        auction.actions[robot] = STAY
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
            cell = options[first + action]
            if cell == NONE:
                continue
            value = gains[first + action] - prices[cell]
            if value > best:
                second, best, choice = best, value, action
            elif value > second:
                second = value
        cell = options[first + choice]
        prices[cell] += min(best - second, ALONE) + RAISE * auction.unit
        before = holder[cell]
        holder[cell], auction.actions[robot] = robot, choice
        if before != NOBODY:
            stack[count] = before
            count += 1


@kernel
def part(robots: Robots, auction: Auction, is_last: bool) -> bool:
    """Part robots that would change places, and return whether there are any.

    They stay if there is no other auction, and else one of them may not move there.
    """
    is_found = False
    for robot in range(len(robots.places)):
        if auction.targets[robot] != NONE or auction.actions[robot] == STAY:
            continue
        move = robot * ACTIONS + auction.actions[robot]
        other = robots.robot_in[auction.options[move]]
        if other == NOBODY or auction.actions[other] == STAY:
            continue
        back = other * ACTIONS + auction.actions[other]
        if auction.options[back] != robots.places[robot] % robots.size:
            continue
        is_found = True
        auction.actions[robot] = auction.actions[other] = STAY
        if not is_last:
            is_less = auction.gains[move] < auction.gains[back]
            forbids = is_less != (draw(robots.random) % AGAINST == 0)
            auction.options[move if forbids else back] = NONE
    return is_found


@kernel
def turn_to(robots: Robots, auction: Auction, robot: int, to: int) -> bool:
    """Turn a robot by a quarter to a heading, and return whether it had to turn."""
    cell, heading = robots.places[robot] % robots.size, robots.places[robot] // robots.size
    turn = (to - heading) & 3
    if not auction.has_headings or turn == 0:
        return False
    robots.places[robot] = ((heading + (3 if turn == 3 else 1)) & 3) * robots.size + cell
    return True


@kernel
def advance(robots: Robots, auction: Auction) -> None:
    """Let robots turn, and let those move that head for cells which are or become empty."""
    size, moves, robot_in = robots.size, auction.moves, robots.robot_in
    for robot in range(len(robots.places)):
        moves[robot] = 0
        if auction.targets[robot] == NONE:
            if auction.wanted[robot] != NONE:
                turn_to(robots, auction, robot, auction.wanted[robot])
            continue
        first, way = robots.places[robot] % size * STAY, 0
        while auction.ahead[first + way] != auction.targets[robot]:
            way += 1
        moves[robot] = 0 if turn_to(robots, auction, robot, way) else 1
    is_changed = True
    while is_changed:
        is_changed = False
        for robot in range(len(robots.places)):
            if moves[robot]:
                before = robot_in[auction.targets[robot]]
                if before != NOBODY and not moves[before]:
                    moves[robot], is_changed = 0, True
    for robot in range(len(robots.places)):
        if moves[robot]:
            robot_in[robots.places[robot] % size] = NOBODY
    for robot in range(len(robots.places)):
        if moves[robot]:
            target = auction.targets[robot]
            robots.places[robot] += target - robots.places[robot] % size
            robot_in[target], auction.targets[robot] = robot, NONE


@kernel
def choose(robots: Robots, auction: Auction, fields: Table) -> None:
    """Choose the next places of all robots and move them there; those that have chosen stay."""
    claim(robots, auction)
    for robot in range(len(robots.places)):
        if auction.targets[robot] == NONE:
            offer(robots, auction, fields, robot, robots.chosen[robot] != UNDECIDED)
    for number in range(AUCTIONS):
        hold_auction(robots, auction)
        if not part(robots, auction, number == AUCTIONS - 1):
            break
    for robot in range(len(robots.places)):
        if auction.targets[robot] == NONE and auction.actions[robot] != STAY:
            auction.targets[robot] = auction.options[robot * ACTIONS + auction.actions[robot]]
    advance(robots, auction)
    for robot in range(len(robots.places)):
        robots.chosen[robot] = robots.places[robot]
        if robots.places[robot] % robots.size == robots.goals[robot]:
            auction.is_there[robot] = 1


@kernel
def stand(robots: Robots, auction: Auction) -> None:
    """Let all robots be where they are before the first step."""
    for cell in range(robots.size):
        robots.robot_in[cell] = NOBODY
    for robot in range(len(robots.places)):
        robots.robot_in[auction.here[robot] % robots.size] = robot
        robots.places[robot], auction.targets[robot] = auction.here[robot], auction.aims[robot]
        auction.is_there[robot], auction.actions[robot] = auction.rests[robot], STAY


@kernel
def foresee(robots: Robots, auction: Auction, fields: Table, draws: Buffer) -> int:
    """Take a step for each draw, and return what robots have yet to gain after the last.

    The first numbers of the random numbers of each step are the draws.
    """
    total = 0
    stand(robots, auction)
    for time in range(len(draws)):
        robots.random[0] = draws[time]
        for robot in range(len(robots.places)):
            stays = time == 0 and robots.stays[robot] == 1
            robots.chosen[robot] = robots.places[robot] if stays else UNDECIDED
        choose(robots, auction, fields)
    for robot in range(len(robots.places)):
        place = robots.places[robot]
        total += loss(robots, auction, fields, robot, place % robots.size, place // robots.size)
        total -= ARRIVAL * auction.unit * (auction.is_there[robot] - auction.rests[robot])
    return total
