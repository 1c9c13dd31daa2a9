import sys
from pathlib import Path

import pytest
import typer
from helpers.command_line import command, refusal

from agents.lab.console.options import (
    BatteryOption,
    SaveOption,
    SaveReplayOption,
    greedy_with,
    load_layout,
    load_place,
)
from agents.lab.place import Place, Stations
from warehouse_core import DEFAULT_LAYOUT, LayoutError
from warehouse_core.world.map_files import save_layout

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


def test_an_mp4_without_its_library_is_refused_before_the_command_runs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    for name in ("keep", "film"):
        words = ["--save", tmp_path / "film.gif", "--save", tmp_path / "film.MP4"]
        line = refusal(capsys, name, *words, app=app)
        assert line == "saving as .mp4 needs imageio-ffmpeg: pip install 'imageio-ffmpeg>=0.5'"
        assert command(capsys, name, *words[:2], app=app).code == 0


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


DRAWN, KEPT = Stations.DRAWN, Stations.KEPT


@pytest.mark.parametrize(
    ("rows", "stations", "start", "randomize"),
    [
        (None, None, None, True),
        (None, KEPT, None, "start"),
        ("P.D..", None, None, "start"),
        ("P.D..", None, "0,1", False),
        ("P.D..", DRAWN, None, True),
        ("P.D..", DRAWN, "0,1", "stations"),
        ("....", None, None, True),
    ],
)
def test_stations_of_a_file_are_kept_unless_it_has_none(
    tmp_path: Path,
    rows: str | None,
    stations: Stations | None,
    start: str | None,
    randomize: object,
) -> None:
    path = None if rows is None else tmp_path / "room.txt"
    if path is not None:
        path.write_text(f"{rows}\n")
    place = load_place(path, stations, start)
    assert place == Place(load_layout(path), None if start is None else (0, 1), randomize)
    assert place.stations is (stations or (KEPT if randomize in (False, "start") else DRAWN))


@pytest.mark.parametrize(
    ("rows", "stations", "start", "message"),
    [
        ("P..", None, None, "there is no dropoff D; add one, or use --stations drawn"),
        ("..D", None, None, "there is no pickup P; add one, or use --stations drawn"),
        ("...", KEPT, None, "there is no pickup P; "),
        ("P.D", DRAWN, None, "allowed: two or more, and there are 1"),
        ("P.D#", None, "0,3", "--start row 0, column 3 is wall"),
        ("P.D", None, "1,0", "--start row 1, column 0 is off the grid"),
    ],
)
def test_a_place_without_an_episode_is_an_error(
    tmp_path: Path, rows: str, stations: Stations | None, start: str | None, message: str
) -> None:
    path = tmp_path / "room.txt"
    path.write_text(f"{rows}\n")
    with pytest.raises(LayoutError, match=message):
        load_place(path, stations, start)


def test_a_map_has_no_stations_and_they_are_drawn(tmp_path: Path) -> None:
    save_layout(DEFAULT_LAYOUT, tmp_path / "room.map")
    assert load_place(tmp_path / "room.map", None, None).stations is DRAWN


@pytest.mark.parametrize(
    ("agent", "memory", "escape", "name"),
    [
        ("astar", None, None, "astar"),
        ("greedy", None, True, "greedy"),
        ("greedy", 5, False, "greedy:memory=5,escape_steps=0"),
        ("greedy:memory=3", None, False, "greedy:memory=3,escape_steps=0"),
    ],
)
def test_memory_and_escape_are_arguments_of_the_greedy_agent(
    agent: str, memory: int | None, escape: bool | None, name: str
) -> None:
    assert greedy_with(agent, memory, escape) == name


@pytest.mark.parametrize(("memory", "escape"), [(5, None), (None, True), (None, False)])
def test_other_agents_have_no_memory_and_no_escape(memory: int | None, escape: bool | None) -> None:
    with pytest.raises(typer.BadParameter, match="are of agent greedy, not of 'astar'"):
        greedy_with("astar", memory, escape)
