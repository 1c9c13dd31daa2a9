"""Continuous control: control steps per second, with VMAS as the baseline, and long runs.

The environment variable ``VMAS_PYTHON`` names a Python that has VMAS; without it there is no
baseline. A robot of VMAS has no walls, and two robots share an environment. ``DRIVE_NETWORK`` names
a file of ``warehouse train drive``, which is then compared with followers.
"""

import os
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from agents.drive import Follower
from agents.lab.training.driving import EXAM_SEED
from agents.learning import DrivePolicy
from agents.registry import make_agent
from warehouse_core import record_episode
from warehouse_core.records import drive_summary
from warehouse_physics import RobotSpec
from warehouse_physics.drive import DriveEnv, DriveVectorEnv

WORKER = Path(__file__).with_name("vmas_worker.py")

STEPS = 200_000
"""Control steps of all rows in a measurement."""

EPISODES = 100
"""Episodes of each driver, from the seed of the exam on."""

CASES = [(256, 0, 350_000), (4096, 0, 150_000), (4096, 16, 90_000)]
"""Rows, rays of each, and control steps per second to reach."""


def rate_of(rows: int, rays: int, drive: str) -> float:
    """Return the control steps per second of processor time, with observations and rewards."""
    spec = RobotSpec(drive=drive)
    env = DriveVectorEnv(rows, spec=spec, rays=rays, autoreset_mode="SameStep")
    env.reset(seed=0)
    actions = np.random.default_rng(0).uniform(-1, 1, (50, rows, 2))
    steps = max(STEPS // rows, 10)
    best = 0.0
    for _ in range(5):
        start = time.process_time()
        for number in range(steps):
            env.step(actions[number % 50])
        best = max(best, rows * steps / (time.process_time() - start))
    return best


def rate_of_vmas(rows: int, rays: int) -> float:
    """Return the steps of robots per second of VMAS, which has two robots in an environment."""
    python = os.environ["VMAS_PYTHON"]
    arguments = [python, str(WORKER), str(rows // 2), str(rays)]
    with subprocess.Popen(
        arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as worker:
        assert worker.stdin is not None
        assert worker.stdout is not None
        seconds = []
        for _ in range(3):
            worker.stdin.write("20\n")
            worker.stdin.flush()
            seconds.append(float(worker.stdout.readline()))
        worker.stdin.close()
    return 20 * rows / min(seconds)


@pytest.mark.parametrize(("rows", "rays", "least"), CASES)
def test_steps_per_second(measured, rows, rays, least):
    rate = rate_of(rows, rays, "omnidirectional")
    name = f"control steps per second, {rows:,} warehouses, {rays} rays"
    measured(name, f"{rate:,.0f}")
    measured(f"{name}, two wheels", f"{rate_of(rows, rays, 'differential'):,.0f}")
    if "VMAS_PYTHON" in os.environ:
        vmas = rate_of_vmas(rows, rays)
        measured(f"{name}, over VMAS", f"{rate / vmas:.1f} ({vmas:,.0f})")
    assert rate >= least


@pytest.mark.parametrize("drive", ["omnidirectional", "differential"])
def test_the_follower_delivers_in_300_episodes_without_a_hit(measured, drive):
    env, seconds, hits = DriveEnv(spec=RobotSpec(drive=drive)), [], 0
    for seed in range(300):
        agent = Follower(env, make_agent("astar", seed, env.layout))
        episode = record_episode(env, agent, seed=seed)
        assert episode.outcome == "delivered", seed
        summary = drive_summary(episode)
        hits += summary.hits
        seconds.append(summary.seconds)
    measured(f"follower on A*, {drive}", f"{np.mean(seconds):.1f} s, {hits} hits")
    assert hits == 0


@pytest.mark.parametrize(
    "trouble", ["nominal", "noise=0.1", "grip=0.1"], ids=["nominal", "noise", "slippery"]
)
@pytest.mark.parametrize("agent", ["greedy", "astar", "network"])
def test_drivers_of_a_disc(measured, agent, trouble):
    file = os.environ.get("DRIVE_NETWORK")
    if agent == "network" and not file:
        pytest.skip("DRIVE_NETWORK names no file")
    policy = DrivePolicy.load(Path(file)) if file and agent == "network" else None
    name = policy.backend if policy else "drive:drive=omnidirectional,rays=0,max_seconds=60"
    env = DriveEnv.from_name(name if trouble == "nominal" else f"{name},{trouble}")
    summaries = []
    for seed in range(EXAM_SEED, EXAM_SEED + EPISODES):
        driver = policy or Follower(env, make_agent(agent, seed, env.layout))
        episode = record_episode(env, driver, seed=seed)
        if episode.outcome == "delivered":
            summaries.append(drive_summary(episode))
    seconds, joules, hits = (
        np.mean([getattr(each, name) for each in summaries])
        for name in ("seconds", "joules", "hits")
    )
    share = len(summaries) / EPISODES
    words = f"{share:.1%} delivered, {seconds:.1f} s, {joules:,.0f} J, {hits:.2f} hits"
    measured(f"{agent} drives a disc, {trouble}", words)
    assert share > 0.2
