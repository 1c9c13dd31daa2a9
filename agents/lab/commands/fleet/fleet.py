"""The command ``warehouse fleet``: shifts of several robots, their measures and a replay."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from agents.errors import EpisodeError, EpisodeInterrupted
from agents.fleet.guided import Choice
from agents.fleet.planned import PlanLog, PlannedFleet, check_headings, wants_dispatch
from agents.lab.commands.fleet.report import (
    SUFFIX,
    ShiftResult,
    report_shifts,
    result_of,
    write_shifts,
)
from agents.lab.console import options
from agents.lab.console.options import MANY, option, parameter_option, writable
from agents.lab.console.output import replay_or_save
from agents.lab.console.terminal import say, warnings_printed
from agents.lab.console.values import parse_battery
from agents.lab.console.watch import slow_steps_reported
from agents.lab.parameters import default_value, pair_of
from agents.lab.runs.run import draw_seed, run
from agents.registry import make_backend, make_fleet_agent, make_team
from warehouse_core import Episode, FleetEnv, OrderStream, WarehouseError
from warehouse_core.orders import load_orders
from warehouse_core.orders.order import Orders
from warehouse_core.records.recorder import FleetAgent
from warehouse_core.wording import counted
from warehouse_core.world.moves import COMPASS, TURN
from warehouse_core.world.named_layouts import DEPOT, find_layout

RATE, DUE = default_value("order_rate"), pair_of(default_value("due"))

PUSHES, AUTO = "pushes", "auto"


def find_orders(file: Path | None, rate: float | None) -> Orders:
    """Return the orders in a file, or random orders that arrive at a rate."""
    if file is None:
        return OrderStream(RATE if rate is None else rate, DUE)
    if rate is not None:
        raise typer.BadParameter("--order-rate cannot be combined with --orders, which lists them")
    if file.suffix.lower() != ".csv":
        raise typer.BadParameter(f"{file}: orders cannot be read from this format; allowed: .csv")
    return load_orders(file)


def parse_plans(text: str | None, robots: int) -> PlanLog | None:
    """Return the log of plans for a text such as ``0,3`` or ``pushes``; ``None`` for ``None``."""
    if text is None:
        return None
    words = text.split(",")
    numbers = [word for word in words if word != PUSHES]
    if not all(re.fullmatch(r"[0-9]{1,9}", each) and int(each) < robots for each in numbers):
        raise typer.BadParameter(
            f"--show-plans is {text!r}; it must be numbers of robots, 0..{robots - 1}, as in 0,3, "
            f"or {PUSHES}"
        )
    return PlanLog([int(each) for each in numbers], PUSHES in words)


def fleet(
    robots: options.RobotsOption = 8,
    order_rate: Annotated[
        float | None, parameter_option("order_rate", "X", f"Default: {RATE}.")
    ] = None,
    orders: Annotated[
        Path | None, option("--orders FILE", "Read the orders from this .csv file.")
    ] = None,
    agent: Annotated[
        str | None,
        option("--agent NAME", f"{options.AGENT} Each robot gets one, and no planner moves them."),
    ] = None,
    planner: Annotated[
        str | None,
        option("--planner NAME", f"{options.PLANNER} It plans for all robots. Default: {AUTO}."),
    ] = None,
    assignment: options.AssignmentOption = None,
    show_plans: Annotated[
        str | None,
        option(
            "--show-plans ROBOTS",
            "Draw the planned paths of these robots, as in 0,3. For "
            f"'{PUSHES}': draw arrows from robots that push others, with --planner pibt.",
        ),
    ] = None,
    optimum: Annotated[
        bool,
        option(
            "--optimum",
            "Print how many deliveries were possible. The calculation takes some seconds.",
        ),
    ] = False,
    layout: options.FleetLayout = Path(DEPOT),
    max_steps: options.MaxSteps = 1000,
    battery: options.FleetBattery = "400steps",
    people: Annotated[int, parameter_option("people")] = 0,
    moves: Annotated[
        str,
        option(
            "--moves NAME",
            f"{options.MOVES} turn needs a planner that knows headings: auto, circulation or "
            "windowed.",
        ),
    ] = COMPASS,
    backend: options.FleetBackend = "grid",
    episodes: options.Episodes = 1,
    seed: options.SeedOption = None,
    *,
    save: Annotated[
        list[Path],
        option(
            "--save -o FILE",
            f"{options.REPLAY}, a record as .npz, and the orders of all episodes as .csv, next to "
            f"their measures in FILE-measures.csv. {options.MAY_BE_REPEATED}",
            callback=writable(options.RECORD_SUFFIX, SUFFIX, replays=True),
            **MANY,
        ),
    ],
    show: options.Show = None,
) -> None:
    """Run shifts of robots and replay one.

    A planner moves all robots, and orders and chargers are assigned to them.
    The planner auto is chosen for the layout and the number of robots. With
    --agent, each robot has an agent of its own, which takes it to the goals
    of its order. A robot whose battery is low drives to a charger.

    For several episodes, the means are printed and the first is replayed. A
    page (--save x.html) has a map of where robots were held up.

    Example: warehouse fleet --robots 12 --order-rate 0.1 --people 3 --seed 12
    """
    if agent is None:
        planner = planner or AUTO
    elif planner is not None:
        raise typer.BadParameter(
            "--planner cannot be combined with --agent: it plans for all robots"
        )
    for what, is_given in (
        ("--assignment", assignment is not None),
        ("--moves turn", moves == TURN),
        ("--show-plans", show_plans is not None),
    ):
        if agent is not None and is_given:
            raise typer.BadParameter(f"{what} needs a planner; leave out --agent")
    log = parse_plans(show_plans, robots)
    grid, name = find_layout(layout), agent or planner or AUTO
    make_env = partial(
        FleetEnv,
        grid,
        robots,
        backend=make_backend(backend),
        orders=find_orders(orders, order_rate),
        max_steps=max_steps,
        battery=parse_battery(battery),
        people=people,
        moves=moves,
    )

    first = draw_seed() if seed is None else seed

    def run_seed(seed: int) -> Episode:
        controller = (
            make_team(name, robots, seed, grid)
            if agent is not None
            else make_fleet_agent(
                name, assignment, seed, grid, robots, moves, log=log if seed == first else None
            )
        )
        if seed == first and isinstance(controller, PlannedFleet):
            say_choice(controller)
        with closing(make_env(dispatch=wants_dispatch(controller))) as env:
            if isinstance(controller, PlannedFleet):
                check_headings(controller.planner, env)
            episode = run(env, controller, seed, slow_steps_reported(controller, name), name=name)
        warn_of_lost_steps(controller, seed, name)
        return episode

    title = (
        f"{counted(robots, 'robot')} ({name}) on layout {layout.stem}, backend {backend}, "
        f"{f'seed {first}' if episodes == 1 else f'seeds {first} to {first + episodes - 1}'}"
    )
    results, records = list[ShiftResult](), list[Episode]()

    def keep(episode: Episode) -> None:
        results.append(result_of(episode, optimum))
        if not records:  # to keep all of them would take much memory
            records.append(episode)

    def finish(show: bool | None, note: str = "") -> None:
        report_shifts(results, robots, title + note)
        tables = [path for path in save if path.suffix.lower() == SUFFIX]
        for path in tables:
            say(f"saved {path} and {write_shifts(path, results)}")
        replays, plans = [path for path in save if path not in tables], log.plans if log else ()
        show = bool(show) if tables else show
        replay_or_save(records[0], replays, show, plans=plans)

    try:
        with warnings_printed():
            for each in tracked(range(first, first + episodes)):
                keep(run_seed(each))
    except (EpisodeError, EpisodeInterrupted) as error:
        is_interrupted = isinstance(error, EpisodeInterrupted)
        keep(error.episode)
        finish(False if is_interrupted else show, ", not finished")
        if is_interrupted:
            raise typer.Abort from error
        raise
    except WarehouseError:
        raise
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    finish(show)


def say_choice(agent: PlannedFleet) -> None:
    """Print which planner ``auto`` has chosen, and why."""
    choice = getattr(agent.planner, "choice", None)
    if isinstance(choice, Choice):
        say(f"--planner {AUTO} chose {choice.name}: {choice.reason}.")


def warn_of_lost_steps(agent: FleetAgent, seed: int, name: str) -> None:
    """Warn of steps in which all robots of a ``PlannedFleet`` waited because planning failed."""
    lost = agent.lost if isinstance(agent, PlannedFleet) else []
    if lost:
        step, reason = lost[0]
        more = f"; {counted(len(lost) - 1, 'more step')} lost" if len(lost) > 1 else ""
        warnings.warn(
            f"seed {seed}, step {step}, planner {name}: {reason}; all robots waited{more}",
            stacklevel=2,
        )


def tracked(seeds: Sequence[int]) -> Iterable[int]:
    """Return the seeds, with a progress bar if there are several."""
    if len(seeds) == 1:
        return seeds
    from agents.lab.console.progress import track

    return track(seeds, "shifts")
