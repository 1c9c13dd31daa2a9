"""The track of bare frames, for replays without a record."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from warehouse_core.viz.tracks.track import METRICS, Frame, Pose, TileRows, Track, middle
from warehouse_core.world.tiles import ALLOWED_TILES, EMPTY, ROBOT_EMPTY, ROBOT_LOADED, TILES

SIGNS = {*TILES, ROBOT_EMPTY, ROBOT_LOADED}
"""Characters of frames."""


def track_of_frames(
    frames: Sequence[Sequence[Sequence[str]]],
    metrics: Mapping[str, Sequence[float | None]] | None = None,
) -> Track:
    """Return the track of bare frames in the format of ``WarehouseEnv.render_grid``.

    A frame does not show the tile under the robot. This tile is taken from a frame in which the
    robot is in another cell, if possible from a later one.

    Raises:
        ValueError: the frames differ in size or have an unknown character, or a metric has an
            unknown name, the wrong number of entries, or an entry that cannot be plotted.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> from warehouse_core.viz.tracks import track_of_frames
        >>> len(track_of_frames([WarehouseEnv().render_grid()]).frames)
        1
    """
    grids = [["".join(row) for row in frame] for frame in frames]
    _check_grids(grids)
    width, texts = len(grids[0][0]), ["".join(grid) for grid in grids]
    robots = [max(text.rfind(ROBOT_EMPTY), text.rfind(ROBOT_LOADED)) for text in texts]
    known: dict[TileRows, TileRows] = {}  # equal rows become one object, which is drawn once
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
    numbers = _numbers(metrics or {}, len(grids))
    return Track(drawn, numbers, full_battery=max([1.0, *numbers.get("battery", [])]))


def _check_grids(grids: list[list[str]]) -> None:
    for index, grid in enumerate(grids):
        if not grid:
            raise ValueError(f"frame {index} has no rows")
        for row, line in enumerate(grid):
            if len(grid) != len(grids[0]) or len(line) != len(grids[0][0]) or not line:
                raise ValueError(
                    f"frame {index} has {len(grid)} rows with {len(line)} columns in row {row}; "
                    f"frame 0 has {len(grids[0])} rows of {len(grids[0][0])}"
                )
            for col, sign in enumerate(line):
                if sign not in SIGNS:
                    raise ValueError(
                        f"frame {index}, row {row}, column {col}: {sign!r} is unknown; "
                        f"allowed: {ALLOWED_TILES}, R and r (robot)"
                    )


def _numbers(metrics: Mapping[str, Sequence[float | None]], frames: int) -> dict[str, list[float]]:
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
            f"metric {name!r}, frame {frame}: {value!r} is not a finite number, None or NaN"
        )
    return number
