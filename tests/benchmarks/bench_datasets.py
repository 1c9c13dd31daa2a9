"""Minari datasets: the number of steps that are recorded and written per minute."""

import shutil
from pathlib import Path
from time import perf_counter, process_time

import pytest

from agents.lab.datasets.minari_files import save_dataset
from agents.lab.datasets.source import Source

EPISODES, ROUNDS = 3_000, 3
LEAST = 1e6
"""Minimum number of steps per minute of CPU time."""


@pytest.mark.parametrize("agent", ["greedy", "astar", "random"])
def test_a_million_steps_a_minute_are_recorded_and_written(
    agent: str, measured, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    source, seeds = Source(agent), range(EPISODES)
    steps = sum(episode.steps for episode in source.episodes(seeds))

    def took() -> tuple[float, float]:
        """Return the CPU time and the wall-clock time of writing a dataset, in seconds."""
        starts = process_time(), perf_counter()
        folder = save_dataset("bench-v0", source, source.episodes(seeds))
        seconds = process_time() - starts[0], perf_counter() - starts[1]
        shutil.rmtree(folder)
        return seconds

    rounds = [took() for _ in range(ROUNDS)]
    cpu, clock = (60 * steps / min(each) for each in zip(*rounds, strict=True))
    measured(
        f"steps per minute written to a Minari dataset, {agent} agent",
        f"{cpu / 1e6:.2f} million in CPU time, {clock / 1e6:.2f} million in wall-clock time; "
        f"{steps / EPISODES:.0f} steps per episode",
    )
    assert cpu >= LEAST
