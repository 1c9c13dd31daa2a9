"""A copied environment with bodies goes on exactly like its original; a batch cannot be copied."""

import copy
import pickle
import random
from collections.abc import Callable
from itertools import product
from typing import Any

import gymnasium
import numpy as np
import pytest

from warehouse_core import DEFAULT_LAYOUT, BatchEnv, FleetEnv, WarehouseEnv
from warehouse_core.gymnasium_env import WarehouseGymnasiumEnv, WarehouseVectorEnv
from warehouse_core.pettingzoo_env import env as in_turn
from warehouse_core.pettingzoo_env import parallel_env
from warehouse_physics import Disturbances, DrivingMotion, RigidBodyMotion, RobotSpec, Stop

WHEELED = RobotSpec(drive="differential", recuperation=0.5)
ROUGH = Disturbances(
    actuation_noise=0.2,
    drag_spread=0.3,
    slippery=frozenset({(1, 2), (2, 1)}),
    motor_strength=0.9,
    odometry=0.02,
)
BROKEN = Disturbances(actuation_noise=0.1, stops=(Stop(1, 3.0, 4.0),), odometry=0.02)

Clone = Callable[[Any], Any]


def by_pickle(env: Any) -> Any:
    return pickle.loads(pickle.dumps(env))


CLONES = [copy.copy, copy.deepcopy, by_pickle]


def moving() -> RigidBodyMotion:
    return RigidBodyMotion(WHEELED, ROUGH)


def driving() -> DrivingMotion:
    return DrivingMotion(WHEELED, BROKEN)


def made(**settings: Any) -> Any:
    return gymnasium.make("warehouse_core.gymnasium_env:Warehouse-v0", **settings)


OWN: dict[str, Callable[[], Any]] = {
    "alone": lambda: WarehouseEnv(backend=moving()),
    "fleet": lambda: FleetEnv(robots=3, people=1, backend=moving(), orders=0.2),
    "driving": lambda: FleetEnv(robots=3, people=1, backend=driving(), orders=0.2),
    "gymnasium": lambda: WarehouseGymnasiumEnv(backend=moving(), scan=4),
    "gymnasium, vectors": lambda: WarehouseGymnasiumEnv(backend="physics", observation="vector"),
    "pettingzoo": lambda: parallel_env(robots=3, backend=moving()),
    "pettingzoo, driving": lambda: parallel_env(robots=3, backend=driving()),
}
WRAPPED: dict[str, Callable[[], Any]] = {
    "gymnasium.make": lambda: made(backend=moving(), scan=4),
    "pettingzoo, in turn": lambda: in_turn(robots=3, backend=driving()),
}
"""Environments in wrappers of other packages, where ``copy.copy`` copies only the wrapper."""


@pytest.mark.parametrize(
    ("form", "clone"),
    [*product((OWN | WRAPPED), [copy.deepcopy]), *product(["driving"], CLONES[::2])],
)
def test_a_copy_goes_on_like_its_original(form: str, clone: Clone) -> None:
    env, draws = (OWN | WRAPPED)[form](), random.Random(1)
    env.reset(seed=3)
    for steps in (0, 6):
        act(env, steps, draws)
        twin, state = clone(env), draws.getstate()
        expected = act(env, 3, draws)
        draws.setstate(state)
        assert act(twin, 3, draws) == expected


def act(env: Any, steps: int, draws: random.Random) -> list[Any]:
    """Take random moves, also into walls; return all observations and motions."""
    seen = []
    for _ in range(steps):
        if hasattr(env, "agent_selection"):
            for _ in env.agents:
                seen.append(env.last())
                env.step(draws.randrange(5))
        elif hasattr(env, "possible_agents"):
            seen.append(env.step({agent: draws.randrange(5) for agent in env.agents}))
        elif isinstance(env, FleetEnv):
            seen.append((env.step([draws.randrange(5) for _ in range(3)]), env.last_motion))
        else:
            seen.append(env.step(draws.randrange(5)))
            seen.append(getattr(env, "last_motion", None))
    return [plain(each) for each in seen]


def plain(value: Any) -> Any:
    """Return a value in which arrays are bytes, so that values can be compared exactly."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    return value


def test_a_copy_repeats_extended_routes_drives_and_failures() -> None:
    motion = DrivingMotion(None, Disturbances(actuation_noise=0.1))
    motion.reset(DEFAULT_LAYOUT, [(1, 1), (3, 1)], None)
    motion.advance([(0, 1), (0, 1)], [True, False])
    motion.extend([(2, 2), (3, 3)])
    motion.drive(0.7)
    motion.fail(1)
    cells = [(1, 2), motion.routes().ends[1]]
    motion.extend(cells)
    cells[0] = (1, 1)  # the caller may change its own list
    motion.advance([(0, 1), (0, 1)], [True, False])
    twins = [copy.copy(motion), copy.deepcopy(motion)]
    for twin in (*twins, copy.deepcopy(twins[0])):
        assert twin.routes() == motion.routes()
        assert twin.routes().failed == [False, True]
    then = [pickle.dumps(each.drive(2.0)) for each in (motion, *twins)]
    assert len({*then}) == 1


@pytest.mark.parametrize("clone", CLONES)
@pytest.mark.parametrize("kind", [BatchEnv, WarehouseVectorEnv])
def test_what_cannot_be_repeated_is_refused_in_a_line(kind: Any, clone: Clone) -> None:
    batch = kind(2, backend="physics")
    with pytest.raises(TypeError, match=r"^a batch of bodies can be neither copied nor pickled; "):
        clone(batch)


def test_a_copy_of_a_closed_motion_needs_a_reset_like_its_original() -> None:
    motion = DrivingMotion(period=2.0)
    motion.reset(DEFAULT_LAYOUT, [(1, 1)], 0)
    motion.close()
    twin = copy.deepcopy(motion)
    assert twin.period == 2.0
    with pytest.raises(RuntimeError, match="needs a reset"):
        twin.routes()
