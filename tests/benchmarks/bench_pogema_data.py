"""The maps, starts, goals and results of POGEMA's benchmark are the published ones.

The environment variable ``POGEMA_DATA`` names a copy of
github.com/Cognitive-AI-Systems/pogema-benchmark, with its raw data and ``algorithms/experiments``.
"""

import json
import math
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.lab.commands.pogema.benchmark import SETS, Instance, Kind, instances, layouts_of
from agents.lab.commands.pogema.maps import read_maps
from agents.lab.commands.pogema.published import published
from agents.mapf.graph import Graph
from agents.mapf.problem import Problem

RAW = {Kind.ONE_SHOT: "raw_data_MAPF", Kind.LIFELONG: "raw_data_LMAPF"}

FILES = {"LaCAM3": "LaCAM"}
"""Names of files that differ from the algorithms'."""

SCENARIO = re.compile(
    r"^    agents_xy: (.*?)\n    map_name: ([\w-]+)\n    seed: (\d+)\n    targets_xy: (.*?)"
    r"(?=\n  \S|\n\S|\Z)",
    re.MULTILINE | re.DOTALL,
)

Ends = dict[tuple[str, int], tuple[Any, Any]]
"""Starts and goals in the benchmark's scenarios, by map and seed."""


@pytest.fixture(scope="module")
def data() -> Path:
    return Path(os.environ["POGEMA_DATA"])


def scenarios(data: Path, folder: str, kind: Kind) -> Ends:
    name = {Kind.ONE_SHOT: "mapf", Kind.LIFELONG: "lmapf"}[kind]
    text = Path(data, "algorithms", "experiments", folder, f"{folder}-{name}.yaml").read_text()
    return {
        (map_name, int(seed)): (json.loads(starts), json.loads(goals))
        for starts, map_name, seed, goals in SCENARIO.findall(text)
    }


def goals_of(one: Instance, most: int) -> list[list[int]]:
    """Return the first goals of each robot."""
    cells, new_goals = np.array(one.goals), one.new_goals()
    drawn = [cells]
    for _ in range(most - 1):
        cells = new_goals(cells, cells)
        drawn.append(cells)
    return np.array(drawn).T.tolist()


def all_of(name: str, kind: Kind, data: Path) -> Iterator[Instance]:
    yield from instances([name], [kind], SETS[name].sizes[-1:], SETS[name].episodes, data)


@pytest.mark.parametrize("name", [name for name in SETS if SETS[name].draw is not None])
def test_maps_are_the_published_ones(name: str, data: Path, measured) -> None:
    chosen = SETS[name]
    path = Path(data, "algorithms", "experiments", chosen.folder, "maps.yaml")
    text = path.read_text().translate(str.maketrans("!@$", "..."))
    found = dict(re.findall(r'"([\w-]+)": \|-\n((?:  \S+\n?)+)', text))
    drawn = layouts_of(chosen, len(chosen.maps), None)
    equal = [
        list(layout.rows) == found[map_name].split()
        for map_name, layout in zip(chosen.maps, drawn, strict=True)
    ]
    measured(f"maps of POGEMA's benchmark, {name}", f"{sum(equal)} of {len(equal)} equal")
    assert all(equal)


@pytest.mark.parametrize("kind", Kind)
@pytest.mark.parametrize("name", [name for name in SETS if name != "warehouse"])
def test_starts_and_goals_are_the_published_ones(
    name: str, kind: Kind, data: Path, measured
) -> None:
    wanted, equal = scenarios(data, SETS[name].folder, kind), []
    for one in all_of(name, kind, data):
        starts, goals = wanted[one.map_name, one.seed]
        is_equal = one.starts == one.layout.numbers(starts).tolist()
        if kind is Kind.ONE_SHOT:
            is_equal &= one.goals == one.layout.numbers(goals).tolist()
        else:
            mine = goals_of(one, max(map(len, goals)))
            is_equal &= all(
                column[: len(each)] == one.layout.numbers(each).tolist()
                for column, each in zip(mine, goals, strict=True)
            )
        equal.append(is_equal)
    measured(
        f"starts and goals of POGEMA's benchmark, {name}, {kind}",
        f"{sum(equal)} of {len(equal)} episodes equal",
    )
    assert all(equal)


def test_published_costs_fit_starts_and_goals(data: Path, measured) -> None:
    for name, chosen in SETS.items():
        least, lowest = chosen.sizes[0], []
        values = published()[Kind.ONE_SHOT, name, least]["LaCAM3"].values
        for one in instances([name], [Kind.ONE_SHOT], [least], chosen.episodes, data):
            bound = Problem(Graph(one.layout), one.starts, one.goals).lower_bound
            lowest.append(values[one.number] / bound)
        measured(f"LaCAM3's published costs over the bound, {name}, least", f"{min(lowest):.3f}")
        assert min(lowest) >= 1


@pytest.mark.parametrize("kind", Kind)
def test_published_results_are_those_of_the_raw_data(kind: Kind, data: Path, measured) -> None:
    count = 0
    for (each, name, robots), group in published().items():
        chosen = SETS[name]
        for algorithm, result in group.items() if each is kind else ():
            file = f"{FILES.get(algorithm, algorithm)}.json"
            text = Path(data, RAW[kind], chosen.folder, file).read_text()
            found = {}
            for episode in json.loads(text):
                place = episode["env_grid_search"]
                if place["num_agents"] == robots:
                    key = place.get("map_name", chosen.maps[0]), place.get("seed", 0)
                    found[key] = episode["metrics"]
            for number, value in enumerate(result.values):
                seed, map_number = divmod(number, len(chosen.maps))
                raw = found.get((chosen.maps[map_number], seed))
                if raw is None:
                    assert math.isnan(value)
                elif kind is Kind.LIFELONG:
                    assert value == raw["avg_throughput"]
                else:
                    assert value == (raw["SoC"] if raw["CSR"] == 1 else math.inf)
                count += 1
    measured(f"published results of POGEMA's benchmark, {kind}", f"{count:,} equal")


def test_read_maps_reads_all(data: Path) -> None:
    for folder, count in (("04-movingai", 128), ("05-puzzles", 16)):
        assert len(read_maps(Path(data, "raw_data_MAPF", folder, "maps.yaml"))) == count
