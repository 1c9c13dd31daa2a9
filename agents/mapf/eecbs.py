"""EECBS, explicit estimation CBS: plans that cost at most ``w`` times the optimum, with a proof.

Each robot's path costs at most ``w`` times its cheapest path, and has the fewest conflicts among
these (focal search). In the tree, each node has an estimate of its cost once its conflicts are
resolved. The cost of a conflict is learned from each node and its best child. The next node is the
one with the fewest conflicts among those with an estimate of at most ``w`` times the smallest
estimate. If this node costs more than ``w`` times the lowest bound of all leaves, the node with the
smallest estimate takes its place, and failing that, the node with the lowest bound.

Source: Li, Ruml and Koenig (2021), EECBS: a bounded-suboptimal search for multi-agent path finding,
AAAI.
"""

from __future__ import annotations

from agents.errors import PlanError
from agents.mapf.cbs import NO_PLAN, ConflictNode, ConflictTree, separate_delays
from agents.mapf.problem import Plan, Problem
from warehouse_core.arguments import real_number

__all__ = ["solve_eecbs"]

W = 1.2
"""Default limit on the ratio of the cost to the optimum."""


class Leaf:
    """A leaf of the tree, with a lower bound on the costs of the plans below it."""

    def __init__(self, node: ConflictNode, bound: int) -> None:
        self.node, self.bound = node, max(bound, node.least)
        self.cost, self.conflicts = node.cost, len(node.conflicts)


class ExplicitTree(ConflictTree):
    """A conflict tree whose next node is chosen with estimated costs."""

    def _grow(self) -> tuple[ConflictNode, int]:
        self._spent = self._removed = 0
        leaves = [Leaf(self._root(), 0)]
        while leaves:
            bound = min(leaf.bound for leaf in leaves)
            leaf = self._choose(leaves, bound)
            if not leaf.conflicts:
                return leaf.node, bound
            delays = self._late(leaf.node)
            lowest = leaf.node.least + separate_delays(delays)
            if lowest > leaf.bound:
                leaf.bound = lowest  # the others may be better now
                continue
            grown = self._split(leaf.node, delays, self.w * bound)
            leaves.remove(leaf)
            new = [Leaf(node, leaf.bound) for node in grown]
            if new and new[0].node is not leaf.node:
                child = min(new, key=lambda each: (each.conflicts, each.cost))
                self._spent += child.cost - leaf.cost
                self._removed += leaf.conflicts - child.conflicts
            leaves += new
        raise PlanError(NO_PLAN)

    def _choose(self, leaves: list[Leaf], bound: int) -> Leaf:
        """Return the next leaf to expand; its cost is at most ``w`` times the lowest bound."""
        price = self._spent / max(self._removed, 1)
        costs = [leaf.cost + price * leaf.conflicts for leaf in leaves]
        most = self.w * min(costs)
        near = [leaf for leaf, cost in zip(leaves, costs, strict=True) if cost <= most]
        quiet = min(near, key=lambda leaf: (leaf.conflicts, leaf.cost))
        if quiet.cost <= self.w * bound:
            return quiet
        expected = leaves[costs.index(min(costs))]
        if expected.cost <= self.w * bound:
            return expected
        return min(leaves, key=lambda leaf: (leaf.bound, leaf.conflicts))


def solve_eecbs(problem: Problem, seconds: float, w: float = W) -> Plan:
    """Return a plan that costs at most ``w`` times the optimum; see ``problem.Solver``.

    Raises:
        ValueError: ``w`` is below 1.
        PlanError: no plan was found in time.

    Example:
        >>> from agents.mapf.eecbs import solve_eecbs
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.problem import Problem
        >>> from warehouse_core import Layout
        >>> problem = Problem(Graph(Layout(["...", "..."])), starts=[0, 2], goals=[2, 0])
        >>> plan = solve_eecbs(problem, seconds=10, w=1.5)
        >>> plan.sum_of_costs <= 1.5 * plan.bound
        True
    """
    return ExplicitTree(problem, real_number("w", w, 1.0)).solve(seconds)
