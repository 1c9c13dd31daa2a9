"""Robots that fail while they drive through joint plans: all others come to rest at open cells."""

import itertools
import math
import random
import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.driving import crowds
from helpers.driving_validator import motion_fault
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import Cell, Layout
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec, Stop

FAST = RobotSpec.fast()
SPECS = RobotSpec(), FAST, replace(FAST, turn_seconds=0.5)
MAX_SECONDS = 150
MOVES = list(DISPLACEMENTS[:5])


class Failures:
    """Robots that execute a plan, of which some fail."""

    def __init__(
        self, layout: Layout, plan: list[list[Cell]], spec: RobotSpec, loaded: list[bool]
    ) -> None:
        self.motion, self._layout, self._loaded = DrivingMotion(spec, path_every=1), layout, loaded
        self.motion.reset(layout, plan[0], 0)
        self._paths: list[np.ndarray] = []
        self.hits = 0
        self.move([(0, 0)] * len(loaded))
        for cells in plan[1:]:
            self.motion.extend(cells)

    def drive(self, seconds: float) -> None:
        self._add(self.motion.drive(seconds))

    def move(self, displacements: list[Cell]) -> None:
        self._add(self.motion.advance(displacements, self._loaded))

    def _add(self, outcomes: list) -> None:
        self._paths.append(np.stack([outcome.path[:, 1:3] for outcome in outcomes], axis=1))
        self.hits += sum(len(outcome.contacts) for outcome in outcomes)

    def come_to_rest(self) -> None:
        """Drive until all robots that have not failed are at rest at different open cells."""
        for _ in range(MAX_SECONDS):
            ways = self.motion.ways()
            if all(rests or fails for rests, fails in zip(ways.at_rest, ways.failed, strict=True)):
                break
            self.drive(1.0)
        else:
            raise AssertionError(f"robots do not arrive: {ways}")
        self.drive(2.0)
        live = [end for end, fails in zip(ways.ends, ways.failed, strict=True) if not fails]
        assert len({*live, *ways.closed}) == len(live) + len(ways.closed)
        for robot, (row, col) in enumerate(ways.ends):
            assert self._layout.is_open((row, col))
            assert not ways.failed[robot] or (row, col) in ways.closed
            if not ways.failed[robot]:
                x, y = self._paths[-1][-1, robot]
                assert math.dist((x, y), (col + 0.5, row + 0.5)) < 2e-3

    def check(self) -> None:
        """Check what robots have done so far."""
        rows = [self._paths[0][:1], *(path[1:] for path in self._paths)]
        assert self.hits == 0
        assert motion_fault(np.concatenate(rows), self.motion.spec) is None


@given(
    st.one_of(crowds(), crowds(".")),
    st.sampled_from(SPECS),
    st.lists(st.floats(0.02, 4.0), min_size=1, max_size=3),
)
@settings(max_examples=8)
def test_robots_come_to_rest_and_go_on_around_those_that_fail(drawn, spec, pauses) -> None:
    layout, plan, loaded, stream = drawn
    crowd = Failures(layout, plan, spec, loaded)
    robots = range(len(crowd.motion.ways().ends))
    for pause in pauses:
        crowd.drive(pause)
        crowd.motion.fail(stream.choice(robots))
    crowd.come_to_rest()
    for _ in range(10):
        crowd.move([stream.choice(MOVES) for _ in robots])
    crowd.come_to_rest()
    crowd.check()


def test_a_robot_that_fails_on_its_way_back_leaves_others_cells_to_them() -> None:
    """The first robot fails where it stands, so the second stays, and the third turns back.

    Then the third fails, close behind the second. Each cell has at most one of them.
    """
    layout, stays = Layout(["......", "#####."]), (Stop(0, 0.0, 60.0),)
    plan = [[(0, 5), (0, 4), (0, 1)], [(0, 5), (0, 4), (0, 2)],
            [(1, 5), (0, 4), (0, 3)], [(1, 5), (0, 5), (0, 4)]]  # fmt: skip
    for spec, at in itertools.product((RobotSpec(), FAST), np.arange(2.0, 5.0, 0.5)):
        motion = DrivingMotion(spec, Disturbances(stops=stays))
        motion.reset(layout, [(0, 5), (0, 4), (0, 0)], 0)
        for cells in plan:
            motion.extend(cells)
        outcomes = [*motion.drive(at)]
        motion.fail(0)
        outcomes += motion.drive(0.02)
        motion.fail(2)
        outcomes += motion.drive(5.0)
        ways = motion.ways()
        live = [end for end, fails in zip(ways.ends, ways.failed, strict=True) if not fails]
        assert len({*live, *ways.closed}) == len(live) + len(ways.closed), at
        assert not any(outcome.contacts for outcome in outcomes), at


@pytest.mark.parametrize("back", [False, True])
def test_the_closed_cells_are_those_in_which_a_robot_would_be_too_near(back: bool) -> None:
    """Wherever it fails: while it speeds up, drives, brakes and turns back."""
    layout, apart = Layout(["." * 4]), 2 * FAST.radius
    way = [0, 1, 2, 1, 0] if back else [0, 1, 2, 3]
    for at in np.arange(1, 60 + 30 * back, 2) / 30:
        motion = DrivingMotion(FAST)
        motion.reset(layout, [(0, 0)], 0)
        for col in way[1:]:
            motion.extend([(0, col)])
        motion.drive(at)
        motion.fail(0)
        x = motion.drive(1.2)[0].path[-1, 1]
        closed = {col for _, col in motion.ways().closed}
        assert {col for col in range(4) if abs(x - col - 0.5) < apart + 0.01} <= closed
        assert closed <= {col for col in range(4) if abs(x - col - 0.5) < apart + 0.032}


@pytest.mark.parametrize("at", [0.35, 0.7, 2.25, 2.7])
def test_a_failure_in_a_ring_without_room_stops_all_robots(at: float) -> None:
    """One that fails between two cells leaves no cells for all others, who stop where they are."""
    ring = [(0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (2, 1), (2, 0), (1, 0)]
    plan = [[ring[(robot + step) % 8] for robot in range(8)] for step in range(4)]
    crowd = Failures(Layout(["...", ".#.", "..."]), plan, FAST, [False] * 8)
    crowd.drive(at)
    crowd.motion.fail(0)
    crowd.come_to_rest()
    crowd.check()
    failed = crowd.motion.ways().failed
    assert sum(failed) == (8 if len(crowd.motion.ways().closed) > 1 else 1)


@pytest.mark.parametrize("at", [0.6, 1.0, 1.5])
def test_a_robot_that_is_caught_between_two_that_fail_stops_and_fails_too(at: float) -> None:
    plan = [[(0, 3 - robot + step) for robot in range(4)] for step in range(5)]
    crowd = Failures(Layout(["." * 8]), plan, FAST, [False] * 4)
    crowd.drive(at)
    for robot in (2, 0):
        crowd.motion.fail(robot)
    crowd.come_to_rest()
    crowd.check()
    failed = crowd.motion.ways().failed
    assert failed[::2] == [True, True]
    assert failed[1] == (at != 1.0)
    assert not failed[3]


@pytest.mark.parametrize("seed", range(5))
def test_a_failure_in_a_corner_leaves_the_order_of_all_others_as_it_is(seed: int) -> None:
    stream, starts = random.Random(seed), [(0, 5), (4, 2), (1, 1), (1, 2)]
    crowd = Failures(Layout(["......"] * 5), [starts], FAST, [False] * 4)
    for step in range(40):
        if step == 5:
            crowd.motion.fail(0)
        crowd.move([(0, 0), *(stream.choice(MOVES) for _ in starts[1:])])
    crowd.come_to_rest()
    crowd.check()
    assert crowd.motion.ways().closed == [(0, 5)]


def test_no_way_is_extended_for_a_robot_that_has_failed_or_into_its_cell() -> None:
    motion = DrivingMotion(FAST)
    motion.reset(Layout(["....."]), [(0, 1), (0, 2), (0, 4)], 0)
    motion.extend([(0, 1), (0, 3), (0, 4)])
    motion.drive(0.7)
    motion.fail(1)
    for cells, message in (
        ([(0, 1), (0, 3), (0, 4)], "robot 1 cannot go from (0, 2) to (0, 3); it has failed"),
        (
            [(0, 1), (0, 2), (0, 3)],
            "robot 2 cannot go from (0, 4) to (0, 3); a robot that has failed closes it",
        ),
    ):
        with pytest.raises(ValueError, match=re.escape(message)):
            motion.extend(cells)
    motion.extend([(0, 0), (0, 2), (0, 4)])
    assert motion.ways().ends == [(0, 0), (0, 2), (0, 4)]
