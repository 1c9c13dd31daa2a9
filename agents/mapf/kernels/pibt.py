"""PIBT, priority inheritance with backtracking: in each step the robots choose cells by priority.

A robot chooses the cell nearest to its goal. If a robot of lower priority is in that cell, this
robot inherits the priority and chooses next. If it finds no free cell, it stays, and the first
robot tries its next choice (backtracking).

Two robots that meet head-on in a corridor *swap*. One of them backs off to a junction and pulls the
other robot after it, so that they can pass each other there.

Sources: Okumura, Machida, Défago and Tamura (2022), Priority inheritance with backtracking for
iterative multi-agent path finding, Artificial Intelligence 310. The swap operation comes from
Okumura (2023), Improving LaCAM for scalable eventually optimal multi-agent pathfinding, IJCAI.
"""

from __future__ import annotations

from typing import NamedTuple

from agents.mapf.kernels.buffers import Buffer, Table, buffer
from agents.mapf.kernels.places import ACTIONS, FAR, NONE, STAY, Places
from agents.mapf.kernels.robots import NOBODY, SPREAD, UNDECIDED, Robots, draw, mix
from warehouse_core.compiled import kernel

WAIT_KEY, OCCUPIED_KEY, CHANCE_KEY = 20, 20, 7
"""Penalties in the key of a choice: for waiting, for an occupied cell, and the largest random one.

The unit is 1/40 of a step. Together they are less than two steps. A larger sum would make a robot
wait behind another robot that it could push.
"""

STEP_KEY = 40
"""Length of one step in the unit of the keys."""


class Pibt(NamedTuple):
    """State of PIBT for ``R`` robots. The shape of a buffer is ``[R]`` unless stated otherwise.

    Attributes:
        pushers: robot that made each robot choose before its turn, or ``NOBODY``.
        is_taken: ``[size]``, 1 for cells that robots have chosen; all 0 between rounds.
        choices: ``[R * 5]``, places that each robot can go to, best first.
        options: number of these choices.
        tried: number of choices that each robot has tried.
        partner: robot that each robot swaps with, or ``NOBODY``.
        keys: ``[5]``, sort keys of the choices of one robot.
        is_final: ``[1]``, 1 if robots stay at their goals for good, 0 if they leave them again.
        wishes: place next to each robot that it tries first unless it swaps, or ``NONE``.
    """

    pushers: Buffer
    is_taken: Buffer
    choices: Buffer
    options: Buffer
    tried: Buffer
    partner: Buffer
    keys: Buffer
    is_final: Buffer
    wishes: Buffer


def pibt_of(size: int, robots: int, is_final: bool = False) -> Pibt:
    """Return the buffers of PIBT for the given numbers of cells and robots, with no cell taken."""
    return Pibt(
        pushers=buffer(robots, NOBODY), is_taken=buffer(size), choices=buffer(robots * ACTIONS),
        options=buffer(robots), tried=buffer(robots), partner=buffer(robots),
        keys=buffer(ACTIONS), is_final=buffer(1, int(is_final)), wishes=buffer(robots, NONE),
    )  # fmt: skip


@kernel
def sort_choices(floor: Places, robots: Robots, pibt: Pibt, fields: Table, robot: int) -> None:
    """Write the places that a robot can go to into its choices, best first."""
    size, near, price, closed = floor.size, floor.near, floor.price, floor.closed
    robot_in, choices, keys = robots.robot_in, pibt.choices, pibt.keys
    place, row, first = robots.places[robot], robots.rows[robot], robot * ACTIONS
    base, unit = place * ACTIONS, STEP_KEY // floor.step
    bits = mix(robots.random[0] + robot * SPREAD)
    stays = place % size == robots.goals[robot] or fields[row + place] == FAR
    count = 0
    for action in range(ACTIONS):
        to = near[base + action]
        if to == closed:
            continue
        key = (fields[row + to] + price[base + action]) * unit + (bits & CHANCE_KEY)
        bits >>= 3
        if action == STAY:
            key = 0 if stays else key + WAIT_KEY
        elif robot_in[to % size] != NOBODY:
            key += OCCUPIED_KEY
        at = count
        while at > 0 and keys[at - 1] > key:
            keys[at] = keys[at - 1]
            choices[first + at] = choices[first + at - 1]
            at -= 1
        keys[at] = key
        choices[first + at] = to
        count += 1
    pibt.options[robot] = count


@kernel
def exits(floor: Places, robots: Robots, cell: int, behind: int) -> int:
    """Return the exits of a cell other than ``behind``: their number times ``size`` plus the last.

    A dead end does not count as an exit if a robot is there that has its goal there.
    """
    size, near, degree, robot_in = floor.size, floor.near, floor.degree, robots.robot_in
    number, last = 0, 0
    for action in range(STAY):
        to = near[cell * ACTIONS + action]
        if to == floor.closed:
            continue
        to %= size
        other = robot_in[to]
        is_shut = degree[to] == 1 and other != NOBODY and robots.goals[other] == to
        if to != behind and not is_shut:
            number, last = number + 1, to
    return number * size + last


@kernel
def has_room(floor: Places, robots: Robots, behind: int, ahead: int, crowd: int) -> bool:
    """Return whether ``crowd`` robots can be pushed into the cells from ``ahead`` on."""
    start, cells = ahead, 0
    while True:
        cells += 1
        crowd += robots.robot_in[ahead] != NOBODY
        onward = exits(floor, robots, ahead, behind)
        if onward < floor.size:
            return crowd <= cells
        behind, ahead = ahead, onward % floor.size
        if onward >= 2 * floor.size or ahead == start:
            return True


@kernel
def needs_swap(
    floor: Places, robots: Robots, pibt: Pibt, fields: Table, pusher: int, puller: int,
    behind: int, ahead: int,
) -> bool:  # fmt: skip
    """Return whether two robots must swap because pushing on would not let them pass each other."""
    push, pull = robots.rows[pusher], robots.rows[puller]
    is_dead_end, comes_out, crowd = False, False, 0
    while fields[push + ahead] < fields[push + behind]:
        other = robots.robot_in[ahead]
        if other != NOBODY:
            row, crowd = robots.rows[other], crowd + 1
            is_back = fields[row + behind] < fields[row + ahead]
            comes_out = comes_out or is_back or robots.goals[other] == ahead
        onward = exits(floor, robots, ahead, behind)
        if onward >= 2 * floor.size:
            return False
        if onward < floor.size:
            is_dead_end = True
            break
        behind, ahead = ahead, onward - floor.size
    is_back = fields[pull + behind] < fields[pull + ahead]
    if pibt.is_final[0] == 0:  # the pusher only has to reach its goal, as it leaves it again
        comes_out = comes_out or (is_back and robots.goals[pusher] != robots.goals[puller])
        return comes_out and (is_dead_end or not has_room(floor, robots, behind, ahead, crowd))
    return is_back and (is_dead_end or behind == robots.goals[pusher])


@kernel
def can_swap(floor: Places, robots: Robots, behind: int, ahead: int) -> bool:
    """Return whether the corridor from ``behind`` through ``ahead`` leads to a junction."""
    start = behind
    while ahead != start:
        onward = exits(floor, robots, ahead, behind)
        if onward >= 2 * floor.size:
            return True
        if onward < floor.size:
            return False
        behind, ahead = ahead, onward - floor.size
    return False


@kernel
def swap_partner(floor: Places, robots: Robots, pibt: Pibt, fields: Table, robot: int) -> int:
    """Return the undecided robot that a robot has to swap with, or ``NOBODY``.

    This is the robot ahead. It can also be a neighbour that wants to go the same way and can only
    pass if this robot backs off. Robots with headings do not swap.
    """
    size, near, robot_in, row = floor.size, floor.near, robots.robot_in, robots.rows[robot]
    here, ahead = robots.places[robot] % size, pibt.choices[robot * ACTIONS] % size
    if ahead == here or floor.closed != size:
        return NOBODY
    if floor.through[ahead] > 2 and fields[row + ahead] < fields[row + here]:
        return NOBODY  # they can pass each other there; this test is cheaper
    other = robot_in[ahead]
    if (
        other != NOBODY
        and robots.chosen[other] == UNDECIDED
        and needs_swap(floor, robots, pibt, fields, robot, other, here, ahead)
        and can_swap(floor, robots, ahead, here)
    ):
        return other
    for action in range(STAY):
        neighbour = near[here * ACTIONS + action]
        if neighbour == floor.closed or neighbour % size == ahead:
            continue
        other = robot_in[neighbour % size]
        if (
            other != NOBODY
            and needs_swap(floor, robots, pibt, fields, other, robot, here, ahead)
            and can_swap(floor, robots, ahead, here)
        ):
            return other
    return NOBODY


@kernel
def begin(floor: Places, robots: Robots, pibt: Pibt, fields: Table, robot: int) -> None:
    """Start the choice of a robot.

    It tries its best place or its wish first. To back off in a swap, it tries its worst place.
    """
    choices = pibt.choices
    sort_choices(floor, robots, pibt, fields, robot)
    pibt.tried[robot] = 0
    partner = swap_partner(floor, robots, pibt, fields, robot)
    pibt.partner[robot] = partner
    if partner != NOBODY:
        first, last = robot * ACTIONS, robot * ACTIONS + pibt.options[robot] - 1
        while first < last:
            choices[first], choices[last] = choices[last], choices[first]
            first, last = first + 1, last - 1
    elif pibt.wishes[robot] != NONE:
        at = first = robot * ACTIONS
        while choices[at] != pibt.wishes[robot]:
            at += 1
        while at > first:
            choices[at], at = choices[at - 1], at - 1
        choices[first] = pibt.wishes[robot]


@kernel
def pull(floor: Places, robots: Robots, pibt: Pibt, robot: int) -> None:
    """Move the swap partner of a robot that backs off into the cell that it leaves, if possible."""
    partner, here = pibt.partner[robot], robots.places[robot] % floor.size
    if partner == NOBODY or pibt.tried[robot] != 1 or robots.chosen[partner] != UNDECIDED:
        return
    if pibt.is_taken[here] or robots.is_closed[here]:
        return
    for action in range(STAY):
        to = floor.near[robots.places[partner] * ACTIONS + action]
        if to != floor.closed and to % floor.size == here:
            robots.chosen[partner] = to
            pibt.is_taken[here] = 1


@kernel
def choose(floor: Places, robots: Robots, pibt: Pibt, fields: Table) -> bool:
    """Choose the next places of all undecided robots in one round of PIBT.

    The round is a loop with an explicit stack, because chains of thousands of robots that push each
    other would exceed Python's recursion limit.

    Returns:
        True if each robot has a cell of its own. False occurs only if the cell of an undecided
        robot was taken before the round.
    """
    size, places, chosen, is_taken = floor.size, robots.places, robots.chosen, pibt.is_taken
    robot_in, choices, options, tried = robots.robot_in, pibt.choices, pibt.options, pibt.tried
    is_complete = True
    draw(robots.random)
    for robot in range(len(places)):
        if chosen[robot] != UNDECIDED:
            is_taken[chosen[robot] % size] = 1
    for at in range(len(robots.order)):
        robot, depth = robots.order[at], 0
        if chosen[robot] != UNDECIDED:
            continue
        begin(floor, robots, pibt, fields, robot)
        while True:
            here, other, is_found = places[robot] % size, NOBODY, False
            while tried[robot] < options[robot] and not is_found:
                place = choices[robot * ACTIONS + tried[robot]]
                tried[robot] += 1
                cell = place % size
                other = robot_in[cell]
                is_shut = robots.is_closed[cell] and cell != here
                if (
                    is_taken[cell]
                    or is_shut
                    or (
                        other != NOBODY
                        and other != robot
                        and chosen[other] != UNDECIDED
                        and chosen[other] % size == here
                    )
                ):
                    continue  # another robot takes the cell, or the two would swap cells
                chosen[robot], is_taken[cell], is_found = place, 1, True
            if is_found and other not in (NOBODY, robot) and chosen[other] == UNDECIDED:
                robots.stack[depth] = robot
                depth += 1
                pibt.pushers[other] = robot
                robot = other
                begin(floor, robots, pibt, fields, robot)
                continue
            if is_found:  # the cell will be free, so all robots that pushed get their choices
                pull(floor, robots, pibt, robot)
                while depth > 0:
                    depth -= 1
                    pull(floor, robots, pibt, robots.stack[depth])
                break
            # No choice is left. The robot stays, and the robot that pushed it tries another cell.
            chosen[robot] = places[robot]
            pibt.pushers[robot] = NOBODY
            is_complete = is_complete and (depth > 0 or not is_taken[here])
            is_taken[here] = 1
            if depth == 0:
                break
            depth -= 1
            robot = robots.stack[depth]
    for robot in range(len(places)):
        is_taken[chosen[robot] % size] = 0
    return is_complete
