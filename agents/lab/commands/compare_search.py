"""Comparison of searches with several heuristic weights, for ``warehouse compare search``."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import typer

from agents.lab.console.output import Film, show_or_save
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import say
from agents.lab.console.values import load_layout, parse_cell
from agents.search.algorithms import (
    MAX_WEIGHT,
    Heuristic,
    Solution,
    check_weight,
    weighted_astar_search,
)
from agents.search.heuristics import manhattan, true_distance, zero
from agents.search.problems import RouteProblem
from agents.search.trace import MAX_PANELS, SearchCourse, track_of_course
from warehouse_core.errors import LayoutError
from warehouse_core.world.distances import distances
from warehouse_core.world.layout import DEFAULT_LAYOUT, Layout, check_open
from warehouse_core.world.tiles import Cell

MakeHeuristic = Callable[[RouteProblem, Layout], Heuristic[Cell]]

HEURISTICS: dict[str, MakeHeuristic] = {
    "manhattan": lambda problem, layout: manhattan(problem),
    "true": true_distance,
    "zero": lambda problem, layout: zero,
}

NAMES = {0.0: "uniform-cost", 1.0: "A*", math.inf: "greedy best-first"}
"""Names of weighted A* with special weights."""

ALL_DIFFER: tuple[Cell, Cell] = (2, 10), (1, 3)
"""Start and goal in the chapter's layout for which all four default searches differ."""

FoundPath = Solution[Cell, str]


def algorithm(weight: float) -> str:
    """Return the name of weighted A* with a weight."""
    return NAMES.get(weight, "weighted A*")


def parse_weights(text: str) -> list[float]:
    """Return the weights in a text, which are separated by commas."""
    weights = [_parse_weight(part) for part in text.split(",")]
    if len(weights) > MAX_PANELS:
        raise typer.BadParameter(
            f"--weights has {len(weights)} weights; at most {MAX_PANELS} fit into a picture"
        )
    return weights


def choose_ends(
    layout: Layout, start: Cell | None, goal: Cell | None, seed: int | None
) -> tuple[Cell, Cell]:
    """Return the start and the goal, after choosing those that are not given.

    With a seed they are random. Without a seed the goal is the first pickup, and the start is the
    cell that is farthest from the goal. The default in the chapter's layout is ``ALL_DIFFER``.

    Raises:
        LayoutError: the layout has no pickup, and neither a goal nor a seed is given.
    """
    if seed is None:
        if goal is None and not layout.pickups:
            raise LayoutError("the layout has no pickup to go to; give --goal ROW,COL or --seed N")
        if layout is DEFAULT_LAYOUT and start is goal is None:
            return ALL_DIFFER
        goal = goal or layout.pickups[0]
        check_open(layout, goal, "goal")
        return start or farthest_from(goal, layout), goal
    default, count = layout.default_start(), len(layout.open_cells)
    # Three cells, because one of them may be the given start or goal.
    ranks = random.Random(seed).sample(range(count), min(count, 3))
    cells = [layout.open_cell(rank) for rank in ranks]
    begin = start or next((cell for cell in cells if cell != goal), default)
    return begin, goal or next((cell for cell in cells if cell != begin), default)


def farthest_from(goal: Cell, layout: Layout) -> Cell:
    """Return the cell with the longest shortest path to a goal.

    If the goal cannot be reached from any other cell, return another open cell, if there is one.
    """
    steps = distances(layout, [goal])
    row, col = np.unravel_index(np.where(np.isfinite(steps), steps, -1).argmax(), steps.shape)
    farthest = int(row), int(col)
    ends = layout.open_cell(0), layout.open_cell(len(layout.open_cells) - 1)
    return farthest if farthest != goal else next((end for end in ends if end != goal), goal)


def search_table(weights: Sequence[float], solutions: Sequence[FoundPath], title: str) -> TextTable:
    """Return a table with the results of each search."""
    rows = [
        (
            algorithm(weight),
            f"{weight:g}",
            f"{solution.cost:g}" if solution.found else "none",
            *map(str, (solution.expanded, solution.generated, solution.largest_frontier)),
        )
        for weight, solution in zip(weights, solutions, strict=True)
    ]
    header = ("algorithm", "weight", "cost", "expanded", "generated", "largest frontier")
    return TextTable(header, rows, title)


def compare_search(
    layout: Path | None = None,
    start: str | None = None,
    goal: str | None = None,
    seed: int | None = None,
    weights: str = "0,1,5,inf",
    heuristic: str = "manhattan",
    save: Sequence[Path] = (),
    show: bool | None = None,
) -> None:
    """Search for a path with several weights of a heuristic, and compare the searches.

    ``choose_ends`` chooses the start and the goal.
    """
    values = parse_weights(weights)
    given = parse_cell(start, "--start"), parse_cell(goal, "--goal")
    if heuristic not in HEURISTICS:
        raise typer.BadParameter(
            f"no heuristic is called {heuristic!r}; allowed: {', '.join(HEURISTICS)}"
        )
    grid = load_layout(layout)
    begin, end = choose_ends(grid, *given, seed)
    problem = RouteProblem(grid, begin, end)
    estimate = HEURISTICS[heuristic](problem, grid)
    found = [weighted_astar_search(problem, estimate, w, with_events=True) for w in values]
    title = f"Search from {begin} to {end}, heuristic: {heuristic}"
    print_table(search_table(values, found, title))
    if not found[0].found:
        say(f"no path exists from {begin} to {end}")

    named = zip(map(_panel_name, values), found, strict=True)
    courses = [SearchCourse(name, grid, (begin, end), each) for name, each in named]
    film = Film(lambda: [*map(track_of_course, courses)], title)
    show_or_save(film, save, show, "search.gif")


def _parse_weight(text: str) -> float:
    try:
        weight = float(text)
        check_weight(weight)
    except ValueError:
        allowed = f"0..{MAX_WEIGHT} or inf"
        raise typer.BadParameter(f"--weights has {text!r}; each must be {allowed}") from None
    return abs(weight)  # turns -0.0 into 0


def _panel_name(weight: float) -> str:
    sign = "\u221e" if weight == math.inf else f"{weight:g}"
    return f"{algorithm(weight)}, W = {sign}"
