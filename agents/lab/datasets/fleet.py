"""Episodes of a fleet, as the joint data of all its robots.

Minari has datasets of one actor. A fleet is one here: an observation and an action hold all robots,
one after the other, as in the storage of OG-MARL. Infos hold what the format has no place for,
above all the reward of each robot.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from agents.lab.datasets.source import (
    INFO_FIELDS,
    EpisodeArrays,
    acting,
    infos_of,
    recorded_action,
)
from warehouse_core import FleetEnv
from warehouse_core.records import FleetAgent
from warehouse_core.task.encoding import FLEET_TILES, FleetArrays, vector, vector_limits
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tables import Flags

FIELDS = {
    "observations": "what each robot observes: warehouse_core.task.vector with FLEET_TILES",
    "actions": f"index of the action of each robot: {', '.join(ACTIONS)}",
    "rewards": "sum of the rewards of all robots in the step",
    "terminations": "whether the task of all robots was done",
    "truncations": "whether all robots had ended for another reason",
    "infos/rewards": "reward of each robot",
    "infos/terminations": "whether the task of each robot was done",
    "infos/truncations": "whether each robot had ended for another reason",
    **INFO_FIELDS,
}
"""Meaning of each array; the infos have an element for each robot."""


class FleetSource:
    """Episodes of an agent that directs a fleet of ``R`` robots.

    The episode of a seed is the one that ``warehouse fleet --seed`` shows. Observations are
    ``[T + 1, R, L]``, actions ``[T, R]``.

    Args:
        agent: name of the agent.
        make_agent: returns the agent of the episode with a seed.
        env: the fleet.
    """

    fields = FIELDS
    spec: EnvSpec | None = None

    def __init__(self, agent: str, make_agent: Callable[[int], FleetAgent], env: FleetEnv) -> None:
        self.agent, self._make_agent, self._env = agent, make_agent, env
        self.layout = layout = env.layout
        settings = env.settings
        low, high = vector_limits(
            layout.height, layout.width, settings.view_radius, settings.battery.capacity,
            settings.max_steps, FLEET_TILES,
        )  # fmt: skip
        one: spaces.Space[Any] = spaces.Box(low, high, dtype=np.float32)
        self.observation_space = batch_space(one, settings.robots)
        self.action_space = batch_space(spaces.Discrete(len(ACTIONS)), settings.robots)
        self.task = (
            f"Agent {agent} directs {settings.robots} robots that deliver orders on the backend "
            f"{env.backend}."
        )

    def episodes(self, seeds: Sequence[int]) -> Iterator[EpisodeArrays]:
        """Yield one whole episode for each seed, in order; see ``Source``."""
        for seed in seeds:
            yield EpisodeArrays(seed, self._episode(seed))

    def _episode(self, seed: int) -> dict[str, NDArray[Any]]:
        env, agent = self._env, self._make_agent(seed)
        observed, info = env.reset(seed)
        agent.reset()
        nobody = np.zeros(env.settings.robots, np.bool_)
        moments = [_moment(observed, np.zeros(len(nobody)), nobody, nobody, info)]
        actions = []
        while not all(env.ended):
            with acting(self.agent, lambda: (seed, env.steps + 1)):
                chosen = [recorded_action(each) for each in env.action_indices(agent.act(env))]
            moments.append(_moment(*env.step(chosen)))
            actions.append(chosen)
        arrays = {name: np.stack([each[name] for each in moments]) for name in moments[0]}
        is_done = arrays["infos/terminations"][1:]
        is_over = (is_done | arrays["infos/truncations"][1:]).all(axis=1)
        return {
            **arrays,
            "actions": np.array(actions),
            "rewards": arrays["infos/rewards"][1:].sum(axis=1),
            "terminations": is_done.all(axis=1),
            "truncations": is_over & ~is_done.all(axis=1),
        }


def _moment(
    observed: FleetArrays,
    rewards: NDArray[np.float64],
    terminated: Flags,
    truncated: Flags,
    info: dict[str, Any],
) -> dict[str, NDArray[Any]]:
    """Return what is recorded of a step, or of a reset, by name."""
    return {
        "observations": vector(observed, FLEET_TILES),
        "infos/rewards": rewards,
        "infos/terminations": terminated,
        "infos/truncations": truncated,
        **infos_of(info, len(rewards)),
    }
