"""The interface of a motion, which carries out moves, and the outcome that it returns.

A *motion* moves ``R`` robots at once; in the chapter's environment ``R = 1``. It knows walls and
robots, but no rewards, items or batteries: those are in ``task/rules.py``, which reads only the
``cell`` and ``blocked`` of an outcome.

A *position* is ``(x, y)`` in metres with ``x = (col + 0.5) * cell_size`` and
``y = (row + 0.5) * cell_size``; rows grow downward and so does y. A *heading* is in radians from
the x axis towards the y axis: east 0, south pi/2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import LayoutError
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tiles import Cell

WALL_CONTACT = "wall"


class Conditions(NamedTuple):
    """How far the floor and the motors of a motion are known to differ from the nominal.

    Attributes:
        slippery: cells with slippery floor.
        motor_strength: actual share of the motor force, 0 to 1.

    Example:
        >>> from warehouse_core.motion import Conditions
        >>> Conditions(slippery=((4, 5),))
        Conditions(slippery=((4, 5),), motor_strength=1.0)
    """

    slippery: tuple[Cell, ...] = ()
    motor_strength: float = 1.0


@runtime_checkable
class HasConditions(Protocol):
    """A motion whose conditions are recorded, and drawn in replays.

    Example:
        >>> from warehouse_core import GridMotion
        >>> from warehouse_core.motion import HasConditions
        >>> from warehouse_physics import RigidBodyMotion
        >>> isinstance(RigidBodyMotion(), HasConditions), isinstance(GridMotion(), HasConditions)
        (True, False)
    """

    @property
    def conditions(self) -> Conditions:
        """Floor and motors."""


def conditions_of(motion: object, layout: Layout) -> Conditions:
    """Return the conditions of a motion in a layout, in whose open cells the floor may be slippery.

    A motion that tells none has nominal ones.
    """
    if not isinstance(motion, HasConditions):
        return Conditions()
    slippery, strength = motion.conditions
    return Conditions(tuple(filter(layout.is_open, sorted(slippery))), float(strength))


def robot_contact(robot: int) -> str:
    """Return the name of a robot as the counterpart of a contact."""
    return f"robot {robot}"


class Contact(NamedTuple):
    """One hit during a motion.

    Attributes:
        seconds: time of the hit, from the start of the motion.
        impulse: impulse in N·s, positive: the speed at which the two approached right before, times
            the mass of the robot, or of two robots their reduced mass. The push of their motors
            during and after the hit is not in it, nor the push of others who touch them.
        point: position ``(x, y)`` in metres.
        counterpart: ``"wall"`` or ``"robot 3"``.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> env = WarehouseEnv(backend="physics")
        >>> observation = env.reset()
        >>> step = env.step("N")
        >>> [contact] = env.last_motion.contacts
        >>> contact.counterpart, round(contact.impulse)
        ('wall', 28)
    """

    seconds: float
    impulse: float
    point: tuple[float, float]
    counterpart: str


class Outcome(NamedTuple):
    """The outcome of one action of one robot, in the same fields for every backend.

    Attributes:
        cell: cell of the robot after the action.
        blocked: something stopped the robot on its way to another cell.
        seconds: its duration.
        joules: its cost.
        path: ``[K, 4]`` float64, read-only, ``K >= 2``: time from the start of the motion in
            seconds, x, y, heading. The first row is the start, the last row the end.
        contacts: every hit, in order of time. Not empty when ``blocked``, unless the robot that
            had been in the next cell came back and this one gave way before they touched.
        cut_off: the action took too long and ended before the robot was at rest where it had to
            be; its values are those at that moment.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> env = WarehouseEnv()
        >>> observation = env.reset()
        >>> step = env.step("N")
        >>> outcome = env.last_motion
        >>> outcome.cell, outcome.blocked, outcome.seconds
        ((1, 1), True, 1.0)
    """

    cell: Cell
    blocked: bool
    seconds: float
    joules: float
    path: NDArray[np.float64]
    contacts: tuple[Contact, ...] = ()
    cut_off: bool = False

    def copy(self) -> Outcome:
        """Return the same outcome with a copy of its path."""
        return self._replace(path=self.path.copy())

    def __eq__(self, other: object) -> bool:
        # A tuple would ask the arrays of the paths for one truth value, which they do not have.
        if not isinstance(other, Outcome):
            return NotImplemented
        return np.array_equal(self.path, other.path) and all(
            mine == others
            for mine, others in zip(self, other, strict=True)
            if mine is not self.path
        )

    def __ne__(self, other: object) -> bool:
        return not self == other  # a tuple has a __ne__ of its own

    def __hash__(self) -> int:
        return hash(
            (self.cell, self.blocked, self.seconds, self.joules, self.contacts, self.cut_off)
        )


@runtime_checkable
class Motion(Protocol):
    """The interface of a backend; ``warehouse_core/conformance`` checks an implementation.

    Example:
        >>> from warehouse_core import GridMotion, Motion
        >>> motion: Motion = GridMotion()
        >>> isinstance(motion, Motion)
        True
    """

    cell_size: float
    """Side of a cell in metres."""

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        """Put ``R = len(cells)`` robots at rest in the middle of their cells, heading east.

        Args:
            layout: layout that has the walls.
            cells: one open cell for each robot, all different.
            seed: seed of the backend's random numbers; ``None`` lets the backend choose.

        Raises:
            LayoutError: a cell is a wall, off the grid, or given twice, or there is none; nothing
                has changed.
        """

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        """Carry out one action for each robot, all at the same time.

        Args:
            displacements: ``(0, 0)`` or one cell north, east, south or west for each robot.
            loaded: flag of each robot that carries an item.

        Returns:
            One outcome for each robot.

        Raises:
            ValueError: another number of arguments than robots, or another displacement; nothing
                has changed.
            RuntimeError: ``advance`` before ``reset`` or after ``close``.
        """

    def close(self) -> None:
        """Release resources; safe to call twice."""


@runtime_checkable
class Turns(Motion, Protocol):
    """A motion whose robots can turn on the spot; any other waits instead."""

    def face(self, directions: Sequence[Cell]) -> None:
        """Let robots that stay in their cells in the next ``advance`` turn in it.

        Args:
            directions: displacement of a move in the direction that each robot turns to, the
                shorter way round; ``(0, 0)`` for robots that do not turn.

        Raises:
            ValueError: another number of directions than robots, or another displacement; nothing
                has changed.
            RuntimeError: before ``reset`` or after ``close``.
        """


class Ways(NamedTuple):
    """The ways that ``R`` robots have ahead of them.

    Attributes:
        ends: the last cell of each way, where the next move of the robot begins. They are all
            different, except that two failed robots may stand between the same two cells.
        has_room: flag of each way that a move may extend now.
        at_rest: flag of each robot that is at rest at the end of its way, as it has to be to pick,
            drop or charge.
        failed: flag of each robot that stays in its place for good.
        closed: the cells that failed robots are in, or reach into, which nobody can enter.
    """

    ends: Sequence[Cell]
    has_room: Sequence[bool]
    at_rest: Sequence[bool]
    failed: Sequence[bool] = ()
    closed: Sequence[Cell] = ()


@runtime_checkable
class HasPace(Protocol):
    """A motion that says how many of its steps a robot takes for a cell.

    Attributes:
        cell_steps: steps of a cell at top speed.
    """

    cell_steps: float


def cell_steps_of(motion: object) -> float:
    """Return how many steps of a motion a robot takes for a cell, 1 if it does not say so."""
    return motion.cell_steps if isinstance(motion, HasPace) else 1.0


@runtime_checkable
class HasCost(Protocol):
    """A motion that says how much energy a cell takes.

    Attributes:
        cell_joules: joules that a robot is to count with for a cell.
    """

    cell_joules: float


@runtime_checkable
class DrivesThrough(Motion, Protocol):
    """A motion whose robots have ways ahead of them, and drive through the cells of these ways.

    A displacement does not move a robot from where it is, but appends a cell to the end of its way;
    without room there the robot waits. A call of ``advance`` may end while robots drive.
    """

    def ways(self) -> Ways:
        """Return the way that each robot has ahead of it.

        Raises:
            RuntimeError: before ``reset`` or after ``close``.
        """

    def fail(self, robot: int) -> None:
        """Let a robot brake and stay where it is for good, and others go on without it.

        Robots that are then caught between others, with no cell to come to rest in, fail too.

        Raises:
            RuntimeError: before ``reset`` or after ``close``.
        """


Pose = tuple[float, float, float]
"""A position x and y in metres, and a heading."""

MAX_RAYS = 1_000
"""Most rays of a scan."""

SCAN_RANGE = 10.0
"""Metres beyond which a scan sees nothing."""


@runtime_checkable
class Senses(Motion, Protocol):
    """A motion whose robots have sensors."""

    def scan(self, robot: int, rays: int) -> NDArray[np.float64]:
        """Return how far walls and other robots are in ``rays`` directions.

        Args:
            robot: number of the robot.
            rays: number of directions, at equal angles: the first leads east, the others follow
                towards south, whatever the heading of the robot is.

        Returns:
            ``[rays]`` metres from the middle of the robot, ``SCAN_RANGE`` if nothing is nearer.

        Raises:
            ValueError: there is no such robot, or no ray.
            RuntimeError: before ``reset`` or after ``close``.
        """

    def odometry(self, robot: int) -> Pose | None:
        """Return where a robot believes to be, or ``None`` without odometry.

        Raises:
            ValueError: there is no such robot.
            RuntimeError: before ``reset`` or after ``close``.
        """


def centre_of(cell: Cell, cell_size: float) -> tuple[float, float]:
    """Return the position of the middle of ``cell`` in metres."""
    row, col = cell
    return (col + 0.5) * cell_size, (row + 0.5) * cell_size


def check_starts(layout: Layout, cells: Sequence[Cell]) -> None:
    """Raise if robots cannot be put on these cells; for backends to call in ``reset``.

    Raises:
        LayoutError: naming the robot and the cell; or there are no cells.
    """
    if not cells:
        raise LayoutError("no robots: cells is empty; it needs a cell for each robot")
    robot_in: dict[Cell, int] = {}
    for robot, cell in enumerate(cells):
        check_open(layout, cell, f"robot {robot}:")
        first = robot_in.setdefault(cell, robot)
        if first != robot:
            raise LayoutError(f"robots {first} and {robot} are both given {cell}")


_ALLOWED = frozenset(DISPLACEMENTS)


def check_directions(robots: int, directions: Sequence[Cell]) -> None:
    """Raise unless there is one direction to turn to for each robot; for backends, in ``face``.

    Raises:
        ValueError: naming the robot and the direction, or the two counts.
    """
    if len(directions) != robots:
        raise ValueError(f"{len(directions)} directions for {robots} robots; one each")
    _check_displacements("direction", directions)


def check_moves(robots: int, displacements: Sequence[Cell], loaded: Sequence[bool]) -> None:
    """Raise unless there is one action for each robot; for backends to call in ``advance``.

    Raises:
        ValueError: naming the robot and the displacement, or the two counts.
    """
    if not len(displacements) == len(loaded) == robots:
        raise ValueError(
            f"{len(displacements)} displacements and {len(loaded)} loads for {robots} robots; "
            "one of each is needed for every robot"
        )
    _check_displacements("displacement", displacements)


def _check_displacements(name: str, displacements: Sequence[Cell]) -> None:
    if not _ALLOWED.issuperset(displacements):
        robot, bad = next(each for each in enumerate(displacements) if each[1] not in _ALLOWED)
        raise ValueError(f"{name} {bad!r} of robot {robot}; allowed: {sorted(_ALLOWED)}")
