"""Routes under random rules, compared with brute force."""

import random

from agents.mapf.graph import WAIT, Graph
from agents.mapf.route import CellSets, Constraint, Route, Rules, TracedPath, bits_of
from warehouse_core import Layout

LAYOUT = Layout(["...", ".#.", "..."])
GRAPH = Graph(LAYOUT)
SETS = CellSets(GRAPH)
CELLS = LAYOUT.open_cells.tolist()
MOST, HORIZON, SLACK = 7, 16, 2
"""Longest paths in steps, of the robot and of others, and the slack of wide layers."""


def paths_to(goal: int, path: list[int]) -> list[list[int]]:
    """Return all continuations of a path up to their final arrival."""
    paths = [path] if path[-1] == goal and path[-2:-1] != [goal] else []
    if len(path) <= MOST:
        near = [cell for cell in GRAPH.neighbours[path[-1], : WAIT + 1].tolist() if cell >= 0]
        for cell in near:
            paths += paths_to(goal, [*path, cell])
    return paths


def at(path: list[int], time: int) -> int:
    return path[min(time, len(path) - 1)]


def keeps(path: list[int], rule: Constraint, is_own: bool, goal: int) -> bool:
    """Return whether a path satisfies a constraint on its own or another robot."""
    _, time, cell, before, holds = rule
    if cell is None:
        if is_own:
            return (len(path) - 1 <= time) == holds
        return all(at(path, each) != goal for each in range(time, HORIZON))
    move = at(path, time - 1), at(path, time)
    if is_own:
        return (move[1] == cell and before in (None, move[0])) == holds
    if before is None:
        return move[1] != cell
    return move[1] != cell and move[0] != before and move != (cell, before)


def conflicts(path: list[int], others: list[TracedPath]) -> int:
    """Return the number of conflicts of a path with others."""
    count = 0
    for time in range(1, HORIZON + 1):
        before, cell = at(path, time - 1), at(path, time)
        count += any(other.at(time) == cell for other in others)
        count += before != cell and any(
            (other.at(time), other.at(time - 1)) == (before, cell) for other in others
        )
    return count


def random_rules(stream: random.Random, start: int, goal: int) -> list[tuple[Constraint, int]]:
    """Return constraints on robots 0 and 1, each with the goal of its robot."""
    paths, other_goal = [], stream.choice([cell for cell in CELLS if cell != goal])
    for _ in range(stream.randint(0, 3)):
        robot, time, cell = stream.choice([0, 0, 1]), stream.randint(1, 4), stream.choice(CELLS)
        before = stream.choice([None, stream.choice(GRAPH.neighbours[cell, :WAIT].tolist())])
        if before == -1 or (before is not None and time == 1 and robot == 1 and before == start):
            continue
        cell, before = (None, None) if stream.random() < 0.3 else (cell, before)
        rule = Constraint(robot, time, cell, before, robot == 1 or stream.random() < 0.4)
        paths.append((rule, other_goal if robot else goal))
    return paths


def test_routes_and_quiet_paths_equal_brute_force() -> None:
    stream, solved, quiet = random.Random(4), 0, 0
    for _ in range(150):
        start, goal = stream.choice(CELLS), stream.choice(CELLS)
        rules, given = Rules(), random_rules(stream, start, goal)
        for rule, its_goal in given:
            rules.add(SETS, rule, rule.robot == 0, SETS.bits[its_goal])
        route = Route(SETS, rules, SETS.bits[start], SETS.bits[goal])
        kept = [
            path
            for path in paths_to(goal, [start])
            if all(keeps(path, rule, rule.robot == 0, its_goal) for rule, its_goal in given)
        ]
        if not kept:
            assert route.cost == -1 or route.cost > MOST, given
            continue
        solved += 1
        cost = min(map(len, kept)) - 1
        assert route.cost == cost, (start, goal, given)
        for time, cells in enumerate(route.layers()):
            cheapest = {path[time] for path in kept if len(path) == cost + 1}
            assert {SETS.cell(bit) for bit in bits_of(cells)} == cheapest, (start, goal, given)
        if cost + SLACK > MOST:
            continue
        near = [path for path in kept if len(path) <= cost + 1 + SLACK]
        for time, cells in enumerate(route.layers(SLACK)):
            assert all(SETS.bits[at(path, time)] & cells for path in near), (start, goal, given)
        for path in kept:
            assert route.allows(TracedPath(path), SLACK) == (path in near)
        others = [TracedPath(stream.choice(kept)), TracedPath(stream.choice(kept)[::-1])]
        paths = route.quietest(others, HORIZON, SLACK)
        assert paths.cells in near
        choice = [path for path in near if cost == 0 or at(path, cost - 1) != goal]
        best = min((conflicts(path, others), len(path)) for path in choice)
        assert (conflicts(paths.cells, others), len(paths.cells)) == best, (start, goal, given)
        quiet += best[0] > 0
    assert solved > 90
    assert quiet > 30
