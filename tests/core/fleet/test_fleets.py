"""Many fleets together equal separate ones, and the same seed gives the same episode."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.fleet_truth import charged_layout, plain

from warehouse_core import FleetEnv, OrderStream
from warehouse_core.batch.fleet.engine import FleetEngine
from warehouse_core.batch.fleet.settings import FleetSettings, as_orders
from warehouse_core.fleet import Battery, People
from warehouse_core.orders.order import OrderQueue
from warehouse_core.world.layout import Layout

SIZES = (8, 7, 9, 8)
LAYOUTS: list[Layout] = [charged_layout(8, width, 2, seed=width) for width in SIZES]
ROBOTS, STEPS = 5, 70

KINDS: dict[str, dict[str, Any]] = {
    "stream": {"orders": (OrderStream(0.4, (5, 20)), OrderStream(1.0, (5, 9), start=30))},
    "queue": {"orders": OrderQueue(3, (5, 20)), "battery": Battery(1500, "joules")},
    "open": {"orders": 0.5, "dispatch": False, "late_penalty": 0.5},
    "none": {"people": People(3, "aisles"), "view_radius": 0},
    "people": {"people": People(2), "orders": 0.3, "team_reward": True, "view_radius": 3},
}

over_kinds = pytest.mark.parametrize("kind", KINDS)


def settings_of(kind: str) -> dict[str, Any]:
    usual = {"max_steps": 60, "battery": Battery(40), "view_radius": 1, "dispatch": True}
    chosen = usual | {"people": People(0), "late_penalty": 0.0, "team_reward": False} | KINDS[kind]
    return chosen | {"orders": as_orders(chosen.get("orders"))}


def helpful_actions(found: Any, stream: np.random.Generator) -> np.ndarray:
    """Return random actions that do something, more often than not what only stations allow."""
    weights = found["action_mask"] * np.array([1, 1, 1, 1, 1, 20, 20])
    return (stream.random(weights.shape) * weights).argmax(axis=1)


@over_kinds
def test_fleets_together_equal_separate_ones(kind: str) -> None:
    settings = FleetSettings(robots=ROBOTS, starts=None, **settings_of(kind))
    groups = [LAYOUTS, *([layout] for layout in LAYOUTS)]
    together, *apart = (FleetEngine(group, settings, "grid") for group in groups)
    stream, rows = np.random.default_rng(1), np.arange(len(LAYOUTS))
    together.begin(rows, [3, 4, 5, 6])
    for seed, fleets in enumerate(apart, 3):
        fleets.begin(rows[:1], [seed])
    picked = 0
    for number in range(STEPS):
        if number in (25, 40):  # some of them start again, with a seed and without
            some = np.array([2, 0])
            together.begin(some, [None, 9])
            apart[2].begin(rows[:1], [None])
            apart[0].begin(rows[:1], [9])
        masks = together.robots.masks()
        actions = helpful_actions({"action_mask": masks}, stream)
        step = together.step(actions)
        seen = together.observe()
        for floor, fleets in enumerate(apart):
            part = slice(floor * ROBOTS, (floor + 1) * ROBOTS)
            assert np.array_equal(fleets.robots.masks(), masks[part])
            mine = fleets.step(actions[part])
            for ours, theirs in zip(mine.outcome[:5], step.outcome[:5], strict=True):
                assert np.array_equal(ours, theirs[part])
            for ours, theirs in zip(mine[1:], step[1:], strict=True):
                assert np.array_equal(ours, theirs[part])
            for key, value in fleets.observe().items():
                assert np.array_equal(value, seen[key][part]), key  # type: ignore[literal-required]
            assert repr(fleets.measures(0)) == repr(together.measures(floor))
            assert np.array_equal(fleets.crowd.cells[0], together.crowd.cells[floor])
        picked += int(together.robots.has_item.sum())
    assert picked > 20


def episode(kind: str, seed: int, backend: str = "grid") -> Any:
    """Return all that a random episode shows, without arrays."""
    settings = settings_of(kind)
    fleet = FleetEnv(LAYOUTS[0], ROBOTS, backend=backend, **settings)
    stream = np.random.default_rng(1)
    found: list[Any] = [fleet.reset(seed=seed)]
    ended = np.zeros(ROBOTS, np.bool_)
    while not ended.all():
        found.append(fleet.step(helpful_actions(found[-1][-1], stream)))
        ended = found[-1][2] | found[-1][3]
    return plain(found), fleet.orders, repr(fleet.measures), fleet.people


@over_kinds
def test_the_same_seed_gives_the_same_episode(kind: str) -> None:
    first = episode(kind, 3)
    assert episode(kind, 3) == first
    assert episode(kind, 4) != first


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_the_same_seed_gives_the_same_episode_in_another_process(backend: str) -> None:
    code = f"import test_fleets; print(test_fleets.episode('people', 3, {backend!r}))"
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    said = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        check=True,
        text=True,
        env=os.environ | {"PYTHONPATH": path},
    )
    assert said.stdout.strip() == str(episode("people", 3, backend))


def test_starts_are_drawn_from_empty_cells_first() -> None:
    for robots in (4, 6):
        fleet = FleetEnv(["P..", "D..", "C##"], robots, battery=10**6)
        cells = set()
        for seed in range(30):
            fleet.reset(seed=seed)
            assert len(set(fleet.cells)) == robots
            cells |= set(fleet.cells)
        stations = {(0, 0), (1, 0), (2, 0)}
        assert cells & stations == (set() if robots == 4 else stations)


def test_a_floor_of_one_robot_among_people_is_moved_by_arrays() -> None:
    fleet = FleetEnv(["....", "...."], 1, people=People(2, "aisles"))
    arrays, _ = fleet.reset(seed=1)
    assert arrays["local_grid"].shape == (1, 25)
    assert len(set(fleet.cells + fleet.people)) == 3
