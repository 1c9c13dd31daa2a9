"""People who walk on a floor among its robots, and whom nobody controls.

For the motion a person is another robot without an item. People are never hurt: the rules of right
of way, or the bodies of a physical backend, block every robot that would run into a person.
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
"""Limit on the stations between which people walk. More are thinned out evenly."""

MAX_GOAL_CELLS = 2**26
"""Limit on the number of these stations times the cells of the layout, at 4 bytes each."""

AHEAD, ASIDE, BACK = 8.0, 1.0, 0.05
"""Weights of the open directions in the random choice of a person."""

NUMBERS = WAIT + 2
"""Random numbers of a person in a step: one per direction, one for a pause, one for a goal."""


class Walkers:
    """The people on ``B`` floors, ``P`` on each, in arrays ``[B, P]``.

    Attributes:
        cells: cells of the people, numbered within their layouts.
        ends: cells where their next moves begin. They differ from ``cells`` if the motion drives
            through cells.
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
            self._paths = _ShortestPaths(layouts)

    def enter(self, floor: int, cells: Integers, stream: np.random.Generator) -> None:
        """Place the people of a floor in their cells, with ``stream`` for their random numbers."""
        self.cells[floor] = self.ends[floor] = cells
        self._last[floor], self._is_blocked[floor] = WAIT, False
        self._streams[floor] = stream
        if self._walks_to_stations:
            self._goals[floor] = self._paths.goals(floor, stream.random(len(cells)))

    def actions(self) -> NDArray[np.intp]:
        """Return the action of each person in this step, 0 to 4, ``[B, P]``."""
        uniforms = np.array(
            [stream.random((self.cells.shape[1], NUMBERS)) for stream in self._streams]
        )
        weights = self._to_stations(uniforms[..., -1]) if self._walks_to_stations else self._ahead()
        # A blocked person may turn in any direction, which frees robots that wait for it.
        weights = np.where(self._is_blocked[..., None], ASIDE, weights)
        weights *= self._sides.take(self._base + self.ends, axis=0)
        with np.errstate(divide="ignore"):
            # Each direction has the least of these exponential times in proportion to its weight.
            times = -np.log1p(-uniforms[..., :WAIT]) / weights
        actions: NDArray[np.intp] = np.argmin(times, axis=-1)
        still = (uniforms[..., WAIT] < self._pause) | ~weights.any(axis=-1)
        actions[still] = WAIT
        self._moves = ~still
        self._last = np.where(still, self._last, actions)
        return actions

    def move(self, cells: Integers, ends: Integers) -> None:
        """Store the cells of people after a step, and the cells where their next moves begin."""
        self._is_blocked = self._moves & (ends == self.ends)
        self.cells, self.ends = cells.astype(np.intp), ends.astype(np.intp)

    def _ahead(self) -> NDArray[np.float64]:
        """Return the weights of the directions for people who walk along aisles."""
        return _AHEAD.take(self._last, axis=0)

    def _to_stations(self, uniforms: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the weights for people who walk to stations, after giving new goals on arrival."""
        paths, floors = self._paths, np.arange(len(self.cells))[:, None]
        arrived = paths.has_arrived(floors, self._goals, self.ends)
        self._goals = np.where(arrived, paths.others(floors, self._goals, uniforms), self._goals)
        return paths.weights(floors, self._goals, self.ends)


class _ShortestPaths:
    """The shortest paths to the goals of people in each layout.

    Goals are stations, or any open cells if a layout has fewer than two stations. ``floors``,
    ``goals`` and ``cells`` are arrays that can be broadcast to one shape.
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
        """Return a random other goal for each goal, or the same one if there is no other."""
        count = self._count[floors]
        others: Integers = (goals + 1 + (uniforms * (count - 1)).astype(np.intp)) % count
        return others

    def has_arrived(self, floors: Any, goals: Integers, cells: Integers) -> NDArray[np.bool_]:
        """Return whether each cell is the goal."""
        return self._is_goal.take(self._places(floors, goals, cells))

    def weights(self, floors: Any, goals: Integers, cells: Integers) -> NDArray[np.float64]:
        """Return the weights ``[..., 4]`` of the directions, large towards the goal."""
        nearer = self._is_nearer.take(self._places(floors, goals, cells), axis=0)
        return np.where(nearer, AHEAD, BACK)

    def _places(self, floors: Any, goals: Integers, cells: Integers) -> NDArray[np.intp]:
        places: NDArray[np.intp] = self._first[floors] + goals * self._size[floors] + cells
        return places


def _goals(layout: Layout) -> list[Cell]:
    """Return at most ``MAX_GOALS`` stations of a layout, or open cells without two stations."""
    cells: Sequence[Cell] = layout.pickups + layout.dropoffs
    if len(cells) < 2:
        cells = [layout.open_cell(rank) for rank in range(len(layout.open_cells))]
    every = -(-len(cells) // min(MAX_GOALS, MAX_GOAL_CELLS // size_of(layout)))
    return list(cells[::every])


def _is_nearer(field: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return ``[H * W, 4]``, whether the N, E, S and W neighbours of each cell are nearer."""
    around = np.pad(field, 1, constant_values=np.inf)
    height, width = field.shape
    sides = [
        around[1 + down : 1 + down + height, 1 + right : 1 + right + width]
        for down, right in DISPLACEMENTS[:WAIT]
    ]
    nearer: NDArray[np.bool_] = np.stack(sides, axis=-1) < field[..., None]
    return nearer.reshape(-1, WAIT)


_AHEAD = np.full((WAIT + 1, WAIT), ASIDE)
"""Weights of the directions after each action; before the first action all are equal."""
_AHEAD[range(WAIT), range(WAIT)] = AHEAD
_AHEAD[range(WAIT), [2, 3, 0, 1]] = BACK


class MingledMotion(BaseBatchMotion):
    """Motion of ``R`` robots among ``P`` people on each floor; see ``BatchMotion``.

    It wraps a motion of ``R + P`` bodies on each floor, of which the robots are first. People enter
    before robots are placed.
    """

    def __init__(self, motion: BaseBatchMotion, robots: int, walkers: Walkers) -> None:
        self._motion, self._robots, self._walkers = motion, robots, walkers
        self._bodies = robots + walkers.cells.shape[1]

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Place the robots and people of some floors in their cells; see ``BatchMotion.place``."""
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
        """Stop some robots for good; see ``BaseBatchMotion.fail``."""
        floors, robots = np.divmod(rows, self._robots)
        self._motion.fail(floors * self._bodies + robots)

    def outcomes(self, floor: int) -> Sequence[Outcome]:
        """Return the last outcomes of the robots on a floor, and then of its people."""
        return self._motion.outcomes(floor)

    def close(self) -> None:
        """Close the motion of robots and people; see ``BatchMotion.close``."""
        self._motion.close()

    def _joined(self, robots: NDArray[Any], people: NDArray[Any]) -> NDArray[Any]:
        """Join values of robots ``[F * R]`` and people ``[F, P]`` into values of all bodies."""
        return np.hstack([np.reshape(robots, (len(people), -1)), people]).ravel()

    def _of_people(self, bodies: NDArray[Any]) -> NDArray[Any]:
        """Return the values of people ``[F, P]``, given the values of all bodies."""
        return bodies.reshape(-1, self._bodies)[:, self._robots :]

    def _of_robots(self, bodies: NDArray[Any]) -> NDArray[Any]:
        """Return the values of robots ``[N]``, given the values of all bodies."""
        return bodies.reshape(-1, self._bodies)[:, : self._robots].ravel()
