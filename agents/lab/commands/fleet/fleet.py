"""The command ``warehouse fleet``: a shift of several robots, and its measures."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Sequence
from contextlib import closing
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from agents.errors import EpisodeError, EpisodeInterrupted
from agents.fleet.plan_log import PlanLog
from agents.fleet.planned import PLAN_SECONDS, PlannedFleet, check_headings, wants_dispatch
from agents.lab.commands.fleet.report import ShiftResult, report_shifts, result_of
from agents.lab.commands.fleet.values import SUFFIX, write_shifts
from agents.lab.console import options
from agents.lab.console.options import MANY, option, parameter_option, writable
from agents.lab.console.output import replay_or_save
from agents.lab.console.terminal import say, warnings_printed
from agents.lab.console.values import parse_battery, parse_due
from agents.lab.console.watch import slow_steps_told
from agents.lab.parameters import Number, usual
from agents.lab.runs.run import draw_seed, run
from agents.registry import PLANNERS, make_backend, make_fleet_agent, make_team
from warehouse_core import Episode, FleetEnv, OrderStream, WarehouseError
from warehouse_core.extras import install_command
from warehouse_core.orders import load_orders
from warehouse_core.orders.order import Orders
from warehouse_core.records.recorder import FleetAgent
from warehouse_core.wording import counted
from warehouse_core.world.moves import COMPASS, TURN
from warehouse_core.world.named_layouts import DEPOT, find_layout

RATE, DUE = usual("order_rate"), usual("due")

MANY_ROBOTS = 100
"""Robots from which on compiled planners are worth their installation."""


def find_orders(file: Path | None, rate: float | None, due: str | None) -> Orders:
    """Return the orders in a file, or orders that arrive at a rate with some due times."""
    if file is None:
        return OrderStream(RATE if rate is None else rate, parse_due(due or DUE))
    for option_name, value in (("--order-rate", rate), ("--due", due)):
        if value is not None:
            raise typer.BadParameter(f"{option_name} does not go with --orders, which has them")
    if file.suffix.lower() != ".csv":
        raise typer.BadParameter(f"{file}: unknown format of orders; allowed: .csv")
    return load_orders(file)


def parse_robots(text: str | None, robots: int) -> list[int]:
    """Return the numbers of robots in a text such as ``0,3``; of ``None`` none."""
    numbers = [] if text is None else text.split(",")
    if not all(re.fullmatch(r"[0-9]{1,9}", each) and int(each) < robots for each in numbers):
        raise typer.BadParameter(
            f"--show-plans is {text!r}; it must be numbers of robots, 0..{robots - 1}, as in 0,3"
        )
    return [int(each) for each in numbers]


def fleet(
    robots: options.RobotsOption = 8,
    order_rate: Annotated[
        float | None, parameter_option("order_rate", "X", f"Default: {RATE}.")
    ] = None,
    orders: Annotated[
        Path | None, option("--orders FILE", "Read the orders from a .csv file.")
    ] = None,
    due: Annotated[str | None, parameter_option("due", "FEWEST:MOST", f"Default: {DUE}.")] = None,
    agent: options.AgentOption = "greedy",
    planner: Annotated[
        str | None,
        option(
            "--planner NAME",
            f"{options.PLANNER} It directs all robots, instead of --agent.",
        ),
    ] = None,
    assignment: options.AssignmentOption = None,
    plan_seconds: options.PlanSeconds = PLAN_SECONDS,
    goes_on: Annotated[
        bool,
        option("--go-on", "Let all robots wait for a step when a planner fails. Default: stop."),
    ] = False,
    show_plans: Annotated[
        str | None,
        option(
            "--show-plans ROBOTS",
            "Draw the plans of these robots of a planner ahead of them, as in 0,3.",
        ),
    ] = None,
    show_pushes: Annotated[
        bool, option("--show-pushes", "Draw which robot pushes which, of a planner by PIBT.")
    ] = False,
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
    late_penalty: Annotated[
        float,
        option(
            "--late-penalty X",
            "Reward taken away for each step by which a delivery is late.",
            Number(0),
        ),
    ] = 0.0,
    backend: options.FleetBackend = "grid",
    view_radius: options.ViewRadius = 2,
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
    speed: options.Speed = 1.0,
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
    watched = parse_robots(show_plans, robots)
    if planner is None and (watched or show_pushes):
        raise typer.BadParameter(
            "--show-plans and --show-pushes need a planner; add --planner NAME"
        )
    log = PlanLog(watched, show_pushes) if watched or show_pushes else None
    floor, director = find_layout(layout), planner or agent
    make_env = partial(
        FleetEnv,
        floor,
        robots,
        backend=make_backend(backend),
        orders=find_orders(orders, order_rate, due),
        max_steps=max_steps,
        battery=parse_battery(battery),
        view_radius=view_radius,
        people=people,
        late_penalty=late_penalty,
        moves=moves,
    )

    first = draw_seed() if seed is None else seed
    tell_of_numba(planner, robots)

    def run_seed(seed: int) -> Episode:
        directing = (
            make_team(agent, robots, seed, floor)
            if planner is None
            else make_fleet_agent(
                planner,
                assignment,
                seed,
                floor,
                robots,
                seconds=plan_seconds,
                goes_on=goes_on,
                log=log if seed == first else None,
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
        replay_or_save(records[0], replays, show, speed=speed, plans=plans)

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


def tell_of_numba(planner: str | None, robots: int) -> None:
    """Say how to compile a planner of many robots, unless Numba is installed."""
    is_known = planner is not None and planner.partition(":")[0] in PLANNERS
    if is_known and robots >= MANY_ROBOTS and find_spec("numba") is None:
        say(
            f"warehouse: {planner} would plan for {robots} robots several times as fast with "
            f"Numba: {install_command('fast')}",
            error=True,
        )


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
