"""Fleets that are stuck in narrow places get out."""

from collections.abc import Callable

import numpy as np

from agents.fleet.escapes import PATIENCE, STANDS, Escapes
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

    def __init__(
        self,
        layout: Layout,
        cells: list[Cell],
        goals: list[Cell | None],
        cell_steps: float = 1.0,
    ) -> None:
        self.layout, self.cells, self.people = layout, cells, list[Cell]()
        self._goals, self._fields = goals, Fields(Graph(layout))
        self._escapes = Escapes(self._fields, len(cells), cell_steps)
        self.held: list[int] = []

    def step(self, has_worked: bool = False, fixed: tuple[int, ...] = ()) -> dict[int, Cell]:
        """Return the aims of a step, after which the robots are there."""
        layout = self.layout
        cells, people = layout.numbers(self.cells), layout.numbers(self.people)
        goals = np.array([NONE if goal is None else layout.number(goal) for goal in self._goals])
        rows = self._fields.rows(goals)
        all_aims = np.where(goals == NONE, FAR, self._fields.matrix[rows, cells])
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
    floor = Floor(DEAD_END, [(0, 4), (0, 3)], [(2, 5), (0, 4)])
    assert [floor.step() for _ in range(PATIENCE)] == [{}] * PATIENCE
    assert floor.step(has_worked=True) == {}
    assert [floor.step() for _ in range(PATIENCE - 1)] == [{}] * (PATIENCE - 1)
    assert set(floor.step()) == {0, 1}
    floor = Floor(DEAD_END, [(0, 3), (0, 2)], [(2, 5), (0, 4)])
    assert [floor.step() for _ in range(PATIENCE)] == [{}] * PATIENCE
    floor.cells = [(0, 4), (0, 3)]
    assert [floor.step() for _ in range(PATIENCE)] == [{}] * PATIENCE


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


def test_a_long_search_goes_on_in_later_steps_while_its_robots_stand(monkeypatch) -> None:
    monkeypatch.setattr("agents.fleet.escapes.STEP_STATES", 3)
    floor = Floor(DEAD_END, [(0, 2), (0, 3)], [(0, 3), (0, 0)])
    for _ in range(PATIENCE + 1):
        aims = floor.step()
    assert sorted(floor.held) == [0, 1]
    assert aims == {0: (0, 2), 1: (0, 3)}  # no plan yet
    assert floor.run(40)
