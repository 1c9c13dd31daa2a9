"""EPIBT, enhanced PIBT: each robot chooses its next few actions, in order of priority.

An *operation* is a sequence of actions, one for each step of a window. A robot takes the best
operation whose path does not collide with a robot that has already chosen. A robot that has not
chosen yet is expected to complete its operation from the previous step and then to wait. If the
path collides with such a robot, the first robot pushes it: the pushed robot chooses next. If a
pushed robot finds no path, the choices since the push are undone and the first robot tries its next
operation.

With windows, a robot that has to turn before it leaves a cell can still be pushed out of it.

Source: Yukhnevich and Andreychuk (2025), Enhancing PIBT via multi-action operations.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from agents.mapf.kernels.buffers import Buffer, Table, buffer, buffer_of, table_of
from agents.mapf.kernels.pibt import CHANCE_KEY
from agents.mapf.kernels.places import FORWARD, NONE, STAY, TURNS
from agents.mapf.kernels.robots import NOBODY, SPREAD, UNDECIDED, Robots, draw, mix
from warehouse_core.compiled import kernel
from warehouse_core.world.moves import LEFT, RIGHT
from warehouse_core.world.tables import Integers

BLOCKED, PUSHED_IN_VAIN = -2, -3
"""Results of ``first_collision``: an obstacle that cannot be pushed, or was pushed in vain."""

FREE, CHOOSING, CHOSEN = range(3)
"""States of a robot: it has not chosen, it is choosing or pushing others, or it has chosen."""

MAX_VISITS = 8
"""Limit on how often a robot is pushed in one step, which bounds the computing time."""

USED = 1 << 62
"""Key of an operation that leads into a wall or has been tried."""

END_WEIGHT, CHANCE_KEYS = 4, CHANCE_KEY + 1
"""Weight of the distance at the end of the window, and number of random values in a key."""

OPERATION_STEPS = 3
"""Length of an operation in steps."""


class Epibt(NamedTuple):
    """State of EPIBT for ``R`` robots. The shape of a buffer is ``[R]`` unless stated otherwise.

    Operations that begin with the same actions share a *prefix*, so that each prefix is simulated
    only once.

    Attributes:
        window: steps of an operation, ``W``.
        ahead: ``[size * 4]``, cell that a move N, E, S or W leads to, or ``NONE``.
        operations: ``[N * W]``, actions of each operation. The first operation waits.
        parents: ``[M]``, for each prefix, the prefix that is one action shorter. The first prefix
            is empty, and the last ``N`` are the whole operations.
        actions: ``[M]``, last action of each prefix.
        within: ``[W * N]``, for each step of the window, the prefix of each operation up to it.
        cells: ``[M]``, cell in which each prefix ends, or ``NONE``.
        headings: ``[M]``, heading in which each prefix ends.
        passed: ``[M]``, sum of the distances from the goal after each action of the prefix.
        paths: ``[R * W]``, chosen places after each step of the window.
        expected_places: ``[R * W]``, expected places after each step of the window.
        states: ``FREE``, ``CHOOSING`` or ``CHOSEN``.
        visits: number of times that each robot has begun to choose in this step.
        pushed: robot that each robot has last pushed in vain, or ``NOBODY``.
        pushed_at: step of the window in which these two would have collided.
        collision_time: ``[1]``, step of the window of the result of ``first_collision``.
        keys: ``[R * N]``, keys of the operations of the robots in the stack. The least key is best.
        marks: length of the trail when each robot began its operation.
        trail: ``[R + 1]``, robots that have chosen in this turn. The last entry is their number.
        holder: ``[W * size]``, robot whose chosen path has each cell after each step, or
            ``NOBODY``. Robots that are ``FREE`` hold no cells.
        expected: ``[W * size]``, robot that is expected in each cell after each step, or
            ``NOBODY``.
    """

    window: int
    ahead: Table
    operations: Buffer
    parents: Buffer
    actions: Buffer
    within: Buffer
    cells: Buffer
    headings: Buffer
    passed: Buffer
    paths: Buffer
    expected_places: Buffer
    states: Buffer
    visits: Buffer
    pushed: Buffer
    pushed_at: Buffer
    collision_time: Buffer
    keys: Buffer
    marks: Buffer
    trail: Buffer
    holder: Buffer
    expected: Buffer


def epibt_of(ahead: Integers, robots: int) -> Epibt:
    """Return the buffers of EPIBT; ``ahead`` is ``[size, 4]`` and described in ``Epibt``."""
    operations = turning_operations(OPERATION_STEPS)
    (size, _), (count, window) = ahead.shape, operations.shape
    parents, actions, within = prefixes(operations)
    number = len(parents)
    return Epibt(
        window=window, ahead=table_of(ahead.astype(np.int32)), operations=buffer_of(operations),
        parents=buffer_of(np.array(parents)), actions=buffer_of(np.array(actions)),
        within=buffer_of(np.array(within)), cells=buffer(number), headings=buffer(number),
        passed=buffer(number), paths=buffer(robots * window, NONE),
        expected_places=buffer(robots * window),
        states=buffer(robots), visits=buffer(robots), pushed=buffer(robots),
        pushed_at=buffer(robots), collision_time=buffer(1), keys=buffer(robots * count),
        marks=buffer(robots), trail=buffer(robots + 1), holder=buffer(window * size, NOBODY),
        expected=buffer(window * size, NOBODY),
    )  # fmt: skip


def turning_operations(window: int) -> Integers:
    """Return all useful sequences of moves, turns and waits through a window, ``[N, window]``.

    The actions are ``FORWARD``, ``RIGHT``, ``LEFT`` and ``STAY``. The first sequence only waits. If
    several sequences lead through the same cells to the same heading, the result has only the one
    with the fewest turns, and among equals the one that turns first.
    """
    operations: dict[tuple[object, ...], tuple[int, ...]] = {}
    every = product((FORWARD, RIGHT, LEFT, STAY), repeat=window)
    for actions in sorted(every, key=lambda each: (each.count(RIGHT) + each.count(LEFT), each)):
        place, heading, cells_passed = 0j, 1 + 0j, list[object]()
        for action in actions:
            heading *= {RIGHT: 1j, LEFT: -1j}.get(action, 1)
            place += heading * (action == FORWARD)
            cells_passed.append(place)
        operations.setdefault((*cells_passed, heading), actions)
    return np.array(sorted(operations.values(), key=lambda each: each != (STAY,) * window))


def prefixes(operations: Integers) -> tuple[list[int], list[int], list[int]]:
    """Return ``parents``, ``actions`` and ``within`` of an ``Epibt`` for operations, ``[N, W]``."""
    numbers: dict[tuple[int, ...], int] = {(): 0}
    within = [
        numbers.setdefault(tuple(actions), len(numbers))
        for length in range(1, operations.shape[1] + 1)
        for actions in operations[:, :length].tolist()
    ]
    parents = [numbers[actions[:-1]] for actions in numbers]
    return parents, [STAY, *(actions[-1] for actions in numbers if actions)], within


@kernel
def hold_path(robots: Robots, epibt: Epibt, robot: int, holder: int) -> None:
    """Reserve the cells of the chosen path of a robot for a holder: the robot, or ``NOBODY``."""
    for time in range(epibt.window):
        cell = epibt.paths[robot * epibt.window + time] % robots.size
        epibt.holder[time * robots.size + cell] = holder


@kernel
def set_expected(robots: Robots, epibt: Epibt, robot: int, waits: bool) -> None:
    """Expect a robot to complete its path and then wait, or only to wait if ``waits``."""
    first, place = robot * epibt.window, robots.places[robot]
    for at in range(first, first + epibt.window):
        if not waits and at + 1 < first + epibt.window:
            place = epibt.paths[at + 1]
        epibt.expected_places[at] = place


@kernel
def colliding_robot(robots: Robots, epibt: Epibt, robot: int) -> int:
    """Return a robot whose expected path is impossible because of a collision, or ``NOBODY``.

    The result is the given robot, or another robot that would enter a cell in which the given one
    waits.
    """
    size, before, moves = robots.size, robots.places[robot] % robots.size, False
    result = NOBODY
    for time in range(epibt.window):
        cell = epibt.expected_places[robot * epibt.window + time] % size
        other = epibt.expected[time * size + cell]
        if other != robot:
            result = other
        if cell != before:
            moves = True
            there = robots.robot_in[cell] if time == 0 else epibt.expected[(time - 1) * size + cell]
            is_swap = there != NOBODY and epibt.expected[time * size + before] == there
            if is_swap or robots.is_closed[cell]:
                return robot
        before = cell
    return robot if result != NOBODY and moves else result


@kernel
def set_all_expected(robots: Robots, epibt: Epibt) -> None:
    """Set the expected paths of all robots so that no two of them collide."""
    for robot in range(len(robots.places)):
        is_lost = epibt.paths[robot * epibt.window] != robots.places[robot]
        set_expected(robots, epibt, robot, is_lost or epibt.states[robot] == CHOSEN)
    is_changed = True
    while is_changed:
        is_changed = False
        for at in range(len(epibt.expected)):
            epibt.expected[at] = NOBODY
        for robot in range(len(robots.places)):
            for time in range(epibt.window):
                cell = epibt.expected_places[robot * epibt.window + time] % robots.size
                epibt.expected[time * robots.size + cell] = robot
        for robot in range(len(robots.places)):
            other = colliding_robot(robots, epibt, robot)
            if other != NOBODY:
                set_expected(robots, epibt, other, True)
                is_changed = True


@kernel
def robot_at(robots: Robots, epibt: Epibt, time: int, cell: int, robot: int) -> int:
    """Return the other robot in a cell after a step of the window, or before its first step."""
    if time < 0:
        return robots.robot_in[cell]
    at = time * robots.size + cell
    holder = epibt.holder[at]
    if holder not in (NOBODY, robot):
        return holder
    there = epibt.expected[at]
    return there if there != NOBODY and epibt.states[there] == FREE else NOBODY


@kernel
def undo(robots: Robots, epibt: Epibt, mark: int) -> None:
    """Free the robots that have chosen since the trail had the length ``mark``."""
    last = len(epibt.trail) - 1
    while epibt.trail[last] > mark:
        epibt.trail[last] -= 1
        robot = epibt.trail[epibt.trail[last]]
        hold_path(robots, epibt, robot, NOBODY)
        epibt.states[robot] = FREE


@kernel
def cell_after(epibt: Epibt, cell: int, heading: int, action: int) -> int:
    """Return the cell of a robot after an action, or ``NONE`` if the action leads into a wall."""
    if action == STAY:
        return cell
    return epibt.ahead[cell * STAY + heading] if action == FORWARD else cell


@kernel
def heading_after(heading: int, action: int) -> int:
    """Return the heading of a robot after an action."""
    if action in (FORWARD, STAY):
        return heading
    return (heading + TURNS - 2 * action) & 3


@kernel
def write_path(robots: Robots, epibt: Epibt, robot: int, operation: int) -> None:
    """Write the places of an operation into the path of a robot; none may be a wall."""
    cell, heading = robots.places[robot] % robots.size, robots.places[robot] // robots.size
    for time in range(epibt.window):
        action = epibt.operations[operation * epibt.window + time]
        cell = cell_after(epibt, cell, heading, action)
        heading = heading_after(heading, action)
        epibt.paths[robot * epibt.window + time] = heading * robots.size + cell


@kernel
def write_keys(robots: Robots, epibt: Epibt, fields: Table, robot: int, depth: int) -> None:
    """Write the keys of all operations of a robot, with one calculation for each shared prefix."""
    count, number = len(epibt.operations) // epibt.window, len(epibt.parents)
    cells, headings, passed, row = epibt.cells, epibt.headings, epibt.passed, robots.rows[robot]
    bits, place = mix(robots.random[0] + robot * SPREAD), robots.places[robot]
    cells[0], headings[0], passed[0] = place % robots.size, place // robots.size, 0
    for at in range(1, number):
        parent, action = epibt.parents[at], epibt.actions[at]
        cell, heading, left = cells[parent], headings[parent], 0
        if cell != NONE:
            cell = cell_after(epibt, cell, heading, action)
            heading = heading_after(heading, action)
        if cell != NONE:
            left = fields[row + heading * robots.size + cell]
        operation = at - number + count
        if operation < 0:
            cells[at], headings[at], passed[at] = cell, heading, passed[parent] + left
            continue
        key = USED
        if cell != NONE:
            key = (passed[parent] + END_WEIGHT * left) * CHANCE_KEYS
            if operation > 0:  # prefer waiting if no operation leads nearer
                key += 1 + (bits + operation * 5) % CHANCE_KEY
        epibt.keys[depth * count + operation] = key


@kernel
def begin(robots: Robots, epibt: Epibt, fields: Table, robot: int, depth: int) -> None:
    """Start the choice of a robot while ``depth`` robots are in the stack."""
    epibt.states[robot], epibt.pushed[robot] = CHOOSING, NOBODY
    epibt.visits[robot] += 1
    write_keys(robots, epibt, fields, robot, depth)


@kernel
def next_operation(epibt: Epibt, depth: int) -> int:
    """Return the best operation that a robot has not tried, or ``NONE``."""
    count = len(epibt.operations) // epibt.window
    best, least = NONE, USED
    for operation in range(count):
        key = epibt.keys[depth * count + operation]
        if key < least:
            best, least = operation, key
    if best != NONE:
        epibt.keys[depth * count + best] = USED
    return best


@kernel
def exclude(epibt: Epibt, depth: int, operation: int, time: int) -> None:
    """Rule out all operations that equal the given one up to a step of the window."""
    count = len(epibt.operations) // epibt.window
    for other in range(count):
        if epibt.within[time * count + other] == epibt.within[time * count + operation]:
            epibt.keys[depth * count + other] = USED


@kernel
def first_collision(robots: Robots, epibt: Epibt, robot: int) -> int:
    """Return the first robot that the path of a robot collides with, ``NOBODY``, or ``BLOCKED``.

    ``BLOCKED`` stands for closed cells and for robots that are not free or were pushed too often.
    The result is ``PUSHED_IN_VAIN`` if pushing the same robot has failed before and the collision
    is not later than the one before.
    """
    result, before = NOBODY, robots.places[robot] % robots.size
    for time in range(epibt.window):
        cell = epibt.paths[robot * epibt.window + time] % robots.size
        other, opposite = robot_at(robots, epibt, time, cell, robot), NOBODY
        if cell != before:
            if robots.is_closed[cell]:
                epibt.collision_time[0] = time
                return BLOCKED
            opposite = robot_at(robots, epibt, time - 1, cell, robot)
            if opposite != NOBODY and robot_at(robots, epibt, time, before, robot) != opposite:
                opposite = NOBODY
        for one in (other, opposite):
            if one == NOBODY:
                continue
            if epibt.states[one] != FREE or epibt.visits[one] >= MAX_VISITS:
                epibt.collision_time[0] = time
                return BLOCKED
            if result == NOBODY:
                result, epibt.collision_time[0] = one, time
        before = cell
    is_vain = result == epibt.pushed[robot] and epibt.collision_time[0] <= epibt.pushed_at[robot]
    return PUSHED_IN_VAIN if result != NOBODY and is_vain else result


@kernel
def push(robots: Robots, epibt: Epibt, fields: Table, robot: int) -> bool:
    """Let a free robot choose, with all robots that it pushes; return whether it has found a path.

    On success, the robots that have chosen are on the trail. Otherwise nothing has changed.
    """
    last, depth, other = len(epibt.trail) - 1, 0, PUSHED_IN_VAIN
    epibt.trail[last] = 0
    begin(robots, epibt, fields, robot, depth)
    while True:
        if other < NOBODY:  # the operation is not possible, or there is none yet
            operation = next_operation(epibt, depth)
            if operation == NONE:
                epibt.states[robot] = FREE
                if depth == 0:
                    return False
                depth -= 1
                robot = robots.stack[depth]
                hold_path(robots, epibt, robot, NOBODY)
                undo(robots, epibt, epibt.marks[robot])
                continue
            write_path(robots, epibt, robot, operation)
            epibt.marks[robot] = epibt.trail[last]
            other = first_collision(robots, epibt, robot)
            if other == BLOCKED:
                exclude(epibt, depth, operation, epibt.collision_time[0])
            if other < NOBODY:
                continue
            hold_path(robots, epibt, robot, robot)
        if other != NOBODY:
            epibt.pushed[robot], epibt.pushed_at[robot] = other, epibt.collision_time[0]
            robots.stack[depth] = robot
            depth += 1
            robot, other = other, PUSHED_IN_VAIN
            begin(robots, epibt, fields, robot, depth)
            continue
        epibt.states[robot] = CHOSEN
        epibt.trail[epibt.trail[last]] = robot
        epibt.trail[last] += 1
        if depth == 0:
            return True
        depth -= 1
        robot = robots.stack[depth]
        other = first_collision(robots, epibt, robot)
        if other < NOBODY:
            hold_path(robots, epibt, robot, NOBODY)
            undo(robots, epibt, epibt.marks[robot])


@kernel
def choose(robots: Robots, epibt: Epibt, fields: Table) -> bool:
    """Choose the next places of all undecided robots in one round of EPIBT.

    All other robots are expected to wait after this step.

    Returns:
        False if an undecided robot cannot leave a cell that one of the other robots enters.
    """
    count, window, chosen = len(robots.order), epibt.window, robots.chosen
    draw(robots.random)
    for robot in range(count):
        epibt.visits[robot] = 0
        epibt.states[robot] = FREE if chosen[robot] == UNDECIDED else CHOSEN
    for at in range(len(epibt.holder)):
        epibt.holder[at] = NOBODY
    set_all_expected(robots, epibt)
    for robot in range(count):
        if epibt.states[robot] == CHOSEN:
            for at in range(robot * window, (robot + 1) * window):
                epibt.paths[at] = chosen[robot]
            hold_path(robots, epibt, robot, robot)
    for turn in range(2):  # robots that cannot do what is expected of them choose first
        for at in range(count):
            robot = robots.order[at]
            is_held = epibt.holder[epibt.expected_places[robot * window] % robots.size] != NOBODY
            if epibt.states[robot] == CHOSEN or (turn == 0 and not is_held):
                continue
            if push(robots, epibt, fields, robot):
                continue
            if is_held:
                for other in range(count):
                    if epibt.states[other] == FREE:
                        epibt.paths[other * window] = NONE  # no path is expected of it any more
                return False
            for at in range(robot * window, (robot + 1) * window):
                epibt.paths[at] = epibt.expected_places[at]
            epibt.states[robot] = CHOSEN
            hold_path(robots, epibt, robot, robot)
    for robot in range(count):
        chosen[robot] = epibt.paths[robot * window]
    return True
