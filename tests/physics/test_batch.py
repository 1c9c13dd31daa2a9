"""Many warehouses in one space: each row equals a single motion."""

import math
import random

import numpy as np
import pytest
from helpers.rigid_bodies import Singles, batch_in, rows_differ, some_layouts

from warehouse_core import Layout, LayoutError
from warehouse_core.motion.base import BatchOutcome
from warehouse_physics import Disturbances, RigidBodyMotion, RobotSpec
from warehouse_physics.arena import Hit
from warehouse_physics.batch import rigid_body_batch
from warehouse_physics.batch import robots as batch_robots
from warehouse_physics.batch.rigid_body_batch import RigidBodyBatch

NORTH, EAST, SOUTH, WEST, WAIT = range(5)

HALL = Layout(["....."] * 4)
LEDGE = Layout(["."])
"""One cell, so that every move ends at a wall."""
CORRIDOR = Layout(["..........."])

SPECS = {
    "fast": RobotSpec.fast(),
    "small cells": RobotSpec(cell_size=0.5, radius=0.17, acceleration=2.0, motor_force=200.0),
    "tight": RobotSpec(radius=0.499),
    "wide": RobotSpec(radius=0.45),
    "exact": RobotSpec(acceleration=4.0, motor_force=400.0),
    "exact and small": RobotSpec(
        cell_size=0.5, radius=0.2, top_speed=3.0, acceleration=4.0, motor_force=400.0
    ),
    "dragged": RobotSpec(floor_drag=0.05, acceleration=0.45),
    "turning": RobotSpec(turn_seconds=0.31),
    "wheeled": RobotSpec(drive="differential", track=0.9, recuperation=0.5),
    "regaining": RobotSpec(recuperation=0.7, radius=0.499),
    "violent": RobotSpec(top_speed=10.5, acceleration=1e6, motor_force=1e9),
}
"""Robots of many kinds. One barely fits its cell, and two reach a wall exactly at the end of a
substep, because their numbers are round. The floor brakes one harder than its motor does, and one
hits walls as hard as possible."""

over_specs = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS.keys())


def advance(batch: RigidBodyBatch, *actions: int, loaded: bool = False) -> BatchOutcome:
    return batch.advance(np.array(actions), np.full(len(actions), loaded))


# Each row equals a single motion.


@over_specs
def test_each_row_equals_a_single_motion(spec: RobotSpec) -> None:
    blocked = rows_differ(spec, rows=8, steps=20)
    assert blocked > 8 * 20 / 8, "too few hits to compare"


def test_rows_in_several_spaces_have_the_bits_of_one_space(monkeypatch) -> None:
    stream = random.Random(6)
    layouts = some_layouts(11, stream)
    generator = np.random.default_rng(6)
    moves = [(generator.integers(0, 8, 11), generator.random(11) < 0.5) for _ in range(30)]
    outcomes = []
    for rows in (256, 4):
        monkeypatch.setattr(rigid_body_batch, "ROWS_OF_A_SPACE", rows)
        batch = batch_in(layouts)
        assert len(batch._parts) == math.ceil(11 / rows)
        each = [batch.advance(*move) for move in moves[:15]]
        batch.place(np.array([9, 3]), np.array([layouts[row].open_cells[-1] for row in (9, 3)]))
        each += [batch.advance(*move) for move in moves[15:]]
        outcomes.append([column.tobytes() for outcome in each for column in outcome[:4]])
    assert outcomes[0] == outcomes[1]


def test_an_action_that_takes_too_long_ends_and_the_robot_stops(monkeypatch) -> None:
    monkeypatch.setattr(batch_robots, "MAX_SECONDS", 0.5)
    batch = batch_in([CORRIDOR, LEDGE])
    arena = batch._parts[0].arena
    # The action ends with the first event after MAX_SECONDS, the hit of the second robot.
    assert advance(batch, EAST, EAST).seconds == pytest.approx([34 / 60] * 2)
    assert arena.look()[1][0, 0] > 0.5
    advance(batch, WAIT, EAST)
    assert np.abs(arena.look()[1][0]).max() < 1e-9


def test_a_robot_at_rest_ignores_contacts_while_others_drive() -> None:
    batch = batch_in([LEDGE, HALL])
    batch._parts[0].arena.bodies[0].position += (0.2, 0.0)
    outcome = advance(batch, WAIT, EAST)
    assert (outcome.blocked[0], outcome.seconds[0]) == (False, RobotSpec().dwell)
    batch._parts[0]._meet([Hit(1, None, (-1.0, 0.0), (0.0, 0.0))], 200)
    assert not batch._parts[0].gave_up[1]


# Invalid calls.


def test_only_a_nominal_motion_can_be_batched() -> None:
    disturbed = RigidBodyMotion(disturbances=Disturbances(motor_strength=0.5))
    with pytest.raises(
        ValueError, match=r"motor_strength=0\.5.*cannot be batched.*does not support disturbances"
    ):
        disturbed.batch([HALL])


def test_an_empty_batch_raises() -> None:
    with pytest.raises(ValueError, match="at least one layout"):
        RigidBodyMotion().batch([])


@pytest.mark.parametrize(
    ("rows", "cells", "error", "message"),
    [
        ([0, 2], [0, 0], ValueError, r"rows\[1\] is 2; allowed: 0\.\.1"),
        ([-1], [0], ValueError, r"rows\[0\] is -1; allowed: 0\.\.1"),
        ([1, 0, 1], [0, 0, 0], ValueError, r"rows are \[1, 0, 1\]; each row may be given once"),
        ([0, 1], [0], ValueError, r"cells have the shape \(1,\); it must be \(2,\)"),
        ([0.0], [0], ValueError, "rows are float64; they must be integers"),
        ([0], [math.nan], ValueError, "cells are float64; they must be integers"),
        ([0, 1], [1, 2], LayoutError, "the robot of row 1: row 0, column 2 is wall"),
        ([0, 1], [1, 3], LayoutError, "the robot of row 1: row 1, column 0 is off the"),
    ],
)
def test_invalid_places_raise_and_change_nothing(rows, cells, error, message) -> None:
    batch = batch_in([HALL, Layout(["..#"])])
    with pytest.raises(error, match=message):
        batch.place(np.array(rows), np.array(cells))
    assert advance(batch, WAIT, WAIT).cells.tolist() == [0, 0]


@pytest.mark.parametrize(
    ("actions", "loaded", "message"),
    [
        ([EAST], [False], r"actions have the shape \(1,\); it must be \(2,\)"),
        ([EAST, 8], [False, False], r"actions\[1\] is 8; allowed: 0\.\.7"),
        ([EAST, -1], [False, False], r"actions\[1\] is -1; allowed: 0\.\.7"),
        ([EAST, math.inf], [False, False], "actions are float64; they must be integers"),
        ([EAST, EAST], [False], r"loaded have the shape \(1,\); it must be \(2,\)"),
        ([EAST, EAST], [0, 2], "loaded are int64; they must be bool"),
    ],
)
def test_invalid_actions_raise_and_change_nothing(actions, loaded, message) -> None:
    batch = batch_in([HALL, HALL])
    with pytest.raises(ValueError, match=message):
        batch.advance(np.array(actions), np.array(loaded))
    assert advance(batch, WAIT, WAIT).cells.tolist() == [0, 0]


def test_after_a_change_the_walls_are_those_of_the_new_layout() -> None:
    walled = Layout([".#...", *HALL.rows[1:]])
    batch = batch_in([walled, HALL])
    assert advance(batch, EAST, EAST).blocked.tolist() == [True, False]
    batch.change(np.array([0, 1]), [HALL, walled])
    with pytest.raises(RuntimeError, match="row 0 had none"):
        advance(batch, EAST, EAST)
    batch.place(np.array([1, 0]), np.array([0, 0]))
    assert advance(batch, EAST, EAST).blocked.tolist() == [False, True]


@pytest.mark.parametrize(
    ("floors", "layouts", "error", "message"),
    [
        ([0, 1], [HALL, LEDGE], LayoutError, r"floor 1 is 1 x 1; .* the one before, 4 x 5"),
        ([0, 1], [HALL], ValueError, "shorter"),
        ([2], [HALL], ValueError, r"rows\[0\] is 2; allowed: 0\.\.1"),
        ([1, 1], [HALL, HALL], ValueError, "given once"),
    ],
)
def test_invalid_changes_raise_and_change_nothing(floors, layouts, error, message) -> None:
    batch = batch_in([HALL, HALL])
    with pytest.raises(error, match=message):
        batch.change(np.array(floors), layouts)
    assert advance(batch, EAST, EAST).cells.tolist() == [1, 1]


# Parts of a batch.


def test_a_robot_with_weak_brakes_equals_a_single_motion() -> None:
    spec = RobotSpec(floor_drag=0.0)
    batch, singles = batch_in([HALL], spec), Singles(spec, [HALL])
    singles.place(0, 0)
    batch._parts[0]._braking_forces *= 0.6
    robot = singles.motions[0]._arena.robots[0]
    drive = robot.drive

    def drive_with_weak_brakes(*arguments) -> None:
        drive(*arguments)
        robot._braking_force *= 0.6

    robot.drive = drive_with_weak_brakes
    for action in (EAST, SOUTH, EAST, EAST):
        outcome, expected = advance(batch, action), singles.advance([action], [False])
        assert outcome.cells.tolist() == expected.cells.tolist()
        assert outcome.seconds == pytest.approx(expected.seconds)
        assert outcome.seconds[0] > 2.5, "the plan would take two seconds"
