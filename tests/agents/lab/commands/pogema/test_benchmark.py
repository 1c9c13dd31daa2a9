"""The maps, starts, goals and published results of POGEMA's benchmark."""

from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from agents.errors import PlanError
from agents.lab.commands.pogema.benchmark import SETS, Instance, Kind, draw_ends, instances
from agents.lab.commands.pogema.maps import read_maps
from agents.lab.commands.pogema.published import published
from agents.mapf.graph import Graph
from agents.mapf.problem import Problem
from warehouse_core import Layout, LayoutError
from warehouse_core.world.generators import kiva_warehouse

MAPS = 32

PUBLISHED_MAPS = {
    "random": "00d4426093fb7c9ca503ea1115b257c71297cee220a7acbf69d0f33bec0596b4",
    "mazes": "0863605c229c6babfc09435ab156b545926a9424abae3d40f80aca68b7462691",
    "warehouse": "0d4407bf968989567ce1596d819eb31d5f5b141b99cc6efe3bf4c5e67e60341c",
}
"""Digests of the first ``MAPS`` maps in ``maps.yaml``; the warehouse with its starts and goals.

``tests/benchmarks/bench_pogema_data.py`` compares all of them with a copy of the benchmark.
"""

PUBLISHED_ENDS = {
    "random": (
        0,
        [(9, 4), (6, 2), (1, 3), (19, 13)],
        [(19, 1), (15, 5), (2, 6), (18, 12)],
        [(19, 1), (7, 3), (13, 14), (19, 6), (3, 18), (6, 2)],
    ),
    "mazes": (
        3,
        [(4, 9), (6, 3), (8, 1), (13, 7)],
        [(10, 16), (16, 8), (5, 18), (8, 5)],
        [(10, 16), (5, 8), (11, 9), (16, 11), (2, 17), (4, 14)],
    ),
}
"""Starts and goals of the first robots, and the goals of robot 0, in the benchmark's scenarios."""

PUZZLES = '"puzzle-00": |-\n  ....#\n  ..#.#\n  #.#..\n"puzzle-01": |-\n  ##...\n  ....#\n'
"""The form of the benchmark's file."""


def some(name: str, kind: Kind, robots: int, number: int = 0) -> Instance:
    return list(instances([name], [kind], [robots], number + 1, None))[number]


def write_maps(text: str, folder: str = "05-puzzles") -> Path:
    path = Path("raw_data_MAPF", folder, "maps.yaml")
    path.parent.mkdir(parents=True)
    path.write_text(text)
    return path


def digest(text: str) -> str:
    return sha256(text.encode()).hexdigest()


@pytest.mark.parametrize("name", ["random", "mazes"])
def test_drawn_maps_equal_the_published_ones_cell_for_cell(name: str) -> None:
    draw = SETS[name].draw
    assert draw is not None
    maps = ["\n".join(draw(number).rows) for number in range(MAPS)]
    assert digest("\n\n".join(maps)) == PUBLISHED_MAPS[name]


def test_the_warehouse_of_papers_equals_the_published_one_with_its_starts_and_goals() -> None:
    layout, starts, goals = kiva_warehouse()
    tiles = np.array([list(row) for row in layout.rows]).ravel()
    tiles[tiles == "."] = "!"
    tiles[starts], tiles[goals] = "@", "$"
    rows = tiles.reshape(layout.height, layout.width)
    assert digest("\n".join("".join(row) for row in rows)) == PUBLISHED_MAPS["warehouse"]


@pytest.mark.parametrize("name", PUBLISHED_ENDS)
def test_starts_and_all_goals_are_the_published_ones(name: str) -> None:
    number, starts, goals, later = PUBLISHED_ENDS[name]
    for kind in Kind:
        found = some(name, kind, 64, number)
        assert found.layout.cells(found.starts)[:4] == starts
        assert found.layout.cells(found.goals)[:4] == goals
    new_goals, cells = found.new_goals(), np.array(found.goals)
    drawn = [cells[0]]
    while len(drawn) < len(later):
        cells = new_goals(cells, cells)
        drawn.append(cells[0])
    assert found.layout.cells(np.array(drawn)) == later


def test_a_goal_is_drawn_for_the_robots_that_are_at_theirs_alone() -> None:
    one = some("random", Kind.LIFELONG, 8)
    goals = np.array(one.goals)
    cells = np.where(np.arange(8) == 5, goals, one.starts)
    changed = one.new_goals()(cells, goals) != goals
    assert changed.nonzero()[0].tolist() == [5]


def test_published_costs_in_the_warehouse_fit_its_starts_and_goals() -> None:
    costs = published()[Kind.ONE_SHOT, "warehouse", 32]["LaCAM3"].values
    for one, cost in zip(instances(["warehouse"], [Kind.ONE_SHOT], [32], 8, None), costs[:8],
                         strict=True):  # fmt: skip
        bound = Problem(Graph(one.layout), one.starts, one.goals).lower_bound
        assert bound <= cost < 1.03 * bound


def test_a_goal_comes_twice_in_the_warehouse_alone() -> None:
    for name, robots, twice in (("warehouse", 192, True), ("random", 64, False)):
        one = some(name, Kind.LIFELONG, robots)
        cells, new_goals, same = np.array(one.goals), one.new_goals(), 0
        for _ in range(40):
            after = new_goals(cells, cells)
            same += int((after == cells).sum())
            cells = after
        assert (same > 0) is twice
        if twice:
            assert set(cells.tolist()) <= set(kiva_warehouse()[2].tolist())


def test_no_robot_starts_where_it_has_no_way_to_go() -> None:
    for seed in range(20):
        starts, goals = draw_ends(Layout([".#..", "##.."]), seed, 2)
        assert sorted(starts + goals) == [2, 3, 6, 7]


def test_each_set_has_published_results_for_all_its_episodes() -> None:
    for name, chosen in SETS.items():
        for kind in Kind:
            for robots in chosen.sizes:
                group = published()[kind, name, robots]
                assert {len(each.values) for each in group.values()} == {chosen.episodes}
    lacam = published()[Kind.ONE_SHOT, "mazes", 64]["LaCAM3"].values[:20]
    assert int(np.isfinite(lacam).sum()) == 17
    assert published()[Kind.LIFELONG, "random", 8]["RHCR"].values[0] == 0.5390625


def test_maps_are_read_from_a_copy_of_the_benchmark() -> None:
    rows = "....\n  .#..\n  ...."
    path = write_maps("".join(f'"puzzle-{number:02}": |-\n  {rows}\n' for number in range(16)))
    assert list(read_maps(path)["puzzle-00"].rows) == ["....", ".#..", "...."]
    found = list(instances(["puzzles"], [Kind.ONE_SHOT], [2], 18, Path()))
    assert [(one.map_name, one.seed) for one in found[15:]] == [
        ("puzzle-15", 0), ("puzzle-00", 1), ("puzzle-01", 1)
    ]  # fmt: skip


def test_maps_that_a_copy_lacks_are_named() -> None:
    with pytest.raises(PlanError, match="give its folder as --data, after: git clone https://"):
        list(instances(["puzzles"], [Kind.ONE_SHOT], [2], 1, None))
    path = write_maps(PUZZLES)
    with pytest.raises(PlanError, match=r"maps\.yaml: it has no map puzzle-02"):
        list(instances(["puzzles"], [Kind.ONE_SHOT], [2], 3, Path()))
    path.write_text(PUZZLES.replace("##...", "##x.."))
    with pytest.raises(LayoutError, match=r"maps\.yaml: map puzzle-01: .*'x'"):
        read_maps(path)
    path.write_text("maps: none\n")
    with pytest.raises(LayoutError, match="it has no maps as POGEMA's benchmark writes them"):
        read_maps(path)
