"""Run episodes of a case and say in a row each what became of them; a worker does nothing else."""

from __future__ import annotations

from collections.abc import Sequence

from agents.experiments.case import Case, make_agent_for, make_env
from agents.experiments.store import Row
from warehouse_core import Episode, record_episode
from warehouse_core.failure_modes import diagnose


def run_episodes(case: Case, seeds: Sequence[int]) -> list[Row]:
    """Run one episode for each seed, each in a fresh environment with a fresh agent.

    The rows depend on nothing but the case and the seeds.
    """
    return [row_of(run_one(case, seed)) for seed in seeds]


def run_one(case: Case, seed: int) -> Episode:
    """Run one episode of a case and return its record."""
    env = make_env(case, seed)
    try:
        return record_episode(env, make_agent_for(case, seed), seed=seed)
    finally:
        env.close()


def row_of(episode: Episode) -> Row:
    """Return what is stored of an episode."""
    assert episode.seed is not None, "every episode here has a seed"
    diagnosis = diagnose(episode)
    row, col = diagnosis.cells[0] if diagnosis.cells else episode.cells[-1]
    return Row(
        episode.seed,
        diagnosis.mode,
        episode.steps,
        diagnosis.needed,
        episode.total_reward,
        episode.battery[-1],
        episode.seconds,
        episode.joules,
        row,
        col,
    )
