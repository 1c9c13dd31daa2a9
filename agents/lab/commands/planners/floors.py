"""Problems for measuring planners, which are read from files or generated."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from agents.errors import PlanError
from agents.lab.console.options import LAYOUT, option
from agents.mapf.graph import Graph
from agents.mapf.problem import Problem
from warehouse_core import Layout
from warehouse_core.world.generators import kiva_warehouse
from warehouse_core.world.map_files import load_layout
from warehouse_core.world.moves import COMPASS, EAST, TURN
from warehouse_core.world.named_layouts import find_layout
from warehouse_core.world.scenarios import check_scenarios, load_scenarios
from warehouse_core.world.tables import Integers

KIVA, SCENARIO = "kiva", ".scen"

FloorOption = Annotated[
    str | None,
    option(
        "--layout FILE",
        f"{LAYOUT} Default: kiva, which has 33 x 46 cells, 192 starts and 480 goals, as in papers.",
        show_default=False,
    ),
]


class PlannerFloor(NamedTuple):
    """A layout with the cells in which robots may start and have goals.

    Attributes:
        layout: walls, and a pickup in each goal cell for planners that learn. It has no chargers,
            because some planners would avoid them. If goals may be anywhere, it has no stations.
        starts: numbers of the start cells.
        goals: numbers of the goal cells.
    """

    layout: Layout
    starts: Integers
    goals: Integers


def find_floor(name: str | None) -> PlannerFloor:
    """Return the floor with a name or from a file, by default ``KIVA``.

    Starts and goals are in the largest connected part of the layout.
    """
    if name is None or name == KIVA:
        layout, starts, goals = kiva_warehouse()
        places = layout.cells(goals)
        return PlannerFloor(layout.with_tiles(places, [], []), starts, goals)
    layout = find_layout(name).with_tiles([], [], [])
    labels = Graph(layout).parts[layout.open_cells]
    cells = layout.open_cells[labels == np.bincount(labels).argmax()] if labels.size else labels
    return PlannerFloor(layout, cells, cells)


def random_problem(floor: PlannerFloor, robots: int, seed: int, moves: str = COMPASS) -> Problem:
    """Return a problem with random starts and goals."""
    most = min(len(floor.starts), len(floor.goals))
    if robots > most:
        raise PlanError(f"--robots is {robots}; allowed: 1..{most} on this layout")
    stream = np.random.default_rng(seed)
    starts, goals = (stream.permutation(cells)[:robots].tolist() for cells in floor[1:])
    return Problem(Graph(floor.layout), starts, goals, first_headings(robots, moves))


def scenario_problem(
    path: Path, layout_file: str | None, robots: int | None, moves: str = COMPASS
) -> Problem:
    """Return the problem in the first scenarios of a ``.scen`` file, one for each robot.

    Args:
        path: path of the file.
        layout_file: name or file of the layout. By default it is the map that the scenarios name,
            in the same folder.
        robots: number of robots, by default one for each scenario.
        moves: name of the moves of a robot.

    Raises:
        PlanError: the file has too few scenarios.
        LayoutError: the layout cannot be used.
    """
    scenarios = load_scenarios(path)
    count = len(scenarios) if robots is None else robots
    if not 0 < count <= len(scenarios):
        raise PlanError(
            f"--robots is {count}; allowed: 1..{len(scenarios)}, the scenarios of {path}"
        )
    chosen = scenarios[:count]
    if layout_file is None:
        layout = load_layout(path.parent / Path(chosen[0].map_name).name)
    else:
        layout = find_layout(layout_file)
    check_scenarios(layout, chosen)
    starts, goals = (
        layout.numbers(ends).tolist()
        for ends in zip(*((each.start, each.goal) for each in chosen), strict=True)
    )
    return Problem(Graph(layout), starts, goals, first_headings(count, moves))


def first_headings(robots: int, moves: str) -> list[int] | None:
    """Return the initial headings of the robots, all east, or ``None`` without headings."""
    return [EAST] * robots if moves == TURN else None


def find_scenarios(paths: Sequence[Path]) -> list[Path]:
    """Return the scenario files in a list of files and folders.

    Raises:
        PlanError: a folder has no scenario file, or a file has another format.
    """
    found = list[Path]()
    for path in paths:
        inside = sorted(path.glob(f"*{SCENARIO}")) if path.is_dir() else [path]
        if not inside:
            raise PlanError(f"{path}: the folder has no {SCENARIO} file")
        if inside[0].suffix.lower() != SCENARIO:
            raise PlanError(f"{path}: unknown format of a problem; allowed: {SCENARIO}")
        found += inside
    return found
