"""Speed of a page that plays 1,000 robots, in Chromium without a GPU."""

from pathlib import Path
from typing import Any

import numpy as np
from helpers.fleet_truth import big_warehouse
from helpers.player_pages import Files, headless_chromium, wait_until

from agents.fleet.planned import PlannedFleet
from agents.mapf.graph import Graph
from agents.mapf.pibt import PIBT
from warehouse_core import FleetEnv, OrderStream, record_fleet_episode
from warehouse_core.viz.tracks import Track, track_of_record
from warehouse_core.viz.tracks.track import DrawnHit

STEPS = 1_000

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


def large_fleet(robots: int) -> Track:
    """Return the track of a planned shift with some robots marked as blocked in each step."""
    layout, random = big_warehouse(), np.random.default_rng(2)
    env = FleetEnv(
        layout, robots, orders=OrderStream(robots / 250), max_steps=STEPS, battery=10 * STEPS,
        dispatch=False,
    )  # fmt: skip
    agent = PlannedFleet(PIBT(Graph(layout)), "nearest", seconds=60.0)
    track = track_of_record(record_fleet_episode(env, agent, seed=1))
    for frame in track.frames:
        blocked = random.choice(robots, robots // 50, replace=False).tolist()
        poses = [(robot, frame.robots[robot]) for robot in sorted(blocked)]
        frame.hits = tuple(DrawnHit(pose.at, "", robot) for robot, pose in poses if pose)
    return track


def load(browser: Any, path: Path) -> Any:
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    page.goto(path.as_uri())
    wait_until(page, "globalThis.player?.theme !== undefined")
    page.evaluate("document.querySelector('canvas').getContext('2d').getImageData(0, 0, 1, 1)")
    return page


def test_a_page_of_a_thousand_robots_plays_smoothly(tmp_path, measured) -> None:
    with headless_chromium() as browser:
        page = load(browser, Files(tmp_path)("1000", lambda: [large_fleet(1_000)]))
        for zoom in ZOOMS:
            rate = page.evaluate(PLAY, [zoom, 5])
            name = f"1,000 robots on 140 x 500 cells, zoom {zoom}"
            measured(name, f"{rate:.0f} frames per second")
            assert rate >= MIN_RATE
        page.close()
