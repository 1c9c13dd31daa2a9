"""The law of drives: limits, drag, energy, and independence of the time step."""

from itertools import pairwise

import numpy as np
import pytest
from helpers.drive_rows import rows_on

from warehouse_physics import Disturbances, RobotSpec
from warehouse_physics.drive.drives import drive_of, rolling

WHEELS = RobotSpec(drive="differential")
KINDS = [
    (RobotSpec(), "velocity"),
    (RobotSpec(), "force"),
    (WHEELS, "velocity"),
    (WHEELS, "wheels"),
    (WHEELS, "force"),
]
each_kind = pytest.mark.parametrize(
    ("spec", "control"), KINDS, ids=lambda x: getattr(x, "drive", x)
)


def held(count, length, rows=1, seed=1):
    """Return random actions, each of which is held for ``length`` steps."""
    actions = np.random.default_rng(seed).uniform(-1, 1, (count, rows, 2))
    return np.repeat(actions, length, axis=0)


@each_kind
def test_a_path_of_half_a_minute_hardly_depends_on_the_time_step(spec, control):
    coarse, fine = rows_on(spec=spec, control=control), rows_on(spec=spec, control=control, finer=2)
    off = 0.0
    for action in held(60, 5):
        coarse.step(action)
        fine.step(action)
        off = max(off, float(np.hypot(*(coarse.state.positions - fine.state.positions)[0])))
    assert 0 < off < 0.02 * spec.cell_size


@each_kind
def test_no_robot_is_faster_or_stronger_than_its_spec(spec, control):
    rows, drive = rows_on(spec=spec, control=control, rows=20), drive_of(spec, control, 20)
    before = drive.speeds(rows.state)
    for action in held(20, 10, 20, seed=2) * 3:
        step = rows.step(np.clip(action, -1, 1), is_traced=True)
        speeds = drive.speeds(rows.state)
        assert np.abs(speeds).max() <= spec.top_speed + 1e-9
        if control != "force":
            assert np.abs(speeds - before).max() <= spec.acceleration * 0.1 + 1e-9
        forces = np.array([motors for _, motors, _ in step.trace])
        assert np.hypot(*forces.reshape(-1, 2).T).max() <= spec.motor_force + 1e-9
        before = speeds


def work_of_motion(spec, dt, states, drag):
    """Return the work that a drive must have done, from how a body has moved and nothing else.

    The impulse on a body is its mass times the change of its velocity. The motor has given this
    impulse, and the impulse that the drag took.
    """
    drive = drive_of(spec, "velocity", len(states[0].angles))
    work = 0.0
    for before, after in pairwise(states):
        old, new = drive.speeds(before), drive.speeds(after)
        if spec.is_differential:
            gain = (new - old).sum(axis=0) / 2 * spec.mass / dt
            spin = (after.turn_rates - before.turn_rates) * spec.mass * spec.radius**2 / 2 / dt
            wheels = np.stack([gain + spin / spec.wheel_arm, gain - spin / spec.wheel_arm])
            motors = wheels / 2 + drag / 2 * np.sign(old + new)
            done = motors * (old + new) / 2 * dt
        else:
            mean = (old + new) / 2
            speed = np.hypot(*mean)
            motors = spec.mass * (new - old) / dt + drag * mean / np.maximum(speed, 1e-12)
            done = (motors * mean).sum(axis=0) * dt
        work += np.where(done > 0, done, done * spec.recuperation * spec.drivetrain_efficiency)
    return work


@pytest.mark.parametrize("recuperation", [0.0, 0.6])
@pytest.mark.parametrize("drive", ["omnidirectional", "differential"])
def test_the_energy_is_the_integral_of_the_impulses(drive, recuperation):
    spec = RobotSpec(drive=drive, recuperation=recuperation)
    rows = rows_on(spec=spec, rows=100)
    used, work = np.zeros(100), 0.0
    for action in held(50, 2, 100, seed=3):  # 10,000 random actions
        start = rows.state
        step = rows.step(action, is_traced=True)
        used += step.joules
        states = [start, *(state for state, _, _ in step.trace)]
        part = work_of_motion(spec, rows.settings.spec.time_step, states, spec.drag_force(False))
        work = work + (part.sum(axis=0) if part.ndim == 2 else part)
    seconds = 100 * 0.1
    expected = work / spec.drivetrain_efficiency + spec.idle_power * seconds
    assert np.abs(used / expected - 1).max() < 1e-3
    assert (work > 10).all()


def test_drag_stops_what_rolls_and_pushes_nothing_back():
    mass, drag = np.array([100.0]), np.array([5.0])

    def after(speed, motor):
        force = rolling(np.array([speed]), np.array([motor]), mass, drag)
        return float(speed + (motor - force[0]) / mass[0])

    assert after(1.0, 0.0) == 0.95
    assert after(0.01, 0.0) == 0.0  # it stops within the substep
    assert after(-0.01, 0.0) == 0.0
    assert after(0.0, 4.0) == 0.0  # the motor is too weak
    assert after(0.0, 15.0) == pytest.approx(0.1)
    assert after(0.1, -15.0) == pytest.approx(-0.05)  # half of the substep in each direction
    assert after(0.0, 0.0) == 0.0


@pytest.mark.parametrize("drive", ["omnidirectional", "differential"])
def test_a_motor_that_is_weaker_than_the_drag_moves_nothing(drive):
    rows = rows_on(spec=RobotSpec(drive=drive), disturbances=Disturbances(motor_strength=0.1))
    for _ in range(20):
        rows.step(np.array([[1.0, 0.3]]))
    assert rows.state.positions.tolist() == [[30.5, 30.5]]


def test_a_robot_on_a_curve_loses_no_speed_and_keeps_its_radius():
    rows = rows_on(spec=WHEELS)
    for _ in range(100):
        rows.step(np.array([[0.5, 0.1]]))
    speed, turn_rate = 0.5, 0.1 * WHEELS.top_speed / WHEELS.wheel_arm
    assert np.hypot(*rows.state.velocities[0]) == pytest.approx(speed, abs=1e-9)
    assert rows.state.turn_rates[0] == pytest.approx(turn_rate, abs=1e-9)


def test_wheels_that_are_asked_for_too_much_keep_the_curve():
    for control in ("velocity", "wheels", "force"):
        command = drive_of(WHEELS, control, 1).command(np.array([[1.0, 1.0]]))
        most = WHEELS.motor_force / 2 if control == "force" else WHEELS.top_speed
        expected = [most, most] if control == "wheels" else [most, 0.0]
        assert command.T.tolist() == [expected]
    command = drive_of(RobotSpec(), "velocity", 1).command(np.array([[1.0, 1.0]]))
    assert np.hypot(*command) == pytest.approx(1.0)


def test_tyres_slide_on_ice_and_hold_elsewhere():
    icy = rows_on(spec=WHEELS, disturbances=Disturbances(slippery="all", grip=0.05))
    dry = rows_on(spec=WHEELS)
    for rows in (icy, dry):
        for action in [[1.0, 0.0]] * 30 + [[1.0, 0.5]] * 10:
            rows.step(np.array([action]))

    def slide(rows):
        angle = rows.state.angles[0] + rows.state.turn_rates[0] * rows.settings.spec.time_step / 2
        right, down = rows.state.velocities[0]
        return abs(down * np.cos(angle) - right * np.sin(angle))

    assert slide(icy) > 0.1
    assert slide(dry) < 1e-9


def test_a_control_that_a_robot_does_not_have_is_refused():
    with pytest.raises(ValueError, match=r"control is 'wheels'; a robot with drive 'omnidirect"):
        drive_of(RobotSpec(), "wheels", 1)
    with pytest.raises(ValueError, match="control is 'speed'"):
        drive_of(RobotSpec(), "speed", 1)
