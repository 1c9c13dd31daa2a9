"""Conflict-based search: optimal plans, by a tree of constraints on single robots.

The root has the cheapest way of each robot. Where two are in conflict, one child forbids it to the
one robot and one child to the other, and only that robot is planned again. The cheapest leaf is
first; if its ways have no conflict they are an optimal plan.

Conflicts are prioritised. The *MDD* of a robot holds all its cheapest ways. A conflict is cardinal
if it raises the costs of both robots, and is split first, and semi-cardinal if of one: where a
robot's MDD has one cell only. Two robots are dependent, too, if every pair of ways in their MDDs
has a conflict somewhere; then the one or the other takes longer, which is what the children say.
Separate pairs of dependent robots bound the cost below a node. A child of no more cost and fewer
conflicts than its parent takes the place of the parent's ways (a *bypass*).

Sources: Sharon et al. (2015), Conflict-based search for optimal multi-agent pathfinding, Artificial
Intelligence 219. Boyarski et al. (2015), ICBS, IJCAI. Felner et al. (2018), Adding heuristics to
conflict-based search, ICAPS, and Li et al. (2019), Improved heuristics, IJCAI: dependent pairs.
Sharon et al. (2013), The increasing cost tree search, Artificial Intelligence 195: their split.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush
from itertools import combinations, count
from time import perf_counter
from typing import NamedTuple

from agents.errors import PlanError
from agents.mapf.graph import Graph
from agents.mapf.problem import Plan, Problem
from agents.mapf.reservations import Reservations
from agents.mapf.space_time import find_way, moves_of
from warehouse_core.wording import counted

TOLL = 2.0**-12
"""Cost of a conflict with another robot's way, so that among ways of equal length one with few
conflicts is taken. A power of two below any sum of conflicts keeps the costs exact.
"""

CARDINAL = 2
"""Robots of a cardinal conflict whose costs it raises: both."""

MAX_PAIRS = 10_000
"""Pairs of cells at one time up to which two robots are compared; beyond it they count as
independent, which weakens the bound but never makes it wrong.
"""


class Constraint(NamedTuple):
    """What a robot must not do in a joint step.

    Attributes:
        cell: cell that the robot must not be in at the time; ``None`` forbids the robot to be in
            its goal for good by then.
        before: cell that the robot must not come from; ``None`` forbids the cell altogether.
    """

    robot: int
    time: int
    cell: int | None
    before: int | None = None


class Conflict(NamedTuple):
    """Two constraints, one of which every plan without this conflict keeps."""

    one: Constraint
    other: Constraint


Judged = tuple[int, Conflict]
"""Number of its robots whose cost a conflict raises, and the conflict to split."""

MDD = list[dict[int, list[int]]]
"""Multi-valued decision diagram: by time, the cells of a robot's cheapest ways, each with the cells
that follow it.
"""


@dataclass(eq=False)
class ConflictNode:
    """A node of the conflict tree: the cheapest way of each robot, and all conflicts between them.

    ``constraint`` is what it adds to its parent's, and ``split`` the conflict that its children
    forbid. The root has no parent and no constraint, and a leaf no split.
    """

    parent: ConflictNode | None
    constraint: Constraint | None
    ways: Sequence[list[int]]
    conflicts: list[Conflict]
    cost: int = field(init=False)
    split: Conflict | None = None

    def __post_init__(self) -> None:
        self.cost = sum(len(way) - 1 for way in self.ways)

    def constraints(self, robot: int) -> frozenset[Constraint]:
        """Return the constraints on a robot, from here up to the root."""
        found, node = set(), self
        while node.parent is not None and node.constraint is not None:
            if node.constraint.robot == robot:
                found.add(node.constraint)
            node = node.parent
        return frozenset(found)


class ConflictTree:
    """The tree of a problem, which grows until it has a plan; the cost of a way is its length.

    Attributes:
        nodes: all nodes so far, the root first.
        solution: node whose ways are an optimal plan, once there is one.
    """

    def __init__(self, problem: Problem) -> None:
        graph = problem.graph if problem.graph.costs is None else Graph(problem.graph.layout)
        self.problem, self.nodes = problem, list[ConflictNode]()
        self.solution: ConflictNode | None = None
        self._size, self._moves = graph.size, moves_of(graph)
        self._fields = [graph.distances(goal).tolist() for goal in problem.goals]
        self._mdds: dict[tuple[int, frozenset[Constraint]], MDD] = {}
        self._dependent: dict[tuple[int, int], bool] = {}

    def solve(self, seconds: float) -> Plan:
        """Return an optimal plan.

        Raises:
            PlanError: none was found in time; without a plan the tree has no end.
        """
        self._deadline = perf_counter() + seconds
        try:
            self.solution = self._grow()
            return Plan.of(self.solution.ways, self.solution.cost)
        except TimeoutError:
            nodes = counted(len(self.nodes), "node")
            raise PlanError(f"no plan in {seconds:g} s and {nodes} of the conflict tree") from None

    def _grow(self) -> ConflictNode:
        """Return the first leaf without conflicts."""
        root = self._root()
        self.nodes, numbers = [root], count()
        heap = [(root.cost, len(root.conflicts), next(numbers), root)]
        while heap:
            bound, _, _, node = heappop(heap)
            if perf_counter() > self._deadline:
                raise TimeoutError
            if not node.conflicts:
                return node
            judged = [self._judge(node, conflict) for conflict in node.conflicts]
            lowest = node.cost + _separate_pairs(judged)
            # A node whose bound turns out to be higher waits for its turn.
            grown = [node] if lowest > bound else self._split(node, judged)
            for each in grown:
                key = max(bound, lowest, each.cost), len(each.conflicts), next(numbers)
                heappush(heap, (*key, each))
        raise PlanError("there is no plan: some robot has no way that keeps clear of the others")

    def _root(self) -> ConflictNode:
        ways: list[list[int]] = []
        for robot in range(self.problem.robots):
            way = self._find(robot, frozenset(), dict(enumerate(ways)))
            ways.append(way or [])  # never empty: a problem has a way for each robot
        pairs = combinations(range(len(ways)), 2)
        return ConflictNode(
            None, None, ways, [each for pair in pairs for each in _conflicts(ways, *pair)]
        )

    def _split(self, node: ConflictNode, judged: list[Judged]) -> list[ConflictNode]:
        """Return the children of a node, or the node itself with other ways: a bypass."""
        _, split = max(judged, key=lambda each: (each[0], -each[1].one.time))
        found = []
        for constraint in split:
            child = self._child(node, constraint)
            if child is None:
                continue
            if child.cost == node.cost and len(child.conflicts) < len(node.conflicts):
                node.ways, node.conflicts = child.ways, child.conflicts
                return [node]
            found.append(child)
        node.split = split
        self.nodes += found
        return found

    def _child(self, node: ConflictNode, constraint: Constraint) -> ConflictNode | None:
        """Return the node in which one more constraint holds, or ``None`` if it has no way."""
        robot, ways = constraint.robot, list(node.ways)
        others = {other: way for other, way in enumerate(ways) if other != robot}
        way = self._find(robot, node.constraints(robot) | {constraint}, others)
        if way is None:
            return None
        ways[robot] = way
        kept = [each for each in node.conflicts if robot not in (each.one.robot, each.other.robot)]
        new = [each for other in others for each in _conflicts(ways, *sorted((robot, other)))]
        return ConflictNode(node, constraint, ways, kept + new)

    def _find(
        self, robot: int, constraints: frozenset[Constraint], others: dict[int, list[int]]
    ) -> list[int] | None:
        """Return the cheapest way of a robot, of equal ones one with few conflicts with others."""
        start, goal = self.problem.starts[robot], self.problem.goals[robot]
        taken, end = Reservations(self._size), 0
        longest = max(map(len, others.values()), default=0)
        for other, way in others.items():
            taken.add(other, way + [way[-1]] * (longest - len(way)))
        for _, time, cell, before in constraints:
            taken.latest = max(taken.latest, time)
            if cell is None:
                end = max(end, time + 1)
                continue
            state = time * self._size + cell
            if before is None:
                taken.closed.add(state)
                end = max(end, time + 1) if cell == goal else end
            else:
                taken.closed_moves.add((state - cell - self._size + before) * self._size + cell)
        found = find_way(
            self._moves, self._fields[robot], start, goal, taken,
            end=end, toll=TOLL, deadline=self._deadline,
        )  # fmt: skip
        return None if found is None else found.cells

    def _judge(self, node: ConflictNode, conflict: Conflict) -> Judged:
        """Return how many of its robots a conflict costs more, and the conflict to split."""
        one, other = (self._mdd(node, each.robot) for each in conflict)
        forced = _is_forced(one, conflict.one) + _is_forced(other, conflict.other)
        if forced == CARDINAL:
            return forced, conflict
        key = id(one), id(other)  # the MDDs live as long as the tree
        if key not in self._dependent:
            self._dependent[key] = _meet(one, other)
        if not self._dependent[key]:
            return forced, conflict
        ends = (Constraint(each.robot, len(node.ways[each.robot]) - 1, None) for each in conflict)
        return CARDINAL, Conflict(*ends)

    def _mdd(self, node: ConflictNode, robot: int) -> MDD:
        """Return all ways of a robot that cost as much as its way in a node."""
        constraints, cost = node.constraints(robot), len(node.ways[robot]) - 1
        if (robot, constraints) in self._mdds:
            return self._mdds[robot, constraints]
        closed = {(each.time, each.cell, each.before) for each in constraints}
        field, goal = self._fields[robot], self.problem.goals[robot]
        layer, moves = {self.problem.starts[robot]}, MDD()
        for time in range(1, cost + 1):
            moves.append({
                cell: [
                    to
                    for to, *_ in self._moves[cell]
                    if field[to] <= cost - time
                    and not {(time, to, None), (time, to, cell)} & closed
                ]
                for cell in layer
            })  # fmt: skip
            layer = {to for reached in moves[-1].values() for to in reached}
        after: dict[int, list[int]] = {goal: [goal]}
        for time in reversed(range(cost)):
            kept = {cell: [to for to in ways if to in after] for cell, ways in moves[time].items()}
            after = moves[time] = {cell: ways for cell, ways in kept.items() if ways}
        self._mdds[robot, constraints] = [*moves, {goal: [goal]}]
        return self._mdds[robot, constraints]


def solve_cbs(problem: Problem, seconds: float) -> Plan:
    """Return an optimal plan; see ``problem.Solver``."""
    return ConflictTree(problem).solve(seconds)


def _conflicts(ways: Sequence[list[int]], one: int, other: int) -> Iterator[Conflict]:
    """Return all conflicts of the ways of two robots."""
    steps = max(len(ways[one]), len(ways[other]))
    ours, theirs = (way + way[-1:] * (steps - len(way)) for way in (ways[one], ways[other]))
    for time in range(1, steps):
        here, there = ours[time], theirs[time]
        if here == there:
            yield Conflict(Constraint(one, time, here), Constraint(other, time, here))
        elif here == theirs[time - 1] and there == ours[time - 1]:
            first = Constraint(one, time, here, there)
            yield Conflict(first, Constraint(other, time, there, here))


def _is_forced(mdd: MDD, constraint: Constraint) -> bool:
    """Return whether all ways of an MDD break a constraint that one of them breaks."""
    first = constraint.time - (constraint.before is not None)
    times = range(first, constraint.time + 1)
    return all(len(mdd[min(time, len(mdd) - 1)]) == 1 for time in times)


def _meet(one: MDD, other: MDD) -> bool:
    """Return whether every pair of ways has a conflict, as far as ``MAX_PAIRS`` allow to say."""
    pairs = {(ours, theirs) for ours in one[0] for theirs in other[0]}
    for time in range(max(len(one), len(other)) - 1):
        our, their = (mdd[min(time, len(mdd) - 1)] for mdd in (one, other))
        pairs = {
            (to, there)
            for ours, theirs in pairs
            for to in our[ours]
            for there in their[theirs]
            if to != there and not (to == theirs and there == ours)
        }
        if len(pairs) > MAX_PAIRS:
            return False
    return not pairs


def _separate_pairs(judged: Iterable[Judged]) -> int:
    """Return a number of pairs of dependent robots, where no robot is in two."""
    paired = set[int]()
    for kind, (one, other) in judged:
        if kind == CARDINAL and not {one.robot, other.robot} & paired:
            paired |= {one.robot, other.robot}
    return len(paired) // 2
