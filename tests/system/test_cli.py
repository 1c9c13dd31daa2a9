"""The command ``warehouse``: its output, its files and its exit codes."""

import json
import re
from importlib.metadata import entry_points, version
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import LEAVES, Result, command, in_a_process, refusal, without_display
from helpers.pictures import short_episode
from PIL import Image

import agents.__main__ as program
from agents.run_episode import run_episode
from warehouse_core import Episode
from warehouse_core.viz.export.gif_writer import GifWriter

HEAVY = ("matplotlib", "scipy", "gymnasium", "pymunk", "jinja2", "rich", "PIL", "torch")
WAITER = """
class Waiter:
    def reset(self):
        pass

    def act(self, observation):
        return "WAIT"
"""


@pytest.fixture(autouse=True)
def no_display(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, small_pictures: None) -> None:
    without_display(monkeypatch)
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def record(tmp_path: Path) -> Path:
    path = tmp_path / "episode.npz"
    short_episode().save(path)
    return path


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


# The command itself.


def test_the_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    expected = f"warehouse-lab {version('warehouse-lab')}\n"
    assert command(capsys, "--version") == (0, expected, "")


@pytest.mark.parametrize("name", LEAVES)
def test_every_command_explains_its_options_and_has_an_example_that_is_valid(
    capsys: pytest.CaptureFixture[str], name: str
) -> None:
    result = command(capsys, *name.split(), "-h")
    assert result.code == 0
    assert all(parameter.help for parameter in LEAVES[name].params)
    [example] = re.findall(r"Example: warehouse (.*(?:\n  .+)*)", result.out)
    words = " ".join(example.split()).removeprefix(name).split()
    LEAVES[name].make_context(name, words)  # raises if an option is wrong


def test_the_help_cuts_no_summary_off(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    for group in ((), ("layout",), ("train",)):
        assert "..." not in command(capsys, *group, "--help").out.partition("Commands:")[2]


def test_the_help_loads_no_heavy_library(tmp_path: Path) -> None:
    program = f"""
import sys
from agents.lab.commands.cli import main
sys.argv = ["warehouse", "--help"]
try:
    main()
finally:
    sys.stderr.write(" ".join(name for name in {HEAVY} if name in sys.modules))
"""
    result = in_a_process("-c", program, folder=tmp_path)
    assert (result.code, result.err) == (0, "")
    assert "compare-agents" in result.out


def test_without_a_command_the_help_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    result = command(capsys)
    assert result.code == 2
    assert result.out + result.err == command(capsys, "--help").out


# warehouse run


def test_run_saves_several_files(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    files = ["a.gif", "b.html", "c.svg", "d.png", "e.npz", "f.mp4"]
    words = [word for file in files for word in ("--save", file)]
    result = command(capsys, "run", "--seed", 1, "--battery", 1, *words)
    assert result.code == 0
    assert result.out.splitlines()[-6:] == [f"saved {file}" for file in files]
    assert names(tmp_path) == files
    assert all((tmp_path / file).stat().st_size > 1000 for file in files)
    assert Episode.load("e.npz").seed == 1


def test_run_replaces_an_older_file(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    for seed in (1, 2):
        assert command(capsys, "run", "--seed", seed, "--save", "e.npz").code == 0
        assert Episode.load("e.npz").seed == seed


def test_run_without_a_display_names_the_file_of_the_replay(
    capsys: pytest.CaptureFixture[str],
) -> None:
    result = command(capsys, "run", "--seed", 12, "--battery", 5)
    assert (result.code, result.err) == (0, "")
    assert result.out.splitlines()[-2:] == [
        "there is no display to open a window on, so the replay goes to a file",
        "saved replay-GreedyAgent-grid-12.gif",
    ]
    with Image.open("replay-GreedyAgent-grid-12.gif") as film:
        assert film.n_frames == 6  # type: ignore[attr-defined]


def test_a_missing_display_is_found_even_if_matplotlib_has_a_window_backend(tmp_path: Path) -> None:
    result = in_a_process("-m", "agents", "play", folder=tmp_path, MPLBACKEND="tkagg")
    message = "warehouse: play needs a window, and there is no display here\n"
    assert result == Result(1, "", message)


def test_run_takes_an_agent_from_a_file(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(WAITER)
    words = ["run", "--agent", "mine.py:Waiter", "--seed", 1, "--max-steps", 3, "--save", "e.npz"]
    result = command(capsys, *words)
    assert result.out.startswith(
        "Waiter on the grid backend, seed 1, stations drawn\noutcome         out of time\n"
    )
    assert Episode.load("e.npz").actions == ["WAIT"] * 3


def test_a_layout_with_too_few_cells_for_the_stations_is_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "tiny.txt").write_text("###\n#.#\n###\n")
    message = refusal(capsys, "run", "--layout", "tiny.txt", "--save", "e.npz")
    assert message.startswith("tiny.txt: pickup and dropoff are drawn from the empty cells; ")
    assert names(tmp_path) == ["tiny.txt"]


def test_a_full_disk_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    monkeypatch.setattr(GifWriter, "add", full)
    words = ["run", "--seed", 1, "--battery", 2, "--save"]
    for file in ("e.npz", "e.gif"):
        assert refusal(capsys, *words, file) == "No space left on device"
    assert names(tmp_path) == []


def test_a_missing_permission_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    # Permissions do not stop an administrator, who may be running this.
    def forbidden(self: Path, *_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "open", forbidden)
    message = refusal(capsys, "run", "--seed", 1, "--battery", 2, "--save", "e.npz")
    assert message.endswith("npz: Permission denied")
    assert names(tmp_path) == []


# warehouse replay


def test_replay_reports_and_saves(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, record: Path
) -> None:
    result = command(
        capsys, "replay", record, "--save", "a.gif", "--interval-ms", 300, "--speed", 2.5
    )
    assert result.code == 0
    assert result.out.splitlines() == [
        "Tester on the grid backend, seed 4",
        "outcome         delivered",
        "diagnosis       delivered in 6 steps; the shortest way takes 5",
        "total reward    13.40",
        "final battery   4 of 10",
        "episode length  6 of at most 30 steps",
        "saved a.gif",
    ]
    with Image.open("a.gif") as film:
        assert film.n_frames == 7  # type: ignore[attr-defined]
        assert film.info["duration"] == 120


@pytest.mark.parametrize(("interval_ms", "speed"), [(1, 100), (60_000, 0.01)])
def test_replay_is_saved_at_the_limits_of_the_speed(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, interval_ms: float, speed: float
) -> None:
    record = tmp_path / "short.npz"
    run_episode(seed=1, max_steps=1).save(record)
    words = ["--interval-ms", interval_ms, "--speed", speed]
    targets = ["--save", "a.gif", "--save", "a.html", "--save", "a.mp4"]
    assert command(capsys, "replay", record, *words, *targets).code == 0


def test_a_missing_record_is_named(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert refusal(capsys, "replay", "e.npz") == "e.npz: No such file or directory"
    assert str(tmp_path) in refusal(capsys, "replay", tmp_path)


def damage_the_end(record: Path) -> None:
    record.write_bytes(record.read_bytes()[:-40])


def damage_all(record: Path) -> None:
    record.write_bytes(b"not an archive")


def damage_the_header(record: Path) -> None:
    with np.load(record) as file:
        arrays = dict(file)
    header = json.loads(arrays["header"].tobytes()) | {"seed": "one"}
    arrays["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    np.savez_compressed(record, **arrays)


@pytest.mark.parametrize("damage", [damage_the_end, damage_all, damage_the_header])
def test_a_damaged_record_is_one_line_that_names_the_file(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, record: Path, damage: object
) -> None:
    assert callable(damage)
    damage(record)
    assert refusal(capsys, "replay", record, "--save", "a.gif").startswith(f"{record}: ")
    assert names(tmp_path) == ["episode.npz"]


# Interrupts and faults.


def test_an_interrupt_ends_with_130_and_leaves_no_partial_file(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    record: Path,
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(GifWriter, "add", interrupted)
    result = command(capsys, "replay", record, "--save", "a.gif")
    assert result.code == 130
    assert "Traceback" not in result.err
    assert names(tmp_path) == ["episode.npz"]


def test_the_installed_command_is_this_one() -> None:
    (entry,) = entry_points(group="console_scripts", name="warehouse")
    assert entry.load() is program.main


def test_an_interrupt_during_the_imports_is_one_line(tmp_path: Path) -> None:
    words = """
import sys
class Interrupting:
    def find_spec(self, name, *_):
        if name == "numpy":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupting())
from agents.__main__ import main
main()
"""
    assert in_a_process("-c", words, folder=tmp_path) == (130, "", "warehouse: interrupted\n")
