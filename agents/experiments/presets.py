"""The chapter's questions as plans, each under a minute on two cores."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Preset:
    """A question of the chapter.

    Attributes:
        question: in words.
        choices: the settings that answer it.
        episodes: of each combination.
    """

    question: str
    choices: dict[str, Any]
    episodes: int


PRESETS = {
    "escape": Preset(
        "Does escaping loops cut delivery time, or does it make the robot wander?",
        {"escape": [True, False], "memory": [2, 5, 10, 20]},
        2000,
    ),
    "battery": Preset(
        "How does battery capacity affect success?",
        {"battery": {"from": 20, "to": 200, "step": 20}, "escape": [True, False]},
        1000,
    ),
    "obstacles": Preset(
        "What do more obstacles do?",
        {"layout": "random", "size": "12x12", "density": {"from": 0.0, "to": 0.4, "step": 0.05}},
        1000,
    ),
    "size": Preset(
        "What does a larger grid do?",
        {"layout": "random", "size": ["7x12", "10x16", "14x22", "20x32"], "battery": [200, 800],
         "max_steps": 800},
        500,
    ),
    "backends": Preset(
        "What does the real robot do with the same policy?",
        {"backend": ["grid", "physics"], "escape": [True, False]},
        200,
    ),
}  # fmt: skip
