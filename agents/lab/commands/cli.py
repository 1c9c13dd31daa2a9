"""The command ``warehouse``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agents.lab.commands import layout as layout_commands
from agents.lab.commands.compare_agents import compare_agents
from agents.lab.commands.compare_backends import compare
from agents.lab.commands.demos import demo
from agents.lab.commands.explore import explore
from agents.lab.commands.export.export import export
from agents.lab.commands.fleet.fleet import fleet
from agents.lab.commands.fleet.report import report_fleet
from agents.lab.commands.gap.gap import gap
from agents.lab.commands.grade.grade import grade
from agents.lab.commands.planners.compare_planners import compare_planners
from agents.lab.commands.planners.mapf import mapf
from agents.lab.commands.play import play
from agents.lab.commands.run import report_episode, run
from agents.lab.commands.search import search
from agents.lab.commands.train import train_ppo, train_q
from agents.lab.console import main as console
from agents.lab.console import options
from agents.lab.console.output import replay_or_save
from agents.lab.console.terminal import say
from agents.lab.experiments.sweep import sweep
from agents.lab.reports.report import report
from warehouse_core import Episode
from warehouse_core.viz.tracks.track import INTERVAL_MS

app = console.application(
    name="warehouse",
    help="A grid warehouse for rational agents, with a motion backend you can swap.",
    no_args_is_help=True,
)
app.command()(run)
app.command()(play)
app.command()(fleet)
app.command()(gap)
app.command()(mapf)
app.command()(compare_planners)
app.command()(compare)
app.command()(compare_agents)
app.command()(grade)
app.command()(demo)
app.command()(search)
app.command()(explore)
app.command()(sweep)
app.command()(report)
app.command()(export)
app.add_typer(layout_commands.app, name="layout")

training = typer.Typer(no_args_is_help=True, help="Train an agent by reinforcement learning.")
training.command("ppo")(train_ppo)
training.command("q")(train_q)
app.add_typer(training, name="train")


@app.command()
def replay(
    file: Annotated[Path, typer.Argument(help="An episode saved as .npz.")],
    *,
    save: options.Save,
    show: options.Show = None,
    interval_ms: Annotated[
        float, options.option("--interval-ms", "Milliseconds between frames.", (1, 60_000))
    ] = INTERVAL_MS,
    speed: options.Speed = 1.0,
) -> None:
    """Replay a saved episode.

    Example: warehouse replay episode.npz --speed 2 --save replay.gif
    """
    episode = Episode.load(file)
    if episode.is_fleet:
        report_fleet(episode)
    else:
        report_episode(episode)
    replay_or_save(episode, save, show, interval_ms, speed)


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
    """Take the options before a command."""


def main() -> None:
    """Run the command line."""
    console.main(app)
