"""Every command refuses a wrong option in one line, before it prints or writes anything.

The commands and their options are read from the program, so a new command is tested by itself.
"""

import enum
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import LEAVES, refusal, without_display

MANY = 10**9
LIMITS = {
    "--battery": {(1, MANY)},
    "--count": {(1, 10**6)},
    "--episodes": {(1, 1000), (1, 100_000), (1, None)},
    "--interval-ms": {(1, 60_000)},
    "--jobs": {(1, 64)},
    "--late-penalty": {(0, None)},
    "--layouts": {(1, 100_000)},
    "--max-steps": {(1, MANY)},
    "--memory": {(0, 10**9)},
    "--noise": {(0, 0.5)},
    "--people": {(0, 100_000)},
    "--robots": {(1, 100_000), (1, 1000)},
    "--seed": {(0, None), (0, 2**32 - 1)},
    "--seeds": {(1, 1000)},
    "--speed": {(0.01, 100)},
    "--steps": {(1, MANY)},
    "--stop": {(0, None)},
    "--view-radius": {(0, 1000)},
    "--workers": {(1, 1024)},
}
"""Least and greatest values of options; commands may differ in them."""

ARGUMENTS = {
    "export": ("r.sqlite", "t.csv"),
    "grade": ("agent.py",),
    "layout check": ("hall.map",),
    "layout import": ("hall.map",),
    "layout warehouse": ("1-1-1-1-1",),
    "replay": ("e.npz",),
    "report": ("r.sqlite",),
}
"""Arguments of commands that need some; options are refused before these files are read."""

BACKENDS = {"sleigh": "no backend is called 'sleigh'; installed: driving, grid, physics"}
CELLS = {
    "0,0": "row 0, column 0 is wall; it must be an open cell",
    "-1,99": "row -1, column 99 is off the grid (rows 0..6, columns 0..11)",
}
UNKNOWN = {
    "--agent": {
        "nobody": "no agent is called 'nobody'; allowed: random, reflex, greedy",
        "missing.py:Agent": "agent file missing.py: there is no such file",
        "wrong.py:Agent": "wrong.py, line 2: ",
        "waiter.py:Agent": "waiter.py has no class 'Agent'",
    },
    "--backend": BACKENDS,
    "--goal": CELLS,
    "--layout": {
        "nowhere": "no layout is called 'nowhere'; allowed: default, corridor, ",
        "missing.txt": "missing.txt: No such file or directory",
        "bad.txt": "bad.txt: row 1, column 2: 'x' is not a tile; allowed: # (wall)",
    },
    "--left": BACKENDS,
    "--planner": {"nobody": "no planner is called 'nobody'; allowed: pibt, "},
    "--right": BACKENDS,
    "--save": {"good": "good: cannot save as a file without a suffix; allowed: ."},
    "--start": CELLS,
}
"""Values of options that name nothing, and what is said of them."""

MALFORMED = {
    "--goal": {"1,2,3": "--goal is '1,2,3'; it must be ROW,COL as in 1,2"},
    "--start": {"1": "--start is '1'; it must be ROW,COL as in 1,2"},
}
PICTURES = ".gif, .mp4, .html, .svg, .png"
SUFFIXES = {
    "run": f"{PICTURES}, .npz",
    "play": f"{PICTURES}, .npz",
    "fleet": f"{PICTURES}, .npz",
    "gap": ".html, .csv",
    "compare-planners": ".svg, .png",
    "compare": PICTURES,
    "compare-agents": ".svg, .png",
    "grade": ".json, .html",
    "demo": PICTURES,
    "search": PICTURES,
    "explore": f"{PICTURES}, .npz",
    "replay": f"{PICTURES}, .npz",
}
"""Suffixes of the files that commands save."""

each_command = pytest.mark.parametrize("name", LEAVES)


def options_of(name: str) -> list[str]:
    return [parameter.opts[0] for parameter in LEAVES[name].params]


def wrong_values(parameter: Any) -> Iterator[str]:
    """Yield texts that are not of the parameter's type, and the nearest ones beyond its limits."""
    kind = parameter.type_descriptor.annotation
    if kind in (int, float):
        yield "much"
        if kind is int:
            yield "1.5"
        for limit, way in ((parameter.min, -math.inf), (parameter.max, math.inf)):
            if limit is not None and kind is float:
                yield from (repr(math.nextafter(limit, way)), repr(way), "nan")
            elif limit is not None:
                yield str(limit + (1 if way > 0 else -1))
    elif isinstance(kind, type) and issubclass(kind, enum.Enum):
        yield "nonsense"


def cases() -> Iterator[tuple[str, str, str, int, str]]:
    """Yield command, option, value, exit code and a part of the line."""
    for name, leaf in LEAVES.items():
        for parameter in leaf.params:
            option = parameter.opts[0]
            for value in dict.fromkeys(wrong_values(parameter)):
                yield name, option, value, 2, f"Invalid value for '{option}'"
            for code, table in ((2, MALFORMED), (1, UNKNOWN)):
                for value, message in table.get(option, {}).items():
                    yield name, option, value, code, message


@pytest.fixture(autouse=True)
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """Work in a folder to which nothing may be added."""
    without_display(monkeypatch)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wrong.py").write_text("x = 1\nclass Agent(:\n")
    (tmp_path / "waiter.py").write_text("class Waiter:\n    pass\n")
    (tmp_path / "bad.txt").write_text("P..D\n..x.\n")
    (tmp_path / "inner").mkdir()
    before = {*tmp_path.iterdir()}
    yield
    assert {*tmp_path.iterdir()} - before <= {tmp_path / "__pycache__"}


@pytest.mark.parametrize(("name", "option", "value", "code", "message"), [*cases()])
def test_a_wrong_value_is_refused_before_any_work(
    capsys: pytest.CaptureFixture[str], name: str, option: str, value: str, code: int, message: str
) -> None:
    line = refusal(capsys, *name.split(), *ARGUMENTS.get(name, ()), option, value, code=code)
    assert message in line


def test_the_limits_of_numbers_are_those_of_the_table() -> None:
    limits: dict[str, set[tuple[float | None, float | None]]] = {}
    for name, leaf in LEAVES.items():
        for parameter in leaf.params:
            option, pair = parameter.opts[0], (parameter.min, parameter.max)
            if pair != (None, None):
                limits.setdefault(option, set()).add(pair)
                for value in (each for each in pair if each is not None):
                    words = [*ARGUMENTS.get(name, ()), option, str(value)]
                    leaf.make_context(name, words)  # raises if a limit is refused
    assert limits == LIMITS


@each_command
def test_what_a_command_does_not_have_is_wrong_usage(
    capsys: pytest.CaptureFixture[str], name: str
) -> None:
    words = (*name.split(), *ARGUMENTS.get(name, ()))
    assert "--frobnicate" in refusal(capsys, *words, "--frobnicate", code=2)
    arguments = [option for option in options_of(name) if not option.startswith("-")]
    extra = ["much"] * (1 + len(arguments) - len(ARGUMENTS.get(name, ())))
    assert "unexpected extra argument" in refusal(capsys, *words, *extra, code=2)


@pytest.mark.parametrize("name", ARGUMENTS)
def test_a_missing_argument_is_wrong_usage(capsys: pytest.CaptureFixture[str], name: str) -> None:
    assert "Missing argument" in refusal(capsys, *name.split(), code=2)


def test_all_commands_that_save_are_in_the_table() -> None:
    assert [name for name in LEAVES if "--save" in options_of(name)] == [*SUFFIXES]


@pytest.mark.parametrize("name", SUFFIXES)
def test_a_file_is_saved_in_a_folder_in_one_of_the_allowed_formats(
    capsys: pytest.CaptureFixture[str], name: str
) -> None:
    words = (*name.split(), *ARGUMENTS.get(name, ()), "--save")
    line = refusal(capsys, *words, "a.xyz")
    assert line == f"a.xyz: cannot save as .xyz; allowed: {SUFFIXES[name]}"
    suffix = SUFFIXES[name].split(", ")[0]
    line = refusal(capsys, *words, f"missing/a{suffix}")
    assert line == "the folder missing does not exist"
    folder = Path(f"inner/a{suffix}")
    folder.mkdir()
    assert refusal(capsys, *words, folder) == f"{folder} is a folder, not a file"


def test_a_command_that_is_not_known_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert "frobnicate" in refusal(capsys, "frobnicate", code=2)
