"""The interface of robots that drive through: routes, joint steps and periods."""

from collections.abc import Callable
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest

from warehouse_core import BackendError, Cell, Layout
from warehouse_core.motion.backends import make_motion
from warehouse_physics import DrivingMotion, RobotSpec
from warehouse_physics.arena import Hit
from warehouse_physics.driving.dependencies import HISTORY

STAY, EAST, WEST = (0, 0), (0, 1), (0, -1)
LAYOUT = Layout([".....", "..#.."])


def motion_at(*cells: Cell, **options: Any) -> DrivingMotion:
    motion = DrivingMotion(**options)
    motion.reset(LAYOUT, cells, 0)
    return motion


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ([(0, 0)], "1 cells for 2 robots; each robot needs one"),
        (
            [(0, 2), (0, 1)],
            r"robot 0 cannot move from \(0, 0\) to \(0, 2\), which is not an open cell",
        ),
        (
            [(-1, 0), (0, 1)],
            r"robot 0 cannot move from \(0, 0\) to \(-1, 0\), which is not an open",
        ),
        ([(0, 1), (0, 1)], r"robots 0 and 1 cannot both move to \(0, 1\)"),
        ([(0, 1), (0, 0)], r"robots 0 and 1 cannot swap the cells \(0, 0\) and \(0, 1\)"),
    ],
)
def test_a_joint_step_with_a_conflict_is_refused_and_nothing_changes(cells, message) -> None:
    motion = motion_at((0, 0), (0, 1))
    with pytest.raises(ValueError, match=message):
        motion.extend(cells)
    assert motion.routes().ends == [(0, 0), (0, 1)]
    motion.extend([(0, 1), (0, 2)])
    assert motion.routes().ends == [(0, 1), (0, 2)]


def test_a_joint_step_of_a_plan_needs_no_room() -> None:
    motion = motion_at((0, 0))
    for col in range(1, 5):
        assert motion.routes().has_room == [col - 1 <= 1.5]  # to stop, and to drive for a second
        motion.extend([(0, col)])
    assert motion.routes()[:3] == ([(0, 4)], [False], [False])
    assert motion.drive(5.0)[0].cell == (0, 4)
    assert motion.routes()[:3] == ([(0, 4)], [True], [True])


def test_a_route_that_grows_in_time_leads_round_corners_as_fast_as_a_whole_one() -> None:
    floor = Layout(["." * 5] * 5)
    cells = [(0, col) for col in range(5)] + [(row, 4) for row in range(1, 5)]
    growing, whole = DrivingMotion(period=0.25), DrivingMotion()
    for motion in growing, whole:
        motion.reset(floor, cells[:1], 0)
    for cell in cells[1:]:
        whole.extend([cell])
    ahead = cells[1:]
    for _ in range(60):
        (end,), (has_room,), (is_there,), *_ = growing.routes()
        if is_there and not ahead:
            break
        row, col = ahead.pop(0) if has_room and ahead else end
        growing.advance([(row - end[0], col - end[1])], [False])
        whole.drive(0.25)
        assert whole.routes().at_rest == growing.routes().at_rest or ahead
    assert whole.routes().at_rest == [True]


def test_the_name_of_the_backend_may_have_the_period_among_the_numbers_of_the_robot() -> None:
    motion = make_motion("driving:period=0.25,top_speed=0.5")
    assert isinstance(motion, DrivingMotion)
    assert (motion.period, motion.spec.top_speed) == pytest.approx((0.25, 0.5))
    assert motion.cell_steps == pytest.approx(8)
    assert make_motion("driving:top_speed=0.5").period == pytest.approx(2.0)
    with pytest.raises(
        BackendError,
        match=r"called 'perod'; allowed: .*, recuperation, noise, .*, slippery, period$",
    ):
        make_motion("driving:perod=0.25")
    with pytest.raises(BackendError, match=r"called 'period'; allowed: .*, odometry, slippery$"):
        make_motion("physics:period=0.25")


@pytest.mark.parametrize("period", [0.25, 0.5, 1.0])
def test_picking_takes_its_time_however_short_the_calls_are(period: float) -> None:
    motion = motion_at((0, 0), period=period)
    motion.advance([STAY], [False])  # the call in which it picks
    starts = []
    for call in range(1, 9):
        (outcome,) = motion.advance([EAST if call == 1 else STAY], [True])
        starts += [call * period] * bool(outcome.path[-1, 1] > outcome.path[0, 1])
    assert starts[0] == pytest.approx(1.0)


def test_robots_that_cannot_extend_their_routes_are_blocked() -> None:
    motion = motion_at((0, 0), (0, 1), (1, 0))
    outcomes = motion.advance([EAST, WEST, WEST], [False] * 3)
    assert [outcome.blocked for outcome in outcomes] == [True] * 3
    assert motion.routes().ends == [(0, 0), (0, 1), (1, 0)]
    outcomes = motion.advance([EAST, EAST, STAY], [False] * 3)
    assert [outcome.blocked for outcome in outcomes] == [False] * 3


def test_a_call_lasts_the_nearest_number_of_substeps() -> None:
    motion = motion_at((0, 0))
    assert motion.period == pytest.approx(1.0)
    for asked, got in ((1.0, 1.0), (0.024, 1 / 60), (0.026, 2 / 60), (1e-9, 1 / 60)):
        (outcome,) = motion.drive(asked)
        assert outcome.seconds == outcome.path[-1, 0] == pytest.approx(got)
    assert motion_at((0, 0), spec=RobotSpec(top_speed=0.5)).period == pytest.approx(2.0)
    (outcome,) = motion_at((0, 0), period=0.2).advance([STAY], [False])
    assert outcome.seconds == pytest.approx(0.2)
    assert outcome.joules == pytest.approx(20 * 0.2)


def test_a_path_has_a_row_for_each_so_many_substeps_and_the_ends() -> None:
    for options, expected in (
        ({}, [0, 10, 20, 25]),
        ({"path_every": 12}, [0, 12, 24, 25]),
        ({"path_every": 5, "record_path": False}, [0, 25]),
    ):
        motion = motion_at((0, 0), **options)
        motion.extend([(0, 1)])
        (outcome,) = motion.drive(25 / 60)
        assert outcome.path[:, 0] * 60 == pytest.approx(expected)
        assert outcome.path[0, 1:].tolist() == [0.5, 0.5, 0.0]
        assert not outcome.path.flags.writeable


def test_paths_go_on_where_they_ended_and_headings_follow_the_route() -> None:
    motion = motion_at((0, 3))
    for cell in ((0, 4), (1, 4)):
        motion.extend([cell])
    rows = [motion.drive(0.5)[0].path for _ in range(8)]
    for before, after in pairwise(rows):
        assert np.array_equal(before[-1, 1:], after[0, 1:])
    assert rows[0][-1, 3] == 0
    assert rows[-1][-1, 1:] == pytest.approx([4.5, 1.5, np.pi / 2], abs=2e-3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: DrivingMotion(period=0.0), "period is 0.0"),
        (lambda: motion_at((0, 0)).drive(0.0), "seconds is 0.0"),
        (
            lambda: DrivingMotion(RobotSpec(radius=0.36)),
            "radius is 0.36; with cell_size 1.0 robots that drive through need a radius below",
        ),
        (lambda: motion_at((0, 0)).advance([(1, 1)], [False]), r"displacement \(1, 1\) of robot 0"),
    ],
)
def test_wrong_values_are_named(make: Callable[[], object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()


def test_a_motion_needs_a_reset_before_it_drives_and_after_it_is_closed() -> None:
    closed = motion_at((0, 0))
    closed.close()
    closed.close()
    calls: list[Callable[[DrivingMotion], object]] = [
        lambda motion: motion.routes(),
        lambda motion: motion.extend([(0, 1)]),
        lambda motion: motion.drive(1.0),
        lambda motion: motion.advance([EAST], [False]),
    ]
    for motion, call in product((DrivingMotion(), closed), calls):
        with pytest.raises(RuntimeError, match="needs a reset"):
            call(motion)


def test_cells_that_robots_have_passed_are_forgotten() -> None:
    motion, ring = motion_at((0, 0), (0, 1)), [(0, 0), (0, 1), (1, 1), (1, 0)]
    assert motion._driver is not None
    kept = 0
    for step in range(1, HISTORY + 12):
        motion.extend([ring[step % 4], ring[(step + 1) % 4]])
        motion.drive(2.0)
        kept = max(kept, *(len(list(motion._driver.routes.nodes(robot, 0))) for robot in (0, 1)))
    assert kept <= HISTORY + 3


def test_braking_gives_back_and_pays_for_the_next_calls() -> None:
    motions = [DrivingMotion(RobotSpec(recuperation=share)) for share in (0.0, 1.0)]
    costs: list[list[float]] = [[], []]
    for motion, joules in zip(motions, costs, strict=True):
        motion.reset(Layout(["." * 8]), [(0, 0)], 0)
        for step in range(10):
            joules += [motion.advance([(0, int(step < 6))], [False])[0].joules]
    spec = RobotSpec()
    braked = spec.mass / 2 - spec.drag_force(loaded=False) / 2  # from 1 m/s, over half a metre
    assert sum(costs[0]) - sum(costs[1]) == pytest.approx(braked, rel=0.01)
    assert min(costs[1]) >= 0


def test_what_a_hit_takes_from_a_robot_is_not_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    motion = DrivingMotion(RobotSpec(recuperation=1.0))
    motion.reset(Layout(["." * 8]), [(0, 0)], 0)
    for _ in range(4):
        motion.advance([(0, 1)], [False])
    driver, before = motion._driver, motion._driver.joules()[0]
    arena = driver._arena
    step = arena.stepper.run

    def run_against_a_wall(now: int, until: int) -> tuple[int, list[Any]]:
        step(now, until)
        arena.bodies[0].velocity = 0.0, 0.0
        return until, [Hit(0, None, (-1.0, 0.0), (1.0, 0.0), 50.0, (4.0, 0.5))]

    monkeypatch.setattr(arena.stepper, "run", run_against_a_wall)
    driver.step()
    assert driver.joules()[0] == before
