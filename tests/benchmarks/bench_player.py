"""Opening and drawing pages of large fleets in headless Chromium, without a GPU."""

from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pytest
from helpers.fleet_truth import big_warehouse
from helpers.player_pages import headless_chromium, wait_until
from helpers.timing import seconds
from numpy.typing import NDArray

from warehouse_core import Layout, Order
from warehouse_core.viz.player import player_page
from warehouse_core.viz.tracks import Frame, Pose, Track
from warehouse_core.viz.tracks.track import FleetFrame, Hit
from warehouse_core.world.tiles import WALL

Write = Callable[[int], Path]

HEIGHT, WIDTH = 140, 500
STEPS = 1_000
FRAMES = 300

MAX_MS = {200: 6.0, 1_000: 16.0}
"""Of a frame by robots; 16 ms is that of a display with 60 frames a second."""

MAX_SECONDS = 3.0
"""From a request to the first picture, of 1,000 robots and 1,000 steps."""

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
"""Draws frames as playing does; reading a pixel waits until all has been drawn."""


def walks(robots: int, layout: Layout) -> NDArray[np.intp]:
    """Return [steps + 1, robots, 2] rows and columns of robots that mostly go on as before."""
    random = np.random.default_rng(1)
    is_open = np.array([[tile != WALL for tile in row] for row in layout.rows])
    free = np.argwhere(is_open)
    at = free[random.choice(len(free), robots, replace=False)]
    sides = np.array([(0, 1), (1, 0), (0, -1), (-1, 0)])
    heading = random.integers(0, 4, robots)
    found = [at]
    for _ in range(STEPS):
        to = np.clip(at + sides[heading], 0, (HEIGHT - 1, WIDTH - 1))
        to = np.where(is_open[to[:, 0], to[:, 1], None], to, at)
        turns = (to == at).all(axis=1) | (random.random(robots) < 0.05)
        heading = np.where(turns, random.integers(0, 4, robots), heading)
        at = to
        found.append(at)
    return np.array(found)


def large_fleet(robots: int) -> Track:
    """Return robots that carry items, are blocked now and then, and have orders."""
    layout = big_warehouse()
    places = walks(robots, layout).tolist()
    random = np.random.default_rng(2)
    items = random.integers(-4, 4, robots).tolist()
    frames = []
    for step, now in enumerate(places):
        poses = tuple(
            Pose((col + 0.5, row + 0.5), 0.0, item >= 0)
            for (row, col), item in zip(now, items, strict=True)
        )
        hits = tuple(
            Hit(poses[robot].at, "", robot)
            for robot in sorted(random.choice(robots, robots // 50, replace=False).tolist())
        )
        fleet = FleetFrame(
            (), tuple(item if item >= 0 else None for item in items), (1 - step / STEPS,) * robots
        )
        frames.append(Frame(layout.rows, poses, float(step), hits=hits, fleet=fleet))
    orders = []
    for order in range(robots):
        released, pickup = order * STEPS // robots, layout.pickups[order % len(layout.pickups)]
        times = released + 100, released + 200
        due = released + 150 + 10 * (order % 10)
        orders.append(Order(released, due, pickup, layout.dropoffs[0], None, order, *times))
    ramp: list[float] = [*range(STEPS + 1)]
    level = [1 - step / STEPS for step in range(STEPS + 1)]
    metrics: dict[str, list[float]] = {
        "released": ramp, "delivered": ramp, "joules": ramp,
        "battery_mean": level, "battery_lowest": level,
    }  # fmt: skip
    lateness = [(step, step % 7 - 3) for step in range(STEPS + 1)]
    return Track(frames, metrics, title=f"{robots} robots", lateness=lateness, orders=orders)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with headless_chromium() as chromium:
        yield chromium


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Write:
    """Return a function that writes the page of a fleet, once."""
    folder = tmp_path_factory.mktemp("pages")

    def write(robots: int) -> Path:
        path = folder / f"{robots}.html"
        if not path.exists():
            path.write_text(player_page([large_fleet(robots)]), encoding="utf-8")
        return path

    return write


def load(browser: Any, path: Path) -> Any:
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    page.goto(path.as_uri())
    wait_until(page, "globalThis.player?.theme !== undefined")
    page.evaluate("document.querySelector('canvas').getContext('2d').getImageData(0, 0, 1, 1)")
    return page


@pytest.mark.parametrize("robots", MAX_MS)
def test_frames_are_drawn_in_time(
    browser: Any,
    written: Write,
    robots: int,
    measured: Callable[[str, object], None],
) -> None:
    page = load(browser, written(robots))
    for words, setting in (("", {}), (", one chosen, with heat", {"chosen": 7, "hasHeat": True})):
        spent = page.evaluate(DRAW, [FRAMES, setting])
        what = f"a frame of {robots:,} robots on {HEIGHT} x {WIDTH} cells{words}"
        measured(what, f"{median(spent):.1f} ms, at most {max(spent):.0f} ms")
        assert median(spent) <= MAX_MS[robots]
    page.close()


def test_a_thousand_robots_and_steps_open_in_time(
    browser: Any, written: Write, measured: Callable[[str, object], None]
) -> None:
    path = written(1_000)
    spent = median(seconds(lambda: load(browser, path).close()) for _ in range(3))
    measured("opening 1,000 robots x 1,000 steps", f"{spent:.1f} s")
    assert spent <= MAX_SECONDS
