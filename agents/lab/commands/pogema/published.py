"""The published results of POGEMA's benchmark, episode by episode.

The file ``published.csv`` has a line for each kind, set, number of robots and algorithm: the mean
seconds of an episode by the clock, and for each episode, in the order of ``MapSet``, the sum of
costs, ``-`` if not all robots were at their goals within the limit of steps, ``?`` if the episode
was not run. For lifelong episodes it has the goals that were reached in 256 steps. RHCR ran the
mazes for 128 steps; its goals there are doubled.

Source: the folders ``raw_data_MAPF`` and ``raw_data_LMAPF`` of
github.com/Cognitive-AI-Systems/pogema-benchmark; Skrynnik et al. (2025), POGEMA: a benchmark
platform for cooperative multi-agent pathfinding, ICLR. LaCAM there is LaCAM3, with up to 60 s.
"""

from __future__ import annotations

import csv
import math
from functools import cache
from pathlib import Path
from typing import NamedTuple

from agents.lab.commands.pogema.benchmark import Kind

FILE = Path(__file__).with_name("published.csv")

STEPS = 256
"""Steps of the lifelong episodes."""

REFERENCE = {Kind.ONE_SHOT: "LaCAM3", Kind.LIFELONG: "RHCR"}
"""Algorithm that ratios are over."""


class Published(NamedTuple):
    """The results of an algorithm with a number of robots.

    Attributes:
        seconds: mean seconds of an episode, by the clock.
        values: sum of costs or goals a step of each episode; infinite costs if not all robots
            were at their goals in time, NaN if the episode was not run.
    """

    seconds: float
    values: tuple[float, ...]


@cache
def published() -> dict[tuple[Kind, str, int], dict[str, Published]]:
    """Return the results by kind, set and number of robots, and then by algorithm."""
    found: dict[tuple[Kind, str, int], dict[str, Published]] = {}
    with FILE.open(encoding="utf-8", newline="") as file:
        for line in csv.DictReader(file):
            kind = Kind(line["kind"])
            unit = STEPS if kind is Kind.LIFELONG else 1
            words = {"-": math.inf, "?": math.nan}
            values = tuple(
                words[word] if word in words else int(word) / unit
                for word in line["episodes"].split()
            )
            name = {"LaCAM": "LaCAM3"}.get(line["algorithm"], line["algorithm"])
            group = found.setdefault((kind, line["set"], int(line["robots"])), {})
            group[name] = Published(float(line["seconds"]), values)
    return found
