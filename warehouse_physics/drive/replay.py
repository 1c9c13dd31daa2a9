"""Replays of records of continuous control."""

from __future__ import annotations

from typing import Any

from warehouse_core import BackendError, Episode
from warehouse_core.wording import brief
from warehouse_physics.drive.env import OWN, DriveEnv
from warehouse_physics.drive.recording import DriveRecorder


def replay(episode: Episode, env: DriveEnv | str) -> Episode:
    """Drive the actions of a record again, and return the new record.

    Raises:
        BackendError: the record had obstacles, crates or bodies that a record does not keep.
    """
    if isinstance(env, str):
        if OWN in env:
            raise BackendError(
                "the recorded warehouse had obstacles, crates in given cells, or bodies of its "
                "own, which a record does not keep; give replay_episode(episode, backend=env) the "
                "environment"
            )
        env = DriveEnv.from_name(env, episode.layout)
    env.reset(seed=episode.seed, options={"layout": episode.layout, "start_pos": episode.cells[0]})
    recorder = DriveRecorder(env, seed=episode.seed, agent=episode.agent)
    for action, reason in zip(episode.actions, episode.reasons, strict=True):
        recorder.step(action_in(action), reason)
    return recorder.episode


def action_in(text: Any) -> tuple[float, float]:
    """Return the action in a text.

    Raises:
        ValueError: the text does not have two numbers.
    """
    try:
        first, second = map(float, str(text).split())
    except ValueError:
        raise ValueError(f"the action is {brief(text)}; it must be two numbers") from None
    return first, second
