"""Planners on POGEMA's benchmark, beside its published results, on the same episodes.

The environment variable ``POGEMA_DATA`` names a copy of
github.com/Cognitive-AI-Systems/pogema-benchmark, for the maps of MovingAI and the puzzles. The
command ``warehouse pogema`` does the same with more planners, episodes and numbers of robots.
"""

import os
from pathlib import Path

import pytest

from agents.lab.commands.pogema.benchmark import Kind, instances
from agents.lab.commands.pogema.results import key_of
from agents.lab.commands.pogema.summary import COLUMNS, groups_of, measures
from agents.lab.commands.pogema.trial import run_instance
from agents.mapf.kernels.buffers import IS_COMPILED

pytestmark = pytest.mark.usefixtures("processor_clock")

SECONDS = 2.0
"""Time for a plan, or for a step."""

ONE_SHOT = {
    ("random", 64, 20): (20, 0.95),
    ("mazes", 64, 20): (19, 0.95),
    ("warehouse", 192, 20): (20, 0.97),
    ("movingai", 256, 8): (7, 1.0),
    ("puzzles", 4, 160): (150, 1.0),
}
"""Episodes to be solved of a set, and costs over LaCAM3's, at most, by set, robots and episodes."""

PLAIN = {("mazes", 64, 20): (18, 1.0)}
"""The same without Numba."""

LIFELONG = {
    ("random", 64, 20): ("windowed:groups=400", 4.3),
    ("mazes", 64, 20): ("windowed:groups=400", 2.8),
    ("warehouse", 192, 3): ("windowed:groups=100,window=30", 5.6),
    ("movingai", 256, 8): ("windowed:groups=200", 5.4),
}
"""Planner that takes about 10 ms a step if compiled, and goals a step to be reached."""


def measures_of(kind: Kind, planner: str, place: tuple[str, int, int], measured) -> dict[str, str]:
    """Run a planner and return its measures by name."""
    collection, robots, episodes = place
    data, results = Path(os.environ["POGEMA_DATA"]), {}
    for one in instances([collection], [kind], [robots], episodes, data):
        results[key_of(one, planner, SECONDS)] = run_instance(one, planner, SECONDS)
    [group] = groups_of(results)
    figures = {
        name: dict(zip(COLUMNS[kind], measures(group, name), strict=True)) for name in group.scores
    }
    words = [
        f"{name}: {', '.join(f'{what} {figure}' for what, figure in each.items() if figure)}"
        for name, each in figures.items()
    ]
    form = "" if IS_COMPILED else ", without Numba"
    measured(
        f"POGEMA's benchmark, {kind}, {collection}, {robots} robots, {len(results)} episodes{form}",
        "; ".join(words),
    )
    return figures[planner]


@pytest.mark.parametrize("place", ONE_SHOT if IS_COMPILED else PLAIN, ids=str)
def test_plans(place: tuple[str, int, int], measured) -> None:
    solved, ratio = (ONE_SHOT if IS_COMPILED else PLAIN)[place]
    found = measures_of(Kind.ONE_SHOT, "anytime", place, measured)
    assert int(found["solved"].split()[0]) >= solved
    assert float(found["times LaCAM3"]) <= ratio


@pytest.mark.parametrize("place", LIFELONG, ids=str)
def test_lifelong_windows(place: tuple[str, int, int], measured) -> None:
    planner, least = LIFELONG[place]
    found = measures_of(Kind.LIFELONG, planner, place, measured)
    assert float(found["goals a step"]) >= least
