"""The command ``warehouse compare-agents``."""

from pathlib import Path

import pytest
from helpers.command_line import command, refusal
from PIL import Image

from agents.evaluation.scores import CONTENDERS

SMALL = ("compare-agents", "-n", 3, "--backend", "grid", "--max-steps", 40)


def test_it_prints_a_row_for_each_agent(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "150")
    code, out, err = command(capsys, *SMALL, "--seed", 5)
    assert (code, err) == (0, "")
    assert "3 episodes each, backend grid, seeds from 5" in out
    assert all(name in out for name in CONTENDERS)
    assert "none" not in out.split("A*")[1]


def test_the_same_seeds_give_the_same_table(capsys: pytest.CaptureFixture[str]) -> None:
    tables = [command(capsys, *SMALL, "--seed", seed).out for seed in (1, 1, 2)]
    rows = [table.partition("\n")[2] for table in tables]  # the title has the seed
    assert rows[0] == rows[1] != rows[2]


@pytest.mark.parametrize("name", ["figure.png", "figure.svg"])
def test_the_figure_is_saved(capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    assert command(capsys, *SMALL, "--save", path).out.endswith(f"saved {path}\n")
    if path.suffix == ".png":
        with Image.open(path) as picture:
            assert picture.width > 900
    else:
        assert "<svg" in path.read_text(encoding="utf-8")


def test_what_cannot_be_saved_is_refused_before_anything_runs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    line = refusal(capsys, *SMALL, "--save", tmp_path / "figure.gif")
    assert line == f"{tmp_path / 'figure.gif'}: cannot save as .gif; allowed: .svg, .png"
    assert "nowhere" in refusal(capsys, *SMALL, "--save", tmp_path / "nowhere" / "figure.png")


def test_wrong_numbers_are_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--episodes" in refusal(capsys, "compare-agents", "-n", 0, code=2)
    assert "antigravity" in refusal(capsys, "compare-agents", "--backend", "antigravity")
