"""Pictures of an episode: an animated replay, or its frames as SVG files.

Matplotlib is imported when something is drawn, not when this module is; without it both functions
say so and return. What is drawn is in ``viz/scene.py``, how it plays in ``viz/replay.py``, the file
formats in ``viz/export.py``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from warehouse_core.records.episode import Episode
from warehouse_core.viz.track import FRAME_SECONDS, Track, track_of_episode, track_of_frames

if TYPE_CHECKING:
    from warehouse_core.viz.replay import Replay

INTERVAL_MS = 150
"""Milliseconds from one frame to the next, unless asked otherwise."""

Frames = Sequence[Sequence[Sequence[str]]]
Metrics = Mapping[str, Sequence[float | None]]


def replay_animation(
    frames: Episode | Frames,
    metrics: Metrics | None = None,
    interval_ms: float = INTERVAL_MS,
    speed: float = 1.0,
    *,
    window: bool | None = None,
    beside: Episode | None = None,
    frame_seconds: float = FRAME_SECONDS,
) -> Replay | None:
    """Return the animated replay of an episode.

    ``replay_animation(episode).show()`` opens a window (as ``matplotlib.pyplot.show()`` does),
    ``.save("replay.gif")`` writes ``.gif``, ``.mp4``, ``.html``, ``.png`` or ``.svg``, and as the
    last value of a notebook cell it shows itself. In the window space pauses and resumes, left
    and right step one frame and pause.

    Args:
        frames: an ``Episode``, or frames as ``WarehouseEnv.render_grid`` returns them.
        metrics: lists ``rewards``, ``battery``, ``dist_pickup`` and ``dist_dropoff``, each
            optional, with one entry a frame; an ``Episode`` brings its own.
        interval_ms: from one frame to the next at speed 1, in milliseconds.
        speed: factor on the playing speed.
        window: whether ``show`` is to open a window; ``None`` means wherever there is a display.
        beside: an episode to be replayed to the right of the first, step by step.
        frame_seconds: simulated time between two frames of a continuous motion, three of which
            are shown in ``interval_ms``.

    Returns:
        A ``matplotlib.animation.FuncAnimation``; ``None`` without frames or without matplotlib.

    Raises:
        ValueError: bad frames, metrics, interval or speed; the message names which and where.
        TypeError: metrics beside an ``Episode``.
    """
    track = _track_of(frames, metrics, frame_seconds)
    if track is None or not _matplotlib_is_installed():
        return None
    from warehouse_core.render.window import has_display
    from warehouse_core.viz.replay import Replay

    return Replay(
        track,
        interval_ms,
        speed,
        window=has_display() if window is None else window,
        beside=None if beside is None else track_of_episode(beside, frame_seconds),
    )


def save_frames_to_svg(frames: Episode | Frames, output_dir: str | Path, dpi: float = 120) -> None:
    """Write every frame as ``frame_0000.svg`` and so on, and the legend as ``legend.svg``.

    The same frames give the same bytes. Does nothing without frames, and says so without
    matplotlib.

    Args:
        frames: an ``Episode``, or frames as ``WarehouseEnv.render_grid`` returns them.
        output_dir: made if need be; files of these names in it are replaced.
        dpi: dots an inch of whatever is drawn as pixels; here everything is drawn as lines.

    Raises:
        ValueError: bad frames or ``dpi``.
        OSError: the folder cannot be made or written to.
    """
    track = _track_of(frames, None, FRAME_SECONDS)
    if track is None or not _matplotlib_is_installed():
        return
    from warehouse_core.viz.export import save_frames

    save_frames(track, Path(output_dir), dpi)


def _track_of(
    frames: Episode | Frames, metrics: Metrics | None, frame_seconds: float
) -> Track | None:
    if isinstance(frames, Episode):
        if metrics is not None:
            raise TypeError("an Episode brings its own metrics; give none beside it")
        return track_of_episode(frames, frame_seconds)
    return track_of_frames(frames, metrics) if len(frames) else None


def _matplotlib_is_installed() -> bool:
    try:
        import matplotlib  # noqa: F401 - only asked for
    except ImportError:
        print("matplotlib is not installed, so nothing is drawn: pip install matplotlib")
        return False
    return True
