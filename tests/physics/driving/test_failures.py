"""Robots that fail while they drive through joint plans: the others come to rest in open cells."""

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.driving import Failures, crowds
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import Layout
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_physics import Disturbances, DrivingMotion, RobotSpec, Stop

FAST = RobotSpec.fast()
SPECS = RobotSpec(), FAST, replace(FAST, turn_seconds=0.5)
MOVES = list(DISPLACEMENTS[:5])


@given(
    st.one_of(crowds(), crowds(".")),
    st.sampled_from(SPECS),
    st.lists(st.floats(0.02, 4.0), min_size=1, max_size=3),
)
@settings(max_examples=5)
def test_robots_come_to_rest_and_go_on_around_those_that_fail(example, spec, pauses) -> None:
    layout, plan, loaded, stream = example
    crowd = Failures(layout, plan, spec, loaded)
    robots = range(len(crowd.motion.routes().ends))
    for pause in pauses:
        crowd.drive(pause)
        crowd.motion.fail(stream.choice(robots))
    crowd.come_to_rest()
    for _ in range(10):
        crowd.move([stream.choice(MOVES) for _ in robots])
    crowd.come_to_rest()
    crowd.check()


def test_a_robot_stops_before_a_failed_robot_that_is_beyond_its_next_corner() -> None:
    motion = DrivingMotion()
    motion.reset(Layout(["...."] * 4), [(3, 2), (0, 0)], 0)
    for cell in ((0, 1), (0, 2), (1, 2), (2, 2), (3, 2)):
        motion.extend([(3, 3), cell])
    motion.fail(0)
    assert motion.routes().ends == [(3, 2), (2, 2)]
    _, outcome = motion.drive(15.0)
    assert (outcome.cell, outcome.contacts) == ((2, 2), ())


def test_a_robot_that_fails_on_its_way_back_leaves_others_cells_to_them() -> None:
    """The first robot fails while it waits, so the second stays and the third turns back.

    Then the third fails, close behind the second. Each cell has at most one of them.
    """
    layout, stays = Layout(["......", "#####."]), (Stop(0, 0.0, 60.0),)
    plan = [[(0, 5), (0, 4), (0, 1)], [(0, 5), (0, 4), (0, 2)],
            [(1, 5), (0, 4), (0, 3)], [(1, 5), (0, 5), (0, 4)]]  # fmt: skip
    for spec, at in itertools.product((RobotSpec(), FAST), np.arange(2.0, 5.0, 1.0)):
        motion = DrivingMotion(spec, Disturbances(stops=stays))
        motion.reset(layout, [(0, 5), (0, 4), (0, 0)], 0)
        for cells in plan:
            motion.extend(cells)
        outcomes = [*motion.drive(at)]
        motion.fail(0)
        outcomes += motion.drive(0.02)
        motion.fail(2)
        outcomes += motion.drive(5.0)
        routes = motion.routes()
        live = [end for end, fails in zip(routes.ends, routes.failed, strict=True) if not fails]
        assert len({*live, *routes.closed}) == len(live) + len(routes.closed), at
        assert not any(outcome.contacts for outcome in outcomes), at


@pytest.mark.parametrize("back", [False, True])
def test_the_closed_cells_are_those_in_which_a_robot_would_be_too_near(back: bool) -> None:
    """The robot fails while it speeds up, drives, brakes or turns back."""
    layout, apart = Layout(["." * 4]), 2 * FAST.radius
    cols = [0, 1, 2, 1, 0] if back else [0, 1, 2, 3]
    for at in np.arange(1, 60 + 30 * back, 4) / 30:
        motion = DrivingMotion(FAST)
        motion.reset(layout, [(0, 0)], 0)
        for col in cols[1:]:
            motion.extend([(0, col)])
        motion.drive(at)
        motion.fail(0)
        x = motion.drive(1.2)[0].path[-1, 1]
        closed = {col for _, col in motion.routes().closed}
        assert {col for col in range(4) if abs(x - col - 0.5) < apart + 0.01} <= closed
        assert closed <= {col for col in range(4) if abs(x - col - 0.5) < apart + 0.032}


@pytest.mark.parametrize("at", [0.35, 0.7, 2.25, 2.7])
def test_a_failure_in_a_ring_without_room_stops_all_robots(at: float) -> None:
    """A robot that fails between two cells leaves too few cells, so the others stop anywhere."""
    ring = [(0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (2, 1), (2, 0), (1, 0)]
    plan = [[ring[(robot + step) % 8] for robot in range(8)] for step in range(4)]
    crowd = Failures(Layout(["...", ".#.", "..."]), plan, FAST, [False] * 8)
    crowd.drive(at)
    crowd.motion.fail(0)
    crowd.come_to_rest()
    crowd.check()
    failed = crowd.motion.routes().failed
    assert sum(failed) == (8 if len(crowd.motion.routes().closed) > 1 else 1)


def test_no_route_is_extended_for_a_robot_that_has_failed_or_into_its_cell() -> None:
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
    assert motion.routes().ends == [(0, 0), (0, 2), (0, 4)]
