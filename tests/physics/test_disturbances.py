"""Disturbances are off by default, follow from the seed, and are reported correctly."""

import math
import random
from itertools import combinations
from typing import Any

import pytest

from warehouse_core import Cell, Layout, Outcome, WarehouseEnv
from warehouse_core.errors import BackendError
from warehouse_core.motion import make_motion
from warehouse_physics import Disturbances, RigidBodyMotion, RobotSpec
from warehouse_physics.disturbances import FloorConditions

HALL = Layout(["......."] * 7)
ALL_CELLS = frozenset((row, col) for row in range(7) for col in range(7))
STAY, NORTH, EAST, SOUTH, WEST = STEPS = ((0, 0), (-1, 0), (0, 1), (1, 0), (0, -1))

KINDS = {
    "noise": Disturbances(actuation_noise=0.2),
    "ice": Disturbances(slippery=frozenset({(3, 3), (3, 4), (2, 2)})),
    "weak motor": Disturbances(motor_strength=0.4),
    "drag": Disturbances(drag_spread=0.9),
}
over_kinds = pytest.mark.parametrize("disturbances", KINDS.values(), ids=KINDS.keys())


def motion_with(
    disturbances: Disturbances | None, seed: int = 0, cell: Cell = (3, 3)
) -> RigidBodyMotion:
    motion = RigidBodyMotion(disturbances=disturbances)
    motion.reset(HALL, [cell], seed)
    return motion


def wander(motion: RigidBodyMotion, moves: int = 30) -> list[Outcome]:
    """Move at random, with an item in half of the moves."""
    stream = random.Random(0)
    return [
        motion.advance([stream.choice(STEPS)], [stream.random() < 0.5])[0] for _ in range(moves)
    ]


def cell_at(outcome: Outcome) -> Cell:
    """Return the cell under the end of a path, for cells of 1 m."""
    return math.floor(outcome.path[-1, 2]), math.floor(outcome.path[-1, 1])


# Settings.


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ("noise=0.1,motor_strength=0.7", Disturbances(0.1, motor_strength=0.7)),
        ("drag_spread=0.5,patience=3", Disturbances(drag_spread=0.5, patience=3.0)),
        ("odometry=0.02", Disturbances(odometry=0.02)),
        ("slippery=4-5+10-6", Disturbances(slippery=frozenset({(4, 5), (10, 6)}))),
        ("slippery=all", Disturbances(slippery="all")),
        ("grip=0.2", Disturbances(slippery="all", grip=0.2)),
        ("grip=0.2,slippery=4-5", Disturbances(slippery=frozenset({(4, 5)}), grip=0.2)),
    ],
)
def test_disturbances_may_follow_the_name_of_a_backend(settings, expected) -> None:
    for name in ("physics", "driving"):
        motion = make_motion(f"{name}:mass=60,{settings}")
        assert motion.disturbances == expected  # type: ignore[attr-defined]
        assert motion.spec.mass == 60  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ("nois=1", "no number is called 'nois'; allowed: radius, .*, noise, grip, .*, slippery"),
        ("noise=1", "noise is 1.0; it must be at least 0 and at most 0.5"),
        ("grip=-1", "grip is -1.0; it must be at least 0 and at most 1"),
        ("slippery=4", "slippery is '4'; it must be all, or the row and column of cells, as in 4-"),
    ],
)
def test_a_wrong_disturbance_is_named_with_what_is_allowed(settings: str, message: str) -> None:
    with pytest.raises(BackendError, match=f"^backend 'physics:{settings}': {message}"):
        make_motion(f"physics:{settings}")


def test_a_floor_may_be_slippery_everywhere() -> None:
    everywhere = Disturbances(slippery="all")
    assert wander(motion_with(everywhere)) == wander(motion_with(Disturbances(slippery=ALL_CELLS)))
    env = WarehouseEnv(HALL, backend=RigidBodyMotion(disturbances=everywhere))
    assert frozenset(env.settings.slippery) == ALL_CELLS


@pytest.mark.parametrize("cells", [5, "icy", [(1, 2, 3)], [(1.5, 2)]])
def test_invalid_slippery_cells_raise(cells: Any) -> None:
    with pytest.raises(
        ValueError, match=r"^slippery is .*; it must be .all. or cells \(row, column\)$"
    ):
        Disturbances(slippery=cells)


# Off by default.


def test_disturbances_are_off_by_default() -> None:
    assert not Disturbances().any
    assert not Disturbances(grip=0.5, patience=5, slippery=[]).any
    assert all(disturbances.any and disturbances.is_felt for disturbances in KINDS.values())
    drifting = Disturbances(odometry=0.01)
    assert (drifting.any, drifting.is_felt) == (True, False)


def test_disturbances_of_nominal_size_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = wander(motion_with(None))
    monkeypatch.setattr(Disturbances, "is_felt", True)
    motion = motion_with(Disturbances(patience=100))
    assert motion._arena.robots[0]._conditions is not None
    assert wander(motion) == plain


# Seeded.


@pytest.mark.parametrize("kind", KINDS)
def test_the_outcomes_follow_from_the_seed(kind: str) -> None:
    motion = motion_with(KINDS[kind], 4)
    first = wander(motion)
    motion.reset(HALL, [(3, 3)], 4)
    assert wander(motion) == first
    is_random = kind in ("noise", "drag")
    assert (wander(motion_with(KINDS[kind], 5)) != first) == is_random


# Reports.


@over_kinds
def test_the_cell_is_under_the_body_and_only_hits_block(disturbances) -> None:
    for outcome in wander(motion_with(disturbances, 1)):
        assert outcome.cell == cell_at(outcome)
        assert outcome.contacts or not outcome.blocked
        assert outcome.seconds == pytest.approx(outcome.path[-1, 0])


def test_a_robot_that_brakes_on_ice_slides_past_its_target() -> None:
    ahead = Disturbances(slippery=frozenset({(3, col) for col in range(4, 7)}), grip=0.01)
    motion = motion_with(ahead)
    nominal = motion_with(None).advance([EAST], [False])[0]
    outcome = motion.advance([EAST], [False])[0]
    assert outcome.path[:, 1].max() > 4.5 + 0.05
    assert outcome.seconds > nominal.seconds
    assert not outcome.blocked
    assert outcome.cell == cell_at(outcome)


@pytest.mark.parametrize(("grip", "least", "most"), [(0.1, 4.49, 4.51), (0.02, 3.5, 4.0)])
def test_a_robot_with_less_grip_gets_less_far(grip: float, least: float, most: float) -> None:
    motion = motion_with(Disturbances(slippery=ALL_CELLS, grip=grip))
    outcome, another = (motion.advance([EAST], [False])[0] for _ in range(2))
    first, second = outcome.path[:, 1:3], another.path[:, 1:3]
    assert least < first[-1, 0] < most
    assert (outcome.cell, outcome.blocked, outcome.contacts) == (cell_at(outcome), False, ())
    assert second[0].tolist() == first[-1].tolist()
    assert second[-1, 0] > first[-1, 0] + 0.05


def test_the_drag_of_a_cell_depends_only_on_seed_and_cell() -> None:
    rough = Disturbances(drag_spread=0.5)
    floor, again = FloorConditions(rough, 7), FloorConditions(rough, 7)
    factors = [floor.drag_factor(cell) for cell in sorted(ALL_CELLS)]
    backwards = [again.drag_factor(cell) for cell in sorted(ALL_CELLS, reverse=True)]
    assert factors == backwards[::-1]
    assert all(0.5 <= factor <= 1.5 for factor in factors)
    assert len(set(factors)) == len(factors)
    assert factors != [FloorConditions(rough, 8).drag_factor(cell) for cell in sorted(ALL_CELLS)]


def test_disturbed_robots_are_at_rest_at_the_end_and_never_blocked_at_their_goal() -> None:
    """Robots that already touched before an action, and are pushed in it, are still braked."""
    goals = 0
    for seed in range(3):
        stream = random.Random(seed)
        slick = Disturbances(
            actuation_noise=0.3, slippery=stream.sample(sorted(ALL_CELLS), 20), drag_spread=0.9
        )
        motion = RigidBodyMotion(disturbances=slick)
        motion.reset(HALL, stream.sample(sorted(ALL_CELLS), 20), seed)
        for _ in range(6):
            moves = stream.choices(STEPS, k=20)
            homes = (
                [math.floor(robot.body.position.y) for robot in motion._arena.robots],
                [math.floor(robot.body.position.x) for robot in motion._arena.robots],
            )
            outcomes = motion.advance(moves, [False] * 20)
            for robot, outcome in enumerate(outcomes):
                assert motion._arena.robots[robot].body.velocity.length < 1e-5
                down, right = moves[robot]
                goal = homes[0][robot] + down, homes[1][robot] + right
                assert not (outcome.blocked and outcome.cell == goal)
                goals += outcome.cell == goal
    assert goals > 3 * 6 * 20 / 4


# Stalls.


@pytest.mark.parametrize("strength", [0.0, 0.1])
def test_a_motor_too_weak_for_the_floor_stalls(strength: float) -> None:
    outcome = motion_with(Disturbances(motor_strength=strength)).advance([EAST], [False])[0]
    assert (outcome.cell, outcome.blocked, outcome.contacts) == ((3, 3), False, ())
    assert outcome.path[-1, 1:3] == pytest.approx((3.5, 3.5), abs=0.01)
    nominal = motion_with(None).advance([EAST], [False])[0]
    assert outcome.seconds == pytest.approx(2 * nominal.seconds, rel=0.6)
    assert outcome.joules == pytest.approx(RobotSpec().idle_power * outcome.seconds)


@over_kinds
def test_a_disturbed_fleet_is_reported_correctly(disturbances: Disturbances) -> None:
    """Robots that end off the middle may be in the same cell, but bodies never overlap."""
    motion, stream = RigidBodyMotion(disturbances=disturbances), random.Random(2)
    motion.reset(HALL, [(2, 2), (2, 3), (3, 3), (3, 4)], 0)
    for _ in range(20):
        outcomes = motion.advance(stream.choices(STEPS, k=4), [False] * 4)
        assert [outcome.cell for outcome in outcomes] == [cell_at(outcome) for outcome in outcomes]
        for one, other in combinations(outcomes, 2):
            apart = math.dist(one.path[-1, 1:3], other.path[-1, 1:3])
            assert apart >= 2 * RobotSpec().radius - 0.01
