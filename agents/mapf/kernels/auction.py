"""Circulation: one auction in each step decides the moves of all robots together.

In a step, robots move in chains that end in an empty cell, or in closed rings. An auction matches
each robot to its own cell or a neighbouring cell so that the total gain of all robots is nearly as
large as possible. If two robots would swap cells, one of the two moves is forbidden and the auction
is repeated. On crowded floors, robots that choose one after the other soon block one
another; with circulations, more of them reach their goals.

The gain of a robot is its weight times the difference between the logarithms of the distances
before and after the move. Robots near their goals therefore go first. A robot that has been given a
move keeps it until the move is made. It first turns, and waits for the robots ahead to turn; no
other robot can take its two cells meanwhile. A robot without a move turns to the heading that it
would prefer.

Sources: Bertsekas (1988), The auction algorithm: a distributed relaxation method for the assignment
problem, Annals of Operations Research 14. Yu and LaValle (2013), Planning optimal paths for
multiple robots on graphs, ICRA, describe one-step plans as flows.
"""

from __future__ import annotations

from typing import NamedTuple

from agents.mapf.kernels.buffers import Buffer, Table
from agents.mapf.kernels.places import ACTIONS, NONE, STAY
from agents.mapf.kernels.robots import NOBODY, UNDECIDED, Robots, draw
from warehouse_core.compiled import kernel

WORTH, MAX_DISTANCE, PARTS = 1 << 16, 20_000, 8
"""Gain for halving the distance at weight 1, cap on distances in steps, and resolution per step."""

CHANCE, CHANCES = 4, 128
"""Random noise changes a gain by at most 1/4, up or down, in 128 levels each."""

RAISE = WORTH // 1000
"""Smallest rise of a price for a weight of 1."""

ALONE, LEAST = 1 << 44, -(1 << 62)
"""Largest rise of a price at once, above any gain, and a number that is below any value."""

AUCTIONS = 7
"""Most auctions in a step. After the last one, robots that would swap cells stay."""

AGAINST = 5
"""The move with the larger gain is forbidden once in this many swaps, else the smaller one."""


class Auction(NamedTuple):
    """State of a circulation of ``R`` robots. Buffers are ``[R]`` unless stated otherwise.

    Attributes:
        step: distance of a step.
        has_headings: 1 if robots drive forward and turn.
        unit: weight of an ordinary robot.
        ahead: ``[size * 4]``, cell that a move N, E, S or W leads to, or ``NONE``.
        worth: ``[MAX_DISTANCE * PARTS + 1]``, what a robot gains on its path from each distance.
        targets: cells to which robots have moves, or ``NONE``.
        is_there: 1 for robots that have no reason to move, such as those that have reached their
            goals.
        weights: factors of gains.
        is_claimed: ``[size]``, 1 for cells that no robot without a move can have.
        options: ``[R * 5]``, cells that the moves and staying lead to, or ``NONE``.
        gains: ``[R * 5]``, gain of each option.
        actions: action of each robot.
        wanted: heading to which each robot turns if it has no move, or ``NONE``.
        moves: 1 for robots that move in this step.
        prices: ``[size]``, prices of cells.
        holder: ``[size]``, robot with the highest bid for each cell, or ``NOBODY``.
    """

    step: int
    has_headings: int
    unit: int
    ahead: Table
    worth: Buffer
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


@kernel
def loss(
    robots: Robots, auction: Auction, fields: Table, robot: int, cell: int, heading: int
) -> int:
    """Return what a robot has yet to gain when it is in a cell, from its distance to the goal."""
    if auction.is_there[robot]:
        return 0
    left = fields[robots.rows[robot] + heading * robots.size + cell]
    parts = (left * PARTS + auction.step - 1) // auction.step
    return auction.worth[min(parts, MAX_DISTANCE * PARTS)] * auction.weights[robot]


@kernel
def claim(robots: Robots, auction: Auction) -> None:
    """Claim the cells of robots that have moves or must stay, and the targets of these moves."""
    for cell in range(robots.size):
        auction.is_claimed[cell] = robots.is_closed[cell]
    for robot in range(len(robots.places)):
        if auction.targets[robot] != NONE:
            auction.is_claimed[auction.targets[robot]] = 1
        if auction.targets[robot] != NONE or robots.chosen[robot] != UNDECIDED:
            auction.is_claimed[robots.places[robot] % robots.size] = 1


@kernel
def offer(robots: Robots, auction: Auction, fields: Table, robot: int, is_fixed: bool) -> None:
    """Write the options of a robot without a move, their gains, and the heading it prefers."""
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
    """Match robots without a move to cells so that the total gain is nearly the largest possible.

    A robot that gains nothing by a move keeps its own cell at first. Each other robot bids for its
    best cell at the current prices. The price then rises until the second-best cell is as good. A
    robot that is outbid bids again.
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
def prevent_swaps(robots: Robots, auction: Auction, is_last: bool) -> bool:
    """Prevent pairs of robots from swapping cells, and return whether there were any.

    Both robots stay after the last auction. Before that, one of the two moves is forbidden.
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
    """Turn a robot by a quarter towards a heading, and return whether it had to turn."""
    cell, heading = robots.places[robot] % robots.size, robots.places[robot] // robots.size
    turn = (to - heading) & 3
    if not auction.has_headings or turn == 0:
        return False
    robots.places[robot] = ((heading + (3 if turn == 3 else 1)) & 3) * robots.size + cell
    return True


@kernel
def advance(robots: Robots, auction: Auction) -> None:
    """Turn robots, and move those whose target cells are empty or become empty."""
    size, moves, robot_in = robots.size, auction.moves, robots.robot_in
    for robot in range(len(robots.places)):
        moves[robot] = 0
        if auction.targets[robot] == NONE:
            if auction.wanted[robot] != NONE:
                turn_to(robots, auction, robot, auction.wanted[robot])
            continue
        first, action = robots.places[robot] % size * STAY, 0
        while auction.ahead[first + action] != auction.targets[robot]:
            action += 1
        moves[robot] = 0 if turn_to(robots, auction, robot, action) else 1
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
    """Choose the next places of all robots and move them there; robots that have chosen stay."""
    claim(robots, auction)
    for robot in range(len(robots.places)):
        if auction.targets[robot] == NONE:
            offer(robots, auction, fields, robot, robots.chosen[robot] != UNDECIDED)
    for number in range(AUCTIONS):
        hold_auction(robots, auction)
        if not prevent_swaps(robots, auction, number == AUCTIONS - 1):
            break
    for robot in range(len(robots.places)):
        if auction.targets[robot] == NONE and auction.actions[robot] != STAY:
            auction.targets[robot] = auction.options[robot * ACTIONS + auction.actions[robot]]
    advance(robots, auction)
    for robot in range(len(robots.places)):
        robots.chosen[robot] = robots.places[robot]
        if robots.places[robot] % robots.size == robots.goals[robot]:
            auction.is_there[robot] = 1
