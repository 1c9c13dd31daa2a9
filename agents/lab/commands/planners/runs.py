"""Problems for measuring planners, and runs of planners by name.

Robots have one goal each, or get one goal after another.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from itertools import count
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from agents import registry
from agents.code_names import split_name
from agents.errors import AgentError, PlanError, reason_of
from agents.lab.console.options import LAYOUT, option
from agents.mapf.anytime import solve_anytime
from agents.mapf.cbs import solve_cbs
from agents.mapf.eecbs import solve_eecbs
from agents.mapf.graph import CLOSED, Fields, Graph
from agents.mapf.kernels.lacam import prepare_solvers
from agents.mapf.kernels.places import FAR
from agents.mapf.planner import (
    NO_CELLS,
    SIDES,
    Planner,
    Situation,
    check_next,
    knows_headings,
    next_steps,
    solve_by_steps,
)
from agents.mapf.problem import Plan, Problem, Solver, places_of
from agents.mapf.time_limit import time_limit
from agents.registry import PLANNERS, agent_file, make_planner
from warehouse_core import Layout
from warehouse_core.wording import brief, counted
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

SOLVERS: dict[str, Solver] = {"lacam": solve_anytime, "cbs": solve_cbs, "ecbs": solve_eecbs}
"""Planners for robots that have one goal each, by name."""

AUTO = "auto"

STEPPERS = ("pibt", AUTO)
"""Default planners for robots that get one goal after another; the registry has all of them."""

BOUND = "nobody in the way"
"""Displayed name of ``Unhindered``."""


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


def make_stepper(
    name: str, seed: int, layout: Layout, robots: int, seconds: float, *, has_headings: bool = False
) -> CheckedPlanner:
    """Return the planner with a name in the registry, which plans one step after another.

    Raises:
        AgentError: ``make_planner`` fails, the object is not a ``Planner``, or robots have headings
            and it does not support them.
    """
    if split_name(name).source not in PLANNERS and registry.make_solver(name, SOLVERS):
        raise AgentError(
            f"planner {name!r} plans whole paths to one goal per robot; allowed in lifelong runs: "
            f"{', '.join(PLANNERS)}, or your own as file.py:Class or module:Class"
        )
    made = make_planner(name, seed, layout, robots, TURN if has_headings else COMPASS)
    if not isinstance(made, Planner):
        raise AgentError(
            f"planner {name!r} has no method next_cells; it controls a fleet and does not solve "
            "problems"
        )
    if has_headings and not knows_headings(made):
        raise AgentError(
            f"planner {name!r} does not support headings; it needs a method next_places"
        )
    return CheckedPlanner(made, name, Graph(layout), seconds)


def make_solver(name: str, seed: int, problem: Problem, seconds: float) -> Solver:
    """Return the solver with a name, or a solver that takes each step from a registered planner.

    The name ``auto`` stands for ``lacam``, which proves that plans of small teams are optimal and
    improves plans of large teams until the time is up.
    """
    prepare_solvers()
    if split_name(name).source == AUTO:
        name = "lacam"
    solver = registry.make_solver(name, SOLVERS, seed)
    if solver is not None:
        return solver
    code = split_name(name)
    if code.file is None and code.module is None and code.source not in PLANNERS:
        known = [*PLANNERS, *SOLVERS]
        raise AgentError(
            f"no planner is called {name!r}; allowed: {', '.join(known)}, or your own as "
            "file.py:Class, or file.py:function for whole problems"
        )
    layout, has_headings = problem.graph.layout, problem.headings is not None
    stepper = make_stepper(name, seed, layout, problem.robots, seconds, has_headings=has_headings)
    return partial(solve_by_steps, stepper)


def solve_checked(
    name: str, solve: Solver, problem: Problem, seconds: float
) -> tuple[Plan, float, float]:
    """Run a solver; return its checked plan, and the seconds by the clock and of the processor.

    Raises:
        PlanError: the solver found no plan.
        AgentError: the solver failed, or its result is not a plan for the problem; the message says
            why.
    """
    begin = time.perf_counter(), time.process_time()
    try:
        plan = solve(problem, seconds)
    except PlanError:
        raise
    except Exception as error:  # the solver of a user may raise anything
        if isinstance(error, ValueError) and split_name(name).source in SOLVERS:
            raise AgentError(f"planner {name!r}: {error}") from error  # a wrong argument
        reason = reason_of(error, agent_file(name))
        raise AgentError(f"planner {name!r} failed: {reason}") from error
    took = time.perf_counter() - begin[0], time.process_time() - begin[1]
    try:
        check_plan(problem, plan)
    except PlanError as error:
        raise AgentError(f"planner {name!r}: {error}") from error
    return plan, *took


def check_plan(problem: Problem, plan: object) -> None:
    """Raise ``PlanError`` if an object is not a plan that solves a problem."""
    robots = problem.robots
    if not (isinstance(plan, Plan) and plan.cells.ndim == 2 and plan.cells.shape[1] == robots):
        raise PlanError(f"it returned {brief(plan)}; needed: a Plan of {counted(robots, 'robot')}")
    shape = None if plan.headings is None else plan.headings.shape
    needed = None if problem.headings is None else plan.cells.shape
    if shape != needed:
        raise PlanError(f"it returned headings of the shape {shape}; needed: {needed}")
    nobody, goals = np.zeros(robots, np.bool_), np.array(problem.goals)
    for what, ends, row in (("start", problem.starts, 0), ("goal", problem.goals, -1)):
        for robot in np.flatnonzero(plan.cells[row] != np.array(ends))[:1].tolist():
            place, wanted = map(problem.graph.layout.cell, (plan.cells[row, robot], ends[robot]))
            raise PlanError(f"robot {robot} is in {place}, not at its {what} {wanted}")
    if plan.headings is not None:
        headings = np.array(problem.headings, np.intp)
        for robot in np.flatnonzero(plan.headings[0] != headings)[:1].tolist():
            raise PlanError(f"robot {robot} does not head {SIDES[headings[robot]]} initially")
    places = plan.places(problem.graph)
    for step, cells in enumerate(plan.cells[:-1]):
        headings = NO_CELLS if plan.headings is None else plan.headings[step]
        situation = Situation(cells, goals, nobody, NO_CELLS)
        try:
            check_next(problem.graph, situation, headings, places[step + 1])
        except PlanError as error:
            raise PlanError(f"step {step}: {error}") from None


class Attempt(NamedTuple):
    """The attempt of a planner at a problem.

    Attributes:
        makespan: number of steps of the plan, or ``None`` if no plan was found.
        costs: sum of costs of the plan, or ``None`` if no plan was found.
        bound: sum of the fewest steps from starts to goals.
        proved: true if the planner has proved that no plan has lower costs.
        seconds: processor time in s.
    """

    makespan: int | None
    costs: int | None
    bound: int
    proved: bool
    seconds: float


def attempt(name: str, seed: int, problem: Problem, seconds: float) -> Attempt:
    """Run the planner with a name on a problem; see ``make_solver`` and ``solve_checked``."""
    solve = make_solver(name, seed, problem, seconds)
    bound, begin = problem.lower_bound, time.process_time()
    try:
        plan, _, took = solve_checked(name, solve, problem, seconds)
    except PlanError:
        return Attempt(None, None, bound, False, time.process_time() - begin)
    costs = plan.sum_of_costs
    return Attempt(plan.makespan, costs, bound, plan.bound == costs, took)


class CheckedPlanner:
    """A planner whose steps are checked, and cut off if planning takes too long.

    In a step that was cut off, all robots wait and the planner is reset.

    Attributes:
        lost: numbers, from 0, of the steps that were cut off.
    """

    def __init__(self, planner: Planner, name: str, graph: Graph, seconds: float) -> None:
        self._planner, self._name = planner, name
        self._graph, self._seconds = graph, seconds
        self.lost: list[int] = []

    def reset(self) -> None:
        """Forget the previous episode."""
        self._planner.reset()
        self._numbers, self.lost = count(), []

    def next_cells(self, situation: Situation) -> Integers:
        """Return the cell of each robot after the next joint step; see ``next_places``."""
        return self.next_places(situation, NO_CELLS)

    def next_places(self, situation: Situation, headings: Integers) -> Integers:
        """Return the place (cell and heading) of each robot after the next joint step, ``[R]``.

        Raises:
            PlanError: the step has a conflict, or the planner failed.
        """
        number = next(self._numbers)
        try:
            with time_limit(self._seconds):
                chosen = next_steps(self._planner, situation, headings)
            return check_next(self._graph, situation, headings, chosen)
        except TimeoutError:
            self.lost.append(number)
            self._planner.reset()
            return places_of(self._graph, situation.cells, headings)
        except Exception as error:  # the planner of a user may raise anything
            is_clear = isinstance(error, PlanError)
            reason = str(error) if is_clear else reason_of(error, agent_file(self._name))
            raise PlanError(f"planner {self._name!r}, step {number}: {reason}") from error


class Unhindered:
    """A planner that moves each robot along a shortest path as if it were alone.

    Its throughput is an upper bound if goals are given.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph, self._fields = graph, Fields(graph)

    def reset(self) -> None:
        """Do nothing."""

    def next_cells(self, situation: Situation) -> Integers:
        """Return the next cell of each robot, ``[R]``; several robots may enter the same cell."""
        reached = self._graph.neighbours[situation.cells]
        rows = self._fields.rows(situation.goals)
        steps = self._fields.matrix[rows[:, None], reached]
        best = np.where(reached == CLOSED, FAR, steps).argmin(axis=1)
        found: Integers = np.take_along_axis(reached, best[:, None], 1)[:, 0]
        return found
