from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from warehouse_core import Contact, Layout, LayoutError, Outcome
from warehouse_core.conformance.batch_checks import BATCH_CHECKS
from warehouse_core.motion.base import NOTHING, WALL
from warehouse_core.motion.grid import GridMotion
from warehouse_core.motion.separate import SeparateMotions

NORTH, EAST, SOUTH, WEST, WAIT = range(5)
HALL = Layout(["...", "..."])


def batch_of(layouts: Sequence[Layout], robots: int, make: Any = GridMotion) -> SeparateMotions:
    return SeparateMotions([make() for _ in layouts], layouts, robots)


class Separate(GridMotion):
    """A grid whose batches consist of single motions."""

    def batch(self, layouts: Sequence[Layout]) -> Any:
        return batch_of(layouts, 1)

    def fleet_batch(self, layouts: Sequence[Layout], robots: int) -> Any:
        return batch_of(layouts, robots)


@pytest.mark.parametrize("check", BATCH_CHECKS, ids=lambda check: check.__name__)
def test_it_conforms(check: Any) -> None:
    check(Separate)


class Scripted(GridMotion):
    """A motion with given outcomes, which records calls of ``reset`` and ``close``."""

    outcomes: Sequence[Outcome] = ()
    calls: list[Any]

    def reset(self, layout: Layout, cells: Any, seed: int | None) -> None:
        self.calls = [*getattr(self, "calls", []), (list(cells), seed)]

    def advance(self, displacements: Any, loaded: Any) -> Sequence[Outcome]:
        return self.outcomes

    def close(self) -> None:
        self.calls.append("closed")


def ended(cell: tuple[int, int], *counterparts: str, blocked: bool = True) -> Outcome:
    hits = tuple(Contact(0.5, 1.0, (0.0, 0.0), each) for each in counterparts)
    return Outcome(cell, blocked, 1.0, 1.0, np.zeros((2, 4)), hits)


def test_what_stopped_a_robot_is_read_from_its_outcome() -> None:
    """Robots 0 to 2 stand in the first row, 3 to 5 in the second."""
    batch = batch_of([HALL], 6, Scripted)
    batch.place(np.arange(6), np.arange(6))
    batch._motions[0].outcomes = [
        ended((0, 0), "robot 4", "wall"),
        ended((0, 1), "wall", "robot 0"),
        ended((0, 2), "a fence"),
        ended((1, 0)),
        ended((1, 1), "robot 3", blocked=False),
        ended((1, 2)),
    ]
    actions = np.array([SOUTH, NORTH, EAST, NORTH, WAIT, EAST])
    found = batch.advance(actions, np.zeros(6, bool)).stopped_by
    # Without contacts, robot 0 in the cell to the north stops 3, and something else stops 5.
    assert found.tolist() == [4, WALL, WALL, 0, NOTHING, WALL]


def test_robots_with_the_same_target_stop_each_other() -> None:
    """Some backends keep them from touching. A robot without a rival is stopped by a wall."""
    batch = batch_of([HALL], 3, Scripted)
    batch.place(np.arange(3), np.array([0, 2, 3]))
    batch._motions[0].outcomes = [ended((0, 0)), ended((0, 2)), ended((1, 0))]
    found = batch.advance(np.array([EAST, WEST, WEST]), np.zeros(3, bool))
    assert found.stopped_by.tolist() == [1, 0, WALL]


@pytest.mark.parametrize(
    "rows", [[0], [1, 2], [1, 0], [0, 1, 0, 1], [4, 5], [-2, -1], [0, 1, 2]], ids=str
)
def test_rows_that_are_not_whole_floors_raise(rows: list[int]) -> None:
    batch = batch_of([HALL] * 2, 2)
    with pytest.raises(ValueError, match=r"rows are \[.*2 on each of floors 0..1"):
        batch.place(np.array(rows), np.arange(len(rows)))


@pytest.mark.parametrize(
    ("cells", "seeds", "error", "message"),
    [
        ([0, 1, 2], None, ValueError, "3 cells and 2 seeds for 4 rows of 2 floors"),
        ([0, 1, 2, 3], [5], ValueError, "4 cells and 1 seeds for 4 rows"),
        ([0, 1, 2, 2], None, LayoutError, r"robots 0 and 1 are both placed in \(0, 2\)"),
        ([0, 1, 2, 6], None, LayoutError, "robot 1: row 2, column 0 is off the grid"),
    ],
)
def test_a_bad_place_changes_nothing(cells, seeds, error, message) -> None:
    batch = batch_of([HALL] * 2, 2)
    batch.place(np.arange(4), np.array([3, 4, 3, 4]))
    with pytest.raises(error, match=message):
        batch.place(np.arange(4), np.array(cells), seeds)
    found = batch.advance(np.full(4, WAIT), np.zeros(4, bool))
    assert found.cells.tolist() == [3, 4, 3, 4]


def test_calls_out_of_order_raise() -> None:
    batch = batch_of([HALL] * 2, 2)
    wait = np.full(4, WAIT), np.zeros(4, bool)
    batch.place(np.arange(2), np.array([3, 4]))
    with pytest.raises(RuntimeError, match="place"):
        batch.advance(*wait)
    with pytest.raises(RuntimeError, match="floor 0"):
        batch.outcomes(0)
    batch.place(np.array([2, 3]), np.array([3, 4]))
    batch.advance(*wait)
    batch.place(np.arange(2), np.array([3, 4]))
    assert len(batch.outcomes(1)) == 2
    with pytest.raises(RuntimeError, match="floor 0"):
        batch.outcomes(0)
