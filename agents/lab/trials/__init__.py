"""How well agents do: scores, intervals and their wording."""

from agents.lab.trials.interval import Interval, mean_interval, share_interval
from agents.lab.trials.scores import MEASURES, Run, Scores, Task, evaluate

__all__ = [
    "MEASURES",
    "Interval",
    "Run",
    "Scores",
    "Task",
    "evaluate",
    "mean_interval",
    "share_interval",
]
