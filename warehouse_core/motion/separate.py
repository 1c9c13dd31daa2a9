"""A batch motion that consists of one motion for each floor, for backends without batches."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.motion.base import (
    NOTHING,
    WALL,
    BaseBatchMotion,
    BaseMotion,
    BatchOutcome,
    Motion,
    Outcome,
    check_starts,
    robot_contact,
    with_defaults,
)
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Flags, Integers
from warehouse_core.world.tiles import Cell, moved


class SeparateMotions(BaseBatchMotion):
    """Motion of ``R`` robots in each of ``B`` layouts, with one motion per layout.

    See ``BatchMotion``. ``stopped_by`` of a blocked robot is the counterpart of its first contact.
    Without a contact it is the robot that is in its target cell, or another robot with the same
    target cell. Anything that is not a robot counts as a wall. The motions must all be different,
    and ``close`` closes them.
    """

    def __init__(self, motions: Sequence[Motion], layouts: Sequence[Layout], robots: int) -> None:
        self._motions: list[BaseMotion] = list(map(with_defaults, motions))
        self._layouts, self._robots = list(layouts), robots
        self._cells: list[list[Cell]] = [[] for _ in layouts]
        self._outcomes: list[Sequence[Outcome]] = [() for _ in layouts]
        self._number_of = {robot_contact(robot): robot for robot in range(robots)}

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Place the robots of some floors in their cells; see ``BatchMotion.place``.

        Nothing changes if an argument is refused.

        Raises:
            LayoutError: a cell is not open, or is given twice on a floor.
            ValueError: the rows are not all robots of different floors in order, or the numbers of
                cells or seeds do not fit.
        """
        floors = self._whole_floors(rows)
        seeds = [None] * len(floors) if seeds is None else seeds
        if (len(cells), len(seeds)) != (len(rows), len(floors)):
            raise ValueError(
                f"{len(cells)} cells and {len(seeds)} seeds for {len(rows)} rows of "
                f"{len(floors)} floors; each row needs a cell, and each floor a seed"
            )
        layouts = [self._layouts[floor] for floor in floors]
        starts = [
            layout.cells(each) for layout, each in zip(layouts, self._by_floor(cells), strict=True)
        ]
        for layout, each in zip(layouts, starts, strict=True):
            check_starts(layout, each)
        for floor, layout, each, seed in zip(floors, layouts, starts, seeds, strict=True):
            self._motions[floor].reset(layout, each, seed)
            self._cells[floor], self._outcomes[floor] = each, ()

    changes_layouts = True

    def change(self, floors: Integers, layouts: Sequence[Layout]) -> None:
        """Replace the layouts of some floors; see ``BaseBatchMotion.change``."""
        for floor, layout in zip(floors.tolist(), layouts, strict=True):
            self._layouts[floor], self._cells[floor], self._outcomes[floor] = layout, [], ()

    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Carry out one action for each robot; see ``BatchMotion.advance``.

        Raises:
            RuntimeError: a floor has not been placed yet, or the motion is closed.
        """
        if not all(self._cells):
            raise RuntimeError("advance() needs a place() of every floor before it")
        stopped_by: list[int] = []
        driving: list[bool] = []
        failed: list[bool] = []
        pairs = zip(self._by_floor(actions).tolist(), self._by_floor(loaded).tolist(), strict=True)
        for floor, (chosen, loads) in enumerate(pairs):
            motion, moves = self._motions[floor], [DISPLACEMENTS[action] for action in chosen]
            targets = list(map(moved, self._cells[floor], moves))
            outcomes = self._outcomes[floor] = motion.advance(moves, loads)
            self._cells[floor] = [outcome.cell for outcome in outcomes]
            if motion.drives_through:
                routes = motion.routes()
                self._cells[floor] = list(routes.ends)
                driving += [not rests for rests in routes.at_rest]
                failed += routes.failed
            stopped_by += self._stoppers(targets, self._cells[floor], outcomes)
        each = [outcome[:4] for outcomes in self._outcomes for outcome in outcomes]
        cells, blocked, seconds, joules = zip(*each, strict=True)
        return BatchOutcome(
            self._numbers(cells),
            np.array(blocked, np.bool_),
            np.array(seconds, np.float64),
            np.array(joules, np.float64),
            np.array(stopped_by, np.intp),
            self._numbers(chain.from_iterable(self._cells)) if driving else None,
            np.array(driving, np.bool_) if driving else None,
            np.array(failed, np.bool_) if failed else None,
        )

    def face(self, actions: Integers) -> None:
        """Let robots turn on the spot; see ``BaseBatchMotion.face``."""
        for motion, chosen in zip(self._motions, self._by_floor(actions).tolist(), strict=True):
            motion.face([DISPLACEMENTS[action] for action in chosen])

    def outcomes(self, floor: int) -> Sequence[Outcome]:
        """Return the last outcomes on one floor; see ``BaseBatchMotion.outcomes``."""
        if not self._outcomes[floor]:
            raise RuntimeError(f"outcomes() needs an advance() after the place() of floor {floor}")
        return self._outcomes[floor]

    def fail(self, rows: Integers) -> None:
        """Stop some robots for good; see ``BaseBatchMotion.fail``."""
        for row in rows.tolist():
            floor, robot = divmod(row, self._robots)
            self._motions[floor].fail(robot)

    def close(self) -> None:
        """Close all motions; see ``BatchMotion.close``."""
        for motion in self._motions:
            motion.close()
        self._cells = [[] for _ in self._layouts]

    def _numbers(self, cells: Iterable[Cell]) -> NDArray[np.intp]:
        """Return the numbers of the cells of all robots, ``[N]``, floor by floor."""
        widths = np.repeat([layout.width for layout in self._layouts], self._robots)
        places = np.array(list(cells), np.intp)
        numbers: NDArray[np.intp] = places[:, 0] * widths + places[:, 1]
        return numbers

    def _by_floor(self, values: NDArray[Any]) -> NDArray[Any]:
        return np.reshape(values, (-1, self._robots))

    def _whole_floors(self, rows: Integers) -> list[int]:
        """Return the floors of the rows, which must be all robots of these floors."""
        floors = np.asarray(rows)[:: self._robots] // self._robots
        whole = floors[:, None] * self._robots + np.arange(self._robots)
        numbers: list[int] = floors.tolist()
        known = set(numbers) & set(range(len(self._layouts)))
        if len(known) < len(numbers) or not np.array_equal(whole.ravel(), rows):
            raise ValueError(
                f"rows are {rows}; they must be all robots of different floors in order, "
                f"{self._robots} on each of floors 0..{len(self._layouts) - 1}"
            )
        return numbers

    def _stoppers(
        self, targets: Sequence[Cell], ends: Sequence[Cell], outcomes: Sequence[Outcome]
    ) -> Iterator[int]:
        """Yield the obstacle that stopped each robot: a robot, ``WALL`` or ``NOTHING``."""
        rivals = defaultdict[Cell, list[int]](list)
        for robot, target in enumerate(targets):
            rivals[target].append(robot)
        robot_in = {end: robot for robot, end in enumerate(ends)}
        for robot, (target, outcome) in enumerate(zip(targets, outcomes, strict=True)):
            if not outcome.blocked:
                yield NOTHING
            elif outcome.contacts:
                yield self._number_of.get(outcome.contacts[0].counterpart, WALL)
            elif target in robot_in:
                yield robot_in[target]
            else:
                yield next((other for other in rivals[target] if other != robot), WALL)
