"""Steps of robots with headings: an independent check, and smallest costs by brute force.

A robot is a triple of row, column and heading. The heading is ``None`` for robots that move in four
directions. No code of the planners is used.
"""

from collections.abc import Iterator, Sequence
from heapq import heappop, heappush
from itertools import product

from agents.mapf.problem import Plan, Problem

AHEAD = ((-1, 0), (0, 1), (1, 0), (0, -1))

Robot = tuple[int, int, int | None]
State = tuple[Robot, ...]


def turning_conflict(problem: Problem, plan: Plan) -> str | None:
    """Return the first fault of a plan of robots with headings, or ``None``."""
    rows = problem.graph.layout.rows
    states = [
        tuple((*divmod(int(cell), len(rows[0])), int(to)) for cell, to in zip(*step, strict=True))
        for step in zip(plan.cells, plan.headings, strict=True)
    ]
    if states[0] != first_state(problem):
        return f"it does not begin at the starts {first_state(problem)}"
    for step in range(len(states) - 1):
        for one, other in zip(states[step], states[step + 1], strict=True):
            if other not in steps_of(rows, one):
                return f"step {step}: no step leads from {one} to {other}"
        if meets(states[step], states[step + 1]):
            return f"step {step}: robots meet"
    ends = tuple(divmod(int(cell), len(rows[0])) for cell in problem.goals)
    return None if cells_of(states[-1]) == ends else "it does not end in the goals"


def first_state(problem: Problem) -> State:
    width = problem.graph.layout.width
    headings = problem.headings or [None] * problem.robots
    pairs = zip(problem.starts, headings, strict=True)
    return tuple((*divmod(cell, width), heading) for cell, heading in pairs)


def steps_of(rows: Sequence[str], state: Robot) -> list[Robot]:
    """Return where a robot can be after a step: as it is, turned, or in the cell ahead."""
    row, col, heading = state
    found = [state]
    if heading is not None:
        found += [(row, col, (heading + 1) % 4), (row, col, (heading - 1) % 4)]
    for down, right in AHEAD if heading is None else AHEAD[heading : heading + 1]:
        to = row + down, col + right
        if 0 <= to[0] < len(rows) and 0 <= to[1] < len(rows[0]) and rows[to[0]][to[1]] != "#":
            found.append((*to, heading))
    return found


def cells_of(state: State) -> tuple[tuple[int, int], ...]:
    return tuple(each[:2] for each in state)


def meets(before: State, after: State) -> bool:
    """Return whether two robots are in one cell or swap places."""
    here, there = cells_of(before), cells_of(after)
    if len(set(there)) < len(there):
        return True
    moves = {(a, b) for a, b in zip(here, there, strict=True) if a != b}
    return any((b, a) in moves for a, b in moves)


def steps_from(rows: Sequence[str], state: State) -> Iterator[State]:
    for after in product(*(steps_of(rows, each) for each in state)):
        if not meets(state, after):
            yield after


def least_step_cost(problem: Problem) -> int | None:
    """Return the smallest sum of step costs, or ``None`` if there is no plan: Dijkstra.

    A step costs 1 for each robot that is not at its goal both before and after it.
    """
    rows, first = problem.graph.layout.rows, first_state(problem)
    ends = tuple(divmod(cell, len(rows[0])) for cell in problem.goals)
    best, heap = {first: 0}, [(0, first)]
    while heap:
        cost, state = heappop(heap)
        if cells_of(state) == ends:
            return cost
        if cost > best[state]:
            continue
        for after in steps_from(rows, state):
            total = cost + sum(
                not one == other == end
                for one, other, end in zip(cells_of(state), cells_of(after), ends, strict=True)
            )
            if total < best.get(after, total + 1):
                best[after] = total
                heappush(heap, (total, after))
    return None
