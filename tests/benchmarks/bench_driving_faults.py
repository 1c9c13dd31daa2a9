"""Random plans with noise, slippery floors, stops and failures: no hits, and all come to rest.

``WAREHOUSE_PLANS`` is the number of plans. The paths of all robots are checked by their geometry:
distances between discs, and to walls. A plan of each hundred has 30 to 200 robots, the others 2 to
12, on open floors, among walls, in narrow aisles with bays, and among shelves.
"""

import itertools
import math
import os
import random
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from helpers.driving import resolved
from scipy.spatial import cKDTree

from warehouse_core import Cell, Layout, Outcome
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.generators import shelf_layout
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec, Stop

PLANS = int(os.environ.get("WAREHOUSE_PLANS", "100"))
FAST = RobotSpec.fast()
SPECS = (
    RobotSpec(),
    FAST,
    replace(FAST, turn_seconds=0.5),
    replace(FAST, radius=0.2),
    replace(FAST, drive="differential"),
)
MANY = 100
"""One plan of so many has many robots."""

SPELL, PATIENCE, MAX_SPELLS = 5.0, 15, 700
"""Seconds of a spell, spells without a move after which nobody will move, and most spells."""

SLACK, STILL = 1e-5, 1e-4


class Result(NamedTuple):
    """What is wrong with a plan, and how many robots it has, and how many of them failed."""

    faults: list[str]
    robots: int
    failed: int


def floor_of(stream: random.Random, is_large: bool) -> Layout:
    """Return a random floor."""
    if is_large:
        size = 4, stream.randint(4, 6), stream.randint(4, 6)
        return shelf_layout(*size, aisle=stream.choice([1, 2]), seed=stream.randrange(100))
    kind, width = stream.choice(["open", "walls", "narrow", "shelves"]), stream.randint(4, 12)

    def row(tiles: str) -> str:
        return "".join(stream.choice(tiles) for _ in range(width))

    if kind == "open":
        return Layout(["." * width] * stream.randint(2, 6))
    if kind == "walls":
        return Layout([*(row("....#") for _ in range(stream.randint(2, 6))), "." * width])
    if kind == "narrow":
        return Layout([row("##."), "." * width, row("##."), stream.choice(".#") * width])
    size = stream.randint(1, 3), stream.randint(2, 3), stream.randint(2, 4)
    return shelf_layout(*size, aisle=1, pickups=2, dropoffs=2, seed=stream.randrange(100))


def disturbances_of(stream: random.Random, cells: Sequence[Cell], robots: int) -> Disturbances:
    """Return random disturbances, of which some may be missing."""
    found: dict[str, Any] = {}
    if stream.random() < 0.7:
        found["actuation_noise"] = stream.uniform(0.05, 0.2)
    if stream.random() < 0.5:
        share = stream.choice([0.1, 0.3, 1.0])
        found["slippery"] = frozenset(cell for cell in cells if stream.random() < share)
        found["grip"] = stream.choice([0.03, 0.05, 0.1, 0.3])
    if stream.random() < 0.3:
        found["drag_spread"] = stream.uniform(0.05, 0.5)
    seconds = [1.0, 5.0, 20.0, 60.0, math.inf]
    found["stops"] = tuple(
        Stop(stream.randrange(robots), stream.uniform(0, 15), stream.choice(seconds))
        for _ in range(stream.choice([0, 0, 1, 2, 3]))
    )
    return Disturbances(**found)


class Run:
    """A plan, given at once or while robots drive, and what they did."""

    def __init__(self, seed: int) -> None:
        self._stream = stream = random.Random(seed)
        is_large = seed % MANY == MANY - 1
        self._layout = floor_of(stream, is_large)
        cells = [divmod(int(cell), self._layout.width) for cell in self._layout.open_cells]
        most = int(0.7 * len(cells))
        few, many = (2, max(2, min(12, most))), (30, max(30, min(200, most)))
        self._robots = min(stream.randint(*(many if is_large else few)), len(cells))
        self._starts = stream.sample(cells, self._robots)
        self._spec = stream.choice(SPECS)
        disturbances = disturbances_of(stream, cells, self._robots)
        self._motion = DrivingMotion(self._spec, disturbances, path_every=1, switches=True)
        self._motion.reset(self._layout, self._starts, stream.randrange(1000))
        self._loaded = [stream.random() < 0.5 for _ in self._starts]
        self._ways = [stream.randrange(WAIT) for _ in self._starts]
        self._paths: list[np.ndarray] = []
        self._hits, self._now = 0, 0.0

    def result(self) -> Result:
        """Carry out the plan, and return what is wrong with it."""
        faults = [*self._drive(), *self._geometry()]
        failed = sum(self._motion.ways().failed)
        self._motion.close()
        return Result(faults, self._robots, failed)

    def _drive(self) -> list[str]:
        stream, fails = self._stream, self._stream.choice([0, 0, 1, 2, 3])
        times, steps = sorted(stream.uniform(0, 20) for _ in range(fails)), stream.randint(3, 20)
        if stream.random() < 0.5:
            plan = resolved(self._layout, self._starts, [self._actions() for _ in range(steps)])
            for cells in plan[1:]:
                self._motion.extend(cells)
            self._move([WAIT] * self._robots)
            for at in times:
                if at > self._now:
                    self._add(self._motion.drive(at - self._now))
                self._motion.fail(stream.randrange(self._robots))
        else:
            for _ in range(steps):
                while times and times[0] <= 1.5 * self._now:
                    times.pop(0)
                    self._motion.fail(stream.randrange(self._robots))
                self._move(self._actions())
        return self._come_to_rest()

    def _come_to_rest(self) -> list[str]:
        """Drive until all robots that have not failed are at rest at different open cells."""
        still, before = 0, self._paths[-1][-1]
        for _ in range(MAX_SPELLS):
            ways = self._motion.ways()
            if all(map(max, ways.at_rest, ways.failed)):
                break
            self._add(self._motion.drive(SPELL))
            now = self._paths[-1][-1]
            still = still + 1 if np.abs(now - before).max() < STILL else 0
            if still == PATIENCE:
                return ["nobody moves any more"]
            before = now
        else:
            return ["robots do not come to rest"]
        live = [end for end, fails in zip(ways.ends, ways.failed, strict=True) if not fails]
        if len({*live, *ways.closed}) != len(live) + len(ways.closed):
            return ["two robots rest at one cell"]
        return []

    def _geometry(self) -> list[str]:
        """Compare all positions with each other and with the walls."""
        rows = np.concatenate(self._paths) / self._spec.cell_size
        rows = rows[np.append(True, np.abs(np.diff(rows, axis=0)).max(axis=(1, 2)) > 0)]
        apart = min(cKDTree(row).query(row, k=2)[0][:, 1].min() for row in rows)
        faults = [f"{self._hits} hits"] if self._hits else []
        if apart < 2 * self._spec.radius * (1 - SLACK):
            faults.append(f"robots are {apart:.4f} apart")
        if (gap := self._to_walls(rows)) < self._spec.radius * (1 - SLACK):
            faults.append(f"a robot is {gap:.4f} from a wall")
        return faults

    def _to_walls(self, rows: np.ndarray) -> float:
        """Return the least distance of the middle of a robot from a wall."""
        layout, cells = self._layout, np.floor(rows[..., ::-1]).astype(int)
        size = layout.height, layout.width
        walls = np.ones((size[0] + 2, size[1] + 2), np.bool_)
        for row, col in itertools.product(*map(range, size)):
            walls[row + 1, col + 1] = not layout.is_open((row, col))
        least = math.inf
        for down, right in itertools.product((-1, 0, 1), repeat=2):
            row, col = cells[..., 0] + down, cells[..., 1] + right
            is_wall = walls[np.clip(row + 1, 0, size[0] + 1), np.clip(col + 1, 0, size[1] + 1)]
            beside, above = (
                np.maximum(np.maximum(low - at, at - low - 1), 0)
                for low, at in ((col, rows[..., 0]), (row, rows[..., 1]))
            )
            least = min(least, np.hypot(beside, above)[is_wall].min(initial=math.inf))
        return least

    def _actions(self) -> list[int]:
        """Return random actions of robots that mostly go straight on."""
        stream = self._stream
        for robot in range(self._robots):
            if stream.random() < 0.3:
                self._ways[robot] = stream.randrange(WAIT)
        return [way if stream.random() < 0.9 else WAIT for way in self._ways]

    def _move(self, actions: Sequence[int]) -> None:
        moves = [DISPLACEMENTS[action] for action in actions]
        self._add(self._motion.advance(moves, self._loaded))

    def _add(self, outcomes: Sequence[Outcome]) -> None:
        self._hits += sum(len(outcome.contacts) for outcome in outcomes)
        self._paths.append(np.stack([outcome.path[1:, 1:3] for outcome in outcomes], axis=1))
        self._now += outcomes[0].seconds


def test_nobody_is_hit_whatever_fails_or_slips(measured) -> None:
    results = [Run(seed).result() for seed in range(PLANS)]
    wrong = {seed: each.faults for seed, each in enumerate(results) if each.faults}
    robots, failed = (sum(each[place] for each in results) for place in (1, 2))
    measured(
        f"driving with disturbances, {PLANS:,} random plans",
        f"{len(wrong)} with a hit, an overlap or robots that do not come to rest; "
        f"{robots:,} robots, of which {failed:,} failed",
    )
    assert not wrong
