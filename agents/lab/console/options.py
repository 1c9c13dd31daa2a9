"""Options of commands: how to declare one, and those that several commands share."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from agents.lab.parameters import MAX_SEED, MAX_VALUE, PARAMETERS, CheckValue, Number, Whole
from agents.lab.place import Stations
from agents.registry import PLANNERS
from warehouse_core.files.atomic import check_suffix, check_target
from warehouse_core.wording import brief
from warehouse_core.world.named_layouts import NAMES

RECORD_SUFFIX = ".npz"

PICTURES = (".svg", ".png")
"""Suffixes of still pictures."""

MANY: dict[str, Any] = {"default_factory": list, "show_default": False}
"""Settings of an option that may be given more than once, or not at all."""


class Reader:
    """Parser of the text of an option, with the same checks as in files of experiment plans.

    Attributes:
        check: check of the value.
    """

    def __init__(self, name: str, check: CheckValue) -> None:
        self.name, self.check = name, check

    def __call__(self, text: Any) -> Any:
        """Return the checked value of a text, or of a default that is not text."""
        value = text
        for kind in (int, float) if isinstance(text, str) else ():
            try:
                value = kind(text)
                break
            except ValueError:
                continue
        try:
            return self.check(value)
        except ValueError as error:
            raise typer.BadParameter(f"{self.name} is {brief(value)}; allowed: {error}") from None


def option(words: str, help_text: str, check: CheckValue | None = None, **settings: Any) -> Any:
    """Return an option.

    The first sentence of its description is the same in all commands that have the option. Further
    sentences say what is special in this command.

    Args:
        words: names of the option and its metavar, as in ``"--count -c N"``.
        help_text: description.
        check: check of the value; ``None`` leaves it as text.
        settings: further arguments of ``typer.Option``.
    """
    names = [word for word in words.split() if word.startswith("-")]
    metavar = words.split()[-1] if len(names) < len(words.split()) else None
    parser = Reader(names[0], check) if check else None
    return typer.Option(*names, metavar=metavar, parser=parser, help=help_text, **settings)


def parameter_option(name: str, metavar: str = "N", more: str = "") -> Any:
    """Return the option for a parameter of experiments, with its check and its description."""
    parameter = PARAMETERS[name]
    words = f"--{name.replace('_', '-')} {metavar}"
    return option(words, f"{parameter.help} {more}".strip(), parameter.check)


def given(context: typer.Context) -> set[str]:
    """Return the names of the parameters that the user typed on the command line."""
    sources = {name: context.get_parameter_source(name) for name in context.params}
    return {name for name, source in sources.items() if source and source.name == "COMMANDLINE"}


def refuse(context: typer.Context, names: Iterable[str], command: str) -> None:
    """Raise ``typer.BadParameter`` if the user typed one of the named options."""
    for parameter in context.command.params:
        if parameter.name in given(context).intersection(names):
            raise typer.BadParameter(f"{parameter.opts[0]} cannot be combined with '{command}'")


def one_of(kind: type[StrEnum]) -> CheckValue:
    """Return a check that a value is one of the words of an enumeration."""

    def check(value: Any) -> StrEnum:
        try:
            return kind(value)
        except ValueError:
            raise ValueError(", ".join(kind)) from None

    return check


def writable(*suffixes: str, replays: bool = False) -> Callable[[Any], Any]:
    """Return a callback that, before the command runs, refuses files that cannot be written.

    Args:
        suffixes: suffixes that are allowed.
        replays: allow the suffixes of replays too.
    """

    def check(given: list[Path] | Path | None) -> Any:
        for target in [given] if isinstance(given, Path) else given or ():
            allowed = suffixes
            if replays:
                from warehouse_core.viz.export import FORMATS, ffmpeg

                allowed = *FORMATS, *suffixes
            if check_suffix(target, allowed) == ".mp4":
                ffmpeg()  # if it is missing, fail here and not after the episode
            check_target(target)
        return given

    return check


MAY_BE_REPEATED = "May be repeated."

AGENT = (
    "Name of the agent: random, reflex, model, goal, utility, greedy, exploring, bfs, ucs, astar, "
    "weighted-astar, greedy-best-first, clone:FILE, ppo:FILE, q:FILE, or your own as file.py or "
    "file.py:Class. Arguments may follow the name, as in greedy:memory=20."
)
AgentOption = Annotated[str, option("--agent NAME", AGENT)]

LAYOUT = f"Layout of the warehouse: a file, or one of {', '.join(NAMES)}."
FleetLayout = Annotated[Path, option("--layout FILE", LAYOUT)]
LayoutOption = Annotated[
    Path | None, option("--layout FILE", f"{LAYOUT} Default: default, the layout of the chapter.")
]

StationsOption = Annotated[
    Stations | None,
    option(
        f"--stations {'|'.join(Stations)}",
        "Place pickup and dropoff at random (drawn), or keep the stations of the layout (kept). "
        "Default: kept if the layout is a file with stations, otherwise drawn.",
        one_of(Stations),
        show_default=False,
    ),
]
START = "Start cell."
Start = Annotated[str | None, option("--start ROW,COL", f"{START} Default: a random one.")]

SEED = "Random seed."
Seed = Annotated[int, option("--seed N", SEED, Whole(0, MAX_SEED))]
SeedOption = Annotated[
    int | None, option("--seed N", f"{SEED} Default: a random one.", Whole(0, MAX_SEED))
]
MAX_EPISODES = 100_000
EPISODES = "Number of episodes, with successive seeds."
Episodes = Annotated[int, option("--episodes -n N", EPISODES, Whole(1, MAX_EPISODES))]
BatteryOption = Annotated[int, parameter_option("battery")]
MaxSteps = Annotated[int, parameter_option("max_steps")]
ViewRadius = Annotated[int, parameter_option("view_radius")]

BACKEND = (
    "Name of the motion backend. Allowed: grid, physics, {}or your own as file.py:Class. Settings "
    "of the robot and disturbances may follow, as in physics:top_speed=2,noise=0.1,grip=0.05."
)
InstalledBackend = Annotated[
    str,
    option(
        "--backend NAME",
        "Name of the motion backend. Allowed: grid, physics, or another one that is installed.",
    ),
]
DRIVES = "driving (a body drives the path of a finished episode in one go), "
CONTROL = "drive (continuous control, which drives an agent's moves), "
BackendOption = Annotated[str, option("--backend NAME", BACKEND.format(""))]
RunBackend = Annotated[str, option("--backend NAME", BACKEND.format(f"{DRIVES}{CONTROL}"))]
PlayBackend = Annotated[
    str,
    option("--backend NAME", BACKEND.format("drive (held keys steer a body in real time), ")),
]
FleetBackend = Annotated[
    str,
    option(
        "--backend NAME",
        BACKEND.format("driving (robots follow a plan without stopping in each cell), "),
    ),
]

SlipperyOption = Annotated[
    list[str],
    option(
        "--slippery ROW,COL",
        f"Cell with slippery floor, for backends with bodies. {MAY_BE_REPEATED} Its grip follows "
        "the name of the backend, as in physics:grip=0.05, which alone is for the whole floor.",
        **MANY,
    ),
]

MOVES = "How robots move. compass: N, E, S or W; turn: forward, with turns on the spot."
ROBOTS = PARAMETERS["robots"].help
RobotsOption = Annotated[int, parameter_option("robots", "-r N")]
PLANNER = f"Name of the planner: {', '.join(PLANNERS)}, or your own as file.py:Class."
AssignmentOption = Annotated[str | None, option("--assignment NAME", PARAMETERS["assignment"].help)]
PLAN_SECONDS = (
    "Limit on the seconds of a plan, or of a step of a plan. After this time planning is stopped, "
    "and all robots wait."
)
PlanSeconds = Annotated[float, option("--plan-seconds S", PLAN_SECONDS, Number(0.001, MAX_VALUE))]
OrderRate = Annotated[float, parameter_option("order_rate", "X")]
FleetBattery = Annotated[
    str,
    option(
        "--battery N",
        f"{PARAMETERS['battery'].help} For a capacity in joules, append the unit: 30000joules.",
    ),
]

SAVE = "Save to this file."
REPLAY = f"{SAVE} A replay is saved as .gif, .mp4, .html, .svg or .png"
Save = Annotated[
    list[Path],
    option(
        "--save -o FILE",
        f"{REPLAY}, a record as .npz. {MAY_BE_REPEATED}",
        callback=writable(RECORD_SUFFIX, replays=True),
        **MANY,
    ),
]
SaveReplay = Annotated[
    list[Path],
    option(
        "--save -o FILE",
        f"{REPLAY}. {MAY_BE_REPEATED}",
        callback=writable(replays=True),
        **MANY,
    ),
]
Show = Annotated[
    bool | None,
    option(
        "--show/--no-show", "Show the replay in a window. Default: yes, unless --save is given."
    ),
]
Speed = Annotated[
    float,
    option(
        "--speed X",
        "Speed of the replay as a multiple of the default, from 0.01 to 100.",
        Number(0.01, 100),
    ),
]
Jobs = Annotated[
    int | None,
    option("--jobs -j N", "Number of processes. Default: one for each processor.", Whole(1, 1024)),
]
