"""The command ``warehouse compare search``."""

from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.command_line import Warehouse
from PIL import Image

from agents.lab.commands.compare_search import algorithm, choose_ends
from warehouse_core import DEFAULT_LAYOUT, Layout, LayoutError

Search = Callable[..., str]
SPLIT = "#######\n#..#..#\n#..#.P#\n#######\n"


def rows(out: str) -> list[list[str]]:
    """Return the cells of the rows of the printed table."""
    lines = [line for line in out.splitlines() if line.startswith("\u2502")]
    return [[cell.strip() for cell in line.strip("\u2502").split("\u2502")] for line in lines]


@pytest.fixture
def search(warehouse: Warehouse) -> Search:
    """Return a function that runs the command without a window and returns its output."""

    def run(*words: object) -> str:
        code, out, err = warehouse("compare", "search", "--no-show", *words)
        assert (code, err) == (0, "")
        return out

    return run


def test_the_table_has_a_row_for_each_weight(search: Search) -> None:
    printed = rows(search("--start", "5,1", "--goal", "1,10"))
    assert [row[:2] for row in printed] == [
        ["uniform-cost", "0"],
        ["A*", "1"],
        ["weighted A*", "5"],
        ["greedy best-first", "inf"],
    ]
    assert printed[0][2] == printed[1][2] == "15"
    assert int(printed[1][3]) < int(printed[0][3])
    assert all(int(row[4]) > int(row[3]) >= int(row[5]) > 0 for row in printed)
    assert algorithm(0.5) == "weighted A*"


def test_the_default_start_is_far_from_the_goal(search: Search) -> None:
    assert "Search from (4, 9) to (4, 2)" in search("--layout", "trap")
    assert "Search from (1, 10) to (5, 1)" in search("--goal", "5,1")


def test_random_ends_are_open_and_different() -> None:
    for seed in range(20):
        for start, goal in ((None, None), ((1, 1), None), (None, (1, 1))):
            ends = choose_ends(DEFAULT_LAYOUT, start, goal, seed)
            assert ends[0] != ends[1]
            assert all(DEFAULT_LAYOUT.is_open(cell) for cell in ends)
            assert start in (None, ends[0])
            assert goal in (None, ends[1])


def test_the_start_is_not_a_goal_with_walls_around_it() -> None:
    layout = Layout([".#.#."])
    assert choose_ends(layout, None, (0, 0), None) == ((0, 4), (0, 0))
    assert choose_ends(layout, None, (0, 4), None) == ((0, 0), (0, 4))
    assert choose_ends(Layout(["P"]), None, None, None) == ((0, 0), (0, 0))


def test_a_layout_without_a_pickup_asks_for_a_goal() -> None:
    with pytest.raises(LayoutError, match="no pickup to go to; give --goal ROW,COL or --seed N"):
        choose_ends(Layout(["..."]), None, None, None)


def test_an_unreachable_goal_is_reported_and_shown(search: Search, tmp_path: Path) -> None:
    Path("split.txt").write_text(SPLIT)
    # The true distance shows at the start that there is no path.
    for name, expanded in (("manhattan", 4), ("true", 1)):
        words = f"--layout split.txt --start 1,1 --heuristic {name} --weights 1,inf"
        out = search(*words.split(), "--save", "path.png")
        assert [row[2:4] for row in rows(out)] == [["none", str(expanded)]] * 2
        assert "no path exists from (1, 1) to (2, 5)\n" in out
        with Image.open("path.png") as image:
            assert len(image.convert("RGB").getcolors(1 << 20)) > 10
