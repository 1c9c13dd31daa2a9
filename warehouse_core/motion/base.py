"""The interface of motions, which carry out moves, and the outcomes that they return.

A *motion* moves ``R`` robots at once. In the chapter's environment ``R = 1``. A motion knows walls
and robots, but no rewards, items or batteries. Those belong to ``task/rules.py``, which reads only
``cell`` and ``blocked`` of an outcome.

A *position* is ``(x, y)`` in metres, with ``x = (col + 0.5) * cell_size`` and
``y = (row + 0.5) * cell_size``. Like rows, y grows downward. A *heading* is an angle in radians
from the x axis towards the y axis: 0 is east and pi/2 is south.

A *batch motion* moves ``R`` robots in each of ``B`` layouts. Floor ``b`` of the batch has the same
``cell`` and ``blocked`` as a separate motion in ``layouts[b]``. The arrays have a row for each of
the ``N = B * R`` robots, floor by floor: robot ``r`` of floor ``b`` is row ``b * R + r``. Here
the cell of a robot is a number ``row * W + col``, where ``W`` is the width of its layout.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import BackendError, LayoutError
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tables import Flags, Integers
from warehouse_core.world.tiles import Cell

WALL_CONTACT = "wall"

NOTHING, WALL = -1, -2
"""Values of ``stopped_by`` that are not robots. The robots of a floor have numbers from 0."""


EVERYWHERE = "all"
"""Value of ``slippery`` for a floor that is slippery in all open cells."""


class Conditions(NamedTuple):
    """Known conditions of the floor, the motors and the drive of a motion.

    Attributes:
        slippery: cells with slippery floor, or ``EVERYWHERE``.
        motor_strength: actual share of the nominal motor force, 0 to 1.
        drive: drive of the robots, such as ``"differential"``; "" for robots without a body.

    Example:
        >>> from warehouse_core.motion import Conditions
        >>> Conditions(slippery=((4, 5),))
        Conditions(slippery=((4, 5),), motor_strength=1.0, drive='')
    """

    slippery: tuple[Cell, ...] | str = ()
    motor_strength: float = 1.0
    drive: str = ""


def robot_contact(robot: int) -> str:
    """Return the name that a robot has as the counterpart of a contact."""
    return f"robot {robot}"


class Contact(NamedTuple):
    """A hit during a motion.

    Attributes:
        seconds: time of the hit since the start of the motion.
        impulse: impulse in N·s, above 0. It is the speed of approach right before the hit, times
            the mass of the robot, or the reduced mass of two robots. It does not include the force
            of motors during and after the hit, nor the push of other bodies.
        point: position ``(x, y)`` of the hit in metres.
        counterpart: body that was hit, such as ``"wall"`` or ``"robot 3"``.

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
    """The outcome of one action of one robot, with the same fields for every backend.

    Attributes:
        cell: cell of the robot after the action.
        blocked: ``True`` if something stopped the robot before it reached its target cell.
        seconds: duration of the action.
        joules: energy that the action used.
        path: ``[K, 4]`` float64, read-only, with ``K >= 2``. Each row has the time since the start
            of the motion in seconds, x, y and heading. The first row is the start of the
            motion, and the last row is its end.
        contacts: all hits in order of time. A blocked robot has at least one, unless it gave way to
            a robot that came back to the target cell before they touched.
        cut_off: ``True`` if the action took too long and was ended before the robot was at rest
            where it had to be. All values are those at that moment.
        readings: ``[K, 5]`` float64, read-only, with one row per row of ``path``: the velocity
            ``(vx, vy)`` in m/s, the force of the motor ``(fx, fy)`` in N in the substep that ends
            then, and the energy used since the start of the motion in J. ``None`` for backends that
            do not measure them, such as the grid.
        lines: ``[N, 5]`` float64, read-only: straight lines around the robot at the end of the
            motion, first the rays of its range scan and then the outlines of crates, people and
            other bodies. Each row has 1 for a ray and 0 for a part of an outline, and then
            the ends of the line in metres. ``None`` for backends without such things.

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
    readings: NDArray[np.float64] | None = None
    lines: NDArray[np.float64] | None = None

    def copy(self) -> Outcome:
        """Return a copy of the outcome, with copies of its arrays."""
        cell, blocked, seconds, joules, path, contacts, cut_off, readings, lines = self
        if readings is not None:
            readings = readings.copy()
        if lines is not None:
            lines = lines.copy()
        # Each step of a Gymnasium environment copies one, and _replace takes twice as long.
        path = path.copy()
        return Outcome(cell, blocked, seconds, joules, path, contacts, cut_off, readings, lines)

    def __eq__(self, other: object) -> bool:
        # Tuples compare with ==, which for paths returns an array without a truth value.
        if not isinstance(other, Outcome):
            return NotImplemented
        pairs: Any = zip(self, other, strict=True)
        return all(
            np.array_equal(mine, others)
            if isinstance(mine, np.ndarray) or isinstance(others, np.ndarray)
            else mine == others
            for mine, others in pairs
        )

    def __ne__(self, other: object) -> bool:
        return not self == other  # otherwise the __ne__ of tuple would be used

    def __hash__(self) -> int:
        return hash(
            (self.cell, self.blocked, self.seconds, self.joules, self.contacts, self.cut_off)
        )


@runtime_checkable
class Motion(Protocol):
    """The interface of motion backends; ``warehouse_core/conformance`` checks implementations.

    Example:
        >>> from warehouse_core import GridMotion, Motion
        >>> motion: Motion = GridMotion()
        >>> isinstance(motion, Motion)
        True
    """

    cell_size: float
    """Side of a cell in metres."""

    def reset(self, layout: Layout, cells: Sequence[Cell], seed: int | None) -> None:
        """Place ``R = len(cells)`` robots at rest in the middle of their cells, heading east.

        Nothing changes if an error is raised.

        Args:
            layout: layout with the walls.
            cells: open cell of each robot, all different.
            seed: seed of the backend's random numbers; ``None`` lets the backend choose one.

        Raises:
            LayoutError: a cell is a wall, is off the grid, or is given twice, or there are no
                cells.
        """

    def advance(self, displacements: Sequence[Cell], loaded: Sequence[bool]) -> Sequence[Outcome]:
        """Carry out one action for each robot, all at the same time.

        Args:
            displacements: rows and columns to move for each robot: ``(0, 0)``, or one cell north,
                east, south or west.
            loaded: flag of each robot that carries an item.

        Returns:
            The outcome for each robot.

        Raises:
            ValueError: the number of arguments differs from the number of robots, or a displacement
                is not allowed. Nothing has changed.
            RuntimeError: the motion has not been reset, or is closed.
        """

    def close(self) -> None:
        """Release resources; safe to call twice."""


class Routes(NamedTuple):
    """The routes of ``R`` robots: the cells that they have yet to drive through.

    Attributes:
        ends: last cell of each route, where the next move of the robot begins. All are different,
            except that two failed robots may stand between the same two cells.
        has_room: ``True`` for each route that the next move may extend.
        at_rest: ``True`` for each robot that is at rest at the end of its route. Only then can it
            pick, drop or charge.
        failed: ``True`` for each robot that has stopped for good.
        closed: cells that nobody can enter because a failed robot occupies at least a part of them.
    """

    ends: Sequence[Cell]
    has_room: Sequence[bool]
    at_rest: Sequence[bool]
    failed: Sequence[bool] = ()
    closed: Sequence[Cell] = ()


Pose = tuple[float, float, float]
"""Position x and y in metres, and heading in radians."""

MAX_RAYS = 1_000
"""Limit on the rays of a scan."""

SCAN_RANGE = 10.0
"""Range of a scan in metres."""


class BatchOutcome(NamedTuple):
    """The outcomes of one action of each robot, in arrays that belong to the caller.

    Attributes:
        cells: ``[N]`` intp, cells of the robots after the action.
        blocked: ``[N]`` bool, ``True`` if something stopped the robot before its target cell.
        seconds: ``[N]`` float64, duration of each action.
        joules: ``[N]`` float64, energy that each action used.
        stopped_by: ``[N]`` intp, obstacle of each robot: ``NOTHING``, ``WALL``, or the number of
            another robot on its floor. ``None`` if each robot is alone and only walls can block it.
        ends: ``[N]`` intp, cells where the next moves begin, for motions that drive through.
            ``None`` if they begin in ``cells``.
        driving: ``[N]`` bool, ``True`` for robots that are not at rest. They cannot pick, drop or
            charge. ``None`` if all robots are at rest after each action.
        failed: ``[N]`` bool, ``True`` for robots that have stopped for good. ``None`` if robots
            cannot fail.

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
    """The interface of motions of ``R`` robots in each of ``B`` layouts.

    Example:
        >>> from warehouse_core import DEFAULT_LAYOUT, GridMotion
        >>> from warehouse_core.motion import BatchMotion
        >>> motion: BatchMotion = GridMotion().batch([DEFAULT_LAYOUT, DEFAULT_LAYOUT])
    """

    def place(
        self, rows: Integers, cells: Integers, seeds: Sequence[int | None] | None = None
    ) -> None:
        """Place the robots of some floors at rest in the middle of their cells, heading east.

        Backends need not check the arguments.

        Args:
            rows: ``[F * R]``, all robots of ``F`` different floors, in order on each floor.
            cells: ``[F * R]``, an open cell for each of these robots, all different on a floor.
            seeds: ``[F]`` seed of the backend's random numbers on each of these floors; ``None``
                lets the backend choose.
        """

    def advance(self, actions: Integers, loaded: Flags) -> BatchOutcome:
        """Carry out one action for each robot; all robots must have been placed.

        Args:
            actions: ``[N]`` index into ``DISPLACEMENTS`` for each robot.
            loaded: ``[N]`` flag of each robot that carries an item.

        Raises:
            RuntimeError: the motion is closed.
        """

    def close(self) -> None:
        """Release resources; safe to call twice."""


class BaseBatchMotion(BatchMotion):
    """A base class of batch motions, with a default for every optional part.

    Attributes:
        changes_layouts: ``True`` if ``change`` can replace the layouts of floors. Pools of layouts
            need this.

    Example:
        >>> from warehouse_core import DEFAULT_LAYOUT, GridMotion
        >>> from warehouse_core.motion import BaseBatchMotion
        >>> batch = GridMotion().batch([DEFAULT_LAYOUT])
        >>> isinstance(batch, BaseBatchMotion), batch.changes_layouts
        (True, True)
    """

    changes_layouts: bool = False

    def outcomes(self, floor: int) -> Sequence[Outcome]:
        """Return the last outcomes of the robots on one floor, with paths and contacts.

        Batches of single robots need not support this, and may return nothing.

        Raises:
            RuntimeError: the robots of the floor have not moved since they were placed.
        """
        return ()

    def change(self, floors: Integers, layouts: Sequence[Layout]) -> None:
        """Replace the layouts of different floors with others of the same sizes.

        The robots on these floors must be placed before they move.
        """

    def face(self, actions: Integers) -> None:
        """Let robots that stay in their cells turn in the next ``advance``; by default they wait.

        Args:
            actions: ``[N]`` index into ``DISPLACEMENTS`` of each robot's new direction; ``WAIT``
                for robots that do not turn.
        """

    def fail(self, rows: Integers) -> None:
        """Stop some robots for good; see ``BaseMotion.fail``."""


class BaseMotion(Motion):
    """A base class of motions, with a default for every optional part.

    Motions that do not derive from it get these defaults from ``with_defaults``.

    Attributes:
        conditions: conditions of floor and motors. Records store them, and replays show them.
        cell_steps: number of calls of ``advance`` in which a robot at top speed crosses a cell.
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
            directions: new direction of each robot, as the displacement of a move. The robot turns
                by the smaller angle. ``(0, 0)`` stands for robots that do not turn.

        Raises:
            ValueError: the number of directions differs from the number of robots, or a direction
                is not allowed. Nothing has changed.
            RuntimeError: the motion has not been reset, or is closed.
        """

    def routes(self) -> Routes:
        """Return the route ahead of each robot if the motion ``drives_through``.

        Raises:
            RuntimeError: the motion has not been reset, or is closed.
        """
        return Routes((), (), ())

    def fail(self, robot: int) -> None:
        """Make a robot brake and stop for good; without ``drives_through``, do nothing.

        Other robots fail too if they have no cell left in which they can come to rest.

        Raises:
            RuntimeError: the motion has not been reset, or is closed.
        """

    def drive_episode(self, episode: Any) -> Any:
        """Return a record in which bodies drive the cells of a lone robot's ``Episode`` in one go.

        Raises:
            BackendError: the motion cannot do this.
        """
        raise BackendError(
            f"{type(self).__name__} cannot drive the cells of a record in one go; it has no "
            "drive_episode()"
        )

    def scan(self, robot: int, rays: int) -> NDArray[np.float64] | None:
        """Return the distances to walls and other robots in ``rays`` directions.

        Args:
            robot: number of the robot.
            rays: number of directions, at equal angles. The first is east and the second is further
                towards south, whatever the heading of the robot is.

        Returns:
            ``[rays]`` distances in metres from the middle of the robot, at most ``SCAN_RANGE``;
            ``None`` for robots without sensors.

        Raises:
            ValueError: the robot does not exist, or ``rays`` is less than 1.
            RuntimeError: the motion has not been reset, or is closed.
        """
        return None

    def odometry(self, robot: int) -> Pose | None:
        """Return the pose that a robot estimates by odometry, or ``None`` without odometry.

        Raises:
            ValueError: the robot does not exist.
            RuntimeError: the motion has not been reset, or is closed.
        """
        return None

    def batch(self, layouts: Sequence[Layout]) -> BatchMotion | None:
        """Return a motion for one robot in each of these layouts, or ``None`` if unsupported.

        Raises:
            ValueError: the settings of this motion do not allow a batch.
        """
        return None

    def fleet_batch(self, layouts: Sequence[Layout], robots: int) -> BatchMotion | None:
        """Return a motion for ``robots`` robots, at least 1, in each layout, or ``None``.

        Raises:
            ValueError: the settings of this motion do not allow such a batch.
        """
        return None


def with_defaults(motion: Any, base: Any = BaseMotion) -> Any:
    """Return a motion with the defaults of a base class for all parts that it lacks.

    A motion that derives from the base class is returned unchanged. The base class is
    ``BaseMotion`` or ``BaseBatchMotion``.
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
    slippery, strength, drive = Conditions(*with_defaults(motion).conditions)
    is_everywhere = isinstance(slippery, str) and slippery == EVERYWHERE
    cells: list[Any] = layout.cells(layout.open_cells) if is_everywhere else [*slippery]
    return Conditions(tuple(filter(layout.is_open, sorted(cells))), float(strength), drive)


def centre_of(cell: Cell, cell_size: float) -> tuple[float, float]:
    """Return the position of the middle of a cell in metres."""
    row, col = cell
    return (col + 0.5) * cell_size, (row + 0.5) * cell_size


def check_starts(layout: Layout, cells: Sequence[Cell]) -> None:
    """Raise an error if robots cannot be placed in these cells; backends call it in ``reset``.

    Raises:
        LayoutError: a cell is not open or is given twice, or there are no cells.
    """
    if not cells:
        raise LayoutError("no robots: cells is empty; it needs a cell for each robot")
    robot_in: dict[Cell, int] = {}
    for robot, cell in enumerate(cells):
        check_open(layout, cell, f"robot {robot}:")
        first = robot_in.setdefault(cell, robot)
        if first != robot:
            raise LayoutError(f"robots {first} and {robot} are both placed in {cell}")


_ALLOWED = frozenset(DISPLACEMENTS)


def check_directions(robots: int, directions: Sequence[Cell]) -> None:
    """Raise an error unless there is a valid direction per robot; backends call it in ``face``.

    Raises:
        ValueError: the number of directions is wrong, or a direction is not allowed.
    """
    if len(directions) != robots:
        raise ValueError(f"{len(directions)} directions for {robots} robots; each robot needs one")
    _check_displacements("direction", directions)


def check_moves(robots: int, displacements: Sequence[Cell], loaded: Sequence[bool]) -> None:
    """Raise an error unless there is a valid action per robot; backends call it in ``advance``.

    Raises:
        ValueError: the number of actions is wrong, or a displacement is not allowed.
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
