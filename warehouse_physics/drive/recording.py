"""Records of continuous control, in the form of every other episode.

A step of the record is a control step. Its action is a text with the two numbers, such as
``"1.0 -0.25"``, and its motion has the path of the body.
"""

from __future__ import annotations

import math
from typing import Any

from warehouse_core import Episode
from warehouse_core.records.recorder import explanation_of


def text_of(action: tuple[float, float]) -> str:
    """Return an action as text that has all its digits."""
    return f"{action[0]!r} {action[1]!r}"


class DriveRecorder:
    """A recorder that steps a ``DriveEnv``, whose episode has begun with ``seed``.

    Attributes:
        episode: the record so far.
    """

    def __init__(
        self, env: Any, observation: Any = None, *, seed: int | None = None, agent: str = ""
    ) -> None:
        self._env = env
        self.episode = Episode(env.layout, env.settings, seed, agent)
        self._observation = observation
        self._keep_frame(0.0)

    @property
    def place(self) -> str:
        """The present position of ``run``, such as ``"step 3"``."""
        return f"step {self.episode.steps + 1}"

    @property
    def ended(self) -> bool:
        """Whether the episode is over."""
        ended: bool = self.episode.terminated or self.episode.truncated
        return ended

    def step(self, action: Any, reason: str = "") -> Any:
        """Take one step, record it and return the observation."""
        env, episode = self._env, self.episode
        self._observation, reward, terminated, truncated, _ = env.step(action)
        episode.actions.append(text_of(env.last_action))
        episode.reasons.append(reason)
        episode.motions.append(env.last_motion)
        episode.terminated, episode.truncated = terminated, truncated
        self._keep_frame(reward)
        return self._observation

    def run(self, agent: Any) -> None:
        """Reset an agent and let it act until the episode is over."""
        agent.reset()
        while not self.ended:
            action = agent.act(self._observation)
            self.step(action, str(explanation_of(agent)))

    def _keep_frame(self, reward: float) -> None:
        env, episode = self._env, self.episode
        episode.cells.append(env.cell)
        episode.loaded.append(env.has_item)
        episode.battery.append(math.ceil(max(env.battery, 0.0)))
        episode.rewards.append(reward)
