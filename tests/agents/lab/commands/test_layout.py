from pathlib import Path

import pytest
from helpers.command_line import command, refusal

from warehouse_core import DEFAULT_LAYOUT, Episode, Layout, random_layout, shelf_layout
from warehouse_core.world.generators import benchmark_warehouse
from warehouse_core.world.map_files import load_map
from warehouse_core.world.named_layouts import NAMES, named_layout


@pytest.fixture(autouse=True)
def files(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Work in a folder with a layout and a map."""
    monkeypatch.chdir(tmp_path)
    Path("room.txt").write_text("#####\n#P.D#\n#...#\n#####\n")
    Path("hall.map").write_text("type octile\nheight 2\nwidth 4\nmap\n@.S.\nT...\n")


@pytest.mark.parametrize(
    ("words", "printed"),
    [
        (
            "generate --height 8 --width 9 --density 0.3 --seed 5",
            random_layout(8, 9, 0.3, 5),
        ),
        (
            "shelves --rows 3 --columns 2 --length 5 --depth 2 --aisle 3 --seed 7",
            shelf_layout(3, 2, 5, 2, 3, 7),
        ),
        (
            "shelves --aisle 2 --pickups 4 --dropoffs 3 --chargers 2 --seed 7",
            shelf_layout(aisle=2, seed=7, pickups=4, dropoffs=3, chargers=2),
        ),
        ("warehouse 3-4-5-2-1", benchmark_warehouse(3, 4, 5, 2, 1)),
        ("print room.txt", Layout(["#####", "#P.D#", "#...#", "#####"])),
        ("print maze", named_layout("maze")),
        ("print", DEFAULT_LAYOUT),
        ("import hall.map", Layout(["#...", "#..."])),
    ],
)
def test_layouts_are_printed(
    capsys: pytest.CaptureFixture[str], words: str, printed: Layout
) -> None:
    assert command(capsys, "layout", *words.split()) == (0, f"{printed}\n", "")


@pytest.mark.parametrize(("kind", "option"), [("generate", "--output"), ("shelves", "-o")])
def test_a_layout_goes_to_a_file_and_passes_the_check(
    capsys: pytest.CaptureFixture[str], kind: str, option: str
) -> None:
    assert command(capsys, "layout", kind, option, "new.txt") == (0, "saved new.txt\n", "")
    printed = command(capsys, "layout", kind).out
    assert command(capsys, "layout", "print", "new.txt").out == printed
    result = command(capsys, "layout", "check", "new.txt")
    assert (result.code, "0 of them cut off" in result.out) == (0, True)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (
            "#####\n#P.D#\n#...#\n#####\n",
            "4 x 5, 6 open cells (0 of them cut off), pickups: 1, dropoffs: 1; an item can be",
        ),
        ("PCD\nC..\n", "dropoffs: 1, chargers: 2; an item"),
        ("P.D#..\n", "5 open cells (2 of them cut off)"),
    ],
)
def test_check_describes_a_layout(capsys: pytest.CaptureFixture[str], rows: str, said: str) -> None:
    Path("room.txt").write_text(rows)
    result = command(capsys, "layout", "check", "room.txt")
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
def test_check_names_what_is_wrong_with_a_layout(
    capsys: pytest.CaptureFixture[str], rows: str, message: str
) -> None:
    Path("room.txt").write_text(rows)
    assert refusal(capsys, "layout", "check", "room.txt").startswith(f"room.txt: {message}")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("generate -o missing/hall.txt", "the folder missing does not exist"),
        ("generate --height -3", "the size is -3 x 16"),
        ("shelves --rows 0", "shelf_rows is 0"),
        ("warehouse 10-20-10-0-1", "depth is 0; it must be at least 1"),
        ("warehouse 999999999-1-1-1-1", "more than MAX_CELLS"),
        ("warehouse 10-20-10-2", "'10-20-10-2' is not a warehouse; allowed: five whole numbers "),
        ("warehouse 10-20-10-2-1-1", "such as 10-20-10-2-1"),
        ("warehouse 1-1-1-1-x", "'1-1-1-1-x' is not a warehouse"),
        (f"warehouse 1-1-1-1-{'9' * 5000}", "'1-1-1-1-9999"),
        ("check missing.txt", "missing.txt: No such file or directory"),
        ("print missing.txt", "missing.txt: No such file or directory"),
        ("check hall.map", "hall.map: there is no pickup P"),
        ("import ends.map", "ends.map: line 6, column 3: 'E' is no terrain"),
    ],
)
def test_a_wrong_value_or_file_is_named(
    capsys: pytest.CaptureFixture[str], words: str, message: str
) -> None:
    Path("ends.map").write_text(Path("hall.map").read_text().replace("T...", "T.E."))
    assert message in refusal(capsys, "layout", *words.split())


def test_help_explains_the_tiles(capsys: pytest.CaptureFixture[str]) -> None:
    assert "C charger" in " ".join(command(capsys, "layout", "--help").out.split())


def test_import_reads_stations_only_with_robot_runners(capsys: pytest.CaptureFixture[str]) -> None:
    ends = Path("ends.map")
    ends.write_text(Path("hall.map").read_text().replace("T...", "T.E."))
    words = ("layout", "import", ends, "--robot-runners")
    assert command(capsys, *words) == (0, "#.D.\n#.P.\n", "")


def test_import_takes_a_map_under_any_name_and_writes_a_layout(
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = ("layout", "import", Path("hall.map").rename("hall.octile"), "-o", "hall.txt")
    assert command(capsys, *words) == (0, "saved hall.txt\n", "")
    assert Layout.load("hall.txt").rows == ("#...", "#...")


def test_a_layout_can_be_saved_as_a_map(capsys: pytest.CaptureFixture[str]) -> None:
    assert command(capsys, "layout", "shelves", "-o", "new.map").out == "saved new.map\n"
    assert load_map("new.map") == shelf_layout().with_stations(None, None)


def test_a_map_is_a_layout_for_other_commands(capsys: pytest.CaptureFixture[str]) -> None:
    words = "run --layout hall.map --seed 1 --save episode.npz --no-show"
    assert command(capsys, *words.split()).code == 0
    walls = Episode.load("episode.npz").layout.with_stations(None, None)
    assert walls.rows == ("#...", "#...")


def test_layouts_with_names_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    out = command(capsys, "layout", "list").out
    for name in NAMES:
        layout = named_layout(name)
        assert f"{name}, {layout.height} x {layout.width}\n{layout}\n" in out
