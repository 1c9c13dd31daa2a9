"""Checks of rigid bodies: random robots, jams, queues, and an independent account of their work."""

import random
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

from pymunk import Vec2d

from helpers.crowds import targets_of
from helpers.rigid_bodies import STAY, STEPS, rows_differ, together
from warehouse_core import Cell, Layout, Outcome, random_layout
from warehouse_core.motion.traffic import find_stops
from warehouse_physics import RigidBodyMotion, RobotSpec
from warehouse_physics.robot import AT_REST, Robot

PAYLOADS = (0.0, 20.0, 40.0, 90.0, 200.0, 340.0)
JOULES_TOLERANCE = 1e-5
"""Relative difference between a batch and single motions, whose solvers leave other speeds across
the path."""


def random_spec(
    stream: random.Random, *, is_round: bool, widest: float = 0.499, drive: str = "omnidirectional"
) -> RobotSpec:
    """Return a random valid robot, with round numbers or with any."""
    draw = stream.choice
    while True:
        size = draw([0.3, 0.5, 1.0, 1.0, 2.0, 3.7]) if is_round else stream.uniform(0.3, 4)
        widths = [share for share in (0.1, 0.2, 0.3, 0.35, 0.4, 0.45, 0.49) if share <= widest]
        share = draw(widths) if is_round else stream.uniform(0.05, widest)
        values = {
            "mass": draw([10, 50, 200]) if is_round else 10 ** stream.uniform(1, 3),
            "payload_mass": draw([0, 20, 100, 340]) if is_round else 10 ** stream.uniform(0, 3),
            "top_speed": draw([0.5, 1, 2, 3]) if is_round else 10 ** stream.uniform(-0.7, 1),
            "acceleration": draw([0.5, 1, 2, 4]) if is_round else 10 ** stream.uniform(-1, 1.3),
            "motor_force": draw([60, 400, 4000]) if is_round else 10 ** stream.uniform(1.5, 4.5),
            "floor_drag": draw([0, 0.015, 0.05, 0.2, 10 ** stream.uniform(-2, -0.3)]),
            "time_step": draw([1 / 120, 1 / 60, 1 / 30]),
        }
        try:
            return RobotSpec(cell_size=size, radius=share * size, drive=drive, **values)
        except ValueError:
            continue


def random_robots_move_as_the_grid(
    moves: int, seed: int = 0, drive: str = "omnidirectional"
) -> tuple[int, int]:
    """Compare random robots alone, in a batch and on the grid, in a hundred moves each.

    Return the number of moves, and of moves by robots that the floor alone brakes.
    """
    made = braked = 0
    while made < moves:
        spec = random_spec(random.Random(seed), is_round=bool(seed % 2), drive=drive)
        rows_differ(spec, rows=4, steps=25, seed=seed, joules=JOULES_TOLERANCE)
        is_braked = spec.floor_deceleration > spec.attainable_acceleration(loaded=True)
        made, braked, seed = made + 100, braked + 100 * is_braked, seed + 1
    return made, braked


def jams(
    seed: int, actions: int, drive: str = "omnidirectional"
) -> Iterator[list[tuple[Outcome, Cell, bool]]]:
    """Yield the outcomes of a heavily loaded crowd, and the cells and stops by the table.

    A fifth or more of the open cells have robots, and most of these move.
    """
    stream = random.Random(seed)
    layout = random_layout(
        stream.randint(4, 9), stream.randint(4, 10), stream.uniform(0, 0.35), seed=seed
    )
    count = max(2, int(stream.uniform(0.2, 1) * len(layout.open_cells)))
    cells = [layout.open_cell(i) for i in stream.sample(range(len(layout.open_cells)), count)]
    payload = stream.choice(PAYLOADS)
    spec = RobotSpec(
        payload_mass=payload,
        motor_force=max(60.0, 1.5 * payload),
        time_step=stream.choice([1 / 60, 1 / 30]),
        drive=drive,
    )
    motion = RigidBodyMotion(spec, record_path=False)
    motion.reset(layout, cells, 0)
    for _ in range(actions):
        moves = stream.choices(STEPS, [1, 5, 5, 5, 5], k=count)
        targets = targets_of(cells, moves)
        stops = find_stops(layout, cells, targets)
        outcomes = motion.advance(moves, stream.choices([False, True], k=count))
        pairs = zip(cells, targets, stops, strict=True)
        cells = [cell if stop is not None else target for cell, target, stop in pairs]
        is_stopped = [stop is not None for stop in stops]
        yield list(zip(outcomes, cells, is_stopped, strict=True))


def differences_in_jams(
    moves: int, seed: int = 0, drive: str = "omnidirectional"
) -> tuple[int, int, int]:
    """Return how many robots moved, how many differ from the table, and how many were cut off."""
    made = wrong = cut_off = 0
    while made < moves:
        for action in jams(seed, 10, drive):
            differ = [it[:2] != (cell, stopped) for it, cell, stopped in action]
            made, wrong = made + len(action), wrong + sum(differ)
            cut_off += sum(outcome.cut_off for outcome, _, _ in action)
            if any(differ):
                break
        seed += 1
    return made, wrong, cut_off


def queue(layout: Layout, cells: list[Cell], loaded: bool = False) -> list[Outcome]:
    """Let each robot drive into the cell of the next one, and the last one wait."""
    moves = [(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(cells)]
    return together(layout, cells, [*moves, STAY], None, [loaded] * len(cells), record_path=False)


def straight_queue(robots: int) -> tuple[Layout, list[Cell]]:
    """Return a corridor and the cells of a queue that fills it."""
    return Layout(["." * robots]), [(0, col) for col in range(robots)]


def winding_queue(robots: int) -> tuple[Layout, list[Cell]]:
    """Return a hall and the cells of a queue that turns at every robot."""
    side = robots // 2 + 1
    cells = [(number // 2, (number + 1) // 2) for number in range(robots)]
    return Layout(["." * side] * side), cells


class Book:
    """An independent account of the work of motors and of hits, from each substep of a space.

    It knows nothing of phases and profiles. The work of a motor is its impulse times the mean
    velocity. A motor that is commanded to stop gets a share of this work back. A motor pushes
    towards the commanded velocity. Once the body has reached it, the impulse of the motor is the
    change of momentum that floor and contacts do not explain. The impulse of two bodies that begin
    to overlap is their reduced mass times their closing speed. With differential drive, bodies
    yield along their headings only, and motors also turn them.
    """

    def __init__(self, motion: RigidBodyMotion) -> None:
        self._robots, self._spec = motion._arena.robots, motion.spec
        self._reach = 2 * motion.spec.body_radius
        self._step = motion._arena.space.step
        motion._arena.space.step = self._step_and_book
        self.clear()

    def clear(self) -> None:
        """Begin the account of an action."""
        self.work = [0.0] * len(self._robots)
        self.hits: list[list[float]] = [[] for _ in self._robots]

    def _step_and_book(self, dt: float) -> None:
        robots, touching = self._robots, self._touching()
        before = [robot.body.velocity for robot in robots]
        commands = [robot._control.velocity for robot in robots]
        spins = [robot.body.angular_velocity for robot in robots]
        self._step(dt)
        back = self._spec.recuperation * self._spec.drivetrain_efficiency
        for number, (robot, command) in enumerate(zip(robots, commands, strict=True)):
            if command.length > 0:
                push = _push_of(robot, before[number], command)
                mean = self._free(robot, before[number] + robot.body.velocity) / 2
                self.work[number] += max(0.0, push.dot(mean))
            elif self._spec.recuperation:
                push = _push_of(robot, before[number], command)
                braked = max(0.0, -push.dot(before[number] + robot.body.velocity) / 2)
                self.work[number] -= back * braked
            if self._spec.is_differential:
                spin, drag = robot.body.angular_velocity, robot._drag * self._spec.wheel_arm
                gained = robot.body.moment * (spin**2 - spins[number] ** 2) / 2
                work = gained + drag * abs(spins[number] + spin) / 2 * dt
                is_commanded = robot._control.angular_velocity != 0
                self.work[number] += work if is_commanded else min(0.0, back * work)
        for one, two in self._touching() - touching:
            bodies = robots[one].body, robots[two].body
            normal = (bodies[1].position - bodies[0].position).normalized()
            speed = (before[one] - before[two]).dot(normal)
            shares = (self._free(robots[each], normal).length for each in (one, two))
            impulse = speed / sum(
                share**2 / body.mass for share, body in zip(shares, bodies, strict=True)
            )
            if impulse > 0:
                self.hits[one].append(impulse)
                self.hits[two].append(impulse)

    def _free(self, robot: Robot, vector: Vec2d) -> Vec2d:
        """Return the part of a vector in which a robot can move, without turning."""
        heading = robot.body.rotation_vector
        return heading * heading.dot(vector) if self._spec.is_differential else vector

    def _touching(self) -> set[tuple[int, int]]:
        places = [robot.body.position for robot in self._robots]
        return {
            (one, two)
            for two in range(len(places))
            for one in range(two)
            if (places[two] - places[one]).length < self._reach
        }


def _push_of(robot: Robot, before: Vec2d, command: Vec2d) -> Vec2d:
    """Return the impulse of a motor in a substep that began with the velocity ``before``."""
    after, others = robot.body.velocity, []
    missing = command - after
    if robot._spec.is_differential:
        missing = missing.projection(command)
    if missing.length > AT_REST:
        return robot._motor.impulse * missing.normalized()
    robot.body.each_arbiter(lambda arbiter: others.append(arbiter.total_impulse))
    drag = -robot._floor.impulse * after.normalized()
    return robot.body.mass * (after - before) - sum(others, drag)


class BookErrors(NamedTuple):
    """Relative errors compared with the account: joules of moves, impulses between robots."""

    joules: list[float]
    impulses: list[float]


def errors_of_the_books(
    moves: int, robots: int, seed: int = 0, drive: str = "omnidirectional"
) -> BookErrors:
    """Compare the outcomes of random robots with the independent account."""
    errors = BookErrors([], [])
    while len(errors.joules) < moves:
        stream = random.Random(seed)
        widest = 0.35 if robots > 1 else 0.45
        spec = random_spec(stream, is_round=bool(seed % 2), widest=widest, drive=drive)
        layout = random_layout(6, 6, 0.1, seed=seed % 50)
        ranks = stream.sample(range(len(layout.open_cells)), robots)
        motion = RigidBodyMotion(spec, record_path=False)
        motion.reset(layout, [layout.open_cell(rank) for rank in ranks], 0)
        book = Book(motion)
        for _ in range(10):
            book.clear()
            steps = stream.choices(STEPS, [1, 3, 3, 3, 3], k=robots)
            outcomes = motion.advance(steps, stream.choices([False, True], k=robots))
            for outcome, work, hits in zip(outcomes, book.work, book.hits, strict=True):
                joules = work / spec.drivetrain_efficiency + spec.idle_power * outcome.seconds
                errors.joules.append(abs(outcome.joules / joules - 1))
                noted = [it.impulse for it in outcome.contacts if it.counterpart != "wall"]
                assert len(noted) == len(hits), spec
                pairs = zip(sorted(noted), sorted(hits), strict=True)
                errors.impulses.extend(abs(ours / theirs - 1) for ours, theirs in pairs)
        seed += 1
    return errors
