"""Each of many fleets equals a ``FleetEnv``, and the same seed gives the same episode."""

from typing import Any

import numpy as np
import pytest
from helpers.batches import MOTION
from helpers.fleet_truth import charged_layout, random_lone_steps_equal

from warehouse_core import FleetEnv, Layout, OrderQueue, OrderStream
from warehouse_core.batch import AUTORESET_MODES
from warehouse_core.fleet import Battery, FleetBatch, People

YARD = Layout(["......", ".P..D.", "..##.C"])
FLEETS, ROBOTS, STEPS = 4, 5, 60
LAYOUTS = [charged_layout(8, width, 2, seed=width) for width in (8, 7, 9, 8)]

KINDS: dict[str, dict[str, Any]] = {
    "stream": {"orders": (OrderStream(0.4, (5, 20)), OrderStream(1.0, (5, 9), start=20))},
    "queue": {"orders": OrderQueue(3, (5, 20)), "battery": Battery(1500, "joules")},
    "open": {"orders": 0.5, "dispatch": False, "late_penalty": 0.5},
    "none": {"people": People(3, "aisles"), "view_radius": 0},
    "people": {"people": 2, "orders": 0.3, "team_reward": True, "view_radius": 3},
    "headings": {"moves": "turn", "orders": 0.3, "people": 1},
    "bodies": {"backend": "physics", "orders": 0.3, "people": 1, "max_steps": 5},
}

over_kinds = pytest.mark.parametrize("kind", KINDS)


def settings_of(kind: str) -> dict[str, Any]:
    return {"max_steps": 36, "battery": 28, "view_radius": 1} | KINDS[kind]


def helpful_actions(mask: np.ndarray, stream: np.random.Generator) -> np.ndarray:
    """Return random actions with an effect, mostly those that only stations allow."""
    weights = mask * np.array([*[1] * (mask.shape[1] - 2), 20, 20])
    return (stream.random(weights.shape) * weights).argmax(axis=1)


def equal(seen: Any, masks: np.ndarray, fleet: int, expected: tuple[Any, dict[str, Any]]) -> None:
    """Compare the rows of a fleet with a ``FleetEnv``, whose observations may lack chargers."""
    rows = slice(fleet * ROBOTS, (fleet + 1) * ROBOTS)
    arrays, info = expected
    assert arrays.keys() <= seen.keys()
    for key, values in seen.items():
        assert np.array_equal(values[rows], arrays.get(key, [[-1, -1]] * ROBOTS)), key
    assert np.array_equal(masks[rows], info["action_mask"])


@over_kinds
@pytest.mark.parametrize("mode", AUTORESET_MODES)
def test_each_fleet_is_a_fleet_env_that_restarts(mode: str, kind: str) -> None:
    """Some fleets are reset in between, with and without a seed."""
    settings, steps = settings_of(kind), 12 if kind == "bodies" else STEPS
    many = FleetBatch(FLEETS, LAYOUTS, ROBOTS, autoreset_mode=mode, **settings)
    single = [FleetEnv(layout, ROBOTS, **settings) for layout in LAYOUTS]
    stream, restarts, picked = np.random.default_rng(2), 0, 0
    chosen, seeds = np.ones(FLEETS, np.bool_), [7, 8, 9, 3]
    for number in range(steps):
        if chosen.any():
            arrays, info = many.reset(seeds, chosen if number else None)
            for fleet in np.flatnonzero(chosen).tolist():
                equal(arrays, info["action_mask"], fleet, single[fleet].reset(seeds[fleet]))
            assert np.array_equal(info["_action_mask"], np.repeat(chosen, ROBOTS))
        over, actions = many._ended(), helpful_actions(many.action_masks(), stream)
        arrays, rewards, terminated, truncated, info = many.step(actions)
        motion = {key: info["motion"][key] for key in MOTION}
        for key in MOTION:
            assert np.array_equal(info["motion"][f"_{key}"], info["_motion"])
        for fleet, env in enumerate(single):
            rows = slice(fleet * ROBOTS, (fleet + 1) * ROBOTS)
            if over[fleet]:  # this step takes no action
                seen, said = env.reset()
                zeros = rewards[rows], truncated[rows], *(motion[key][rows] for key in motion)
                assert not np.any(zeros)
            else:
                seen, *verdicts, said = env.step(actions[rows])
                verdicts += [said["motion"][key] for key in motion]
                mine = rewards, terminated, truncated, *motion.values()
                for ours, theirs in zip(mine, verdicts, strict=True):
                    assert np.array_equal(ours[rows], theirs)
            picked, restarts = picked + sum(env.loaded), restarts + all(env.ended)
            is_final = mode == "SameStep" and all(env.ended)
            assert (info["_motion"][rows] != (over[fleet] or is_final)).all()
            if is_final:
                assert info["_final_obs"][rows].all()
                final = info["final_info"]["action_mask"]
                equal(info["final_obs"], final, fleet, (seen, said))
                seen, said = env.reset()
            assert repr(many.measures(fleet)) == repr(env.measures)
            equal(arrays, info["action_mask"], fleet, (seen, said))
        chosen = many._ended() & (mode == "Disabled")
        chosen[[0, 2]] |= number == steps // 3
        seeds = [None, 77, 5, 78]
    assert restarts >= FLEETS
    assert picked > 20 or kind == "bodies"
    many.close()


def test_bad_input_is_an_error() -> None:
    with pytest.raises(ValueError, match="2 layouts for 3 rows"):
        FleetBatch(3, [YARD, YARD], 2)
    with pytest.raises(TypeError, match="unexpected keyword argument 'speed'"):
        FleetBatch(3, YARD, 2, speed=1)
    with pytest.raises(ValueError, match=r"^fleet is 3; it must be at most 2"):
        FleetBatch(3, YARD, 2).measures(3)


def test_random_starts_are_empty_cells_first() -> None:
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


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_a_fleet_of_one_robot_is_the_warehouse_of_the_chapter(backend: str) -> None:
    """The episodes are random, on floors with chargers."""
    assert random_lone_steps_equal(600, seed=1, backend=backend) > 6
