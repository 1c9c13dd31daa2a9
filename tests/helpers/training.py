"""Training runs with short exams, in this process and in another one."""

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from agents.lab.commands import train
from agents.lab.training import exams

PROGRAM = """
from agents.__main__ import main
from agents.lab.commands import train
from agents.lab.training import exams
exams.EXAM_SEEDS, train.FINAL_SEEDS = exams.EXAM_SEEDS[:3], train.FINAL_SEEDS[:4]
main()
"""
"""The command line with short exams."""


def shorten_exams(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make exams as short as in ``PROGRAM``."""
    monkeypatch.setattr(exams, "EXAM_SEEDS", exams.EXAM_SEEDS[:3])
    monkeypatch.setattr(train, "FINAL_SEEDS", train.FINAL_SEEDS[:4])


def weights(network: Any) -> list[np.ndarray]:
    """Return all weights and biases of a network."""
    return [array for layer in network.layers for array in layer]


def equal(one: Any, other: Any) -> bool:
    """Return whether two networks are the same to the last bit."""
    pairs = zip(weights(one), weights(other), strict=True)
    return all(np.array_equal(mine, theirs) for mine, theirs in pairs)


def ignore(*_: Any) -> None:
    """Do nothing."""


def check_seeds(make_learner: Callable[..., Any]) -> None:
    """Assert that learners train the same network exactly if they have the same seed."""
    networks = [make_learner().network()]
    for seed in (1, 1, 2):
        learning = make_learner(seed=seed)
        learning.learn(ignore)
        networks.append(learning.network())
    untrained, first, again, other = networks
    assert equal(first, again)
    assert not equal(first, other)
    assert not equal(first, untrained)


def check_resumed(make_learner: Callable[[], Any], stop_at: int) -> tuple[Any, Any]:
    """Assert that a training run that is stopped and resumed ends like a whole one; return both.

    Each learner is created when it is needed, because it seeds its libraries.
    """
    stored: list[bytes] = []
    begun = make_learner()

    def store_and_stop(steps: int, _: float, __: Any) -> None:
        if steps == stop_at:
            stored.append(pickle.dumps(begun.state()))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        begun.learn(store_and_stop)
    calls: tuple[list[Any], list[Any]] = ([], [])
    whole = make_learner()
    whole.learn(lambda *call: calls[0].append(call[:2]))
    resumed = make_learner()
    resumed.restore(pickle.loads(stored[0]))
    resumed.learn(lambda *call: calls[1].append(call[:2]))
    assert len(calls[1]) > 1
    assert repr(calls[1]) == repr(calls[0][-len(calls[1]) :])  # two NaNs are not equal
    assert equal(whole.network(), resumed.network())
    return whole, resumed
