"""The interface of a motion, which carries out moves, and the outcome that it returns.

A *motion* moves ``R`` robots at once; in the chapter's environment ``R = 1``. It knows walls and
robots, but no rewards, items or batteries: those are in ``task/rules.py``, which reads only the
``cell`` and ``blocked`` of an outcome.

A *position* is ``(x, y)`` in metres with ``x = (col + 0.5) * cell_size`` and
``y = (row + 0.5) * cell_size``; rows grow downward and so does y. A *heading* is in radians from
the x axis towards the y axis: east 0, south pi/2.

A *batch motion* moves ``R`` robots in each of ``B`` layouts. Floor ``b`` of the batch equals a
separate motion in ``layouts[b]``, in ``cell`` and ``blocked``. Its arrays have a row for each of
the ``N = B * R`` robots, floor by floor: robot ``r`` of floor ``b`` is row ``b * R + r``. Here the
cell of a robot is a single number, ``row * W + col``, where ``W`` is the width of its layout.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import LayoutError
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tables import Flags, Integers
from warehouse_core.world.tiles import Cell

WALL_CONTACT = "wall"

NOTHING, WALL = -1, -2
"""Values of ``stopped_by`` besides the robots of the floor, which have numbers from 0."""


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


class Routes(NamedTuple):
    """The routes of ``R`` robots: the cells that they have yet to drive through.

    Attributes:
        ends: last cell of each route, where the next move of the robot begins. All are different,
            except that two failed robots may stand between the same two cells.
        has_room: whether the next move may extend the route.
        at_rest: whether the robot is at rest at the end of its route. Only then can it pick, drop
            or charge.
        failed: whether the robot has stopped for good.
        closed: cells that nobody can enter because a failed robot occupies at least a part of them.
    """

    ends: Sequence[Cell]
    has_room: Sequence[bool]
    at_rest: Sequence[bool]
    failed: Sequence[bool] = ()
    closed: Sequence[Cell] = ()


Pose = tuple[float, float, float]
"""A position x and y in metres, and a heading."""

MAX_RAYS = 1_000
"""Most rays of a scan."""

SCAN_RANGE = 10.0
"""Metres beyond which a scan sees nothing."""


class BatchOutcome(NamedTuple):
    """The outcome of one action of each robot; the arrays belong to the caller.

    Attributes:
        cells: ``[N]`` intp, where the robots are now.
        blocked: ``[N]`` bool, whether something stopped the robot on its way to another cell.
        seconds: ``[N]`` float64, duration of each action.
        joules: ``[N]`` float64, cost of each action.
        stopped_by: ``[N]`` intp, what stopped the robot: ``NOTHING``, ``WALL``, or the number of
            another robot on its floor. ``None`` if robots are alone and only walls block them.
        ends: ``[N]`` intp, where their next moves begin, of a motion that drives
            through. ``None``: where they are.
        driving: ``[N]`` bool, whether the robot has not come to rest, so that it can neither pick,
            drop nor charge. ``None``: all are at rest after each action.
        failed: ``[N]`` bool, whether the robot stays where it is for good. ``None``: none can.

    Example:
        >>> import numpy as np
        >>> from warehouse_core import DEFAULT_LAYOUT, GridMotion
        >>> motion = GridMotion().batch([DEFAULT_LAYOUT, DEFAULT_LAYOUT])
        >>> motion.place(np.array([0, 1]), np.array([13, 14]), [None, None])
        >>> outcome = motion.advance(np.array([1, 0]), np.array([False, False]))
        >>> outcome.cells, outcome.blocked
        (array([14, 14]), array([False,  True]))
    """

    cells: NDArray[np.intp]
    blocked: Flags
    seconds: NDArray[np.float64]
    joules: NDArray[np.float64]
    stopped_by: NDArray[np.intp] | None = None
    ends: NDArray[np.intp] | None = None
    driving: Flags | None = None
    failed: Flags | None = None


class BatchMotion(Protocol):
    """The interface of a motion of ``R`` robots in each of ``B`` layouts.

    Example:
        >>> from warehouse_core import DEFAULT_LAYOUT, GridMotion
        >>> from warehouse_core.motion import BatchMotion
        >>> motion: BatchMotion = GridMotion().batch([DEFAULT_LAYOUT, DEFAULT_LAYOUT])
    """

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Put the robots of some floors at rest in the middle of their cells, heading east.

        Args:
            rows: ``[F * R]``, all robots of ``F`` different floors, in order on each floor.
            cells: ``[F * R]``, for each of them an open cell of its layout, on a floor all
                different. A backend need not check either.
            seeds: ``F``, for the backend's random numbers on each of these floors; ``None`` lets
                the backend choose.
        """

    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Carry out one action for each robot; all must have been placed.

        Args:
            actions: ``[N]``, indices into ``DISPLACEMENTS``.
            loaded: ``[N]``, whether the robot carries an item.

        Raises:
            RuntimeError: after ``close``.
        """

    def close(self) -> None:
        """Release resources; safe to call twice."""


class BaseBatchMotion(BatchMotion):
    """A base class of batch motions, with a default for everything that one need not do.

    Attributes:
        changes_layouts: ``True`` if ``change`` replaces the layouts of floors; pools need it.

    Example:
        >>> from warehouse_core import DEFAULT_LAYOUT, GridMotion
        >>> from warehouse_core.motion import BaseBatchMotion
        >>> batch = GridMotion().batch([DEFAULT_LAYOUT])
        >>> isinstance(batch, BaseBatchMotion), batch.changes_layouts
        (True, True)
    """

    changes_layouts: bool = False

    def outcomes(self, floor: int) -> Sequence[Outcome]:
        """Return what the last ``advance`` did on one floor, with paths and contacts.

        A batch of lone robots need not tell that.

        Raises:
            RuntimeError: the robots of the floor have not moved since they were placed.
        """
        return ()

    def change(self, floors: Integers, layouts: Sequence[Layout]) -> None:
        """Replace the layouts of different floors by others of their sizes.

        The robots there must be placed before they move.
        """

    def face(self, actions: Integers) -> None:
        """Let robots that stay in their cells turn in the next ``advance``; by default they wait.

        Args:
            actions: ``[N]``, indices into ``DISPLACEMENTS`` of the directions that the robots turn
                to; ``WAIT`` for those that do not turn.
        """

    def fail(self, rows: Integers) -> None:
        """Let robots stay where they are for good; see ``BaseMotion.fail``."""


class BaseMotion(Motion):
    """A base class of motions, with a default for everything that a motion need not do.

    A motion that does not derive from it is used ``with_defaults``.

    Attributes:
        conditions: conditions of floor and motors, which are recorded and drawn in replays.
        cell_steps: calls of ``advance`` in which a robot crosses a cell at top speed.
        cell_joules: joules that a robot should expect to use for a cell; ``None`` for the nominal
            cost.
        drives_through: ``True`` if robots drive through the cells of routes ahead of them, see
            ``Routes``. A displacement then does not move a robot from where it is. It appends a
            cell to the end of its route; a robot whose route has no room for the cell waits. A call
            of ``advance`` may end while robots drive.

    Example:
        >>> from warehouse_core.motion import BaseMotion
        >>> from warehouse_physics import DrivingMotion, RigidBodyMotion
        >>> BaseMotion.drives_through, DrivingMotion.drives_through
        (False, True)
        >>> isinstance(RigidBodyMotion(), BaseMotion)
        True
    """

    conditions: Conditions = Conditions()
    cell_steps: float = 1.0
    cell_joules: float | None = None
    drives_through: bool = False

    def face(self, directions: Sequence[Cell]) -> None:
        """Let robots that stay in their cells turn in the next ``advance``; by default they wait.

        Args:
            directions: displacement of a move in the direction that each robot turns to, the
                shorter way round; ``(0, 0)`` for robots that do not turn.

        Raises:
            ValueError: another number of directions than robots, or another displacement; nothing
                has changed.
            RuntimeError: before ``reset`` or after ``close``.
        """

    def routes(self) -> Routes:
        """Return the route ahead of each robot if the motion ``drives_through``.

        Raises:
            RuntimeError: before ``reset`` or after ``close``.
        """
        return Routes((), (), ())

    def fail(self, robot: int) -> None:
        """Let a robot brake and stay where it is for good; without ``drives_through``, do nothing.

        Robots that are then caught between others, with no cell to come to rest in, fail too.

        Raises:
            RuntimeError: before ``reset`` or after ``close``.
        """

    def scan(self, robot: int, rays: int) -> NDArray[np.float64] | None:
        """Return how far walls and other robots are in ``rays`` directions.

        Args:
            robot: number of the robot.
            rays: number of directions, at equal angles: the first leads east, the others follow
                towards south, whatever the heading of the robot is.

        Returns:
            ``[rays]`` metres from the middle of the robot, ``SCAN_RANGE`` if nothing is nearer;
            ``None`` for robots without sensors.

        Raises:
            ValueError: there is no such robot, or no ray.
            RuntimeError: before ``reset`` or after ``close``.
        """
        return None

    def odometry(self, robot: int) -> Pose | None:
        """Return where a robot believes to be, or ``None`` without odometry.

        Raises:
            ValueError: there is no such robot.
            RuntimeError: before ``reset`` or after ``close``.
        """
        return None

    def batch(self, layouts: Sequence[Layout]) -> BatchMotion | None:
        """Return a motion for a lone robot in each of these layouts, or ``None`` if it has none.

        Raises:
            ValueError: the settings of this motion do not allow a batch.
        """
        return None

    def fleet_batch(self, layouts: Sequence[Layout], robots: int) -> BatchMotion | None:
        """Return a motion for so many robots, at least 1, in each layout, or ``None``.

        Raises:
            ValueError: the settings of this motion do not allow a batch of so many robots.
        """
        return None


def with_defaults(motion: Any, base: Any = BaseMotion) -> Any:
    """Return a motion with the defaults of a base class for everything that it lacks.

    A motion that derives from the base class, ``BaseMotion`` or ``BaseBatchMotion``, is
    returned itself.
    """
    if isinstance(motion, base):
        return motion
    complete = base.__new__(base)
    for name in (*Motion.__annotations__, *dir(base)):
        if not name.startswith("_") and hasattr(motion, name):
            setattr(complete, name, getattr(motion, name))
    return complete


def conditions_of(motion: object, layout: Layout) -> Conditions:
    """Return the conditions of a motion in a layout; only open cells may be slippery."""
    slippery, strength = with_defaults(motion).conditions
    return Conditions(tuple(filter(layout.is_open, sorted(slippery))), float(strength))


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
