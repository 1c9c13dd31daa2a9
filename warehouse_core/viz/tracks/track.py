"""What a replay draws: frames, and what changes with the steps.

Positions are in cells here: ``x`` counts columns and ``y`` rows from the top left corner, so the
middle of cell ``(row, col)`` is at ``x = col + 0.5``, ``y = row + 0.5``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import NamedTuple

from warehouse_core.orders.order import Order
from warehouse_core.records.plans import NO_PLANS, StepPlans
from warehouse_core.render.atlas import UNSEEN
from warehouse_core.render.palette import LOOK, Color
from warehouse_core.world.tiles import WALL, Cell

OUTER: float = LOOK["border"]["outer"]
"""Share of the cells of a border of walls that is not shown."""

INTERVAL_MS = 150
"""Milliseconds between frames of a replay."""

CONTINUOUS_FRAMES = 3
"""Frames of continuous motions that are shown in the time of one step of a grid."""

LONG_SECONDS = 100
"""Seconds of the longest episode whose clock shows tenths."""

MIN_PACE, MAX_PACE = 1e-6, 1e9
"""Limits on the playing speed, and on the milliseconds between frames."""

METRICS = ("rewards", "battery", "dist_pickup", "dist_dropoff")
"""Names of what the charts of one robot show."""

TileRows = tuple[str, ...]
Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class DrawnHit:
    """A collision: where, in cells, the label drawn beside it, and the index of the robot."""

    at: Point
    label: str
    robot: int = 0


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a robot is, in cells, its heading (radians, or ``None``), and whether it is loaded.

    Example:
        >>> from warehouse_core.viz.tracks import Pose
        >>> Pose(at=(1.5, 2.5), heading=None, loaded=True)
        Pose(at=(1.5, 2.5), heading=None, loaded=True)
    """

    at: Point
    heading: float | None
    loaded: bool


class Waiting(NamedTuple):
    """Orders that wait in a place, their number, and the greatest of their ages."""

    at: Point
    number: int
    age: int


class FleetFrame(NamedTuple):
    """What a frame of a fleet shows: orders that wait, for each robot what it has, and plans.

    That is the age of its item or ``None``, and its share of a full battery. An *age* is an index
    into ``ORDER_COLORS``.
    """

    waiting: tuple[Waiting, ...]
    items: tuple[int | None, ...]
    battery: tuple[float, ...]
    plans: StepPlans = NO_PLANS


class Marks(NamedTuple):
    """Cells that change their colour, such as those that a search expands.

    Attributes:
        times: ``[K]``, not decreasing.
        cells: ``[K]``.
        values: ``[K]`` indices into ``colors``.
        colors: colours of the floor from then on.
        names: names of the colours, for the legend.
        ends: start and goal.
    """

    times: Sequence[int]
    cells: Sequence[Cell]
    values: Sequence[int]
    colors: Sequence[Color]
    names: Sequence[str]
    ends: tuple[Cell, Cell]


@dataclass(slots=True)
class Frame:
    """One drawn frame. In a continuous track it is a moment inside a motion.

    Attributes:
        tiles: rows of tiles without the robots, ``UNSEEN`` where a cell has not been seen.
        robots: pose of each robot, ``None`` for one that is not shown; in a fleet poses of people
            follow.
        progress: steps taken, with a fraction inside a continuous motion.
        caption: the action and its reason; in the last frame of an episode its diagnosis.
        hits: the collisions to show.
        clock: simulated seconds; 0 in all frames if the track has no motions.
        speed: speed of the first robot, in m/s.
        energy: used so far by all robots, in joules.
        route: the planned way of the robot; empty where no plan is shown.
        fleet: orders and batteries of a fleet.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> from warehouse_core.viz.tracks import track_of_frames
        >>> frame = track_of_frames([WarehouseEnv().render_grid()]).frames[0]
        >>> frame.robots[0].at, frame.progress
        ((1.5, 1.5), 0.0)
    """

    tiles: TileRows
    robots: tuple[Pose | None, ...]
    progress: float
    caption: str = ""
    hits: tuple[DrawnHit, ...] = ()
    clock: float = 0.0
    speed: float = 0.0
    energy: float = 0.0
    route: tuple[Point, ...] = ()
    fleet: FleetFrame | None = None


@dataclass(slots=True)
class Track:
    """Everything a replay shows. ``S`` is the number of steps plus one.

    Attributes:
        frames: frames, at least one; all have the same number of robots.
        metrics: ``[S]`` what charts show, by ``METRICS``, NaN where nothing is drawn; of fleets
            orders released and delivered and joules used so far, and shares of full batteries.
        is_continuous: true if frames have a speed, and show moments inside a step.
        full_battery: units of a full battery.
        title: shown above the grid.
        ending: outcome, shown with the last frame.
        lateness: step of each delivery of a fleet, and by how many steps it was late.
        orders: orders of a fleet, for a page; ``None`` if it does not show them.
        assignments: step, robot and order of each assignment of these orders.
        held_up: step and cell of each time that a robot of a fleet was held up, for a page.
        view_radius: cells that a robot sees in each direction, ``None`` if unknown.
        slippery: cells with slippery floor.
        motor_strength: actual share of the motor force.
        marks: cells that a search has coloured.
        tells_next: true if a caption is about the next step, false if about the last one.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> from warehouse_core.viz.tracks import track_of_record
        >>> track = track_of_record(record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12))
        >>> track.steps, track.is_continuous
        (23, False)
    """

    frames: list[Frame]
    metrics: Mapping[str, Sequence[float]]
    is_continuous: bool = False
    full_battery: float = 1.0
    title: str = ""
    ending: str = ""
    lateness: Sequence[tuple[int, int]] = ()
    orders: Sequence[Order] | None = None
    assignments: Sequence[tuple[int, int, int | None]] = ()
    held_up: Sequence[tuple[int, Cell]] = ()
    view_radius: int | None = None
    slippery: tuple[Cell, ...] = ()
    motor_strength: float = 1.0
    marks: Marks | None = None
    tells_next: bool = False

    def __len__(self) -> int:
        return len(self.frames)

    def step_at(self, frame: int) -> int:
        """Return how many steps are complete in ``frame``."""
        return math.floor(self.frames[frame].progress)

    def rewards_until(self, step: int) -> tuple[list[float], list[float]]:
        """Return the rewards of all steps up to one, with NaN as 0, and their running sums."""
        rewards = [0.0 if math.isnan(r) else r for r in self.metrics["rewards"][: step + 1]]
        return rewards, [*accumulate(rewards)]

    @property
    def steps(self) -> int:
        """The number of steps that the track shows."""
        return math.ceil(self.frames[-1].progress)

    @property
    def ends(self) -> list[int]:
        """``[S]`` the frame in which each step is complete."""
        return [n for n, frame in enumerate(self.frames) if frame.progress.is_integer()]

    @property
    def clock_digits(self) -> int:
        """The decimals that the clock of the track shows."""
        return 0 if self.frames[-1].clock > LONG_SECONDS else 1

    @property
    def clocks(self) -> list[float]:
        """``[S]`` the simulated seconds at which each step was complete."""
        return [self.frames[end].clock for end in self.ends]

    @property
    def still(self) -> int:
        """The frame that tells most, for a picture that does not move.

        A track of one step is about its first hit, one with plans about the plans of most robots
        that push or have one; others are about how they end.
        """
        hits = (number for number, frame in enumerate(self.frames) if frame.hits)
        hit = next(hits, None) if self.steps == 1 else None
        if hit is not None:
            return hit

        def planned(number: int) -> tuple[int, int, int]:
            fleet = self.frames[number].fleet
            plans = fleet.plans if fleet else NO_PLANS
            return len(plans.pushers), len(plans.ways), number

        return max(range(len(self)), key=planned)

    @property
    def is_fleet(self) -> bool:
        """Whether the track shows a fleet."""
        return self.frames[0].fleet is not None

    @property
    def counts_orders(self) -> bool:
        """Whether the charts are about the orders of a fleet."""
        return "delivered" in self.metrics

    @property
    def outer(self) -> float:
        """Share of the outermost cells that is not shown, where they are walls in all frames."""
        first, sides = self.frames[0].tiles, set[str]()
        for rows in {frame.tiles for frame in self.frames}:
            sides.update(rows[0], rows[-1], *(line[0] + line[-1] for line in rows))
        is_wide = min(len(first), len(first[0])) > 2
        return OUTER if is_wide and sides <= {WALL, UNSEEN} else 0.0

    @property
    def shown_size(self) -> tuple[float, float]:
        """Width and height of what is shown of the map, in cells."""
        rows, outer = self.frames[0].tiles, self.outer
        return len(rows[0]) - 2 * outer, len(rows) - 2 * outer


def middle(cell: Cell) -> Point:
    """Return the middle of a cell."""
    return cell[1] + 0.5, cell[0] + 0.5
