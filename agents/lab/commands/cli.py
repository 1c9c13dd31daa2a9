"""The command ``warehouse``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from agents.lab.commands.compare import CompareCommand, compare
from agents.lab.commands.demos import demo
from agents.lab.commands.export import export
from agents.lab.commands.fleet.fleet import fleet
from agents.lab.commands.fleet.report import report_fleet
from agents.lab.commands.grade.grade import grade
from agents.lab.commands.layout import layout
from agents.lab.commands.planners.plan import plan
from agents.lab.commands.play import play
from agents.lab.commands.playground import playground
from agents.lab.commands.race import race
from agents.lab.commands.run import report_episode, run
from agents.lab.commands.train import TrainCommand, train
from agents.lab.console import main as console
from agents.lab.console import options
from agents.lab.console.group import CommandGroup
from agents.lab.console.options import option
from agents.lab.console.output import replay_or_save
from agents.lab.console.terminal import say
from agents.lab.experiments.sweep import NAMES, sweep
from agents.lab.reports.report import report
from agents.registry import make_backend
from warehouse_core import Episode, replay_episode
from warehouse_core.motion import make_motion

RENAMED_COMMANDS = {
    "explore": "warehouse run --agent exploring",
    "search": "warehouse compare search",
    "mapf": "warehouse plan",
    "gap": "warehouse compare backends --robots N",
    "dataset": "warehouse export NAME",
    "league": "warehouse plan --moves turn",
    "pogema": "pytest tests/benchmarks/bench_pogema.py",
    "compare-agents": "warehouse compare agents",
    "compare-planners": "warehouse compare planners",
    "bench": "pytest tests/benchmarks",
}
"""Replacement for each former command."""


class Commands(CommandGroup):
    """The commands of ``warehouse``."""

    renamed = RENAMED_COMMANDS


app = console.application(
    cls=Commands,
    name="warehouse",
    help="Simulate warehouse robots on a grid or with rigid bodies, and compare their agents.",
    no_args_is_help=True,
)


def replay(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="An episode saved as .npz.")],
    backend: Annotated[
        str | None,
        option(
            "--backend NAME",
            "Name of the motion backend. The recorded actions are carried out again on it, as on "
            "physics; with driving, a body drives the recorded path in one go.",
        ),
    ] = None,
    *,
    save: options.Save,
    show: options.Show = None,
    speed: options.Speed = 1.0,
) -> None:
    """Replay a saved episode.

    Example: warehouse replay episode.npz --speed 2 --save replay.gif
    """
    known = None if backend is None else make_backend(backend)
    if known is not None:
        make_motion(known)  # refuses a wrong name before any work
    episode = Episode.load(file)
    if known is not None:
        episode = replay_episode(episode, known)
    if episode.is_fleet:
        report_fleet(episode)
    else:
        report_episode(episode)
    replay_or_save(episode, save, show, speed)


GROUPS: dict[str, dict[str, Callable[..., None]]] = {
    "Start": {
        "run": run,
        "play": play,
        "playground": playground,
        "race": race,
        "demo": demo,
        "replay": replay,
    },
    "Several robots": {
        "fleet": fleet,
        "plan": plan,
    },
    "Study": {
        "compare": compare,
        "train": train,
        "sweep": sweep,
        "report": report,
        "grade": grade,
    },
    "Files": {"layout": layout, "export": export},
}
"""Commands, by the title under which the help lists them."""

CLASSES = {"compare": CompareCommand, "train": TrainCommand}
"""The commands whose help depends on their first argument."""

for title, commands in GROUPS.items():
    for name, command in commands.items():
        epilog = NAMES if command is sweep else None
        kind = CLASSES.get(name)
        text = console.help_of(command)
        app.command(name, cls=kind, help=text, rich_help_panel=title, epilog=epilog)(command)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version  # takes long to import

        say(f"warehouse-lab {version('warehouse-lab')}")
        raise typer.Exit


@app.callback()
def before_a_command(
    show_version: Annotated[
        bool,
        options.option("--version", "Print the version.", callback=_print_version, is_eager=True),
    ] = False,
) -> None:
    """Handle the options before a command."""


def main() -> None:
    """Run the command line."""
    console.main(app)
