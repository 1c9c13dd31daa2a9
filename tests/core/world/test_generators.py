import math
import random
from collections.abc import Callable
from functools import partial
from itertools import combinations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import Layout, LayoutError, random_layout, shelf_layout
from warehouse_core.world.generators import (
    MAX_DENSITY,
    benchmark_warehouse,
    kiva_warehouse,
    maze_layout,
)
from warehouse_core.world.tiles import manhattan_distance

sizes = st.integers(4, 16)
densities = st.floats(0, MAX_DENSITY)
seeds = st.integers(0, 2**64)
counts = st.integers(1, 4)


def assert_usable(layout: Layout) -> None:
    """Check that every open cell is reachable, and that there is a border."""
    everywhere = {layout.open_cell(index) for index in range(len(layout.open_cells))}
    assert layout.reachable_from((1, 1)) == everywhere
    assert set(layout.rows[0]) == set(layout.rows[-1]) == {"#"}
    assert all(row[0] == row[-1] == "#" for row in layout.rows)


@settings(max_examples=30)
@given(sizes, sizes, densities, seeds)
def test_a_random_layout_can_always_be_solved(height, width, density, seed) -> None:
    layout = random_layout(height, width, density, seed)
    assert (layout.height, layout.width) == (height, width)
    assert_usable(layout)
    assert len(layout.pickups) == len(layout.dropoffs) == 1
    assert len(layout.open_cells) >= 4


@pytest.mark.parametrize("density", [0, 0.1, 0.3])
@pytest.mark.parametrize("side", [10, 17])
def test_a_random_layout_has_the_given_density(side: int, density: float) -> None:
    for seed in range(5):
        layout = random_layout(side, side + 3, density, seed)
        inside = (side - 2) * (side + 1)
        assert inside - len(layout.open_cells) == round(density * inside)


def test_a_random_layout_follows_from_its_seed_and_not_from_the_global_random() -> None:
    state = random.getstate()
    layouts = [random_layout(9, 9, 0.3, seed) for seed in (1, 1, 2)]
    assert layouts[0] == layouts[1] != layouts[2]
    assert shelf_layout(seed=1) == shelf_layout(seed=1)
    assert random.getstate() == state


@settings(max_examples=60)
@given(counts, counts, counts, counts, counts, seeds, st.data())
def test_shelves_can_be_served_and_their_stations_are_spread_and_never_neighbours(
    rows: int, columns: int, length: int, depth: int, aisle: int, seed: int, data: st.DataObject
) -> None:
    def most(places: int) -> int:
        return max(1, places // 2)

    bare = shelf_layout(rows, columns, length, depth, aisle)
    limits = {
        "pickups": most(rows * columns * length),
        "dropoffs": most(bare.width - 2),
        "chargers": most(2 * (bare.height - 4)),
    }
    wanted = {name: data.draw(st.integers(name != "chargers", limits[name])) for name in limits}
    layout = shelf_layout(rows, columns, length, depth, aisle, seed, **wanted)
    assert layout == shelf_layout(rows, columns, length, depth, aisle, seed, **wanted)
    assert layout.open_cells.tolist() == bare.open_cells.tolist()
    assert_usable(layout)
    assert layout.height == rows * (depth + aisle) + aisle + 2
    assert layout.width == columns * (length + aisle) + aisle + 2
    inside = (layout.height - 2) * (layout.width - 2)
    assert inside - len(layout.open_cells) == rows * columns * length * depth
    for name, count in wanted.items():
        cells = getattr(layout, name)
        assert len(cells) == count
        assert all(manhattan_distance(*pair) > 1 for pair in combinations(cells, 2)), name
    assert all(layout.rows[row + 1][col] == "#" for row, col in layout.pickups)
    assert max(row for row, _ in layout.pickups) + 1 < layout.height - 1
    assert {row for row, _ in layout.dropoffs} == {layout.height - 2}
    assert {col for _, col in layout.chargers} <= {1, layout.width - 2}
    assert all(1 < row < layout.height - 2 for row, _ in layout.chargers)
    for name, limit in limits.items():
        with pytest.raises(
            LayoutError, match=rf"{name} is {limit + 1}; it must be .\.\.{limit} in"
        ):
            shelf_layout(rows, columns, length, depth, aisle, **{name: limit + 1})


@pytest.mark.parametrize(
    ("sizes", "width", "height", "open_cells"),
    [((10, 20, 10, 2, 1), 161, 63, 5699), ((20, 40, 10, 2, 2), 340, 164, 38756)],
)
def test_the_published_warehouses_have_their_sizes(sizes, width, height, open_cells) -> None:
    layout = benchmark_warehouse(*sizes)
    assert (layout.width, layout.height) == (width, height)
    assert len(layout.open_cells) == len(layout.reachable_from((1, 1))) == open_cells
    assert layout.pickups == layout.dropoffs == ()


def test_the_warehouse_of_papers_has_the_published_size_and_goals_along_shelves() -> None:
    layout, starts, goals = kiva_warehouse()
    assert (layout.height, layout.width, len(starts), len(goals)) == (33, 46, 192, 480)
    assert not set(starts) & set(goals)
    for cell in goals:
        row, col = divmod(int(cell), layout.width)
        assert "#" in (layout.rows[row - 1][col], layout.rows[row + 1][col])
    assert {int(cell) % layout.width for cell in starts} == {1, 2, 4, 5, 40, 41, 43, 44}


SHELF_SIZES = ("shelf_rows", "shelf_columns", "shelf_length", "shelf_depth", "aisle")
BLOCK_SIZES = ("columns", "rows", "length", "depth", "aisle")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: random_layout(3, 9, 0.1, 0), "3 x 9; it must be at least 4 x 4"),
        (lambda: random_layout(9, 3, 0.1, 0), "9 x 3; it must be at least 4 x 4"),
        *(
            (partial(random_layout, 9, 9, density, 0), "density is")
            for density in (-0.01, MAX_DENSITY + 0.01, math.nan)
        ),
        *(
            (partial(shelf_layout, **{name: 0}), f"{name} is 0; it must be at least 1")
            for name in SHELF_SIZES
        ),
        (lambda: shelf_layout(pickups=0), r"pickups is 0; it must be 1\.\."),
        (lambda: shelf_layout(dropoffs=0), r"dropoffs is 0; it must be 1\.\."),
        (lambda: shelf_layout(chargers=-1), r"chargers is -1; it must be 0\.\."),
        *(
            (
                partial(benchmark_warehouse, **dict.fromkeys(BLOCK_SIZES, 2) | {name: 0}),
                f"^{name} is 0; it must be at least 1",
            )
            for name in BLOCK_SIZES
        ),
        (lambda: kiva_warehouse(0, 1, 1), "rows is 0; it must be at least 1"),
        (lambda: kiva_warehouse(1, 10**9, 1), "columns is 1000000000; it must be at most 16000000"),
        # Too large to be built before it is checked.
        (lambda: random_layout(4, 10**12, 0, 0), f"4 x {10**12} cells are more than MAX_CELLS"),
        (lambda: shelf_layout(1, 1, 10**7), f"5 x {10**7 + 4} cells are more than MAX_CELLS"),
        (lambda: benchmark_warehouse(1, 1, 10**7, 1, 2), f"7 x {10**7 + 7} cells are more"),
    ],
)
def test_a_wrong_size_is_named(make: Callable[[], object], message: str) -> None:
    with pytest.raises(LayoutError, match=message):
        make()


def test_exactly_one_path_connects_any_two_cells_of_a_maze() -> None:
    mazes = {maze_layout(7, 11, seed) for seed in range(30)}
    assert len(mazes) == 30
    assert maze_layout(7, 11, 3) == maze_layout(7, 11, 3)
    for maze in mazes:
        assert_usable(maze)
        cells = {maze.open_cell(index) for index in range(len(maze.open_cells))}
        edges = [pair for pair in combinations(cells, 2) if manhattan_distance(*pair) == 1]
        assert len(cells) == 29, "each of 15 rooms, and the cells between them"
        assert len(edges) == len(cells) - 1


@pytest.mark.parametrize("size", [(6, 7), (7, 8), (3, 7)])
def test_a_maze_has_odd_sides(size: tuple[int, int]) -> None:
    with pytest.raises(LayoutError, match=r"a maze must have odd sides of at least 5"):
        maze_layout(*size, seed=1)
