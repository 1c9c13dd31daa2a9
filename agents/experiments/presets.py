"""The chapter's questions as plans, each under a minute on two cores.

The questions are in ``Parameter.question``.
"""

from __future__ import annotations

from agents.experiments.choices import PlanFile

PRESETS = {
    "escape": PlanFile({"escape": [True, False], "memory": [2, 5, 10, 20]}, 2000),
    "battery": PlanFile(
        {"battery": {"from": 20, "to": 200, "step": 20}, "escape": [True, False]}, 1000
    ),
    "obstacles": PlanFile(
        {"layout": "random", "size": "12x12", "density": {"from": 0.0, "to": 0.4, "step": 0.05}},
        1000,
    ),
    "size": PlanFile(
        {
            "layout": "random",
            "size": ["7x12", "10x16", "14x22", "20x32"],
            "battery": [200, 800],
            "max_steps": 800,
        },
        500,
    ),
    "backends": PlanFile({"backend": ["grid", "physics"], "escape": [True, False]}, 200),
}
