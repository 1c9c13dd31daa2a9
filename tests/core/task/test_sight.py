import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import DEFAULT_LAYOUT, Cell, Layout
from warehouse_core.task import sight as sight_module
from warehouse_core.task.sight import Sight


def sight_of(layout: Layout, radius: int) -> Sight:
    sight = Sight(radius)
    sight.use(layout)
    return sight


def window_of(layout: Layout, radius: int, cell: Cell, robot: str) -> list[str]:
    """Return a window that is computed cell by cell."""
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


@pytest.mark.parametrize("limit", [("MAX_CACHED_WINDOWS", 4), ("MAX_CACHED_CHARACTERS", 4 * 9)])
def test_the_cache_has_a_limit(monkeypatch: pytest.MonkeyPatch, limit: tuple[str, int]) -> None:
    monkeypatch.setattr(sight_module, *limit)
    sight = sight_of(DEFAULT_LAYOUT, 1)
    for rank in range(len(DEFAULT_LAYOUT.open_cells)):
        cell = DEFAULT_LAYOUT.open_cell(rank)
        assert sight.window(cell, loaded=False) == window_of(DEFAULT_LAYOUT, 1, cell, "R")
        assert len(sight._windows) <= 4
