"""Reservations: the robot in each cell at each time, so that others keep out of the way.

A cell at a time is one number, a *state*: ``time * H * W + cell``. The *way* of a robot is a list
of its cells, one for each time.

Source: Silver (2005), Cooperative pathfinding, AIIDE; its reservation table.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence


class Reservations:
    """The states and moves that are taken on a floor of ``H * W`` cells, its size.

    Attributes:
        states: robot that has each taken state.
        moves: ``state * H * W + cell`` of the moves that would make a robot change places with
            another, and that robot.
        ends: the state from which on a cell is occupied for good, by cell.
        closed: states that no robot can have, such as cells of people.
        latest: time after which nothing is taken or closed but for good.
        ways: begin and way of each robot that was added.
    """

    def __init__(self, size: int) -> None:
        self.size, self.latest = size, 0
        self.states: dict[int, int] = {}
        self.moves: dict[int, int] = {}
        self.ends: dict[int, int] = {}
        self.closed: set[int] = set()
        self.ways: dict[int, tuple[int, list[int]]] = {}

    def add(self, robot: int, way: list[int], begin: int = 0, *, stays: bool = False) -> None:
        """Reserve the way of a robot, which is in the first cell at the time ``begin``.

        With ``stays`` the last cell is occupied for good.
        """
        for state, swap in self._keys(way, begin):
            self.states[state] = robot
            self.moves[swap] = robot
        self.ways[robot] = begin, way
        end = begin + len(way) - 1
        self.latest = max(self.latest, end)
        if stays:
            self.ends[way[-1]] = end * self.size + way[-1]

    def remove(self, robot: int) -> None:
        """Remove the reservations of a robot, if it has any, which is not to stay for good."""
        begin, way = self.ways.pop(robot, (0, ()))
        for state, swap in self._keys(way, begin):
            del self.states[state]
            del self.moves[swap]

    def close(self, cells: Collection[int], times: Iterable[int]) -> None:
        """Let nobody be in any of the cells at the times."""
        for time in times:
            self.closed.update(time * self.size + cell for cell in cells)
            self.latest = max(self.latest, time)

    def is_free(self, state: int) -> bool:
        """Return whether nobody has a state, and somebody can; regardless of ``ends``."""
        return state not in self.states and state not in self.closed

    def rivals(self, robot: int, way: Sequence[int], begin: int = 0) -> set[int]:
        """Return the robots with whose reservations the way of a robot is in conflict."""
        found, state, before = set(), begin * self.size, way[0]
        for cell in way:
            move = (state - self.size + before) * self.size + cell
            found |= {self.states.get(state + cell, robot), self.moves.get(move, robot)}
            state, before = state + self.size, cell
        return found - {robot}

    def free_from(self, cell: int, begin: int = 0) -> int:
        """Return the first time, not before ``begin``, from which on a cell is free."""
        times = range(self.latest, begin - 1, -1)
        return next((t + 1 for t in times if not self.is_free(t * self.size + cell)), begin)

    def _keys(self, way: Sequence[int], begin: int) -> Iterator[tuple[int, int]]:
        """Return each state of a way, and the reverse of the move that led there."""
        state, before = begin * self.size, way[0] if way else 0
        for cell in way:
            yield state + cell, (state - self.size + cell) * self.size + before
            state, before = state + self.size, cell
