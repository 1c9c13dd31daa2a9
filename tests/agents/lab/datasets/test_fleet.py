"""Episodes of a fleet as joint arrays."""

import numpy as np
import pytest

from agents.errors import EpisodeError
from agents.lab.datasets.fleet import FleetSource
from agents.registry import make_fleet_agent, make_team
from warehouse_core import FleetEnv, record_episode, shelf_layout
from warehouse_core.fleet.env import Actions
from warehouse_core.records import FleetAgent
from warehouse_core.task.encoding import FLEET_TILES, vector

FLOOR = shelf_layout(aisle=2, chargers=2)


def greedy(seed: int) -> FleetAgent:
    return make_team("greedy", 3, seed, FLOOR)


def pibt(seed: int) -> FleetAgent:
    return make_fleet_agent("pibt", None, seed, FLOOR, 3)


@pytest.mark.parametrize(
    ("orders", "make", "steps"), [(0.2, greedy, 40), (0.2, pibt, 40), (None, greedy, 90)]
)
def test_an_episode_is_what_the_fleet_does_and_each_robot_has_its_column(
    orders: float | None, make, steps: int
) -> None:
    env = FleetEnv(FLOOR, 3, orders=orders, max_steps=steps, dispatch=make is greedy)
    source = FleetSource("mine", make, env)
    found = dict(source.episodes(range(3)))
    assert [*found] == [*range(3)]
    for seed, arrays in found.items():
        shift = record_episode(env, make(seed), seed=seed)
        assert (arrays["actions"] == shift.actions).all()
        assert arrays["actions"].dtype == np.int64
        assert (arrays["infos/rewards"][1:] == shift.rewards).all()
        assert (arrays["rewards"] == np.sum(shift.rewards, axis=1)).all()
        assert [each in source.action_space for each in arrays["actions"]] == [True] * shift.steps
        seen, info = env.reset(seed)
        moments = [(seen, np.zeros(3, bool), np.zeros(3, bool), info)]
        agent = make(seed)
        agent.reset()
        for actions in arrays["actions"]:
            agent.act(env)  # which may assign orders
            seen, _, *ends, info = env.step(actions)
            moments.append((seen, *ends, info))
        observed, dones, outs, infos = zip(*moments, strict=True)
        vectors = np.array([vector(each, FLEET_TILES) for each in observed])
        assert vectors.tobytes() == arrays["observations"].tobytes()
        assert all(each in source.observation_space for each in arrays["observations"])
        done, out = np.array(dones), np.array(outs)
        assert (arrays["infos/terminations"] == done).all()
        assert (arrays["infos/truncations"] == out).all()
        masks = [each["action_mask"] for each in infos]
        assert (arrays["infos/action_mask"] == masks).all()
        blocked = [each["motion"]["blocked"] for each in infos[1:]]
        assert (arrays["infos/motion"][1:, :, 0] == blocked).all()
        assert not arrays["infos/motion"][0].any()
        assert arrays["terminations"].tolist() == done[1:].all(axis=1).tolist()
        assert (arrays["terminations"] | arrays["truncations"])[-1]
        assert not (arrays["terminations"] | arrays["truncations"])[:-1].any()
    done_early = [arrays["infos/terminations"][:-1].any() for arrays in found.values()]
    assert any(done_early) == (orders is None)


class Flying:
    def reset(self) -> None:
        pass

    def act(self, env: FleetEnv) -> Actions:
        return ["N", "FLY" if env.steps == 2 else "N"]


def test_an_action_that_does_not_exist_is_named_with_seed_and_step() -> None:
    source = FleetSource("flying", lambda seed: Flying(), FleetEnv(robots=2))
    with pytest.raises(EpisodeError, match=r"^seed 7, step 3, agent flying: AgentError"):
        next(source.episodes([7]))
