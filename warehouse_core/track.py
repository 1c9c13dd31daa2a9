"""What a replay draws, read from bare frames or from an ``Episode``.

Positions are in cells here: ``x`` counts columns and ``y`` rows from the top left corner, so the
middle of cell ``(row, col)`` is at ``x = col + 0.5``, ``y = row + 0.5``. ``F`` is the number of
drawn frames.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from warehouse_core.episode import UNFINISHED, Episode
from warehouse_core.layout import ALLOWED_TILES, EMPTY, TILES, Cell
from warehouse_core.sight import ROBOT_EMPTY, ROBOT_LOADED

METRICS = ("rewards", "battery", "dist_pickup", "dist_dropoff")

Rows = tuple[str, ...]
Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Hit:
    """Something that the robot ran into: where, in cells, and with what."""

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
    """Everything a replay shows, one entry a drawn frame.

    Attributes:
        tiles: ``[F]`` rows of tiles without the robot.
        poses: ``[F]`` of the robot, ``None`` where a frame has none.
        metrics: for some of ``METRICS`` a list ``[F]``; NaN is not drawn.
        captions: ``[F]`` what was done and why.
        hits: ``[F]`` what the robot ran into.
        full_battery: units of a full battery.
        title: shown above the grid.
        ending: how it ended, shown with the last frame.

    """

    tiles: list[Rows]
    poses: list[Pose | None]
    metrics: dict[str, list[float]]
    captions: list[str] = field(default_factory=list)
    hits: list[tuple[Hit, ...]] = field(default_factory=list)
    full_battery: float = 1.0
    title: str = ""
    ending: str = ""

    def __len__(self) -> int:
        return len(self.tiles)


def track_of_episode(episode: Episode) -> Track:
    """Return the track of a record."""
    size = episode.settings.cell_size
    headings = [motion.path[-1, 3] for motion in episode.motions]
    poses = [
        Pose((col + 0.5, row + 0.5), heading, loaded)
        for (row, col), heading, loaded in zip(
            episode.cells, [None, *map(float, headings)], episode.loaded, strict=True
        )
    ]
    hits = [
        tuple(
            Hit((contact.point[0] / size, contact.point[1] / size), contact.counterpart)
            for contact in motion.contacts
        )
        for motion in episode.motions
    ]
    captions = [
        _printable(f"{action} ({reason})" if reason else str(action))
        for action, reason in zip(episode.actions, episode.reasons, strict=True)
    ]
    seed = "" if episode.seed is None else f", seed {episode.seed}"
    return Track(
        tiles=[episode.layout.rows] * len(episode.cells),
        poses=list(poses),
        metrics=episode.metrics,
        captions=["", *captions],
        hits=[(), *hits],
        full_battery=episode.settings.battery,
        title=_printable(
            f"{episode.agent or 'Warehouse'} on the {episode.settings.backend} backend{seed}"
        ),
        ending="" if episode.outcome == UNFINISHED else episode.outcome,
    )


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
        captions=[""] * len(grids),
        hits=[()] * len(grids),
        full_battery=max([1.0, *checked.get("battery", [])]),
    )


def _printable(text: str) -> str:
    """Return ``text`` with a space for each character that nobody sees and SVG may not hold."""
    return "".join(character if character.isprintable() else " " for character in text)


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
