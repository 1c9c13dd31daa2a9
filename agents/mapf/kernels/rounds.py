"""One joint step by PIBT: each robot chooses its next place, in the order of priorities.

A robot that wants the cell of another gives it its priority: the other chooses next, and if it
finds no cell it stays, and the first tries its next choice. Two robots that meet head-on where
neither can pass *swap*: one backs off to where two ways lead on, and pulls the other after it.

Places are numbers as in ``graph.py``; the cell of a place is its remainder by ``size``.

Sources: Okumura, Machida, Défago and Tamura (2022), Priority inheritance with backtracking for
iterative multi-agent path finding, Artificial Intelligence 310. Swaps: Okumura (2023), Improving
LaCAM for scalable eventually optimal multi-agent pathfinding, IJCAI.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.mapf.kernels.buffers import Buffer, Table, buffer, kernel
from agents.mapf.kernels.floor import ACTIONS, FAR, STAY, Floor

NOBODY = -1
"""Number in place of a robot where there is none."""

UNDECIDED = -1
"""Next place of a robot that has not chosen yet."""

CHOSEN, CLOSED = 1, 2
"""Marks of a cell that is somebody's next, and of one that only who is in it can have."""

WAIT_KEY, OCCUPIED_KEY, CHANCE_KEY = 20, 20, 7
"""Keys of a choice in fortieths of a step: waiting, somebody in the cell, and the most of chance.

Together they are less than two steps, so that no robot waits behind one that it could push.
"""

SPREAD = 0x9E3779B9
"""Multiplier of the number of a robot, so that each has another chance."""

STEP_KEY = 40
"""A step in the units of these keys."""


class Team(NamedTuple):
    """Robots in a round; all buffers are ``[R]`` but for those that say so.

    Attributes:
        places: present places.
        goals: goal cells.
        rows: index of the distance field of each goal in the table of fields.
        order: robots by falling priority.
        chosen: next places, or ``UNDECIDED``.
        pushers: robot that made each choose before its turn, or ``NOBODY``.
        robot_in: ``[size]``, robot in each cell, or ``NOBODY``.
        is_taken: ``[size]``, ``CHOSEN``, ``CLOSED``, or 0.
        choices: ``[R * 5]``, places that each can go to, the best first.
        options: number of these.
        tried: number of choices that each has tried.
        partner: robot that each swaps with, or ``NOBODY``.
        stack: robots that wait for one that they push.
        keys: ``[5]``, used while choices are sorted.
        random: ``[1]``, state of the random numbers, not 0; each round draws one.
        is_sorted: ``[1]``, 1 if all choices are in order before a round.
        is_final: ``[1]``, 1 if robots stay at their goals for good; others leave them again.
    """

    places: Buffer
    goals: Buffer
    rows: Buffer
    order: Buffer
    chosen: Buffer
    pushers: Buffer
    robot_in: Buffer
    is_taken: Buffer
    choices: Buffer
    options: Buffer
    tried: Buffer
    partner: Buffer
    stack: Buffer
    keys: Buffer
    random: Buffer
    is_sorted: Buffer
    is_final: Buffer


def first_random(seed: int | None) -> Buffer:
    """Return the state of the random numbers of a seed."""
    return buffer(1, int(np.random.default_rng(seed).integers(1, 1 << 32)))


def team_of(size: int, robots: int, seed: int | None, is_final: bool = False) -> Team:
    """Return the buffers of a team on so many cells, with nothing in them."""
    return Team(
        places=buffer(robots), goals=buffer(robots), rows=buffer(robots), order=buffer(robots),
        chosen=buffer(robots, UNDECIDED), pushers=buffer(robots, NOBODY),
        robot_in=buffer(size, NOBODY), is_taken=buffer(size), choices=buffer(robots * ACTIONS),
        options=buffer(robots), tried=buffer(robots), partner=buffer(robots),
        stack=buffer(robots), keys=buffer(ACTIONS), random=first_random(seed),
        is_sorted=buffer(1), is_final=buffer(1, int(is_final)),
    )  # fmt: skip


@kernel
def draw(random: Buffer) -> int:
    """Return the next random number of 32 bits, by Marsaglia's xorshift (2003)."""
    x = random[0]
    x ^= (x << 13) & 0xFFFFFFFF
    x ^= x >> 17
    x ^= (x << 5) & 0xFFFFFFFF
    random[0] = x
    return x


@kernel
def mix(number: int) -> int:
    """Return 32 bits that look like chance, and that a number decides; arrays are taken too."""
    number = ((number ^ (number >> 16)) * 0x45D9F3B) & 0xFFFFFFFF
    number = ((number ^ (number >> 16)) * 0x45D9F3B) & 0xFFFFFFFF
    return number ^ (number >> 16)


@kernel
def sort_choices(floor: Floor, team: Team, fields: Table, robot: int) -> None:
    """Write the places that a robot can go to into its choices, the best first."""
    size, near, price, closed = floor.size, floor.near, floor.price, floor.closed
    robot_in, choices, keys = team.robot_in, team.choices, team.keys
    place, row, first = team.places[robot], team.rows[robot], robot * ACTIONS
    base, unit = place * ACTIONS, STEP_KEY // floor.step
    bits = mix(team.random[0] + robot * SPREAD)
    stays = place % size == team.goals[robot] or fields[row + place] == FAR
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
    team.options[robot] = count


@kernel
def exits(floor: Floor, team: Team, cell: int, behind: int) -> int:
    """Return the other ways on from a cell: their number times ``size``, plus the last of them.

    Dead ends in which a robot has its goal are none.
    """
    size, near, degree, robot_in = floor.size, floor.near, floor.degree, team.robot_in
    number, last = 0, 0
    for action in range(STAY):
        to = near[cell * ACTIONS + action]
        if to == floor.closed:
            continue
        to %= size
        other = robot_in[to]
        is_shut = degree[to] == 1 and other != NOBODY and team.goals[other] == to
        if to != behind and not is_shut:
            number, last = number + 1, to
    return number * size + last


@kernel
def has_room(floor: Floor, team: Team, behind: int, ahead: int, crowd: int) -> bool:
    """Return whether so many robots can be pushed on to ``ahead`` and beyond it."""
    start, cells = ahead, 0
    while True:
        cells += 1
        crowd += team.robot_in[ahead] != NOBODY
        found = exits(floor, team, ahead, behind)
        if found < floor.size:
            return crowd <= cells
        behind, ahead = ahead, found % floor.size
        if found >= 2 * floor.size or ahead == start:
            return True


@kernel
def needs_swap(
    floor: Floor, team: Team, fields: Table, pusher: int, puller: int, behind: int, ahead: int
) -> bool:
    """Return whether two robots have to change places, since pushing on leads nowhere."""
    push, pull = team.rows[pusher], team.rows[puller]
    is_dead_end, comes_out, crowd = False, False, 0
    while fields[push + ahead] < fields[push + behind]:
        other = team.robot_in[ahead]
        if other != NOBODY:
            row, crowd = team.rows[other], crowd + 1
            is_back = fields[row + behind] < fields[row + ahead]
            comes_out = comes_out or is_back or team.goals[other] == ahead
        found = exits(floor, team, ahead, behind)
        if found >= 2 * floor.size:
            return False
        if found < floor.size:
            is_dead_end = True
            break
        behind, ahead = ahead, found - floor.size
    is_back = fields[pull + behind] < fields[pull + ahead]
    if team.is_final[0] == 0:  # the pusher leaves its goal again, and only has to get there
        comes_out = comes_out or (is_back and team.goals[pusher] != team.goals[puller])
        return comes_out and (is_dead_end or not has_room(floor, team, behind, ahead, crowd))
    return is_back and (is_dead_end or behind == team.goals[pusher])


@kernel
def can_swap(floor: Floor, team: Team, behind: int, ahead: int) -> bool:
    """Return whether the way from ``behind`` by ``ahead`` leads to where two ways lead on."""
    start = behind
    while ahead != start:
        found = exits(floor, team, ahead, behind)
        if found >= 2 * floor.size:
            return True
        if found < floor.size:
            return False
        behind, ahead = ahead, found - floor.size
    return False


@kernel
def swap_partner(floor: Floor, team: Team, fields: Table, robot: int) -> int:
    """Return the undecided robot that has to pass a robot, or ``NOBODY``.

    It is the one ahead, or, to clear the way for it, one beside that wants to go on as this does.
    Robots with headings do not swap.
    """
    size, near, robot_in, row = floor.size, floor.near, team.robot_in, team.rows[robot]
    here, ahead = team.places[robot] % size, team.choices[robot * ACTIONS] % size
    if ahead == here or floor.closed != size:
        return NOBODY
    if floor.through[ahead] > 2 and fields[row + ahead] < fields[row + here]:
        return NOBODY  # they can pass each other there, which is found sooner so
    other = robot_in[ahead]
    if (
        other != NOBODY
        and team.chosen[other] == UNDECIDED
        and needs_swap(floor, team, fields, robot, other, here, ahead)
        and can_swap(floor, team, ahead, here)
    ):
        return other
    for action in range(STAY):
        beside = near[here * ACTIONS + action]
        if beside == floor.closed or beside % size == ahead:
            continue
        other = robot_in[beside % size]
        if (
            other != NOBODY
            and needs_swap(floor, team, fields, other, robot, here, ahead)
            and can_swap(floor, team, ahead, here)
        ):
            return other
    return NOBODY


@kernel
def begin(floor: Floor, team: Team, fields: Table, robot: int) -> None:
    """Let a robot begin to choose: the best place first, or the worst if it backs off."""
    if team.is_sorted[0] == 0:
        sort_choices(floor, team, fields, robot)
    team.tried[robot] = 0
    partner = swap_partner(floor, team, fields, robot)
    team.partner[robot] = partner
    if partner != NOBODY:
        first, last = robot * ACTIONS, robot * ACTIONS + team.options[robot] - 1
        choices = team.choices
        while first < last:
            choices[first], choices[last] = choices[last], choices[first]
            first, last = first + 1, last - 1


@kernel
def pull(floor: Floor, team: Team, robot: int) -> None:
    """Let the robot that swaps with one that backs off follow it, if both can."""
    partner, here = team.partner[robot], team.places[robot] % floor.size
    if partner == NOBODY or team.tried[robot] != 1 or team.chosen[partner] != UNDECIDED:
        return
    if team.is_taken[here]:
        return
    for action in range(STAY):
        to = floor.near[team.places[partner] * ACTIONS + action]
        if to != floor.closed and to % floor.size == here:
            team.chosen[partner] = to
            team.is_taken[here] = CHOSEN


@kernel
def choose(floor: Floor, team: Team, fields: Table) -> bool:
    """Choose the next places of all undecided robots, in one round of PIBT.

    The round is a loop with a stack, since chains of thousands of robots that push each other
    would exceed Python's limit on recursion.

    Returns:
        True if each robot has a cell of its own. It is false only if the cell of an undecided
        robot was taken before.
    """
    size, places, chosen, is_taken = floor.size, team.places, team.chosen, team.is_taken
    robot_in, choices, options, tried = team.robot_in, team.choices, team.options, team.tried
    is_complete = True
    if team.is_sorted[0] == 0:
        draw(team.random)
    for at in range(len(team.order)):
        robot, depth = team.order[at], 0
        if chosen[robot] != UNDECIDED:
            continue
        begin(floor, team, fields, robot)
        while True:
            here, other, is_found = places[robot] % size, NOBODY, False
            while tried[robot] < options[robot] and not is_found:
                place = choices[robot * ACTIONS + tried[robot]]
                tried[robot] += 1
                cell = place % size
                other = robot_in[cell]
                if (is_taken[cell] and (cell != here or is_taken[cell] == CHOSEN)) or (
                    other != NOBODY
                    and other != robot
                    and chosen[other] != UNDECIDED
                    and chosen[other] % size == here
                ):
                    continue  # somebody else will be there, or they would change places
                chosen[robot], is_taken[cell], is_found = place, CHOSEN, True
            if is_found and other not in (NOBODY, robot) and chosen[other] == UNDECIDED:
                team.stack[depth] = robot
                depth += 1
                team.pushers[other] = robot
                robot = other
                begin(floor, team, fields, robot)
                continue
            if is_found:  # the cell will be free, so all who pushed get theirs
                pull(floor, team, robot)
                while depth > 0:
                    depth -= 1
                    pull(floor, team, team.stack[depth])
                break
            # Nothing is left to try: it stays, and who pushed it tries another cell.
            chosen[robot] = places[robot]
            team.pushers[robot] = NOBODY
            is_complete = is_complete and (depth > 0 or is_taken[here] != CHOSEN)
            is_taken[here] = CHOSEN
            if depth == 0:
                break
            depth -= 1
            robot = team.stack[depth]
    return is_complete
