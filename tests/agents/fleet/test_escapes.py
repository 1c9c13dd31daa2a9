"""Fleets that are stuck in narrow places get out."""

from collections.abc import Callable

import numpy as np

from agents.fleet.escapes import PATIENCE, STANDS, Course, Escapes
from agents.mapf.assignment import NONE
from agents.mapf.graph import Fields, Graph
from agents.mapf.kernels.places import FAR
from warehouse_core import Cell, Layout

DEAD_END = Layout(["P....#", "###.##", "###..D"])
Walk = Callable[[list[Cell], list[Cell]], list[Cell]]


def stays(cells: list[Cell], people: list[Cell]) -> list[Cell]:
    """Motion of people who stay where they are."""
    return people


class Floor:
    """Robots that only make planned moves, and people whose steps a function gives."""

    def __init__(self, layout: Layout, cells: list[Cell], goals: list[Cell | None]) -> None:
        self.layout, self.cells, self.people = layout, cells, list[Cell]()
        self._goals, self._fields = goals, Fields(Graph(layout))
        self._escapes = Escapes(self._fields, len(cells))
        self.held: list[int] = []

    def step(self, has_worked: bool = False, fixed: tuple[int, ...] = ()) -> dict[int, Cell]:
        """Return the aims of a step, after which the robots are there."""
        layout = self.layout
        cells, people = layout.numbers(self.cells), layout.numbers(self.people)
        goals = np.array([NONE if goal is None else layout.number(goal) for goal in self._goals])
        all_aims = np.where(goals == NONE, FAR, self._fields.distances(goals, cells))
        walls = set(cells[list(fixed)].tolist())
        found = self._escapes.aims(cells, goals, all_aims, walls, people, has_worked)
        aims = {robot: layout.cell(aim) for robot, aim in found.items()}
        self.held = self._escapes.held
        self.cells = [aims.get(robot, cell) for robot, cell in enumerate(self.cells)]
        assert len({*self.cells, *self.people}) == len(self.cells) + len(self.people)
        return aims

    def run(self, steps: int, walk: Walk = stays) -> bool:
        """Return whether a robot has reached its goal within a number of steps."""
        for _ in range(steps):
            self.step()
            self.people = walk(self.cells, self.people)
            if any(cell == goal for cell, goal in zip(self.cells, self._goals, strict=True)):
                return True
        return False


def test_nothing_is_planned_while_a_robot_comes_nearer_or_works() -> None:
    floor = Floor(DEAD_END, [(0, 4), (0, 3)], [(2, 5), None])
    assert [floor.step() for _ in range(PATIENCE)] == [{}] * PATIENCE
    assert floor.step(has_worked=True) == {}
    assert [floor.step() for _ in range(PATIENCE - 1)] == [{}] * (PATIENCE - 1)
    assert set(floor.step()) == {0, 1}
    floor = Floor(DEAD_END, [(0, 3), (0, 2)], [(2, 5), (0, 4)])
    assert [floor.step() for _ in range(PATIENCE)] == [{}] * PATIENCE
    floor.cells = [(0, 4), (0, 3)]
    assert [floor.step() for _ in range(PATIENCE)] == [{}] * PATIENCE


def test_two_robots_pass_each_other_while_others_work_if_they_have_no_other_paths() -> None:
    bypass = Layout(["P.....", "###.#.", "###..."])
    for layout, people in ((DEAD_END, []), (DEAD_END, [(0, 0)]), (bypass, [])):
        floor = Floor(layout, [(0, 4), (0, 3)], [(1, 3), (0, 4)])
        floor.people = people
        aims = [floor.step(has_worked=True) for _ in range(PATIENCE + 12)]
        assert not any(aims[:PATIENCE])
        assert any(aims) is (layout is DEAD_END and not people)


def test_nobody_moves_into_people_or_robots_that_stay() -> None:
    crossing = Layout(["##.##", "P...D", "##.##"])
    for taken, free in ((0, 2), (2, 0)):
        by_person = Floor(crossing, [(1, 1), (1, 2)], [(1, 4), (1, 0)])
        by_person.people = [(taken, 2)]
        assert by_person.run(PATIENCE + 12)
        by_robot = Floor(crossing, [(1, 1), (1, 2), (taken, 2)], [(1, 4), (1, 0), None])
        all_aims = [by_robot.step(fixed=(2,)) for _ in range(PATIENCE + 12)]
        assert (free, 2) in {cell for aims in all_aims for cell in aims.values()}
        assert by_robot.cells[2] == (taken, 2)


def test_robots_let_a_person_pass_who_does_not_go_back() -> None:
    siding = Layout(["D.....P", "###.###"])

    def west(cells: list[Cell], people: list[Cell]) -> list[Cell]:
        [(row, column)] = people
        ahead = (0, 3) if row else (0, max(column - 1, 0))
        return people if ahead in cells else [ahead]

    floor = Floor(siding, [(0, 3)], [(0, 6)])
    floor.people = [(0, 6)]
    assert floor.run(PATIENCE + 30, west)
    assert floor.people == [(0, 0)]


def test_other_moves_are_planned_if_somebody_does_not_continue() -> None:
    siding = Layout(["P...D", "#.#.#"])
    floor = Floor(siding, [(0, 0)], [(0, 4)])
    floor.people = [(0, 2)]
    aims = [floor.step() for _ in range(PATIENCE + 3 * STANDS)]
    assert {0: (0, 1)} in aims  # only these two cells give the person room to pass
    assert floor.held == [0]
    floor.people = [(1, 3)]
    assert floor.run(3 * STANDS)


def test_nothing_is_planned_where_nobody_can_pass() -> None:
    floor = Floor(Layout(["P.D"]), [(0, 0), (0, 1)], [(0, 2), (0, 0)])
    floor.people = [(0, 2)]
    assert [floor.step() for _ in range(2 * PATIENCE + 2)] == [{}] * (2 * PATIENCE + 2)
    assert floor.held == []


def test_a_queue_of_any_length_lets_a_person_out_of_a_dead_end() -> None:
    queue = 24
    hall, corridor = "." * (queue - 3), "#" * (queue + 1)
    layout = Layout([hall + corridor, hall + "." * queue + "D", "P" + hall[1:] + corridor])
    end = layout.width - 1

    def leaves(cells: list[Cell], people: list[Cell]) -> list[Cell]:
        [(row, column)] = people
        for ahead in (row, column - 1), (row - 1, column), (row + 1, column):
            if layout.is_open(ahead) and ahead not in cells:
                return [ahead]
        return people

    floor = Floor(layout, [(1, end - 1 - at) for at in range(queue)], [(1, end)] * queue)
    floor.people = [(1, end)]
    assert floor.run(PATIENCE + 5 * queue, leaves)


def test_robots_in_a_ring_move_together() -> None:
    course = Course([0, 1, 2, 3], np.array([[0, 1], [1, 3], [3, 2], [2, 0]]))
    assert course.next_cells([0, 1, 3, 2], set()) == {0: 1, 1: 3, 2: 2, 3: 0}
    assert course.next_cells([0, 1, 3, 2], {2}) == {}


def test_robots_keep_the_order_of_the_plan_at_each_cell() -> None:
    course = Course([0, ~0, 1], np.array([[1, 1, 2, 2], [0, 1, 1, 4], [7, 7, 7, 1]]))
    assert course.follow([1, 0, 7])
    assert course.next_cells([1, 0, 7], set()) == {0: 2}  # the person comes before robot 1
    assert course.follow([2, 1, 7])
    assert course.next_cells([2, 1, 7], set()) == {}
    assert course.follow([2, 4, 7])
    assert course.next_cells([2, 4, 7], set()) == {1: 1}
    assert not course.follow([2, 4, 1])


def test_the_order_does_not_wait_for_people_who_walk_elsewhere() -> None:
    course = Course([0, ~0], np.array([[2, 2, 1], [0, 1, 4]]))
    assert course.follow([2, 0])
    assert course.next_cells([2, 0], set()) == {}
    assert course.follow([2, 9])
    assert course.next_cells([2, 9], set()) == {0: 1}
    assert course.next_cells([2, 1], set()) == {}  # the person has come back
    assert not course.follow([3, 1])  # the robot has left the plan


def test_a_long_search_goes_on_in_later_steps_while_its_robots_stand(monkeypatch) -> None:
    monkeypatch.setattr("agents.fleet.escapes.STEP_DECISIONS", 2)
    for most, is_found in ((2, False), (20, True)):
        monkeypatch.setattr("agents.fleet.escapes.MAX_STEPS", most)
        floor = Floor(DEAD_END, [(0, 2), (0, 3)], [(2, 5), None])
        for _ in range(PATIENCE + 1):
            aims = floor.step()
        assert sorted(floor.held) == [0, 1]
        assert aims == {0: (0, 2), 1: (0, 3)}  # no plan yet
        assert floor.run(40) is is_found


def test_the_next_robot_is_freed_at_once_if_there_is_no_plan_for_one() -> None:
    # Nobody can let robot 0 pass, which is nearest to its goal.
    floor = Floor(Layout(["P.#", "###", "..D"]), [(0, 0), (2, 0)], [(0, 1), (2, 2)])
    floor.people = [(0, 1)]
    waits = [floor.step() for _ in range(PATIENCE + 2)]
    assert waits[PATIENCE] in ({}, {0: (0, 0)})
    assert waits[PATIENCE + 1] == {1: (2, 1)}
