"""Exports and replays compared with plain matplotlib animations."""

import subprocess
import sys

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from warehouse_core import Episode, WarehouseEnv, record_episode
from warehouse_core.warehouse_viz import replay_animation

STEPS = 100
TILES = "#.PDRr"


class Waiter:
    """An agent that moves up and down, so that an episode has the maximum number of steps."""

    def reset(self) -> None:
        self.turn = 0

    def act(self, observation) -> str:
        self.turn += 1
        return "NS"[self.turn // 3 % 2]


def episode_of(steps: int) -> Episode:
    env = WarehouseEnv(max_steps=steps, battery=steps)
    return record_episode(env, Waiter(), seed=1, randomize=False)


def plain_animation(episode: Episode) -> FuncAnimation:
    """Return the simplest animation, which redraws ``imshow`` and a line in each frame."""
    images = [[[TILES.index(tile) for tile in row] for row in frame] for frame in episode.frames]
    figure = Figure(figsize=(11.05, 5.75), dpi=100)
    FigureCanvasAgg(figure)
    grid, chart = figure.subplots(1, 2)
    picture = grid.imshow(np.array(images[0]), vmin=0, vmax=5)
    line = chart.plot(episode.rewards)[0]

    def show(frame: int) -> tuple[()]:
        picture.set_data(np.array(images[frame]))
        line.set_data(range(frame + 1), episode.rewards[: frame + 1])
        return ()

    return FuncAnimation(figure, show, frames=len(images), cache_frame_data=False)


def test_a_gif_of_two_hundred_steps(times_faster, tmp_path):
    episode = episode_of(2 * STEPS)
    assert episode.steps == 2 * STEPS

    def save_ours() -> None:
        replay_animation(episode, window=False).save(tmp_path / "ours.gif")

    def save_plain() -> None:
        plain_animation(episode).save(tmp_path / "plain.gif", writer=PillowWriter(fps=7))

    assert times_faster(save_ours, save_plain, rounds=1) >= 4.0


def test_a_gif_of_a_physics_episode_is_small_in_memory(measured, tmp_path):
    """Measure the time without imports, and the peak memory of the whole process."""
    program = f"""
import re, time
from pathlib import Path
from agents.run_episode import run_episode
from warehouse_core.warehouse_viz import replay_animation
import warehouse_core.viz.replay
episode = run_episode(seed=2, backend="physics")
start = time.perf_counter()
replay_animation(episode, window=False).save({str(tmp_path / "film.gif")!r})
spent = time.perf_counter() - start
# The peak of getrusage would include the memory of the process that started this one.
peak = re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1]
print(spent, int(peak) / 1024)
"""
    words = [sys.executable, "-c", program]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    spent, megabytes = map(float, done.stdout.split())
    size = (tmp_path / "film.gif").stat().st_size / 1e6
    found = f"{spent:.1f} s, {megabytes:.0f} MB of memory, a file of {size:.1f} MB"
    measured("a GIF of 134 steps of physics", found)
    assert megabytes < 300
