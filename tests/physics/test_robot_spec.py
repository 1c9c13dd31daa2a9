"""Every number of a robot is checked before the physics engine uses it."""

import pytest

from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import BackendError, WarehouseEnv, record_episode, replay_episode
from warehouse_core.motion.backends import make_motion
from warehouse_core.motion.grid import GRAVITY
from warehouse_physics import RobotSpec

TOO_SLOW = r"^the loaded robot would need .* s to turn .*, motor_force .*; allowed: at most 60 s$"


def test_a_differential_drive_has_a_track_and_no_turn_seconds() -> None:
    with pytest.raises(ValueError, match=r"^drive is 'tank'; allowed: omnidirectional, diff"):
        RobotSpec(drive="tank")
    assert RobotSpec(turn_seconds=1.5, drive="omnidirectional").turn_substeps(1) == 90
    with pytest.raises(ValueError, match=r"^turn_seconds is 1\.5; it must be 0 with drive 'diff"):
        RobotSpec(turn_seconds=1.5, drive="differential")
    narrow, wide = (RobotSpec(drive="differential", track=track) for track in (0.3, 1.0))
    # A wheel of the narrow robot drives a shorter distance, but has a much larger mass to turn.
    assert narrow.turn_substeps(2) > wide.turn_substeps(2) > 0
    for track in (0.09, 1.01):
        with pytest.raises(
            ValueError, match=r"^track is .*; it must be at least 0\.1 and at most 1"
        ):
            RobotSpec(track=track)
    with pytest.raises(ValueError, match=TOO_SLOW):
        RobotSpec(drive="differential", track=0.1, motor_force=10.4)


@pytest.mark.parametrize("radius", [0.4995, 2.0])
def test_a_robot_that_does_not_fit_its_cell_raises(radius: float) -> None:
    with pytest.raises(
        ValueError, match=r"^radius is .*; with cell_size 1\.0 it must be at most 0\.499"
    ):
        RobotSpec(radius=radius)
    assert RobotSpec(radius=radius, cell_size=2.1 * radius).radius == radius


@pytest.mark.parametrize("time_step", [1 / 60, 0.01])
def test_no_robot_moves_further_than_half_its_radius_in_a_substep(time_step: float) -> None:
    most = 0.35 / 2 / time_step
    assert RobotSpec(top_speed=most, time_step=time_step).top_speed == most
    with pytest.raises(ValueError, match=rf"^top_speed is .* must be at most {most!r}$"):
        RobotSpec(top_speed=most * 1.0001, time_step=time_step)


def test_a_motor_too_weak_for_the_loaded_robot_raises() -> None:
    drag = 0.015 * 70 * GRAVITY
    assert RobotSpec().drag_force(loaded=True) == pytest.approx(drag)
    assert RobotSpec(motor_force=2 * drag)
    with pytest.raises(ValueError, match=r"^motor_force is .*; to move the loaded robot it must"):
        RobotSpec(motor_force=0.99 * drag)


@pytest.mark.parametrize("changes", [{"top_speed": 0.01}, {"turn_seconds": 30}])
def test_a_move_that_takes_more_than_a_minute_raises(changes: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=TOO_SLOW):
        RobotSpec(**changes)


def test_the_time_step_does_not_limit_how_long_a_move_may_take() -> None:
    assert RobotSpec(drive="differential", time_step=1 / 480).turn_substeps(1) > 500
    assert RobotSpec(time_step=1e-5)
    with pytest.raises(ValueError, match=r"^time_step is 9e-06; it must be at least 1e-05"):
        RobotSpec(time_step=9e-6)


def test_only_robots_that_are_fast_for_their_size_have_shorter_substeps() -> None:
    for spec in (RobotSpec(), RobotSpec.fast(), RobotSpec(top_speed=2)):
        assert spec.refined() is spec
    small = RobotSpec(radius=0.05, acceleration=0.5, motor_force=50)
    # On the way to the wall it reaches sqrt(2 * 0.5 * 0.452) = 0.67 m/s, or 11 mm in 1/60 s.
    assert small.refined().time_step == pytest.approx(1 / 300)
    assert small.refined().refined() == small.refined()
    assert RobotSpec().refined(1.3).time_step == pytest.approx(1 / 120)


def test_a_load_adds_mass_and_drag_and_lowers_the_acceleration() -> None:
    spec = RobotSpec(mass=40, payload_mass=40, motor_force=60, floor_drag=0.02)
    assert (spec.total_mass(loaded=False), spec.total_mass(loaded=True)) == (40, 80)
    assert spec.drag_force(loaded=True) == 2 * spec.drag_force(loaded=False)
    assert spec.attainable_acceleration(loaded=False) == 1.0
    # 60 N minus the drag accelerate 80 kg.
    expected = (60 - 0.02 * 80 * GRAVITY) / 80
    assert spec.attainable_acceleration(loaded=True) == pytest.approx(expected)


def test_a_strong_motor_needs_at_least_a_substep_to_reach_top_speed() -> None:
    spec = RobotSpec(acceleration=1e4, motor_force=1e7)
    assert spec.attainable_acceleration(loaded=True) == 1.0 / (1 / 60)


@pytest.mark.parametrize("name", ["physics", "driving"])
def test_the_name_of_a_backend_may_give_numbers_of_the_robot(name: str) -> None:
    motion = make_motion(f"{name}:top_speed=2,turn_seconds=1.5")
    assert motion.spec == RobotSpec(top_speed=2, turn_seconds=1.5)
    assert make_motion(f"{name}:drive=differential,mass=40").spec.is_differential
    with pytest.raises(BackendError, match=r": drive is '2'; allowed: omnidirectional, diff"):
        make_motion(f"{name}:drive=2")
    with pytest.raises(BackendError, match=r": 'mass=heavy' is not of the form name=1\.5"):
        make_motion(f"{name}:mass=heavy")
    with pytest.raises(BackendError, match=r": no number is called 'tempo'; allowed: radius, mass"):
        make_motion(f"{name}:tempo=2")
    with pytest.raises(BackendError, match=r": top_speed is 99\.0; .* must be at most 10\.5"):
        make_motion(f"{name}:top_speed=99")


def test_a_record_of_a_robot_with_other_numbers_is_replayed() -> None:
    env = WarehouseEnv(max_steps=20, backend="physics:turn_seconds=0.5,mass=40")
    episode = record_episode(env, GreedyAgent(), seed=3)
    assert episode.settings.backend == "physics:turn_seconds=0.5,mass=40"
    assert replay_episode(episode) == episode
    assert replay_episode(episode, "physics").seconds < episode.seconds
