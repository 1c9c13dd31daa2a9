"""Escapes from jams: a joint plan that brings one robot of a jam to its goal.

In a narrow place, robots may wait forever for one another, or for people who wait for them. LaCAM
then searches the joint steps of the robots and people around one robot, the chief, for a plan that
brings it to its goal. All others go away from that goal, so that the chief can pass them.

The search is complete: it finds a plan for the chief if one exists, given enough time. No plan
exists if robots that stay, such as robots with a flat battery, cut the chief off, or if nobody has
room to let it pass. A person may also refuse to follow a plan, and people may enclose a robot.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.mapf.graph import CLOSED, Fields
from agents.mapf.kernels import lacam
from agents.mapf.kernels.buffers import table_of, write
from agents.mapf.kernels.epibt import epibt_of
from agents.mapf.kernels.local_guidance import guidance_of
from agents.mapf.kernels.pibt import pibt_of
from agents.mapf.kernels.places import FAR, NONE
from agents.mapf.kernels.robots import robots_of
from warehouse_core.compiled import prepare
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Integers

PATIENCE = 6
"""Time without progress after which a fleet or two robots count as stuck, in steps of a cell."""

STANDS = 4
"""Time without any move after which another plan is made, in steps of a cell."""

FLEET_MOVERS, PAIR_MOVERS = 60, 16
"""Limits on the robots and people that move in a plan for a stuck fleet, and for two stuck robots.

All others go on with their work. With 16 for both, two of 20 fleets in rooms delivered half as many
items. With 60 for both, 48 fleets in rooms delivered 2% less.
"""

STEP_DECISIONS, MAX_STEPS = 3_000, 3
"""Decisions of robots in a step of the search, which take 0.035 s, and steps of a search."""


class Deadlock(NamedTuple):
    """The robots and people that may move in a plan, of which the first is the chief.

    Attributes:
        who: numbers of robots, and ``~number`` of people.
        cells: cells of these robots and people.
        field: ``[size]``, distances to the goal of the chief, ``FAR`` where it has no path.
        blocked: cells that nobody can enter.
    """

    who: list[int]
    cells: list[int]
    field: Integers
    blocked: set[int]


class JointSearch:
    """A search with LaCAM for joint steps that bring the chief of a deadlock to its goal.

    Args:
        fields: distances on the floor.
        deadlock: robots and people.
        people_first: true if people have the highest priority, so that robots give way to them.
    """

    def __init__(self, fields: Fields, deadlock: Deadlock, people_first: bool) -> None:
        size, count = fields.graph.size, len(deadlock.cells)
        is_reached = deadlock.field < FAR
        away = np.where(is_reached, deadlock.field[is_reached].max() - deadlock.field, FAR)
        no_matter = np.zeros_like(deadlock.field)  # the search ends wherever the others are
        table = np.stack([deadlock.field, away, no_matter]).astype(np.int32)
        is_chief, is_robot = np.arange(count) == 0, np.array(deadlock.who) >= 0
        ranks = np.argsort(is_robot, kind="stable") if people_first else np.arange(count)
        self._table, self._floor = table_of(table), fields.floor
        self._robots = robots = robots_of(size, count, 0)
        goals = np.where(is_chief, deadlock.field.argmin(), NONE)
        rows = np.where(is_chief, 0, size)
        write(robots, goals=goals, rows=rows, chosen=np.array(deadlock.cells))
        for cell in deadlock.blocked:
            robots.is_closed[cell] = 1
        self._pibt = pibt_of(size, count)
        self._epibt = epibt_of(fields.graph.neighbours[:0, :WAIT], 0)  # unused
        self._guidance = guidance_of(size, count, 0)
        rows = np.where(is_chief, 0, 2 * size)
        self._search = lacam.new_search(robots, self._floor, self._table, ranks, rows)

    def go_on(self, rounds: int) -> bool:
        """Continue for a number of rounds of PIBT, and return whether the search is over."""
        for _ in range(rounds):
            status = lacam.explore(
                self._search, self._robots, self._pibt, self._epibt, self._guidance, self._floor,
                self._table, self._table, 1,
            )  # fmt: skip
            if status == lacam.FULL:
                self._search = lacam.enlarged_search(self._search)
            elif status != lacam.SPENT:
                return True
        return False

    def paths(self) -> Integers | None:
        """Return the cells of each before and after each step of the plan, ``[count, T + 1]``."""
        places = lacam.best_places(self._search)
        return np.array(places).T if places else None


class Course:
    """The progress of a plan. A robot waits until all that pass its next cell before have passed.

    People are expected to do the same. A person who walks elsewhere is no longer in the plan.

    Args:
        who: robots and people, see ``Deadlock``.
        paths: cells of each, ``[count, T + 1]``.
    """

    def __init__(self, who: list[int], paths: Integers) -> None:
        self._who, self._paths = who, paths
        self._reached = np.zeros(len(who), np.intp)

    def follow(self, cells: list[int]) -> bool:
        """Note the cells of the robots and people; return whether robots have moves to make."""
        last, is_robot = self._paths.shape[1] - 1, np.array(self._who) >= 0
        for number, cell in enumerate(cells):
            path, at = self._paths[number], int(self._reached[number])
            later = np.flatnonzero(path[at:] == cell)
            if len(later):
                at += int(later[0])
                while at < last and path[at + 1] == cell:
                    at += 1
                self._reached[number] = at
            elif is_robot[number]:
                return False
            else:
                self._reached[number] = last
        return bool((self._reached[is_robot] < last).any())

    def next_cells(self, cells: list[int], occupied: set[int]) -> dict[int, int]:
        """Return the next cells of the robots that can move in this step.

        Args:
            cells: cells of the robots and people of the plan.
            occupied: cells of all others, and other cells that no robot can enter.
        """
        steps = np.arange(self._paths.shape[1])
        is_ahead = steps >= self._reached[:, None]
        inside, ahead = {cell: number for number, cell in enumerate(cells)}, dict[int, int]()
        follows = dict[int, int]()
        for number, who in enumerate(self._who):
            step = int(self._reached[number]) + 1
            if who < 0 or step == len(steps):
                continue
            cell = int(self._paths[number, step])
            passes_before = is_ahead[:, :step] & (self._paths[:, :step] == cell)
            passes_before[number] = False
            other = inside.get(cell, number)
            passes_before[other, self._reached[other] : self._reached[other] + 1] = False
            if self._who[other] >= 0 and cell not in occupied and not passes_before.any():
                ahead[number], follows[number] = cell, other
        while stops := [each for each in ahead if follows[each] not in ahead]:
            for each in stops:
                del ahead[each]
        return {self._who[number]: cell for number, cell in ahead.items()}


class Escapes:
    """Plans for robots that are stuck, each for another chief.

    A fleet is stuck if no robot comes closer to its goal than its smallest distance since a robot
    last picked, dropped or charged. Two robots are stuck, even if others are not, if they stand and
    each has no path to its goal except through the cell of the other. While a search goes on in
    later steps, its robots stand.

    Args:
        fields: distances on the floor, in steps.
        robots: ``R``.
        cell_steps: steps in which a robot crosses a cell.
    """

    def __init__(self, fields: Fields, robots: int, cell_steps: float = 1.0) -> None:
        self._patience, self._most_stands = PATIENCE * cell_steps, STANDS * cell_steps
        sides: list[list[int]] = fields.graph.neighbours[:, :WAIT].tolist()
        self._fields = fields
        self._near = [[each for each in neighbours if each != CLOSED] for neighbours in sides]
        self._nearest = np.full(robots, FAR)
        self._cells, self._goals = np.full((2, robots), NONE)
        self._stood = np.zeros(robots, np.intp)
        self._waits = self._stands = self._tries = self._steps = 0
        self._deadlock: Deadlock | None = None
        self._search: JointSearch | None = None
        self._course: Course | None = None
        prepare(lacam.add, lacam.explore, lacam.fill_table)

    @property
    def held(self) -> list[int]:
        """Robots that make only planned moves."""
        return [who for who in self._deadlock.who if who >= 0] if self._deadlock else []

    def aims(
        self, cells: Integers, goals: Integers, distances: Integers, walls: set[int],
        people: Integers, has_worked: bool,
    ) -> dict[int, int]:  # fmt: skip
        """Return the cells that robots must have after this step, by robot; others move freely.

        Args:
            cells: ``[R]`` cells of the robots.
            goals: ``[R]`` goal cells of the robots.
            distances: ``[R]`` distances to the goals in steps, ``FAR`` for robots without a task.
            walls: cells of robots that stay for a long time, and other closed cells.
            people: cells of people.
            has_worked: true if a robot picks, drops, or begins or ends to charge.
        """
        if has_worked:
            self._nearest[:] = FAR
            self._tries = 0
        is_nearer = distances < self._nearest
        self._nearest[is_nearer] = distances[is_nearer]
        self._waits = 0 if has_worked or is_nearer.any() else self._waits + 1
        self._stands = self._stands + 1 if np.array_equal(cells, self._cells) else 0
        stood = (cells == self._cells) & (goals == self._goals) & (distances < FAR)
        self._stood = np.where(stood, self._stood + 1, 0)
        self._cells, self._goals = cells.copy(), goals.copy()
        where = cells.tolist() + people.tolist()[::-1]  # so that index ~number is a person
        if self._search is None:
            self._start(where, distances, walls)
        if self._search is not None:
            self._continue(where)
        if self._course is not None:
            return self._follow(where, walls)
        return {robot: where[robot] for robot in self.held}

    def _start(self, where: list[int], distances: Integers, walls: set[int]) -> None:
        """Begin a search if the fleet or two robots are stuck."""
        is_stuck = (
            self._stands >= self._most_stands if self._course else self._waits >= self._patience
        )
        if is_stuck:
            nearest: list[int] = np.argsort(distances, kind="stable").tolist()
            chiefs = nearest[: np.count_nonzero(distances < FAR)]
            self._begin(chiefs, FLEET_MOVERS, where, walls)
            return
        # Plans for two robots rarely work where people walk, because they do not follow them.
        has_people = len(where) > len(self._cells)
        pair = [] if self._course or has_people else self._opposed(distances)
        if pair:
            self._begin(pair, PAIR_MOVERS, where, walls)

    def _opposed(self, distances: Integers) -> list[int]:
        """Return two robots without any path except through each other's cells, or none.

        Only the two that have stood longest face to face are checked, and not again too soon.
        """
        late = np.flatnonzero(self._stood >= self._patience).tolist()
        robot_in = {int(self._cells[robot]): robot for robot in late}
        near = [(robot, cell) for robot in late for cell in self._near[self._cells[robot]]]
        pairs = [(robot, robot_in[cell]) for robot, cell in near if cell in robot_in]
        if not pairs:
            return []
        ones, others = np.array(pairs).T
        cells, goals, distances_to = self._cells, self._goals, self._fields.distances
        # Each of two robots that face each other stands on a shortest path of the other.
        is_facing = distances_to(goals[ones], cells[others]) < distances[ones]
        is_facing &= distances_to(goals[others], cells[ones]) < distances[others]
        if not is_facing.any():
            return []
        stood = np.where(is_facing, self._stood[ones] + self._stood[others], 0)
        one, other = pairs[stood.argmax()]
        self._stood[[one, other]] = 0
        return [] if self._passes(one, other) or self._passes(other, one) else [one, other]

    def _passes(self, robot: int, other: int) -> bool:
        """Return whether a robot has a path to its goal that avoids the cell of another."""
        closed = {int(self._cells[other])} | self._fields.graph.closed
        return int(self._goals[robot]) in self._distances(int(self._cells[robot]), closed)

    def _begin(self, chiefs: list[int], most: int, where: list[int], walls: set[int]) -> None:
        """Begin a search for at most ``most`` movers; each attempt has another chief."""
        self._stands = self._steps = 0
        self._deadlock, self._course = None, None
        for _ in chiefs:
            chief = chiefs[self._tries % len(chiefs)]
            self._tries += 1
            self._deadlock = self._deadlock_of(chief, most, where, walls)
            if self._deadlock:
                self._search = JointSearch(self._fields, self._deadlock, self._tries % 2 == 1)
                return

    def _deadlock_of(
        self, chief: int, most: int, where: list[int], walls: set[int]
    ) -> Deadlock | None:
        """Return the robots and people that are nearest to a chief, or ``None`` without a path."""
        goal = int(self._goals[chief])
        numbers = range(len(self._cells)), range(len(self._cells) - len(where), 0)
        who_in = {where[who]: who for part in numbers for who in part}
        closed = walls | self._fields.graph.closed
        near = self._distances(where[chief], closed - {where[chief]})
        cells = [cell for cell in near if cell in who_in][:most]
        blocked = (closed | who_in.keys()) - {*cells}
        reached = self._distances(goal, blocked)
        if goal in blocked or where[chief] not in reached:
            return None
        field = np.full(self._fields.graph.size, FAR)
        field[list(reached)] = list(reached.values())
        return Deadlock([who_in[cell] for cell in cells], cells, field, blocked)

    def _distances(self, cell: int, closed: set[int]) -> dict[int, int]:
        """Return the distances of cells from a cell by paths without closed cells, in order."""
        found, reached = {cell: 0}, [cell]
        for place in reached:
            new = [each for each in self._near[place] if each not in found and each not in closed]
            found |= dict.fromkeys(new, found[place] + 1)
            reached += new
        return found

    def _continue(self, where: list[int]) -> None:
        """Continue the search, which ends if a robot or a person that it plans for has moved."""
        assert self._search
        assert self._deadlock
        self._steps += 1
        is_over = [where[who] for who in self._deadlock.who] != self._deadlock.cells
        if not is_over and self._search.go_on(max(STEP_DECISIONS // len(self._deadlock.who), 1)):
            paths, is_over = self._search.paths(), True
            if paths is not None:
                self._course, self._waits = Course(self._deadlock.who, paths), 0
        if is_over or self._steps == MAX_STEPS:
            self._search = None
            if not self._course:
                self._deadlock = None

    def _follow(self, where: list[int], walls: set[int]) -> dict[int, int]:
        """Return the next cells of the robots in the plan, or none if it is carried out."""
        assert self._course
        assert self._deadlock
        cells = [where[who] for who in self._deadlock.who]
        if not self._course.follow(cells):
            self._course = self._deadlock = None
            return {}
        occupied = walls | {*where} - {*cells}
        return {who: where[who] for who in self.held} | self._course.next_cells(cells, occupied)
