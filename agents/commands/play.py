"""Drive the robot by hand, in a window."""

from __future__ import annotations

from pathlib import Path

from matplotlib.backend_bases import Event, KeyEvent

from agents.console.options import (
    BackendOption,
    BatteryOption,
    LayoutOption,
    MaxStepsOption,
    SaveOption,
    SeedOption,
    load_layout,
)
from agents.console.output import check_targets, save_episode
from agents.run_episode import draw_seed, make_env, report_episode
from warehouse_core import Episode, EpisodeRecorder, WarehouseEnv
from warehouse_core.errors import NoDisplayError
from warehouse_core.render.display import has_display
from warehouse_core.viz.figure import make_window
from warehouse_core.viz.scene import Scene
from warehouse_core.viz.track import track_of_episode

KEYS = {
    "up": "N", "n": "N",
    "right": "E", "e": "E",
    "down": "S", "s": "S",
    "left": "W", "w": "W",
    "p": "PICK",
    "d": "DROP",
    " ": "WAIT",
}  # fmt: skip
FRAME_MS = 40
"""Milliseconds between the frames of a continuous motion."""

AGAIN, QUIT = ("enter", "return"), ("q", "escape")
HELP = "arrows or NESW move, P picks, D drops, space waits, Enter starts again, Q quits"


class Driver:
    """A window on an environment that keys drive. Each episode is drawn anew from the next seed.

    Args:
        env: to be driven.
        seed: of the first episode.
    """

    def __init__(self, env: WarehouseEnv, seed: int) -> None:
        self._env = env
        self._begin(seed)
        self._scene = Scene(track_of_episode(self.episode), make_window, length=env.max_steps + 1)
        self.figure = self._scene.root
        self.figure.canvas.mpl_connect("key_press_event", self._on_key)
        self._timer = self.figure.canvas.new_timer(interval=FRAME_MS)
        self._timer.add_callback(self._glide)
        self._show()

    @property
    def episode(self) -> Episode:
        """What has been driven so far."""
        return self._recorder.episode

    def press(self, key: str) -> None:
        """Do what ``key`` stands for; after the end of an episode keys that drive do nothing."""
        key = key if key == " " else key.lower()
        if key in QUIT:
            import matplotlib.pyplot as plt

            plt.close(self.figure)
        elif key in AGAIN:
            assert self.episode.seed is not None, "every episode here has a seed"
            self._begin(self.episode.seed + 1)
            self._show()
        elif key in KEYS and not self._recorder.ended:
            self._recorder.step(KEYS[key], "key")
            self._show()

    def _begin(self, seed: int) -> None:
        self._frame = 0
        self._env.reset(randomize=True, seed=seed)
        self._recorder = EpisodeRecorder(self._env, seed=seed, agent="You")

    def _show(self) -> None:
        """Show what is new: a step of the grid at once, a continuous motion frame by frame."""
        track = self._track = track_of_episode(self.episode)
        track.frames[0].caption = HELP
        if self._recorder.ended:
            track.frames[-1].caption += ", Enter starts again"
        if not track.is_continuous:
            self._frame = len(track) - 1
        self._glide()
        self._timer.start()

    def _glide(self) -> None:
        """Show the next frame, and stop the clock at the last."""
        last = len(self._track) - 1
        self._frame = min(self._frame + 1, last)
        self._scene.show(self._frame, self._track)
        self.figure.canvas.draw_idle()
        if self._frame == last:
            self._timer.stop()

    def _on_key(self, event: Event) -> None:
        if isinstance(event, KeyEvent) and event.key is not None:
            self.press(event.key)


def play(
    backend: BackendOption = "grid",
    layout: LayoutOption = None,
    seed: SeedOption = None,
    battery: BatteryOption = 200,
    max_steps: MaxStepsOption = 200,
    save: SaveOption = None,
) -> None:
    """Drive the robot yourself: arrows or NESW, P picks, D drops, space waits."""
    targets: list[Path] = save or []
    check_targets(targets)
    env = make_env(load_layout(layout), backend, battery, max_steps)
    if not has_display():
        raise NoDisplayError("play needs a window, and there is no display here")
    driver = Driver(env, draw_seed() if seed is None else seed)
    import matplotlib.pyplot as plt

    plt.show()
    report_episode(driver.episode)
    for target in targets:
        save_episode(driver.episode, target)
    env.close()
