"""What a replay draws, read from bare frames or from an ``Episode``.

Positions are in cells here: ``x`` counts columns and ``y`` rows from the top left corner, so the
middle of cell ``(row, col)`` is at ``x = col + 0.5``, ``y = row + 0.5``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from warehouse_core.arguments import real_number
from warehouse_core.errors import RecordError
from warehouse_core.motion.base import Contact, Outcome
from warehouse_core.records.episode import UNFINISHED, Episode
from warehouse_core.records.failure_modes import diagnose
from warehouse_core.records.plans import NO_PLANS, StepPlans
from warehouse_core.wording import printable
from warehouse_core.world.tiles import (
    ALLOWED_TILES,
    CHARGER,
    EMPTY,
    ROBOT_EMPTY,
    ROBOT_LOADED,
    TILES,
    Cell,
)

FRAME_SECONDS = 0.2
"""Simulated seconds from one frame of a continuous motion to the next."""

FLASH_SECONDS = 0.6
"""Simulated seconds for which a hit is shown."""

MAX_FRAMES = 100_000
"""Limit on the frames of continuous motions, whose number follows from their duration."""

INTERVAL_MS = 150
"""Milliseconds between frames of a replay."""

METRICS = ("rewards", "battery", "dist_pickup", "dist_dropoff")

Rows = tuple[str, ...]
Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Hit:
    """A collision: where, in cells, and the label drawn beside it."""

    at: Point
    label: str


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a robot is, in cells, its heading (radians, or ``None``), and whether it is loaded."""

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


class Shift(NamedTuple):
    """What the charts of a fleet show; all but ``lateness`` are lists ``[S]``, see ``Track``.

    That is orders released and items delivered so far, mean and lowest share of a full battery, and
    energy used so far. ``lateness`` has the step of each delivery and by how many it was late.
    """

    released: list[int]
    delivered: list[int]
    lateness: list[tuple[int, int]]
    battery: list[float]
    lowest: list[float]
    joules: list[float]


@dataclass(slots=True)
class Frame:
    """One drawn frame. In a continuous track it is a moment inside a motion.

    Attributes:
        tiles: rows of tiles without the robots, ``UNSEEN`` where a cell has not been seen.
        robots: the pose of each robot, ``None`` for one that is not shown; those of a fleet are
            followed by people.
        progress: steps taken, with a fraction inside a continuous motion.
        caption: the action and its reason; in the last frame of an episode its diagnosis.
        hits: the collisions to show.
        clock: simulated seconds.
        speed: of the first robot, in m/s.
        energy: used so far by the first robot, in joules.
        route: the planned way of the robot; empty where no plan is shown.
        fleet: orders and batteries of a fleet.
    """

    tiles: Rows
    robots: tuple[Pose | None, ...]
    progress: float
    caption: str = ""
    hits: tuple[Hit, ...] = ()
    clock: float = 0.0
    speed: float = 0.0
    energy: float = 0.0
    route: tuple[Point, ...] = ()
    fleet: FleetFrame | None = None


@dataclass(slots=True)
class Track:
    """Everything a replay shows. ``S`` is the number of steps plus one.

    Attributes:
        frames: at least one; all have the same number of robots.
        metrics: for some of ``METRICS`` a list ``[S]``; NaN is not drawn.
        is_continuous: whether frames have a clock, a speed and an energy.
        full_battery: units of a full battery.
        title: shown above the grid.
        ending: how it ended, shown with the last frame.
        shift: what the charts of a fleet show.
    """

    frames: list[Frame]
    metrics: dict[str, list[float]]
    is_continuous: bool = False
    full_battery: float = 1.0
    title: str = ""
    ending: str = ""
    shift: Shift | None = None

    def __len__(self) -> int:
        return len(self.frames)

    def step_at(self, frame: int) -> int:
        """Return how many steps are complete in ``frame``."""
        return math.floor(self.frames[frame].progress)

    @property
    def steps(self) -> int:
        """The number of steps that the track shows."""
        return math.ceil(self.frames[-1].progress)

    @property
    def is_fleet(self) -> bool:
        """Whether the robots are those of a fleet."""
        return self.frames[0].fleet is not None

    @property
    def has_chargers(self) -> bool:
        """Whether any frame shows a charger."""
        return any(map(has_chargers, {frame.tiles for frame in self.frames}))

    @property
    def has_routes(self) -> bool:
        """Whether any frame shows a planned way."""
        return any(frame.route for frame in self.frames)


def has_chargers(rows: Rows) -> bool:
    """Return whether there is a charger among the tiles."""
    return any(CHARGER in line for line in rows)


def track_of_episode(episode: Episode, frame_seconds: float | None = FRAME_SECONDS) -> Track:
    """Return the track of a record.

    Args:
        episode: the record.
        frame_seconds: simulated time between two frames of continuous motions; ``None`` gives
            one frame a step, as for motions that are not continuous.

    Raises:
        ValueError: ``frame_seconds`` is not a positive finite number.
        RecordError: continuous motions take more than ``MAX_FRAMES`` frames.
    """
    captions = step_captions(episode)
    start = Pose(middle(episode.cells[0]), None, episode.loaded[0])
    frames = [Frame(episode.layout.rows, (start,), 0.0)]
    size = episode.settings.cell_size
    is_continuous = any(len(motion.path) > 2 for motion in episode.motions)
    check_frame_seconds(frame_seconds, episode.seconds if is_continuous else 0.0)
    if is_continuous and frame_seconds is not None:
        for motion, loaded, caption in zip(
            episode.motions, episode.loaded[1:], captions, strict=True
        ):
            frames += frames_along(frames[-1], [motion], [loaded], size, frame_seconds, caption)
    else:
        is_continuous = False
        for step, motion in enumerate(episode.motions, start=1):
            heading = float(motion.path[-1, 3])
            pose = Pose(middle(episode.cells[step]), heading, episode.loaded[step])
            hits = tuple(_hit(contact, size, "") for contact in motion.contacts)
            frames.append(
                Frame(episode.layout.rows, (pose,), float(step), captions[step - 1], hits)
            )
    seed = "" if episode.seed is None else f", seed {episode.seed}"
    title = f"{episode.agent or 'Warehouse'} on the {episode.settings.backend} backend{seed}"
    track = Track(
        frames, episode.metrics, is_continuous, episode.settings.battery, printable(title)
    )
    if episode.outcome != UNFINISHED:
        diagnosis = diagnose(episode)
        track.ending, frames[-1].caption = diagnosis.mode, printable(diagnosis.sentence)
    return track


def step_captions(episode: Episode) -> list[str]:
    """Return for each step the action and its reason."""
    return [
        printable(f"{action} ({reason})" if reason else str(action))
        for action, reason in zip(episode.actions, episode.reasons, strict=True)
    ]


def frames_along(
    start: Frame,
    motions: Sequence[Outcome],
    loaded: Sequence[bool],
    cell_size: float,
    frame_seconds: float,
    caption: str,
) -> Iterator[Frame]:
    """Yield the frames along the paths of one action of each robot, the last where they end.

    Args:
        start: the frame before.
        motions: for each robot of ``start`` what its backend did.
        loaded: for each robot whether it holds an item after the action.
        cell_size: in metres.
        frame_seconds: simulated time between two frames.
        caption: of each frame.
    """
    seconds, joules = max(motion.seconds for motion in motions), motions[0].joules
    count = max(1, round(seconds / frame_seconds))
    times = [seconds * frame / count for frame in range(count + 1)]
    paths = [
        [np.interp(times, motion.path[:, 0], motion.path[:, axis]).tolist() for axis in (1, 2, 3)]
        for motion in motions
    ]
    (xs, ys, _), *_ = paths
    for k in range(1, count + 1):
        is_last = k == count
        poses = [
            Pose(
                (x[k] / cell_size, y[k] / cell_size),
                angle[k],
                after if is_last else before is not None and before.loaded,
            )
            for (x, y, angle), before, after in zip(paths, start.robots, loaded, strict=True)
        ]
        hits = [
            _hit(contact, cell_size, f"{contact.impulse:.0f} N·s")
            for motion in motions
            for contact in motion.contacts
            if contact.seconds <= times[k] <= contact.seconds + FLASH_SECONDS
        ]
        moved = math.dist((xs[k - 1], ys[k - 1]), (xs[k], ys[k]))
        yield Frame(
            start.tiles,
            tuple(poses),
            start.progress + k / count,
            caption,
            tuple(dict.fromkeys(hits)),  # both robots of a collision report it
            start.clock + (seconds if is_last else times[k]),
            moved / (times[k] - times[k - 1]),
            start.energy + joules * k / count,
        )


def _hit(contact: Contact, cell_size: float, label: str) -> Hit:
    x, y = contact.point
    return Hit((x / cell_size, y / cell_size), label)


def check_frame_seconds(frame_seconds: float | None, seconds: float) -> None:
    """Raise unless motions of so many seconds can have a frame every ``frame_seconds``.

    Raises:
        ValueError: ``frame_seconds`` is not a positive finite number.
        RecordError: they would take more than ``MAX_FRAMES`` frames.
    """
    if frame_seconds is None:
        return
    real_number("frame_seconds", frame_seconds, above=True)
    if seconds > MAX_FRAMES * frame_seconds:
        raise RecordError(
            f"the motions take {seconds:g} s; with a frame every {frame_seconds:g} s "
            f"that is more than MAX_FRAMES = {MAX_FRAMES}"
        )


def middle(cell: Cell) -> Point:
    """Return the middle of a cell."""
    return cell[1] + 0.5, cell[0] + 0.5


def track_of_frames(
    frames: Sequence[Sequence[Sequence[str]]],
    metrics: Mapping[str, Sequence[float | None]] | None = None,
) -> Track:
    """Return the track of bare frames as ``WarehouseEnv.render_grid`` returns them.

    A frame does not show the tile under the robot; it is taken from the nearest frame that has
    the robot elsewhere.

    Raises:
        ValueError: frames of different sizes, an unknown character, an unknown metric, one whose
            number of entries is not that of the frames, or an entry that cannot be plotted.
    """
    grids = [["".join(row) for row in frame] for frame in frames]
    _check_grids(grids)
    width, texts = len(grids[0][0]), ["".join(grid) for grid in grids]
    robots = [max(text.rfind(ROBOT_EMPTY), text.rfind(ROBOT_LOADED)) for text in texts]
    known: dict[Rows, Rows] = {}  # equal rows become one object, which is drawn once
    drawn = []
    for index, (text, robot) in enumerate(zip(texts, robots, strict=True)):
        pose, ground = None, text
        if robot >= 0:
            pose = Pose(middle(divmod(robot, width)), None, text[robot] == ROBOT_LOADED)
            others = [*range(index + 1, len(texts)), *range(index - 1, -1, -1)]
            under = next((texts[i][robot] for i in others if robots[i] != robot), EMPTY)
            ground = f"{text[:robot]}{under}{text[robot + 1 :]}"
        rows = tuple(ground[start : start + width] for start in range(0, len(ground), width))
        drawn.append(Frame(known.setdefault(rows, rows), (pose,), float(index)))
    checked = _check_metrics(metrics or {}, len(grids))
    full_battery = max([1.0, *checked.get("battery", [])])
    return Track(drawn, checked, full_battery=full_battery)


def _check_grids(grids: list[list[str]]) -> None:
    for index, grid in enumerate(grids):
        for row, line in enumerate(grid):
            if len(grid) != len(grids[0]) or len(line) != len(grids[0][0]) or not line:
                raise ValueError(
                    f"frame {index} has {len(grid)} rows with {len(line)} columns in row {row}; "
                    f"frame 0 has {len(grids[0])} rows of {len(grids[0][0])}"
                )
        if not grid:
            raise ValueError(f"frame {index} has no rows")
    allowed = {*TILES, ROBOT_EMPTY, ROBOT_LOADED}
    for index, grid in enumerate(grids):
        for row, line in enumerate(grid):
            unknown = set(line) - allowed
            if unknown:
                col = min(map(line.index, unknown))
                raise ValueError(
                    f"frame {index}, row {row}, column {col}: {line[col]!r} is unknown; "
                    f"allowed: {ALLOWED_TILES}, R and r (robot)"
                )


def _check_metrics(
    metrics: Mapping[str, Sequence[float | None]], frames: int
) -> dict[str, list[float]]:
    for name, values in metrics.items():
        if name not in METRICS:
            raise ValueError(f"metric {name!r} is unknown; allowed: {', '.join(METRICS)}")
        if len(values) != frames:
            raise ValueError(f"metric {name!r} has {len(values)} entries for {frames} frames")
    return {
        name: [_number(name, frame, value) for frame, value in enumerate(values)]
        for name, values in metrics.items()
    }


def _number(name: str, frame: int, value: float | None) -> float:
    try:
        number = math.nan if value is None else float(value)
    except (TypeError, ValueError):
        number = math.inf
    if math.isinf(number):
        raise ValueError(
            f"metric {name!r}, frame {frame}: {value!r} is no finite number, nor None or NaN"
        )
    return number
