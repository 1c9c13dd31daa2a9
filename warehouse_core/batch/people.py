"""People, who walk on a floor among its robots and whom nobody commands.

To the motion a person is one more robot, without an item. People are never hurt: by the table of
traffic, or by what bodies do, whoever would run into one is blocked.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.fleet_settings import STATIONS, People
from warehouse_core.motion.base import BaseBatchMotion, BatchOutcome, Outcome
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.distances import distances
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Flags, Integers, LayoutSet, sides_table, size_of
from warehouse_core.world.tiles import Cell

MAX_GOALS = 32
"""Limit on the stations of a layout between which people walk; more are left out evenly."""

MAX_GOAL_CELLS = 2**26
"""Limit on the product of these stations and the cells of the layout, 4 bytes each."""

AHEAD, ASIDE, BACK = 8.0, 1.0, 0.05
"""Weights with which a person draws one of the open directions."""

NUMBERS = WAIT + 2
"""Random numbers of a person in a step: one for each direction, one for a pause, one for a goal."""


class Walkers:
    """The people on ``B`` floors, ``P`` on each; arrays are ``[B, P]``.

    Attributes:
        cells: cells in which they are, numbered within their layouts.
        ends: cells in which their next moves begin; others if the motion drives through cells.
    """

    def __init__(self, people: People, layouts: LayoutSet) -> None:
        shape = len(layouts.kind), people.count
        self.cells = self.ends = np.zeros(shape, np.intp)
        self._pause = people.pause
        self._walks_to_stations = people.count > 0 and people.habit == STATIONS
        self._last, self._goals = np.full(shape, WAIT), np.zeros(shape, np.intp)
        self._moves, self._is_blocked = np.zeros((2, *shape), np.bool_)
        self._streams = [np.random.default_rng(0)] * shape[0]
        self._base = layouts.base[:, None]
        self._sides = sides_table(layouts.kinds)
        if self._walks_to_stations:
            self._ways = _ShortestWays(layouts)

    def enter(self, floor: int, cells: Integers, stream: np.random.Generator) -> None:
        """Put the people of a floor in their cells; they draw from ``stream`` from now on."""
        self.cells[floor] = self.ends[floor] = cells
        self._last[floor], self._is_blocked[floor] = WAIT, False
        self._streams[floor] = stream
        if self._walks_to_stations:
            self._goals[floor] = self._ways.goals(floor, stream.random(len(cells)))

    def actions(self) -> NDArray[np.intp]:
        """Return what each of them does in this step, 0 to 4."""
        uniforms = np.array(
            [stream.random((self.cells.shape[1], NUMBERS)) for stream in self._streams]
        )
        weights = self._to_stations(uniforms[..., -1]) if self._walks_to_stations else self._ahead()
        # Who could not move turns any way, and so out of the way of robots that wait.
        weights = np.where(self._is_blocked[..., None], ASIDE, weights)
        weights *= self._sides.take(self._base + self.ends, axis=0)
        with np.errstate(divide="ignore"):
            # The least of exponential times is that of each direction in proportion to its weight.
            times = -np.log1p(-uniforms[..., :WAIT]) / weights
        actions: NDArray[np.intp] = np.argmin(times, axis=-1)
        still = (uniforms[..., WAIT] < self._pause) | ~weights.any(axis=-1)
        actions[still] = WAIT
        self._moves = ~still
        self._last = np.where(still, self._last, actions)
        return actions

    def move(self, cells: Integers, ends: Integers) -> None:
        """Note where they are after a step, and where their next moves begin."""
        self._is_blocked = self._moves & (ends == self.ends)
        self.cells, self.ends = cells.astype(np.intp), ends.astype(np.intp)

    def _ahead(self) -> NDArray[np.float64]:
        """Return the weights of the directions for those who walk along aisles."""
        return _AHEAD.take(self._last, axis=0)

    def _to_stations(self, uniforms: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the weights for those who walk to stations; who has arrived gets another goal."""
        ways, floors = self._ways, np.arange(len(self.cells))[:, None]
        arrived = ways.has_arrived(floors, self._goals, self.ends)
        self._goals = np.where(arrived, ways.others(floors, self._goals, uniforms), self._goals)
        return ways.weights(floors, self._goals, self.ends)


class _ShortestWays:
    """The shortest ways to the stations of each layout; open cells if it has fewer than two.

    ``floors``, ``goals`` and ``cells`` are arrays of one shape, or broadcast to one.
    """

    def __init__(self, layouts: LayoutSet) -> None:
        goals = [_goals(kind) for kind in layouts.kinds]
        counts, sizes = list(map(len, goals)), list(map(size_of, layouts.kinds))
        self._count, self._size = layouts.of_rows(counts), layouts.of_rows(sizes)
        self._first = layouts.of_rows(np.cumsum([0, *np.multiply(counts, sizes)])[:-1])
        pairs = zip(layouts.kinds, goals, strict=True)
        fields = [distances(kind, [goal]) for kind, each in pairs for goal in each]
        self._is_goal = np.concatenate([(field == 0).ravel() for field in fields])
        self._is_nearer = np.concatenate([_is_nearer(field) for field in fields])

    def goals(self, floors: Any, uniforms: NDArray[np.float64]) -> NDArray[np.intp]:
        """Return a random goal for each uniform number."""
        goals: NDArray[np.intp] = (uniforms * self._count[floors]).astype(np.intp)
        return goals

    def others(self, floors: Any, goals: Integers, uniforms: NDArray[np.float64]) -> Integers:
        """Return for each goal another one at random, or the same if there is no other."""
        count = self._count[floors]
        others: Integers = (goals + 1 + (uniforms * (count - 1)).astype(np.intp)) % count
        return others

    def has_arrived(self, floors: Any, goals: Integers, cells: Integers) -> NDArray[np.bool_]:
        """Return whether the cells are the goals."""
        return self._is_goal.take(self._places(floors, goals, cells))

    def weights(self, floors: Any, goals: Integers, cells: Integers) -> NDArray[np.float64]:
        """Return the weights ``[..., 4]`` of the directions: towards the goal, or else aside."""
        nearer = self._is_nearer.take(self._places(floors, goals, cells), axis=0)
        return np.where(nearer, AHEAD, BACK)

    def _places(self, floors: Any, goals: Integers, cells: Integers) -> NDArray[np.intp]:
        places: NDArray[np.intp] = self._first[floors] + goals * self._size[floors] + cells
        return places


def _goals(layout: Layout) -> list[Cell]:
    """Return the stations of a layout, at most ``MAX_GOALS``, or else open cells."""
    cells: Sequence[Cell] = layout.pickups + layout.dropoffs
    if len(cells) < 2:
        cells = [layout.open_cell(rank) for rank in range(len(layout.open_cells))]
    every = -(-len(cells) // min(MAX_GOALS, MAX_GOAL_CELLS // size_of(layout)))
    return list(cells[::every])


def _is_nearer(field: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether the N, E, S and W neighbours of each cell are nearer, ``[H * W, 4]``."""
    around = np.pad(field, 1, constant_values=np.inf)
    height, width = field.shape
    sides = [
        around[1 + down : 1 + down + height, 1 + right : 1 + right + width]
        for down, right in DISPLACEMENTS[:WAIT]
    ]
    nearer: NDArray[np.bool_] = np.stack(sides, axis=-1) < field[..., None]
    return nearer.reshape(-1, WAIT)


_AHEAD = np.full((WAIT + 1, WAIT), ASIDE)
"""Weights of the directions after each action; all are equal before the first."""
_AHEAD[range(WAIT), range(WAIT)] = AHEAD
_AHEAD[range(WAIT), [2, 3, 0, 1]] = BACK


class MingledMotion(BaseBatchMotion):
    """Moves ``R`` robots among ``P`` people on each floor; see ``BatchMotion``.

    The motion that it is made of moves ``R + P`` bodies on each floor, the robots first. People
    enter before robots are placed.
    """

    def __init__(self, motion: BaseBatchMotion, robots: int, walkers: Walkers) -> None:
        self._motion, self._robots, self._walkers = motion, robots, walkers
        self._bodies = robots + walkers.cells.shape[1]

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Put robots and people of some floors in their cells; see ``BatchMotion.place``."""
        floors = rows[:: self._robots] // self._robots
        bodies = floors[:, None] * self._bodies + np.arange(self._bodies)
        people = self._walkers.cells[floors]
        self._motion.place(bodies.ravel(), self._joined(cells, people), seeds)

    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Carry out one action for each robot and person; see ``BatchMotion.advance``."""
        people = self._walkers.actions()
        outcome = self._motion.advance(
            self._joined(actions, people), self._joined(loaded, np.zeros_like(people, np.bool_))
        )
        ends = outcome.cells if outcome.ends is None else outcome.ends
        self._walkers.move(self._of_people(outcome.cells), self._of_people(ends))
        of_robots: list[Any] = [None if each is None else self._of_robots(each) for each in outcome]
        return BatchOutcome(*of_robots)

    def face(self, actions: Integers) -> None:
        """Let robots turn on the spot; see ``BaseBatchMotion.face``."""
        self._motion.face(self._joined(actions, np.full_like(self._walkers.cells, WAIT)))

    def fail(self, rows: Integers) -> None:
        """Let robots stay where they are for good; see ``BaseBatchMotion.fail``."""
        floors, robots = np.divmod(rows, self._robots)
        self._motion.fail(floors * self._bodies + robots)

    def outcomes(self, floor: int) -> Sequence[Outcome]:
        """Return what the robots of a floor, and then its people, did."""
        return self._motion.outcomes(floor)

    def close(self) -> None:
        """Close the motion of robots and people; see ``BatchMotion.close``."""
        self._motion.close()

    def _joined(self, robots: NDArray[Any], people: NDArray[Any]) -> NDArray[Any]:
        """Return the values of all bodies, from robots ``[F * R]`` and people ``[F, P]``."""
        return np.hstack([np.reshape(robots, (len(people), -1)), people]).ravel()

    def _of_people(self, bodies: NDArray[Any]) -> NDArray[Any]:
        """Return the values of the people ``[F, P]`` from the values of all bodies."""
        return bodies.reshape(-1, self._bodies)[:, self._robots :]

    def _of_robots(self, bodies: NDArray[Any]) -> NDArray[Any]:
        """Return the values of the robots ``[N]`` from the values of all bodies."""
        return bodies.reshape(-1, self._bodies)[:, : self._robots].ravel()
