"""Animated drawings in a browser show the right step at each time, and load nothing."""

from pathlib import Path
from typing import Any

import pytest
from helpers.player_pages import shown

from agents.lab.commands.run import run_episode
from warehouse_core.viz.svg import animated_svg
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import INTERVAL_MS

pytestmark = pytest.mark.browser

ROBOT = """
seconds => {
  const root = document.documentElement;
  root.pauseAnimations();
  root.setCurrentTime(seconds);
  const isSeen = (node) =>
    node === root || (getComputedStyle(node).opacity !== "0" && isSeen(node.parentNode));
  const seen = (selector) => [...root.querySelectorAll(`.moves ${selector}`)].find(isSeen);
  const disc = seen("circle");
  const floor = root.querySelector(".moves .floor").getBoundingClientRect();
  const box = disc.getBoundingClientRect();
  const cell = floor.width / 12;
  return [
    (box.x + box.width / 2 - floor.x) / cell, (box.y + box.height / 2 - floor.y) / cell,
    disc.classList[0], seen(".count").textContent,
  ];
}
"""
SEEN = 'name => getComputedStyle(document.querySelector(`.${name}`)).display !== "none"'
PAPER = 'getComputedStyle(document.querySelector(".paper")).fill'


def test_a_browser_shows_the_robot_of_each_step_in_the_colours_and_motion_that_are_preferred(
    browser: Any, tmp_path: Path
) -> None:
    track = track_of_record(run_episode("greedy", seed=12))
    file = tmp_path / "drawing.svg"
    file.write_text(animated_svg([track]), encoding="utf-8")
    with shown(browser) as light:
        light.page.goto(file.as_uri())
        for step in (0, 5, 12, 23):
            [pose] = track.frames[step].robots
            assert pose is not None
            seconds = (step + 0.01) * INTERVAL_MS / 1000
            x, y, look, counter = light.page.evaluate(ROBOT, seconds)
            assert (x, y) == pytest.approx(pose.at, abs=0.05)
            assert (look, counter) == ("loaded" if pose.loaded else "robot", f"step {step} of 23")
        assert [light.page.evaluate(SEEN, name) for name in ("moves", "rests")] == [True, False]
        assert light.page.evaluate(PAPER) == "rgb(255, 255, 255)"
        assert light.requests == [file.as_uri()]
    with shown(browser, color_scheme="dark", reduced_motion="reduce") as dark:
        dark.page.goto(file.as_uri())
        assert [dark.page.evaluate(SEEN, name) for name in ("moves", "rests")] == [False, True]
        assert dark.page.evaluate(PAPER) == "rgb(23, 24, 28)"
