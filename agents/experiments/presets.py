"""The chapter's questions as plans, each under a minute on two cores."""

from __future__ import annotations

from typing import Any, NamedTuple


class Preset(NamedTuple):
    """A plan that answers a question of the chapter, see ``Parameter.question``.

    Attributes:
        choices: the values of each parameter.
        episodes: of each combination.
    """

    choices: dict[str, Any]
    episodes: int


PRESETS = {
    "escape": Preset({"escape": [True, False], "memory": [2, 5, 10, 20]}, 2000),
    "battery": Preset(
        {"battery": {"from": 20, "to": 200, "step": 20}, "escape": [True, False]}, 1000
    ),
    "obstacles": Preset(
        {"layout": "random", "size": "12x12", "density": {"from": 0.0, "to": 0.4, "step": 0.05}},
        1000,
    ),
    "size": Preset(
        {
            "layout": "random",
            "size": ["7x12", "10x16", "14x22", "20x32"],
            "battery": [200, 800],
            "max_steps": 800,
        },
        500,
    ),
    "backends": Preset({"backend": ["grid", "physics"], "escape": [True, False]}, 200),
}
