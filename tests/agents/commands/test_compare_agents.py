"""The command ``warehouse compare-agents``."""

from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import command, refusal
from PIL import Image

from agents.commands.compare_agents import contenders
from agents.search.agents import ExploringAgent
from warehouse_core import DEFAULT_LAYOUT

SMALL = ("compare-agents", "-n", 2, "--backend", "grid", "--max-steps", 40)


def test_it_prints_a_row_for_each_agent(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "150")
    code, out, err = command(capsys, *SMALL, "--seed", 5)
    assert (code, err) == (0, "")
    assert "2 episodes each, backend grid, seeds from 5" in out
    assert all(name in out for name in contenders(DEFAULT_LAYOUT))
    assert "none" not in out.split("A*")[1]


def test_the_same_seeds_give_the_same_table(capsys: pytest.CaptureFixture[str]) -> None:
    tables = [command(capsys, *SMALL, "--seed", seed).out for seed in (1, 1, 2)]
    rows = [table.partition("\n")[2] for table in tables]  # the title has the seed
    assert rows[0] == rows[1] != rows[2]


def test_the_agents_are_what_their_names_say() -> None:
    made: dict[str, Any] = {name: make(7) for name, make in contenders(DEFAULT_LAYOUT).items()}
    assert made["greedy"].seed == made["greedy without escape"].seed == 7
    assert made["greedy"].escape_steps > 0
    assert made["greedy without escape"].escape_steps == 0
    assert isinstance(made["exploring"], ExploringAgent)
    assert (made["uniform-cost"].algorithm, made["A*"].algorithm) == ("ucs", "astar")


@pytest.mark.parametrize("name", ["figure.png", "figure.svg"])
def test_the_figure_is_saved(capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    assert command(capsys, *SMALL, "--save", path).out.endswith(f"saved {path}\n")
    if path.suffix == ".png":
        with Image.open(path) as picture:
            assert picture.width > 900
    else:
        assert "<svg" in path.read_text(encoding="utf-8")


def test_a_file_that_cannot_be_written_is_an_error_before_the_episodes(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    line = refusal(capsys, *SMALL, "--save", tmp_path / "figure.gif")
    assert line == f"{tmp_path / 'figure.gif'}: cannot save as .gif; allowed: .svg, .png"
    assert "nowhere" in refusal(capsys, *SMALL, "--save", tmp_path / "nowhere" / "figure.png")


def test_wrong_numbers_are_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--episodes" in refusal(capsys, "compare-agents", "-n", 0, code=2)
    assert "antigravity" in refusal(capsys, "compare-agents", "--backend", "antigravity")
