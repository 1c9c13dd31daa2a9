"""Robots that people or staying robots hold up go around them or give way."""

import numpy as np
import pytest

from agents.fleet.detours import LONG_PATIENCE, PATIENCE, Detours
from agents.mapf.graph import Graph
from agents.registry import make_fleet_agent
from warehouse_core import Cell, FleetEnv, Layout, Order, shelf_layout
from warehouse_core.records.recorder import record_fleet_episode

RING = Layout(["......", ".####.", "......"])
TREE = Layout([".......", "###.###", "###.###"])
Aims = list[dict[int, Cell]]


def aims(
    layout: Layout,
    cells: list[Cell],
    goals: list[Cell],
    people: list[Cell],
    stays: int = 0,
    cell_steps: int = 1,
    steps: int = PATIENCE,
) -> Aims:
    """Return the goals in each step of robots that do not move; the last ones always stay."""
    detours, robots = Detours(Graph(layout), len(cells), cell_steps), np.arange(len(cells))
    here, there, persons = (layout.numbers(each) for each in (cells, goals, people))
    found = [
        detours.goals(here, there, robots >= len(cells) - stays, persons)
        for _ in range(steps * cell_steps + 1)
    ]
    return [{robot: layout.cell(aim) for robot, aim in each.items()} for each in found]


@pytest.mark.parametrize("is_person", [True, False])
def test_a_robot_goes_around_an_obstacle(is_person: bool) -> None:
    others = [] if is_person else [(0, 2)]
    found = aims(RING, [(0, 1), *others], [(0, 4), *others], [(0, 2)] * is_person, len(others))
    assert found[:PATIENCE] == [{}] * PATIENCE
    assert found[PATIENCE] == {0: (0, 0)}


def test_a_detour_ends_where_the_shortest_path_no_longer_leads_through_the_obstacle() -> None:
    detours, path, nobody = Detours(Graph(RING), 1), [1], np.array([False])
    for _ in range(12):
        person, goal = RING.numbers([(0, 2)]), RING.numbers([(0, 4)])
        path.append(detours.goals(np.array(path[-1:]), goal, nobody, person).get(0, path[-1]))
    assert RING.cells([*dict.fromkeys(path)]) == [(0, 1), (0, 0), (1, 0), (2, 0), (2, 1)]


def test_a_robot_that_takes_four_steps_for_a_cell_waits_four_times_longer() -> None:
    found = aims(RING, [(0, 1)], [(0, 4)], [(0, 2)], cell_steps=4)
    assert [bool(each) for each in found] == [False] * (4 * PATIENCE) + [True]


def test_a_robot_that_waits_for_another_next_to_a_person_takes_priority() -> None:
    assert aims(RING, [(0, 1)], [(2, 0)], [(0, 2)])[-1] == {0: (2, 0)}


def test_a_robot_goes_back_behind_a_junction_to_let_a_person_out() -> None:
    assert aims(TREE, [(1, 3)], [(2, 3)], [(2, 3)])[-1] == {0: (0, 3)}
    # The person could go on, but only along the robot's path.
    assert aims(TREE, [(0, 3)], [(2, 3)], [(1, 3)])[-1] == {0: (0, 2)}


def test_a_robot_waits_longer_for_a_person_who_can_leave_its_path() -> None:
    found = aims(TREE, [(2, 3)], [(0, 0)], [(1, 3)], cell_steps=4, steps=LONG_PATIENCE)
    assert found == [{}] * 4 * LONG_PATIENCE + [{0: (2, 3)}]  # it stands at the end
    cells = [(2, 3), (0, 3)]
    assert aims(TREE, cells, [(0, 0), (0, 6)], [(1, 3)])[-1][0] == (2, 3)  # the person is enclosed
    robots = [(2, 3), (1, 3)]
    assert aims(TREE, robots, [(0, 0), (1, 3)], [], 1)[-1] == {0: (2, 3)}  # that robot stays


def test_robots_that_enclose_a_person_back_off_even_without_a_goal() -> None:
    cells = [(0, 1), (0, 3)]
    assert set(aims(RING, cells, cells, [(0, 2)])[-1]) == {0, 1}
    assert aims(RING, cells[:1], cells[:1], [(0, 2)])[-1] == {}


def test_a_robot_waits_for_one_that_stays_at_its_goal() -> None:
    assert aims(RING, [(0, 1), (0, 2)], [(0, 2)] * 2, [], 1)[-1] == {}


def test_another_goal_ends_a_detour() -> None:
    graph, nobody = Graph(RING), np.array([False])
    detours, person = Detours(graph, 1), RING.numbers([(0, 2)])

    def go(cell: Cell, goal: Cell) -> dict[int, int]:
        return detours.goals(RING.numbers([cell]), RING.numbers([goal]), nobody, person)

    def wait(cell: Cell, goal: Cell) -> dict[int, int]:
        return [go(cell, goal) for _ in range(PATIENCE + 1)][-1]

    aim = wait((0, 1), (0, 4))[0]
    assert go((1, 0), (0, 4)) == {0: aim}
    assert go(RING.cell(aim), (0, 4)).get(0) != aim
    assert wait((0, 1), (0, 4)) == {0: aim}
    assert go((0, 1), (0, 3)) == {}
    wait((0, 1), (0, 4))
    assert go((2, 0), (0, 4)) == {0: aim}
    assert wait((2, 0), (0, 4)) == {}  # it cannot move on, but not because of the person


def test_a_fleet_with_a_person_in_narrow_aisles_does_not_freeze() -> None:
    layout = shelf_layout(3, 4, 5, aisle=1, pickups=6, dropoffs=3, seed=1)
    env = FleetEnv(layout, 11, orders=0.4, people=1, battery=999, max_steps=300, dispatch=False)
    agent = make_fleet_agent("pibt:guidance=lanes", "urgent", 1, layout, 11)
    assert record_fleet_episode(env, agent, seed=1).measures.delivered > 60  # it froze after 20


@pytest.mark.filterwarnings("ignore:0 chargers")
def test_a_path_leads_around_a_robot_with_a_flat_battery() -> None:
    layout = Layout(["P....D", ".####.", "......"])
    orders = [Order(0, 90, (0, 0), (0, 5))]
    env = FleetEnv(
        layout, 2, orders=orders, starts=[(0, 0), (0, 3)], max_steps=40, dispatch=False, battery=99
    )
    env.reset(seed=0)
    agent = make_fleet_agent("pibt", layout=layout)
    env._engine.battery[1] = 1
    while not env.ended[0]:
        env.step(agent.act(env))
    assert env.measures.delivered == 1
    assert env.steps < 15
