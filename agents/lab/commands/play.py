"""The command ``warehouse play``: a window in which keys drive the robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from agents.lab.commands.run import report_episode
from agents.lab.commands.steer import SteeringWheel
from agents.lab.console import options
from agents.lab.console.output import replay_or_save, unused
from agents.lab.console.terminal import say
from agents.lab.console.values import with_slippery
from agents.lab.runs.run import draw_seed
from agents.lab.trials.task import Task, load_task
from warehouse_core import Episode, EpisodeRecorder, WarehouseEnv
from warehouse_core.errors import NoDisplayError
from warehouse_core.records.episode import is_drive
from warehouse_core.render.window import has_display
from warehouse_core.viz.tracks.record_track import track_of_record

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
HELP = "Arrows or NESW move, P picks, D drops, space waits, Enter starts another game, Q quits"


class KeyDriver:
    """A window in which keys drive the robot of an environment.

    Args:
        env: environment of the robot.
        seed: seed of the first game; each further game adds 1.
        task: task with the stations of the games.

    Attributes:
        keys: meaning of the keys, in words.
        games: records of all games, the last of which may be unfinished.
    """

    keys = HELP

    def __init__(self, env: WarehouseEnv, seed: int, task: Task) -> None:
        # Here, because matplotlib takes long to import.
        from warehouse_core.viz.figure import make_window
        from warehouse_core.viz.scene import Scene

        self._env, self._task = env, task
        self.games: list[Episode] = []
        self._begin(seed)
        self._scene = Scene([track_of_record(self.episode)], make_window, length=env.max_steps + 1)
        self.figure = self._scene.root
        manager: Any = self.figure.canvas.manager
        manager.set_window_title(f"Warehouse: {HELP}")  # where it stays in view
        self.figure.canvas.mpl_connect("key_press_event", self._on_key)
        self._timer = self.figure.canvas.new_timer(interval=FRAME_MS)
        self._timer.add_callback(self._glide)
        self._show()

    @property
    def episode(self) -> Episode:
        """Record of the current game so far."""
        return self.games[-1]

    def press(self, key: str) -> None:
        """Carry out a key; after the end of a game, keys that stand for actions are ignored."""
        key = key if key == " " else key.lower()
        if key in QUIT:
            import matplotlib.pyplot as plt

            plt.close(self.figure)
        elif key in AGAIN:
            report_game(self.games, self._task)
            self._begin(self._next_seed)
            self._show()
        elif key in KEYS and not self._recorder.ended:
            self._recorder.step(KEYS[key], "key")
            self._show()

    def _begin(self, seed: int) -> None:
        self._frame = 0
        self._env.reset(self._task.randomize, seed)
        self._recorder = EpisodeRecorder(self._env, seed=seed, agent="You")
        self._next_seed = seed + 1
        self.games.append(self._recorder.episode)

    def _show(self) -> None:
        """Show the latest step: one frame on the grid, several if the motion is continuous."""
        track = self._track = track_of_record(self.episode)
        track.frames[0].caption = HELP
        if self._recorder.ended:
            track.frames[-1].caption += f", Enter starts seed {self._next_seed}"
        if not track.is_continuous:
            self._frame = len(track) - 1
        self._glide()
        self._timer.start()

    def _glide(self) -> None:
        """Show the next frame, and stop the timer at the last frame."""
        last = len(self._track) - 1
        self._frame = min(self._frame + 1, last)
        self._scene.show(self._frame, self._track)
        self.figure.canvas.draw_idle()
        if self._frame == last:
            self._timer.stop()

    def _on_key(self, event: Any) -> None:
        if event.key is not None:
            self.press(event.key)


def report_game(games: Sequence[Episode], task: Task) -> None:
    """Print the number and the outcome of the last game."""
    say(f"game {len(games)}")
    report_episode(games[-1], task.stations)


def play(
    backend: options.PlayBackend = "grid",
    layout: options.LayoutOption = None,
    stations: options.StationsOption = None,
    start: options.Start = None,
    seed: options.SeedOption = None,
    battery: options.BatteryOption = 200,
    max_steps: options.MaxSteps = 200,
    *,
    slippery: options.SlipperyOption,
    save: options.Save,
) -> None:
    """Drive the robot yourself, in a window.

    Arrows or NESW move, P picks, D drops, space waits, and Enter starts another game. Each game
    is saved; from the second game on, the names of its files have a number. With --backend drive,
    held arrow keys accelerate and steer the robot, which keeps its momentum.

    Example: warehouse play --backend drive --save games.npz
    """
    [backend] = with_slippery(slippery, layout, backend)
    limits = {"battery": battery, "max_steps": max_steps}
    task = load_task(layout, stations, start, backend=backend, **limits)
    env = task.make_env()
    if not has_display():
        raise NoDisplayError("'warehouse play' needs a window, but there is no display")
    seed = draw_seed() if seed is None else seed
    driver = SteeringWheel(env, seed) if is_drive(backend) else KeyDriver(env, seed, task)
    say(driver.keys)
    import matplotlib.pyplot as plt

    try:
        plt.show()
    finally:
        games = driver.games
        if len(games) > 1 and not games[-1].steps:
            del games[-1]  # the window was closed at its start
        else:
            report_game(games, task)
        replay_or_save(games[0], save, show=False)
        for game in games[1:]:
            replay_or_save(game, list(map(unused, save)), show=False)
        env.close()
