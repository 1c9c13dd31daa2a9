"""Each check fails for a motion that breaks its rule, and passes for the grid."""

import math
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest

from warehouse_core import Cell, Layout, Motion, Outcome
from warehouse_core.conformance import run_conformance
from warehouse_core.conformance.suite import CHECKS, ConformanceError
from warehouse_core.motion.base import BaseMotion, BatchOutcome
from warehouse_core.motion.grid import GridMotion
from warehouse_core.world.tiles import moved

NAMES = [check.__name__ for check in CHECKS]
CHECK = dict(zip(NAMES, CHECKS, strict=True))
STAY, NORTH, EAST, SOUTH, WEST = (0, 0), (-1, 0), (0, 1), (1, 0), (0, -1)


def failed_by(make_motion: Callable[[], Motion]) -> dict[str, str]:
    """Return the checks that a motion fails, with the details of the failures."""
    return {result.name: result.detail for result in run_conformance(make_motion).failures}


def path_of(rows: object) -> Any:
    path = np.array(rows)
    path.flags.writeable = False
    return path


class LoneGrid(GridMotion):
    """A grid without a batch, so that only the checks of single motions apply."""

    batch = BaseMotion.batch  # type: ignore[assignment]
    fleet_batch = BaseMotion.fleet_batch  # type: ignore[assignment]


class Altered(LoneGrid):
    """A grid that changes its outcomes before it returns them."""

    def __init__(self, alter: Callable[[Outcome], Outcome]) -> None:
        super().__init__(cell_size=0.5)
        self.alter = alter

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        return [self.alter(outcome) for outcome in super().advance(displacements, loaded)]


def having(**fields: Any) -> Callable[[Outcome], Outcome]:
    return lambda outcome: outcome._replace(**fields)


def with_path(change: Callable[[Any], Any]) -> Callable[[Outcome], Outcome]:
    return lambda outcome: outcome._replace(path=path_of(change(outcome.path.copy())))


def with_contact(**changed: object) -> Callable[[Outcome], Outcome]:
    return lambda outcome: outcome._replace(
        contacts=tuple(contact._replace(**changed) for contact in outcome.contacts)
    )


def shifted(*columns: float) -> Callable[[Any], Any]:
    return lambda path: path + np.array([0.0, *columns, 0.0])


def into_the_wall(outcome: Outcome) -> Outcome:
    if "wall" not in [contact.counterpart for contact in outcome.contacts]:
        return outcome
    (t0, x, y, heading), end = outcome.path
    ahead = [t0, x + math.cos(heading) / 2, y + math.sin(heading) / 2, heading]
    return outcome._replace(path=path_of([[t0, x, y, heading], ahead, end]))


def twice_in_falling_order(outcome: Outcome) -> Outcome:
    late = tuple(contact._replace(seconds=0.9) for contact in outcome.contacts)
    return outcome._replace(contacts=(*late, *outcome.contacts))


ALTERATIONS: dict[str, list[Callable[[Outcome], Outcome]]] = {
    "check_reset_puts_robots_at_rest": [
        with_path(shifted(0.1, 0.0)),
        with_path(lambda path: path + np.array([0.0, 0.0, 0.0, 1.0])),
    ],
    "check_a_free_move_ends_in_the_next_cell": [
        lambda outcome: outcome._replace(cell=(outcome.cell[0], 3)),
        having(blocked=True),
    ],
    "check_a_wall_stops": [
        having(blocked=False),
        with_contact(counterpart="door"),
        having(contacts=()),
    ],
    "check_waiting_stays": [having(blocked=True)],
    "check_a_move_costs_more_than_waiting": [having(joules=1.0)],
    "check_values_are_plain": [
        lambda outcome: outcome._replace(cell=list(outcome.cell)),
        lambda outcome: outcome._replace(cell=(np.int64(outcome.cell[0]), outcome.cell[1])),
        lambda outcome: outcome._replace(blocked=np.bool_(outcome.blocked)),
        *(having(seconds=seconds) for seconds in (1, 0.0)),
        *(having(joules=joules) for joules in (-1.0, math.nan, math.inf)),
    ],
    "check_paths_are_well_formed": [
        lambda outcome: outcome._replace(path=outcome.path.tolist()),
        lambda outcome: outcome._replace(path=outcome.path.copy()),
        with_path(lambda path: path.astype(np.float32)),
        with_path(lambda path: path[:1]),
        with_path(lambda path: path[:, :3]),
        with_path(lambda path: path * np.array([1, 1, 1, np.nan])),
        with_path(lambda path: np.vstack([path, path])),
        with_path(lambda path: path[::-1]),
        with_path(lambda path: path + np.array([0.1, 0, 0, 0])),
        having(seconds=0.5),
    ],
    "check_paths_join_up": [with_path(lambda path: path + np.array([[0, 0.01, 0, 0], [0] * 4]))],
    "check_paths_end_in_the_middle_of_a_cell": [
        with_path(lambda path: path + np.array([[0] * 4, [0, 0.1, 0, 0]]))
    ],
    "check_paths_keep_out_of_walls": [into_the_wall],
    "check_contacts_are_well_formed": [
        having(contacts=()),
        *(with_contact(seconds=seconds) for seconds in (-0.1, 1.1)),
        twice_in_falling_order,
        *(with_contact(impulse=impulse) for impulse in (0.0, math.inf, math.nan)),
        with_contact(point=(-9.0, 0.0)),
        *(with_contact(counterpart=name) for name in ("tree", "robot 0")),
    ],
}


@pytest.mark.parametrize(
    ("name", "alter"),
    [(name, alter) for name, alterations in ALTERATIONS.items() for alter in alterations],
)
def test_a_wrong_outcome_fails_its_check(name: str, alter: Callable[[Outcome], Outcome]) -> None:
    with pytest.raises((ConformanceError, AttributeError, TypeError)):
        CHECK[name](lambda: Altered(alter))


class WithoutWalls(LoneGrid):
    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        super().reset(layout, cells, seed)
        self._layout = Layout(["." * layout.width] * layout.height)


class WithoutEdge(LoneGrid):
    """Reads row -1 as the last row, like a list."""

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        super().reset(layout, cells, seed)
        self._layout = Layout([*layout.rows, "." * layout.width])


class Forgetful(LoneGrid):
    """Ignores a new layout of the same size."""

    _first: Layout | None = None

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        self._first = layout if self._first is None else self._first
        same_size = (layout.height, layout.width) == (self._first.height, self._first.width)
        super().reset(self._first if same_size else layout, cells, seed)


class Ghosts(LoneGrid):
    """Robots drive through each other."""

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        if len(self._cells) != len(displacements):
            return super().advance(displacements, loaded)
        cells, outcomes = self._cells, []
        for cell, displacement in zip(cells, displacements, strict=True):
            self._cells, self._headings = [cell], [EAST]
            outcomes += super().advance([displacement], [False])
        self._cells = [outcome.cell for outcome in outcomes]
        self._headings = [EAST] * len(cells)
        return outcomes


class Cautious(LoneGrid):
    """Robots do not enter a cell that another robot leaves in the same step."""

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        moves = zip(self._cells, displacements, strict=False)
        calm = [STAY if moved(cell, move) in self._cells else move for cell, move in moves]
        return super().advance(calm or displacements, loaded)


class Recycling(LoneGrid):
    """Returns the same array each time."""

    def __init__(self) -> None:
        super().__init__()
        self._memory = np.zeros((5, 2, 4))

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        outcomes = super().advance(displacements, loaded)
        for memory, outcome in zip(self._memory, outcomes, strict=False):
            memory[:] = outcome.path
        views = [memory.view() for memory in self._memory]
        for view in views:
            view.flags.writeable = False
        return [o._replace(path=view) for o, view in zip(outcomes, views, strict=False)]


class Lasting(LoneGrid):
    """A reset does not change the headings."""

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        headings = self._headings
        super().reset(layout, cells, seed)
        self._headings[: len(headings)] = headings[: len(cells)]


class Restless(LoneGrid):
    """A robot that waits moves east if that cell is open."""

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        if list(displacements) == [STAY] and self._cells == [(3, 3)]:
            displacements = [EAST]
        return super().advance(displacements, loaded)


class Rash(LoneGrid):
    """Turns the robots before it checks the moves."""

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        if self._cells and (1, 1) in displacements:
            self._headings = [NORTH] * len(self._cells)
        return super().advance(displacements, loaded)


class Hasty(LoneGrid):
    """Stores the layout before it checks the starts."""

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        self._layout, self._lone = layout, {}
        super().reset(layout, cells, seed)


class Undying(LoneGrid):
    def close(self) -> None:
        pass


class AlteredBatch(GridMotion):
    """A grid whose batches change their outcomes before they return them."""

    changed: ClassVar[dict[str, Callable[[Any], Any]]] = {}

    def _altered(self, batch: Any) -> Any:
        advance, changed = batch.advance, self.changed

        def altered(actions: Any, loaded: Any) -> BatchOutcome:
            outcome = advance(actions, loaded)
            changes = {name: change(getattr(outcome, name)) for name, change in changed.items()}
            return outcome._replace(**changes)

        # It has no method ``change``, so that no other check applies.
        outcomes = getattr(batch, "outcomes", None)
        return SimpleNamespace(
            place=batch.place, advance=altered, outcomes=outcomes, close=batch.close
        )

    def batch(self, layouts: Sequence[Layout]) -> Any:
        return self._altered(super().batch(layouts))

    def fleet_batch(self, layouts: Sequence[Layout], robots: int) -> Any:
        return self._altered(super().fleet_batch(layouts, robots))


def altering(name: str, **changed: Callable[[Any], Any]) -> type[AlteredBatch]:
    return type(name, (AlteredBatch,), {"changed": changed})


LateBatch = altering("LateBatch", seconds=lambda seconds: seconds * 1.001)
BlamesTheFirst = altering(
    "BlamesTheFirst", stopped_by=lambda stops: None if stops is None else stops.clip(max=0)
)


class ForgetsItsOutcomes(GridMotion):
    """A grid whose fleets return the outcomes of the first floor for all of them."""

    def fleet_batch(self, layouts: Sequence[Layout], robots: int) -> Any:
        batch: Any = super().fleet_batch(layouts, robots)
        outcomes = batch.outcomes
        batch.outcomes = lambda floor: outcomes(0)
        return batch


class StubbornBatch(GridMotion):
    """A grid whose batch ignores changes of its layouts."""

    def batch(self, layouts: Sequence[Layout]) -> Any:
        batch: Any = super().batch(layouts)
        batch.change = lambda floors, layouts: None
        return batch


class TirelessBatch(GridMotion):
    """A grid whose closed batch still moves."""

    def batch(self, layouts: Sequence[Layout]) -> Any:
        batch: Any = super().batch(layouts)
        batch.close = lambda: None
        return batch


BROKEN: dict[type[GridMotion], set[str]] = {
    WithoutWalls: {"check_a_wall_stops", "check_a_lone_robot_agrees_with_the_walls"},
    WithoutEdge: {"check_the_edge_stops"},
    Forgetful: {"check_a_new_layout_replaces_the_old"},
    Ghosts: {
        "check_robots_agree_with_the_traffic_rule",
        "check_traffic_same_target",
        "check_traffic_head_on",
        "check_traffic_occupied",
    },
    Cautious: {
        "check_robots_agree_with_the_traffic_rule",
        "check_traffic_following",
        "check_traffic_cycle",
    },
    Recycling: {"check_outcomes_are_kept_as_they_were"},
    Lasting: {"check_reset_puts_robots_at_rest", "check_equal_runs_are_equal"},
    Restless: {"check_waiting_stays", "check_a_move_costs_more_than_waiting"},
    Rash: {"check_bad_moves_change_nothing"},
    Hasty: {"check_bad_starts_change_nothing"},
    Undying: {"check_advance_needs_a_reset"},
    LateBatch: {
        "check_a_batch_moves_as_single_motions_do",
        "check_a_batch_of_fleets_moves_as_single_motions_do",
    },
    BlamesTheFirst: {"check_a_batch_of_fleets_moves_as_single_motions_do"},
    ForgetsItsOutcomes: {"check_a_batch_of_fleets_moves_as_single_motions_do"},
    StubbornBatch: {"check_a_batch_moves_in_changed_layouts"},
    TirelessBatch: {"check_a_closed_batch_does_not_move"},
}


@pytest.mark.parametrize("motion", BROKEN, ids=lambda motion: motion.__name__)
def test_a_broken_motion_fails_its_check(motion: type[GridMotion]) -> None:
    for name in BROKEN[motion]:
        with pytest.raises((ConformanceError, OSError)):
            CHECK[name](motion)


@pytest.mark.parametrize("motion", [WithoutEdge, Lasting, Rash, LateBatch, BlamesTheFirst])
def test_a_check_fails_for_its_own_rule_only(motion: type[GridMotion]) -> None:
    assert failed_by(motion).keys() == BROKEN[motion]


def test_every_check_fails_for_some_motion() -> None:
    assert set(ALTERATIONS).union(*BROKEN.values()) == set(NAMES)


@pytest.mark.parametrize("cell_size", [1.0, 2.5])
def test_the_grid_conforms(cell_size: float) -> None:
    report = run_conformance(lambda: GridMotion(cell_size))
    report.raise_for_failures()
    assert [result.name for result in report.results] == NAMES
    assert {result.status for result in report.results} == {"passed"}


class BatchRaises(GridMotion):
    """A grid whose methods ``batch`` and ``fleet_batch`` raise ValueError."""

    def batch(self, *_: Any) -> Any:
        raise ValueError("not with this motor")

    fleet_batch = batch


@pytest.mark.parametrize("motion", [LoneGrid, BatchRaises])
def test_a_motion_without_a_batch_conforms(motion: type[GridMotion]) -> None:
    run_conformance(motion).raise_for_failures()


class Crashing(GridMotion):
    def advance(self, *_: Any) -> Any:
        raise ZeroDivisionError("no mass")


def refuse() -> Motion:
    raise OSError("no licence")


@pytest.mark.parametrize(
    ("make_motion", "detail"),
    [
        (Crashing, "it raised ZeroDivisionError('no mass')"),
        (refuse, "it raised OSError('no licence')"),
    ],
)
def test_an_exception_in_a_motion_is_a_failure_of_the_check(make_motion, detail) -> None:
    failures = failed_by(make_motion)
    moved = [name for name in NAMES if name != "check_a_closed_batch_does_not_move"]
    assert [name for name in failures if name in moved] == moved
    assert set(failures.values()) == {detail}


def test_an_expected_failure_with_a_reason_is_not_a_failure() -> None:
    expected = dict.fromkeys(failed_by(Cautious), "it brakes for whoever is ahead")
    report = run_conformance(Cautious, expected)
    report.raise_for_failures()
    kept = {r.name: r for r in report.results if r.status == "expected failure"}
    assert kept.keys() == expected.keys()
    detail = kept["check_traffic_cycle"].detail
    assert detail.startswith("it brakes for whoever is ahead (robot 0 ended in")


def test_an_unexpected_pass_is_a_failure() -> None:
    report = run_conformance(GridMotion, {"check_a_wall_stops": "too fast"})
    (failure,) = report.failures
    assert (failure.name, failure.status) == ("check_a_wall_stops", "unexpected pass")
    with pytest.raises(ConformanceError, match=r"unexpected pass: check_a_wall_stops: .*too fast"):
        report.raise_for_failures()


def test_an_expected_failure_names_a_check_and_a_reason() -> None:
    with pytest.raises(ValueError, match="no check is called check_tyres, check_wheels"):
        run_conformance(GridMotion, {"check_wheels": "round", "check_tyres": "flat"})
    with pytest.raises(ValueError, match="check_a_wall_stops needs a reason"):
        run_conformance(GridMotion, {"check_a_wall_stops": "  "})


def test_a_report_has_one_line_for_each_check() -> None:
    lines = str(run_conformance(GridMotion)).splitlines()
    assert len(lines) == len(NAMES)
    assert lines[1].startswith(
        "passed: check_a_free_move_ends_in_the_next_cell: A move into a free"
    )
