from dataclasses import replace

import numpy as np
import pytest

from agents.lab.trials.random_layouts import MAX_POOL, RandomLayouts, VariedLayouts
from agents.lab.trials.task import Task
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Layout, LayoutError
from warehouse_core.world.tiles import WALL

SMALL = RandomLayouts(5, 6, 0.1, 0.3, count=20)


def walls(layouts: RandomLayouts, seed: int) -> int:
    return sum(row[1:-1].count(WALL) for row in layouts.layout(seed).rows[1:-1])


def test_a_seed_always_gives_the_same_layout_and_other_seeds_give_others() -> None:
    layouts = RandomLayouts()
    assert layouts.layout(3) == RandomLayouts().layout(3)
    assert len({layouts.layout(seed) for seed in range(100)}) == 100
    assert (layouts.layout(3).height, layouts.layout(3).width) == (7, 12)


def test_densities_are_spread_over_their_range() -> None:
    counts = [walls(RandomLayouts(12, 12, 0.1, 0.4), seed) for seed in range(200)]
    assert (min(counts), max(counts)) == (10, 40)
    assert 80 < sum(count < 25 for count in counts) < 120
    assert {walls(RandomLayouts(12, 12, 0.2, 0.2), seed) for seed in range(20)} == {20}


def test_a_pool_shares_no_layout_with_another_pool_or_an_episode() -> None:
    pools = [replace(RandomLayouts(count=300), pool_seed=seed).pool() for seed in (1, 2)]
    episodes = [RandomLayouts().layout(seed) for seed in range(300)]
    assert len({*pools[0], *pools[1], *episodes}) == 900
    assert pools[0] == RandomLayouts(count=300, pool_seed=1).pool()
    assert RandomLayouts(count=300).without(range(300)).pool() == pools[0]


def test_the_pool_leaves_out_the_layouts_of_episodes() -> None:
    episodes = range(2_000_000, 2_001_000)
    all_of_77 = RandomLayouts(pool_seed=77)
    some = all_of_77.without(episodes)
    assert len(some.left_out) == 1
    assert len(some.pool()) == 1023
    [left_out] = set(all_of_77.pool()) - set(some.pool())
    bare = {all_of_77.layout(seed).with_stations(None, None) for seed in episodes}
    assert left_out.with_stations(None, None) in bare
    tiny = RandomLayouts(4, 4, 0.1, 0.2, count=50)
    with pytest.raises(LayoutError, match=r"of 4 x 4 .*: each of the 50 training layouts is also"):
        tiny.without(range(100))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"height": 3}, r"the size is 3 x 6; it must be at least 4 x 4"),
        ({"width": 10**9}, r"cells are more than"),
        ({"highest": 0.5}, r"density is 0\.5; it must be at least 0 and at most 0\.4"),
        ({"lowest": -0.1}, r"density is -0\.1"),
        ({"lowest": float("nan")}, r"density is nan"),
        (
            {"lowest": 0.3, "highest": 0.2},
            r"density is from 0\.3 to 0\.2; the first must not be higher",
        ),
        ({"count": 0}, rf"the number of layouts is 0; allowed: 1\.\.{MAX_POOL}"),
    ],
)
def test_values_that_are_not_allowed_raise(changes: dict[str, float], message: str) -> None:
    with pytest.raises(LayoutError, match=message):
        replace(SMALL, **changes)  # type: ignore[arg-type]


def test_each_episode_of_a_task_is_in_the_layout_of_its_seed() -> None:
    task = Task(SMALL, max_steps=1)
    for seed in (4, 9):
        assert task.make_env(seed).layout == SMALL.layout(seed)
    needed = [row.needed for row in task.evaluate(GreedyAgent, range(30)).rows]
    assert len(set(needed)) > 5


def test_rows_for_training_are_in_layouts_of_the_pool() -> None:
    batch = Task(SMALL).make_batch(60)
    batch.reset(seed=1)
    pool = {layout.with_stations(None, None) for layout in SMALL.pool()}
    drawn = {batch.row(row)[0].with_stations(None, None) for row in range(60)}
    assert drawn <= pool
    assert len(drawn) > 10


def test_varied_layouts_have_many_sizes_and_two_in_five_are_mazes() -> None:
    varied = VariedLayouts(15, 17, count=200)
    made = varied.pool()
    assert {(layout.height, layout.width) for layout in made} == {(15, 17)}
    free = [np.array([layout.cell(number) for number in layout.open_cells]) for layout in made]
    assert len({tuple(cells.max(axis=0)) for cells in free}) > 80
    # A tree has one edge fewer than it has cells.
    trees = sum(_ways(layout) == len(layout.open_cells) - 1 for layout in made)
    assert 70 < trees < 100
    assert varied.name == "random layouts and mazes of up to 15 x 17"
    for layout in made:
        assert len(layout.reachable_from(layout.open_cell(0))) == len(layout.open_cells)


def _ways(layout: Layout) -> int:
    is_open = np.array([list(row) for row in layout.rows]) != WALL
    return int((is_open[1:] & is_open[:-1]).sum() + (is_open[:, 1:] & is_open[:, :-1]).sum())
