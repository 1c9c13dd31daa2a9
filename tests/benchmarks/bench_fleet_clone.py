"""A clone of a planner of fleets on POGEMA's benchmark, beside its teacher, PIBT and others.

``SEEDS=0 pytest tests/benchmarks/bench_fleet_clone.py`` trains with one seed, ``STEPS=300000``
trains shorter, and ``EPISODES=32`` runs so many episodes. Settings were chosen on other floors than
those of the benchmark; its episodes from 34 on have served for nothing else. Gains are means of
differences on the same episodes, with 95% intervals.
"""

import os
import time
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from agents.lab.commands.fleet_clone import FleetFloors, make_fleet_learner
from agents.lab.commands.pogema.benchmark import Kind, instances
from agents.lab.commands.pogema.published import published
from agents.lab.commands.pogema.trial import Outcome, run_instance
from agents.lab.trials.interval import mean_interval
from agents.learning.traffic_network import TrafficNetwork

SEEDS = [int(seed) for seed in os.environ.get("SEEDS", "0 1 2").split()]
TEACHER, LAYOUTS = "windowed:groups=100", 1024
STEPS = int(os.environ.get("STEPS", "1000000"))
ROBOTS, EPISODES = 64, range(34, 34 + int(os.environ.get("EPISODES", "94")))
TRAINING_MINUTES = 120.0
LEAST = {"random": 2.42, "mazes": 1.65}
"""Goals a step of Follower, as published for all episodes, which a clone must exceed."""


@cache
def clone(seed: int) -> tuple[TrafficNetwork, float]:
    """Return a network, and the minutes of processor time of its training."""
    begin = time.process_time()
    floors = FleetFloors(ROBOTS, None, LAYOUTS, seed)
    learner = make_fleet_learner(TEACHER, floors, STEPS, seed)
    network = learner.learn(lambda *_: None)
    return network, (time.process_time() - begin) / 60


@cache
def outcomes(planner: str, collection: str) -> list[Outcome]:
    """Return what a planner reaches in the episodes."""
    found = instances([collection], [Kind.LIFELONG], [ROBOTS], EPISODES.stop, None)
    return [run_instance(one, planner, 60.0) for one in found if one.number in EPISODES]


def goals(planner: str, collection: str) -> np.ndarray:
    """Return the goals a step of a planner in each episode."""
    return np.array([each.goals / each.steps for each in outcomes(planner, collection)])


@pytest.mark.parametrize("seed", SEEDS)
def test_a_clone_reaches_more_goals_than_follower(seed: int, measured, tmp_path: Path) -> None:
    network, minutes = clone(seed)
    path = tmp_path / "clone.npz"
    network.save(path)
    for collection, least in LEAST.items():
        reached, plain = goals(f"clone:{path}", collection), goals("pibt", collection)
        gain = mean_interval(reached - plain)
        took = np.mean(
            [each.seconds / each.steps for each in outcomes(f"clone:{path}", collection)]
        )
        measured(
            f"goals a step of a clone of {TEACHER}, {STEPS:,} steps, seed {seed}, "
            f"POGEMA's {collection} maps, {ROBOTS} robots, {len(reached)} episodes",
            f"{reached.mean():.2f}, {gain.estimate:+.2f} ({gain.low:+.2f} to {gain.high:+.2f}) "
            f"beside PIBT; {1000 * took:.1f} ms a step; trained in {minutes:.1f} minutes of one "
            "processor",
        )
        assert reached.mean() > least
    assert minutes < TRAINING_MINUTES


@pytest.mark.parametrize("collection", LEAST)
def test_others_on_the_same_episodes(collection: str, measured) -> None:
    figures = {
        name: np.nanmean(np.array(each.values)[EPISODES])
        for name, each in published()[Kind.LIFELONG, collection, ROBOTS].items()
    }
    for planner in ("pibt", "pibt-lanes", "windowed", TEACHER):
        figures[planner] = goals(planner, collection).mean()
    words = ", ".join(f"{name} {figure:.2f}" for name, figure in figures.items())
    measured(
        f"goals a step of others, POGEMA's {collection} maps, {ROBOTS} robots, "
        f"{len(EPISODES)} episodes",
        words,
    )
