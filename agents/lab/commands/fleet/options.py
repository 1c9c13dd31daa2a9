"""What the commands that run fleets share: options, and how their texts are read."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from agents.lab.console.options import number_option
from agents.lab.parameters import PARAMETERS
from warehouse_core.arguments import MAX_STEPS
from warehouse_core.batch.fleet.battery import JOULES, STEPS
from warehouse_core.fleet import Battery
from warehouse_core.world.named_layouts import NAMES

RobotsOption = Annotated[int, number_option("robots", "-r")]

AssignmentOption = Annotated[
    str | None,
    typer.Option("--assignment", metavar="NAME", help=PARAMETERS["assignment"].help),
]

PlanSecondsOption = Annotated[
    float,
    typer.Option(
        "--plan-seconds",
        metavar="S",
        help="A plan of a step that takes longer is cut off, and all robots wait.",
    ),
]

FleetLayoutOption = Annotated[
    Path,
    typer.Option(
        "--layout",
        metavar="FILE",
        help=f"Layout file (rows of # . P D C, or a MovingAI .map), or a name: {', '.join(NAMES)}.",
    ),
]

FleetBatteryOption = Annotated[
    str,
    typer.Option(
        "--battery",
        metavar="N[UNIT]",
        help="A full battery, in steps or joules, as in 400steps or 30000joules.",
    ),
]

DUE = 50, 150
"""Steps from release to due time of an order, at least and at most."""


def parse_due(text: str | None, usual: tuple[int, int] = DUE, unit: str = STEPS) -> tuple[int, int]:
    """Return the fewest and most steps, or seconds, in a text ``FEWEST:MOST``.

    Args:
        text: value of ``--due``.
        usual: times without a text.
        unit: unit of both times.

    Raises:
        typer.BadParameter: the text is not of that form, or they are out of order.
    """
    if text is None:
        return usual
    found = re.fullmatch(r"([0-9]{1,9}):([0-9]{1,9})", text)
    fewest, most = map(int, found.groups()) if found else (1, 0)
    if fewest > most:
        raise typer.BadParameter(
            f"--due is {text!r}; it must be FEWEST:MOST {unit} from release to due time, as in "
            f"{usual[0]}:{usual[1]}"
        )
    return fewest, most


def parse_battery(text: str) -> Battery:
    """Return the battery in a text such as ``400``, ``400steps`` or ``20000joules``.

    Raises:
        typer.BadParameter: the text is not of that form, or out of range.
    """
    found = re.fullmatch(rf"([0-9]{{1,12}}) ?({STEPS}|{JOULES})?", text)
    if found is None or not 1 <= int(found[1]) <= MAX_STEPS:
        raise typer.BadParameter(
            f"--battery is {text!r}; it must be 1..{MAX_STEPS} steps or joules, as in 400steps"
        )
    return Battery(int(found[1]), found[2] or STEPS)
