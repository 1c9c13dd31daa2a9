"""A copy of robots with bodies goes on to the last bit like its original; a batch has none."""

import copy
import pickle
import random
from collections.abc import Callable
from typing import Any

import pytest

from warehouse_core import DEFAULT_LAYOUT, BatchEnv, FleetEnv, WarehouseEnv
from warehouse_physics import Disturbances, DrivingMotion, RigidBodyMotion, Stop

ROUGH = Disturbances(
    actuation_noise=0.2, drag_spread=0.3, slippery=frozenset({(1, 2), (2, 1)}), motor_strength=0.9
)
BROKEN = Disturbances(actuation_noise=0.1, stops=(Stop(1, 3.0, 4.0),))

Env = WarehouseEnv | FleetEnv


def fleet(motion: Any, **settings: Any) -> FleetEnv:
    return FleetEnv(robots=3, people=1, backend=motion, **settings)


@pytest.mark.parametrize(
    "make",
    [
        lambda: WarehouseEnv(backend="physics"),
        lambda: WarehouseEnv(backend=RigidBodyMotion(None, ROUGH)),
        lambda: fleet(RigidBodyMotion(None, ROUGH)),
        lambda: fleet("driving", orders=0.2),
        lambda: fleet(DrivingMotion(None, BROKEN)),
    ],
)
@pytest.mark.parametrize("clone", [copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))])
def test_a_copy_goes_on_like_its_original(
    make: Callable[[], Env], clone: Callable[[Env], Env]
) -> None:
    env, draws = make(), random.Random(1)
    env.reset()  # the seed of the disturbances is drawn
    for steps in (0, 12):
        actions(env, steps, draws)
        twin, state = clone(env), draws.getstate()
        expected = actions(env, 5, draws)
        draws.setstate(state)
        assert actions(twin, 5, draws) == expected


def actions(env: Env, steps: int, draws: random.Random) -> list[bytes]:
    """Take random moves, which also lead into walls, and return all that the motion did."""
    done = []
    for _ in range(steps):
        if isinstance(env, WarehouseEnv):
            env.step(draws.randrange(4))
            outcomes = [env.last_motion]
        else:
            env.step([draws.randrange(5) for _ in range(3)])
            outcomes = [*env.last_motion]
        done += [pickle.dumps(each) for each in outcomes]
    return done


def test_a_copy_stays_in_its_own_space() -> None:
    env = WarehouseEnv(backend="physics")
    twin = copy.deepcopy(env)
    env.step("E")
    assert (env.state.robot_pos, twin.state.robot_pos) == ((1, 2), (1, 1))
    assert twin.step("S")[0]["robot_pos"] == (2, 1)


def test_robots_that_were_led_and_failed_have_done_the_same_in_the_copy() -> None:
    motion = DrivingMotion(None, Disturbances(actuation_noise=0.1))
    motion.reset(DEFAULT_LAYOUT, [(1, 1), (3, 1)], None)
    motion.advance([(0, 1), (0, 1)], [True, False])
    motion.extend([(2, 2), (3, 3)])
    motion.drive(0.7)
    motion.fail(1)
    cells = [(3, 2), (3, 3)]
    motion.extend(cells)
    cells[0] = (1, 1)  # a list of the caller's own, which may change
    motion.advance([(0, 1), (0, 1)], [True, False])
    twins = [copy.copy(motion), copy.deepcopy(motion)]
    for twin in (*twins, copy.deepcopy(twins[0])):
        assert twin.ways() == motion.ways()
        assert twin.ways().failed == [False, True]
    then = [pickle.dumps(each.drive(2.0)) for each in (motion, *twins)]
    assert len({*then}) == 1


def test_what_cannot_be_repeated_is_refused_in_a_line() -> None:
    batch = BatchEnv(2, backend="physics")
    with pytest.raises(TypeError, match=r"^a batch of bodies can be neither copied nor pickled; "):
        copy.deepcopy(batch)


def test_a_copy_of_a_closed_motion_needs_a_reset_like_its_original() -> None:
    motion = DrivingMotion(period=2.0)
    motion.reset(DEFAULT_LAYOUT, [(1, 1)], 0)
    motion.close()
    twin = copy.deepcopy(motion)
    assert twin.period == 2.0
    with pytest.raises(RuntimeError, match="needs a reset"):
        twin.ways()
