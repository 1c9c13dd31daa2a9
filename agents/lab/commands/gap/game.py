"""A game of the League in the worlds of ``warehouse gap``: its plan on the grid and on bodies.

On the grid each move, turn or wait of a robot takes a second. Bodies have two driven wheels, and
carry out the same plan. Those that stop in every cell do it in joint steps, in each of which all
wait for the last to be at rest. Those that drive through learn of one more step of the plan in each
second. They go on as soon as those before them in the plan have left the next cell, and turn where
their ways do. ``R`` is the number of robots, and a game has ``T`` steps.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from agents.lab.commands.gap.trial import count_hits
from agents.lab.commands.gap.worlds import (
    ALONE,
    DISTURBED,
    PLAN,
    STOPPING,
    Shocks,
    draw_disturbances,
)
from agents.mapf.graph import Graph
from agents.mapf.league.result import Result
from agents.mapf.league.rules import result_of
from warehouse_core import Layout, Outcome
from warehouse_core.motion.grid import NOMINAL_SECONDS, nominal_joules
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.moves import EAST
from warehouse_core.world.tables import Integers
from warehouse_core.world.tiles import WALL

DRIVE = "differential"
"""Drive of the bodies, which turn on the spot as robots of the League do."""

ARRIVED = 1e-3
"""Share of a cell within which a robot has reached the middle of a cell."""

RESTS = 1e-5
"""Metres that a robot moves at most from row to row of its path while it is said to rest."""


MAX_CELLS = 1_000_000
"""Most cells of floors that are below one another."""


class Game(NamedTuple):
    """A plan that robots of the League carry out, and the tasks that they finish by it.

    Attributes:
        layout: floor.
        cells, headings: ``[T + 1, R]``, before each step and after the last.
        ends: ``[N, 2]``, robot and step of the end of each finished task.
    """

    layout: Layout
    cells: Integers
    headings: Integers
    ends: Integers


class GameScore(NamedTuple):
    """What robots reach in the seconds of a game.

    Attributes:
        finished: number of finished tasks.
        joules: energy of all robots.
        stops: number of times that a robot has come to rest after a move.
        hits: contacts, of which two robots that touch have one.
    """

    finished: int
    joules: float
    stops: int
    hits: int


def game_of(layout: Layout, result: Result, steps: int) -> Game:
    """Return the game of a result, or its first steps."""
    graph = Graph(layout)
    ways, turned = [result.starts], [np.full(len(result.starts), EAST)]
    for actions in result.actual[:steps]:
        cells, headings = result_of(graph, ways[-1], turned[-1], actions)
        ways.append(cells)
        turned.append(headings)
    ends = [
        (errand.robot, errand.step)
        for errand in result.errands
        if errand.step <= steps and errand.visited == len(result.tasks[errand.task][1])
    ]
    return Game(layout, np.array(ways), np.array(turned), np.array(ends, np.intp).reshape(-1, 2))


def play_in(world: str, seed: int, *, game: Game, shocks: Shocks) -> GameScore:
    """Return what robots reach in one of ``WORLDS``, in so many seconds as the game has steps."""
    if world == PLAN:
        return on_grid(game)
    if world == STOPPING:
        return stopping(game)
    if world == ALONE:
        scores = [driving(each, Shocks(0.0, 0.0), seed) for each in on_own_floors(game)]
        return GameScore(*map(sum, zip(*scores, strict=True)))
    return driving(game, shocks if world == DISTURBED else Shocks(0.0, 0.0), seed)


def on_grid(game: Game) -> GameScore:
    """Return what the game promises."""
    moved = game.cells[1:] != game.cells[:-1]
    moves, others = int(moved.sum()), int((~moved).sum())
    joules = moves * nominal_joules(1.0, moving=True) + others * nominal_joules(1.0, moving=False)
    last = ~np.concatenate([moved[1:], np.ones_like(moved[:1])])
    return GameScore(len(game.ends), joules, int((moved & last).sum()), 0)


def stopping(game: Game) -> GameScore:
    """Return what bodies reach that stop in every cell, in joint steps."""
    from warehouse_physics import RigidBodyMotion, RobotSpec

    motion = RigidBodyMotion(RobotSpec(drive=DRIVE), record_path=False)
    cells, robots = [*map(game.layout.cells, game.cells)], game.cells.shape[1]
    motion.reset(game.layout, cells[0], 0)
    tally, now, seconds = Tally(motion.spec.idle_power), 0.0, len(cells) - 1
    moves = np.diff(game.layout.places(game.cells), axis=0).tolist()
    turned = game.headings[1:] != game.headings[:-1]
    faced = np.where(turned, game.headings[1:], WAIT).tolist()
    done = 0
    for displacements, directions in zip(moves, faced, strict=True):
        motion.face([DISPLACEMENTS[direction] for direction in directions])
        outcomes = motion.advance([*map(tuple, displacements)], [False] * robots)
        now += max(outcome.seconds for outcome in outcomes)
        if now > seconds:
            break
        tally.add(outcomes)
        tally.stops += sum(map(any, displacements))
        done += 1
    return tally.score(game, np.full(robots, done))


def driving(game: Game, shocks: Shocks, seed: int) -> GameScore:
    """Return what bodies reach that drive through."""
    from warehouse_physics import DrivingMotion, RobotSpec

    seconds, robots = len(game.cells) - 1, game.cells.shape[1]
    # A robot that has died does as much in a game as one that stands until the end of it.
    shocks = shocks._replace(stop=min(shocks.stop, seconds))
    motion = DrivingMotion(RobotSpec(drive=DRIVE), draw_disturbances(shocks, robots, seconds, seed))
    cells = [*map(game.layout.cells, game.cells)]
    motion.reset(game.layout, cells[0], seed)
    tally, visits = Tally(motion.spec.idle_power), Visits(game)
    is_moving = np.zeros((robots, 1), np.bool_)
    for targets in cells[1:]:
        motion.extend(targets)
        outcomes = motion.drive(NOMINAL_SECONDS)
        tally.add(outcomes)
        visits.add(outcomes)
        paths = np.array([outcome.path for outcome in outcomes])
        moves = np.abs(np.diff(paths[:, :, 1:3], axis=1)).max(axis=2) > RESTS
        moves = np.concatenate([is_moving, moves], axis=1)
        tally.stops += int((moves[:, :-1] & ~moves[:, 1:]).sum())
        is_moving = moves[:, -1:]
    return tally.score(game, visits.steps(motion.cell_size))


def on_own_floors(game: Game) -> Iterator[Game]:
    """Yield games of some of the robots, each of which is on a floor of its own below the last."""
    layout, cells, headings, ends = game
    size = (layout.height + 1) * layout.width
    some = max(1, MAX_CELLS // size)
    for first in range(0, cells.shape[1], some):
        part = slice(first, first + some)
        robots = cells[:, part].shape[1]
        floors = Layout([*layout.rows, WALL * layout.width] * robots)
        theirs = ends[(ends[:, 0] >= first) & (ends[:, 0] < first + robots)] - [first, 0]
        yield Game(floors, cells[:, part] + size * np.arange(robots), headings[:, part], theirs)


class Visits:
    """Which cells of their ways robots are in; a way has a cell once for each visit."""

    def __init__(self, game: Game) -> None:
        moved = np.diff(game.cells, axis=0) != 0
        self._number = np.concatenate([np.zeros_like(moved[:1], np.intp), moved.cumsum(axis=0)])
        self._ways = [
            game.layout.cells(way[np.append(True, moves)])
            for way, moves in zip(game.cells.T, moved.T, strict=True)
        ]
        self._at = [0] * len(self._ways)

    def add(self, outcomes: Sequence[Outcome]) -> None:
        """Add where bodies are after some time in which each has entered two cells at most."""
        self._outcomes = outcomes
        for robot, outcome in enumerate(outcomes):
            at, way = self._at[robot], self._ways[robot]
            near = range(at, min(at + 3, len(way)))
            self._at[robot] = next((each for each in near if way[each] == outcome.cell), at)

    def steps(self, cell_size: float) -> Integers:
        """Return how many steps of the game each robot has done, ``[R]``.

        A step is done once the robot is in the middle of its cell.
        """
        done = []
        for robot, outcome in enumerate(self._outcomes):
            at, way = self._at[robot], self._ways[robot]
            ahead = np.subtract(way[at], way[max(at - 1, 0)])
            off = outcome.path[-1, [2, 1]] / cell_size - 0.5 - way[at]
            at -= bool(ahead @ off < -ARRIVED)
            done.append(np.searchsorted(self._number[:, robot], at, side="right") - 1)
        return np.array(done)


class Tally:
    """What bodies have done so far, outcome by outcome."""

    def __init__(self, idle_power: float) -> None:
        self._idle_power = idle_power
        self._work, self._hits, self.stops = 0.0, 0, 0

    def add(self, outcomes: Sequence[Outcome]) -> None:
        """Add what each robot did next."""
        self._work += sum(each.joules - self._idle_power * each.seconds for each in outcomes)
        self._hits += count_hits([outcomes])

    def score(self, game: Game, done: Integers) -> GameScore:
        """Return all of it, where robots have done so many steps, ``[R]``."""
        steps, robots = np.subtract(game.cells.shape, (1, 0)).tolist()
        robot, step = game.ends.T
        finished = int((step <= done[robot]).sum())
        idle = self._idle_power * steps * NOMINAL_SECONDS * robots
        return GameScore(finished, self._work + idle, self.stops, self._hits)
