"""Search algorithms, in the terms of Russell and Norvig, all based on one best-first search.

A *problem* has an initial state, actions, a transition model, action costs and a goal test. A
*node* is a state with the path that led to it. The *frontier* contains the nodes that have been
generated but not yet expanded. *Reached* contains the best known path to each state. Each algorithm
expands the node with the lowest value of f next. The algorithms differ only in f:

| algorithm         | evaluation function f                 | section |
| ----------------- | ------------------------------------- | ------- |
| breadth-first     | the depth                             | 3.4.1   |
| uniform-cost      | g, the path cost                      | 3.4.2   |
| greedy best-first | h, the heuristic                      | 3.5.1   |
| A*                | g + h                                 | 3.5.2   |
| weighted A*       | g + W h                               | 3.5.4   |

Among nodes with equal f, the node generated last is expanded first. On a grid, where many paths are
equally long, the search then follows one of these paths instead of extending all of them. The
frontier is therefore a heap of values of f, with a stack of nodes for each value.

A better path to a state that has been expanded *reopens* the state, so it is expanded again. A*
with an inconsistent heuristic needs this to find the best path, and weighted A* needs it for its
bound. Greedy best-first search gives no bound, and might expand the same state many times, so
reopening is off by default there.

Source: Russell and Norvig, Artificial Intelligence, 4th ed., ch. 3.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, replace
from heapq import heappop, heappush
from typing import Any, Generic, NamedTuple, TypeVar, cast

from warehouse_core.wording import brief

S = TypeVar("S", bound=Hashable)
A = TypeVar("A")

Evaluation = Callable[[S, float], float]
"""The evaluation function f of a node's state and the cost of its path."""

MAX_WEIGHT = 1_000_000
"""Largest finite weight; with much larger weights, estimates overflow to infinity."""

Heuristic = Callable[[S], float]
"""The heuristic h, an estimate of the cost from a state to the nearest goal."""

Node = tuple[float, S, Any, A | None]
"""The cost of a path, its last state, its parent node and the last action. The initial node has
``None`` for the parent and the action."""

CLOSED: Node[Any, Any] = (-math.inf, None, None, None)
"""Replaces the node of an expanded state that must not be reopened: no path can cost less."""


class Problem(ABC, Generic[S, A]):
    """A search problem (section 3.1.1).

    Attributes:
        initial: the initial state.

    Example:
        >>> from agents.search import Problem, breadth_first_search
        >>> class Count(Problem):
        ...     initial = 1
        ...
        ...     def is_goal(self, state):
        ...         return state == 10
        ...
        ...     def actions(self, state):
        ...         return ["add 1", "double"]
        ...
        ...     def result(self, state, action):
        ...         return state + 1 if action == "add 1" else 2 * state
        >>> breadth_first_search(Count()).actions
        ('add 1', 'double', 'add 1', 'double')
    """

    initial: S

    @abstractmethod
    def is_goal(self, state: S) -> bool:
        """Return whether a state is a goal."""

    @abstractmethod
    def actions(self, state: S) -> Iterable[A]:
        """Return the actions that are possible in a state."""

    @abstractmethod
    def result(self, state: S, action: A) -> S:
        """Return the state to which an action leads: the transition model."""

    def action_cost(self, state: S, action: A, successor: S) -> float:
        """Return the cost of an action, which must be at least 0; the default is 1."""
        return 1.0

    def expand(self, state: S) -> Sequence[tuple[A, S, float]]:
        """Return each action with its result and cost: EXPAND in figure 3.7."""
        results = [(action, self.result(state, action)) for action in self.actions(state)]
        return [(action, to, self.action_cost(state, action, to)) for action, to in results]


class Event(NamedTuple):
    """One expansion of a node, recorded for pictures.

    Attributes:
        expanded: state of the node.
        reached: states to which this expansion found a first or a better path.
    """

    expanded: Hashable
    reached: tuple[Hashable, ...]


@dataclass(frozen=True)
class Solution(Generic[S, A]):
    """The result of a search.

    Attributes:
        states: states of the path from the initial state to a goal; empty without a path.
        actions: actions of the path; empty without a path.
        cost: cost of the path; infinite without a path.
        generated: number of nodes generated, including the initial node.
        expanded: number of nodes expanded.
        largest_frontier: largest number of nodes in the frontier, including outdated ones.
        events: one event for each expansion, in order, if they were requested.

    Example:
        >>> from agents.search import RouteProblem, Solution, uniform_cost_search
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> found: Solution = uniform_cost_search(RouteProblem(DEFAULT_LAYOUT, (1, 1), (1, 3)))
        >>> found.actions, found.cost, found.expanded
        (('E', 'E'), 2.0, 3)
    """

    states: tuple[S, ...]
    actions: tuple[A, ...]
    cost: float
    generated: int
    expanded: int
    largest_frontier: int
    events: tuple[Event, ...] = ()

    @property
    def found(self) -> bool:
        """``True`` if there is a path."""
        return bool(self.states)


def best_first_search(
    problem: Problem[S, A],
    evaluate: Evaluation[S],
    *,
    with_events: bool = False,
    reopen: bool = True,
    expand: Callable[[S], Sequence[tuple[A, S, float]]] | None = None,
) -> Solution[S, A]:
    """Repeatedly expand the node with the lowest f until this node is a goal (figure 3.7).

    A node with an infinite f is not added to the frontier, because no goal is reachable from it.

    Args:
        problem: problem to solve.
        evaluate: evaluation function f.
        with_events: record each expansion.
        reopen: expand a state again if a better path to it is found.
        expand: function to use instead of ``problem.expand``.

    Raises:
        ValueError: the cost of an action that leads to a new state or on a better path is negative
            or NaN.

    Example:
        >>> from agents.search import RouteProblem, best_first_search
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> problem = RouteProblem(DEFAULT_LAYOUT, (1, 1), (5, 10))
        >>> best_first_search(problem, lambda state, path_cost: path_cost).cost
        13.0
    """
    value = evaluate(problem.initial, 0.0)
    node: Node[S, A] = (0.0, problem.initial, None, None)
    reached = {problem.initial: node}
    stacks, values = {value: [node]}, [value]
    waiting = largest = generated = 1
    expanded = 0
    events: list[Event] = []
    # Methods are looked up once instead of for each node, because this loop dominates the run time.
    expand, is_goal = expand or problem.expand, problem.is_goal
    best_known, stack_of = reached.get, stacks.get
    while values:
        stack = stacks[values[0]]
        if not stack:
            del stacks[heappop(values)]
            continue
        node = stack.pop()
        waiting -= 1
        cost, state, _, _ = node
        if node is not reached[state]:
            continue  # outdated: a better path to this state has been found
        if is_goal(state):
            states, actions = _path(node)
            return Solution(states, actions, cost, generated, expanded, largest, tuple(events))
        expanded += 1
        if not reopen:
            reached[state] = CLOSED
        fresh: list[S] = []
        edges = expand(state)
        generated += len(edges)
        for action, successor, action_cost in edges:
            path_cost = cost + action_cost
            known = best_known(successor)
            if known is None or path_cost < known[0]:
                if not action_cost >= 0:
                    raise ValueError(f"{action!r} in {state!r} costs {action_cost!r}; at least 0")
                value = evaluate(successor, path_cost)
                if value == math.inf:
                    continue  # no goal is reachable from there
                reached[successor] = child = (path_cost, successor, node, action)
                equals = stack_of(value)
                if equals is None:
                    stacks[value] = [child]
                    heappush(values, value)
                else:
                    equals.append(child)
                waiting += 1
                if with_events:
                    fresh.append(successor)
        if waiting > largest:
            largest = waiting
        if with_events:
            events.append(Event(state, tuple(fresh)))
    return Solution((), (), math.inf, generated, expanded, largest, tuple(events))


def breadth_first_search(problem: Problem[S, A], *, with_events: bool = False) -> Solution[S, A]:
    """Find a path with the fewest actions, regardless of their costs (section 3.4.1).

    Example:
        >>> from agents.search import RouteProblem, breadth_first_search
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> breadth_first_search(RouteProblem(DEFAULT_LAYOUT, (1, 1), (1, 3))).actions
        ('E', 'E')
    """

    def expand(state: S) -> Sequence[tuple[A, S, float]]:
        return [(action, successor, 1.0) for action, successor, _ in problem.expand(state)]

    solution = best_first_search(problem, path_cost, with_events=with_events, expand=expand)
    steps = zip(solution.states, solution.actions, solution.states[1:], strict=False)
    cost = sum((problem.action_cost(*step) for step in steps), 0.0)
    return replace(solution, cost=cost if solution.found else math.inf)


def uniform_cost_search(problem: Problem[S, A], *, with_events: bool = False) -> Solution[S, A]:
    """Find a path of least cost by expanding states in order of path cost (section 3.4.2).

    Example:
        >>> from agents.search import RouteProblem, uniform_cost_search
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> uniform_cost_search(RouteProblem(DEFAULT_LAYOUT, (1, 1), (5, 10))).expanded
        37
    """
    return best_first_search(problem, path_cost, with_events=with_events)


def greedy_best_first_search(
    problem: Problem[S, A],
    heuristic: Heuristic[S],
    *,
    with_events: bool = False,
    reopen: bool = False,
) -> Solution[S, A]:
    """Find a path by expanding the node with the lowest heuristic value (section 3.5.1).

    No state is expanded twice, unless ``reopen`` is true, which often gives a better path.

    Example:
        >>> from agents.search import RouteProblem, greedy_best_first_search, manhattan
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> problem = RouteProblem(DEFAULT_LAYOUT, (1, 1), (5, 10))
        >>> greedy_best_first_search(problem, manhattan(problem)).expanded
        17
    """
    return weighted_astar_search(
        problem, heuristic, math.inf, with_events=with_events, reopen=reopen
    )


def astar_search(
    problem: Problem[S, A], heuristic: Heuristic[S], *, with_events: bool = False
) -> Solution[S, A]:
    """Find a path with A*, of least cost if the heuristic never overestimates (section 3.5.2).

    Example:
        >>> from agents.search import RouteProblem, astar_search, manhattan
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> problem = RouteProblem(DEFAULT_LAYOUT, (1, 1), (5, 10))
        >>> found = astar_search(problem, manhattan(problem))
        >>> found.cost, found.expanded
        (13.0, 17)
    """
    return weighted_astar_search(problem, heuristic, 1.0, with_events=with_events)


def weighted_astar_search(
    problem: Problem[S, A],
    heuristic: Heuristic[S],
    weight: float,
    *,
    with_events: bool = False,
    reopen: bool | None = None,
) -> Solution[S, A]:
    """Find a path with weighted A*, often much faster but not always optimal (section 3.5.4).

    Args:
        problem: problem to solve.
        heuristic: heuristic h.
        weight: weight W of the heuristic. With 0 this is uniform-cost search, with 1 A*, and with
            infinity greedy best-first search. If h never overestimates, the path costs at most
            ``max(1, weight)`` times the least cost.
        with_events: record each expansion.
        reopen: expand a state again if a better path to it is found. By default this is on for all
            weights except infinity. Without it, the bound requires a consistent heuristic.

    Raises:
        ValueError: ``check_weight`` does not allow the weight.

    Example:
        >>> from agents.search import RouteProblem, manhattan, weighted_astar_search
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> problem = RouteProblem(DEFAULT_LAYOUT, (1, 1), (5, 10))
        >>> weighted_astar_search(problem, manhattan(problem), weight=2).expanded
        17
    """
    return best_first_search(
        problem,
        weighted(heuristic, weight),
        with_events=with_events,
        reopen=weight != math.inf if reopen is None else reopen,
    )


def path_cost(state: Hashable, cost: float) -> float:
    """Return the path cost g as the evaluation of a node."""
    return cost


def weighted(heuristic: Heuristic[S], weight: float) -> Evaluation[S]:
    """Return the evaluation function g + W h.

    Raises:
        ValueError: ``check_weight`` does not allow the weight.
    """
    check_weight(weight)
    if weight == 0:
        return path_cost
    if weight == 1:
        return lambda state, cost: cost + heuristic(state)
    if weight == math.inf:
        return lambda state, cost: heuristic(state)
    return lambda state, cost: cost + weight * heuristic(state)


def check_weight(weight: float) -> None:
    """Check the weight of a heuristic.

    Raises:
        ValueError: the weight is neither infinity nor a number from 0 to ``MAX_WEIGHT``.
    """
    is_number = isinstance(weight, (int, float)) and not isinstance(weight, bool)
    if not is_number or not (0 <= weight <= MAX_WEIGHT or weight == math.inf):
        raise ValueError(f"weight is {brief(weight)}; it must be 0..{MAX_WEIGHT} or infinity")


def _path(node: Node[S, A]) -> tuple[tuple[S, ...], tuple[A, ...]]:
    """Return the states and the actions that lead to a node."""
    states, actions = list[S](), list[A]()
    while True:
        _, state, before, action = node
        states.append(state)
        if before is None:
            return tuple(reversed(states)), tuple(reversed(actions))
        actions.append(cast(A, action))
        node = before
