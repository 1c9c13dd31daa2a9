"""Planned fleets: a planner and a task assignment control all robots of a fleet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from agents.errors import AgentError, file_of, reason_of
from agents.fleet.scheduler import Scheduler, shares_cell
from agents.mapf.assignment import ASSIGNMENTS
from agents.mapf.graph import CLOSED, Graph
from agents.mapf.kernels.robots import NOBODY
from agents.mapf.planner import Planner, Situation, check_next, knows_headings, next_steps
from agents.mapf.problem import places_of
from agents.mapf.time_limit import time_limit
from warehouse_core import Cell, FleetEnv
from warehouse_core.arguments import flag, instance_of, one_of, real_number, with_methods
from warehouse_core.records import FleetAgent
from warehouse_core.records.plans import NO_PLANS, StepPlans
from warehouse_core.world.actions import DROP, PICK, WAIT
from warehouse_core.world.moves import FORWARD, LEFT, RIGHT, TURN_ACTIONS
from warehouse_core.world.tables import Integers

DEFAULT_ASSIGNMENT = "urgent"

PLAN_SECONDS = 10.0
"""Default time limit for the plan of a step, in seconds."""

_WAITS = TURN_ACTIONS.index("WAIT")

_TURNS = np.array([_WAITS, RIGHT, RIGHT, LEFT])
"""Action that turns a robot, by the number of quarter turns to the right that it needs."""

_HANDLES = np.full(DROP + 1, _WAITS)
_HANDLES[[PICK, DROP]] = TURN_ACTIONS.index("PICK"), TURN_ACTIONS.index("DROP")
"""Index in ``TURN_ACTIONS`` of picks and drops, by their index in ``ACTIONS``."""


def wants_dispatch(agent: FleetAgent) -> bool:
    """Return whether the environment assigns the orders, as it does unless the agent declines."""
    return getattr(agent, "dispatch", True)


def check_headings(planner: Planner, env: FleetEnv) -> None:
    """Raise ``AgentError`` if robots have headings and their planner does not support them."""
    if env.settings.has_headings and not knows_headings(planner):
        raise AgentError(
            f"planner {type(planner).__name__} does not support headings, which robots "
            'with moves="turn" have; it needs a method next_places'
        )


class PlanLog:
    """Record of a planner's plans for some robots and, with ``pushes``, of who pushes whom.

    Attributes:
        plans: plans of the steps so far, as ``replay_animation`` takes them.
    """

    def __init__(self, robots: Sequence[int] = (), pushes: bool = False) -> None:
        self.plans: list[StepPlans] = []
        self._robots, self.pushes = robots, pushes

    def add(self, planner: Planner, graph: Graph, situation: Situation, chosen: Integers) -> None:
        """Record the plans of a step from a situation to the chosen cells, ``[R]``.

        ``graph`` is used if the planner has no ``graph`` of its own.
        """
        cells, goals = situation.cells, situation.goals
        graph, plan_of = getattr(planner, "graph", None) or graph, getattr(planner, "plan_of", None)
        places, wishes = dict[int, list[Cell]](), dict[int, list[Cell]]()
        for robot in self._robots:
            ahead = plan_of(robot) if plan_of else []
            # A robot that cannot follow its plan waits.
            is_planned = ahead[:1] == [chosen[robot]]
            path = [int(cells[robot]), *(ahead if is_planned else [int(chosen[robot])])]
            places[robot] = graph.layout.cells(path)
            wishes[robot] = graph.layout.cells(graph.path(path[-1], int(goals[robot])))
        pushed = dict[int, int]()
        if self.pushes:
            pushers = getattr(planner, "pushers", ())
            pushed = {robot: int(by) for robot, by in enumerate(pushers) if by != NOBODY}
        self.plans.append(StepPlans(places, wishes, pushed))


class PlannedFleet:
    """Fleet agent that moves its robots with a planner, to goals from orders, chargers and parking.

    If a plan takes too long, the step is lost and all robots wait. The same happens if the planner
    fails and ``goes_on`` is true; the planner is then reset.

    Args:
        planner: planner made for the floor of the fleet.
        assignment: a name of ``ASSIGNMENTS``.
        seconds: time limit of the planner for a step, above 0.
        goes_on: continue when the planner fails, instead of raising its error.
        log: log that records the plans of each step.

    Raises:
        AgentError: the log has to record pushes, which the planner does not report.

    Attributes:
        dispatch: false, because this class assigns the orders; see ``FleetEnv``.
        lost: lost steps, each with the reason.

    Example:
        >>> from agents.fleet import PlannedFleet
        >>> from agents.mapf.graph import CLOSED, Graph
        >>> from agents.mapf.pibt import PIBT
        >>> from warehouse_core import FleetEnv, record_episode, shelf_layout
        >>> layout = shelf_layout(aisle=2)
        >>> env = FleetEnv(layout, 4, orders=0.1, max_steps=100, dispatch=False, seed=1)
        >>> shift = record_episode(env, PlannedFleet(PIBT(Graph(layout)), "nearest"), seed=1)
        >>> shift.measures.delivered, shift.measures.orders
        (8, 10)
    """

    dispatch = False

    def __init__(
        self, planner: Planner, assignment: str = DEFAULT_ASSIGNMENT, *,
        seconds: float = PLAN_SECONDS, goes_on: bool = False, log: PlanLog | None = None,
    ) -> None:  # fmt: skip
        with_methods("planner", planner, "reset", "next_cells")
        self._log = None if log is None else instance_of("log", log, PlanLog)
        if log and log.pushes and not hasattr(planner, "pushers"):
            raise AgentError(f"planner {type(planner).__name__} does not report which robots push")
        self.planner = planner
        self._assignment = one_of("assignment", assignment, ASSIGNMENTS)
        self._seconds = real_number("seconds", seconds, above=True)
        self._goes_on = flag("goes_on", goes_on)
        self.reset()

    def reset(self) -> None:
        """Forget the last episode."""
        self.planner.reset()
        self._scheduler: Scheduler | None = None
        self.lost: list[tuple[int, str]] = []
        if self._log:
            self._log.plans.clear()

    def act(self, env: FleetEnv) -> NDArray[np.intp]:
        """Return the next action of each robot, as an index.

        Raises:
            PlanError: the plan of the step has a conflict.
            AgentError: the robots have headings, and the planner does not support them.
        """
        if self._scheduler is None:
            check_headings(self.planner, env)
            known = getattr(self.planner, "graph", None)
            self._scheduler = Scheduler(env, self._assignment, known)
        situation, actions = self._scheduler.situation(env)
        graph, cells, headings = self._scheduler.graph, situation.cells, np.array(env.headings)
        stays = places_of(graph, cells, headings)
        known = getattr(self.planner, "graph", None) or graph
        if known.closed != graph.closed:
            known.close(graph.closed)
            self.planner.reset()
        try:
            chosen = self._plan(graph, situation, headings)
            if self._log:
                self._log.add(self.planner, graph, situation, chosen % graph.size)
        except TimeoutError:
            chosen = self._lose(env, stays, f"the plan took more than {self._seconds:g} s")
        except Exception as error:  # a user's planner may raise anything
            if not self._goes_on:
                raise
            chosen = self._lose(env, stays, reason_of(error, file_of(self.planner)))
        if env.settings.has_headings:
            return turning_actions(graph, situation, headings, chosen, actions)
        if shares_cell(cells).any():
            chosen = separate(graph, situation, chosen)
        moves = (graph.neighbours[cells] == chosen[:, None]).argmax(axis=1)
        return np.where(actions == WAIT, moves, actions)

    def _plan(self, graph: Graph, situation: Situation, headings: Integers) -> Integers:
        """Return the checked next cells of the robots, or their next places with headings."""
        with time_limit(self._seconds):
            chosen = next_steps(self.planner, situation, headings)
        return check_next(graph, situation, headings, chosen)

    def _lose(self, env: FleetEnv, stays: Integers, reason: str) -> Integers:
        self.lost.append((env.steps + 1, reason))
        self.planner.reset()
        if self._log:
            self._log.plans.append(NO_PLANS)
        return stays


def turning_actions(
    graph: Graph, situation: Situation, headings: Integers, places: Integers, actions: Integers
) -> NDArray[np.intp]:
    """Return the actions of robots with headings, ``[R]`` indices into ``TURN_ACTIONS``.

    Args:
        graph: floor.
        situation: situation before the step.
        headings: ``[R]`` headings before the step.
        places: ``[R]`` places after the step, see ``PlacePlanner``.
        actions: ``[R]``, ``PICK`` or ``DROP``, or ``WAIT`` for robots that move, turn or wait.
    """
    cells = situation.cells
    wanted, to = np.divmod(places, graph.size)
    if shares_cell(cells).any():
        separated = separate(graph, situation, to)
        away = (graph.neighbours[cells, :WAIT] == separated[:, None]).argmax(axis=1)
        wanted = np.where(separated != to, away, wanted)
        to = np.where((separated != to) & (away != headings), cells, separated)
    moves = np.where(to != cells, FORWARD, _TURNS[(wanted - headings) % len(_TURNS)])
    return np.where(actions == WAIT, moves, _HANDLES[actions])


def separate(graph: Graph, situation: Situation, chosen: Integers) -> Integers:
    """Separate robots that share a cell: let the first one leave, and return the next cells.

    Bodies may come to rest in one cell after a disturbance. For the planner, both robots stay.
    """
    cells = situation.cells
    first = np.unique(cells, return_index=True)[1]
    others = np.setdiff1d(np.arange(len(cells)), first)
    taken = {CLOSED, *cells.tolist(), *chosen.tolist(), *situation.closed.tolist()}
    separated = chosen.copy()
    for cell in np.unique(cells[others]).tolist():
        free = [side for side in graph.neighbours[cell].tolist() if side not in taken]
        if free:
            separated[np.argmax(cells == cell)] = free[0]
            taken.add(free[0])
    return separated
