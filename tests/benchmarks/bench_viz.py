"""Exports and replays compared with plain matplotlib animations."""

import subprocess
import sys
from time import perf_counter

import numpy as np
from helpers.fleets import fleet_episode
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from agents.run_episode import run_episode
from warehouse_core import Episode, WarehouseEnv, random_layout, record_episode, shelf_layout
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
import resource, time
from agents.run_episode import run_episode
from warehouse_core.warehouse_viz import replay_animation
import warehouse_core.viz.replay
episode = run_episode(seed=2, backend="physics")
start = time.perf_counter()
replay_animation(episode, window=False).save({str(tmp_path / "film.gif")!r})
print(time.perf_counter() - start, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""
    words = [sys.executable, "-c", program]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    spent, megabytes = map(float, done.stdout.split())
    size = (tmp_path / "film.gif").stat().st_size / 1e6
    found = f"{spent:.1f} s, {megabytes:.0f} MB of memory, a file of {size:.1f} MB"
    measured("a GIF of 134 steps of physics", found)
    assert megabytes < 300


def test_a_gif_of_fifty_robots(times_faster, tmp_path):
    floor = shelf_layout(6, 6, 5, aisle=2, pickups=8, dropoffs=6, chargers=8)
    fleet = fleet_episode(
        layout=floor, robots=50, people=6, orders=0.8, max_steps=STEPS, battery=200
    )
    lone = episode_of(STEPS)
    ratio = times_faster(
        lambda: replay_animation(fleet, window=False).save(tmp_path / "fleet.gif"),
        lambda: replay_animation(lone, window=False).save(tmp_path / "lone.gif"),
        rounds=3,
    )
    assert ratio >= 1 / 5


def test_a_frame_of_a_fifty_by_fifty_grid(times_faster):
    layout = random_layout(50, 50, 0.3, seed=1)
    episode = run_episode(layout=layout, seed=5)
    replay = replay_animation(episode, window=False)
    plain = plain_animation(episode)
    frames = range(min(60, len(episode.cells)))

    def draw_ours() -> None:
        for frame in frames:
            replay.go_to(frame)
            replay.figure.canvas.draw()

    def draw_plain() -> None:
        for frame in frames:
            plain._func(frame)
            plain._fig.canvas.draw()

    start = perf_counter()
    draw_ours()
    assert len(frames) / (perf_counter() - start) >= 30
    assert times_faster(draw_ours, draw_plain, rounds=3) >= 1.0
