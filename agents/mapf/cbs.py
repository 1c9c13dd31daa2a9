"""CBS, conflict-based search: optimal plans from a tree of constraints on single robots.

The root of the tree has a cheapest path for each robot. A node with a conflict is split by a
question about one of its two robots, such as whether it is in a cell at a time. In one child the
robot must not be there. In the other child it must be there, and all other robots have to keep
away. Only robots whose paths the new constraint forbids are replanned. The children have no plan in
common, and together they have all plans of their parent (*disjoint splitting*). The cheapest leaf
is expanded first. If its paths have no conflict, they are an optimal plan.

Two robots *clash* if every pair of their cheapest paths has a conflict, as in corridors, in
rectangles and at goals. The question is then whether the first robot arrives late; if it does not,
the second one does. Their delays are computed in advance, so that a long corridor needs only two
children, and both cost more than their parent. Pairs of clashing robots with no robot in common
give a lower bound on the cost below a node.

Other conflicts are ordered by the number of cells that one of the robots could have been in at the
time, fewest first. If a robot rests at its goal, the question is whether it has arrived.

Sources: Sharon et al. (2015), Conflict-based search for optimal multi-agent pathfinding, Artificial
Intelligence 219. Boyarski et al. (2015), ICBS, IJCAI, for the choice of conflicts and for bypasses.
Felner et al. (2018), Adding heuristics to conflict-based search, ICAPS. Li et al. (2019), Disjoint
splitting for multi-agent path finding with conflict-based search, ICAPS. Li et al. (2021), Pairwise
symmetry reasoning for multi-agent path finding search, Artificial Intelligence 301. Sharon et al.
(2013), The increasing cost tree search, Artificial Intelligence 195, for pairs of MDDs.
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
from agents.mapf.problem import Plan, Problem
from agents.mapf.route import CellSets, Constraint, Route, Rules, TracedPath, bits_of
from warehouse_core.wording import counted

__all__ = ["solve_cbs"]

Pair = tuple[int, int]
"""Numbers of two robots, the smaller first."""

ROUND = 16
"""Step between possible horizons. Rounded horizons seldom change, so that traces can be reused."""

NO_PLAN = "there is no plan: some robot has no path that avoids the others"

MAX_BYTES = 500_000_000
"""Approximate memory for layers and traces, beyond which they are dropped."""

LEAST_KEPT = 4
"""Number of layers and traces per robot that are always kept at first."""

MAX_CELLS = 10_000
"""Limit on the cells of a robot, summed over all times, for a comparison of two robots.

Beyond it, the two count as robots without a clash. This weakens the bound but keeps it valid.
"""

MAX_DELAY = 64
"""Largest delay of a robot that is tested."""


class Conflict(NamedTuple):
    """Two robots in one cell, or two robots that swap cells.

    Attributes:
        robots: the two robots.
        time: number of the joint step.
        cell: cell of the first robot after the step.
        before: cell of the first robot before the step if the two swap cells.
    """

    robots: Pair
    time: int
    cell: int
    before: int | None = None


@dataclass(eq=False)
class ConflictNode:
    """A node of a conflict tree.

    Attributes:
        parent: parent of the node; the root has none.
        constraints: constraints of the node that its parent does not have.
        routes: route of each robot, the set of paths that the constraints allow.
        paths: chosen path of each robot.
        conflicts: conflicts of the paths by pair.
    """

    parent: ConflictNode | None
    constraints: tuple[Constraint, ...]
    routes: list[Route]
    paths: list[TracedPath]
    conflicts: dict[Pair, list[Conflict]]

    @property
    def cost(self) -> int:
        """The sum of the costs of the chosen paths."""
        return sum(path.cost for path in self.paths)

    @property
    def least(self) -> int:
        """The sum of the costs of the cheapest paths."""
        return sum(route.cost for route in self.routes)


class ConflictTree:
    """The conflict tree of a problem, where the cost of a path is its number of steps.

    Args:
        problem: problem to solve.
        w: factor by which the path of a robot may cost more than its cheapest path.

    Raises:
        PlanError: the robots have headings.

    Attributes:
        nodes: number of nodes so far.
    """

    def __init__(self, problem: Problem, w: float = 1.0) -> None:
        problem.refuse_headings("CBS")
        self.problem, self.w, self.nodes = problem, w, 0
        self._sets, self._deadline = CellSets(problem.graph), inf
        self._starts = [self._sets.bits[cell] for cell in problem.starts]
        self._goals = [self._sets.bits[cell] for cell in problem.goals]
        self._delays: dict[tuple[Route, Route], Pair | None] = {}
        self._kept: list[Route | TracedPath] = []
        self._most_kept: float = inf

    def solve(self, seconds: float) -> Plan:
        """Return a plan.

        Raises:
            PlanError: no plan was found in time. If no plan exists, the tree may be infinite.
        """
        self._deadline = perf_counter() + seconds
        try:
            node, bound = self._grow()
            return Plan.of([path.cells for path in node.paths], bound)
        except TimeoutError:
            nodes = counted(self.nodes, "node")
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
            # A node whose bound turns out to be higher goes back into the queue.
            grown = [node] if lowest > bound else self._split(node, delays, node.cost)
            for each in grown:
                key = max(bound, lowest, each.cost), len(each.conflicts), next(numbers)
                heappush(heap, (*key, each))
        raise PlanError(NO_PLAN)

    def _root(self) -> ConflictNode:
        """Return the root of a new tree."""
        node = ConflictNode(None, (), [], [], {})
        for robot in range(self.problem.robots):
            node.routes.append(self._route(robot, node))
            node.paths.append(self._path(robot, node))
        self._find_conflicts(node, set(range(self.problem.robots)))
        most = self._sets.bytes * _horizon(path.cost for path in node.paths)
        self._most_kept = max(MAX_BYTES // most, LEAST_KEPT * self.problem.robots)
        self.nodes = 1
        return node

    def _late(self, node: ConflictNode) -> dict[Pair, Pair]:
        """Return the delays of each pair that clashes; see ``delays_of``."""
        clashes = {}
        for pair in node.conflicts:
            self._look_at_clock()
            one, other = routes = node.routes[pair[0]], node.routes[pair[1]]
            if routes not in self._delays:
                self._delays[routes] = delays_of(self._sets, one, other)
            delays = self._delays[routes]
            if delays is not None:
                clashes[pair] = delays
        return clashes

    def _split(
        self, node: ConflictNode, delays: dict[Pair, Pair], most: float
    ) -> list[ConflictNode]:
        """Return the children of a node, or the node itself with other paths (a *bypass*).

        A child replaces the paths of its parent if it has fewer conflicts, no higher bound, and a
        cost of at most ``most``.
        """
        statement, follows = self._question(node, delays)
        children = []
        for constraints in ((statement,), (statement._replace(holds=True), *follows)):
            child = self._child(node, constraints)
            if child is None:
                continue
            is_quieter = len(child.conflicts) < len(node.conflicts)
            if is_quieter and child.least == node.least and child.cost <= most:
                node.paths, node.conflicts = child.paths, child.conflicts
                return [node]
            children.append(child)
        self.nodes += len(children)
        return children

    def _question(
        self, node: ConflictNode, delays: dict[Pair, Pair]
    ) -> tuple[Constraint, list[Constraint]]:
        """Return the constraint that splits a node, and what follows if it has to be false."""
        if delays:
            pair = max(delays, key=lambda each: min(delays[each]))
            late = [
                Constraint(robot, node.routes[robot].cost + delay - 1, None)
                for robot, delay in zip(pair, delays[pair], strict=True)
            ]
            if delays[pair][0] < delays[pair][1]:  # ask the robot that would be later
                late.reverse()
            return late[0], late[1:]
        conflict = min(
            (each for conflicts in node.conflicts.values() for each in conflicts),
            key=lambda each: (_resting(node, each) is None, min(_widths(node, each)), each.time),
        )
        _, time, cell, before = conflict
        robot = _resting(node, conflict)
        if robot is not None:
            return Constraint(robot, time, None), []
        one, other = _widths(node, conflict)
        if one >= other:  # ask the robot that has more cells to choose from
            return Constraint(conflict.robots[0], time, cell, before), []
        cell, before = (cell, None) if before is None else (before, cell)
        return Constraint(conflict.robots[1], time, cell, before), []

    def _child(
        self, node: ConflictNode, constraints: tuple[Constraint, ...]
    ) -> ConflictNode | None:
        """Return the child with some more constraints, or ``None`` if it has no plan."""
        child = ConflictNode(node, constraints, [*node.routes], [*node.paths], node.conflicts)
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
            if robot in new or not route.allows(child.paths[robot], self._slack(route)):
                child.paths[robot] = self._path(robot, child)
                changed.add(robot)
        self._find_conflicts(child, changed)
        return child

    def _others(self, node: ConflictNode, constraint: Constraint) -> Iterator[int]:
        """Yield the other robots whose cheapest or chosen paths a positive constraint forbids."""
        if not constraint.holds:
            return
        rules, bits = Rules(), self._sets.bits
        rules.add(self._sets, constraint, False, self._goals[constraint.robot])
        for robot, (route, path) in enumerate(zip(node.routes, node.paths, strict=True)):
            if robot == constraint.robot:
                continue
            end = max(route.cost, path.cost) + 1  # from then on it rests at its own goal
            closed = [*rules.closed.items()]
            for begin, cells in rules.ends.items():
                closed += [(time, cells) for time in range(begin, end)]
            for time, barred in rules.into.items():
                for cell, before in barred.items():
                    if before & (route.layer(time - 1) | bits[path.at(time - 1)]):
                        closed.append((time, cell))
            if any(cells & (route.layer(time) | bits[path.at(time)]) for time, cells in closed):
                yield robot

    def _route(self, robot: int, node: ConflictNode | None) -> Route:
        """Return the route of a robot under the constraints of a node and of its ancestors."""
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

    def _path(self, robot: int, node: ConflictNode) -> TracedPath:
        """Return a path of a robot that has few conflicts with the paths of the others."""
        route, others = node.routes[robot], node.paths[:robot] + node.paths[robot + 1 :]
        slack = self._slack(route)
        horizon = _horizon([*(path.cost for path in others), route.cost + slack])
        path = route.quietest(others, horizon, slack)
        self._keep(path)
        return path

    def _slack(self, route: Route) -> int:
        return int(self.w * route.cost) - route.cost

    def _find_conflicts(self, node: ConflictNode, changed: set[int]) -> None:
        """Update the conflicts of the robots whose paths have changed."""
        horizon = _horizon(path.cost for path in node.paths)
        traces = [path.trace(self._sets, horizon) for path in node.paths]
        node.conflicts = {
            pair: conflicts
            for pair, conflicts in node.conflicts.items()
            if changed.isdisjoint(pair)
        }
        layer = 8 * self._sets.bytes
        for robot in sorted(changed):
            self._look_at_clock()
            # In a swap, the other robot enters the cell that this one leaves.
            near = traces[robot] | traces[robot] << layer
            for other, trace in enumerate(traces):
                if near & trace and other != robot:
                    pair = (robot, other) if robot < other else (other, robot)
                    conflicts = _conflicts(pair, node.paths[pair[0]], traces, layer)
                    if conflicts:
                        node.conflicts[pair] = conflicts

    def _look_at_clock(self) -> None:
        if perf_counter() > self._deadline:
            raise TimeoutError

    def _keep(self, thing: Route | TracedPath) -> None:
        """Register a route or path that caches sets, and clear all caches now and then."""
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
    """Return a rounded time that is later than all the given times."""
    return (max(times, default=0) // ROUND + 1) * ROUND


def _widths(node: ConflictNode, conflict: Conflict) -> list[int]:
    """Return the number of cells that the cheapest paths of each robot have at a conflict."""
    times = range(conflict.time - (conflict.before is not None), conflict.time + 1)
    return [
        max(node.routes[robot].layer(time).bit_count() for time in times)
        for robot in conflict.robots
    ]


def _resting(node: ConflictNode, conflict: Conflict) -> int | None:
    """Return the robot that has arrived at its goal where a conflict occurs, or ``None``."""
    arrived = [robot for robot in conflict.robots if conflict.time >= node.paths[robot].cost]
    return arrived[0] if arrived and conflict.before is None else None


def separate_delays(delays: dict[Pair, Pair]) -> int:
    """Return the extra cost of pairs that have no robot in common, chosen from the costliest on."""
    paired, total = set[int](), 0
    for pair, both in sorted(delays.items(), key=lambda each: -min(each[1])):
        if paired.isdisjoint(pair):
            paired.update(pair)
            total += min(both)
    return total


def _conflicts(pair: Pair, one: TracedPath, traces: Sequence[int], layer: int) -> list[Conflict]:
    """Return all conflicts of two robots, the first of which has the path ``one``.

    ``traces`` holds the trace of each robot, with ``layer`` bits for each time.
    """
    ours, theirs = (traces[robot] for robot in pair)
    times = _times(ours & theirs, layer)
    conflicts = [Conflict(pair, time, one.at(time)) for time in times]
    left, entered = ours & theirs >> layer, theirs & ours >> layer
    if left and entered:
        for time in set(_times(left, layer)).intersection(_times(entered, layer)):
            if one.at(time) != one.at(time + 1):
                conflicts.append(Conflict(pair, time + 1, one.at(time + 1), one.at(time)))
    return conflicts


def _times(trace: int, layer: int) -> list[int]:
    """Return the times at which a trace has cells."""
    return [(bit.bit_length() - 1) // layer for bit in bits_of(trace)]


def delays_of(sets: CellSets, one: Route, other: Route) -> tuple[int, int] | None:
    """Return delays of two robots, such that in every plan one of them is at least that late.

    Both are 1 or more. ``None`` means that the robots do not clash. For each cell of one robot at a
    time, the search keeps the set of cells of the other robot. It thus detects the symmetries of
    rectangles, targets and corridors without testing for each of them.
    """
    known: dict[tuple[int, int], bool] = {}

    def clash(our: int, their: int) -> bool:
        """Return whether the robots clash even if each may be late by less than its delay."""
        if max(our, their) > MAX_DELAY:
            return False
        if (our, their) not in known:
            known[our, their] = _clash(sets, one.layers(our - 1), other.layers(their - 1))
        return known[our, their]

    if not clash(1, 1):
        return None
    ours = theirs = 1
    for a, b in ((1, 1), (1, 0), (0, 1)):
        more = 1
        while clash(ours + a * more, theirs + b * more):
            ours, theirs, more = ours + a * more, theirs + b * more, 2 * more
        while more := more // 2:
            if clash(ours + a * more, theirs + b * more):
                ours, theirs = ours + a * more, theirs + b * more
    return ours, theirs


def _clash(sets: CellSets, ours: list[int], theirs: list[int]) -> bool:
    """Return whether every two paths through layers have a conflict."""
    if sum(map(int.bit_count, ours)) > sum(map(int.bit_count, theirs)):
        ours, theirs = theirs, ours  # enumerate the cells of the robot that has fewer
    end = max(len(ours), len(theirs))
    ours, theirs = ours + ours[-1:] * (end - len(ours)), theirs + theirs[-1:] * (end - len(theirs))
    near = [
        time
        for time in range(1, end)
        if ours[time] & theirs[time]
        or (ours[time] & theirs[time - 1] and ours[time - 1] & theirs[time])
    ]
    if not near:
        return False
    begin, looked_at = near[0] - 1, 0
    with_us = dict.fromkeys(bits_of(ours[begin]), theirs[begin])
    for time in range(near[0], near[-1] + 1):
        looked_at += len(with_us)
        if looked_at > MAX_CELLS:
            return False
        with_us = _after(sets, with_us, ours[time], theirs[time])
        if not with_us:
            return True
    return False


def _after(sets: CellSets, with_us: dict[int, int], our: int, their: int) -> dict[int, int]:
    """Return the cells of the other robot for each cell of this one, a step after ``with_us``.

    After the step, this robot may be in the cells ``our``, and the other one in ``their``.
    """
    after: dict[int, int] = {}
    for before, cells in with_us.items():
        reached = sets.spread(cells) & their
        for cell in sets.steps_from(before):
            if cell & our:
                there = reached & ~cell
                # They must not swap cells: the other must not come from this robot's new cell.
                if there & before and cell & cells and not sets.spread(before) & cells & ~cell:
                    there ^= before
                if there:
                    after[cell] = after.get(cell, 0) | there
    return after
