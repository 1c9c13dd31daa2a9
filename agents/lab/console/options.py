"""The options of commands: how one is declared, and those that several commands share."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from agents.lab import place
from agents.lab.parameters import MAX_VALUE, PARAMETERS, Whole
from warehouse_core.files.atomic import check_suffix, check_target
from warehouse_core.world.named_layouts import NAMES

MAX_COUNT = MAX_VALUE

RECORD_SUFFIX = ".npz"

PICTURES = (".svg", ".png")
"""Suffixes of pictures that do not move."""

MANY: dict[str, Any] = {"default_factory": list, "show_default": False}
"""Settings of an option that may be given more than once, or not at all."""


def option(
    words: str,
    help_text: str,
    limits: tuple[float | None, float | None] = (None, None),
    **settings: Any,
) -> Any:
    """Return an option.

    Args:
        words: names of the option and its metavar, as in ``"--count -c N"``.
        help_text: description.
        limits: least and greatest value of a number.
        settings: further arguments of ``typer.Option``.
    """
    names = [word for word in words.split() if word.startswith("-")]
    metavar = words.split()[-1] if len(names) < len(words.split()) else None
    least, most = limits
    return typer.Option(*names, metavar=metavar, min=least, max=most, help=help_text, **settings)


def number_option(name: str, short: str = "") -> Any:
    """Return the option of a parameter that is a whole number, with its range and its help."""
    parameter = PARAMETERS[name]
    assert isinstance(parameter.check, Whole), "the option of a whole number"
    words = f"--{name.replace('_', '-')} {short} N"
    return option(words, parameter.help, (parameter.check.minimum, parameter.check.maximum))


def seconds_option(name: str, help_text: str, most: float = math.inf) -> Any:
    """Return an option for a time above 0."""

    def check(seconds: float) -> float:
        if not 0 < seconds <= most:
            raise typer.BadParameter(f"{name} is {seconds:g}; it must be above 0 s")
        return seconds

    return option(f"{name} S", help_text, callback=check)


def writable(*suffixes: str, replays: bool = False) -> Callable[[Any], Any]:
    """Return a callback that refuses a file that cannot be written before the command runs.

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
                ffmpeg()  # what it needs is missed here, and not after the episode
            check_target(target)
        return given

    return check


AgentOption = Annotated[
    str,
    option(
        "--agent NAME",
        "The agent: random, reflex, greedy, exploring, bfs, ucs, astar, weighted-astar, "
        "greedy-best-first, ppo:FILE, q:FILE, or your own as file.py:Class; arguments may follow "
        "as in greedy:memory=20,escape_steps=0 or ppo:FILE:revisit=4.",
    ),
]
Memory = Annotated[int | None, number_option("memory")]
Escape = Annotated[
    bool | None, option("--escape/--no-escape", "Whether the greedy agent escapes from loops: yes.")
]

LAYOUTS = f"Layout file (rows of # . P D C, or a MovingAI .map), or a name: {', '.join(NAMES)}."
LAYOUT = f"{LAYOUTS} Default: that of the chapter."
FleetLayout = Annotated[Path, option("--layout FILE", LAYOUTS)]
LayoutOption = Annotated[Path | None, option("--layout FILE", LAYOUT)]

StationsOption = Annotated[
    place.Stations | None,
    option(
        "--stations",
        "Draw pickup and dropoff, or keep those of the layout. "
        "Default: kept in a file that has any, drawn otherwise.",
        show_default=False,
    ),
]
Start = Annotated[str | None, option("--start ROW,COL", "Start cell. Default: a random one.")]
SeedOption = Annotated[int | None, option("--seed N", "Random seed. Default: a random one.")]
FirstSeed = Annotated[int, option("--seed N", "Seed of the first run or episode.", (0, None))]
BatteryOption = Annotated[int, number_option("battery")]
MaxSteps = Annotated[int, number_option("max_steps")]
ViewRadius = Annotated[int, number_option("view_radius")]
BackendOption = Annotated[
    str,
    option(
        "--backend NAME",
        "Motion backend: grid, physics, for fleets driving (through cells as a plan says), or your "
        "own as file.py:Class; numbers of the robot may follow as in physics:top_speed=2,mass=70.",
    ),
]

RobotsOption = Annotated[int, number_option("robots", "-r")]
AssignmentOption = Annotated[str | None, option("--assignment NAME", PARAMETERS["assignment"].help)]
PlanSeconds = Annotated[
    float,
    seconds_option(
        "--plan-seconds", "A plan of a step that takes longer is cut off, and all robots wait."
    ),
]
FleetBattery = Annotated[
    str,
    option("--battery N[UNIT]", "A full battery, in steps or joules: 400steps or 30000joules."),
]

REPLAY = "Write the replay as .gif, .mp4, .html, .svg or .png"
Save = Annotated[
    list[Path],
    option(
        "--save FILE",
        f"{REPLAY}, or the record as .npz; may be given more than once.",
        callback=writable(RECORD_SUFFIX, replays=True),
        **MANY,
    ),
]
SaveReplay = Annotated[
    list[Path],
    option(
        "--save FILE",
        f"{REPLAY}; may be given more than once.",
        callback=writable(replays=True),
        **MANY,
    ),
]
SaveFigure = Annotated[
    Path | None,
    option("--save FILE", "Write the figure, .svg or .png.", callback=writable(*PICTURES)),
]
Show = Annotated[
    bool | None,
    option("--show/--no-show", "Open a window, or do not. Default: open one if nothing is saved."),
]
Speed = Annotated[float, option("--speed", "Factor on the playing speed.", (0.01, 100))]
Jobs = Annotated[
    int | None, option("--jobs -j N", "Processes. Default: one for each processor.", (1, 64))
]
