"""Planners on many MovingAI scenarios: how many they solve over the number of robots."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path

from agents.errors import PlanError
from agents.lab.commands.planners.floors import scenario_problem, with_moves
from agents.lab.commands.planners.runs import Attempt, attempt
from agents.lab.console.csv_file import write_csv
from agents.lab.console.options import PICTURES
from agents.lab.console.output import save_picture
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import say
from agents.lab.trials.interval import MIN_VALUES, Interval, share_interval
from agents.lab.trials.workers import run_trials
from warehouse_core.files.atomic import check_suffix
from warehouse_core.wording import counted
from warehouse_core.world.scenarios import load_scenarios

SCENARIO, VALUES = ".scen", ".csv"

FIRST_SIZE = 10
"""Fewest robots by default; each number after it is twice the one before."""


Attempts = Mapping[tuple[str, int], Sequence[Attempt]]
"""Attempts at each file by planner and number of robots."""


def find_scenarios(paths: Sequence[Path]) -> list[Path]:
    """Return the files of scenarios among paths and in folders, ``x-2`` before ``x-10``.

    Raises:
        PlanError: a folder has none, or a file is something else.
    """
    found = list[Path]()
    for path in paths:
        if path.is_dir():
            inside = sorted(path.glob(f"*{SCENARIO}"), key=_by_number)
            if not inside:
                raise PlanError(f"{path}: the folder has no {SCENARIO}")
            found += inside
        elif path.suffix.lower() == SCENARIO:
            found.append(path)
        else:
            raise PlanError(f"{path}: several files must be {SCENARIO}, or folders of them")
    return found


def _by_number(path: Path) -> list[tuple[int, str]]:
    """Return the parts of a name, in which numbers are ordered by their values."""
    parts = re.findall(r"\d+|\D+", path.name)
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


def attempt_at(
    case: tuple[str, int], number: int, *, files: Sequence[Path], layout: str | None, moves: str,
    seed: int, seconds: float,
) -> Attempt:  # fmt: skip
    """Return the attempt of a planner at the first robots of a file."""
    planner, robots = case
    problem = with_moves(scenario_problem(files[number], layout, robots), moves)
    return attempt(planner, seed, problem, seconds)


def study(
    files: Sequence[Path],
    planners: Sequence[str],
    sizes: Sequence[int],
    layout: str | None,
    moves: str,
    seed: int,
    seconds: float,
    jobs: int | None,
    outputs: Sequence[Path],
) -> None:
    """Print how many scenarios planners solve, and write each attempt and curves.

    Raises:
        PlanError: a file has fewer scenarios than robots, or as for ``scenario_problem``.
        FormatError: an output of another suffix than ``.csv``, ``.svg`` and ``.png``.
    """
    for path in outputs:
        check_suffix(path, (VALUES, *PICTURES))
    least = min(len(load_scenarios(path)) for path in files)
    if not sizes:
        sizes = [FIRST_SIZE * 2**power for power in range(least.bit_length())]
        sizes = [size for size in sizes if size <= least] or [least]
    for path, size in product(files, [max(sizes)]):
        scenario_problem(path, layout, size)  # what is wrong is told before anything runs
    call = partial(attempt_at, files=files, layout=layout, moves=moves, seed=seed, seconds=seconds)
    cases = list(product(planners, sizes))
    attempts = run_trials(call, cases, range(len(files)), jobs, "plans")
    title = f"{counted(len(files), 'scenario file')}, {seconds:g} s a plan"
    for path in outputs:
        if path.suffix == VALUES:
            write_attempts(path, attempts, files)
        else:
            from agents.lab.commands.planners.picture import curves_figure  # imports matplotlib

            save_picture(curves_figure(shares(attempts), title, "scenarios solved"), path)
    rows = [(str(size), *(cell(attempts[planner, size]) for planner in planners)) for size in sizes]
    caption = (
        "Files of whose first robots a plan was found; its costs over the sum of the fewest steps, "
        "mean; processor time of all files, mean."
    )
    print_table(TextTable(("robots", *planners), rows, title, caption))
    for path in outputs:
        say(f"saved {path}")


def cell(attempts: Sequence[Attempt]) -> str:
    """Return what a planner has reached with a number of robots, in lines."""
    ratios = [each.costs / each.bound for each in attempts if each.costs is not None and each.bound]
    solved = sum(each.costs is not None for each in attempts)
    mean = [f"{sum(ratios) / len(ratios):.3f}"] if ratios else []
    seconds = sum(each.seconds for each in attempts) / len(attempts)
    return "\n".join([f"{solved} of {len(attempts)}", *mean, f"{seconds:.3f} s"])


def shares(attempts: Attempts) -> dict[str, dict[int, Interval]]:
    """Return the share of solved files by planner and number of robots."""
    found: dict[str, dict[int, Interval]] = {}
    for (planner, size), each in attempts.items():
        solved = sum(one.costs is not None for one in each)
        share = Interval(solved / len(each))
        if len(each) >= MIN_VALUES:
            share = share_interval(solved, len(each))
        found.setdefault(planner, {})[size] = share
    return found


def write_attempts(path: Path, attempts: Attempts, files: Sequence[Path]) -> None:
    """Write a line for each attempt."""
    lines = (
        [planner, size, str(file), *each]
        for (planner, size), column in attempts.items()
        for file, each in zip(files, column, strict=True)
    )
    write_csv(path, ["planner", "robots", "file", *Attempt._fields], lines)
