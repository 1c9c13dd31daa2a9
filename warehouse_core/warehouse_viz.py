"""Pictures of an episode: an animated replay, or its frames as SVG files.

Matplotlib is imported only when something is drawn. If it is not installed, both functions print a
message and return. ``viz/scene.py`` draws pictures; ``viz/replay.py`` plays them and writes files.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import real_number, sequence_of
from warehouse_core.errors import FormatError
from warehouse_core.files.atomic import atomic_path
from warehouse_core.records.episode import Episode
from warehouse_core.records.plans import StepPlans
from warehouse_core.render.palette import COLORS
from warehouse_core.render.window import is_in_notebook
from warehouse_core.viz.tracks.grid_track import track_of_frames
from warehouse_core.viz.tracks.record_track import FRAME_SECONDS, track_of_record
from warehouse_core.viz.tracks.track import INTERVAL_MS, Track
from warehouse_core.warehouse_env import legend

if TYPE_CHECKING:
    from matplotlib.patches import Patch

    from warehouse_core.viz.replay import Replay

LEGEND_INCHES, FLEET_LEGEND_INCHES = (6.0, 0.6), (8.0, 0.8)

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
    plans: Sequence[StepPlans] = (),
) -> Replay | PageOnly | None:
    """Return the animated replay of an episode; show it too if it is given as frames.

    Frames are shown in a window until it is closed, as in the chapter and as with
    ``matplotlib.pyplot.show()``. Without a display, a message explains how to save the replay. The
    replay of a record is only returned: ``replay_animation(episode).show()`` opens its window. A
    notebook opens no window; it shows the replay if it is the last value of a cell.

    In the window, space pauses and resumes; the left and right arrow keys pause and step one frame.
    ``.save("replay.gif")`` writes a file: ``.gif``, ``.mp4``, ``.html``, ``.png`` or ``.svg``.

    Args:
        frames: an ``Episode``, or frames as ``WarehouseEnv.render_grid`` returns them.
        metrics: lists by the names ``rewards``, ``battery``, ``dist_pickup`` and
            ``dist_dropoff``, all optional, with one entry per frame. A record has its own metrics.
        interval_ms: milliseconds between frames at speed 1.
        speed: factor by which the replay is faster.
        window: true to let ``show`` open a window, false for a replay without one. In both cases,
            nothing is shown yet. By default, there is a window if there is a display.
        beside: second record, replayed to the right of the first.
        frame_seconds: simulated seconds between two frames of a continuous motion, three of which
            are shown in ``interval_ms``.
        plans: plans of a fleet, which are drawn ahead of its robots; see ``track_of_record``.

    Returns:
        A ``matplotlib.animation.FuncAnimation``, or ``None`` without frames or without matplotlib.
        Without matplotlib the replay of a record can still be saved as an ``.html`` page.

    Raises:
        ValueError: frames, metrics, interval, speed or plans are invalid; the message names the
            value and its position.
        TypeError: metrics are given with a record, or plans without a ``FleetEpisode``.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode, replay_animation
        >>> episode = record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)
        >>> replay_animation(episode).save("replay.html")
    """
    track = _track_of(frames, metrics, frame_seconds, plans)
    if track is None:
        return None
    tracks = [track] if beside is None else [track, track_of_record(beside, frame_seconds)]
    if not _matplotlib_is_installed():  # pragma: no cover - tested in a process of its own
        return PageOnly(tracks, speed) if isinstance(frames, Episode) else None
    from warehouse_core.viz.replay import replay_of_tracks

    replay = replay_of_tracks(*tracks, interval_ms=interval_ms, speed=speed, window=window)
    if window is None and not isinstance(frames, Episode):
        _show(replay)
    return replay


class PageOnly:  # pragma: no cover - tested in a process of its own
    """A replay without matplotlib, which can only be saved as a page."""

    def __init__(self, tracks: Sequence[Track], speed: float) -> None:
        self._tracks, self._speed = tracks, speed

    def save(self, filename: str | Path) -> None:
        """Save the replay as ``.html``; other formats raise a ``FormatError``."""
        from warehouse_core.viz.player.page import save_page

        if Path(filename).suffix.lower() != ".html":
            raise FormatError(f"{filename}: without matplotlib only .html is possible")
        save_page(filename, self._tracks, speed=self._speed)


def save_frames_to_svg(frames: Episode | Frames, output_dir: str | Path, dpi: float = 120) -> None:
    """Write every frame as ``frame_0000.svg`` and so on, and the legend as ``legend.svg``.

    The same frames give the same bytes. Without frames or without matplotlib nothing is written.

    Args:
        frames: an ``Episode``, or frames as ``WarehouseEnv.render_grid`` returns them.
        output_dir: folder, which is created if it does not exist. Existing files with these names
            are replaced.
        dpi: resolution of the tiles, in dots per inch; robots and text are vector shapes.

    Raises:
        ValueError: frames or ``dpi`` are invalid.
        OSError: the folder cannot be created or written to.

    Example:
        >>> from pathlib import Path
        >>> from warehouse_core import WarehouseEnv, save_frames_to_svg
        >>> save_frames_to_svg([WarehouseEnv().render_grid()], "pictures")
        >>> sorted(path.name for path in Path("pictures").iterdir())
        ['frame_0000.svg', 'legend.svg']
    """
    track = _track_of(frames, None, FRAME_SECONDS)
    if track is None or not _matplotlib_is_installed():
        return
    from warehouse_core.viz.figure import make_figure, save_svg
    from warehouse_core.viz.legend import draw_legend
    from warehouse_core.viz.scene import Scene

    real_number("dpi", dpi, above=True)
    folder = Path(output_dir)
    folder.mkdir(parents=True, exist_ok=True)
    track.metrics, track.is_continuous = {}, False
    scene = Scene([track], make_figure, legend=False)
    for frame in range(len(track)):
        scene.show(frame)
        with atomic_path(folder / f"frame_{frame:04d}.svg") as part:
            save_svg(scene.root, part, dpi)
    legend = make_figure(FLEET_LEGEND_INCHES if track.is_fleet else LEGEND_INCHES)
    draw_legend(legend, [track], 6 if track.is_fleet else 5, with_characters=True)
    with atomic_path(folder / "legend.svg") as part:
        save_svg(legend, part, dpi)


def _grid_to_rgb(grid: Sequence[Sequence[str]]) -> NDArray[np.float64]:
    """Return the colours ``[H, W, 3]`` of a frame, as in the book's listing."""
    return np.array([[COLORS[character] for character in row] for row in grid])


def _legend_handles() -> list[Patch]:
    """Return a patch for each character of a frame, as in the book's listing."""
    from matplotlib.patches import Patch

    return [Patch(color=COLORS[sign], label=label) for sign, label in legend(False).items()]


def _track_of(
    frames: Episode | Frames,
    metrics: Metrics | None,
    frame_seconds: float,
    plans: Sequence[StepPlans] = (),
) -> Track | None:
    is_of_fleet = isinstance(frames, Episode) and frames.is_fleet
    if sequence_of("plans", plans, StepPlans) and not is_of_fleet:
        raise TypeError("plans are for the record of a fleet")
    if isinstance(frames, Episode):
        if metrics is not None:
            raise TypeError("a record has its own metrics; metrics must be None")
        return track_of_record(frames, frame_seconds, plans)
    return track_of_frames(frames, metrics) if len(frames) else None


def _show(replay: Replay) -> None:
    """Show a replay in its window; explain how to save it if it has none outside a notebook."""
    if replay.window:
        replay.show()
    elif not is_in_notebook():
        print(
            "there is no display to open a window on: "
            "replay_animation(...).save('replay.gif') writes the replay to a file"
        )


def _matplotlib_is_installed() -> bool:
    try:
        import matplotlib  # noqa: F401 - to see whether it is installed
    except ImportError:  # pragma: no cover - tested in a process of its own
        print("matplotlib is not installed, so nothing is drawn: pip install matplotlib")
        return False
    return True
