from pathlib import Path

import pytest
from helpers.command_line import command, refusal

from warehouse_core import DEFAULT_LAYOUT, Episode, Layout, random_layout, shelf_layout
from warehouse_core.world.generators import benchmark_warehouse
from warehouse_core.world.map_files import load_map
from warehouse_core.world.named_layouts import NAMES, named_layout


@pytest.fixture
def room(tmp_path: Path) -> Path:
    path = tmp_path / "room.txt"
    path.write_text("#####\n#P.D#\n#...#\n#####\n")
    return path


@pytest.fixture
def map_file(tmp_path: Path) -> Path:
    path = tmp_path / "map_file.map"
    path.write_text("type octile\nheight 2\nwidth 4\nmap\n@.S.\nT...\n")
    return path


def layout_in(text: str) -> Layout:
    return Layout(text.split())


def test_generate_prints_a_layout(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--height", 8, "--width", 9, "--density", 0.3, "--seed", 5]
    result = command(capsys, "layout", "generate", *words)
    assert (result.code, result.err) == (0, "")
    assert layout_in(result.out) == random_layout(8, 9, 0.3, 5)


def test_shelves_prints_a_layout(capsys: pytest.CaptureFixture[str]) -> None:
    words = [
        "--rows",
        "3",
        "--columns",
        "2",
        "--length",
        "5",
        "--depth",
        "2",
        "--aisle",
        "2",
        "--seed",
        "7",
    ]
    result = command(capsys, "layout", "shelves", *words)
    assert (result.code, result.err) == (0, "")
    assert layout_in(result.out) == shelf_layout(3, 2, 5, 2, 2, 7)


def test_shelves_may_have_several_stations_and_chargers(
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = ["--aisle", 2, "--pickups", 4, "--dropoffs", 3, "--chargers", 2, "--seed", 7]
    result = command(capsys, "layout", "shelves", *words)
    expected = shelf_layout(aisle=2, seed=7, pickups=4, dropoffs=3, chargers=2)
    assert (result.code, layout_in(result.out)) == (0, expected)


def test_check_counts_chargers_and_names_one_that_cannot_be_reached(
    capsys: pytest.CaptureFixture[str], room: Path
) -> None:
    room.write_text("PCD\nC..\n")
    assert "dropoffs: 1, chargers: 2; an item" in command(capsys, "layout", "check", room).out
    room.write_text("PCD#C\n")
    message = refusal(capsys, "layout", "check", room)
    assert "row 0, column 4 is charger, which cannot be reached" in message


def test_help_explains_the_tiles(capsys: pytest.CaptureFixture[str]) -> None:
    assert "C charger" in " ".join(command(capsys, "layout", "--help").out.split())


@pytest.mark.parametrize(("kind", "option"), [("generate", "--output"), ("shelves", "-o")])
def test_a_layout_goes_to_a_file_and_passes_the_check(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, kind: str, option: str
) -> None:
    target = tmp_path / "hall.txt"
    assert command(capsys, "layout", kind, option, target) == (0, f"saved {target}\n", "")
    printed = command(capsys, "layout", kind).out
    assert command(capsys, "layout", "print", target).out == printed
    result = command(capsys, "layout", "check", target)
    assert result.code == 0
    assert "0 of them cut off" in result.out


def test_a_file_that_cannot_be_written_is_named(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    missing = tmp_path / "missing"
    message = refusal(capsys, "layout", "generate", "-o", missing / "hall.txt")
    assert message == f"the folder {missing} does not exist"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["generate", "--height", -3], "the size is -3 x 16"),
        (["shelves", "--rows", 0], "shelf_rows is 0"),
        (["warehouse", "10-20-10-0-1"], "depth is 0; it must be at least 1"),
        (["warehouse", "999999999-1-1-1-1"], "more than MAX_CELLS"),
    ],
)
def test_a_size_that_is_not_allowed_is_named(
    capsys: pytest.CaptureFixture[str], words: list[object], message: str
) -> None:
    assert message in refusal(capsys, "layout", *words)


def test_check_describes_a_layout(capsys: pytest.CaptureFixture[str], room: Path) -> None:
    assert command(capsys, "layout", "check", room) == (
        0,
        f"{room}: 4 x 5, 6 open cells (0 of them cut off), pickups: 1, dropoffs: 1; "
        "an item can be delivered\n",
        "",
    )


def test_check_counts_cells_that_are_cut_off(
    capsys: pytest.CaptureFixture[str], room: Path
) -> None:
    room.write_text("P.D#..\n")
    assert "5 open cells (2 of them cut off)" in command(capsys, "layout", "check", room).out


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("#..#\n#.x#\n", "row 1, column 2: 'x' is not a tile"),
        ("..D\n", "there is no pickup P"),
        ("..P\n", "there is no dropoff D"),
        ("P#D\n", "row 0, column 2 is dropoff, which cannot be reached"),
        ("P.D#P\n", "row 0, column 4 is pickup, which cannot be reached"),
    ],
)
def test_check_names_what_is_wrong_with_a_layout(
    capsys: pytest.CaptureFixture[str], room: Path, text: str, message: str
) -> None:
    room.write_text(text)
    found = refusal(capsys, "layout", "check", room)
    assert message in found
    assert str(room) in found


@pytest.mark.parametrize("name", ["check", "print"])
def test_a_file_that_cannot_be_read_is_named(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str
) -> None:
    missing = tmp_path / "missing.txt"
    assert refusal(capsys, "layout", name, missing) == f"{missing}: No such file or directory"


def test_print_shows_a_layout_or_the_built_in_one(
    capsys: pytest.CaptureFixture[str], room: Path
) -> None:
    assert command(capsys, "layout", "print", room) == (0, room.read_text(), "")
    assert command(capsys, "layout", "print").out == f"{DEFAULT_LAYOUT}\n"


def test_warehouse_prints_the_benchmark_of_that_name(
    capsys: pytest.CaptureFixture[str],
) -> None:
    result = command(capsys, "layout", "warehouse", "3-4-5-2-1")
    assert result.code == 0
    assert layout_in(result.out) == benchmark_warehouse(3, 4, 5, 2, 1)


@pytest.mark.parametrize(
    "name", ["10-20-10-2", "10-20-10-2-1-1", "1-1-1-1-x", f"1-1-1-1-{'9' * 5000}"]
)
def test_a_wrong_name_of_a_warehouse_is_an_error(
    capsys: pytest.CaptureFixture[str], name: str
) -> None:
    message = refusal(capsys, "layout", "warehouse", name)
    assert name[:10] in message
    if len(name) < 100:
        assert message.endswith("five whole numbers C-R-L-W-A, such as 10-20-10-2-1")


def test_import_reads_a_map(
    capsys: pytest.CaptureFixture[str], map_file: Path, tmp_path: Path
) -> None:
    assert command(capsys, "layout", "import", map_file) == (0, "#...\n#...\n", "")
    hall = tmp_path / "hall.txt"
    words = ["layout", "import", map_file, "-o", hall]
    assert command(capsys, *words) == (0, f"saved {hall}\n", "")
    assert Layout.load(hall).rows == ("#...", "#...")


def test_import_reads_stations_only_with_robot_runners(
    capsys: pytest.CaptureFixture[str], map_file: Path
) -> None:
    map_file.write_text(map_file.read_text().replace("T...", "T.E."))
    message = refusal(capsys, "layout", "import", map_file)
    assert message.startswith(f"{map_file}: line 6, column 3: 'E' is no terrain")
    words = ["layout", "import", map_file, "--robot-runners"]
    assert command(capsys, *words) == (0, "#.D.\n#.P.\n", "")


def test_import_takes_a_map_under_any_name(
    capsys: pytest.CaptureFixture[str], map_file: Path
) -> None:
    renamed = map_file.rename(map_file.with_suffix(".octile"))
    assert command(capsys, "layout", "import", renamed).out == "#...\n#...\n"


def test_a_layout_can_be_saved_as_a_map(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    hall = tmp_path / "hall.map"
    assert command(capsys, "layout", "shelves", "-o", hall).out == f"saved {hall}\n"
    assert load_map(hall) == shelf_layout().with_stations(None, None)


def test_a_map_is_a_layout_for_other_commands(
    capsys: pytest.CaptureFixture[str], map_file: Path, tmp_path: Path
) -> None:
    assert refusal(capsys, "layout", "check", map_file) == f"{map_file}: there is no pickup P"
    record = tmp_path / "episode.npz"
    words = ["run", "--layout", map_file, "--seed", 1, "--save", record, "--no-show"]
    assert command(capsys, *words).code == 0
    walls = Episode.load(record).layout.with_stations(None, None)
    assert walls.rows == ("#...", "#...")


def test_layouts_with_names_are_listed_and_can_be_used(capsys: pytest.CaptureFixture[str]) -> None:
    out = command(capsys, "layout", "list").out
    for name in NAMES:
        layout = named_layout(name)
        assert f"{name}, {layout.height} x {layout.width}\n{layout}\n" in out
    assert command(capsys, "layout", "print", "maze").out == f"{named_layout('maze')}\n"
