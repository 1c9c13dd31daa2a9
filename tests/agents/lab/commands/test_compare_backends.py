import re
from pathlib import Path

import pytest
from helpers.command_line import Warehouse
from PIL import Image

from agents.lab.commands.compare_backends import ROWS, comparison_table, first_difference
from agents.run_episode import run_episode
from warehouse_core import Episode, replay_episode


@pytest.fixture(scope="module")
def grid() -> Episode:
    return run_episode(seed=12)


def changed(episode: Episode, step: int, action: str) -> Episode:
    """Return the episode, run again with another action at one step, counted from 1."""
    again = replay_episode(episode)
    again.actions[step - 1] = action
    return replay_episode(again)


def test_nominal_physics_does_what_the_grid_does(grid: Episode) -> None:
    physics = run_episode(backend="physics", seed=12)
    assert first_difference(grid, physics) is None
    assert physics.settings.backend == "physics"
    assert physics.seconds > grid.steps


def test_the_first_step_that_differs_is_found(grid: Episode) -> None:
    assert first_difference(grid, grid) is None
    assert first_difference(grid, changed(grid, 4, "WAIT")) == 4


def test_a_shorter_episode_differs_where_it_ends(grid: Episode) -> None:
    shorter = run_episode(seed=12, max_steps=10)
    assert first_difference(grid, shorter) == first_difference(shorter, grid) == 11


def test_the_table_has_both_backends_and_every_row(grid: Episode) -> None:
    table = comparison_table(grid, grid)
    assert table.header == ("", "grid", "grid")
    assert len(table.rows) == len(ROWS) + 1
    assert [cell for _, cell, _ in table.rows[:3]] == ["delivered", "23", "12.70"]


def test_compare_prints_the_table_and_saves_both_replays(
    warehouse: Warehouse, tmp_path: Path
) -> None:
    target = tmp_path / "both.png"
    result = warehouse("compare", "--seed", 12, "--max-steps", 2, "--save", target)
    assert result.code == 0
    with Image.open(target) as image:
        assert image.width > 1.5 * image.height
    assert all(word in result.out for word in ("grid", "physics", "joules", "out of time"))


def test_compare_keeps_the_stations_of_a_file(warehouse: Warehouse, tmp_path: Path) -> None:
    (tmp_path / "room.txt").write_text("P..D\n")
    words = ("compare", "--layout", tmp_path / "room.txt", "--start", "0,1", "--seed", 1)
    out = warehouse(*words, "--no-show").out
    assert out.count("delivered") == 2
    assert re.search(r"steps +\u2502 +6 \u2502 +6 ", out)
