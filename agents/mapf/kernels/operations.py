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

from typing import NamedTuple

import numpy as np

from agents.mapf.kernels.buffers import Buffer, Table, buffer, buffer_of, kernel, table_of
from agents.mapf.kernels.floor import FORWARD, NONE, STAY, TURNS
from agents.mapf.kernels.rounds import CHANCE_KEY, NOBODY, SPREAD, draw, first_random, mix
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


class Crew(NamedTuple):
    """Robots in a round; all buffers are ``[R]`` but for those that say so.

    Attributes:
        size: number of cells; the cell of a place is its remainder by it.
        window: steps of an operation, ``W``.
        ahead: ``[size * 4]``, cell that a move N, E, S or W leads to, or ``NONE``.
        operations: ``[N * W]``, actions of each operation; the first one waits.
        parents: ``[M]``, for each beginning of an operation the one that is an action shorter; the
            first one has no action, and the last ``N`` are the operations.
        actions: ``[M]``, last action of each beginning.
        within: ``[W * N]``, for each step of the window the beginning of each operation up to it.
        cells: ``[M]``, cell that each beginning leads a robot to, or ``NONE``.
        headings: ``[M]``, heading in which it gets there.
        passed: ``[M]``, sum of its distances from the goal on the way there.
        places: present places.
        rows: index of the distance field of each goal in the table of fields.
        order: robots by falling priority.
        ways: ``[R * W]``, places after each step of the window.
        kept: ``[R * W]``, places after each step if they go on as expected.
        states: ``FREE``, ``CHOOSING`` or ``CHOSEN``.
        visits: number of times that each has begun to choose in this step.
        pushed: robot that each has pushed last in vain, or ``NOBODY``.
        pushed_at: step of the window in which it would have met that one.
        met_at: ``[1]``, step of the window in which a way has met a robot.
        keys: ``[R * N]``, keys of the operations of robots in the stack, the least is the best.
        stack: robots that push others.
        marks: length of the trail when each began its operation.
        trail: robots that have chosen in this turn, and number of them at the end, ``[R + 1]``.
        robot_in: ``[size]``, robot in each cell now, or ``NOBODY``.
        holder: ``[W * size]``, robot whose way is in each cell after each step, or ``NOBODY``;
            those that are ``FREE`` have none.
        expected: ``[W * size]``, robot that is expected in each cell, likewise.
        is_closed: ``[size]``, 1 for cells that nobody can enter.
        random: ``[1]``, state of the random numbers.
    """

    size: int
    window: int
    ahead: Table
    operations: Buffer
    parents: Buffer
    actions: Buffer
    within: Buffer
    cells: Buffer
    headings: Buffer
    passed: Buffer
    places: Buffer
    rows: Buffer
    order: Buffer
    ways: Buffer
    kept: Buffer
    states: Buffer
    visits: Buffer
    pushed: Buffer
    pushed_at: Buffer
    met_at: Buffer
    keys: Buffer
    stack: Buffer
    marks: Buffer
    trail: Buffer
    robot_in: Buffer
    holder: Buffer
    expected: Buffer
    is_closed: Buffer
    random: Buffer


def crew_of(ahead: Integers, operations: Integers, robots: int, seed: int | None) -> Crew:
    """Return the buffers of robots.

    Args:
        ahead: ``[size, 4]``, see ``Crew``.
        operations: ``[N, W]``, likewise.
        robots: number of robots.
        seed: seed of the random numbers.
    """
    (size, _), (count, window) = ahead.shape, operations.shape
    parents, actions, within = beginnings(operations)
    number = len(parents)
    return Crew(
        size=size, window=window, ahead=table_of(ahead.astype(np.int32)),
        operations=buffer_of(operations), parents=buffer_of(np.array(parents)),
        actions=buffer_of(np.array(actions)), within=buffer_of(np.array(within)),
        cells=buffer(number), headings=buffer(number), passed=buffer(number),
        places=buffer(robots), rows=buffer(robots), order=buffer(robots),
        ways=buffer(robots * window, NONE), kept=buffer(robots * window),
        states=buffer(robots), visits=buffer(robots),
        pushed=buffer(robots), pushed_at=buffer(robots), met_at=buffer(1),
        keys=buffer(robots * count), stack=buffer(robots), marks=buffer(robots),
        trail=buffer(robots + 1), robot_in=buffer(size, NOBODY),
        holder=buffer(window * size, NOBODY), expected=buffer(window * size, NOBODY),
        is_closed=buffer(size), random=first_random(seed),
    )  # fmt: skip


def beginnings(operations: Integers) -> tuple[list[int], list[int], list[int]]:
    """Return ``parents``, ``actions`` and ``within`` of a ``Crew`` for operations, ``[N, W]``."""
    found: dict[tuple[int, ...], int] = {(): 0}
    within = [
        found.setdefault(tuple(actions), len(found))
        for length in range(1, operations.shape[1] + 1)
        for actions in operations[:, :length].tolist()
    ]
    parents = [found[actions[:-1]] for actions in found]
    return parents, [STAY, *(actions[-1] for actions in found if actions)], within


@kernel
def hold(crew: Crew, robot: int) -> None:
    """Enter the way of a robot."""
    for time in range(crew.window):
        cell = crew.ways[robot * crew.window + time] % crew.size
        crew.holder[time * crew.size + cell] = robot


@kernel
def release(crew: Crew, robot: int) -> None:
    """Remove the way of a robot."""
    for time in range(crew.window):
        cell = crew.ways[robot * crew.window + time] % crew.size
        crew.holder[time * crew.size + cell] = NOBODY


@kernel
def go_on(crew: Crew, robot: int) -> None:
    """Let a robot choose what is expected of it."""
    for at in range(robot * crew.window, (robot + 1) * crew.window):
        crew.ways[at] = crew.kept[at]
    crew.states[robot] = CHOSEN
    hold(crew, robot)


@kernel
def keep(crew: Crew, robot: int, waits: bool) -> None:
    """Expect a robot to do the rest of its way and then wait, or to wait only."""
    first, place = robot * crew.window, crew.places[robot]
    for at in range(first, first + crew.window):
        if not waits and at + 1 < first + crew.window:
            place = crew.ways[at + 1]
        crew.kept[at] = place


@kernel
def misses(crew: Crew, robot: int) -> int:
    """Return a robot that cannot go on as expected since it meets another, or ``NOBODY``.

    It is the robot given, or the one that enters a cell in which this one waits.
    """
    size, before, moves = crew.size, crew.places[robot] % crew.size, False
    found = NOBODY
    for time in range(crew.window):
        cell = crew.kept[robot * crew.window + time] % size
        other = crew.expected[time * size + cell]
        if other != robot:
            found = other
        if cell != before:
            moves = True
            there = crew.robot_in[cell] if time == 0 else crew.expected[(time - 1) * size + cell]
            is_swap = there != NOBODY and crew.expected[time * size + before] == there
            if is_swap or crew.is_closed[cell]:
                return robot
        before = cell
    return robot if found != NOBODY and moves else found


@kernel
def expect(crew: Crew) -> None:
    """Set what is expected of all robots, so that no two meet."""
    for robot in range(len(crew.places)):
        is_lost = crew.ways[robot * crew.window] != crew.places[robot]
        keep(crew, robot, is_lost or crew.states[robot] == CHOSEN)
    is_changed = True
    while is_changed:
        is_changed = False
        for at in range(len(crew.expected)):
            crew.expected[at] = NOBODY
        for robot in range(len(crew.places)):
            for time in range(crew.window):
                cell = crew.kept[robot * crew.window + time] % crew.size
                crew.expected[time * crew.size + cell] = robot
        for robot in range(len(crew.places)):
            other = misses(crew, robot)
            if other != NOBODY:
                keep(crew, other, True)
                is_changed = True


@kernel
def who(crew: Crew, time: int, cell: int, robot: int) -> int:
    """Return who but a robot is in a cell after a step of the window, or before the first."""
    if time < 0:
        return crew.robot_in[cell]
    at = time * crew.size + cell
    holder = crew.holder[at] + 0
    if holder not in (NOBODY, robot):
        return holder
    there = crew.expected[at] + 0
    return there if there != NOBODY and crew.states[there] == FREE else NOBODY


@kernel
def undo(crew: Crew, mark: int) -> None:
    """Let robots that have chosen since the trail had a length be free again."""
    last = len(crew.trail) - 1
    while crew.trail[last] > mark:
        crew.trail[last] -= 1
        robot = crew.trail[crew.trail[last]]
        release(crew, robot)
        crew.states[robot] = FREE


@kernel
def entered(crew: Crew, cell: int, heading: int, action: int) -> int:
    """Return the cell in which a robot is after an action, or ``NONE`` if a wall is there."""
    if action == STAY:
        return cell
    return crew.ahead[cell * STAY + heading] + 0 if action == FORWARD else cell


@kernel
def turned(heading: int, action: int) -> int:
    """Return the heading of a robot after an action."""
    if action in (FORWARD, STAY):
        return heading
    return (heading + TURNS - 2 * action) & 3


@kernel
def follow(crew: Crew, robot: int, operation: int) -> None:
    """Write the places of an operation into the way of a robot; no wall may be there."""
    cell, heading = crew.places[robot] % crew.size, crew.places[robot] // crew.size
    for time in range(crew.window):
        action = crew.operations[operation * crew.window + time]
        cell = entered(crew, cell, heading, action)
        heading = turned(heading, action)
        crew.ways[robot * crew.window + time] = heading * crew.size + cell


@kernel
def distance(crew: Crew, fields: Table, row: int, cell: int, heading: int) -> int:
    """Return the distance of a robot from the goal of a row."""
    return fields[row + heading * crew.size + cell] + 0


@kernel
def weigh(crew: Crew, fields: Table, robot: int, depth: int) -> None:
    """Write the keys of all operations of a robot, which begin with the same actions in part."""
    count, number = len(crew.operations) // crew.window, len(crew.parents)
    cells, headings, passed, row = crew.cells, crew.headings, crew.passed, crew.rows[robot]
    bits, place = mix(crew.random[0] + robot * SPREAD), crew.places[robot]
    cells[0], headings[0], passed[0] = place % crew.size, place // crew.size, 0
    for at in range(1, number):
        parent, action = crew.parents[at], crew.actions[at]
        cell, heading, left = cells[parent], headings[parent], 0
        if cell != NONE:
            cell = entered(crew, cell, heading, action)
            heading = turned(heading, action)
        if cell != NONE:
            left = distance(crew, fields, row, cell, heading)
        operation = at - number + count
        if operation < 0:
            cells[at], headings[at], passed[at] = cell, heading, passed[parent] + left
            continue
        key = USED
        if cell != NONE:
            key = (passed[parent] + END_WEIGHT * left) * CHANCE_KEYS
            if operation > 0:  # waiting is best where nothing else brings a robot nearer
                key += 1 + (bits + operation * 5) % CHANCE_KEY
        crew.keys[depth * count + operation] = key


@kernel
def begin(crew: Crew, fields: Table, robot: int, depth: int) -> None:
    """Let a robot begin to choose, with as many in the stack."""
    crew.states[robot], crew.pushed[robot] = CHOOSING, NOBODY
    crew.visits[robot] += 1
    weigh(crew, fields, robot, depth)


@kernel
def next_operation(crew: Crew, depth: int) -> int:
    """Return the best operation that a robot has not tried, or ``NONE``."""
    count = len(crew.operations) // crew.window
    best, least = NONE, USED
    for operation in range(count):
        key = crew.keys[depth * count + operation]
        if key < least:
            best, least = operation, key
    if best != NONE:
        crew.keys[depth * count + best] = USED
    return best


@kernel
def shut(crew: Crew, depth: int, operation: int, time: int) -> None:
    """Let a robot try no operation that is the same as one up to a step of the window."""
    count = len(crew.operations) // crew.window
    for other in range(count):
        if crew.within[time * count + other] == crew.within[time * count + operation]:
            crew.keys[depth * count + other] = USED


@kernel
def meets(crew: Crew, robot: int) -> int:
    """Return the first robot that the way of a robot meets, ``NOBODY``, or ``BLOCKED``.

    Robots that are not free, or have chosen too often, and closed cells block the way. It is
    ``IN_VAIN`` if a robot that was pushed in vain would be met as early or later.
    """
    found, before = NOBODY, crew.places[robot] % crew.size
    for time in range(crew.window):
        cell = crew.ways[robot * crew.window + time] % crew.size
        other, opposite = who(crew, time, cell, robot), NOBODY
        if cell != before:
            if crew.is_closed[cell]:
                crew.met_at[0] = time
                return BLOCKED
            opposite = who(crew, time - 1, cell, robot)
            if opposite != NOBODY and who(crew, time, before, robot) != opposite:
                opposite = NOBODY
        for one in (other, opposite):
            if one == NOBODY:
                continue
            if crew.states[one] != FREE or crew.visits[one] >= MAX_VISITS:
                crew.met_at[0] = time
                return BLOCKED
            if found == NOBODY:
                found, crew.met_at[0] = one, time
        before = cell
    is_vain = found == crew.pushed[robot] and crew.met_at[0] <= crew.pushed_at[robot]
    return IN_VAIN if found != NOBODY and is_vain else found


@kernel
def push(crew: Crew, fields: Table, robot: int) -> bool:
    """Let a free robot choose, and those that it pushes; return whether it has found a way.

    Those that have chosen are on the trail then. Otherwise all are as they were.
    """
    last, depth, other = len(crew.trail) - 1, 0, IN_VAIN
    crew.trail[last] = 0
    begin(crew, fields, robot, depth)
    while True:
        if other < NOBODY:  # the operation does not do, or there is none yet
            operation = next_operation(crew, depth)
            if operation == NONE:
                crew.states[robot] = FREE
                if depth == 0:
                    return False
                depth -= 1
                robot = crew.stack[depth]
                release(crew, robot)
                undo(crew, crew.marks[robot])
                continue
            follow(crew, robot, operation)
            crew.marks[robot] = crew.trail[last]
            other = meets(crew, robot)
            if other == BLOCKED:
                shut(crew, depth, operation, crew.met_at[0])
            if other < NOBODY:
                continue
            hold(crew, robot)
        if other != NOBODY:
            crew.pushed[robot], crew.pushed_at[robot] = other, crew.met_at[0]
            crew.stack[depth] = robot
            depth += 1
            robot, other = other, IN_VAIN
            begin(crew, fields, robot, depth)
            continue
        crew.states[robot] = CHOSEN
        crew.trail[crew.trail[last]] = robot
        crew.trail[last] += 1
        if depth == 0:
            return True
        depth -= 1
        robot = crew.stack[depth]
        other = meets(crew, robot)
        if other < NOBODY:
            release(crew, robot)
            undo(crew, crew.marks[robot])


@kernel
def plan(crew: Crew, fields: Table) -> None:
    """Choose the ways of all robots that are ``FREE``; those that are ``CHOSEN`` wait."""
    draw(crew.random)
    expect(crew)
    for robot in range(len(crew.places)):
        crew.visits[robot] = 0
        if crew.states[robot] == CHOSEN:
            go_on(crew, robot)
    for at in range(len(crew.order)):
        robot = crew.order[at]
        if crew.states[robot] != CHOSEN and not push(crew, fields, robot):
            go_on(crew, robot)
