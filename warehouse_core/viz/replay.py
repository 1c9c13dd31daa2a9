"""A replay: a track played in a window, shown in a notebook, or saved to a file."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import matplotlib as mpl
from matplotlib.animation import FuncAnimation
from matplotlib.backend_bases import Event, KeyEvent

from warehouse_core.arguments import real_number
from warehouse_core.errors import NoDisplayError
from warehouse_core.viz.export import export, progress_bar, self_contained
from warehouse_core.viz.figure import PAIR_DPI, SceneFigure, make_figure, make_window
from warehouse_core.viz.scene import PairScene, Scene
from warehouse_core.viz.track import Track

CONTINUOUS_FRAMES = 3
"""Frames of a continuous motion that are shown in the time of one step of a grid."""


class Playable(Protocol):
    """What can be played: a figure that shows any of its frames."""

    root: SceneFigure

    def __len__(self) -> int:
        """Return the number of frames."""

    def show(self, frame: int) -> None:
        """Change everything that moves to what it is in a frame."""


class Replay(FuncAnimation):
    """A matplotlib animation of a track, with keys.

    Space pauses and resumes (and starts again from the end), left and right step one frame and
    pause, ``q`` closes the window.

    Args:
        track: with at least one frame.
        interval_ms: from one frame to the next at speed 1, in milliseconds.
        speed: factor on the playing speed.
        window: draw into a window, which ``show`` opens.
        beside: another track, to be drawn to the right of the first, step by step.

    Raises:
        ValueError: ``interval_ms`` or ``speed`` is not a positive finite number.
    """

    def __init__(
        self,
        track: Track,
        interval_ms: float,
        speed: float,
        *,
        window: bool,
        beside: Track | None = None,
    ) -> None:
        for name, value in (("interval_ms", interval_ms), ("speed", speed)):
            real_number(name, value, above=True)
        self.track = track
        is_continuous = bool(track.clock or (beside and beside.clock))
        make = make_window if window else make_figure
        scene = (
            PairScene(track, beside, partial(make, dpi=PAIR_DPI)) if beside else Scene(track, make)
        )
        frame_ms = interval_ms / speed / (CONTINUOUS_FRAMES if is_continuous else 1)
        self._play(scene, track.title, frame_ms, window)

    def _play(self, scene: Playable, title: str, frame_ms: float, window: bool) -> None:
        """Begin to play a scene, whatever it shows."""
        self.title = title
        self.frame = 0
        self.playing = True
        self.frame_ms = frame_ms
        # Matplotlib asks for an integer and takes any number; slow replays need a fraction.
        self.fps: Any = 1000 / frame_ms
        self.window = window
        self._scene = scene
        self.figure = scene.root
        super().__init__(
            self.figure,
            self._show,
            frames=self._frames_to_play,
            interval=max(1, round(frame_ms)),
            cache_frame_data=False,
        )
        self.figure.canvas.mpl_connect("key_press_event", self._on_key)
        # The figure keeps its replay alive, so that nobody has to hold on to what is returned.
        self.figure.replay = self

    def __del__(self) -> None:
        """Say nothing: a replay that was made and never drawn is no mistake."""

    def show(self) -> None:
        """Open the window and wait until it is closed.

        Raises:
            NoDisplayError: the replay was made without a window.
        """
        if not self.window:
            raise NoDisplayError("no window can be opened here: there is no display")
        import matplotlib.pyplot as plt

        plt.show()

    def go_to(self, frame: int) -> None:
        """Show ``frame``, or the nearest that there is, and stay there."""
        self.playing = False
        self.frame = min(max(frame, 0), len(self._scene) - 1)
        self.refresh()

    def toggle(self) -> None:
        """Pause or resume; at the end begin again."""
        self.playing = not self.playing
        if self.playing and self.frame == len(self._scene) - 1:
            self.frame = 0
            self.refresh()

    def refresh(self) -> None:
        """Draw the current frame again."""
        self._scene.show(self.frame)
        self.figure.canvas.draw_idle()

    def show_end(self) -> None:
        """Draw the last frame, for a picture, without going there."""
        self._scene.show(len(self._scene) - 1)

    def save(  # type: ignore[override]
        self, filename: str | Path, writer: Any = None, **options: Any
    ) -> None:
        """Save to ``.gif``, ``.mp4``, ``.html``, or as a picture of the end ``.png`` or ``.svg``.

        With a ``writer`` it is matplotlib's own ``Animation.save``.

        Raises:
            ValueError: another suffix, or an MP4 without imageio-ffmpeg installed.
            OSError: the file cannot be written.
        """
        if writer is None:
            export(self, Path(filename))
        else:
            with progress_bar(len(self._scene), "Drawing") as report:
                options.setdefault("progress_callback", report)
                super().save(str(filename), writer=writer, **options)
            self.refresh()

    def to_jshtml(
        self, fps: int | None = None, embed_frames: bool = True, default_mode: str | None = None
    ) -> str:
        """Return the replay as HTML with controls; nothing is loaded from elsewhere."""
        with mpl.rc_context({"animation.embed_limit": math.inf}):
            page = super().to_jshtml(
                self.fps if fps is None else fps, embed_frames, default_mode or "once"
            )
        return self_contained(page)

    def _repr_html_(self) -> str:
        return self.to_jshtml()

    def new_saved_frame_seq(self) -> Iterator[int]:  # type: ignore[override]
        """Return every frame once, wherever the playing has got to."""
        return iter(range(len(self._scene)))

    def _frames_to_play(self) -> Generator[int, None, None]:
        """Yield what to show at each tick of the clock, for ever: a pause is a frame that stays."""
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
        elif key == "q" and self.window:
            import matplotlib.pyplot as plt

            plt.close(self.figure)
