"""The data of a replay: its frames, and the values that change from step to step.

Positions are in cells: ``x`` counts columns and ``y`` counts rows from the top left corner, so the
centre of cell ``(row, col)`` is at ``x = col + 0.5``, ``y = row + 0.5``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from warehouse_core.records.plans import NO_PLANS, StepPlans
from warehouse_core.render.atlas import UNSEEN
from warehouse_core.render.palette import LOOK, Color
from warehouse_core.world.tiles import WALL, Cell

OUTER: float = LOOK["border"]["outer"]
"""Share of the width of a border of walls that is not shown."""

INTERVAL_MS = 150
"""Milliseconds between frames of a replay."""

CONTINUOUS_FRAMES = 3
"""Number of frames of a continuous motion that are shown in the time of one grid step."""

LONG_SECONDS = 100
"""Duration, in seconds, up to which the clock of an episode shows tenths of a second."""

MIN_PACE, MAX_PACE = 1e-6, 1e9
"""Limits on the playing speed, and on the milliseconds between frames."""

METRICS = ("rewards", "battery", "dist_pickup", "dist_dropoff")
"""Names of the metrics of a single robot."""

TileRows = tuple[str, ...]
Point = tuple[float, float]

Line = tuple[bool, Point, Point]
"""A straight line in cells: whether it is a ray of a range scan or part of an outline; its ends."""


@dataclass(frozen=True, slots=True)
class DrawnHit:
    """A collision: its position in cells, its label, the index of the robot, and its size.

    The size is a factor on the size of its burst, which grows with the impulse.
    """

    at: Point
    label: str
    robot: int = 0
    size: float = 1.0


class Push(NamedTuple):
    """What moves a body: its velocity in m/s, the force of its motor in N, and whether it skids."""

    velocity: Point
    force: Point
    skids: bool = False

    @property
    def brakes(self) -> bool:
        """Whether the motor takes more than a small power in W out of the motion."""
        (vx, vy), (fx, fy) = self.velocity, self.force
        most: float = LOOK["braking"]["power"]
        return vx * fx + vy * fy < -most


def arrow_tip(name: str, vector: Point) -> Point:
    """Return the tip of an arrow from the centre of a body, in cells; (0, 0) for no arrow.

    Args:
        name: ``"velocity"`` or ``"force"``.
        vector: the velocity in m/s or the force in N.
    """
    size, arrows = math.hypot(*vector), LOOK["arrows"]
    length = arrows[name] * size
    if length < arrows["shortest"]:
        return 0.0, 0.0
    share = min(arrows["start"] + length, arrows["longest"]) / size
    return share * vector[0], share * vector[1]


@dataclass(frozen=True, slots=True)
class Pose:
    """The position of a robot in cells, its heading (radians, or ``None``), load and push.

    Example:
        >>> from warehouse_core.viz.tracks import Pose
        >>> Pose(at=(1.5, 2.5), heading=None, loaded=True)
        Pose(at=(1.5, 2.5), heading=None, loaded=True, push=None)
    """

    at: Point
    heading: float | None
    loaded: bool
    push: Push | None = None


class Readings(NamedTuple):
    """What a body measured in an episode, in ``K`` rows in the order of time.

    Attributes:
        times: ``[K]`` times on the clock of the track, in seconds.
        speeds: ``[K]`` speeds in m/s.
        forces: ``[K]`` forces of the motor along the heading in N, negative if it brakes.
        energy: ``[K]`` energy used so far in J.
    """

    times: Sequence[float]
    speeds: Sequence[float]
    forces: Sequence[float]
    energy: Sequence[float]


class Waiting(NamedTuple):
    """Orders that wait at a pickup: its position, their number, and the greatest of their ages."""

    at: Point
    number: int
    age: int


class FleetFrame(NamedTuple):
    """The data of a fleet in a frame. An *age* of an order is an index into ``ORDER_COLORS``.

    Attributes:
        waiting: orders that wait at pickups.
        items: age of the order that each robot carries, or ``None``.
        battery: battery level of each robot, as a share of a full battery.
        plans: plans of the robots.
    """

    waiting: tuple[Waiting, ...]
    items: tuple[int | None, ...]
    battery: tuple[float, ...]
    plans: StepPlans = NO_PLANS


class Marks(NamedTuple):
    """Cells that change their colour, such as those that a search expands.

    Attributes:
        times: ``[K]`` times of the changes, not decreasing.
        cells: ``[K]`` cells that change.
        values: ``[K]`` indices into ``colors``, the new colour of each cell.
        colors: colours of marked cells.
        names: names of the colours, for the legend.
        ends: start and goal of the search.
    """

    times: Sequence[int]
    cells: Sequence[Cell]
    values: Sequence[int]
    colors: Sequence[Color]
    names: Sequence[str]
    ends: tuple[Cell, Cell]


@dataclass(slots=True)
class Frame:
    """One frame of a track. In a continuous track it is a moment within a motion.

    Attributes:
        tiles: rows of tiles without the robots; ``UNSEEN`` for cells that have not been seen.
        robots: pose of each robot, or ``None`` if it is not shown. In a fleet the poses of the
            people follow.
        progress: number of steps taken, with a fraction within a continuous motion.
        caption: action and its reason; in the last frame of an episode its diagnosis.
        hits: collisions to show.
        clock: simulated seconds; 0 in all frames if the track has no motions.
        energy: energy used so far by all robots, in joules; 0 if no bodies measure it.
        route: points of the planned path of the robot; empty if no plan is shown.
        fleet: orders, batteries and plans of a fleet.
        lines: rays of the range scan of a single robot, and then outlines of things around it.

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
    energy: float = 0.0
    route: tuple[Point, ...] = ()
    fleet: FleetFrame | None = None
    lines: tuple[Line, ...] = ()


@dataclass(slots=True)
class Track:
    """Everything that a replay shows. ``S`` is the number of steps plus one.

    Attributes:
        frames: frames, at least one; all have the same number of robots.
        metrics: ``[S]`` values of each of ``METRICS``, by name, NaN where nothing is drawn. For a
            fleet: orders released, orders delivered and joules used so far, and battery levels as
            shares of a full battery.
        is_continuous: true if there are frames within steps. Robots then glide from frame to frame
            and look like machines. Otherwise they are discs that jump from cell to cell.
        is_measured: true if bodies measured the clock and the energy. The grid has no seconds and
            no joules of its own; its clock only sets the pace.
        readings: speed, force and energy of the body of a single robot, for charts; ``None`` if its
            motions have no readings.
        full_battery: units of a full battery.
        title: title, shown above the grid.
        ending: outcome, shown with the last frame.
        lateness: step of each delivery of a fleet, and its lateness in steps, which is negative
            if the delivery was early.
        held_up: step and cell of each time a robot of a fleet was held up, for a page.
        view_radius: number of cells that a robot sees in each direction; ``None`` if unknown.
        slippery: cells with slippery floor.
        motor_strength: actual motor force, as a share of the nominal force.
        drive: drive of the bodies, such as ``"differential"``; "" if it is unknown.
        ghost: position of the robot of another track in each frame, drawn as a dashed circle; empty
            for no ghost. See ``ghost_of``.
        marks: cells that a search has coloured.
        captions_next: true if a caption is about the next step, false if about the previous one.

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
    is_measured: bool = False
    readings: Readings | None = None
    full_battery: float = 1.0
    title: str = ""
    ending: str = ""
    lateness: Sequence[tuple[int, int]] = ()
    held_up: Sequence[tuple[int, Cell]] = ()
    view_radius: int | None = None
    slippery: tuple[Cell, ...] = ()
    motor_strength: float = 1.0
    drive: str = ""
    ghost: Sequence[Point] = ()
    marks: Marks | None = None
    captions_next: bool = False

    def __len__(self) -> int:
        return len(self.frames)

    def step_at(self, frame: int) -> int:
        """Return the number of steps that are complete in ``frame``."""
        return math.floor(self.frames[frame].progress)

    @property
    def steps(self) -> int:
        """The number of steps that the track shows."""
        return math.ceil(self.frames[-1].progress)

    @property
    def ends(self) -> list[int]:
        """``[S]`` number of the frame in which each step is complete."""
        return [n for n, frame in enumerate(self.frames) if frame.progress.is_integer()]

    @property
    def clock_digits(self) -> int:
        """Number of decimals that the clock of the track shows."""
        return 0 if self.frames[-1].clock > LONG_SECONDS else 1

    @property
    def still(self) -> int:
        """Number of the most informative frame, for a still picture.

        For a track of one step this is the frame of its first hit. For a track with plans it is the
        frame in which most robots push others or have a plan. For other tracks it is the last one.
        """
        hits = (number for number, frame in enumerate(self.frames) if frame.hits)
        hit = next(hits, None) if self.steps == 1 else None
        if hit is not None:
            return hit

        def planned(number: int) -> tuple[int, int, int]:
            fleet = self.frames[number].fleet
            plans = fleet.plans if fleet else NO_PLANS
            return len(plans.pushers), len(plans.paths), number

        return max(range(len(self)), key=planned)

    @property
    def is_fleet(self) -> bool:
        """Whether the track shows a fleet."""
        return self.frames[0].fleet is not None

    @property
    def counts_orders(self) -> bool:
        """Whether the charts show the orders of a fleet."""
        return "delivered" in self.metrics

    @property
    def outer(self) -> float:
        """Share of the outermost cells that is not shown; 0 unless all of them are always walls."""
        first, sides = self.frames[0].tiles, set[str]()
        for rows in {frame.tiles for frame in self.frames}:
            sides.update(rows[0], rows[-1], *(line[0] + line[-1] for line in rows))
        is_wide = min(len(first), len(first[0])) > 2
        return OUTER if is_wide and sides <= {WALL, UNSEEN} else 0.0

    @property
    def shown_size(self) -> tuple[float, float]:
        """Width and height of the visible part of the map, in cells."""
        rows, outer = self.frames[0].tiles, self.outer
        return len(rows[0]) - 2 * outer, len(rows) - 2 * outer


def middle(cell: Cell) -> Point:
    """Return the centre of a cell as ``(x, y)``."""
    return cell[1] + 0.5, cell[0] + 0.5


def cells_of(tile: str, rows: Sequence[str]) -> list[Cell]:
    """Return the cells that have a tile."""
    return [
        (row, col) for row, line in enumerate(rows) for col, here in enumerate(line) if here == tile
    ]
