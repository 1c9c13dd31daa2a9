"""Routes under random rules are those that trying out all ways gives."""

import random

from agents.mapf.cell_sets import CellSets, bits_of
from agents.mapf.graph import WAIT, Graph
from agents.mapf.route import Route, TracedPath
from agents.mapf.rules import Constraint, Rules
from warehouse_core import Layout

LAYOUT = Layout(["...", ".#.", "..."])
GRAPH = Graph(LAYOUT)
SETS = CellSets(GRAPH)
CELLS = LAYOUT.open_cells.tolist()
MOST, HORIZON, SLACK = 7, 16, 2
"""Steps of the longest ways that are tried out, and of other robots; slack of wide layers."""


def ways_to(goal: int, way: list[int]) -> list[list[int]]:
    """Return all ways that go on from a way and end when they have arrived for good."""
    found = [way] if way[-1] == goal and way[-2:-1] != [goal] else []
    if len(way) <= MOST:
        near = [cell for cell in GRAPH.neighbours[way[-1], : WAIT + 1].tolist() if cell >= 0]
        for cell in near:
            found += ways_to(goal, [*way, cell])
    return found


def at(way: list[int], time: int) -> int:
    return way[min(time, len(way) - 1)]


def keeps(way: list[int], rule: Constraint, is_own: bool, goal: int) -> bool:
    """Return whether a way keeps a constraint on its robot, or one that holds for another."""
    _, time, cell, before, holds = rule
    if cell is None:
        if is_own:
            return (len(way) - 1 <= time) == holds
        return all(at(way, each) != goal for each in range(time, HORIZON))
    move = at(way, time - 1), at(way, time)
    if is_own:
        return (move[1] == cell and before in (None, move[0])) == holds
    if before is None:
        return move[1] != cell
    return move[1] != cell and move[0] != before and move != (cell, before)


def conflicts(way: list[int], others: list[TracedPath]) -> int:
    """Return the times at which a way is in another's cell, and at which it changes places."""
    count = 0
    for time in range(1, HORIZON + 1):
        before, cell = at(way, time - 1), at(way, time)
        count += any(other.at(time) == cell for other in others)
        count += before != cell and any(
            (other.at(time), other.at(time - 1)) == (before, cell) for other in others
        )
    return count


def random_rules(stream: random.Random, start: int, goal: int) -> list[tuple[Constraint, int]]:
    """Return constraints on robots 0 and 1, each with the goal of its robot."""
    found, other_goal = [], stream.choice([cell for cell in CELLS if cell != goal])
    for _ in range(stream.randint(0, 3)):
        robot, time, cell = stream.choice([0, 0, 1]), stream.randint(1, 4), stream.choice(CELLS)
        before = stream.choice([None, stream.choice(GRAPH.neighbours[cell, :WAIT].tolist())])
        if before == -1 or (before is not None and time == 1 and robot == 1 and before == start):
            continue
        cell, before = (None, None) if stream.random() < 0.3 else (cell, before)
        rule = Constraint(robot, time, cell, before, robot == 1 or stream.random() < 0.4)
        found.append((rule, other_goal if robot else goal))
    return found


def test_routes_and_quiet_ways_are_those_of_all_ways() -> None:
    stream, solved, quiet = random.Random(4), 0, 0
    for _ in range(150):
        start, goal = stream.choice(CELLS), stream.choice(CELLS)
        rules, given = Rules(), random_rules(stream, start, goal)
        for rule, its_goal in given:
            rules.add(SETS, rule, rule.robot == 0, SETS.bits[its_goal])
        route = Route(SETS, rules, SETS.bits[start], SETS.bits[goal])
        kept = [
            way
            for way in ways_to(goal, [start])
            if all(keeps(way, rule, rule.robot == 0, its_goal) for rule, its_goal in given)
        ]
        if not kept:
            assert route.cost == -1 or route.cost > MOST, given
            continue
        solved += 1
        cost = min(map(len, kept)) - 1
        assert route.cost == cost, (start, goal, given)
        for time, cells in enumerate(route.layers()):
            cheapest = {way[time] for way in kept if len(way) == cost + 1}
            assert {SETS.cell(bit) for bit in bits_of(cells)} == cheapest, (start, goal, given)
        if cost + SLACK > MOST:
            continue
        near = [way for way in kept if len(way) <= cost + 1 + SLACK]
        for time, cells in enumerate(route.layers(SLACK)):
            assert all(SETS.bits[at(way, time)] & cells for way in near), (start, goal, given)
        for way in kept:
            assert route.allows(TracedPath(way), SLACK) == (way in near)
        others = [TracedPath(stream.choice(kept)), TracedPath(stream.choice(kept)[::-1])]
        found = route.quietest(others, HORIZON, SLACK)
        assert found.cells in near
        choice = [way for way in near if cost == 0 or at(way, cost - 1) != goal]
        best = min((conflicts(way, others), len(way)) for way in choice)
        assert (conflicts(found.cells, others), len(found.cells)) == best, (start, goal, given)
        quiet += best[0] > 0
    assert solved > 90
    assert quiet > 30
