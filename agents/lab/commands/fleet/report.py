"""Report of shifts: measures, a verdict, the failure mode, and files of orders and measures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain
from math import nan
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.fleet.optimum import Optimum, most_deliveries
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import say
from agents.lab.trials.interval import CONFIDENCE, MIN_VALUES, mean, mean_interval, percent
from warehouse_core import Episode
from warehouse_core.files.tables import write_table
from warehouse_core.fleet import FleetMeasures
from warehouse_core.orders.files import COLUMNS
from warehouse_core.orders.order import Order
from warehouse_core.records.failure_modes import FEW_WAITING, Diagnosis, diagnose
from warehouse_core.wording import counted

SUFFIX = ".csv"

DASH = "-"
"""Text in a table for a value that a backend does not measure."""


class MeasureLine(NamedTuple):
    """A line of the table of measures: an attribute of ``FleetMeasures`` with title and unit.

    A measure ``of_bodies`` is a dash on the grid, which has no seconds and no joules of its own.
    """

    title: str
    name: str
    unit: str
    factor: float = 1.0
    of_bodies: bool = False


class ShiftResult(NamedTuple):
    """Results of a shift that are printed and written.

    Attributes:
        seed: seed of the shift.
        measures: measures of the shift.
        diagnosis: failure mode of the shift.
        orders: all orders.
        possible: most deliveries and most deliveries on time, or () if they are not wanted.
    """

    seed: int | None
    measures: FleetMeasures
    diagnosis: Diagnosis
    orders: Sequence[Order]
    possible: Sequence[Optimum] = ()


LINES = (
    MeasureLine("orders", "orders", "items"),
    MeasureLine("delivered", "delivered", "items"),
    MeasureLine("deliveries per hour", "per_hour", "items"),
    MeasureLine("on time", "on_time", "% of deliveries", 100.0),
    MeasureLine("mean lateness", "mean_lateness", "steps"),
    MeasureLine("worst lateness", "worst_lateness", "steps"),
    MeasureLine("energy per delivery", "joules_per_delivery", "kJ", 1e-3, of_bodies=True),
    MeasureLine("distance", "distance", "cells"),
    MeasureLine("blocked by walls", "blocked_by_wall", "moves"),
    MeasureLine("blocked by robots", "blocked_by_robot", "moves"),
    MeasureLine("blocked by people", "blocked_by_person", "moves"),
    MeasureLine("waits", "waits", "robot steps"),
    MeasureLine("charging", "charging", "robot steps"),
    MeasureLine("stranded", "stranded", "robots out of battery or failed"),
    MeasureLine("lost", "lost", "orders held by these robots"),
    MeasureLine("simulated time", "seconds", "s", of_bodies=True),
)
"""Measures of a shift in the order of the table, see ``FleetMeasures``."""


def result_of(episode: Episode, optimum: bool = False) -> ShiftResult:
    """Return the results of a record; with ``optimum``, also how many deliveries were possible."""
    possible = [most_deliveries(episode, on_time) for on_time in (False, True)] if optimum else ()
    diagnosis, measures = diagnose(episode), episode.measures
    outcomes = chain.from_iterable(episode.motions)
    if all(outcome.readings is None for outcome in outcomes):
        measures = replace(measures, seconds=nan, joules_per_delivery=nan)
    return ShiftResult(episode.seed, measures, diagnosis, episode.orders, possible)


def report_shifts(results: Sequence[ShiftResult], robots: int, title: str) -> None:
    """Print the measures of one shift, or the means of several shifts with 95% intervals."""
    measures = [result.measures for result in results]
    print_table(measures_table(measures, title))
    possible = [result.possible for result in results if result.possible]
    lines = [
        verdict(measures, robots),
        *([share_of_possible(measures, possible)] if possible else []),
        f"Diagnosis: {diagnosis([each.diagnosis for each in results])}.",
    ]
    for line in lines:
        say(fill(line, get_terminal_size().columns))


def diagnosis(found: Sequence[Diagnosis]) -> str:
    """Return the diagnosis of one shift, or how often each failure mode occurs in several."""
    if len(found) == 1:
        return f"{found[0].mode}: {found[0].sentence}"
    modes = Counter(each.mode for each in found)
    return ", ".join(f"{mode} ({count:,})" for mode, count in modes.most_common())


def report_fleet(episode: Episode) -> None:
    """Print the measures of a record."""
    title = (
        f"{counted(episode.robots, 'robot')} ({episode.agent}), backend {episode.backend}, "
        f"seed {episode.seed}"
    )
    report_shifts([result_of(episode)], episode.robots, title)


def measures_table(measures: Sequence[FleetMeasures], title: str) -> TextTable:
    """Return a table with a line for each measure."""
    rows: list[tuple[str, ...]] = [
        (line.title, _words(_values(measures, line), line), line.unit) for line in LINES
    ]
    header = "value" if len(measures) == 1 else f"mean ({CONFIDENCE:.0%} interval)"
    few = 1 < len(measures) < MIN_VALUES
    caption = f"Intervals need at least {MIN_VALUES} episodes." if few else ""
    return TextTable(("measure", header, "unit"), rows, title, caption)


def verdict(measures: Sequence[FleetMeasures], robots: int) -> str:
    """Return a summary of the measures of shifts, in one to three sentences."""
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
    parts.append(
        f"{counted(stranded, 'robot') if stranded else 'no robot'} ran out of battery or failed"
    )
    hint, lost = "", sum(each.lost for each in measures)
    if stranded:
        hint = " More chargers or a larger --battery would help."
    elif orders - delivered > FEW_WAITING * robots * len(measures):
        hint = " Orders arrive faster than this fleet delivers."
    if lost:
        hint += f" Orders lost with these robots: {lost:,}."
    return f"{'; '.join(parts)}.{hint}"


def share_of_possible(
    measures: Sequence[FleetMeasures], possible: Sequence[Sequence[Optimum]]
) -> str:
    """Return a sentence that compares the deliveries of shifts with the deliveries possible."""
    delivered = sum(each.delivered for each in measures)
    on_time = sum(round(each.on_time * each.delivered) for each in measures if each.delivered)
    most, shares = list[str](), list[str]()
    for made, found in zip((delivered, on_time), zip(*possible, strict=True), strict=True):
        count, is_exact = sum(each.most for each in found), all(each.is_exact for each in found)
        most.append(f"{'' if is_exact else 'at most '}{count:,}")
        shares.append(percent(made / count) if count else "all")
    return (
        "Robots that never block each other or charge, and know all orders in advance, could "
        f"deliver {most[0]}, and {most[1]} on time. This fleet delivered {shares[0]} and "
        f"{shares[1]} of these numbers."
    )


def _values(measures: Sequence[FleetMeasures], line: MeasureLine) -> NDArray[np.float64]:
    """Return the values of a measure, without the shifts in which it is undefined."""
    values = np.array([value_of(each, line) for each in measures], np.float64)
    return values[~np.isnan(values)]


def value_of(measures: FleetMeasures, line: MeasureLine) -> float:
    """Return a measure of a shift in the unit of its line."""
    value: float = getattr(measures, line.name)
    return value if line.factor == 1.0 else value * line.factor


def _words(values: NDArray[np.float64], line: MeasureLine) -> str:
    if not len(values):
        return DASH if line.of_bodies else "none"
    if len(values) == 1 and values[0].is_integer():
        return f"{int(values[0]):,}"
    found = mean_interval(values)
    assert found is not None, "there is a value"
    return mean(found, "")


def write_shifts(path: Path, results: Sequence[ShiftResult]) -> Path:
    """Write the orders of shifts, one per line, and their measures to a second file.

    Returns:
        the file of the measures, called ``FILE-measures.csv``.
    """
    fates = ("taken_by", "taken", "delivered", "steps_late")
    lines = ([result.seed, *line] for result in results for line in _orders(result))
    write_table(path, ["seed", "order", *COLUMNS, *fates], lines)
    second = path.with_stem(f"{path.stem}-measures")
    titles = [f"{line.title} ({line.unit})" for line in LINES]
    measures = (
        [
            each.seed,
            *(value_of(each.measures, line) for line in LINES),
            each.diagnosis.mode,
            each.diagnosis.sentence,
        ]
        for each in results
    )
    write_table(second, ["seed", *titles, "diagnosis", "sentence"], measures)
    return second


def _orders(result: ShiftResult) -> Iterator[list[object]]:
    for number, order in enumerate(result.orders):
        late = None if order.delivered is None else max(order.delivered - order.due, 0)
        cells = *order.pickup, *order.dropoff
        fate = order.taken_by, order.taken, order.delivered, late
        yield [number, order.released, order.due, *cells, order.robot, *fate]
