from pathlib import Path

import pytest
from helpers.command_line import Refused, Warehouse

from warehouse_core import Layout, random_layout, shelf_layout
from warehouse_core.world.named_layouts import named_layout


@pytest.fixture(autouse=True)
def files(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Work in a folder with a layout and a map."""
    monkeypatch.chdir(tmp_path)
    Path("room.txt").write_text("#####\n#P.D#\n#...#\n#####\n")
    Path("hall.map").write_text("type octile\nheight 2\nwidth 4\nmap\n@.S.\nT...\n")


@pytest.mark.parametrize(
    ("words", "printed"),
    [
        ("random:height=8,width=9,density=0.3,seed=5", random_layout(8, 9, 0.3, 5)),
        (
            "shelves:rows=3,columns=2,length=5,depth=2,aisle=3,seed=7",
            shelf_layout(3, 2, 5, 2, 3, 7),
        ),
        ("room.txt", Layout(["#####", "#P.D#", "#...#", "#####"])),
        ("maze", named_layout("maze")),
        ("hall.map", Layout(["#...", "#..."])),
    ],
)
def test_layouts_are_printed(warehouse: Warehouse, words: str, printed: Layout) -> None:
    assert warehouse("layout", *words.split()) == (0, f"{printed}\n", "")


@pytest.mark.parametrize(("kind", "option"), [("random", "--save"), ("shelves:", "-o")])
def test_a_layout_goes_to_a_file_and_passes_the_check(warehouse, kind, option) -> None:
    assert warehouse("layout", kind, option, "new.txt") == (0, "saved new.txt\n", "")
    printed = warehouse("layout", kind).out
    assert warehouse("layout", "new.txt").out == printed
    result = warehouse("layout", "new.txt", "--check")
    assert (result.code, "0 of them cut off" in result.out) == (0, True)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("P.D\n", "1 x 3, 3 open cells (0 of them cut off), pickups: 1, dropoffs: 1; an item"),
        ("PCD\nC..\n", "dropoffs: 1, chargers: 2; an item can be delivered"),
        ("P.D#..\n", "5 open cells (2 of them cut off)"),
    ],
)
def test_check_describes_a_layout(warehouse: Warehouse, rows: str, said: str) -> None:
    Path("room.txt").write_text(rows)
    result = warehouse("layout", "room.txt", "--check")
    assert (result.code, result.err) == (0, "")
    assert result.out.startswith("room.txt: ")
    assert said in result.out


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("#..#\n#.x#\n", "row 1, column 2: 'x' is not a tile"),
        ("..D\n", "there is no pickup P"),
        ("..P\n", "there is no dropoff D"),
        ("P#D\n", "row 0, column 2 is dropoff, which cannot be reached"),
        ("P.D#P\n", "row 0, column 4 is pickup, which cannot be reached"),
        ("PCD#C\n", "row 0, column 4 is charger, which cannot be reached"),
    ],
)
def test_check_names_what_is_wrong_with_a_layout(refused: Refused, rows: str, message: str) -> None:
    Path("room.txt").write_text(rows)
    assert refused("layout", "room.txt", "--check").startswith(f"room.txt: {message}")


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        ("random:height=x", 1, "random has 'height=x'; it must be NAME=NUMBER; allowed: height, "),
        ("shelves:length=1,size=2", 1, "shelves has 'size=2'; it must be NAME=NUMBER"),
        ("tower:3", 1, "no layout is called 'tower:3'; allowed: default, corridor, "),
        ("trap maze -o a.txt", 2, "--save needs exactly one layout"),
    ],
)
def test_what_is_no_layout_is_refused(refused, words, code, message) -> None:
    assert refused("layout", *words.split(), code=code).startswith(message)
