"""The command ``warehouse fleet``: a shift of several robots, and its measures."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill
from typing import Annotated, NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray

from agents.console.options import (
    MAX_COUNT,
    AgentOption,
    BackendOption,
    SaveOption,
    SeedOption,
    ShowOption,
    SpeedOption,
    ViewRadiusOption,
)
from agents.console.output import replay_or_save
from agents.console.table import Table, print_table
from agents.console.terminal import print_error, say
from agents.errors import EpisodeError, EpisodeInterrupted
from agents.evaluation.interval import CONFIDENCE, MIN_VALUES, mean_interval
from agents.evaluation.wording import mean, percent
from agents.fleet.shift import run_shift
from agents.registry import make_planner, make_team
from agents.run_episode import draw_seed
from warehouse_core import FleetEnv, FleetEpisode, OrderStream, WarehouseError
from warehouse_core.arguments import whole_number
from warehouse_core.fleet import Battery, FleetMeasures
from warehouse_core.fleet.battery import JOULES, STEPS
from warehouse_core.fleet.settings import MAX_BODIES
from warehouse_core.orders import load_orders
from warehouse_core.orders.order import Orders
from warehouse_core.task.encoding import MAX_STEPS
from warehouse_core.wording import counted
from warehouse_core.world.named_layouts import DEPOT, NAMES, find_layout

MAX_SHIFTS = 1000

RATE, DUE = "0.06", (50, 150)
"""Orders that arrive in a step, and the steps until they are due."""

FEW_WAITING = 2
"""Orders of each robot that may be left at the end of a shift; if more are, it was too slow."""


class Line(NamedTuple):
    """A line of the table of measures."""

    title: str
    name: str
    unit: str
    factor: float = 1.0


LINES = (
    Line("orders", "orders", "items"),
    Line("delivered", "delivered", "items"),
    Line("delivered an hour", "per_hour", "items"),
    Line("on time", "on_time", "% of those delivered", 100.0),
    Line("mean lateness", "mean_lateness", "steps"),
    Line("worst lateness", "worst_lateness", "steps"),
    Line("energy a delivery", "joules_per_delivery", "kJ", 1e-3),
    Line("distance", "distance", "cells"),
    Line("blocked by walls", "blocked_by_wall", "moves"),
    Line("blocked by robots", "blocked_by_robot", "moves"),
    Line("blocked by people", "blocked_by_person", "moves"),
    Line("waits", "waits", "robot steps"),
    Line("charging", "charging", "robot steps"),
    Line("stranded", "stranded", "robots with an empty battery"),
    Line("simulated time", "seconds", "s"),
)
"""The measures of a shift, see ``FleetMeasures``."""


def parse_orders(text: str, due: str | None) -> Orders:
    """Return the orders in a text: a rate, or the name of a file.

    Args:
        text: of the option ``--orders``.
        due: of ``--due``, for a rate.

    Raises:
        OrderError: the file has a wrong line.
        OSError: it cannot be read.
        typer.BadParameter: a wrong rate or due time.
    """
    try:
        rate = float(text)
    except ValueError:
        if Path(text).suffix.lower() != ".csv":
            raise typer.BadParameter(
                f"--orders is {text!r}; it must be a rate of orders a step, or a .csv file"
            ) from None
        if due is not None:
            raise typer.BadParameter(
                "--due is for a rate of orders; a file has due times"
            ) from None
        return load_orders(text)
    try:
        return OrderStream(rate, parse_due(due))
    except ValueError as error:
        raise typer.BadParameter(f"--orders {text}: {error}") from error


def parse_due(text: str | None) -> tuple[int, int]:
    """Return the fewest and most steps in a text ``FEWEST:MOST``.

    Raises:
        typer.BadParameter: the text is not of that form, or they are out of order.
    """
    if text is None:
        return DUE
    found = re.fullmatch(r"([0-9]{1,9}):([0-9]{1,9})", text)
    fewest, most = map(int, found.groups()) if found else (1, 0)
    if fewest > most:
        raise typer.BadParameter(
            f"--due is {text!r}; it must be FEWEST:MOST steps from release to due time, as in "
            f"{DUE[0]}:{DUE[1]}"
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


def fleet(
    robots: Annotated[
        int,
        typer.Option(
            "--robots", "-r", metavar="N", min=1, max=MAX_BODIES, help="Number of robots."
        ),
    ] = 8,
    orders: Annotated[
        str,
        typer.Option(
            "--orders",
            metavar="RATE|FILE",
            help="Orders that arrive in a step on average, or a .csv file of orders.",
        ),
    ] = RATE,
    due: Annotated[
        str | None,
        typer.Option(
            "--due",
            metavar="FEWEST:MOST",
            help=f"Steps from release to due time. Default: {DUE[0]}:{DUE[1]}.",
        ),
    ] = None,
    agent: AgentOption = "greedy",
    planner: Annotated[
        str | None,
        typer.Option(
            "--planner",
            metavar="NAME",
            help="Your own agent that directs all robots, as file.py:Class, instead of --agent.",
        ),
    ] = None,
    layout: Annotated[
        Path,
        typer.Option(
            "--layout",
            metavar="FILE",
            help="Layout file (rows of # . P D C, or a MovingAI .map), or a name: "
            f"{', '.join(NAMES)}.",
        ),
    ] = Path(DEPOT),
    steps: Annotated[
        int, typer.Option("--steps", metavar="N", min=1, max=MAX_COUNT, help="Steps of a shift.")
    ] = 1000,
    battery: Annotated[
        str,
        typer.Option(
            "--battery",
            metavar="N[UNIT]",
            help="A full battery, in steps or joules, as in 400steps or 30000joules.",
        ),
    ] = "400steps",
    people: Annotated[
        int,
        typer.Option(
            "--people", metavar="N", min=0, max=MAX_BODIES, help="People who walk on the floor."
        ),
    ] = 0,
    late_penalty: Annotated[
        float,
        typer.Option(
            "--late-penalty",
            metavar="X",
            min=0,
            help="Reward that the record has less for each step by which a delivery is late.",
        ),
    ] = 0.0,
    backend: BackendOption = "grid",
    view_radius: ViewRadiusOption = 2,
    shifts: Annotated[
        int,
        typer.Option(
            "--episodes",
            "-n",
            metavar="N",
            min=1,
            max=MAX_SHIFTS,
            help="Shifts, of one seed after the other. Of several the means are printed, with "
            "95% intervals, and the first is shown.",
        ),
    ] = 1,
    seed: SeedOption = None,
    *,
    save: SaveOption,
    show: ShowOption = None,
    speed: SpeedOption = 1.0,
) -> None:
    """Run a shift of several robots with orders and replay it.

    Each robot is directed by the agent, its goal given by its order. A robot
    whose battery is low drives to a charger.

    Example: warehouse fleet --robots 12 --orders 0.1 --people 3 --seed 12
    """
    if planner is not None and agent != "greedy":
        raise typer.BadParameter("--planner directs all robots; leave out --agent")
    floor, director = find_layout(layout), planner or agent
    make_env = partial(
        FleetEnv,
        floor,
        robots,
        backend=backend,
        orders=parse_orders(orders, due),
        max_steps=steps,
        battery=parse_battery(battery),
        view_radius=view_radius,
        people=people,
        late_penalty=late_penalty,
    )

    def run(seed: int) -> FleetEpisode:
        whole_number("seed", seed, 0)
        directing = (
            make_team(agent, robots, seed, floor)
            if planner is None
            else make_planner(planner, seed, floor)
        )
        with closing(make_env()) as env:
            return run_shift(env, directing, director, seed)

    first = draw_seed() if seed is None else seed
    title = (
        f"{counted(robots, 'robot')} ({director}) on layout {layout.stem}, backend {backend}, "
        f"{f'seed {first}' if shifts == 1 else f'seeds {first} to {first + shifts - 1}'}"
    )
    done = list[FleetEpisode]()

    def finish(show: bool | None, note: str = "") -> None:
        report_shifts([episode.measures for episode in done], robots, title + note)
        replay_or_save(done[0], save, show, speed=speed)

    try:
        run_shifts(run, range(first, first + shifts), done)
    except EpisodeError:
        finish(show, ", not finished")
        raise
    except EpisodeInterrupted as error:
        finish(False, ", not finished")
        raise typer.Abort from error
    finish(show)


def run_shifts(
    run: Callable[[int], FleetEpisode], seeds: Sequence[int], done: list[FleetEpisode]
) -> None:
    """Run a shift for each seed, and add their records to ``done``.

    Raises:
        EpisodeError: an agent failed; the record so far has been added.
        EpisodeInterrupted: Ctrl-C was pressed; likewise.
        typer.BadParameter: the fleet cannot be made.
    """
    try:
        with warnings_printed():
            for seed in tracked(seeds):
                done.append(run(seed))
    except (EpisodeError, EpisodeInterrupted) as error:
        done.append(error.episode)
        raise
    except WarehouseError:
        raise
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


def tracked(seeds: Sequence[int]) -> Iterable[int]:
    """Return the seeds, with a progress bar if there are several."""
    if len(seeds) == 1:
        return seeds
    from agents.console.progress import track

    return track(seeds, "shifts")


@contextmanager
def warnings_printed() -> Iterator[None]:
    """Print each warning of a block once, as a line."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        try:
            yield
        finally:
            for message in dict.fromkeys(str(each.message) for each in found):
                print_error(f"warning: {message}")


def report_shifts(measures: Sequence[FleetMeasures], robots: int, title: str) -> None:
    """Print the measures of shifts, those of several as means with 95% intervals."""
    print_table(measures_table(measures, title))
    say(fill(verdict(measures, robots), get_terminal_size().columns))


def measures_table(measures: Sequence[FleetMeasures], title: str) -> Table:
    """Return a table with a line for each measure."""
    rows: list[tuple[str, ...]] = [
        (line.title, _words(_values(measures, line)), line.unit) for line in LINES
    ]
    header = "value" if len(measures) == 1 else f"mean ({CONFIDENCE:.0%} interval)"
    few = 1 < len(measures) < MIN_VALUES
    caption = f"Fewer than {MIN_VALUES} episodes have no intervals." if few else ""
    return Table(("measure", header, "unit"), rows, title, caption)


def verdict(measures: Sequence[FleetMeasures], robots: int) -> str:
    """Return what the measures of shifts of some robots say, in a sentence or two."""
    orders, delivered, stranded, blocked, distance = (
        sum(getattr(each, name) for each in measures)
        for name in ("orders", "delivered", "stranded", "blocked_by_robot", "distance")
    )
    on_time = sum(each.on_time * each.delivered for each in measures if each.delivered)
    parts = [f"{delivered:,} of {counted(orders, 'order')} delivered"]
    if delivered:
        parts[0] += f", {percent(on_time / delivered)} of them on time"
    if blocked:
        parts.append(f"robots blocked each other in {percent(blocked / (blocked + distance))} of "
                     "their moves")  # fmt: skip
    parts.append(f"{stranded:,} ran empty" if stranded else "none ran empty")
    hint = ""
    if stranded:
        hint = " More chargers or a larger --battery would help."
    elif orders - delivered > FEW_WAITING * robots * len(measures):
        hint = " Orders arrive faster than this fleet delivers."
    return f"{'; '.join(parts)}.{hint}"


def _values(measures: Sequence[FleetMeasures], line: Line) -> NDArray[np.float64]:
    """Return a measure of the shifts that have it."""
    values = np.array([getattr(each, line.name) for each in measures], np.float64) * line.factor
    return values[~np.isnan(values)]


def _words(values: NDArray[np.float64]) -> str:
    if len(values) == 1 and values[0].is_integer():
        return f"{int(values[0]):,}"
    found = mean_interval(values)
    return mean(found, "") if found else "none"
