"""The grid backend, in which robots move by whole cells.

Times and costs are nominal. They allow a comparison with a physical backend, which measures them. A
robot of ``NOMINAL_KG`` crosses a cell in ``NOMINAL_SECONDS``. For its cost see ``nominal_joules``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from struct import Struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import as_cell, real_number
from warehouse_core.compiled import IS_COMPILED, Vector, kernel
from warehouse_core.errors import LayoutError
from warehouse_core.motion.base import (
    NOTHING,
    WALL,
    WALL_CONTACT,
    BaseBatchMotion,
    BaseMotion,
    BatchOutcome,
    Contact,
    Outcome,
    centre_of,
    check_directions,
    check_moves,
    check_starts,
    robot_contact,
)
from warehouse_core.motion.traffic import ArrayTraffic, Moves, Obstacle, find_stops, stop_all
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Flags, Integers, LayoutSet, sides_table, size_of
from warehouse_core.world.tiles import EMPTY, MOVE_DELTAS, Cell, moved

NOMINAL_KG = 50.0
NOMINAL_SECONDS = 1.0
NOMINAL_IDLE_WATTS = 20.0
ROLLING_RESISTANCE = 0.015
"""Ratio of rolling force to weight; 0.01 to 0.02 is typical for a hard tyre on concrete."""
GRAVITY = 9.81

MAX_CELL_SIZE = 1e9
"""Limit on the side of a cell in metres."""

STAY, EAST = (0, 0), (0, 1)
ACTION_COUNT = len(DISPLACEMENTS)
NO_FACING = np.empty(0, np.intp)
NOT_MOVED = -1
"""Value of the cell before the last action if a robot has not moved since it was placed."""

ANGLES = {delta: math.atan2(*delta) for delta in MOVE_DELTAS.values()}
"""Heading of each move in radians; atan2 takes y (rows, downward) before x."""

_WALL_OR_NOTHING = np.array([NOTHING, WALL])
"""Obstacle of a robot that only walls can block, indexed by whether it is blocked."""

_pack = Struct("8d").pack

MAX_CACHED = 40_000
"""Limit on the cached outcomes of a single robot, about half a kilobyte each."""


class GridMotion(BaseMotion):
    """Motion of robots by whole cells, with the rules of right of way in ``traffic.py``.

    Args:
        cell_size: side of a cell in metres.

    Raises:
        ValueError: ``cell_size`` is not above 0, or more than ``MAX_CELL_SIZE``.

    Example:
        >>> from warehouse_core import DEFAULT_LAYOUT, GridMotion
        >>> motion = GridMotion()
        >>> motion.reset(DEFAULT_LAYOUT, [(1, 1), (1, 2)], seed=None)
        >>> [outcome.cell for outcome in motion.advance([(0, 1), (0, 1)], [False, False])]
        [(1, 2), (1, 3)]
    """

    def __init__(self, cell_size: float = 1.0) -> None:
        self.cell_size = real_number("cell_size", cell_size, 0, MAX_CELL_SIZE, above=True)
        self._moving_joules = nominal_joules(self.cell_size, moving=True)
        self._waiting_joules = nominal_joules(self.cell_size, moving=False)
        self._layout = Layout([EMPTY])
        self._cells: list[Cell] = []
        self._headings: list[Cell] = []
        self._facing: Sequence[Cell] = ()
        self._lone: dict[tuple[Cell, Cell, Cell], tuple[Outcome]] = {}

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        """Place the robots in their cells; see ``Motion.reset``. The seed is not used."""
        check_starts(layout, cells)
        if self._layout.open_cells is not layout.open_cells:
            self._lone = {}
        self._layout = layout
        self._cells = list(cells)
        self._headings, self._facing = [EAST] * len(cells), ()

    def face(self, directions: Sequence[Cell]) -> None:
        """Let robots turn on the spot in the next ``advance``; see ``BaseMotion.face``."""
        if not self._cells:
            raise RuntimeError("face() needs a reset() before it")
        check_directions(len(self._cells), directions)
        self._facing = tuple(directions)

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        """Move every robot by one action; see ``Motion.advance``.

        The outcome for a single robot depends only on the walls. So it is cached by cell,
        displacement and heading.
        """
        if self._facing or not len(self._cells) == len(displacements) == len(loaded) == 1:
            return self._advance_all(displacements, loaded)
        displacement = displacements[0]
        heading = self._headings[0] if displacement == STAY else displacement
        key = (self._cells[0], displacement, heading)
        outcomes = self._lone.get(key)
        if outcomes is None:
            outcomes = (self._first_outcome(self._cells[0], displacement, heading),)
            self._lone[key] = outcomes
        self._cells[0] = outcomes[0].cell
        self._headings[0] = heading
        return outcomes

    def carry(self, cell: Cell, displacement: Cell = STAY) -> Outcome:
        """Put a single robot in a cell, and return the outcome of getting there.

        Args:
            cell: cell that the rules of a subclass of ``WarehouseEnv`` have chosen.
            displacement: intended displacement. If it is a move and the robot is to stay, the
                robot counts as blocked.

        Raises:
            LayoutError: the cell is off the grid.
        """
        if not self._cells:
            raise RuntimeError("carry() needs a reset() before it")
        row, col = cell = as_cell("cell", cell)
        check_moves(len(self._cells), (as_cell("displacement", displacement),), (False,))
        if not (0 <= row < self._layout.height and 0 <= col < self._layout.width):
            raise LayoutError(f"cell {self._layout.describe(cell)}; it must be a cell of the grid")
        before, target, stop = self._cells[0], cell, None
        change = (cell[0] - before[0], cell[1] - before[1])
        if cell == before and displacement != STAY:
            target, stop, change = moved(before, displacement), WALL_CONTACT, displacement
        heading = change if change in ANGLES else self._headings[0]
        self._cells[0], self._headings[0] = cell, heading
        return self._outcome(before, target, heading, stop)

    def close(self) -> None:
        """Forget the robots; see ``Motion.close``."""
        self._cells, self._headings, self._lone = [], [], {}

    def batch(self, layouts: Sequence[Layout]) -> GridBatch:
        """Return a motion for one robot in each of these layouts; see ``BaseMotion.batch``."""
        return GridBatch(layouts, self.cell_size)

    def fleet_batch(self, layouts: Sequence[Layout], robots: int) -> GridFleetBatch:
        """Return a motion for several robots in each layout; see ``BaseMotion.fleet_batch``."""
        return GridFleetBatch(layouts, self.cell_size, robots)

    def _advance_all(
        self, displacements: Sequence[Cell], loaded: Sequence[bool]
    ) -> tuple[Outcome, ...]:
        if not self._cells:
            raise RuntimeError("advance() needs a reset() before it")
        check_moves(len(self._cells), displacements, loaded)
        targets = list(map(moved, self._cells, displacements))
        stops = find_stops(self._layout, self._cells, targets)
        turns, self._facing = self._facing or displacements, ()
        starts = [
            heading if move == STAY else move
            for heading, move in zip(self._headings, displacements, strict=True)
        ]
        self._headings = [
            turn if move == STAY != turn else heading
            for heading, move, turn in zip(starts, displacements, turns, strict=True)
        ]
        outcomes = tuple(map(self._outcome, self._cells, targets, self._headings, stops, starts))
        self._cells = [outcome.cell for outcome in outcomes]
        return outcomes

    def _first_outcome(self, cell: Cell, displacement: Cell, heading: Cell) -> Outcome:
        """Return an outcome that is not in the cache yet, and make room for it in a full cache."""
        target = moved(cell, displacement)
        check_moves(1, (displacement,), (False,))
        if len(self._lone) >= MAX_CACHED:
            self._lone.clear()
        stop = None if self._layout.is_open(target) else WALL_CONTACT
        return self._outcome(cell, target, heading, stop)

    def _outcome(
        self, cell: Cell, target: Cell, heading: Cell, stop: Obstacle, start: Cell | None = None
    ) -> Outcome:
        """Return the outcome of a move, or of a turn to ``heading`` from ``start``."""
        end = target if stop is None else cell
        x0, y0 = centre_of(cell, self.cell_size)
        x1, y1 = centre_of(end, self.cell_size)
        angle = before = ANGLES[heading]
        if start is not None and start != heading:
            before -= math.remainder(angle - ANGLES[start], math.tau)
        # An array made from bytes is read-only, and is made faster than an array from tuples.
        data = _pack(0.0, x0, y0, before, NOMINAL_SECONDS, x1, y1, angle)
        path = np.ndarray((2, 4), np.float64, data)
        joules = self._waiting_joules if target == cell else self._moving_joules
        if stop is None:
            return Outcome(end, False, NOMINAL_SECONDS, joules, path)
        # The nominal hit happens halfway, at the edge of the cell, and takes all momentum.
        down, right = heading
        hit = Contact(
            seconds=NOMINAL_SECONDS / 2,
            impulse=NOMINAL_KG * self.cell_size / NOMINAL_SECONDS,
            point=(x0 + right * self.cell_size / 2, y0 + down * self.cell_size / 2),
            counterpart=stop if isinstance(stop, str) else robot_contact(stop),
        )
        return Outcome(end, True, NOMINAL_SECONDS, joules, path, (hit,))


class GridBatch(BaseBatchMotion):
    """Motion of one robot in each of ``B`` layouts, by table lookup; see ``BatchMotion``."""

    changes_layouts = True

    def __init__(self, layouts: Sequence[Layout], cell_size: float, robots: int = 1) -> None:
        self._closed = False
        self._layouts, self._robots = LayoutSet(layouts), robots
        count = len(layouts) * robots
        self._cells = np.zeros(count, np.int32)
        self._base = np.repeat(self._layouts.base, robots) * ACTION_COUNT
        self._next = np.concatenate([_next_cells(layout) for layout in self._layouts.kinds])
        self._seconds = np.full(count, NOMINAL_SECONDS)
        self._joules = np.full(len(DISPLACEMENTS), nominal_joules(cell_size, moving=False))
        self._joules[:WAIT] = nominal_joules(cell_size, moving=True)

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Place some of the robots in their cells; see ``BatchMotion.place``."""
        self._cells[rows] = cells

    def change(self, floors: Integers, layouts: Sequence[Layout]) -> None:
        """Replace the layouts of some floors; see ``BaseBatchMotion.change``."""
        known = len(self._layouts.kinds)
        self._layouts.change(floors, layouts)
        if new := self._layouts.kinds[known:]:
            self._next = np.concatenate([self._next, *map(_next_cells, new)])
        self._base = np.repeat(self._layouts.base, self._robots) * ACTION_COUNT

    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Move every robot by one action; see ``BatchMotion.advance``."""
        if self._closed:
            raise RuntimeError("advance() after close()")
        before = self._cells
        self._cells = self._next.take(self._base + before * ACTION_COUNT + actions)
        blocked = (self._cells == before) & (actions < WAIT)
        joules = self._joules.take(actions)
        return BatchOutcome(self._cells.astype(np.intp), blocked, self._seconds.copy(), joules)

    def close(self) -> None:
        """Make later calls of ``advance`` raise an error; see ``BatchMotion.close``."""
        self._closed = True


class GridArrays(NamedTuple):
    """Arrays of ``move_all`` for ``N`` robots.

    Attributes:
        next_cells: cell after each action in each cell of all layouts.
        base: ``[N]`` index in ``next_cells`` of the first entry of each robot's layout.
        joules_of: energy of each action.
        floor: ``[N]`` number of the first cell of each robot's floor.
        cells: ``[N]`` cell of each robot within its layout.
        before: ``[N]`` cells before the last action.
        starts, headings: ``[N]`` directions at the start and at the end of the last action.
        moving: ``[N]`` flags of robots whose last action was a move.
        moves: arrays of ``stop_all``.
        robots: number of robots on each floor.
    """

    next_cells: Vector[np.int32]
    base: Vector[np.intp]
    joules_of: Vector[np.float64]
    floor: Vector[np.intp]
    cells: Vector[np.int32]
    before: Vector[np.int32]
    starts: Vector[np.intp]
    headings: Vector[np.intp]
    moving: Vector[np.bool_]
    moves: Moves
    robots: int


@kernel
def move_all(
    grid: GridArrays,
    actions: Vector[np.intp],
    facing: Vector[np.intp],
    cells: Vector[np.intp],
    blocked: Vector[np.bool_],
    joules: Vector[np.float64],
    stops: Vector[np.intp],
) -> None:
    """Move every robot by one action.

    Args:
        grid: state of the robots, which is changed.
        actions: ``[N]`` index into ``DISPLACEMENTS`` for each robot.
        facing: ``[N]`` new direction of each robot, see ``face``; empty if no robot turns.
        cells: ``[N]`` cell of each robot after the action, to be filled in like all that follow.
        blocked: ``[N]`` flags of robots that something stopped.
        joules: ``[N]`` energy of each action.
        stops: ``[N]`` obstacle of each robot, as in ``BatchOutcome``.
    """
    moves = grid.moves
    for robot in range(len(actions)):
        action, cell = actions[robot], grid.cells[robot]
        target = grid.next_cells[grid.base[robot] + cell * ACTION_COUNT + action]
        grid.before[robot], grid.moving[robot] = cell, action < WAIT
        if action < WAIT:
            grid.headings[robot] = action
        grid.starts[robot] = grid.headings[robot]
        if action >= WAIT and len(facing) and facing[robot] < WAIT:
            grid.headings[robot] = facing[robot]
        cells[robot], joules[robot] = target, grid.joules_of[action]
        moves.cells[robot] = grid.floor[robot] + cell
        moves.targets[robot] = grid.floor[robot] + target
        stops[robot] = WALL if action < WAIT and target == cell else NOTHING
    if grid.robots > 1:
        stop_all(moves, stops)
    for robot in range(len(actions)):
        blocked[robot] = stops[robot] != NOTHING
        if blocked[robot]:
            cells[robot] = grid.before[robot]
        if stops[robot] >= 0:
            stops[robot] %= grid.robots
        grid.cells[robot] = cells[robot]


class GridFleetBatch(GridBatch):
    """Motion of ``R`` robots in each of ``B`` layouts, with the rules of ``traffic.py``.

    See ``BatchMotion``.
    """

    def __init__(self, layouts: Sequence[Layout], cell_size: float, robots: int) -> None:
        super().__init__(layouts, cell_size, robots)
        self._motion = GridMotion(cell_size)
        ends = np.cumsum(self._layouts.of_rows([size_of(kind) for kind in self._layouts.kinds]))
        self._floor = np.repeat([0, *ends[:-1].tolist()], robots)
        self._traffic = ArrayTraffic(int(ends[-1]), len(layouts), robots)
        self._moves = self._traffic.moves()
        self._before = np.full_like(self._cells, NOT_MOVED)
        self._headings, self._starts = np.full((2, len(self._cells)), DISPLACEMENTS.index(EAST))
        self._moving = self._cells > 0
        self._facing: NDArray[np.intp] = NO_FACING

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Place the robots of some floors in their cells; see ``BatchMotion.place``."""
        super().place(rows, cells)
        self._before[rows] = NOT_MOVED
        self._headings[rows] = DISPLACEMENTS.index(EAST)

    def face(self, actions: Integers) -> None:
        """Let robots turn on the spot in the next ``advance``; see ``BaseBatchMotion.face``."""
        self._facing = np.ascontiguousarray(actions, np.intp)

    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Move every robot by one action; see ``BatchMotion.advance``."""
        facing, self._facing = self._facing, NO_FACING
        if IS_COMPILED and not self._closed:
            return self._advance_in_a_loop(np.ascontiguousarray(actions, np.intp), facing)
        self._before, self._moving = self._cells, actions < WAIT
        np.copyto(self._headings, actions, where=self._moving)
        self._starts = self._headings
        if facing.size:
            turning = (facing < WAIT) & ~self._moving
            self._headings = np.where(turning, facing, self._headings)
        cells, blocked, seconds, joules, *_ = super().advance(actions, loaded)
        if self._robots == 1:
            return BatchOutcome(cells, blocked, seconds, joules, _WALL_OR_NOTHING.take(blocked))
        starts, targets = self._floor + self._before, self._floor + cells
        stops = self._traffic.find_stops(starts, targets, blocked)
        blocked = stops != NOTHING
        cells = np.where(blocked, self._before, cells)
        self._cells = cells.astype(np.int32)
        return BatchOutcome(cells, blocked, seconds, joules, stops)

    def _advance_in_a_loop(
        self, actions: NDArray[np.intp], facing: NDArray[np.intp]
    ) -> BatchOutcome:
        grid = GridArrays(
            self._next, self._base, self._joules, self._floor, self._cells, self._before,
            self._starts, self._headings, self._moving, self._moves, self._robots,
        )  # fmt: skip
        count = len(actions)
        cells, stops = np.empty(count, np.intp), np.empty(count, np.intp)
        blocked, joules = np.empty(count, np.bool_), np.empty(count)
        move_all(grid, actions, facing, cells, blocked, joules, stops)
        return BatchOutcome(cells, blocked, self._seconds.copy(), joules, stops)

    def outcomes(self, floor: int) -> Sequence[Outcome]:
        """Return the last outcomes on one floor; see ``BaseBatchMotion.outcomes``."""
        rows = slice(floor * self._robots, (floor + 1) * self._robots)
        starts, moving = self._before[rows].tolist(), self._moving[rows].tolist()
        if NOT_MOVED in starts:
            raise RuntimeError(f"outcomes() needs an advance() after the place() of floor {floor}")
        layout = self._layouts.kinds[self._layouts.kind[floor]]
        self._motion.reset(layout, layout.cells(starts), None)
        starts, ends = (
            [DISPLACEMENTS[heading] for heading in headings[rows].tolist()]
            for headings in (self._starts, self._headings)
        )
        self._motion._headings = starts
        self._motion.face(ends)
        moves = [move if moves else STAY for move, moves in zip(starts, moving, strict=True)]
        return self._motion.advance(moves, moving)


def _next_cells(layout: Layout) -> NDArray[np.int32]:
    """Return the cell after each action in each cell, ``[N * actions]``."""
    sides = sides_table([layout])
    steps = layout.numbers(DISPLACEMENTS)
    cells = np.repeat(np.arange(len(sides))[:, None], len(DISPLACEMENTS), axis=1)
    cells[:, :WAIT] += sides * steps[:WAIT]
    return cells.ravel().astype(np.int32)  # int32 is read faster than intp


def nominal_joules(cell_size: float, *, moving: bool) -> float:
    """Return the nominal cost of one action in joules.

    Every action costs idle power. A move, even if it is blocked, also costs the kinetic energy at
    its mean speed and the work against rolling resistance over one cell.
    """
    idle = NOMINAL_IDLE_WATTS * NOMINAL_SECONDS
    if not moving:
        return idle
    speed = cell_size / NOMINAL_SECONDS
    rolling = ROLLING_RESISTANCE * NOMINAL_KG * GRAVITY * cell_size
    return idle + 0.5 * NOMINAL_KG * speed**2 + rolling
