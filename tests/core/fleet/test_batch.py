"""Many fleets at once: each equals a ``FleetEnv``."""

from typing import Any

import numpy as np
import pytest

from warehouse_core import FleetEnv, Layout
from warehouse_core.errors import EndedError
from warehouse_core.fleet import FleetBatch, People
from warehouse_core.motion.grid import GridFleetBatch

YARD = Layout(["......", ".P..D.", "..##.C"])
HALL = Layout(["P....", ".....", "....D"])
SETTINGS: dict[str, Any] = {"orders": 0.3, "max_steps": 30, "battery": 40, "people": People(1)}
FLEETS, ROBOTS, STEPS = 3, 2, 75
LAYOUTS = [YARD, HALL, YARD]


def batch(mode: str, **settings: Any) -> FleetBatch:
    return FleetBatch(FLEETS, LAYOUTS, ROBOTS, autoreset_mode=mode, **{**SETTINGS, **settings})


def fleets(**settings: Any) -> list[FleetEnv]:
    return [FleetEnv(layout, ROBOTS, **{**SETTINGS, **settings}) for layout in LAYOUTS]


def joined(parts: list[Any]) -> dict[str, np.ndarray]:
    """Return arrays of fleets as rows; those without a charger observe none."""
    keys = parts[0].keys()
    missing = np.full((ROBOTS, 2), -1)
    return {key: np.concatenate([part.get(key, missing) for part in parts]) for key in keys}


def equal(found: Any, parts: list[Any]) -> None:
    expected = joined(parts)
    assert found.keys() == expected.keys()
    for key, values in expected.items():
        assert np.array_equal(found[key], values), key


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_each_fleet_is_a_fleet_env_that_restarts(mode: str) -> None:
    many, single = batch(mode), fleets()
    arrays, info = many.reset([7, 8, 9])
    first = [env.reset(seed) for env, seed in zip(single, (7, 8, 9), strict=True)]
    equal(arrays, [each for each, _ in first])
    assert np.array_equal(info["action_mask"], many.action_masks())
    stream = np.random.default_rng(2)
    restarted, restarts = False, 0
    for _ in range(STEPS):
        actions = stream.integers(7, size=FLEETS * ROBOTS)
        if mode == "Disabled" and many._ended().any():
            with pytest.raises(EndedError, match="must be reset"):
                many.step(actions)
            many.reset(mask=np.ones(FLEETS, np.bool_))
            for env in single:
                env.reset()
        arrays, rewards, terminated, truncated, info = many.step(actions)
        if restarted:
            assert not np.concatenate([rewards, truncated, info["_motion"]]).any()
            assert not any(values.any() for values in info["motion"].values())
            equal(arrays, [env.reset()[0] for env in single])
            restarted = False
            continue
        steps = [env.step(a) for env, a in zip(single, np.split(actions, FLEETS), strict=True)]
        assert np.array_equal(rewards, np.concatenate([step[1] for step in steps]))
        assert np.array_equal(terminated, np.concatenate([step[2] for step in steps]))
        assert np.array_equal(truncated, np.concatenate([step[3] for step in steps]))
        last, masks = [step[0] for step in steps], [step[4]["action_mask"] for step in steps]
        if not truncated.all():
            equal(arrays, last)
            assert np.array_equal(info["action_mask"], np.concatenate(masks))
            assert "final_obs" not in info
            continue
        restarts += 1
        restarted = mode == "NextStep"
        if mode == "SameStep":
            assert info["_final_obs"].all()
            equal(info["final_obs"], last)
            final = info["final_info"]
            assert np.array_equal(final["action_mask"], np.concatenate(masks))
            equal(arrays, [env.reset()[0] for env in single])
    assert restarts == 2
    assert many.measures(1).steps == single[1].steps
    many.close()


def test_a_fleet_restarts_when_its_last_robot_has_ended() -> None:
    layout = Layout(["PD..", "...."])
    many = FleetBatch(2, layout, 2, max_steps=6, autoreset_mode="SameStep", view_radius=0)
    assert (many.num_envs, many.size) == (4, (2, 4))
    many.reset(seed=1)
    flags = []
    for step in range(6):
        _, rewards, terminated, truncated, info = many.step(np.full(4, 4))
        flags.append((terminated | truncated).tolist())
        assert ("final_obs" in info) == (step == 5)
        assert rewards.all()
    assert flags == [[False] * 4] * 5 + [[True] * 4]


@pytest.mark.parametrize("robots", [1, 2])
def test_fleets_on_the_grid_are_moved_by_arrays(robots: int) -> None:
    """A motion for each floor would be a hundred times slower for thousands of lone robots."""
    many = FleetBatch(3, YARD, robots, orders=0.3)
    assert isinstance(many._engine.motion, GridFleetBatch)


def test_a_mask_resets_some_fleets_only() -> None:
    many = batch("NextStep")
    with pytest.raises(EndedError, match="first reset"):
        many.reset(mask=np.ones(FLEETS, np.bool_))
    many.reset(seed=1)
    many.step(np.full(FLEETS * ROBOTS, 4))
    arrays, info = many.reset(mask=np.array([False, True, False]))
    assert arrays["steps"].ravel().tolist() == [1, 1, 0, 0, 1, 1]
    assert info["_action_mask"].tolist() == [False, False, True, True, False, False]


def test_bad_input_is_an_error() -> None:
    with pytest.raises(ValueError, match="2 layouts for 3 rows"):
        FleetBatch(3, [YARD, HALL], 2)
    with pytest.raises(TypeError, match="unexpected keyword argument 'speed'"):
        FleetBatch(3, YARD, 2, speed=1)
    with pytest.raises(ValueError, match=r"^fleet is 3; it must be at most 2"):
        batch("NextStep").measures(3)


def test_fleets_of_bodies_are_moved_by_a_motion_for_each_floor() -> None:
    many, single = batch("Disabled", backend="physics"), fleets(backend="physics")
    many.reset([7, 8, 9])
    for env, seed in zip(single, (7, 8, 9), strict=True):
        env.reset(seed)
    stream = np.random.default_rng(2)
    for actions in stream.integers(4, size=(5, FLEETS, ROBOTS)):
        arrays, rewards, *_ = many.step(actions.ravel())
        steps = [env.step(each) for env, each in zip(single, actions, strict=True)]
        equal(arrays, [step[0] for step in steps])
        assert np.array_equal(rewards, np.concatenate([step[1] for step in steps]))
    many.close()
