"""Routes: all short enough paths of one robot under the constraints of a node of CBS.

A route is stored as layers, one set of cells for each time. The layers of the cheapest paths are a
*multi-valued decision diagram* (MDD).

Source: Sharon et al. (2013), The increasing cost tree search, Artificial Intelligence 195.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from math import inf
from typing import NamedTuple

from agents.mapf.graph import Graph

Moves = dict[int, dict[int, int]]
"""Forbidden moves by time and cell: the cells that must not be combined with this cell."""


class CellSets:
    """The sets of cells of a floor as whole numbers with one bit for each cell.

    One bit operation moves a robot from all cells that it may be in.

    A column of wall is added on the right, so that no move leads from one row into the next.

    Attributes:
        bits: set with only this cell, for each cell number.
        open: set of all open cells.
        row: distance between the bits of a cell and of the cell below it.
        bytes: largest number of bytes of a set.
    """

    def __init__(self, graph: Graph) -> None:
        layout = graph.layout
        self.row = layout.width + 1
        self.bits = [1 << cell + cell // layout.width for cell in range(graph.size)]
        self.open = self.of(set(layout.open_cells.tolist()) - graph.closed)
        self.bytes = self.row * layout.height // 8 + 1
        self._steps_from: dict[int, list[int]] = {}

    def of(self, cells: Iterable[int]) -> int:
        """Return the set of some cells."""
        union = 0
        for cell in cells:
            union |= self.bits[cell]
        return union

    def cell(self, bit: int) -> int:
        """Return the number of the only cell in a set."""
        place = bit.bit_length() - 1
        return place - place // self.row

    def spread(self, cells: int) -> int:
        """Return the cells that a robot can reach in a step, from any of these."""
        row = self.row
        return (cells | cells << 1 | cells >> 1 | cells << row | cells >> row) & self.open

    def steps_from(self, bit: int) -> list[int]:
        """Return the cells that a robot in a cell can reach in a step, each as a set of its own."""
        key = bit.bit_length()
        if key not in self._steps_from:
            self._steps_from[key] = list(bits_of(self.spread(bit)))
        return self._steps_from[key]


def bits_of(cells: int) -> Iterator[int]:
    """Yield the cells of a set, each as a set of its own."""
    while cells:
        bit = cells & -cells
        yield bit
        cells ^= bit


class Constraint(NamedTuple):
    """A statement about a robot's path, and whether it must be true or false.

    Attributes:
        robot: number of the robot.
        time: number of the joint step.
        cell: cell of the robot after the step; ``None`` states that it has arrived by then.
        before: cell of the robot before the step; ``None`` states nothing about it.
        holds: true for a positive constraint, with which other robots have to keep away; false for
            a negative one.
    """

    robot: int
    time: int
    cell: int | None
    before: int | None = None
    holds: bool = False


class Rules:
    """The rules of a robot, which is at its start at the time 0 and finally stays at its goal.

    Attributes:
        least: earliest time at which the robot may have arrived for good.
        most: latest time at which the robot may have arrived for good.
        closed: cells in which the robot must not be at a time.
        ends: cells in which the robot must not be from a time on.
        into: cells from which the robot must not enter a cell, by time of arrival.
        out_of: cells that the robot must not enter from a cell, by time of arrival.
        latest: time after which the rules do not change.
    """

    def __init__(self) -> None:
        self.least, self.most, self.latest = 0, inf, 0
        self.closed = defaultdict[int, int](int)
        self.ends = defaultdict[int, int](int)
        self.into: Moves = {}
        self.out_of: Moves = {}

    def add(self, sets: CellSets, rule: Constraint, is_own: bool, goal: int) -> None:
        """Add the consequences of a constraint for the robot.

        Args:
            sets: sets of the floor.
            rule: constraint on this robot if ``is_own``, else a positive one on another robot.
            is_own: see above.
            goal: goal of the constraint's robot.
        """
        time, must = rule.time, is_own and rule.holds
        self.latest = max(self.latest, time)
        if rule.cell is None:
            if not is_own:
                self.ends[time] |= goal
            elif must:
                self.most = min(self.most, time)
            else:
                self.least = max(self.least, time + 1)
            return
        places = [(time, sets.bits[rule.cell])]
        if rule.before is not None:
            places.append((time - 1, sets.bits[rule.before]))
            if not must:
                (_, to), (_, before) = reversed(places) if rule.holds else places
                for moves, one, other in ((self.into, to, before), (self.out_of, before, to)):
                    here = moves.setdefault(time, {})
                    here[one] = here.get(one, 0) | other
        if rule.before is None or rule.holds:
            for when, cell in places:
                self.closed[when] |= sets.open ^ cell if must else cell

    def arrival(self, goal: int) -> int:
        """Return the first time from which the robot can stay at its goal."""
        return max([self.least, *(time + 1 for time, each in self.closed.items() if each & goal)])


def step(sets: CellSets, cells: int, barred: dict[int, int] | None) -> int:
    """Return the cells of a robot after a step or, given ``out_of`` moves, before the step.

    ``barred`` are the moves that are forbidden in the step.
    """
    reached = sets.spread(cells)
    for cell, others in barred.items() if barred else ():
        if not sets.spread(cell) & cells & ~others:
            reached &= ~cell
    return reached


class TracedPath:
    """A path of a robot, which stays in the last cell.

    Attributes:
        cells: cell at each time.
        cost: cost of the path, which is the time of arrival.
    """

    def __init__(self, cells: list[int]) -> None:
        self.cells, self.cost = cells, len(cells) - 1
        self._horizon, self._trace = 0, 0

    def at(self, time: int) -> int:
        """Return the cell at a time."""
        return self.cells[min(time, self.cost)]

    def trace(self, sets: CellSets, horizon: int) -> int:
        """Return the sets of the cells at all times up to a horizon, joined to one number."""
        if self._horizon != horizon:
            alone = [sets.bits[cell].to_bytes(sets.bytes, "little") for cell in self.cells]
            alone += alone[-1:] * (horizon + 1 - len(alone))
            self._horizon, self._trace = horizon, int.from_bytes(b"".join(alone), "little")
        return self._trace

    def forget(self) -> None:
        """Drop the cached trace; it is computed again when needed."""
        self._horizon = self._trace = 0


class Route:
    """The paths of a robot from its start to its goal that satisfy its rules.

    Attributes:
        rules: rules that the paths satisfy.
        cost: cost of the cheapest path, or -1 if no path exists.
    """

    def __init__(self, sets: CellSets, rules: Rules, start: int, goal: int) -> None:
        self._sets, self.rules, self._start, self._goal = sets, rules, start, goal
        cheapest = self._forward()
        self.cost = len(cheapest) - 1
        self._layers = {0: self._backward(cheapest)}

    def forget(self) -> None:
        """Drop all cached layers; they are computed again when needed."""
        self._layers.clear()

    def layers(self, slack: int = 0) -> list[int]:
        """Return the cells of all paths that cost at most ``slack`` over the cheapest, by time."""
        slack = int(min(slack, self.rules.most - self.cost))
        if slack not in self._layers:
            last = self.cost + slack if slack else None
            self._layers[slack] = self._backward(self._forward(last))
        return self._layers[slack]

    def layer(self, time: int) -> int:
        """Return the cells of the cheapest paths at a time."""
        return self.layers()[min(time, self.cost)]

    def allows(self, path: TracedPath, slack: int) -> bool:
        """Return whether a path satisfies the rules at a cost of at most ``slack`` extra."""
        bits, layers = [self._sets.bits[cell] for cell in path.cells], self.layers(slack)
        return self.cost <= path.cost < len(layers) and all(
            cell & layers[time] and (not time or bits[time - 1] & self._before(time, cell))
            for time, cell in enumerate(bits)
        )

    def quietest(self, others: Sequence[TracedPath], horizon: int, slack: int) -> TracedPath:
        """Return the path with the fewest conflicts, at most ``slack`` dearer than the cheapest.

        After the time ``horizon``, all of the others stay where they are.
        """
        sets, size, layers = self._sets, self._sets.bytes, self.layers(slack)
        union = 0
        for other in others:
            union |= other.trace(sets, horizon)
        data = union.to_bytes((horizon + 1) * size, "little")
        taken = [int.from_bytes(data[at : at + size], "little") for at in range(0, len(data), size)]
        counts, swaps = [[self._start]], [dict[int, int]()]
        for time in range(1, len(layers)):
            allowed, busy, left = layers[time], taken[time], taken[time - 1]
            if time == self.cost - 1:
                allowed &= ~self._goal  # a robot that waits there has arrived earlier
            new, swap = [0] * (len(counts[-1]) + 2), dict[int, int]()
            for number, cells in enumerate(counts[-1]):
                reached = step(sets, cells, self.rules.into.get(time)) & allowed
                if cells & busy and sets.spread(cells & busy) & reached & left:
                    for cell, before in self._swaps(others, time, cells & busy, reached & left):
                        swap[cell] = swap.get(cell, 0) | before
                        if reached & cell and not self._before(time, cell) & cells & ~swap[cell]:
                            reached ^= cell
                            new[number + 1 + bool(cell & busy)] |= cell
                new[number] |= reached & ~busy
                new[number + 1] |= reached & busy
            counts.append(_firsts(new))
            swaps.append(swap)
        return self._path(counts, swaps, taken)

    def _path(
        self, counts: list[list[int]], swaps: list[dict[int, int]], taken: list[int]
    ) -> TracedPath:
        """Return the cheapest of the paths with the fewest conflicts.

        Args:
            counts: cells that are reached, by time and number of conflicts.
            swaps: previous cells of each cell that is reached by a swap, by time.
            taken: cells of the other robots, by time.
        """
        passed = [time for time, busy in enumerate(taken) if busy & self._goal]
        _, end, number = min(
            (number + sum(other > time for other in passed), time, number)
            for time in range(self.cost, len(counts))
            for number, cells in enumerate(counts[time])
            if cells & self._goal
        )
        cell, path = self._goal, [self._goal]
        for time in range(end, 0, -1):
            number -= bool(cell & taken[time])
            before, swap = self._before(time, cell), swaps[time].get(cell, 0)
            count = counts[time - 1]
            previous = before & ~swap & count[number] if number < len(count) else 0
            if not previous:
                number -= 1
                previous = before & swap & count[number]
            cell = previous & -previous
            path.append(cell)
        return TracedPath([self._sets.cell(cell) for cell in reversed(path)])

    def _before(self, time: int, cell: int) -> int:
        """Return the cells from which the robot may reach a cell at a time."""
        return self._sets.spread(cell) & ~self.rules.into.get(time, {}).get(cell, 0)

    def _swaps(
        self, others: Sequence[TracedPath], time: int, cells: int, reached: int
    ) -> Iterator[tuple[int, int]]:
        """Yield the moves, as cell and previous cell, that another robot makes in reverse."""
        sets = self._sets
        moves = {(path.cells[time], path.cells[time - 1]) for path in others if time <= path.cost}
        for before in bits_of(cells):
            for cell in bits_of(sets.spread(before) & reached & ~before):
                if (sets.cell(before), sets.cell(cell)) in moves:
                    yield cell, before

    def _forward(self, last: int | None = None) -> list[int]:
        """Return the reachable cells at each time, up to a last time or the first arrival."""
        sets, rules, goal = self._sets, self.rules, self._goal
        first, time, cells, closed = rules.arrival(goal), 0, self._start, rules.ends.get(0, 0)
        layers = [cells]
        while time != last:
            if last is None and cells & goal and time >= first:
                if time == 0:
                    return layers
                before = layers[-2] & ~goal  # a robot that waits there has arrived earlier
                if step(sets, before, rules.into.get(time)) & goal:
                    return [*layers[:-2], before, cells]
            if last is None and (
                time >= rules.most or not cells or (time > rules.latest and cells == layers[-2])
            ):
                return []
            time += 1
            closed |= rules.ends.get(time, 0)
            cells = step(sets, cells, rules.into.get(time)) & ~(closed | rules.closed.get(time, 0))
            layers.append(cells)
        return layers

    def _backward(self, layers: list[int]) -> list[int]:
        """Return layers with only the cells from which the goal can be reached in time."""
        layers = [*layers[:-1], self._goal] if layers else []
        for time in range(len(layers) - 1, 0, -1):
            layers[time - 1] &= step(self._sets, layers[time], self.rules.out_of.get(time))
        return layers


def _firsts(sets: list[int]) -> list[int]:
    """Return sets without the cells of earlier sets, up to the last set that has any."""
    seen = 0
    for number, cells in enumerate(sets):
        sets[number] = cells & ~seen
        seen |= cells
    while not sets[-1]:
        sets.pop()
    return sets
