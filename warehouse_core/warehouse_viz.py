"""Pictures of an episode: an animated replay, or its frames as SVG files.

Matplotlib is imported when something is drawn, not when this module is; without it both functions
print a message and return. ``viz/scene.py`` draws, ``viz/replay.py`` plays and writes files.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from warehouse_core.arguments import real_number, sequence_of
from warehouse_core.files.atomic import atomic_path
from warehouse_core.records.episode import Episode
from warehouse_core.records.plans import StepPlans
from warehouse_core.render.window import is_in_notebook
from warehouse_core.viz.tracks.grid_track import track_of_frames
from warehouse_core.viz.tracks.record_track import FRAME_SECONDS, track_of_record
from warehouse_core.viz.tracks.track import INTERVAL_MS, Track

if TYPE_CHECKING:
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
) -> Replay | None:
    """Return the animated replay of an episode; frames are also shown, as the chapter does.

    Frames are shown in a window until it is closed, as ``matplotlib.pyplot.show()`` does; where
    there is no display, a message says how to save the replay. The replay of a record is only
    returned: ``replay_animation(episode).show()`` opens its window. A notebook opens none: it
    shows the replay as the last value of a cell. In the window space pauses and resumes, left and
    right step one frame and pause. ``.save("replay.gif")`` writes ``.gif``, ``.mp4``, ``.html``,
    ``.png`` or ``.svg``.

    Args:
        frames: an ``Episode``, or frames as ``WarehouseEnv.render_grid`` returns them.
        metrics: lists ``rewards``, ``battery``, ``dist_pickup`` and ``dist_dropoff``, each
            optional, with one entry a frame; a record has its own.
        interval_ms: milliseconds between frames at speed 1.
        speed: factor on the playing speed.
        window: true if ``show`` opens a window; false if the replay has none. In both cases
            nothing is shown yet. ``None`` gives it one if there is a display.
        beside: a record to be replayed to the right of the first.
        frame_seconds: simulated time between two frames of a continuous motion, three of which
            are shown in ``interval_ms``.
        plans: plans of a fleet, to be drawn ahead of its robots; see ``track_of_record``.

    Returns:
        A ``matplotlib.animation.FuncAnimation``; ``None`` without frames or without matplotlib.

    Raises:
        ValueError: bad frames, metrics, interval, speed or plans; the message says which, where.
        TypeError: both a record and metrics, or plans without a ``FleetEpisode``.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode, replay_animation
        >>> episode = record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)
        >>> replay_animation(episode).save("replay.html")
    """
    track = _track_of(frames, metrics, frame_seconds, plans)
    if track is None or not _matplotlib_is_installed():
        return None
    from warehouse_core.viz.replay import replay_of_tracks

    tracks = [track] if beside is None else [track, track_of_record(beside, frame_seconds)]
    replay = replay_of_tracks(*tracks, interval_ms=interval_ms, speed=speed, window=window)
    if window is None and not isinstance(frames, Episode):
        _show(replay)
    return replay


def save_frames_to_svg(frames: Episode | Frames, output_dir: str | Path, dpi: float = 120) -> None:
    """Write every frame as ``frame_0000.svg`` and so on, and the legend as ``legend.svg``.

    The same frames give the same bytes. Without frames or without matplotlib nothing is written.

    Args:
        frames: an ``Episode``, or frames as ``WarehouseEnv.render_grid`` returns them.
        output_dir: created if it does not exist; files of these names in it are replaced.
        dpi: dots an inch of the pixels of tiles; robots and words are shapes.

    Raises:
        ValueError: bad frames or ``dpi``.
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
    from warehouse_core.viz.export import progress_bar
    from warehouse_core.viz.figure import make_figure, save_svg
    from warehouse_core.viz.legend import draw_legend
    from warehouse_core.viz.scene import Scene

    real_number("dpi", dpi, above=True)
    folder = Path(output_dir)
    folder.mkdir(parents=True, exist_ok=True)
    track.metrics, track.is_continuous = {}, False
    scene = Scene([track], make_figure, legend=False)
    with progress_bar(len(track), "Drawing") as report:
        for frame in range(len(track)):
            scene.show(frame)
            with atomic_path(folder / f"frame_{frame:04d}.svg") as part:
                save_svg(scene.root, part, dpi)
            report(frame, None)
    legend = make_figure(FLEET_LEGEND_INCHES if track.is_fleet else LEGEND_INCHES)
    draw_legend(legend, [track], 6 if track.is_fleet else 5, with_characters=True)
    with atomic_path(folder / "legend.svg") as part:
        save_svg(legend, part, dpi)


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
    """Show a replay in its window; without one say how to save it, unless a notebook shows it."""
    if replay.window:
        replay.show()
    elif not is_in_notebook():
        print(
            "there is no display to open a window on: "
            "replay_animation(...).save('replay.gif') writes the replay to a file"
        )


def _matplotlib_is_installed() -> bool:
    try:
        import matplotlib  # noqa: F401 - only asked for
    except ImportError:  # pragma: no cover - tested in a process of its own
        print("matplotlib is not installed, so nothing is drawn: pip install matplotlib")
        return False
    return True
