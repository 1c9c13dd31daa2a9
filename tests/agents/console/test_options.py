from pathlib import Path

import pytest
import typer
from helpers.command_line import command, refusal

from agents.console.options import BatteryOption, SaveOption, SaveReplayOption, load_layout
from warehouse_core import DEFAULT_LAYOUT

app = typer.Typer(add_completion=False)


@app.command()
def charge(battery: BatteryOption = 5) -> None:
    print(battery)


@app.command()
def keep(*, save: SaveOption) -> None:
    print(*save)


@app.command()
def film(*, save: SaveReplayOption) -> None:
    print(*save)


def test_wrong_usage_is_one_line_and_ends_with_2(capsys: pytest.CaptureFixture[str]) -> None:
    assert command(capsys, "charge", "--battery", "7", app=app) == (0, "7\n", "")
    for words in (["--battery", "0"], ["--battery", "x"], ["--battery"], ["--fast"], ["more"]):
        assert refusal(capsys, "charge", *words, code=2, app=app), words


def test_every_format_and_the_record_may_be_saved(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    suffixes = ("gif", "mp4", "html", "svg", "png", "npz", "NPZ")
    targets = [str(tmp_path / f"film.{suffix}") for suffix in suffixes]
    words = [word for target in targets for word in ("--save", target)]
    assert command(capsys, "keep", *words, app=app).out.split() == targets
    assert command(capsys, "keep", app=app).out == "\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "target", "message"),
    [
        ("keep", "film.txt", "film.txt: cannot save as .txt; allowed: .gif, "),
        ("film", "film.npz", "film.npz: cannot save as .npz; allowed: .gif, "),
        ("keep", "film", "film: cannot save as a file without a suffix"),
        ("keep", "missing/film.gif", "the folder missing does not exist"),
        ("keep", "folder.gif", "folder.gif is a folder, not a file"),
    ],
)
def test_a_file_that_cannot_be_saved_is_an_error(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    name: str,
    target: str,
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.gif").mkdir()
    words = (name, "--save", "good.gif", "--save", target)
    assert refusal(capsys, *words, app=app).startswith(message)


def test_a_layout_is_the_built_in_one_unless_there_is_a_file(tmp_path: Path) -> None:
    assert load_layout(None) is DEFAULT_LAYOUT
    (tmp_path / "room.txt").write_text("P.D\n")
    assert load_layout(tmp_path / "room.txt").rows == ("P.D",)
