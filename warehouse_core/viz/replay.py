"""A replay: a track played in a window, shown in a notebook, or saved to a file."""

from __future__ import annotations

import math
import sys
from collections.abc import Generator, Iterator, Sequence
from pathlib import Path
from typing import Any

from matplotlib.animation import FuncAnimation
from matplotlib.backend_bases import Event, KeyEvent
from matplotlib.backends.backend_agg import FigureCanvasAgg

from warehouse_core.arguments import flag, real_number
from warehouse_core.errors import NoDisplayError
from warehouse_core.files.atomic import atomic_path, check_suffix
from warehouse_core.render.window import has_display
from warehouse_core.viz.export import FORMATS, mp4_frames
from warehouse_core.viz.figure import make_figure, make_window
from warehouse_core.viz.gif_writer import GifWriter
from warehouse_core.viz.player import player_frame, save_page
from warehouse_core.viz.scene import Scene
from warehouse_core.viz.svg import animated_svg
from warehouse_core.viz.tracks.track import (
    CONTINUOUS_FRAMES,
    INTERVAL_MS,
    MAX_PACE,
    MIN_PACE,
    Track,
)

__all__ = ["Replay"]

MAX_GIF_FRAMES = 1000
"""Limit on the frames of a GIF. Longer replays are thinned evenly, and play faster."""

LONG = 300
"""Number of frames from which on drawing them takes so long that a message is printed first."""

GIF_FRAMES_APART = 2
"""Number of frames of a continuous motion between two frames of a GIF, which also has the last."""


class Replay(FuncAnimation):
    """A matplotlib animation of a scene, with keys.

    The space bar pauses and resumes, and restarts at the end. The left and right arrow keys pause
    and move by one frame. ``v`` hides or shows the arrows for the velocities of bodies and the
    forces of their motors. ``q`` closes the window.

    Args:
        scene: scene to play.
        tracks: tracks of the scene, for pages and animated drawings.
        frame_ms: milliseconds between two frames.
        speed: factor on the default speed of a page or an animated drawing.
        gif_every: number of frames between two frames of a GIF.

    Attributes:
        window: true if the replay has a window, which ``show`` opens, or had one that was closed.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode, replay_animation
        >>> episode = record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)
        >>> replay = replay_animation(episode)
        >>> replay.go_to(10)
        >>> replay.save("replay.html")
    """

    def __init__(
        self,
        scene: Scene,
        tracks: Sequence[Track],
        frame_ms: float,
        *,
        speed: float = 1.0,
        gif_every: int = 1,
    ) -> None:
        self._scene, self._tracks, self._speed, self._gif_every = scene, tracks, speed, gif_every
        self.figure = scene.root
        self.window = self.figure.canvas.manager is not None
        self.frame, self.playing, self.frame_ms = 0, True, frame_ms
        # Matplotlib documents an integer but accepts any number; slow replays need a fraction.
        self.fps: Any = 1000 / frame_ms
        super().__init__(
            self.figure,
            self._show,
            frames=self._frames_to_play,
            interval=max(1, round(frame_ms)),
            cache_frame_data=False,
        )
        self.figure.canvas.mpl_connect("key_press_event", self._on_key)
        # The figure keeps its replay alive, so callers need not keep a reference.
        self.figure.replay = self

    def __del__(self) -> None:
        """Do nothing, because matplotlib would warn about a replay that was never drawn."""

    def show(self) -> None:
        """Open the window and wait until it is closed. A closed window cannot be opened again.

        Raises:
            NoDisplayError: the replay has no window.
        """
        if not self.window:
            raise NoDisplayError("no window can be opened here: there is no display")
        import matplotlib.pyplot as plt

        plt.show()

    def go_to(self, frame: int) -> None:
        """Pause and show ``frame``, or the nearest frame that exists."""
        self.playing = False
        self.frame = min(max(frame, 0), len(self._scene) - 1)
        self.refresh()

    def toggle(self) -> None:
        """Pause or resume; at the end, start again."""
        self.playing = not self.playing
        if self.playing and self.frame == len(self._scene) - 1:
            self.frame = 0
            self.refresh()

    def refresh(self) -> None:
        """Draw the current frame again."""
        self._scene.show(self.frame)
        self.figure.canvas.draw_idle()

    def show_still(self) -> None:
        """Draw the frame for a still picture, without changing the current frame."""
        self._scene.show(self._scene.still)

    def save(  # type: ignore[override]
        self, filename: str | Path, writer: Any = None, **options: Any
    ) -> None:
        """Save to ``.gif``, ``.mp4``, ``.html`` or ``.svg``, or one frame to ``.png``.

        With a ``writer``, this is the ``Animation.save`` of matplotlib. A GIF has at most
        ``MAX_GIF_FRAMES`` frames: a longer replay is thinned evenly, with a message.

        Args:
            filename: path of the file.
            writer: matplotlib writer.
            options: further arguments of ``Animation.save``, only with a writer.

        Raises:
            ValueError: the suffix is not supported, imageio-ffmpeg is missing for an MP4, or the
                replay is too long for an animated ``.svg``.
            OSError: the file cannot be written.
        """
        self._leave_closed_window()
        if writer is not None:
            super().save(str(filename), writer=writer, **options)
            self.refresh()
            return
        suffix = check_suffix(Path(filename), FORMATS)
        try:
            with atomic_path(filename) as part:
                self._write(part, suffix)
        finally:
            self.refresh()

    def _leave_closed_window(self) -> None:
        """Give the figure of a closed window a new canvas, because the old one no longer draws."""
        if self.window:
            import matplotlib.pyplot as plt

            if self.figure.number not in plt.get_fignums():
                FigureCanvasAgg(self.figure)

    def _write(self, path: Path, suffix: str) -> None:
        if suffix == ".gif":
            self._write_gif(path)
        elif suffix == ".mp4":
            self._write_mp4(path)
        elif suffix == ".html":
            save_page(path, self._tracks, speed=self._speed)
        elif suffix == ".svg":
            path.write_text(animated_svg(self._tracks, speed=self._speed), encoding="utf-8")
        else:
            self.show_still()
            self.figure.pixels().save(path, format="PNG")

    def _write_gif(self, path: Path) -> None:
        last = len(self._scene) - 1
        every = max(self._gif_every, math.ceil(last / (MAX_GIF_FRAMES - 1)))
        frames = [*range(0, last, every), last]
        self._announce(len(frames), is_thinned=every > self._gif_every)
        with path.open("wb") as file:
            writer = GifWriter(file, self.frame_ms * self._gif_every)
            for frame in frames:
                self._scene.show(frame)
                writer.add(self.figure.rgba(), self.figure.changed)
            writer.finish()

    def _announce(self, count: int, *, is_thinned: bool = False) -> None:
        """Print how many frames will be drawn, if some are left out or it takes long."""
        if is_thinned or count >= LONG:
            print(
                f"drawing {count:,} of {len(self._scene):,} frames; a page (.html) has all of them "
                "and is written at once",
                file=sys.stderr,
            )

    def _write_mp4(self, path: Path) -> None:
        figure, count = self.figure, len(self._scene)
        height, width = (side // 2 * 2 for side in figure.rgba().shape[:2])
        self._announce(count)
        with mp4_frames(path, self.fps, width, height) as add:
            for frame in range(count):
                self._scene.show(frame)
                add(figure.rgba()[:height, :width].tobytes())

    def _repr_html_(self) -> str:
        return player_frame(self._tracks, speed=self._speed)

    def new_saved_frame_seq(self) -> Iterator[int]:  # type: ignore[override]
        """Return every frame once, regardless of the current frame."""
        return iter(range(len(self._scene)))

    def _frames_to_play(self) -> Generator[int, None, None]:
        """Yield the frame to show at each tick, forever; while paused, the frame is repeated."""
        while True:
            yield self.frame
            last = len(self._scene) - 1
            if self.playing and self.frame < last:
                self.frame += 1
            self.playing = self.playing and self.frame < last

    def _show(self, frame: int) -> tuple[()]:
        self._scene.show(frame)
        return ()

    def _on_key(self, event: Event) -> None:
        key = event.key if isinstance(event, KeyEvent) else None
        if key == " ":
            self.toggle()
        elif key == "left":
            self.go_to(self.frame - 1)
        elif key == "right":
            self.go_to(self.frame + 1)
        elif key == "v":
            self._scene.toggle_arrows()
            self.refresh()
        elif key == "q" and self.window:
            import matplotlib.pyplot as plt

            plt.close(self.figure)


def replay_of_tracks(
    *tracks: Track,
    interval_ms: float = INTERVAL_MS,
    speed: float = 1.0,
    window: bool | None = None,
) -> Replay:
    """Return the replay of one track, or of several tracks side by side.

    Args:
        tracks: tracks to play.
        interval_ms: milliseconds between two frames at speed 1.
        speed: playing speed.
        window: make a window, which ``show`` opens; ``None`` makes one if there is a display.

    Raises:
        ValueError: ``interval_ms`` or ``speed`` is not within ``MIN_PACE`` and ``MAX_PACE``.
    """
    interval_ms = real_number("interval_ms", interval_ms, MIN_PACE, MAX_PACE)
    speed = real_number("speed", speed, MIN_PACE, MAX_PACE)
    window = has_display() if window is None else flag("window", window)
    scene = Scene(tracks, make_window if window else make_figure)
    is_continuous = any(track.is_continuous for track in tracks)
    frame_ms = interval_ms / speed / (CONTINUOUS_FRAMES if is_continuous else 1)
    page_speed = speed * INTERVAL_MS / interval_ms
    every = GIF_FRAMES_APART if is_continuous else 1
    return Replay(scene, tracks, frame_ms, speed=page_speed, gif_every=every)
