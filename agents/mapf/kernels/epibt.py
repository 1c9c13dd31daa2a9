"""One joint step by EPIBT: each robot chooses its next few actions, in the order of priorities.

An *operation* is a sequence of actions, one for each step of a window. A robot takes the best
operation whose way meets no robot that has chosen. Those that have not chosen are expected to do
the rest of what they chose in the step before, and then to wait. Whoever of them it meets it
pushes: they choose next, one after the other, and if one finds no way, the robot tries its next
operation, and those pushed before are as they were. With windows, a robot that has to turn before
it leaves a cell can be pushed out of it.

Source: Yukhnevich and Andreychuk (2025), Enhancing PIBT via multi-action operations.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from agents.mapf.kernels.buffers import Buffer, Table, buffer, buffer_of, kernel, table_of
from agents.mapf.kernels.pibt import CHANCE_KEY
from agents.mapf.kernels.places import FORWARD, NONE, STAY, TURNS
from agents.mapf.kernels.robots import NOBODY, SPREAD, UNDECIDED, Robots, draw, mix
from warehouse_core.world.moves import LEFT, RIGHT
from warehouse_core.world.tables import Integers

BLOCKED, IN_VAIN = -2, -3
"""Stand for what nobody can be pushed out of, and for a robot that was pushed in vain."""

FREE, CHOOSING, CHOSEN = range(3)
"""States of a robot: it has not chosen; it chooses, or pushes others; it has its way."""

MAX_VISITS = 8
"""Most times that a robot is pushed in a step, which bounds the time that it takes."""

USED = 1 << 62
"""Key of an operation that leads into a wall, or has been tried."""

END_WEIGHT, CHANCE_KEYS = 4, CHANCE_KEY + 1
"""Weight of the distance at the end of the window against those before; keys by chance."""

OPERATION_STEPS = 3
"""Steps for which robots choose their actions in a round."""


class Epibt(NamedTuple):
    """What EPIBT knows of ``R`` robots; all buffers are ``[R]`` but for those that say so.

    Attributes:
        window: steps of an operation, ``W``.
        ahead: ``[size * 4]``, cell that a move N, E, S or W leads to, or ``NONE``.
        operations: ``[N * W]``, actions of each operation; the first one waits.
        parents: ``[M]``, for each beginning of an operation the one that is an action shorter; the
            first one has no action, and the last ``N`` are the operations.
        actions: ``[M]``, last action of each beginning.
        within: ``[W * N]``, for each step of the window the beginning of each operation up to it.
        cells: ``[M]``, cell that each beginning leads a robot to, or ``NONE``.
        headings: ``[M]``, heading in which it gets there.
        passed: ``[M]``, sum of its distances from the goal after each action up to there.
        ways: ``[R * W]``, places after each step of the window.
        kept: ``[R * W]``, places after each step if they go on as expected.
        states: ``FREE``, ``CHOOSING`` or ``CHOSEN``.
        visits: number of times that each has begun to choose in this step.
        pushed: robot that each has pushed last in vain, or ``NOBODY``.
        pushed_at: step of the window in which it would have met that one.
        met_at: ``[1]``, step of the window in which a way has met a robot.
        keys: ``[R * N]``, keys of the operations of robots in the stack, the least is the best.
        marks: length of the trail when each began its operation.
        trail: robots that have chosen in this turn, and number of them at the end, ``[R + 1]``.
        holder: ``[W * size]``, robot whose way is in each cell after each step, or ``NOBODY``;
            those that are ``FREE`` have none.
        expected: ``[W * size]``, robot that is expected in each cell, likewise.
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
    ways: Buffer
    kept: Buffer
    states: Buffer
    visits: Buffer
    pushed: Buffer
    pushed_at: Buffer
    met_at: Buffer
    keys: Buffer
    marks: Buffer
    trail: Buffer
    holder: Buffer
    expected: Buffer


def epibt_of(ahead: Integers, robots: int) -> Epibt:
    """Return the buffers of EPIBT; see ``Epibt`` for ``ahead``, ``[size, 4]``."""
    operations = turning_operations(OPERATION_STEPS)
    (size, _), (count, window) = ahead.shape, operations.shape
    parents, actions, within = beginnings(operations)
    number = len(parents)
    return Epibt(
        window=window, ahead=table_of(ahead.astype(np.int32)), operations=buffer_of(operations),
        parents=buffer_of(np.array(parents)), actions=buffer_of(np.array(actions)),
        within=buffer_of(np.array(within)), cells=buffer(number), headings=buffer(number),
        passed=buffer(number), ways=buffer(robots * window, NONE), kept=buffer(robots * window),
        states=buffer(robots), visits=buffer(robots), pushed=buffer(robots),
        pushed_at=buffer(robots), met_at=buffer(1), keys=buffer(robots * count),
        marks=buffer(robots), trail=buffer(robots + 1), holder=buffer(window * size, NOBODY),
        expected=buffer(window * size, NOBODY),
    )  # fmt: skip


def turning_operations(window: int) -> Integers:
    """Return sequences of moves, turns and waits through a window, the one of waits first.

    The actions are ``FORWARD``, ``RIGHT``, ``LEFT`` and ``STAY``. Of several sequences that lead
    through the same cells to the same heading, the one with the fewest turns is left, and of these
    the one that turns first.
    """
    found: dict[tuple[object, ...], tuple[int, ...]] = {}
    every = product((FORWARD, RIGHT, LEFT, STAY), repeat=window)
    for actions in sorted(every, key=lambda each: (each.count(RIGHT) + each.count(LEFT), each)):
        place, heading, way = 0j, 1 + 0j, list[object]()
        for action in actions:
            heading *= {RIGHT: 1j, LEFT: -1j}.get(action, 1)
            place += heading * (action == FORWARD)
            way.append(place)
        found.setdefault((*way, heading), actions)
    return np.array(sorted(found.values(), key=lambda each: each != (STAY,) * window))


def beginnings(operations: Integers) -> tuple[list[int], list[int], list[int]]:
    """Return ``parents``, ``actions`` and ``within`` of an ``Epibt`` for operations, ``[N, W]``."""
    found: dict[tuple[int, ...], int] = {(): 0}
    within = [
        found.setdefault(tuple(actions), len(found))
        for length in range(1, operations.shape[1] + 1)
        for actions in operations[:, :length].tolist()
    ]
    parents = [found[actions[:-1]] for actions in found]
    return parents, [STAY, *(actions[-1] for actions in found if actions)], within


@kernel
def hold(robots: Robots, epibt: Epibt, robot: int) -> None:
    """Enter the way of a robot."""
    for time in range(epibt.window):
        cell = epibt.ways[robot * epibt.window + time] % robots.size
        epibt.holder[time * robots.size + cell] = robot


@kernel
def release(robots: Robots, epibt: Epibt, robot: int) -> None:
    """Remove the way of a robot."""
    for time in range(epibt.window):
        cell = epibt.ways[robot * epibt.window + time] % robots.size
        epibt.holder[time * robots.size + cell] = NOBODY


@kernel
def go_on(robots: Robots, epibt: Epibt, robot: int) -> None:
    """Let a robot choose what is expected of it."""
    for at in range(robot * epibt.window, (robot + 1) * epibt.window):
        epibt.ways[at] = epibt.kept[at]
    epibt.states[robot] = CHOSEN
    hold(robots, epibt, robot)


@kernel
def keep(robots: Robots, epibt: Epibt, robot: int, waits: bool) -> None:
    """Expect a robot to do the rest of its way and then wait, or to wait only."""
    first, place = robot * epibt.window, robots.places[robot]
    for at in range(first, first + epibt.window):
        if not waits and at + 1 < first + epibt.window:
            place = epibt.ways[at + 1]
        epibt.kept[at] = place


@kernel
def misses(robots: Robots, epibt: Epibt, robot: int) -> int:
    """Return a robot that cannot go on as expected since it meets another, or ``NOBODY``.

    It is the robot given, or the one that enters a cell in which this one waits.
    """
    size, before, moves = robots.size, robots.places[robot] % robots.size, False
    found = NOBODY
    for time in range(epibt.window):
        cell = epibt.kept[robot * epibt.window + time] % size
        other = epibt.expected[time * size + cell]
        if other != robot:
            found = other
        if cell != before:
            moves = True
            there = robots.robot_in[cell] if time == 0 else epibt.expected[(time - 1) * size + cell]
            is_swap = there != NOBODY and epibt.expected[time * size + before] == there
            if is_swap or robots.is_closed[cell]:
                return robot
        before = cell
    return robot if found != NOBODY and moves else found


@kernel
def expect(robots: Robots, epibt: Epibt) -> None:
    """Set what is expected of all robots, so that no two meet."""
    for robot in range(len(robots.places)):
        is_lost = epibt.ways[robot * epibt.window] != robots.places[robot]
        keep(robots, epibt, robot, is_lost or epibt.states[robot] == CHOSEN)
    is_changed = True
    while is_changed:
        is_changed = False
        for at in range(len(epibt.expected)):
            epibt.expected[at] = NOBODY
        for robot in range(len(robots.places)):
            for time in range(epibt.window):
                cell = epibt.kept[robot * epibt.window + time] % robots.size
                epibt.expected[time * robots.size + cell] = robot
        for robot in range(len(robots.places)):
            other = misses(robots, epibt, robot)
            if other != NOBODY:
                keep(robots, epibt, other, True)
                is_changed = True


@kernel
def who(robots: Robots, epibt: Epibt, time: int, cell: int, robot: int) -> int:
    """Return who but a robot is in a cell after a step of the window, or before the first."""
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
    """Let robots that have chosen since the trail had a length be free again."""
    last = len(epibt.trail) - 1
    while epibt.trail[last] > mark:
        epibt.trail[last] -= 1
        robot = epibt.trail[epibt.trail[last]]
        release(robots, epibt, robot)
        epibt.states[robot] = FREE


@kernel
def entered(epibt: Epibt, cell: int, heading: int, action: int) -> int:
    """Return the cell in which a robot is after an action, or ``NONE`` if a wall is there."""
    if action == STAY:
        return cell
    return epibt.ahead[cell * STAY + heading] if action == FORWARD else cell


@kernel
def turned(heading: int, action: int) -> int:
    """Return the heading of a robot after an action."""
    if action in (FORWARD, STAY):
        return heading
    return (heading + TURNS - 2 * action) & 3


@kernel
def follow(robots: Robots, epibt: Epibt, robot: int, operation: int) -> None:
    """Write the places of an operation into the route of a robot; they must not be walls."""
    cell, heading = robots.places[robot] % robots.size, robots.places[robot] // robots.size
    for time in range(epibt.window):
        action = epibt.operations[operation * epibt.window + time]
        cell = entered(epibt, cell, heading, action)
        heading = turned(heading, action)
        epibt.ways[robot * epibt.window + time] = heading * robots.size + cell


@kernel
def weigh(robots: Robots, epibt: Epibt, fields: Table, robot: int, depth: int) -> None:
    """Write the keys of all operations of a robot, which begin with the same actions in part."""
    count, number = len(epibt.operations) // epibt.window, len(epibt.parents)
    cells, headings, passed, row = epibt.cells, epibt.headings, epibt.passed, robots.rows[robot]
    bits, place = mix(robots.random[0] + robot * SPREAD), robots.places[robot]
    cells[0], headings[0], passed[0] = place % robots.size, place // robots.size, 0
    for at in range(1, number):
        parent, action = epibt.parents[at], epibt.actions[at]
        cell, heading, left = cells[parent], headings[parent], 0
        if cell != NONE:
            cell = entered(epibt, cell, heading, action)
            heading = turned(heading, action)
        if cell != NONE:
            left = fields[row + heading * robots.size + cell]
        operation = at - number + count
        if operation < 0:
            cells[at], headings[at], passed[at] = cell, heading, passed[parent] + left
            continue
        key = USED
        if cell != NONE:
            key = (passed[parent] + END_WEIGHT * left) * CHANCE_KEYS
            if operation > 0:  # waiting is best where nothing else brings a robot nearer
                key += 1 + (bits + operation * 5) % CHANCE_KEY
        epibt.keys[depth * count + operation] = key


@kernel
def begin(robots: Robots, epibt: Epibt, fields: Table, robot: int, depth: int) -> None:
    """Let a robot begin to choose, with as many in the stack."""
    epibt.states[robot], epibt.pushed[robot] = CHOOSING, NOBODY
    epibt.visits[robot] += 1
    weigh(robots, epibt, fields, robot, depth)


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
def shut(epibt: Epibt, depth: int, operation: int, time: int) -> None:
    """Let a robot try no operation that is the same as one up to a step of the window."""
    count = len(epibt.operations) // epibt.window
    for other in range(count):
        if epibt.within[time * count + other] == epibt.within[time * count + operation]:
            epibt.keys[depth * count + other] = USED


@kernel
def meets(robots: Robots, epibt: Epibt, robot: int) -> int:
    """Return the first robot that the way of a robot meets, ``NOBODY``, or ``BLOCKED``.

    Robots that are not free, or have chosen too often, and closed cells block the way. It is
    ``IN_VAIN`` if a robot that was pushed in vain would be met as early or later.
    """
    found, before = NOBODY, robots.places[robot] % robots.size
    for time in range(epibt.window):
        cell = epibt.ways[robot * epibt.window + time] % robots.size
        other, opposite = who(robots, epibt, time, cell, robot), NOBODY
        if cell != before:
            if robots.is_closed[cell]:
                epibt.met_at[0] = time
                return BLOCKED
            opposite = who(robots, epibt, time - 1, cell, robot)
            if opposite != NOBODY and who(robots, epibt, time, before, robot) != opposite:
                opposite = NOBODY
        for one in (other, opposite):
            if one == NOBODY:
                continue
            if epibt.states[one] != FREE or epibt.visits[one] >= MAX_VISITS:
                epibt.met_at[0] = time
                return BLOCKED
            if found == NOBODY:
                found, epibt.met_at[0] = one, time
        before = cell
    is_vain = found == epibt.pushed[robot] and epibt.met_at[0] <= epibt.pushed_at[robot]
    return IN_VAIN if found != NOBODY and is_vain else found


@kernel
def push(robots: Robots, epibt: Epibt, fields: Table, robot: int) -> bool:
    """Let a free robot choose, and those that it pushes; return whether it has found a way.

    Those that have chosen are on the trail then. Otherwise all are as they were.
    """
    last, depth, other = len(epibt.trail) - 1, 0, IN_VAIN
    epibt.trail[last] = 0
    begin(robots, epibt, fields, robot, depth)
    while True:
        if other < NOBODY:  # the operation does not do, or there is none yet
            operation = next_operation(epibt, depth)
            if operation == NONE:
                epibt.states[robot] = FREE
                if depth == 0:
                    return False
                depth -= 1
                robot = robots.stack[depth]
                release(robots, epibt, robot)
                undo(robots, epibt, epibt.marks[robot])
                continue
            follow(robots, epibt, robot, operation)
            epibt.marks[robot] = epibt.trail[last]
            other = meets(robots, epibt, robot)
            if other == BLOCKED:
                shut(epibt, depth, operation, epibt.met_at[0])
            if other < NOBODY:
                continue
            hold(robots, epibt, robot)
        if other != NOBODY:
            epibt.pushed[robot], epibt.pushed_at[robot] = other, epibt.met_at[0]
            robots.stack[depth] = robot
            depth += 1
            robot, other = other, IN_VAIN
            begin(robots, epibt, fields, robot, depth)
            continue
        epibt.states[robot] = CHOSEN
        epibt.trail[epibt.trail[last]] = robot
        epibt.trail[last] += 1
        if depth == 0:
            return True
        depth -= 1
        robot = robots.stack[depth]
        other = meets(robots, epibt, robot)
        if other < NOBODY:
            release(robots, epibt, robot)
            undo(robots, epibt, epibt.marks[robot])


@kernel
def choose(robots: Robots, epibt: Epibt, fields: Table) -> bool:
    """Choose the next places of all undecided robots, in one round of EPIBT.

    The others are expected to wait after this step.

    Returns:
        False if an undecided robot finds no way out of a cell that one of the others enters.
    """
    count, window, chosen = len(robots.order), epibt.window, robots.chosen
    draw(robots.random)
    for robot in range(count):
        epibt.visits[robot] = 0
        epibt.states[robot] = FREE if chosen[robot] == UNDECIDED else CHOSEN
    for at in range(len(epibt.holder)):
        epibt.holder[at] = NOBODY
    expect(robots, epibt)
    for robot in range(count):
        if epibt.states[robot] == CHOSEN:
            for at in range(robot * window, (robot + 1) * window):
                epibt.ways[at] = chosen[robot]
            hold(robots, epibt, robot)
    for turn in range(2):  # those who cannot go on as expected choose first
        for at in range(count):
            robot = robots.order[at]
            is_held = epibt.holder[epibt.kept[robot * window] % robots.size] != NOBODY
            if epibt.states[robot] == CHOSEN or (turn == 0 and not is_held):
                continue
            if push(robots, epibt, fields, robot):
                continue
            if is_held:
                for other in range(count):
                    if epibt.states[other] == FREE:
                        epibt.ways[other * window] = NONE  # nothing is expected of it any more
                return False
            go_on(robots, epibt, robot)
    for robot in range(count):
        chosen[robot] = epibt.ways[robot * window]
    return True
