"""Pages that play tracks: size, writing time, and drawing speed in Chromium without a GPU."""

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pytest
from helpers.fleet_truth import big_warehouse
from helpers.player_pages import Files, headless_chromium, wait_until
from helpers.timing import seconds

from agents.fleet.planned import PlannedFleet
from agents.lab.console.output import replay_or_save
from agents.mapf.graph import Graph
from agents.mapf.pibt import PIBT
from agents.run_episode import run_episode
from warehouse_core import Episode, FleetEnv, OrderStream, record_fleet_episode
from warehouse_core.viz.tracks import Track, track_of_record
from warehouse_core.viz.tracks.track import DrawnHit

STEPS = 1_000
FRAMES = 300
ROUNDS = 5

MAX_WRITING_SECONDS = 0.2
"""Maximum seconds for writing the shorter episode of bodies."""

MAX_MS = {200: 6.0, 1_000: 16.0}
"""Maximum milliseconds per frame by robots; a display with 60 frames per second allows 16 ms."""

MAX_SECONDS = 3.0
"""Maximum seconds from a request to the first picture, with 1,000 robots and 1,000 steps."""

MIN_RATE = 30.0
"""Minimum number of frames per second of a page with 1,000 robots, at any zoom."""

ZOOMS = (1, 4, 8, 16)

PLAY = """
async ([zoom, seconds]) => {
  const stamps = [];
  player.fit();
  player.zoom(zoom);
  player.seek(20);
  player.listeners.push(() => stamps.push(performance.now()));
  player.play();
  await new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
  player.pause();
  player.listeners.pop();
  return (1000 * (stamps.length - 1)) / (stamps.at(-1) - stamps[0]);
}
"""
"""Script that plays a page as a reader sees it, and returns the frames per second."""

DRAW = """
([frames, setting]) => {
  Object.assign(player, {chosen: null, hasHeat: false, isPlaying: true}, setting);
  const canvases = [...document.querySelectorAll("main canvas")];
  const contexts = canvases.map((canvas) => canvas.getContext("2d"));
  const spent = [];
  for (let frame = 0; frame < frames; frame++) {
    player.time = 500 + frame * player.speed / 60;
    const start = performance.now();
    player.draw();
    for (const context of contexts) context.getImageData(0, 0, 1, 1);
    spent.push(performance.now() - start);
  }
  return spent;
}
"""
"""Script that draws frames as playing does; reading a pixel waits until drawing has finished."""

Measured = Callable[[str, object], None]


@cache
def shift_of(robots: int, steps: int = STEPS) -> Episode:
    layout = big_warehouse()
    env = FleetEnv(
        layout, robots, orders=OrderStream(robots / 250), max_steps=steps, battery=10 * steps,
        dispatch=False,
    )  # fmt: skip
    agent = PlannedFleet(PIBT(Graph(layout)), "nearest", seconds=60.0)
    return record_fleet_episode(env, agent, seed=1)


def large_fleet(robots: int) -> Track:
    """Return the track of a planned shift with some robots marked as blocked in each step."""
    track, random = track_of_record(shift_of(robots)), np.random.default_rng(2)
    for frame in track.frames:
        blocked = random.choice(robots, robots // 50, replace=False).tolist()
        poses = [(robot, frame.robots[robot]) for robot in sorted(blocked)]
        frame.hits = tuple(DrawnHit(pose.at, "", robot) for robot, pose in poses if pose)
    return track


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with headless_chromium() as chromium:
        yield chromium


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    return Files(tmp_path_factory.mktemp("pages"))


def load(browser: Any, path: Path) -> Any:
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    page.goto(path.as_uri())
    wait_until(page, "globalThis.player?.theme !== undefined")
    page.evaluate("document.querySelector('canvas').getContext('2d').getImageData(0, 0, 1, 1)")
    return page


@pytest.mark.parametrize(("seed", "most"), [(12, 120_000), (2, 400_000)])
def test_a_page_of_bodies(seed: int, most: int, tmp_path: Path, measured: Measured) -> None:
    path, episode = tmp_path / "page.html", run_episode(backend="physics", seed=seed)
    spent = median(seconds(lambda: replay_or_save(episode, [path], None)) for _ in range(ROUNDS))
    size = path.stat().st_size
    what = f"page with {episode.steps} steps of physics, seed {seed}"
    measured(what, f"{size / 1e3:.0f} kB, written in {spent:.2f} s")
    assert size <= most
    if seed == 12:
        assert spent <= MAX_WRITING_SECONDS


@pytest.mark.parametrize(
    ("robots", "steps", "most"),
    [(200, STEPS, 3_000_000), (1_000, STEPS, 12_000_000), (1_000, 200, 2_000_000)],
)
def test_a_page_of_a_fleet(
    robots: int, steps: int, most: int, tmp_path: Path, measured: Measured
) -> None:
    path, episode = tmp_path / "page.html", shift_of(robots, steps)
    spent = seconds(lambda: replay_or_save(episode, [path], None))
    size, done = path.stat().st_size, episode.measures.delivered
    what = f"page with {robots:,} robots x {steps:,} steps, {done:,} deliveries"
    measured(what, f"{size / 1e6:.2f} MB, written in {spent:.1f} s")
    assert (episode.robots, episode.steps) == (robots, steps)
    assert size <= most


@pytest.mark.parametrize("robots", MAX_MS)
def test_frames_are_drawn_in_time(
    browser: Any, files: Files, robots: int, measured: Measured
) -> None:
    page = load(browser, files(f"{robots}", lambda: [large_fleet(robots)]))
    for words, setting in (("", {}), (", one chosen, with heat", {"chosen": 7, "hasHeat": True})):
        spent = page.evaluate(DRAW, [FRAMES, setting])
        what = f"a frame with {robots:,} robots on 140 x 500 cells{words}"
        measured(what, f"{median(spent):.1f} ms, at most {max(spent):.0f} ms")
        assert median(spent) <= MAX_MS[robots]
    page.close()


def test_a_thousand_robots_and_steps_open_in_time(
    browser: Any, files: Files, measured: Measured
) -> None:
    path = files("1000", lambda: [large_fleet(1_000)])
    spent = median(seconds(lambda: load(browser, path).close()) for _ in range(3))
    measured("opening 1,000 robots x 1,000 steps", f"{spent:.1f} s")
    assert spent <= MAX_SECONDS


def test_a_page_of_a_thousand_robots_plays_smoothly(
    browser: Any, files: Files, measured: Measured
) -> None:
    page = load(browser, files("1000", lambda: [large_fleet(1_000)]))
    for zoom in ZOOMS:
        rate = page.evaluate(PLAY, [zoom, 5])
        measured(f"1,000 robots on 140 x 500 cells, zoom {zoom}", f"{rate:.0f} frames per second")
        assert rate >= MIN_RATE
    page.close()
