"""Bytes of pages that play tracks, and the time that writing them takes."""

from collections.abc import Callable
from pathlib import Path
from statistics import median

import pytest
from helpers.fleet_truth import big_warehouse
from helpers.timing import seconds

from agents.fleet.planned import PlannedFleet
from agents.lab.console.output import replay_or_save
from agents.mapf.graph import Graph
from agents.mapf.pibt import PIBT
from agents.run_episode import run_episode
from warehouse_core import FleetEnv, OrderStream, record_fleet_episode

STEPS = 1_000
ROUNDS = 5

MAX_SECONDS = 0.2
"""For the shorter episode of bodies."""

Measured = Callable[[str, object], None]


@pytest.mark.parametrize(("seed", "most"), [(12, 120_000), (2, 400_000)])
def test_a_page_of_bodies(seed: int, most: int, tmp_path: Path, measured: Measured) -> None:
    path, episode = tmp_path / "page.html", run_episode(backend="physics", seed=seed)
    spent = median(seconds(lambda: replay_or_save(episode, [path], None)) for _ in range(ROUNDS))
    size = path.stat().st_size
    what = f"page of {episode.steps} steps by physics, seed {seed}"
    measured(what, f"{size / 1e3:.0f} kB, written in {spent:.2f} s")
    assert size <= most
    if seed == 12:
        assert spent <= MAX_SECONDS


@pytest.mark.parametrize(("robots", "most"), [(200, 3_000_000), (1_000, 12_000_000)])
def test_a_page_of_a_fleet(robots: int, most: int, tmp_path: Path, measured: Measured) -> None:
    path, layout = tmp_path / "page.html", big_warehouse()
    env = FleetEnv(
        layout, robots, orders=OrderStream(robots / 250), max_steps=STEPS, battery=10 * STEPS,
        dispatch=False,
    )  # fmt: skip
    episode = record_fleet_episode(env, PlannedFleet(PIBT(Graph(layout)), "nearest", seconds=60.0))
    spent = seconds(lambda: replay_or_save(episode, [path], None))
    size, done = path.stat().st_size, episode.measures.delivered
    what = f"page of {robots:,} robots x {STEPS:,} steps, {done:,} deliveries"
    measured(what, f"{size / 1e6:.2f} MB, written in {spent:.1f} s")
    assert (episode.robots, episode.steps) == (robots, STEPS)
    assert size <= most
