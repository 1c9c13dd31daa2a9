"""EPIBT, which plans for robots with headings, and for others."""

import numpy as np
import pytest

from agents.errors import AgentError, PlanError
from agents.fleet import PlannedFleet
from agents.mapf.epibt import EPIBT, outward_cells, turning_operations
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from agents.mapf.planner import NO_CELLS, Situation, check_turns
from warehouse_core import FleetEnv, Layout, random_layout, record_episode, shelf_layout
from warehouse_core.world.moves import FORWARD, LEFT, RIGHT, TURN_ACTIONS

AHEAD = ((-1, 0), (0, 1), (1, 0), (0, -1))


def check(layout: Layout, before: list, after: list, fixed: set[int], closed: set) -> None:  # type: ignore[type-arg]
    """Check a joint step of cells and headings by the rules, with no code of the planners."""
    cells = [cell for cell, _ in after]
    assert len(set(cells)) == len(cells)
    for robot, ((cell, heading), (to, turned)) in enumerate(zip(before, after, strict=True)):
        if to == cell:
            assert (turned - heading) % 4 in ((0,) if robot in fixed else (0, 1, 3))
            continue
        down, right = AHEAD[heading]
        assert (to, turned) == ((cell[0] + down, cell[1] + right), heading)
        assert robot not in fixed
        assert layout.is_open(to)
        assert to not in closed
        assert all(one != to or other != cell for (one, _), (other, _) in zip(before, after))  # noqa: B905


@pytest.mark.parametrize(("robots", "tries"), [(12, 0.0), (40, 2.0), (70, 0.0)])
def test_steps_of_robots_with_headings_follow_the_rules(robots: int, tries: float) -> None:
    layout, stream = random_layout(14, 14, 0.2, seed=2), np.random.default_rng(robots)
    graph = Graph(layout)
    planner = EPIBT(graph, seed=1, tries=tries)
    cells, goals = (stream.permutation(layout.open_cells)[:robots] for _ in range(2))
    headings, reached = stream.integers(4, size=robots), 0
    for _ in range(30):
        stays, closed = stream.random(robots) < 0.05, stream.permutation(layout.open_cells)[:3]
        situation = Situation(cells, goals, stays, closed)
        places = check_turns(graph, situation, headings, planner.next_places(situation, headings))
        before = list(zip(layout.cells(cells), headings.tolist(), strict=True))
        headings, cells = np.divmod(places, graph.size)
        after = list(zip(layout.cells(cells), headings.tolist(), strict=True))
        check(layout, before, after, {*np.flatnonzero(stays).tolist()}, {*layout.cells(closed)})
        reached += int((cells == goals).sum())
        goals = np.where(cells == goals, stream.permutation(layout.open_cells)[:robots], goals)
    assert reached > robots / 3


def test_one_robot_takes_as_many_steps_as_its_distance_with_turns() -> None:
    layout = random_layout(12, 12, 0.2, seed=3)
    graph = Graph(layout)
    planner, field = EPIBT(graph), Graph(layout, turn_cost=1.0).distances(int(layout.open_cells[0]))
    for cell in layout.open_cells[::9].tolist():
        place, steps = graph.size + cell, 0
        while place % graph.size != layout.open_cells[0]:
            headings, cells = np.divmod(np.array([place]), graph.size)
            goal = layout.open_cells[:1]
            situation = Situation(cells, goal, np.array([False]), NO_CELLS)
            [place] = planner.next_places(situation, headings)
            steps += 1
        assert steps == field[graph.size + cell]


def test_a_robot_that_heads_the_wrong_way_is_pushed_out_of_the_way() -> None:
    layout = Layout(["#.#", "...", "#.#"])
    graph = Graph(layout)
    planner, cells, headings = EPIBT(graph), np.array([3, 4]), np.array([1, 3])
    goals = np.array([5, 3])  # they meet head-on, and the second has to turn before it can leave
    for _ in range(12):
        situation = Situation(cells, goals, np.array([False, False]), NO_CELLS)
        headings, cells = np.divmod(planner.next_places(situation, headings), graph.size)
        if (cells == goals).all():
            return
    raise AssertionError("they are still in each other's way")


def test_equal_seeds_give_equal_runs_and_operations_are_different_ways() -> None:
    graph = Graph(random_layout(12, 12, 0.2, seed=1))
    one, other, third = (
        run_lifelong(graph, EPIBT(graph, seed), 20, 40, 1, has_headings=True).cells
        for seed in (1, 1, 2)
    )
    assert np.array_equal(one, other)
    assert not np.array_equal(one, third)
    found = turning_operations(2).tolist()
    wait = TURN_ACTIONS.index("WAIT")
    assert found[0] == [wait, wait]
    assert sorted(found) == sorted([
        [wait, wait], [FORWARD, FORWARD], [FORWARD, wait], [wait, FORWARD], [FORWARD, RIGHT],
        [FORWARD, LEFT], [RIGHT, FORWARD], [LEFT, FORWARD], [RIGHT, wait], [LEFT, wait],
        [RIGHT, RIGHT],
    ])  # fmt: skip


def test_dead_ends_lead_outwards() -> None:
    layout = Layout(["...#", ".#..", "...#"])
    outward = outward_cells(Graph(layout))
    assert {cell: int(outward[cell]) for cell in range(12) if outward[cell] >= 0} == {7: 6}
    layout = Layout(["..#.", "...."])
    outward = outward_cells(Graph(layout))
    assert {cell: int(outward[cell]) for cell in range(8) if outward[cell] >= 0} == {
        3: 7, 7: 6, 6: 5
    }  # fmt: skip


def test_robots_without_headings_are_led_too() -> None:
    graph = Graph(random_layout(12, 12, 0.2, seed=1))
    assert run_lifelong(graph, EPIBT(graph, window=2), 8, 50, 1).reached > 30


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_a_fleet_with_headings_delivers(backend: str) -> None:
    layout = shelf_layout(aisle=2, pickups=4, chargers=2)
    env = FleetEnv(
        layout, 6, orders=0.2, max_steps=120, dispatch=False, moves="turn", backend=backend
    )
    shift = record_episode(env, PlannedFleet(EPIBT(Graph(layout))), seed=1)
    assert shift.measures.delivered > 5
    assert shift.measures.blocked_by_robot == shift.measures.blocked_by_wall == 0


def test_a_planner_without_headings_is_refused() -> None:
    layout = shelf_layout(aisle=2)
    env = FleetEnv(layout, 2, orders=0.1, dispatch=False, moves="turn", seed=1)
    env.reset()
    with pytest.raises(AgentError, match=r"^planner PIBT does not know headings"):
        PlannedFleet(PIBT(Graph(layout))).act(env)


@pytest.mark.parametrize(
    ("place", "message"),
    [
        (2, "robot 0 heads east at (0, 1) and is to be at (0, 2), heading north"),
        (3 + 0, "robot 0 heads east at (0, 1) and is to be at (0, 0), heading east"),
        (9 + 1, "robot 0 heads east at (0, 1) and is to be at (0, 1), heading west"),
        (12, "robot 0 heads east at (0, 1) and is to be at (0, 0), heading 4"),
    ],
)
def test_a_step_that_no_robot_can_take_is_refused(place: int, message: str) -> None:
    graph, cell, east = Graph(Layout(["..."])), np.array([1]), np.array([1])
    situation = Situation(cell, cell, np.array([False]), NO_CELLS)
    with pytest.raises(PlanError) as caught:
        check_turns(graph, situation, east, np.array([place]))
    assert str(caught.value) == message
    with pytest.raises(PlanError, match="needed: a place for each of 1 robots"):
        check_turns(graph, situation, east, [1.5])
