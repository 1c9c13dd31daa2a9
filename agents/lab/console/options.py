"""The options that several commands share."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any

import typer

from agents.lab.parameters import MAX_VALUE, PARAMETERS, Whole
from agents.lab.place import (
    Place,
    Stations,
    check_stations,
    usual_stations,
    what_to_draw,
)
from warehouse_core import DEFAULT_LAYOUT, Cell, Layout
from warehouse_core.files.atomic import check_suffix, check_target
from warehouse_core.world.layout import check_open
from warehouse_core.world.named_layouts import NAMES, find_layout

MAX_COUNT = MAX_VALUE

RECORD_SUFFIX = ".npz"


def number_option(name: str, *flags: str) -> Any:
    """Return the option of a parameter that is a whole number, with its range and its help.

    Args:
        name: name of the parameter.
        flags: short names of the option.
    """
    parameter = PARAMETERS[name]
    assert isinstance(parameter.check, Whole), "the option of a whole number"
    least, most = parameter.check.minimum, parameter.check.maximum
    flag = f"--{name.replace('_', '-')}"
    return typer.Option(flag, *flags, metavar="N", min=least, max=most, help=parameter.help)


def save_option(help_text: str, *suffixes: str, pictures: bool = False) -> Any:
    """Return an option for files to write.

    Args:
        help_text: description of the option.
        suffixes: suffixes that are allowed.
        pictures: allow the suffixes of pictures too.
    """

    def check(targets: list[Path]) -> list[Path]:
        """Raise ``FormatError`` or ``OSError`` if a file cannot be written."""
        for target in targets:
            allowed = suffixes
            if pictures:
                from warehouse_core.viz.export import FORMATS, ffmpeg

                allowed = *FORMATS, *suffixes
            if check_suffix(target, allowed) == ".mp4":
                ffmpeg()  # what it needs is missed here, and not after the episode
            check_target(target)
        return targets

    return typer.Option(
        "--save",
        metavar="FILE",
        help=help_text,
        default_factory=list,
        show_default=False,
        callback=check,
    )


AgentOption = Annotated[
    str,
    typer.Option(
        "--agent",
        metavar="NAME",
        help="The agent: random, reflex, greedy, exploring, bfs, ucs, astar, weighted-astar, "
        "greedy-best-first, ppo:FILE, q:FILE, or your own as file.py:Class; arguments may follow "
        "as in greedy:memory=20,escape_steps=0 or ppo:FILE:revisit=4.",
    ),
]

MemoryOption = Annotated[int | None, number_option("memory")]

EscapeOption = Annotated[
    bool | None,
    typer.Option("--escape/--no-escape", help="Whether the greedy agent escapes from loops: yes."),
]

LAYOUT_HELP = (
    "Layout file (rows of # . P D C, or a MovingAI .map), or a name: "
    f"{', '.join(NAMES)}. Default: that of the chapter."
)

LayoutOption = Annotated[Path | None, typer.Option("--layout", metavar="FILE", help=LAYOUT_HELP)]

StationsOption = Annotated[
    Stations | None,
    typer.Option(
        "--stations",
        help="Draw pickup and dropoff, or keep those of the layout. "
        "Default: kept in a file that has any, drawn otherwise.",
        show_default=False,
    ),
]

StartOption = Annotated[
    str | None,
    typer.Option("--start", metavar="ROW,COL", help="Start cell. Default: a random one."),
]

SeedOption = Annotated[
    int | None, typer.Option("--seed", metavar="N", help="Random seed. Default: a random one.")
]

BatteryOption = Annotated[int, number_option("battery")]

MaxStepsOption = Annotated[int, number_option("max_steps")]

ViewRadiusOption = Annotated[int, number_option("view_radius")]

BackendOption = Annotated[
    str,
    typer.Option(
        "--backend",
        metavar="NAME",
        help="Motion backend: grid, physics, for fleets driving (through cells as a plan says), or "
        "one of your own; numbers of the robot may follow as in physics:top_speed=2,mass=70.",
    ),
]

SaveOption = Annotated[
    list[Path],
    save_option(
        "Write the replay as .gif, .mp4, .html, .svg or .png, or the record as .npz; "
        "may be given more than once.",
        RECORD_SUFFIX,
        pictures=True,
    ),
]

SaveReplayOption = Annotated[
    list[Path],
    save_option(
        "Write the replay as .gif, .mp4, .html, .svg or .png; may be given more than once.",
        pictures=True,
    ),
]

ShowOption = Annotated[
    bool | None,
    typer.Option(
        "--show/--no-show",
        help="Open a window, or do not. Default: open one if nothing is saved.",
    ),
]

JobsOption = Annotated[
    int | None,
    typer.Option(
        "--jobs",
        "-j",
        metavar="N",
        min=1,
        max=64,
        help="Processes. Default: one for each processor.",
    ),
]

IntervalOption = Annotated[
    float,
    typer.Option("--interval-ms", min=1, max=60_000, help="Milliseconds between frames."),
]

SpeedOption = Annotated[
    float, typer.Option("--speed", min=0.01, max=100, help="Factor on the playing speed.")
]

TrainingStepsOption = Annotated[
    int, typer.Option("--steps", metavar="N", min=1, max=MAX_COUNT, help="Minimum training steps.")
]

TrainedRobotsOption = Annotated[
    int,
    typer.Option("--robots", metavar="R", min=1, max=1000, help="Robots of a fleet, with orders."),
]

OrderRateOption = Annotated[
    float,
    typer.Option("--orders", metavar="RATE", help="Mean number of orders of a fleet in a step."),
]

TrainingSeedOption = Annotated[
    int, typer.Option("--seed", metavar="N", min=0, max=2**32 - 1, help="Random seed.")
]

ModelOption = Annotated[
    Path, typer.Option("--output", "-o", metavar="FILE", help="Write the agent to this .npz file.")
]


def load_layout(path: Path | None) -> Layout:
    """Return the layout in a file or of a name, or the chapter's without one."""
    return DEFAULT_LAYOUT if path is None else find_layout(path)


def load_place(path: Path | None, stations: Stations | None, start: str | None) -> Place:
    """Return where episodes take place, from the options of a command.

    Args:
        path: file of the layout, or its name; ``None`` is the chapter's.
        stations: ``None`` keeps the stations of a file that has any, and draws them otherwise.
        start: ``ROW,COL``, or ``None`` to draw it.

    Raises:
        LayoutError: a bad layout, a start that is not open, or no station of a kind to be kept.
        typer.BadParameter: ``start`` is no cell.
    """
    layout, cell = load_layout(path), parse_cell(start, "--start")
    if cell is not None:
        check_open(layout, cell, "--start")
    chosen = stations or usual_stations(layout, is_default=layout is DEFAULT_LAYOUT)
    check_stations(layout, chosen, path, "--stations drawn")
    return Place(layout, cell, what_to_draw(chosen, cell))


def greedy_with(agent: str, memory: int | None, escape: bool | None) -> str:
    """Return the name of an agent with what the options say of its memory and its escape.

    Raises:
        typer.BadParameter: they are given, and the agent has neither.
    """
    arguments = [] if memory is None else [f"memory={memory}"]
    arguments += ["escape_steps=0"] if escape is False else []
    name, colon, _ = agent.partition(":")
    if name != "greedy" and (memory is not None or escape is not None):
        raise typer.BadParameter(f"--memory and --escape are of agent greedy, not of {agent!r}")
    return f"{agent}{',' if colon else ':'}{','.join(arguments)}" if arguments else agent


def parse_cell(text: str | None, option: str) -> Cell | None:
    """Return the cell in a text ``ROW,COL``, or ``None`` without a text.

    Raises:
        typer.BadParameter: the text is not of that form.
    """
    if text is None:
        return None
    found = re.fullmatch(r"\s*(-?[0-9]{1,9})\s*,\s*(-?[0-9]{1,9})\s*", text)
    if found is None:
        raise typer.BadParameter(f"{option} is {text!r}; it must be ROW,COL as in 1,2")
    return int(found[1]), int(found[2])
