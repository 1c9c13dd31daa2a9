"""Several robots in one space: colliding bodies, compared with ``motion/traffic.py``."""

import random
from itertools import combinations

import numpy as np
import pytest
from helpers.rigid_bodies import EAST, NORTH, SOUTH, STAY, STEPS, WEST, together

from warehouse_core import Layout, Outcome
from warehouse_core.motion.backends import make_fleet_motion
from warehouse_core.motion.base import WALL_CONTACT, robot_contact
from warehouse_physics import Disturbances, RigidBodyMotion, RobotSpec

HALL = Layout(["......"] * 6)

over_specs = pytest.mark.parametrize(
    "spec",
    [RobotSpec(), RobotSpec.fast(), RobotSpec(turn_seconds=0.4)],
    ids=["1/60", "1/30", "turning"],
)


def places_at(times: np.ndarray, outcome: Outcome) -> np.ndarray:
    """Return x and y at some times, ``[2, K]``. A path ends when its robot is at rest."""
    clock, x, y, _ = outcome.path.T
    return np.array([np.interp(times, clock, x), np.interp(times, clock, y)])


@over_specs
def test_a_chain_of_blocked_robots_is_resolved(spec: RobotSpec) -> None:
    """Robots 1, 5 and 6 all have to drive back, and each blocks the next."""
    layout = Layout(["########", "#.....##", "#.#.#..#", "#....#.#", "#......#", "########"])
    cells = [(3, 6), (3, 3), (3, 1), (2, 1), (3, 2), (3, 4), (4, 3), (4, 5), (2, 6), (4, 4)]
    moves = [NORTH, SOUTH, STAY, STAY, SOUTH, WEST, WEST, SOUTH, NORTH, SOUTH]
    loaded = [robot in (0, 1, 6, 8, 9) for robot in range(10)]
    outcomes = together(layout, cells, moves, spec, loaded)
    assert [outcome.cell for outcome in outcomes] == cells
    assert [outcome.blocked for outcome in outcomes] == [move != STAY for move in moves]


def test_both_robots_report_a_hit() -> None:
    pushed = together(HALL, [(2, 2), (2, 3)], [EAST, STAY])
    assert pushed[0].contacts[0].counterpart == robot_contact(1)
    assert pushed[1].contacts[0].counterpart == robot_contact(0)
    assert (pushed[0].blocked, pushed[1].blocked) == (True, False)
    at_a_wall = together(HALL, [(0, 0), (3, 3)], [NORTH, STAY])
    assert at_a_wall[0].contacts[0].counterpart == WALL_CONTACT
    assert at_a_wall[1].contacts == ()


@over_specs
def test_bodies_never_overlap_by_more_than_they_move_in_a_substep(spec) -> None:
    stream, deepest, fastest = random.Random(1), 0.0, 2 * spec.top_speed
    motion = RigidBodyMotion(spec, path_every=1)
    motion.reset(Layout(["...."] * 3), [(row, col) for row in range(3) for col in (0, 2)], 0)
    for _ in range(15):
        outcomes = motion.advance(stream.choices(STEPS, k=6), [False] * 6)
        for one, other in combinations(outcomes, 2):
            times = np.union1d(one.path[:, 0], other.path[:, 0])
            apart = np.hypot(*(places_at(times, one) - places_at(times, other)))
            deepest = max(deepest, 2 * spec.radius - float(apart.min()))
    assert 0 < deepest <= fastest * spec.time_step


def test_a_robot_that_is_pushed_out_of_its_cell_is_reported_where_it_is() -> None:
    """A robot that ends in an unexpected cell is still reported correctly."""
    motion = RigidBodyMotion()
    motion.reset(HALL, [(2, 2), (2, 3)], 0)
    body = motion._arena.robots[1].body
    body.position = (4.5, 4.5)
    outcomes = motion.advance([EAST, STAY], [False, False])
    assert [outcome.cell for outcome in outcomes] == [(2, 3), (4, 4)]
    assert not outcomes[0].blocked


def test_a_batch_of_disturbed_fleets_repeats_with_its_seeds() -> None:
    motion = RigidBodyMotion(disturbances=Disturbances(actuation_noise=0.1))
    ends = []
    for seed in (4, 4, 5):
        batch = make_fleet_motion(motion, [HALL], 3)
        batch.place(np.arange(3), np.array([0, 7, 14]), seeds=[seed])
        ends.append(batch.advance(np.array([1, 2, 1]), np.zeros(3, np.bool_)).seconds.tolist())
    assert ends[0] == ends[1] != ends[2]
