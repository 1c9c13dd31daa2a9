"""How often the intervals contain the true value, by sample size."""

from collections.abc import Callable

import numpy as np

from agents import GreedyAgent
from agents.lab.trials.interval import CONFIDENCE, mean_interval, ratio_interval
from warehouse_core import WarehouseEnv, record_episode
from warehouse_core.records.episode import DELIVERED

EPISODES, TRIALS, SIZES = 5000, 1000, (20, 50, 100, 300)
LOWEST = 0.9


def episodes() -> np.ndarray:
    """Return the steps of episodes ``[n, 2]``, and whether they delivered."""
    env = WarehouseEnv()
    found = [record_episode(env, GreedyAgent(seed), seed=seed) for seed in range(EPISODES)]
    return np.array([(each.steps, each.outcome == DELIVERED) for each in found], float)


def coverage(sample: Callable[[], tuple[float, float]], truth: float) -> float:
    """Return the share of intervals, as their ends, that contain ``truth``."""
    ends = np.array([sample() for _ in range(TRIALS)])
    return float(np.mean((ends[:, 0] <= truth) & (truth <= ends[:, 1])))


def test_intervals_contain_the_true_value_about_as_often_as_they_say(measured) -> None:
    stream = np.random.default_rng(0)
    found = episodes()
    steps, delivered = found.T
    populations = {
        "steps of an episode": steps,
        "steps of a delivery": steps[delivered == 1],
        "lognormal": stream.lognormal(0, 1, 200_000),
    }

    def means(values: np.ndarray, size: int) -> tuple[float, float]:
        interval = mean_interval(stream.choice(values, size))
        return interval.low, interval.high

    def ratios(size: int) -> tuple[float, float]:
        interval = ratio_interval(*stream.choice(found, size).T)
        return interval.low, interval.high

    shares = {}
    for size in SIZES:
        for name, values in populations.items():
            shares[name, size] = coverage(lambda v=values, n=size: means(v, n), values.mean())
    for size in SIZES[1:]:  # of 20 episodes fewer than 20 are delivered
        shares["steps per delivery", size] = coverage(
            lambda n=size: ratios(n), steps.sum() / delivered.sum()
        )
    for (name, size), share in shares.items():
        measured(
            f"{CONFIDENCE:.0%} intervals that contain the mean: {name}, n = {size}", f"{share:.1%}"
        )
    assert min(shares.values()) >= LOWEST
