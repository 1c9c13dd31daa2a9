"""A window in which keys steer a robot under continuous control, in real time."""

from __future__ import annotations

from time import monotonic
from typing import Any

from warehouse_core import Episode
from warehouse_core.viz.tracks.record_track import track_of_record

AXES = {
    "up": (1.0, 0.0), "w": (1.0, 0.0),
    "down": (-1.0, 0.0), "s": (-1.0, 0.0),
    "left": (0.0, -0.5), "a": (0.0, -0.5),
    "right": (0.0, 0.5), "d": (0.0, 0.5),
}  # fmt: skip
"""Speed and turn rate for each key, as shares of the largest ones."""

DISC_AXES = {
    "up": (0.0, -1.0), "w": (0.0, -1.0),
    "down": (0.0, 1.0), "s": (0.0, 1.0),
    "left": (-1.0, 0.0), "a": (-1.0, 0.0),
    "right": (1.0, 0.0), "d": (1.0, 0.0),
}  # fmt: skip
"""Velocity to the east and to the south for each key, for a disc that drives in any direction."""

RELEASED = 0.06
"""Seconds after which a released key counts as released. Some systems repeat a held key, and then
report that it is released and pressed again and again."""

CHART_SECONDS = 60
"""Seconds of a game that the charts have room for at first."""

AGAIN, QUIT = ("enter", "return"), ("q", "escape")
HELP = "Hold arrows or WASD to drive. Stand on P and then on D. Enter starts another game, Q quits"


class SteeringWheel:
    """A window in which held keys drive the robot of a ``DriveEnv``.

    Args:
        env: environment of the robot.
        seed: seed of the first game; each further game adds 1.

    Attributes:
        keys: meaning of the keys, in words.
        games: records of all games, the last of which may be unfinished.
    """

    keys = HELP

    def __init__(self, env: Any, seed: int) -> None:
        # Here, because matplotlib takes long to import.
        from warehouse_core.viz.figure import make_window
        from warehouse_core.viz.scene import Scene

        self._env, self.games = env, list[Episode]()
        self._axes = AXES if env.robot_spec.is_differential else DISC_AXES
        self._held: dict[str, float] = {}
        self._begin(seed)
        self.tick()
        length = round(CHART_SECONDS * env.drive_settings.rate) + 1
        self._scene = Scene([track_of_record(self.games[-1])], make_window, length=length)
        self.figure = self._scene.root
        connect = self.figure.canvas.mpl_connect
        connect("key_press_event", lambda event: self.press(event.key))
        connect("key_release_event", lambda event: self.release(event.key))
        self._timer = self.figure.canvas.new_timer(interval=round(1000 / env.drive_settings.rate))
        self._timer.add_callback(self._show)
        self._timer.start()

    def press(self, key: str | None) -> None:
        """Hold a key, start another game or close the window."""
        key = (key or "").lower()
        if key in QUIT:
            import matplotlib.pyplot as plt

            plt.close(self.figure)
        elif key in AGAIN:
            self._begin(self._seed + 1)
            self.tick()
        elif key in self._axes:
            self._held[key] = float("inf")

    def release(self, key: str | None) -> None:
        """Release a key, a little later."""
        key = (key or "").lower()
        if key in self._held:
            self._held[key] = monotonic() + RELEASED

    def tick(self) -> None:
        """Drive for one control step as the held keys command, unless the game is over."""
        if self._recorder.ended:
            return
        now = monotonic()
        self._held = {key: until for key, until in self._held.items() if until > now}
        held = [self._axes[key] for key in self._held]
        action = [sum(axis) for axis in zip(*held, strict=True)] or [0.0, 0.0]
        self._recorder.step(action, "key" if held else "")

    def _begin(self, seed: int) -> None:
        self._seed = seed
        self._recorder = self._env.start_recording(seed=seed, agent="You", randomize=True)
        self.games.append(self._recorder.episode)

    def _show(self) -> None:
        """Drive on and show the last frame."""
        self.tick()
        track = track_of_record(self.games[-1])
        if not self._recorder.ended:
            track.frames[-1].caption = HELP
        self._scene.show(len(track) - 1, track)
        self.figure.canvas.draw_idle()
