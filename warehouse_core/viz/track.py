"""What a replay draws, read from bare frames or from an ``Episode``.

Positions are in cells here: ``x`` counts columns and ``y`` rows from the top left corner, so the
middle of cell ``(row, col)`` is at ``x = col + 0.5``, ``y = row + 0.5``. ``F`` is the number of
drawn frames.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from warehouse_core.motion.base import Contact, Outcome
from warehouse_core.records.episode import UNFINISHED, Episode
from warehouse_core.records.failure_modes import diagnose
from warehouse_core.wording import printable
from warehouse_core.world.tiles import ALLOWED_TILES, EMPTY, ROBOT_EMPTY, ROBOT_LOADED, TILES, Cell

FRAME_SECONDS = 0.2
"""Simulated seconds from one frame of a continuous motion to the next."""

FLASH_SECONDS = 0.6
"""Simulated seconds for which a hit is shown."""

METRICS = ("rewards", "battery", "dist_pickup", "dist_dropoff")

Rows = tuple[str, ...]
Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Hit:
    """Something that the robot ran into: where, in cells, and what to write beside it."""

    at: Point
    label: str


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the robot is, in cells, which way it faces (radians, or ``None``), and its hands."""

    at: Point
    heading: float | None
    loaded: bool


@dataclass(slots=True)
class Track:
    """Everything a replay shows. ``F`` is the number of drawn frames, ``S`` of steps plus one.

    Attributes:
        tiles: ``[F]`` rows of tiles without the robot, ``UNSEEN`` where nobody has looked yet.
        poses: ``[F]`` of the robot, ``None`` where a frame has none.
        progress: ``[F]`` steps taken, with a fraction inside a continuous motion.
        metrics: for some of ``METRICS`` a list ``[S]``; NaN is not drawn.
        captions: ``[F]`` what was done and why; last of all what became of it, if it has ended.
        hits: ``[F]`` what the robot ran into.
        others: for each further robot its poses ``[F]``.
        clock: ``[F]`` simulated seconds; empty where motions are not continuous, as are the next.
        speed: ``[F]`` in m/s.
        energy: ``[F]`` used so far, in joules.
        routes: ``[F]`` the way that the robot means to go; empty where no plan is shown.
        full_battery: units of a full battery.
        title: shown above the grid.
        ending: how it ended, shown with the last frame.
    """

    tiles: list[Rows]
    poses: list[Pose | None]
    progress: list[float]
    metrics: dict[str, list[float]]
    captions: list[str]
    hits: list[tuple[Hit, ...]]
    others: list[list[Pose | None]] = field(default_factory=list)
    clock: list[float] = field(default_factory=list)
    speed: list[float] = field(default_factory=list)
    energy: list[float] = field(default_factory=list)
    routes: list[tuple[Point, ...]] = field(default_factory=list)
    full_battery: float = 1.0
    title: str = ""
    ending: str = ""

    def __len__(self) -> int:
        return len(self.poses)

    def step_at(self, frame: int) -> int:
        """Return how many steps were complete in ``frame``."""
        return math.floor(self.progress[frame])

    @property
    def steps(self) -> int:
        """The number of steps that the track shows."""
        return math.ceil(self.progress[-1])


def track_of_episode(episode: Episode, frame_seconds: float = FRAME_SECONDS) -> Track:
    """Return the track of a record.

    Where its motions are continuous there is a frame for every ``frame_seconds`` of simulated
    time, elsewhere one for every step.

    Raises:
        ValueError: ``frame_seconds`` is not a positive finite number.
    """
    if not (math.isfinite(frame_seconds) and frame_seconds > 0):
        raise ValueError(f"frame_seconds is {frame_seconds!r}; it must be positive and finite")
    captions = step_captions(episode)
    first: Pose | None = Pose(_middle(episode.cells[0]), None, episode.loaded[0])
    track = Track([], [first], [0.0], episode.metrics, [""], [()])
    if any(len(motion.path) > 2 for motion in episode.motions):
        _follow_motions(track, episode, captions, frame_seconds)
    else:
        _follow_steps(track, episode, captions)
    track.tiles = [episode.layout.rows] * len(track)
    track.full_battery = episode.settings.battery
    seed = "" if episode.seed is None else f", seed {episode.seed}"
    track.title = printable(
        f"{episode.agent or 'Warehouse'} on the {episode.settings.backend} backend{seed}"
    )
    if episode.outcome != UNFINISHED:
        diagnosis = diagnose(episode)
        track.ending, track.captions[-1] = diagnosis.mode, diagnosis.sentence
    return track


def step_captions(episode: Episode) -> list[str]:
    """Return for each step what was done and why."""
    return [
        printable(f"{action} ({reason})" if reason else str(action))
        for action, reason in zip(episode.actions, episode.reasons, strict=True)
    ]


def _follow_steps(track: Track, episode: Episode, captions: list[str]) -> None:
    """Add a frame for every step."""
    size = episode.settings.cell_size
    for step, motion in enumerate(episode.motions, start=1):
        heading = float(motion.path[-1, 3])
        track.poses.append(Pose(_middle(episode.cells[step]), heading, episode.loaded[step]))
        track.progress.append(float(step))
        track.captions.append(captions[step - 1])
        track.hits.append(tuple(_hit(contact, size, "") for contact in motion.contacts))


def _follow_motions(
    track: Track, episode: Episode, captions: list[str], frame_seconds: float
) -> None:
    """Add frames along the path of every motion, the last of each where it ends."""
    size = episode.settings.cell_size
    clock = energy = 0.0
    track.clock, track.speed, track.energy = [0.0], [0.0], [0.0]
    for step, motion in enumerate(episode.motions, start=1):
        path, loaded = motion.path, episode.loaded[step - 1]
        frames = max(1, round(motion.seconds / frame_seconds))
        times = [motion.seconds * frame / frames for frame in range(frames + 1)]
        xs, ys, angles = (np.interp(times, path[:, 0], path[:, k]).tolist() for k in (1, 2, 3))
        for k in range(1, frames + 1):
            moved = math.dist((xs[k - 1], ys[k - 1]), (xs[k], ys[k]))
            is_last = k == frames
            at = (xs[k] / size, ys[k] / size)
            track.poses.append(Pose(at, angles[k], episode.loaded[step] if is_last else loaded))
            track.progress.append(step - 1 + k / frames)
            track.captions.append(captions[step - 1])
            track.hits.append(_hits_about(motion, times[k], size))
            track.clock.append(clock + times[k])
            track.speed.append(moved / (times[k] - times[k - 1]))
            track.energy.append(energy + motion.joules * k / frames)
        clock, energy = clock + motion.seconds, energy + motion.joules


def _hits_about(motion: Outcome, seconds: float, size: float) -> tuple[Hit, ...]:
    """Return the hits that still flash at a time, with their impulses."""
    return tuple(
        _hit(contact, size, f"{contact.impulse:.0f} N·s")
        for contact in motion.contacts
        if contact.seconds <= seconds <= contact.seconds + FLASH_SECONDS
    )


def _hit(contact: Contact, size: float, label: str) -> Hit:
    x, y = contact.point
    return Hit((x / size, y / size), label)


def _middle(cell: Cell) -> Point:
    return cell[1] + 0.5, cell[0] + 0.5


def track_of_frames(
    frames: Sequence[Sequence[Sequence[str]]],
    metrics: Mapping[str, Sequence[float | None]] | None = None,
) -> Track:
    """Return the track of bare frames as ``WarehouseEnv.render_grid`` gives them.

    A frame does not say what is under the robot; it is what the nearest frame shows there that
    has the robot elsewhere.

    Raises:
        ValueError: frames of different sizes, an unknown character, an unknown metric, one with
            another number of entries than there are frames, or an entry that cannot be plotted.
    """
    grids = [["".join(row) for row in frame] for frame in frames]
    _check_sizes(grids)
    robots = [_find_robot(index, grid) for index, grid in enumerate(grids)]
    known: dict[Rows, Rows] = {}
    tiles = []
    for index, grid in enumerate(grids):
        rows = _without_robot(index, grid, grids, robots)
        tiles.append(known.setdefault(rows, rows))
    checked = _check_metrics(metrics or {}, len(grids))
    return Track(
        tiles=tiles,
        poses=[_pose_in(grid, cell) for grid, cell in zip(grids, robots, strict=True)],
        metrics=checked,
        progress=[float(frame) for frame in range(len(grids))],
        captions=[""] * len(grids),
        hits=[()] * len(grids),
        full_battery=max([1.0, *checked.get("battery", [])]),
    )


def _check_sizes(grids: list[list[str]]) -> None:
    for index, grid in enumerate(grids):
        for row, line in enumerate(grid):
            if len(grid) != len(grids[0]) or len(line) != len(grids[0][0]) or not line:
                raise ValueError(
                    f"frame {index} has {len(grid)} rows with {len(line)} columns in row {row}; "
                    f"frame 0 has {len(grids[0])} rows of {len(grids[0][0])}"
                )
        if not grid:
            raise ValueError(f"frame {index} has no rows")


def _find_robot(index: int, grid: list[str]) -> Cell | None:
    found = None
    for row, line in enumerate(grid):
        for col, tile in enumerate(line) if not set(line) <= TILES.keys() else ():
            if tile in (ROBOT_EMPTY, ROBOT_LOADED):
                found = (row, col)
            elif tile not in TILES:
                raise ValueError(
                    f"frame {index}, row {row}, column {col}: {tile!r} is unknown; "
                    f"allowed: {ALLOWED_TILES}, R and r (robot)"
                )
    return found


def _without_robot(
    index: int, grid: list[str], grids: list[list[str]], robots: list[Cell | None]
) -> Rows:
    cell = robots[index]
    if cell is None:
        return tuple(grid)
    row, col = cell
    others = [*range(index + 1, len(grids)), *range(index - 1, -1, -1)]
    under = next((grids[i][row][col] for i in others if robots[i] != cell), EMPTY)
    return (*grid[:row], f"{grid[row][:col]}{under}{grid[row][col + 1 :]}", *grid[row + 1 :])


def _pose_in(grid: list[str], cell: Cell | None) -> Pose | None:
    if cell is None:
        return None
    row, col = cell
    return Pose((col + 0.5, row + 0.5), None, grid[row][col] == ROBOT_LOADED)


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
