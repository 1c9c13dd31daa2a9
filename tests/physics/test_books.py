"""Joules and impulses, compared with an independent account of every substep."""

from dataclasses import replace

import pytest
from helpers.physics_truth import Book, errors_of_the_books, random_robots_move_as_the_grid
from helpers.rigid_bodies import EAST, NORTH, SOUTH, WEST, motion_in, move, together

from warehouse_core import Layout
from warehouse_physics import RobotSpec, stepping

BOOKED_MOVES = 60
COMPARED_MOVES = 300
"""The benchmarks make more moves."""

EXACT = 1e-6
"""Relative error, since the speed across the path that the solver leaves is not counted."""

SPECS = {
    "default": RobotSpec(),
    "brisk": RobotSpec(acceleration=4, motor_force=400),
    "weak": RobotSpec(motor_force=15, payload_mass=0),
    "wide": RobotSpec(radius=0.45, acceleration=2, motor_force=200),
    "dragged": RobotSpec(floor_drag=0.2, motor_force=170),
}
over_specs = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS.keys())


@pytest.fixture(autouse=True)
def public_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make each substep call ``space.step``, which the account replaces."""
    monkeypatch.setattr(stepping, "IS_KNOWN", False)


@over_specs
def test_the_joules_that_braking_gives_back_are_those_of_the_book(spec: RobotSpec) -> None:
    giving = replace(spec, recuperation=0.7)
    motions = [motion_in(Layout([".."] * 2), (0, 0), each) for each in (spec, giving)]
    book = Book(motions[1])
    for displacement in (EAST, EAST, NORTH, SOUTH, WEST):
        book.clear()
        plain, outcome = (move(motion, displacement, loaded=True) for motion in motions)
        joules = book.work[0] / spec.drivetrain_efficiency + spec.idle_power * outcome.seconds
        assert outcome.joules == pytest.approx(joules, rel=1e-3)
        # If the floor does nearly all of the braking, no energy is recovered.
        is_braking = spec.attainable_acceleration(loaded=True) > 2 * spec.floor_deceleration
        assert (outcome.joules < plain.joules * 0.99) == is_braking


def test_no_push_by_another_robot_makes_an_action_cost_less_than_nothing() -> None:
    spec = RobotSpec(recuperation=1.0, idle_power=0.0)
    outcomes = together(Layout(["..."]), [(0, 0), (0, 1)], [EAST, (0, 0)], spec)
    assert outcomes[1].contacts
    assert outcomes[1].joules == 0.0 < outcomes[0].joules


@pytest.mark.parametrize("robots", [1, 6])
def test_random_robots_keep_both_books(robots: int) -> None:
    errors = errors_of_the_books(BOOKED_MOVES, robots)
    assert max(errors.joules) < (0.01 if robots > 1 else EXACT)
    if robots > 1:
        assert len(errors.impulses) > BOOKED_MOVES / 10
        assert max(errors.impulses) < 0.01


def test_robots_that_keep_pushing_one_another_keep_both_books() -> None:
    """In the sixth action two robots touch for seconds, and one pushes the other."""
    assert max(errors_of_the_books(80, 8, seed=1046).joules) < 0.01


def test_random_robots_move_as_on_the_grid_alone_and_in_a_batch() -> None:
    assert random_robots_move_as_the_grid(COMPARED_MOVES)[1] > 0
