"""Conflict-based search: optimal plans, by a tree of constraints on single robots.

The root has a cheapest way of each robot. A node with a conflict asks for a statement on one of its
two robots, such as whether it is in a cell at a time. In the one child it is not; in the other it
is, and other robots keep out of its way. Only robots whose ways this forbids are planned again.
The children share no plan, and together they have all plans of their parent (*disjoint splitting*).
The cheapest leaf is first; if its ways have no conflict they are an optimal plan.

Two robots *clash* if each pair of their cheapest ways has a conflict, as in corridors, rectangles
and at goals. Then the one is asked whether it arrives late, and if not, the other does; by how much
is found before, so that a long corridor takes two children, both of which cost more. Pairs that
share no robot bound the cost below a node. Other conflicts are asked for in the order of the number
of cells that one of the robots could have been in at the time, fewest first; who rests in its goal
is asked whether it has arrived.

Sources: Sharon et al. (2015), Conflict-based search for optimal multi-agent pathfinding, Artificial
Intelligence 219. Boyarski et al. (2015), ICBS, IJCAI: which conflict comes first; bypasses. Felner
et al. (2018), Adding heuristics to conflict-based search, ICAPS. Li et al. (2019), Disjoint
splitting for multi-agent path finding with conflict-based search, ICAPS. Li et al. (2021), Pairwise
symmetry reasoning for multi-agent path finding search, Artificial Intelligence 301.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count
from math import inf
from time import perf_counter
from typing import NamedTuple

from agents.errors import PlanError
from agents.mapf.cell_sets import CellSets, bits_of
from agents.mapf.clash import delays_of
from agents.mapf.problem import Plan, Problem
from agents.mapf.route import Route, TracedWay
from agents.mapf.rules import Constraint, Rules
from warehouse_core.wording import counted

__all__ = ["solve_cbs"]

Pair = tuple[int, int]
"""Numbers of two robots, the smaller first."""

ROUND = 16
"""Horizons are multiples of this, so that traces seldom have to be made again."""

NO_PLAN = "there is no plan: some robot has no way that keeps clear of the others"

MAX_BYTES = 500_000_000
"""Memory that layers and traces take, about, before they are forgotten."""

LEAST_KEPT = 4
"""Number of layers and traces per robot that are not forgotten at once in any case."""


class Conflict(NamedTuple):
    """Two robots in one cell, two that change places, or two that clash.

    Attributes:
        robots: the two.
        time: number of the joint step.
        cell: cell of the first robot after the step; ``None`` for a clash.
        before: cell of the first robot before the step, if they change places.
    """

    robots: Pair
    time: int
    cell: int | None
    before: int | None = None


@dataclass(eq=False)
class ConflictNode:
    """A node of a conflict tree.

    Attributes:
        parent: parent of the node; the root has none.
        constraints: constraints that hold in the node and not in its parent.
        routes: route of each robot.
        ways: way of each robot, one of its route.
        conflicts: conflicts of the ways by pair.
        split: conflict for which the node has children; ``None`` for leaves.
    """

    parent: ConflictNode | None
    constraints: tuple[Constraint, ...]
    routes: list[Route]
    ways: list[TracedWay]
    conflicts: dict[Pair, list[Conflict]]
    split: Conflict | None = None

    @property
    def cost(self) -> int:
        """The sum of the costs of the ways."""
        return sum(way.cost for way in self.ways)

    @property
    def least(self) -> int:
        """The sum of the costs of the cheapest ways."""
        return sum(route.cost for route in self.routes)


class ConflictTree:
    """The conflict tree of a problem; the cost of a way is its number of steps.

    Args:
        problem: problem to solve.
        w: number that the cost of a robot's way is at most times the cost of its cheapest.

    Raises:
        PlanError: the robots have headings.

    Attributes:
        problem: problem to solve.
        nodes: all nodes so far, the root first.
        solution: node whose ways are the plan, once there is one.
    """

    def __init__(self, problem: Problem, w: float = 1.0) -> None:
        problem.refuse_headings("CBS")
        self.problem, self.w, self.nodes = problem, w, list[ConflictNode]()
        self.solution: ConflictNode | None = None
        self._sets, self._deadline = CellSets(problem.graph), inf
        self._starts = [self._sets.bits[cell] for cell in problem.starts]
        self._goals = [self._sets.bits[cell] for cell in problem.goals]
        self._delays: dict[tuple[Route, Route], Pair | None] = {}
        self._kept: list[Route | TracedWay] = []
        self._most_kept: float = inf

    def solve(self, seconds: float) -> Plan:
        """Return a plan.

        Raises:
            PlanError: none was found in time; without a plan the tree need not have an end.
        """
        self._deadline = perf_counter() + seconds
        try:
            self.solution, bound = self._grow()
            return Plan.of([way.cells for way in self.solution.ways], bound)
        except TimeoutError:
            nodes = counted(len(self.nodes), "node")
            raise PlanError(f"no plan in {seconds:g} s and {nodes} of the conflict tree") from None

    def _grow(self) -> tuple[ConflictNode, int]:
        """Return a leaf without conflicts, and a bound on the costs of all plans."""
        root, numbers = self._root(), count()
        heap = [(root.cost, len(root.conflicts), next(numbers), root)]
        while heap:
            bound, _, _, node = heappop(heap)
            if not node.conflicts:
                return node, bound
            delays = self._late(node)
            lowest = node.least + separate_delays(delays)
            # A node whose bound turns out to be higher waits for its turn.
            grown = [node] if lowest > bound else self._split(node, delays, node.cost)
            for each in grown:
                key = max(bound, lowest, each.cost), len(each.conflicts), next(numbers)
                heappush(heap, (*key, each))
        raise PlanError(NO_PLAN)

    def _root(self) -> ConflictNode:
        """Return the root, with which the tree begins anew."""
        node = ConflictNode(None, (), [], [], {})
        for robot in range(self.problem.robots):
            node.routes.append(self._route(robot, node))
            node.ways.append(self._way(robot, node))
        self._find_conflicts(node, set(range(self.problem.robots)))
        most = self._sets.bytes * _horizon(way.cost for way in node.ways)
        self._most_kept = max(MAX_BYTES // most, LEAST_KEPT * self.problem.robots)
        self.nodes = [node]
        return node

    def _late(self, node: ConflictNode) -> dict[Pair, Pair]:
        """Return the delays of each pair that clashes; see ``delays_of``."""
        found = {}
        for pair in node.conflicts:
            self._look_at_clock()
            one, other = routes = node.routes[pair[0]], node.routes[pair[1]]
            if routes not in self._delays:
                self._delays[routes] = delays_of(self._sets, one, other)
            delays = self._delays[routes]
            if delays is not None:
                found[pair] = delays
        return found

    def _split(
        self, node: ConflictNode, delays: dict[Pair, Pair], most: float
    ) -> list[ConflictNode]:
        """Return the children of a node, or the node itself with other ways: a bypass.

        A child that has fewer conflicts at a cost of at most ``most``, and no higher bound, takes
        the place of its parent.
        """
        conflict, statement, follows = self._question(node, delays)
        found = []
        for constraints in ((statement,), (statement._replace(holds=True), *follows)):
            child = self._child(node, constraints)
            if child is None:
                continue
            is_quieter = len(child.conflicts) < len(node.conflicts)
            if is_quieter and child.least == node.least and child.cost <= most:
                node.ways, node.conflicts = child.ways, child.conflicts
                return [node]
            found.append(child)
        node.split = conflict
        self.nodes += found
        return found

    def _question(
        self, node: ConflictNode, delays: dict[Pair, Pair]
    ) -> tuple[Conflict, Constraint, list[Constraint]]:
        """Return the conflict to split, the statement that decides it, and what follows from it."""
        if delays:
            pair = max(delays, key=lambda each: min(delays[each]))
            late = [
                Constraint(robot, node.routes[robot].cost + delay - 1, None)
                for robot, delay in zip(pair, delays[pair], strict=True)
            ]
            if delays[pair][0] < delays[pair][1]:  # the one that would be later is asked
                late.reverse()
            return Conflict(pair, late[0].time, None), late[0], late[1:]
        conflict = min(
            (each for found in node.conflicts.values() for each in found),
            key=lambda each: (_resting(node, each) is None, min(_widths(node, each)), each.time),
        )
        _, time, cell, before = conflict
        robot = _resting(node, conflict)
        if robot is not None:
            return conflict, Constraint(robot, time, None), []
        one, other = _widths(node, conflict)
        if one >= other:  # the robot that has more cells to choose from is asked
            return conflict, Constraint(conflict.robots[0], time, cell, before), []
        cell, before = (cell, None) if before is None else (before, cell)
        return conflict, Constraint(conflict.robots[1], time, cell, before), []

    def _child(
        self, node: ConflictNode, constraints: tuple[Constraint, ...]
    ) -> ConflictNode | None:
        """Return the node in which some more constraints hold, or ``None`` if it has no plan."""
        child = ConflictNode(node, constraints, [*node.routes], [*node.ways], node.conflicts)
        robots = dict.fromkeys([rule.robot for rule in constraints])
        robots |= dict.fromkeys(self._others(child, constraints[0]))
        for robot in robots:
            child.routes[robot] = self._route(robot, child)
            if child.routes[robot].cost < 0:
                return None
        changed = set()
        new = {rule.robot for rule in constraints if not rule.holds}
        for robot in robots:
            route = child.routes[robot]
            if robot in new or not route.allows(child.ways[robot], self._slack(route)):
                child.ways[robot] = self._way(robot, child)
                changed.add(robot)
        self._find_conflicts(child, changed)
        return child

    def _others(self, node: ConflictNode, constraint: Constraint) -> Iterator[int]:
        """Return the other robots whose cheapest ways, or whose way, a constraint forbids."""
        if not constraint.holds:
            return
        rules, bits = Rules(), self._sets.bits
        rules.add(self._sets, constraint, False, self._goals[constraint.robot])
        for robot, (route, way) in enumerate(zip(node.routes, node.ways, strict=True)):
            if robot == constraint.robot:
                continue
            end = max(route.cost, way.cost) + 1  # from then on it is in its own goal
            closed = [*rules.closed.items()]
            for begin, cells in rules.ends.items():
                closed += [(time, cells) for time in range(begin, end)]
            for time, barred in rules.into.items():
                for cell, before in barred.items():
                    if before & (route.layer(time - 1) | bits[way.at(time - 1)]):
                        closed.append((time, cell))
            if any(cells & (route.layer(time) | bits[way.at(time)]) for time, cells in closed):
                yield robot

    def _route(self, robot: int, node: ConflictNode | None) -> Route:
        """Return the route of a robot by the constraints of a node and of those above it."""
        self._look_at_clock()
        rules = Rules()
        while node is not None:
            for rule in node.constraints:
                if rule.robot == robot or rule.holds:
                    rules.add(self._sets, rule, rule.robot == robot, self._goals[rule.robot])
            node = node.parent
        route = Route(self._sets, rules, self._starts[robot], self._goals[robot])
        self._keep(route)
        return route

    def _way(self, robot: int, node: ConflictNode) -> TracedWay:
        """Return a way of a robot with few conflicts with the others that have one."""
        route, others = node.routes[robot], node.ways[:robot] + node.ways[robot + 1 :]
        slack = self._slack(route)
        horizon = _horizon([*(way.cost for way in others), route.cost + slack])
        way = route.quietest(others, horizon, slack)
        self._keep(way)
        return way

    def _slack(self, route: Route) -> int:
        return int(self.w * route.cost) - route.cost

    def _find_conflicts(self, node: ConflictNode, changed: set[int]) -> None:
        """Take over the conflicts of the ways of robots that have changed."""
        horizon = _horizon(way.cost for way in node.ways)
        traces = [way.trace(self._sets, horizon) for way in node.ways]
        node.conflicts = {
            pair: found for pair, found in node.conflicts.items() if changed.isdisjoint(pair)
        }
        layer = 8 * self._sets.bytes
        for robot in sorted(changed):
            self._look_at_clock()
            near = traces[robot] | traces[robot] << layer  # who swaps enters where it was before
            for other, trace in enumerate(traces):
                if near & trace and other != robot:
                    pair = (robot, other) if robot < other else (other, robot)
                    found = _conflicts(pair, node.ways[pair[0]], traces, layer)
                    if found:
                        node.conflicts[pair] = found

    def _look_at_clock(self) -> None:
        if perf_counter() > self._deadline:
            raise TimeoutError

    def _keep(self, thing: Route | TracedWay) -> None:
        """Take over a route or a way that keeps sets, and let all forget them now and then."""
        self._kept.append(thing)
        if len(self._kept) % self._most_kept == 0:
            for each in self._kept:
                each.forget()


def solve_cbs(problem: Problem, seconds: float) -> Plan:
    """Return an optimal plan; see ``problem.Solver``.

    Example:
        >>> from agents.mapf.cbs import solve_cbs
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.problem import Problem
        >>> from warehouse_core import Layout
        >>> problem = Problem(Graph(Layout(["...", "..."])), starts=[0, 2], goals=[2, 0])
        >>> plan = solve_cbs(problem, seconds=10)
        >>> plan.sum_of_costs == plan.bound
        True
    """
    return ConflictTree(problem).solve(seconds)


def _horizon(times: Iterable[int]) -> int:
    """Return a time after some times."""
    return (max(times, default=0) // ROUND + 1) * ROUND


def _widths(node: ConflictNode, conflict: Conflict) -> list[int]:
    """Return how many cells the cheapest ways of both robots have where they are in conflict."""
    times = range(conflict.time - (conflict.before is not None), conflict.time + 1)
    return [
        max(node.routes[robot].layer(time).bit_count() for time in times)
        for robot in conflict.robots
    ]


def _resting(node: ConflictNode, conflict: Conflict) -> int | None:
    """Return the robot that is in conflict where it has arrived, or ``None``."""
    arrived = [robot for robot in conflict.robots if conflict.time >= node.ways[robot].cost]
    return arrived[0] if arrived and conflict.before is None else None


def separate_delays(delays: dict[Pair, Pair]) -> int:
    """Return what pairs of robots cost more, where no robot is in two; dear pairs come first."""
    paired, total = set[int](), 0
    for pair, both in sorted(delays.items(), key=lambda each: -min(each[1])):
        if paired.isdisjoint(pair):
            paired.update(pair)
            total += min(both)
    return total


def _conflicts(pair: Pair, one: TracedWay, traces: Sequence[int], layer: int) -> list[Conflict]:
    """Return all conflicts of two robots.

    Args:
        pair: numbers of the robots.
        one: way of the first robot.
        traces: traces of all robots.
        layer: number of bits of a trace for each time.
    """
    ours, theirs = (traces[robot] for robot in pair)
    times = _times(ours & theirs, layer)
    found = [Conflict(pair, time, one.at(time)) for time in times]
    left, entered = ours & theirs >> layer, theirs & ours >> layer
    if left and entered:
        for time in set(_times(left, layer)).intersection(_times(entered, layer)):
            if one.at(time) != one.at(time + 1):
                found.append(Conflict(pair, time + 1, one.at(time + 1), one.at(time)))
    return found


def _times(trace: int, layer: int) -> list[int]:
    """Return the times at which a trace has cells."""
    return [(bit.bit_length() - 1) // layer for bit in bits_of(trace)]
