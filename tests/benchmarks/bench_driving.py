"""Robots that drive through plans: makespan, joules and hits, speed, memory and repeatability.

``WAREHOUSE_PLANS`` is the number of plans of each planner and number of robots.
"""

import hashlib
import os
import subprocess
import sys
import time
from typing import NamedTuple

import numpy as np
import pytest
from helpers.fleet_truth import big_warehouse
from helpers.timing import resident

from agents.mapf.execution import Execution, drive_steps, drive_through
from agents.mapf.graph import Graph
from agents.mapf.lacam import lacam
from agents.mapf.lifelong import run_lifelong
from agents.mapf.problem import Problem
from agents.registry import PLANNERS, make_planner
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.generators import kiva_warehouse
from warehouse_physics import DrivingMotion

PLANS, STEPS = int(os.environ.get("WAREHOUSE_PLANS", "1")), 100
MAX_RATIO = {32: 0.8, 100: 0.9, 192: 0.9}
"""Makespan driven through over that of joint steps, by number of robots."""

MAX_JOULES = 0.8
MEASURED = 2
"""Plans of which the joint steps are executed too; of the others they take as long a step."""

LAYOUT, STARTS, GOALS = kiva_warehouse()
ONCE = "lacam"
"""A planner of robots that go to their goals once."""

SPELL = 10
"""Simulated seconds whose duration is measured."""


def plan_of(name: str, robots: int, seed: int) -> np.ndarray:
    """Return a plan on the Kiva-like map, ``[T + 1, R]``."""
    graph = Graph(LAYOUT)
    if name == ONCE:
        stream = np.random.default_rng(seed)
        starts, goals = (stream.permutation(each)[:robots].tolist() for each in (STARTS, GOALS))
        return lacam(Problem(graph, starts, goals), 60.0, seed).cells
    planner = make_planner(name, seed, LAYOUT, robots)
    return run_lifelong(graph, planner, robots, STEPS, seed, STARTS, GOALS).cells


class Comparison(NamedTuple):
    """A plan driven through, and in joint steps if they were executed."""

    steps: int
    driven: Execution
    stepped: Execution | None


def compare(name: str, robots: int, seed: int) -> Comparison:
    """Execute a plan in both ways; the second only of the first plans."""
    plan = plan_of(name, robots, seed)
    stepped = drive_steps(LAYOUT, plan) if seed < MEASURED else None
    has_moves = (np.diff(plan, axis=0) != 0).any(axis=1)
    steps = int(np.flatnonzero(has_moves)[-1]) + 1
    return Comparison(steps, drive_through(LAYOUT, plan), stepped)


def ratios_of(found: list[Comparison]) -> tuple[float, float, int]:
    """Return the largest ratio of makespans and of joules, and the number of hits."""
    step = max(each.stepped.seconds / each.steps for each in found if each.stepped)
    return (
        max(each.driven.seconds / (step * each.steps) for each in found),
        max(each.driven.joules / each.stepped.joules for each in found if each.stepped),
        sum(each.driven.hits for each in found),
    )


@pytest.mark.parametrize("robots", MAX_RATIO)
@pytest.mark.parametrize("name", [*PLANNERS, ONCE])
def test_plans_are_driven_through_faster_than_in_joint_steps(
    name: str, robots: int, measured
) -> None:
    found = [compare(name, robots, seed) for seed in range(PLANS)]
    makespan, joules, hits = ratios_of(found)
    mean = np.mean([each.driven.seconds / each.steps for each in found])
    measured(
        f"driven through, {name}, {robots} robots, {PLANS} plans",
        f"{mean:.2f} s a joint step; makespan at most {makespan:.3f} of joint steps; joules at "
        f"most {joules:.3f} in {min(PLANS, MEASURED)} plans; {hits} hits",
    )
    assert hits == 0
    assert joules <= MAX_JOULES
    assert makespan <= MAX_RATIO[robots]


class Crowd:
    """Robots on a large map that go straight on for a few cells at random, and turn."""

    def __init__(self, robots: int) -> None:
        self.layout, self._stream = big_warehouse(), np.random.default_rng(robots)
        starts = self._stream.permutation(self.layout.open_cells)[:robots].tolist()
        self.motion, self._loaded = DrivingMotion(), [False] * robots
        self.motion.reset(self.layout, [divmod(cell, self.layout.width) for cell in starts], 0)
        self._actions = np.zeros(robots, np.intp)

    def drive(self, seconds: int) -> str:
        """Drive on, and return a digest of all paths."""
        digest, robots = hashlib.sha256(), len(self._actions)
        for _ in range(seconds):
            turns = self._stream.random(robots) < 0.3
            drawn = self._stream.integers(0, WAIT, robots)
            self._actions = np.where(turns, drawn, self._actions)
            moves = [DISPLACEMENTS[action] for action in self._actions.tolist()]
            for outcome in self.motion.advance(moves, self._loaded):
                assert not outcome.contacts
                digest.update(outcome.path.tobytes())
        return digest.hexdigest()


def test_a_thousand_bodies_drive_faster_than_real_time(measured) -> None:
    crowd, rounds = Crowd(1000), []
    for _ in range(4):
        since, used = time.perf_counter(), time.process_time()
        crowd.drive(SPELL)
        rounds.append((time.perf_counter() - since, time.process_time() - used))
    wall, cpu = (SPELL / min(column) for column in zip(*rounds, strict=True))
    measured(
        "simulated time over time taken, 1,000 bodies driven through",
        f"{wall:.1f} by the clock, {cpu:.1f} by CPU time, with {os.getloadavg()[0]:.1f} processes "
        "running or waiting",
    )
    assert cpu >= 5


def test_another_process_drives_to_the_same_bits(measured) -> None:
    code = "from bench_driving import Crowd; print(Crowd(100).drive(60))"
    path = os.pathsep.join([os.path.dirname(__file__), *sys.path])
    digests = {Crowd(100).drive(60)}
    for seed in "12":
        environment = os.environ | {"PYTHONPATH": path, "PYTHONHASHSEED": seed}
        run = [sys.executable, "-c", code]
        digests.add(subprocess.check_output(run, env=environment, text=True).strip())
    measured("different digests of the paths of 100 bodies in three processes", len(digests))
    assert len(digests) == 1


def test_memory_is_flat_over_a_thousand_seconds(measured) -> None:
    crowd = Crowd(100)
    crowd.drive(100)
    before = resident()
    crowd.drive(900)
    grown = resident() - before
    measured("memory gained by 100 bodies in 900 simulated seconds", f"{grown / 1e6:.1f} MB")
    assert grown < 1e6
