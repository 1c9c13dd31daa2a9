import sys
from pathlib import Path

import pytest

from agents.lab.console.values import load_layout
from agents.lab.place import Stations
from agents.lab.trials.task import Task, load_task
from warehouse_core import DEFAULT_LAYOUT, LayoutError
from warehouse_core.world.map_files import save_layout


def test_each_file_is_checked_before_the_command_runs(refused, tmp_path, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    for name in ("run", "demo"):
        line = refused(name, "--save", tmp_path / "a.GIF", "--save", tmp_path / "a.MP4")
        assert line == "saving as .mp4 needs imageio-ffmpeg: pip install 'imageio-ffmpeg>=0.5'"
    assert list(tmp_path.iterdir()) == []


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
    start_pos = None if start is None else (0, 1)
    wanted = Task(load_layout(path), start_pos=start_pos, randomize=randomize)
    task = load_task(path, stations, start)
    assert task == wanted
    assert task.stations is (stations or (KEPT if randomize in (False, "start") else DRAWN))


@pytest.mark.parametrize(
    ("rows", "stations", "start", "message"),
    [
        ("P..", None, None, "there is no dropoff D; add one, or use --stations drawn"),
        ("..D", None, None, "there is no pickup P; add one, or use --stations drawn"),
        ("...", KEPT, None, "there is no pickup P; "),
        ("P.D", DRAWN, None, "it has 1 empty cell; random stations need two"),
        ("P.D#", None, "0,3", "--start row 0, column 3 is wall"),
        ("P.D", None, "1,0", "--start row 1, column 0 is off the grid"),
    ],
)
def test_a_place_without_an_episode_is_an_error(tmp_path, rows, stations, start, message) -> None:
    path = tmp_path / "room.txt"
    path.write_text(f"{rows}\n")
    with pytest.raises(LayoutError, match=message):
        load_task(path, stations, start)


def test_a_map_has_no_stations_and_they_are_drawn(tmp_path: Path) -> None:
    save_layout(DEFAULT_LAYOUT, tmp_path / "room.map")
    assert load_task(tmp_path / "room.map").stations is DRAWN
