"""Trainings with short exams, here and in a process of its own."""

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
    """Make exams as short as those of ``PROGRAM``."""
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
    """Assert that learners of the same seed train the same network, and of others another."""
    networks = [make_learner().network()]
    for seed in (1, 1, 2):
        learning = make_learner(seed=seed)
        learning.learn(ignore)
        networks.append(learning.network())
    untrained, first, again, other = networks
    assert equal(first, again)
    assert not equal(first, other)
    assert not equal(first, untrained)
