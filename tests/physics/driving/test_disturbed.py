"""Robots that drive through keep their distances despite disturbances, and none waits forever."""

import math

import numpy as np
import pytest

from warehouse_core import Cell, Layout
from warehouse_core.motion.base import Contact
from warehouse_physics import Disturbances, DrivingMotion, RigidBodyMotion, Stop
from warehouse_physics.disturbances import FloorConditions


def test_stops_are_a_sequence_of_stops_for_robots_that_drive_through() -> None:
    stop = Stop(0, 1.0, math.inf)
    assert Disturbances(stops=[stop]) == Disturbances(stops=(stop,))  # type: ignore[arg-type]
    assert Disturbances(stops=(stop,)).any
    for wrong in (stop, [(0, 1.0, 2.0)]):
        with pytest.raises(ValueError, match="a sequence of Stop"):
            Disturbances(stops=wrong)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="only DrivingMotion supports stops"):
        RigidBodyMotion(disturbances=Disturbances(stops=(stop,)))


HALL = Layout(["....."] * 5)
RING = [(1, 1), (1, 2), (2, 2), (2, 1)]
EAST, STAY = (0, 1), (0, 0)


def drive(motion: DrivingMotion, moves: list[list[Cell]], seconds: int) -> list[Contact]:
    """Carry out moves, then wait until all robots are at rest, and return the hits."""
    count = len(motion.routes().ends)
    hits: list[Contact] = []
    for step in range(seconds):
        if step >= len(moves) and all(motion.routes().at_rest):
            break
        move = moves[step] if step < len(moves) else [STAY] * count
        for outcome in motion.advance(move, [robot % 2 == 0 for robot in range(count)]):
            hits += outcome.contacts
    return hits


def ring(step: int) -> list[Cell]:
    """Return the moves with which all four robots of a ring move on."""
    cells = [RING[(robot + step) % 4] for robot in range(4)]
    nexts = [RING[(robot + step + 1) % 4] for robot in range(4)]
    return [(to[0] - at[0], to[1] - at[1]) for at, to in zip(cells, nexts, strict=True)]


@pytest.mark.parametrize(
    "disturbances",
    [
        Disturbances(actuation_noise=0.1),
        Disturbances(drag_spread=0.9),
        Disturbances(motor_strength=0.5),
        Disturbances(slippery=frozenset({(1, 1), (2, 2)})),
    ],
)
def test_a_ring_of_disturbed_robots_turns_without_a_hit(disturbances: Disturbances) -> None:
    motion = DrivingMotion(disturbances=disturbances)
    motion.reset(HALL, RING, 0)
    assert not drive(motion, [ring(0), ring(1)], 25)
    assert all(motion.routes().at_rest)
    assert motion.routes().ends == RING[2:] + RING[:2]


def test_robots_drive_at_a_random_share_of_their_speed_in_each_cell() -> None:
    motion = DrivingMotion(disturbances=Disturbances(actuation_noise=0.05))
    motion.reset(Layout(["." * 60]), [(0, 0)], 3)
    paths = [motion.advance([EAST], [False])[0].path for _ in range(50)]
    speeds = [(path[-1, 1] - path[-2, 1]) / (path[-1, 0] - path[-2, 0]) for path in paths[3:]]
    assert 0.02 < float(np.std(speeds)) < 0.08


def test_a_robot_that_overshoots_its_end_drives_back_to_it(monkeypatch: pytest.MonkeyPatch) -> None:
    factors = iter([1.0, 1.0, 1.0, 1.25])
    monkeypatch.setattr(FloorConditions, "speed_factor", lambda _: next(factors, 1.25))
    motion = DrivingMotion(disturbances=Disturbances(actuation_noise=0.05), path_every=1)
    motion.reset(HALL, [(0, 0)], 0)
    for col in range(1, 4):
        motion.extend([(0, col)])
    beyond = motion.drive(12.0)[0].path[:, 1] - 3.5
    assert 0.01 < beyond.max() < 0.1
    assert abs(beyond[beyond.argmax() :].min()) < 0.01
    assert motion.routes().at_rest == [True]


def test_a_robot_that_stops_stays_for_its_time_and_drives_on() -> None:
    motion = DrivingMotion(disturbances=Disturbances(stops=(Stop(0, 2.0, 10.0),)))
    motion.reset(HALL, [(0, 1), (0, 0)], 0)
    assert not drive(motion, [[EAST, EAST]] * 3, 8)
    routes = motion.routes()
    assert (routes.has_room[0], routes.at_rest[0], routes.failed[0]) == (False, False, False)
    assert not drive(motion, [], 10)
    assert motion.routes().at_rest == [True, True]


@pytest.mark.parametrize("slippery", [frozenset(), frozenset({(0, 1), (0, 2)})])
def test_robots_behind_one_that_has_failed_go_back_to_cells_of_their_own(slippery) -> None:
    for at in (1.7, 2.2):
        stops = (Stop(0, at, math.inf),)
        motion = DrivingMotion(disturbances=Disturbances(slippery=slippery, stops=stops))
        motion.reset(Layout(["........"] * 2), [(0, 2), (0, 1), (0, 0)], 0)
        assert not drive(motion, [[EAST] * 3] * 4, 20)
        routes = motion.routes()
        assert routes.failed == [True, False, False]
        assert routes.at_rest == [False, True, True]
        assert len(set(routes.ends)) == 3
        assert not set(routes.ends[1:]) & set(routes.closed)


def test_a_robot_on_ice_brakes_for_one_that_waits_in_front_of_it() -> None:
    """The floor of its first cell counts: otherwise the robot could not stop in time."""
    disturbances = Disturbances(slippery=frozenset({(0, 3)}), grip=0.05, stops=(Stop(0, 0, 20.0),))
    motion = DrivingMotion(disturbances=disturbances)
    motion.reset(Layout(["....."]), [(0, 1), (0, 2), (0, 3)], 0)
    motion.extend([(0, 0), (0, 1), (0, 2)])
    assert not any(outcome.contacts for outcome in motion.drive(60.0))
    assert motion.routes().at_rest == [True, True, True]


def test_the_cells_of_a_robot_that_has_failed_are_closed() -> None:
    motion = DrivingMotion()
    motion.reset(HALL, [(0, 1), (0, 0)], 0)
    motion.fail(0)
    outcome = motion.advance([STAY, EAST], [False, False])[1]
    assert outcome.blocked
    assert motion.routes().closed == [(0, 1)]
    assert motion.routes().ends == [(0, 1), (0, 0)]


def test_a_stop_of_a_robot_that_does_not_exist_is_refused() -> None:
    motion = DrivingMotion(disturbances=Disturbances(stops=(Stop(1, 0.0, 1.0),)))
    with pytest.raises(ValueError, match="must be at most 0"):
        motion.reset(HALL, [(0, 0)], 0)
