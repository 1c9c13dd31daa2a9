import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import DEFAULT_LAYOUT, Cell, Layout, random_layout
from warehouse_core.task import sight as sight_module
from warehouse_core.task.sight import Sight


def sight_of(layout: Layout, radius: int) -> Sight:
    sight = Sight(radius)
    sight.use(layout)
    return sight


def window_of(layout: Layout, radius: int, cell: Cell, robot: str) -> list[str]:
    """Return a window, computed cell by cell."""
    lines = []
    for row in range(cell[0] - radius, cell[0] + radius + 1):
        line = ""
        for col in range(cell[1] - radius, cell[1] + radius + 1):
            inside = 0 <= row < layout.height and 0 <= col < layout.width
            tile = layout.rows[row][col] if inside else "#"
            line += robot if (row, col) == cell else tile
        lines.append(line)
    return lines


@settings(max_examples=30)
@given(
    st.integers(1, 5).flatmap(
        lambda width: st.lists(
            st.text(".PD#", min_size=width, max_size=width), min_size=1, max_size=5
        )
    ),
    st.integers(0, 4),
)
def test_a_window_shows_the_cells_around_the_robot(rows: list[str], radius: int) -> None:
    layout = Layout(rows)
    sight = sight_of(layout, radius)
    for row in range(layout.height):
        for col in range(layout.width):
            for loaded, robot in ((False, "R"), (True, "r"), (False, "R")):
                expected = window_of(layout, radius, (row, col), robot)
                assert sight.window((row, col), loaded) == expected


def test_a_window_is_a_new_list() -> None:
    sight = sight_of(DEFAULT_LAYOUT, 1)
    before = sight.window((1, 1), loaded=False)
    before[:] = ["spoilt"]
    assert sight.window((1, 1), loaded=False) == ["###", "#R.", "#.."]


def assert_all_windows(sight: Sight, layout: Layout, radius: int) -> None:
    for index in range(len(layout.open_cells)):
        cell = layout.open_cell(index)
        for loaded, robot in ((False, "R"), (True, "r")):
            assert sight.window(cell, loaded) == window_of(layout, radius, cell, robot)


def test_a_table_replaces_a_full_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sight_module, "MAX_WINDOWS", 4)
    sight = sight_of(DEFAULT_LAYOUT, 2)
    assert_all_windows(sight, DEFAULT_LAYOUT, 2)
    assert sight._columns
    assert len(sight._windows) == 1
    sight.window((1, 1), loaded=False)[:] = ["changed"]
    assert_all_windows(sight, DEFAULT_LAYOUT, 2)


@pytest.mark.parametrize("radius", [0, 1, 3])
def test_a_table_follows_the_layout(radius: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sight_module, "MAX_WINDOWS", 0)
    walls = random_layout(9, 11, 0.3, seed=2)
    moved = walls.with_stations(walls.open_cell(3), walls.open_cell(40))
    turned = Layout(["".join(row) for row in zip(*walls.rows, strict=True)])
    sight = Sight(radius)
    for layout in (walls, moved, walls, turned, random_layout(11, 9, 0.2, seed=5), moved):
        sight.use(layout)
        assert_all_windows(sight, layout, radius)


def test_the_cache_has_a_limit_where_a_table_is_too_large(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sight_module, "MAX_TABLE_BYTES", 100)
    monkeypatch.setattr(sight_module, "MAX_WINDOWS", 2)
    monkeypatch.setattr(sight_module, "MAX_CACHED_CHARACTERS", 4 * 9)
    sight = sight_of(DEFAULT_LAYOUT, 1)
    for _ in range(2):
        for index in range(len(DEFAULT_LAYOUT.open_cells)):
            cell = DEFAULT_LAYOUT.open_cell(index)
            assert sight.window(cell, loaded=False) == window_of(DEFAULT_LAYOUT, 1, cell, "R")
            assert len(sight._windows) <= 4
    assert not sight._columns
