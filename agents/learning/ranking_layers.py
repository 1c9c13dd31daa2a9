"""The layers of a network that ranks moves while it learns; needs PyTorch."""

from __future__ import annotations

import math
from typing import Any

import torch

from agents.learning.layers import Layer


def new_layers(inputs: int, width: int) -> torch.nn.Sequential:
    """Return three layers, two of them hidden and so wide, that lead from a view to one score."""
    return torch.nn.Sequential(
        torch.nn.Linear(inputs, width), torch.nn.ReLU(), torch.nn.Linear(width, width),
        torch.nn.ReLU(), torch.nn.Linear(width, 1),
    )  # fmt: skip


def copied_layers(layers: torch.nn.Sequential) -> list[Layer]:
    """Return a copy of the weights and biases for NumPy."""
    return [_copy(part) for part in layers if isinstance(part, torch.nn.Linear)]


def improve(optimiser: torch.optim.Optimizer, scores: torch.Tensor, wrong: torch.Tensor) -> None:
    """Make it likelier that moves drawn by their scores are any of the right ones.

    Args:
        optimiser: optimiser of the layers that the scores come from.
        scores: ``[B, M]``, negative infinity for moves that cannot be made.
        wrong: ``[B, M]``, true for moves that are not right.
    """
    gain = scores.masked_fill(wrong, -math.inf).logsumexp(1) - scores.logsumexp(1)
    optimiser.zero_grad()
    (-gain.mean()).backward()
    optimiser.step()


def _copy(part: Any) -> Layer:
    return part.weight.detach().numpy().copy(), part.bias.detach().numpy().copy()
