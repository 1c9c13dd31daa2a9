import re
from pathlib import Path

from helpers.command_line import Warehouse
from PIL import Image

from agents.lab.commands.compare_backends import ROWS, comparison_table, first_difference
from agents.run_episode import run_episode
from warehouse_core import replay_episode


def test_the_first_step_that_differs_is_found() -> None:
    grid, physics = (run_episode(backend=backend, seed=12) for backend in ("grid", "physics"))
    other, shorter = replay_episode(grid), run_episode(seed=12, max_steps=10)
    other.actions[3] = "WAIT"
    assert first_difference(grid, grid) is first_difference(grid, physics) is None
    assert first_difference(grid, replay_episode(other)) == 4
    assert first_difference(grid, shorter) == first_difference(shorter, grid) == 11
    header, rows, *_ = comparison_table(grid, physics)
    assert header == ("", "grid", "physics")
    assert [name for name, *_ in rows] == [*ROWS, "first step that differs"]
    assert rows[:2] == [("outcome", "delivered", "delivered"), ("steps", "23", "23")]
    assert float(rows[3][2]) > grid.steps


def test_compare_prints_the_table_and_saves_both_replays(
    warehouse: Warehouse, tmp_path: Path
) -> None:
    target = tmp_path / "both.png"
    result = warehouse("compare", "backends", "--seed", 12, "--max-steps", 2, "--save", target)
    assert result.code == 0
    with Image.open(target) as image:
        assert image.width > 1.5 * image.height
    assert all(word in result.out for word in ("grid", "physics", "joules", "out of time"))


def test_compare_keeps_the_stations_of_a_file(warehouse: Warehouse, tmp_path: Path) -> None:
    (tmp_path / "room.txt").write_text("P..D\n")
    words = (
        "compare",
        "backends",
        "--layout",
        tmp_path / "room.txt",
        "--start",
        "0,1",
        "--seed",
        1,
    )
    out = warehouse(*words, "--no-show").out
    assert out.count("delivered") == 2
    assert re.search(r"steps +\u2502 +6 \u2502 +6 ", out)


def test_slippery_cells_are_for_the_backends_with_bodies(warehouse: Warehouse) -> None:
    words = ("compare", "backends", "--slippery", "1,2", "--seed", 12, "--save", "both.png")
    out = warehouse(*words, "--max-steps", 2).out
    assert "physics:slippery=1-2" in out
    assert "grid:" not in out
    two = ("--backend", "grid", "--backend", "grid")
    assert "given: grid, grid" in warehouse(*words, *two).err
