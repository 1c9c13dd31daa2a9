"""The bodies of robots that drive through, and the hits that they report."""

import pytest

from warehouse_core import Layout
from warehouse_core.motion.base import centre_of
from warehouse_physics import DrivingMotion, RobotSpec
from warehouse_physics.arena import ITERATIONS, Hit
from warehouse_physics.driven_arena import DrivenArena
from warehouse_physics.walls import wall_boxes

SPEC = RobotSpec(payload_mass=50.0)


def hits_of(layout: Layout, cells: list[tuple[int, int]], velocities, loaded=()) -> list[Hit]:
    """Return the first hits of bodies that drive at the given velocities in m/s."""
    arena = DrivenArena(SPEC, ITERATIONS)
    arena.add_walls(wall_boxes(layout))
    arena.add_robots(centre_of(cell, SPEC.cell_size) for cell in cells)
    arena.command(velocities)
    for robot, drive in enumerate(arena.drives):
        arena.bodies[robot].mass = SPEC.total_mass(robot in loaded)
        drive.max_force = 1e4
    return arena.stepper.run(0, 120)[1]


def test_two_bodies_that_meet_both_report_it() -> None:
    cells = [(0, 0), (0, 1)]
    hits = hits_of(Layout(["..."]), cells, [(0.4, 0.0), (-0.2, 0.0)], loaded=[1])
    assert [(hit.robot, hit.other) for hit in sorted(hits)] == [(0, 1), (1, 0)]
    assert [hit.push for hit in sorted(hits)] == [(-1.0, 0.0), (1.0, 0.0)]
    assert [hit.velocity[0] for hit in sorted(hits)] == pytest.approx([0.4, -0.2])
    reduced = 50 * 100 / 150
    assert {round(hit.impulse, 3) for hit in hits} == {round(reduced * 0.6, 3)}


def test_a_hit_is_in_the_outcomes_of_both_robots() -> None:
    motion = DrivingMotion()
    motion.reset(Layout(["....."]), [(0, 0), (0, 4)], 0)
    assert motion._driver is not None
    arena = motion._driver._arena
    motion.drive(0.1)
    arena.bodies[0].position = (4.0, 0.5)
    one, other = motion.drive(1.0)
    assert [contact.counterpart for contact in one.contacts] == ["robot 1"]
    assert [contact.counterpart for contact in other.contacts] == ["robot 0"]
    assert 0 < one.contacts[0].seconds <= 1.0


def test_a_body_that_is_held_against_a_wall_sinks_in_by_a_millimetre() -> None:
    """With Chipmunk's default slop it would be a decimetre."""
    arena = DrivenArena(SPEC, ITERATIONS)
    arena.add_walls(wall_boxes(Layout(["."])))
    arena.add_robots([(0.5, 0.5)])
    arena.drives[0].max_force = 60.0
    for substep in range(120):
        arena.command([(0.5, 0.0)])
        arena.stepper.run(substep, substep + 1)
    assert arena.look()[0][0, 0] + SPEC.radius - 1 == pytest.approx(0.001, abs=5e-4)
