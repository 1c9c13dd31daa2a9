"""Checks results of the League by its rules; it shares no code with the simulator.

``R`` is the number of robots.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.mapf.league.result import Result
from warehouse_core.wording import counted
from warehouse_core.world.robot_runners import League
from warehouse_core.world.tables import Integers

__all__ = ["Verdict", "check_result"]

FORWARD, CLOCKWISE, COUNTER = 0, 1, 2
"""Actions, as indices in ``LETTERS``."""

TURNED = {CLOCKWISE: 1, COUNTER: 3}

AHEAD = np.array([(0, 1), (1, 0), (0, -1), (-1, 0)])
"""Row and column to the cell ahead of a robot that heads east, south, west or north."""

SLACK = 1e-6
"""Part of a tick, or of a cell, by which squares may touch."""

Reals = NDArray[np.float64]


class Verdict(NamedTuple):
    """What a checker found.

    Attributes:
        error: first error, or ``""``.
        finished: number of finished tasks as counted again, or ``None`` where the result does not
            say which robot had which task.

    Example:
        >>> from agents.mapf.league.checker import Verdict
        >>> Verdict("step 2: two robots share a cell", None).error
        'step 2: two robots share a cell'
    """

    error: str
    finished: int | None


def check_result(problem: League, result: Result) -> Verdict:
    """Return whether a result keeps the rules, and the number of tasks that are finished in it.

    Example:
        >>> from agents.mapf.league.checker import check_result
        >>> from agents.mapf.epibt import EPIBT
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.league.entry import PlannedEntry
        >>> from agents.mapf.league.scheduler import Scheduler
        >>> from agents.mapf.league.simulator import play
        >>> from warehouse_core import Layout
        >>> from warehouse_core.world.robot_runners import League
        >>> layout = Layout(["....", "...."])
        >>> problem = League(layout, starts=[(0, 0)], tasks=[((0, 3), (1, 0))], revealed=1)
        >>> graph = Graph(layout)
        >>> entry = PlannedEntry(graph, EPIBT(graph), Scheduler(graph, problem.revealed))
        >>> result = play(problem, entry, steps=20, seconds=10)
        >>> check_result(problem, result)
        Verdict(error='', finished=1)
    """
    starts = [row * problem.layout.width + col for row, col in problem.starts]
    if result.starts.tolist() != starts:
        return Verdict("the robots do not start where the problem says", None)
    try:
        ways = (ticked_cells if problem.year == 2026 else cells_of)(problem, result)
        if problem.strategy:
            finished = count_given(problem, ways)
        elif result.schedule:
            finished = count_scheduled(problem, result, ways)
        else:
            return Verdict("", None)
        if finished != result.finished:
            raise ValueError(f"{finished} tasks are finished; the result says {result.finished}")
    except ValueError as error:
        return Verdict(str(error), None)
    return Verdict("", finished)


def cells_of(problem: League, result: Result) -> Integers:
    """Return the cells of the robots before each step and after the last, ``[T + 1, R]``.

    Raises:
        ValueError: robots leave the floor, share a cell or change places.
    """
    layout = problem.layout
    size, ahead = layout.height * layout.width, np.array([1, layout.width, -1, -layout.width])
    is_open = np.zeros(size, np.bool_)
    is_open[layout.open_cells] = True
    cells, turned = result.starts.copy(), np.zeros(len(result.starts), np.int64)
    ways = np.empty((len(result.actual) + 1, len(cells)), np.int32)
    ways[0] = cells
    for step, actions in enumerate(result.actual.astype(np.int64), 1):
        reached = cells + ahead[turned] * (actions == FORWARD)
        rows = abs(reached // layout.width - cells // layout.width)
        columns = abs(reached % layout.width - cells % layout.width)
        leaves = (reached < 0) | (reached >= size) | (rows + columns > 1)
        for robot in np.flatnonzero(leaves | ~is_open[reached % size])[:1]:
            raise ValueError(f"step {step}: robot {robot} leaves the open cells")
        if len(np.unique(reached)) < len(reached):
            raise ValueError(f"step {step}: two robots share a cell")
        moved = reached != cells
        edges = cells[moved] * size + reached[moved]
        if np.isin(reached[moved] * size + cells[moved], edges).any():
            raise ValueError(f"step {step}: two robots change places")
        for action, quarters in TURNED.items():
            turned = (turned + quarters * (actions == action)) % len(ahead)
        ways[step] = cells = reached
    return ways


def ticked_cells(problem: League, result: Result) -> Integers:
    """Return the cells of the robots before each tick of 2026 and after the last, ``[T + 1, R]``.

    A robot is in its old cell until it has arrived in the next.

    Raises:
        ValueError: robots begin another action before the last is done, move while they are
            delayed, leave the floor, or their squares overlap.
    """
    layout, robots = problem.layout, np.arange(len(result.starts))
    cells = layout.places(result.starts)
    is_open = np.zeros((layout.height + 2, layout.width + 2), np.bool_)
    is_open[tuple((layout.places(layout.open_cells) + 1).T)] = True
    turned, begun, count = (np.zeros(len(robots), np.int64) for _ in range(3))
    is_delayed = np.zeros((len(result.actual) + 1, len(robots)), np.bool_)
    for robot, delays in enumerate(result.delays):
        for start, end in delays:
            is_delayed[start:end, robot] = True
    ways = np.empty((len(result.actual) + 1, len(cells)), np.int32)
    ways[0] = result.starts
    for tick, actions in enumerate(result.actual.astype(np.int64)):
        acts = actions <= COUNTER
        for is_wrong, words in (
            (acts & is_delayed[tick], "moves while it is delayed"),
            (acts & (count > 0) & (actions != begun), "begins another action before the last ends"),
        ):
            for robot in np.flatnonzero(is_wrong)[:1]:
                raise ValueError(f"tick {tick}: robot {robot} {words}")
        begun = np.where(acts & (count == 0), actions, begun)
        moves = acts & (actions == FORWARD)
        ahead = cells + AHEAD[turned]
        for robot in np.flatnonzero(moves & ~is_open[tuple((ahead + 1).T)])[:1]:
            raise ValueError(f"tick {tick}: robot {robot} leaves the open cells")
        is_under_way = ((begun == FORWARD) & (count > 0))[:, None]
        before = cells + AHEAD[turned] * (count / problem.ticks)[:, None] * is_under_way
        speed = AHEAD[turned] * moves[:, None] / problem.ticks
        if pair := overlap(layout.width, cells, before, speed, problem.robot_size):
            raise ValueError(f"tick {tick}: robots {pair[0]} and {pair[1]} overlap")
        count = count + acts
        is_done = count == problem.ticks
        cells = np.where((is_done & (begun == FORWARD))[:, None], ahead, cells)
        for action, quarters in TURNED.items():
            turned = (turned + quarters * (is_done & (begun == action))) % len(AHEAD)
        count[is_done] = 0
        ways[tick + 1] = cells @ [layout.width, 1]
    return ways


def overlap(
    width: int, cells: Integers, before: Reals, speed: Reals, size: float
) -> tuple[int, int] | None:
    """Return two robots whose squares overlap at some time of a tick, or ``None``.

    Args:
        width: columns of the map.
        cells: ``[R, 2]``, row and column of the robots.
        before: ``[R, 2]``, where they are before the tick.
        speed: ``[R, 2]``, how far they move in the tick.
        size: side of the squares.
    """
    lines = cells @ [width + 4, 1]
    order = np.argsort(lines)
    for shift in range(3):
        for side in range(-2, 3) if shift else range(3):
            at = np.searchsorted(lines, lines + shift * (width + 4) + side, sorter=order)
            one = np.flatnonzero(at < len(order))
            other = order[at[one]]
            is_there = lines[other] == lines[one] + shift * (width + 4) + side
            one, other = one[is_there & (one != other)], other[is_there & (one != other)]
            gap, closing = before[other] - before[one], speed[other] - speed[one]
            with np.errstate(divide="ignore", invalid="ignore"):
                ends = np.stack([(-size - gap) / closing, (size - gap) / closing])
            stands, apart = closing == 0, abs(gap) >= size - SLACK
            first = np.where(stands, np.where(apart, np.inf, -np.inf), ends.min(axis=0))
            last = np.where(stands, np.where(apart, -np.inf, np.inf), ends.max(axis=0))
            meets = np.minimum(last.min(axis=1), 1) - np.maximum(first.max(axis=1), 0) > SLACK
            for number in np.flatnonzero(meets)[:1]:
                return int(one[number]), int(other[number])
    return None


def count_given(problem: League, ways: Integers) -> int:
    """Return the number of tasks of 2023 that robots finish on their ways."""
    numbers, robots = problem.layout.numbers, len(problem.starts)
    goals = [int(cell) for cell in numbers([task[0] for task in problem.tasks])]
    finished, queue = 0, iter(range(len(goals)))

    def tasks_of(robot: int) -> Iterator[int]:
        if problem.strategy == "greedy":
            yield from queue
        place = robot
        while problem.strategy == "roundrobin" or place < len(goals):
            yield place % len(goals)
            place += robots

    revealed = problem.revealed // robots
    streams = [tasks_of(robot) for robot in range(robots)]
    queues = [list(islice(stream, revealed)) for stream in streams]
    for cells in ways[1:]:
        for robot, cell in enumerate(cells.tolist()):
            if queues[robot] and goals[queues[robot][0]] == cell:
                finished += 1
                del queues[robot][0]
                queues[robot] += islice(streams[robot], 1)
    return finished


def count_scheduled(problem: League, result: Result, ways: Integers) -> int:
    """Return the number of tasks that robots finish on their ways, by the schedule of a result.

    Raises:
        ValueError: a task is not one of the problem, is revealed too early, or is given to robots
            against the rules; or the errands of the result are others.
    """
    replay = Replay(problem, result)
    changes: dict[int, list[tuple[int, int]]] = {}
    for robot, each in enumerate(result.schedule):
        for step, task in each:
            changes.setdefault(step, []).append((robot, task))
    for step, cells in enumerate(ways):
        given = changes.get(step, [])
        if problem.year == 2024:
            replay.give(step, given)
        if step:
            replay.visit(step, cells.tolist())
        if problem.year == 2026:  # a schedule holds from the next tick on
            replay.give(step, given)
        known = replay.revealed(step) - replay.finished
        if known != problem.revealed:
            raise ValueError(
                f"step {step}: {counted(known, 'task')} known; the problem has {problem.revealed}"
            )
    if replay.errands != [tuple(errand) for errand in result.errands]:
        raise ValueError("the errands are others than on the ways of the robots")
    return replay.finished


class Replay:
    """The tasks of a result while robots go their ways once more.

    Attributes:
        finished: number of finished tasks.
        errands: step, robot, task and visited cells of each errand.
    """

    def __init__(self, problem: League, result: Result) -> None:
        source = [tuple(problem.layout.numbers(task).tolist()) for task in problem.tasks]
        for number, (_, cells) in enumerate(result.tasks):
            if cells != source[number % len(source)]:
                raise ValueError(f"task {number} is not that of the problem")
        self.finished = 0
        self.errands: list[tuple[int, int, int, int]] = []
        self._cells = [cells for _, cells in result.tasks]
        self._known_at = [step for step, _ in result.tasks]
        self._lead = int(problem.year == 2024)
        self._left = [list(cells) for cells in self._cells]
        self._has: dict[int, int] = {}
        self._owner: dict[int, int] = {}
        self._known = 0

    def revealed(self, step: int) -> int:
        """Return the number of tasks that have been revealed until a step."""
        while self._known < len(self._known_at) and self._known_at[self._known] <= step:
            self._known += 1
        return self._known

    def give(self, step: int, changes: list[tuple[int, int]]) -> None:
        """Give tasks to robots, or -1, as a schedule says that holds from a step on."""
        for robot, _ in changes:
            task = self._has.pop(robot, None)
            if task is not None:
                del self._owner[task]
                if len(self._left[task]) < len(self._cells[task]):
                    raise ValueError(f"step {step}: robot {robot} leaves task {task}, once begun")
        for robot, task in changes:
            if task < 0:
                continue
            if task in self._owner or task >= len(self._left) or not self._left[task]:
                raise ValueError(f"step {step}: robot {robot} cannot have task {task}")
            if self._known_at[task] + self._lead > step:
                raise ValueError(f"step {step}: task {task} is not known yet")
            self._owner[task], self._has[robot] = robot, task

    def visit(self, step: int, cells: list[int]) -> None:
        """Do the errands of robots in the cells that they were to visit."""
        for robot in sorted(self._has):
            task = self._has[robot]
            left = self._left[task]
            if cells[robot] == left[0]:
                del left[0]
                self.errands.append((step, robot, task, len(self._cells[task]) - len(left)))
                if not left:
                    self.finished += 1
                    del self._has[robot], self._owner[task]
