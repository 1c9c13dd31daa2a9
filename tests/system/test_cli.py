"""The command ``warehouse``: its output, its files and its exit codes."""

import re
from collections import defaultdict
from importlib.metadata import entry_points, version
from pathlib import Path

import pytest
from helpers.command_line import LEAVES, Refused, Warehouse, in_a_process, without_display
from helpers.pictures import short_episode
from PIL import Image

import agents.__main__ as program
from agents.lab.commands.cli import RENAMED_COMMANDS
from agents.registry import make_agent
from warehouse_core import Episode
from warehouse_core.viz.gif_writer import GifWriter

HEAVY = ("matplotlib", "scipy", "gymnasium", "pymunk", "jinja2", "rich", "PIL", "torch")
FOR_OTHER_COMMANDS = ("gymnasium", "pymunk", "torch", "stable_baselines3", "sb3_contrib")


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


def test_the_version_is_that_of_the_package(warehouse: Warehouse) -> None:
    expected = f"warehouse-lab {version('warehouse-lab')}\n"
    assert warehouse("--version") == (0, expected, "")


@pytest.mark.parametrize("name", LEAVES)
def test_every_command_explains_its_options_and_has_an_example_that_is_valid(
    warehouse: Warehouse, name: str
) -> None:
    result = warehouse(*name.split(), "-h")
    assert result.code == 0
    assert all(parameter.help for parameter in LEAVES[name].params)
    [example] = re.findall(r"Example: warehouse (.*(?:\n  .+)*)", result.out)
    words = " ".join(example.split()).removeprefix(name).split()
    LEAVES[name].make_context(name, words)  # raises if an option is wrong


def test_an_option_has_one_meaning_in_all_commands_and_a_meaning_one_name() -> None:
    meanings, names = defaultdict[str, set[str]](set), defaultdict[str, set[str]](set)
    for leaf in LEAVES.values():
        for parameter in leaf.params:
            if parameter.param_type_name == "option":
                assert parameter.is_flag or parameter.metavar, "no type of Python is shown"
                meaning = parameter.help.partition(". ")[0].removesuffix(".")
                names[meaning].add("/".join(sorted((*parameter.opts, *parameter.secondary_opts))))
                for name in (*parameter.opts, *parameter.secondary_opts):
                    meanings[name].add(meaning)
    assert [each for each in (*meanings.items(), *names.items()) if len(each[1]) > 1] == []


@pytest.mark.parametrize("group", ["", *LEAVES])
def test_the_help_fits_60_columns_and_cuts_no_summary_off(warehouse, monkeypatch, group) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    out = warehouse(*group.split(), "--help").out
    assert max(map(len, out.splitlines())) <= 60
    assert "..." not in out.partition("Options:")[2]


def test_the_help_lists_commands_in_groups(warehouse: Warehouse) -> None:
    lines = warehouse("--help").out.partition("Start:")[2].splitlines()
    titles = ["Start:", *(line for line in lines if line.endswith(":"))]
    assert titles == ["Start:", "Several robots:", "Study:", "Files:"]


@pytest.mark.parametrize("name", [name for name in LEAVES if name in ("run", "play", "fleet")])
def test_backends_that_the_help_lists_exist_for_the_command(name: str) -> None:
    [text] = (each.help for each in LEAVES[name].params if each.opts[0] == "--backend")
    listed = [each for each in ("grid", "physics", "driving") if each in text]
    assert listed == ["grid", "physics"] + ["driving"] * (name != "play")


def test_agents_that_the_help_lists_exist() -> None:
    for name in (
        LEAVES["run"].params[0].help.partition(": ")[2].split(", clone:FILE")[0].split(", ")
    ):
        make_agent(name, 1)


def test_a_former_command_prints_its_replacement(refused: Refused) -> None:
    assert refused("mapf", "--seed", 1, code=2) == (
        "the command 'mapf' no longer exists; use: warehouse plan"
    )
    commands = {line.split()[0] for line in LEAVES}
    assert not commands & set(RENAMED_COMMANDS)
    replaced = {each.split()[1] for each in RENAMED_COMMANDS.values() if "warehouse" in each[:9]}
    assert replaced <= commands


@pytest.mark.parametrize(
    ("line", "heavy"),
    [
        ("--help", HEAVY),
        ("run --seed 1 --no-show", FOR_OTHER_COMMANDS),
        ("compare agents -n 1 --max-steps 9", (*FOR_OTHER_COMMANDS, "scipy", "matplotlib")),
    ],
)
def test_a_command_loads_no_library_that_it_does_not_need(tmp_path, line, heavy) -> None:
    program = f"""
import sys
from agents.lab.commands.cli import main
try:
    main()
finally:
    sys.stderr.write(" ".join(name for name in {heavy} if name in sys.modules))
"""
    result = in_a_process("-c", program, *line.split(), folder=tmp_path)
    assert (result.code, result.err) == (0, "")
    assert result.out


def test_without_a_command_the_help_is_shown(warehouse: Warehouse) -> None:
    result = warehouse()
    assert result.code == 2
    assert result.out + result.err == warehouse("--help").out


# warehouse run


def test_run_saves_several_files(warehouse: Warehouse, tmp_path: Path) -> None:
    files = ["a.gif", "b.html", "c.svg", "d.png", "e.npz", "f.mp4"]
    words = [word for file in files for word in ("--save", file)]
    result = warehouse("run", "--seed", 1, "--battery", 1, *words)
    assert result.code == 0
    assert result.out.splitlines()[-6:] == [f"saved {file}" for file in files]
    assert names(tmp_path) == files
    assert all((tmp_path / file).stat().st_size > 1000 for file in files)
    assert Episode.load("e.npz").seed == 1


@pytest.mark.parametrize(
    ("line", "file", "frames"),
    [
        ("run --seed 12 --battery 5", "replay-GreedyAgent-grid-12.gif", 6),
        ("compare search --layout corridor --weights 1", "search.gif", 0),
        ("demo bump", "demo-bump.gif", 0),
        ("fleet --robots 2 --max-steps 5 --seed 5", "replay-auto-grid-5.html", 0),
    ],
)
def test_without_a_display_a_command_names_the_file_of_what_it_would_show(
    warehouse: Warehouse, tmp_path: Path, line: str, file: str, frames: int
) -> None:
    code, out, err = warehouse(*line.split())
    assert (code, err) == (0, "")
    assert out.splitlines()[-2:] == [
        "there is no display for a window, so the replay is saved to a file",
        f"saved {file}",
    ]
    assert names(tmp_path) == [file]
    if not file.endswith(".html"):
        with Image.open(file) as film:
            count = getattr(film, "n_frames", 1)
        assert count == frames if frames else count > 1


# warehouse replay


def test_replay_reports_and_saves(warehouse: Warehouse, tmp_path: Path, record: Path) -> None:
    result = warehouse("replay", record, "--save", "a.gif", "--speed", 1.25)
    assert result.code == 0
    assert result.out.splitlines() == [
        "Tester on the grid backend, seed 4",
        "outcome         delivered",
        "diagnosis       delivered in 6 steps; the minimum is 5",
        "total reward    13.40",
        "final battery   4 of 10",
        "episode length  6 of at most 30 steps",
        "saved a.gif",
    ]
    with Image.open("a.gif") as film:
        assert film.n_frames == 7  # type: ignore[attr-defined]
        assert film.info["duration"] == 120


def test_a_record_that_is_missing_or_damaged_is_named(refused: Refused, record: Path) -> None:
    assert refused("replay", "none.npz") == "none.npz: No such file or directory"
    assert str(record.parent) in refused("replay", record.parent)
    for damaged in (record.read_bytes()[:-40], b"not an archive"):
        record.write_bytes(damaged)
        assert refused("replay", record, "--save", "a.gif").startswith(f"{record}: ")
    assert names(record.parent) == ["episode.npz"]


# Interrupts and faults.


def test_an_interrupt_ends_with_130_and_leaves_no_partial_file(
    warehouse: Warehouse, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, record: Path
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(GifWriter, "add", interrupted)
    result = warehouse("replay", record, "--save", "a.gif")
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


def test_an_interrupt_while_a_compiled_module_is_initialised_comes_later(tmp_path: Path) -> None:
    """The module ``matplotlib.ft2font`` creates enumerations, and would raise ``ImportError``."""
    words = """
import enum, os, signal, sys
from agents.__main__ import INITIALISING, main
make, sent = enum.EnumType.__call__, []
def interrupted(*arguments, **named):
    frame = sys._getframe()
    while frame is not None and not sent:
        if frame.f_code in INITIALISING:
            sent.append(os.kill(os.getpid(), signal.SIGINT))
        frame = frame.f_back
    return make(*arguments, **named)
enum.EnumType.__call__ = interrupted
sys.argv[1:] = ["run", "--seed", "1", "--battery", "2", "--save", "a.png"]
main()
"""
    code, _, said = in_a_process("-c", words, folder=tmp_path)
    assert (code, said) == (130, "warehouse: interrupted\n")
    assert not list(tmp_path.iterdir())


def test_an_interrupt_that_python_ignores_comes_again(tmp_path: Path) -> None:
    """The interrupt is raised in a weakref callback, such as the locks of imported modules have."""
    words = """
import sys, time, weakref
class Part:
    pass
def interrupted(*_):
    raise KeyboardInterrupt
class Interrupting:
    def find_spec(self, name, *_):
        if name == "numpy":
            part = Part()
            self.callback = weakref.ref(part, interrupted)
            del part
            time.sleep(1000)
            print("the program goes on")
sys.meta_path.insert(0, Interrupting())
from agents.__main__ import main
main()
"""
    assert in_a_process("-c", words, folder=tmp_path) == (130, "", "warehouse: interrupted\n")
