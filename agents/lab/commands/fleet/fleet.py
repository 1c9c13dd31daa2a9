"""The command ``warehouse fleet``: a shift of several robots, and its measures."""

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
from agents.fleet.plan_log import PlanLog
from agents.fleet.planned import PlannedFleet, check_headings, wants_dispatch
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
from agents.lab.console.values import parse_battery, parse_due
from agents.lab.console.watch import slow_steps_told
from agents.lab.parameters import usual
from agents.lab.runs.run import draw_seed, run
from agents.registry import make_backend, make_fleet_agent, make_team
from warehouse_core import Episode, FleetEnv, OrderStream, WarehouseError
from warehouse_core.orders import load_orders
from warehouse_core.orders.order import Orders
from warehouse_core.records.recorder import FleetAgent
from warehouse_core.wording import counted
from warehouse_core.world.moves import COMPASS, TURN
from warehouse_core.world.named_layouts import DEPOT, find_layout

RATE, DUE = usual("order_rate"), parse_due(usual("due"))

PUSHES = "pushes"


def find_orders(file: Path | None, rate: float | None) -> Orders:
    """Return the orders in a file, or orders that arrive at a rate."""
    if file is None:
        return OrderStream(RATE if rate is None else rate, DUE)
    if rate is not None:
        raise typer.BadParameter("--order-rate does not go with --orders, which has them")
    if file.suffix.lower() != ".csv":
        raise typer.BadParameter(f"{file}: unknown format of orders; allowed: .csv")
    return load_orders(file)


def parse_plans(text: str | None, robots: int) -> PlanLog | None:
    """Return the log for a text such as ``0,3`` or ``pushes``; ``None`` without a text."""
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
        Path | None, option("--orders FILE", "Read the orders from a .csv file.")
    ] = None,
    agent: options.AgentOption = "greedy",
    planner: Annotated[
        str | None,
        option(
            "--planner NAME",
            f"{options.PLANNER} It directs all robots, instead of --agent.",
        ),
    ] = None,
    assignment: options.AssignmentOption = None,
    show_plans: Annotated[
        str | None,
        option(
            "--show-plans ROBOTS",
            "Draw the plans of these robots of a planner ahead of them, as in 0,3; "
            f"{PUSHES} draws which robot pushes which, of a planner by PIBT.",
        ),
    ] = None,
    optimum: Annotated[
        bool,
        option(
            "--optimum", "Say how many deliveries were possible, which takes seconds to find out."
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
            f"{options.MOVES} turn needs a planner that knows headings: circulation or windowed, "
            "also with -lanes.",
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
            f"{options.REPLAY}, the record as .npz; the orders of all episodes as .csv, with "
            "their measures beside it in FILE-measures.csv; may be repeated.",
            callback=writable(options.RECORD_SUFFIX, SUFFIX, replays=True),
            **MANY,
        ),
    ],
    show: options.Show = None,
) -> None:
    """Run a shift of robots and replay it.

    Each robot is directed by the agent, its goal given by its order. A robot
    whose battery is low drives to a charger. With --planner, a planner leads
    all robots, and orders and chargers are assigned to them.

    Of several episodes the means are printed, and the first is replayed. The
    page of a replay, .html, has a map of where robots were held up.

    Example: warehouse fleet --robots 12 --order-rate 0.1 --people 3 --seed 12
    """
    if planner is not None and agent != "greedy":
        raise typer.BadParameter("--planner does not go with --agent: it directs all robots")
    if planner is None and assignment is not None:
        raise typer.BadParameter("--assignment needs a planner; add --planner NAME")
    if planner is None and moves == TURN:
        raise typer.BadParameter(
            "--moves turn needs a planner that knows headings; add --planner windowed"
        )
    if planner is None and show_plans is not None:
        raise typer.BadParameter("--show-plans needs a planner; add --planner NAME")
    log = parse_plans(show_plans, robots)
    floor, director = find_layout(layout), planner or agent
    make_env = partial(
        FleetEnv,
        floor,
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
        directing = (
            make_team(agent, robots, seed, floor)
            if planner is None
            else make_fleet_agent(
                planner, assignment, seed, floor, robots, log=log if seed == first else None
            )
        )
        with closing(make_env(dispatch=wants_dispatch(directing))) as env:
            if isinstance(directing, PlannedFleet):
                check_headings(directing.planner, env)
            episode = run(env, directing, seed, slow_steps_told(directing, director), name=director)
        warn_of_lost_steps(directing, seed, director)
        return episode

    title = (
        f"{counted(robots, 'robot')} ({director}) on layout {layout.stem}, backend {backend}, "
        f"{f'seed {first}' if episodes == 1 else f'seeds {first} to {first + episodes - 1}'}"
    )
    results, records = list[ShiftResult](), list[Episode]()

    def keep(episode: Episode) -> None:
        results.append(result_of(episode, optimum))
        if not records:  # all of them would take much memory
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


def warn_of_lost_steps(agent: FleetAgent, seed: int, name: str) -> None:
    """Warn of the steps of a ``PlannedFleet`` in which all robots waited for a plan."""
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
