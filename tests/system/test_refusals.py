"""Every command refuses a wrong option in one line, before it prints or writes anything.

The commands and their options are read from the program, so new commands are tested without a
change here.
"""

import enum
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import LEAVES, Refused, without_display

from agents.lab.console.group import HELP
from agents.lab.parameters import Number, Whole
from agents.lab.trials.random_layouts import TRAINING_LAYOUTS

ORDERS = "released,due,pickup_row,pickup_col,dropoff_row,dropoff_col,robot"
ARGUMENTS = {
    "export": ("warehouse/greedy-v0",),
    "grade": ("agent.py",),
    "replay": ("e.npz",),
    "compare": ("agents",),
    "report": ("r.sqlite",),
    "train": ("q",),
}
"""Required arguments of commands; options are refused before these files are read."""

OF_KINDS = {("compare", "--planner"): ("planners",), ("compare", "--goal"): ("search",)}
"""Arguments with which a command accepts an option that it otherwise refuses."""

BACKENDS = {"sleigh": "no backend is called 'sleigh'; installed: driving, grid, physics"}
CELLS = {
    "0,0": "row 0, column 0 is wall; it must be an open cell",
    "-1,99": "row -1, column 99 is off the grid (rows 0..",
}
UNKNOWN = {
    "--agent": {
        "nobody": "no agent is called 'nobody'; allowed: random, reflex, model, goal, utility",
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
    "--planner": {"nobody": "no planner is called 'nobody'; allowed: auto, pibt, "},
    "--start": CELLS,
}
"""Values of options that name nothing, and parts of their messages."""

MALFORMED = {
    "--goal": {"1,2,3": "--goal is '1,2,3'; it must be ROW,COL, as in 1,2"},
    "--start": {"1": "--start is '1'; it must be ROW,COL, as in 1,2"},
}
PLANS = "--show-plans needs a planner; leave out --agent"
ROBOTS = "it must be numbers of robots, 0..7, as in 0,3, or pushes"
BATTERY = "it must be 1..2147483647 steps or joules, as in 400steps"
TIME = "allowed: a number 0.001..1e+09"
SIZES = "it must be whole numbers, at least 1, as in 32,64"
WEIGHT = "each must be 0..1000000 or inf"
DENSITY = "it must be LOW:HIGH as in 0.1:0.4, or one number"
UNUSED = "describes random layouts; add --layout random"
WAREHOUSE = "is not a warehouse; allowed: five whole numbers C-R-L-W-A, such as 10-20-10-2-1"

WRONG = {
    "fleet --orders 0.2": "0.2: orders cannot be read from this format; allowed: .csv",
    "fleet --orders orders.csv --order-rate 1": "--order-rate cannot be combined with --orders",
    "fleet --battery 0": f"--battery is '0'; {BATTERY}",
    "fleet --agent bfs --show-plans 1": PLANS,
    "fleet --planner pibt --show-plans 8": f"--show-plans is '8'; {ROBOTS}",
    "fleet --planner pibt --show-plans 0,": f"--show-plans is '0,'; {ROBOTS}",
    "fleet --people 100000": "robots and people is 100008; it must be at most",
    "fleet --agent bfs --planner a.py:A": "--planner cannot be combined with --agent",
    "fleet --agent bfs --assignment urgent": "--assignment needs a planner; leave out --agent",
    "plan --plan-seconds 0": f"--plan-seconds is 0; {TIME}",
    "compare backends --robots 2 --order-rate 0": "--order-rate is 0; allowed: a number above 0",
    "plan none.scen": "none.scen: there is no such file or folder",
    "plan .": ".: a folder has several problems; use: warehouse compare planners .",
    "plan bare.txt": "bare.txt: unknown format of a problem; allowed: .scen",
    "plan -o a.csv --planner pibt --planner cbs": "--save takes the paths of one planner",
    "compare planners --robots 4,x": f"--robots has 'x'; {SIZES}",
    "compare search --weights 1,-2": f"--weights has '-2'; {WEIGHT}",
    "compare search --weights 1,2,3,4,5,6,7": "--weights has 7 weights; at most 6",
    "compare search --heuristic luck": "no heuristic is called 'luck'; allowed: manhattan",
    "compare search --jobs 3": "--jobs cannot be combined with 'compare search'",
    "compare agents -o a.png -o b.png": "'compare agents' saves one figure",
    "compare agents x.scen": "'x.scen' is one argument too many for 'compare agents'",
    "compare agents --backend grid --backend physics": "--backend is given 2 times",
    "compare agents --size 7x12": f"--size {UNUSED}",
    "compare agents --density 0.2": f"--density {UNUSED}",
    "train ppo --layouts 3": f"--layouts {UNUSED}",
    "compare agents --layout random --size 7": '--size is 7; allowed: a size "HEIGHTxWIDTH"',
    "compare agents --layout random --density 0.1:x": f"--density is '0.1:x'; {DENSITY}",
    "compare agents --layout random --start 1,1": "--start cannot be combined with --layout random",
    "train ppo --layout random --robots 2": "--layout random cannot be combined with --robots",
    "train q --layout random": "--layout random cannot be combined with 'train q'",
    "train q --from greedy": "--from cannot be combined with 'train q'",
    "train clone --robots 2": "--robots cannot be combined with 'train clone'",
    "demo --save a.gif": "--save needs a demonstration; allowed: bump",
    "demo ballet": "no demo is called 'ballet'; allowed: bump",
    "grade . --save a.csv --save b.csv": "--save takes one .csv file for a folder",
    "grade mine.py --pages pages": "--pages needs a folder of submissions; 'mine.py' is not",
}
"""Command lines with wrong usage, and parts of their messages."""

IMPOSSIBLE = {
    "run --layout tiny.txt": "tiny.txt: it has 1 empty cell; random stations need two or more",
    "fleet --robots 5000": "5000 robots and 0 people do not fit",
    "fleet --orders nowhere.csv": "nowhere.csv: No such file",
    "fleet --orders orders.csv": "orders.csv: line 2: dropoff_col is 'x'",
    "fleet --planner pibt --assignment x": "no assignment is called 'x'; allowed: fifo, nearest",
    "fleet --order-rate 1e9": "MAX_ORDERS",
    "fleet --planner windowed --show-plans pushes": "does not report which robots push",
    "compare backends --robots 400": "400",
    "compare backends --robots 2 --layout bare.txt": "the layout has no pickup",
    "plan --planner x": "no planner is called 'x'; allowed: auto, pibt, windowed, circulation, ",
    "plan --robots 193": "--robots is 193; allowed: 1..192 on this layout",
    "plan -o x.txt": "x.txt: cannot save as .txt; allowed: .gif",
    "compare planners --layout hall --robots 999": "--robots has 999; allowed: 1 to 98",
    "compare agents -o a.gif": "a.gif: cannot save as .gif; allowed: .svg, .png",
    "compare search -o a.csv": "a.csv: cannot save as .csv; allowed: .gif, .mp4, .html, .svg, .png",
    "compare agents --layout random --density 0.2:0.5": "density is 0.5; it must be at least 0",
    f"compare agents -n 2 --layout random --seed {TRAINING_LAYOUTS - 1}": (
        f"the seed of a random layout is {TRAINING_LAYOUTS}; allowed: 0.."
    ),
    "train ppo --layout random --size 4x4": "each of the 1024 training layouts is also in an exam",
    "train ppo --save m.zip": "m.zip: cannot save as .zip; allowed: .npz",
    "train q --save missing/q.npz": "the folder missing does not exist",
    "train q --layout tiny.txt": "randomize needs two open cells",
    "layout random -o missing/hall.txt": "the folder missing does not exist",
    "layout warehouse:10-20-10-2": f"'10-20-10-2' {WAREHOUSE}",
    f"layout warehouse:1-1-1-1-{'9' * 5000}": "'1-1-1-1-9999",
    "layout --check missing.txt": "missing.txt: No such file or directory",
    "grade none.py": "agent file none.py: there is no such file",
    "grade . --trust --late none.csv": "none.csv: No such file or directory",
    "grade waiter.py --rubric none.toml": "none.toml: No such file or directory",
    "grade . -o a.html": "a.html: cannot save as .html; allowed: .csv",
    "grade mine.py -o a.csv": "a.csv: cannot save as .csv; allowed: .json, .html",
    "grade inner --trust": "inner: it contains no submissions",
    "grade astar": "'astar' needs the map, which graded agents do not get; allowed: random",
    "grade nobody": "'nobody' is not an agent; allowed: random, reflex, model, goal, utility",
    "report r.sqlite": "r.sqlite: there is no such file",
    "report r.sqlite -o r.sqlite": "r.sqlite: cannot save as .sqlite; allowed: .html",
    "report r.html": "r.html: this is the file of results; save the page under another name",
    "sweep --set battery": "'battery' has no value; write NAME=VALUE",
    f"sweep --set battery={'9' * 5000}": "battery is inf; allowed: a whole number 1..",
    "sweep plan.toml --preset battery": "both plan.toml and --preset battery are given; give one",
    "export e.npz t.csv": "t.csv: cannot save as .csv; allowed: .mcap",
    "export e.npz e.mcap": "e.npz: No such file or directory",
    "export r.sqlite e.mcap": "e.mcap: cannot save as .mcap; allowed: .csv",
    "export r.sqlite t.csv": "r.sqlite: there is no such file",
}
"""Well-formed command lines that cannot be carried out, and parts of their messages."""

PICTURES = ".gif, .mp4, .html, .svg, .png"
SUFFIXES = {
    "run": f"{PICTURES}, .npz",
    "play": f"{PICTURES}, .npz",
    "fleet": f"{PICTURES}, .npz, .csv",
    "race": PICTURES,
    "plan": f"{PICTURES}, .csv",
    "grade": ".json, .html, .csv",
    "demo": PICTURES,
    "replay": f"{PICTURES}, .npz",
    "compare": f"{PICTURES}, .csv",
}
"""Suffixes of the files that commands save."""

each_command = pytest.mark.parametrize("name", LEAVES)


def options_of(name: str) -> list[str]:
    return [parameter.opts[0] for parameter in LEAVES[name].params]


def limits_of(parameter: Any) -> tuple[Any, Any] | None:
    """Return the smallest and the largest value of an option, or None if it is not a number."""
    check = getattr(parameter.type_descriptor.parameter_info.parser, "check", None)
    return (check.minimum, check.maximum) if isinstance(check, (Whole, Number)) else None


def wrong_values(parameter: Any) -> Iterator[str]:
    """Yield texts of the wrong type for an option, and the nearest values beyond its limits."""
    kind, limits = parameter.type_descriptor.annotation, limits_of(parameter)
    if isinstance(kind, type) and issubclass(kind, enum.Enum):
        yield "nonsense"
    if limits is None:
        return
    yield "much"
    for limit, direction in zip(limits, (-1, 1), strict=True):
        if kind is int:
            yield str(limit + direction)
        elif limit < math.inf:
            yield repr(math.nextafter(limit, direction * math.inf))


def cases() -> Iterator[tuple[str, str, str, int, str]]:
    """Yield command, option, value, exit code and a part of the line."""
    for name, leaf in LEAVES.items():
        for parameter in leaf.params:
            option = parameter.opts[0]
            for value in dict.fromkeys(wrong_values(parameter)):
                yield name, option, value, 2, "; allowed: "
            for code, table in ((2, MALFORMED), (1, UNKNOWN)):
                for value, message in table.get(option, {}).items():
                    yield name, option, value, code, message


@pytest.fixture(autouse=True)
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """Work in a folder in which no file may be created."""
    without_display(monkeypatch)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wrong.py").write_text("x = 1\nclass Agent(:\n")
    (tmp_path / "waiter.py").write_text("class Waiter:\n    pass\n")
    (tmp_path / "bad.txt").write_text("P..D\n..x.\n")
    (tmp_path / "bare.txt").write_text("....\n....\n")
    (tmp_path / "tiny.txt").write_text("###\n#.#\n###\n")
    (tmp_path / "orders.csv").write_text(f"{ORDERS}\n0,90,2,5,11,x,\n")
    for name in ("x.scen", "x.json"):
        (tmp_path / name).touch()
    (tmp_path / "inner").mkdir()
    before = {*tmp_path.iterdir()}
    yield
    assert {*tmp_path.iterdir()} - before <= {tmp_path / "__pycache__"}


@pytest.mark.parametrize(("name", "option", "value", "code", "message"), [*cases()])
def test_a_wrong_value_is_refused_before_any_work(
    refused: Refused, name: str, option: str, value: str, code: int, message: str
) -> None:
    arguments = OF_KINDS.get((name, option), ARGUMENTS.get(name, ()))
    line = refused(*name.split(), *arguments, option, value, code=code)
    assert message in line
    assert len(line) < 1000
    if message == "; allowed: ":
        assert line.startswith(f"{option} is ")


@pytest.mark.parametrize(
    ("line", "code", "message"),
    [
        *((line, 2, message) for line, message in WRONG.items()),
        *((line, 1, message) for line, message in IMPOSSIBLE.items()),
    ],
)
def test_options_that_do_not_fit_are_refused_before_any_work(refused, line, code, message) -> None:
    assert message in refused(*line.split(), code=code)


def test_the_limits_of_numbers_are_allowed() -> None:
    for name, leaf in LEAVES.items():
        for parameter in leaf.params:
            option, limits = parameter.opts[0], limits_of(parameter)
            assert limits or parameter.type_descriptor.annotation not in (int, float), option
            for value in limits or ():
                words = [*ARGUMENTS.get(name, ()), option, str(value)]
                # This raises if a limit is refused. Other tests check the help of the option.
                leaf.make_context(name, words, help_option_names=[*HELP])


@each_command
def test_what_a_command_does_not_have_is_wrong_usage(refused: Refused, name: str) -> None:
    words = (*name.split(), *ARGUMENTS.get(name, ()))
    line = refused(*words, "--qqqqqq", code=2)
    assert line.startswith("no option is called '--qqqqqq'; see: ")
    assert line.endswith(f" {name} -h")
    options = [option for option in options_of(name) if option.startswith("--")]
    for option in options[:1]:
        near = f"no option is called '{option}x'; similar: "
        line = refused(*words, f"{option}x", "1", code=2)
        assert line.startswith(near)
        assert f" {option}" in line.removeprefix(near[:-1]).partition(";")[0]
    arguments = [each for each in LEAVES[name].params if each.param_type_name == "argument"]
    extra = ["much"] * (1 + len(arguments) - len(ARGUMENTS.get(name, ())))
    if all(each.nargs == 1 for each in arguments):
        assert refused(*words, *extra, code=2).startswith("'much' is an unexpected argument; see: ")
    values = [each for each in LEAVES[name].params if not getattr(each, "is_flag", True)]
    for parameter in values[:1]:
        option = parameter.opts[0]
        assert refused(*words, option, code=2).startswith(f"{option} needs a value after it")


@pytest.mark.parametrize("name", ARGUMENTS)
def test_a_missing_argument_is_wrong_usage(refused: Refused, name: str) -> None:
    assert " is missing; see: " in refused(*name.split(), code=2)


def test_all_commands_that_save_are_in_the_table() -> None:
    checked = [
        name
        for name, leaf in LEAVES.items()
        if any(each.opts[0] == "--save" and each.callback for each in leaf.params)
    ]
    assert sorted(checked) == sorted(SUFFIXES)


@pytest.mark.parametrize("name", SUFFIXES)
def test_a_file_is_saved_in_a_folder_in_one_of_the_allowed_formats(refused, name) -> None:
    [parameter] = (each for each in LEAVES[name].params if each.opts[0] == "--save")
    named = re.findall(r"\.\w+", parameter.help)
    assert {*named} == set(SUFFIXES[name].split(", ")), "the help lists what is allowed"
    words = (*name.split(), *ARGUMENTS.get(name, ()), "--save")
    line = refused(*words, "a.xyz")
    assert line == f"a.xyz: cannot save as .xyz; allowed: {SUFFIXES[name]}"
    assert refused(*words, "good").startswith("good: cannot save as a file without a suffix; ")
    suffix = SUFFIXES[name].split(", ")[0]
    line = refused(*words, f"missing/a{suffix}")
    assert line == "the folder missing does not exist"
    folder = Path(f"inner/a{suffix}")
    folder.mkdir()
    assert refused(*words, folder) == f"{folder} is a folder, not a file"


def test_a_command_that_is_not_known_is_wrong_usage(refused: Refused) -> None:
    assert refused("frobnicate", code=2).startswith(
        "no command is called 'frobnicate'; allowed: run, play, "
    )
    line = "WHAT is 'frobnicate'; allowed: agents, backends, planners, search"
    assert refused("compare", "frobnicate", code=2) == line
