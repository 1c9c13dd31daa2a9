"""Local guidance: each robot plans its next steps around the plans of the others.

Before a round of PIBT, each robot in turn finds the cheapest path through a window of steps. The
path may collide with the paths of others, at a cost. In the round, the robot first tries the first
cell of its path. A robot that follows its path keeps the rest of it until it finds the next one, so
that the others know where it intends to go.

Source: Arita and Okumura (2025), Local guidance for configuration-based multi-agent pathfinding.
"""

from __future__ import annotations

from typing import NamedTuple

from agents.mapf.kernels.buffers import Buffer, Table, buffer
from agents.mapf.kernels.places import ACTIONS, NONE, STAY, Places
from agents.mapf.kernels.robots import SPREAD, Robots, mix
from agents.mapf.kernels.space_time_astar import CAME, KNOWN, SEEN, SPENT, Frontier, new_table
from warehouse_core.compiled import kernel

COLLISION = 3
"""Cost of a collision with another path, in steps.

On 16 random floors with 400 robots on 785 cells, plans cost 2.9, 2.7, 2.5, 2.8 and 3.4 times the
lower bound with 1, 2, 3, 4 and 5, and a window of 18 steps.
"""

BUCKETS = 128
"""Range of costs of a path, from the shortest distance up."""


class Guidance(NamedTuple):
    """The guiding paths of ``R`` robots through a window of ``T`` steps.

    Attributes:
        steps: ``T``, or 0 without guidance.
        paths: ``[R * (T + 1)]``, the cell of each robot at each time; ``NONE`` at first if it has
            no path.
        occupied: ``[(T + 1) * size]``, number of paths in each cell at each time.
        moved: ``[(T + 1) * size * 4]``, number of paths that leave each cell to each side at each
            time.
        frontier: records of a search; a state is ``time * size + cell``.
    """

    steps: int
    paths: Table
    occupied: Table
    moved: Table
    frontier: Frontier


def guidance_of(size: int, robots: int, steps: int) -> Guidance:
    """Return the buffers of guidance for the given numbers of cells and robots, with no paths."""
    states = (steps + 1) * size if steps else 0
    paths = new_table(robots * (steps + 1))
    for robot in range(robots):
        paths[robot * (steps + 1)] = NONE
    frontier = Frontier(
        serial=buffer(2), known=new_table(KNOWN * states), heads=buffer(BUCKETS, NONE),
        entries=new_table(2 * states), below=new_table(2 * states),
    )  # fmt: skip
    return Guidance(steps, paths, new_table(states), new_table(STAY * states), frontier)


@kernel
def count_path(floor: Places, guidance: Guidance, robot: int, number: int) -> None:
    """Add a number to the counts of the cells and moves of a robot's path, if it has one."""
    steps, size, paths = guidance.steps, floor.size, guidance.paths
    first = robot * (steps + 1)
    if paths[first] == NONE:
        return
    for time in range(steps):
        here, to = paths[first + time], paths[first + time + 1]
        guidance.occupied[(time + 1) * size + to] += number
        for side in range(STAY):
            if floor.near[here * ACTIONS + side] == to:
                guidance.moved[(time * size + here) * STAY + side] += number


@kernel
def shift_paths(floor: Places, robots: Robots, guidance: Guidance) -> None:
    """Shift all paths by a step, and drop the paths of robots that did not follow them."""
    steps, paths = guidance.steps, guidance.paths
    for state in range(len(guidance.occupied)):
        guidance.occupied[state] = 0
    for move in range(len(guidance.moved)):
        guidance.moved[move] = 0
    for robot in range(len(robots.places)):
        first = robot * (steps + 1)
        if paths[first] != NONE and paths[first + 1] == robots.places[robot]:
            for time in range(steps):  # the last cell stays, so that the robot waits there
                paths[first + time] = paths[first + time + 1]
            count_path(floor, guidance, robot, 1)
        else:
            paths[first] = NONE


@kernel
def find_path(
    floor: Places, robots: Robots, guidance: Guidance, fields: Table, row: int, robot: int
) -> None:
    """Write the cheapest path of a robot, or no path if the search would not fit its buffers.

    The distances to the goal in steps are in ``fields`` from ``row`` on. The cost of a step is 1,
    or 0 at the goal, and ``COLLISION`` for each path that it collides with. The distance that is
    left after the window is added. Among equally good states, the one added last is expanded first.
    """
    size, near, steps, frontier = floor.size, floor.near, guidance.steps, guidance.frontier
    known, heads, entries, below = frontier.known, frontier.heads, frontier.entries, frontier.below
    start, goal = robots.places[robot], robots.goals[robot]
    turn = mix(robots.random[0] + robot * SPREAD)
    least, count, bucket, last = fields[row + start], 1, 0, NONE
    frontier.serial[0] += 1
    serial = frontier.serial[0]
    entries[0], below[0], heads[0] = start, NONE, 0
    known[KNOWN * start + SEEN], known[KNOWN * start + SPENT] = serial, 0
    while bucket < BUCKETS and count + ACTIONS <= len(entries):
        entry = heads[bucket]
        if entry == NONE:
            bucket += 1
            continue
        state, heads[bucket] = entries[entry], below[entry]
        time, cell, spent = state // size, state % size, known[KNOWN * state + SPENT]
        if spent + fields[row + cell] != least + bucket:
            continue  # a cheaper path there has been found since
        if time == steps:
            last = state
            break
        for number in range(ACTIONS):
            # Waiting is added first, and so expanded last, except at the goal.
            action = STAY if number == 0 else (number + turn) & 3
            if cell == goal:
                action = STAY if number == STAY else number
            to = near[cell * ACTIONS + action]
            if to == floor.closed:
                continue
            after = (time + 1) * size + to
            collisions = guidance.occupied[after]
            if action != STAY:
                collisions += guidance.moved[(time * size + to) * STAY + (action ^ 2)]
            total = spent + (cell != goal or to != goal) + COLLISION * collisions
            record, level = KNOWN * after, total + fields[row + to] - least
            is_known = known[record + SEEN] == serial and known[record + SPENT] <= total
            if is_known or level >= BUCKETS:
                continue
            known[record + SEEN], known[record + SPENT], known[record + CAME] = serial, total, state
            entries[count], below[count], heads[level] = after, heads[level], count
            count += 1
    for level in range(bucket, BUCKETS):
        heads[level] = NONE
    first = robot * (steps + 1)
    guidance.paths[first] = NONE if last == NONE else start
    for time in range(steps if last != NONE else 0, 0, -1):
        guidance.paths[first + time], last = last % size, known[KNOWN * last + CAME]


@kernel
def guide(
    floor: Places, robots: Robots, guidance: Guidance, fields: Table, rows: Buffer, wishes: Buffer,
    is_new: bool,
) -> None:  # fmt: skip
    """Write the cell that each robot should try first, or ``NONE``.

    Only a new configuration is guided. When it is visited again, the plain choices of PIBT make the
    search try something else.
    """
    if guidance.steps == 0:
        return
    for robot in range(len(wishes)):
        wishes[robot] = NONE
    if not is_new:
        return
    shift_paths(floor, robots, guidance)
    for robot in robots.order:
        count_path(floor, guidance, robot, -1)
        find_path(floor, robots, guidance, fields, rows[robot], robot)
        count_path(floor, guidance, robot, 1)
        first = robot * (guidance.steps + 1)
        if guidance.paths[first] != NONE:
            wishes[robot] = guidance.paths[first + 1]
