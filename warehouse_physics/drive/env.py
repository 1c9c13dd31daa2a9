"""One warehouse under continuous control as a ``gymnasium.Env``: ``WarehouseDrive-v0``."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import fields
from functools import partial
from typing import Any, NoReturn, Self

import gymnasium
import numpy as np
import pymunk
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import ArrayLike, NDArray

from warehouse_core import Cell, Layout, Outcome
from warehouse_core.arguments import (
    as_cell,
    instance_of,
    real_number,
    seed_number,
    whole_number,
)
from warehouse_core.gymnasium_env.env import ENDED, UNSTARTED
from warehouse_core.gymnasium_env.spaces import RENDER_FPS, check_options, check_render_mode
from warehouse_core.motion.backends import read_numbers
from warehouse_core.motion.base import MAX_RAYS, Contact
from warehouse_core.records.episode import DRIVE
from warehouse_core.render.painter import TilePainter, tile_pixels_for
from warehouse_core.task.settings import Settings
from warehouse_core.task.sight import Sight
from warehouse_core.task.starts import randomized_parts
from warehouse_core.task.state import Observation
from warehouse_core.wording import brief
from warehouse_core.world.layout import check_open
from warehouse_core.world.named_layouts import GivenLayout, as_layout
from warehouse_physics.disturbances import SETTINGS, SLIPPERY, Disturbances
from warehouse_physics.drive.drives import VELOCITY, drive_of
from warehouse_physics.drive.observations import VECTOR, DriveForm
from warehouse_physics.drive.people import Person
from warehouse_physics.drive.picture import outlines_of, picture_of
from warehouse_physics.drive.recording import DriveRecorder
from warehouse_physics.drive.rows import BUDGET, DriveRows, DriveSettings, DriveStep, settings_of
from warehouse_physics.drive.things import Things
from warehouse_physics.energy import move_joules
from warehouse_physics.spec import DIFFERENTIAL, RobotSpec

VIEW_RADIUS = 2
"""Cells that a grid agent sees in each direction, as in the chapter."""

MIN_RATE, MAX_RATE = 1.0, 1_000.0
"""Limits of the control steps in a second."""

LEAST, MOST = 1e-3, 1e9
"""Limits of the seconds of an episode and of the joules of a battery."""

OWN = "own=1"
"""Mark in a name for bodies and obstacles that ``from_name`` cannot make."""

WORDS = ("control", "drive", SLIPPERY)
NUMBERS = ("rate", "rays", "max_seconds", "battery", "crates", "people")


class DriveEnv(gymnasium.Env[Any, Any]):
    """The environment ``WarehouseDrive-v0``: a robot that is driven and keeps its momentum.

    Description:
        A robot takes an item from a pickup to a dropoff, as in ``WarehouseEnv``, but its body is
        controlled continuously. Forces, speeds and accelerations are limited by the ``RobotSpec``,
        so that a command is not yet a motion. The same seed gives the same stations and start as
        ``WarehouseEnv.reset(randomize=True, seed=...)``.

    Actions:
        ``Box(-1, 1, (2,))``. Its meaning depends on ``control`` and on the drive of the robot:

        ==============  =================================  =====================================
        ``control``     two wheels                         a disc that drives in any direction
        ==============  =================================  =====================================
        ``"velocity"``  speed ahead and turn rate, as      velocity to the east and to the south,
                        shares of the largest ones         as shares of the top speed
        ``"wheels"``    speed of the left and of the       not possible
                        right wheel
        ``"force"``     force ahead, and difference of     force to the east and to the south, as
                        the forces of the wheels           shares of the force of the motor
        ==============  =================================  =====================================

        A turn rate above 0 turns to the right. If both numbers together ask for too much, both are
        reduced by the same factor.

    Observations:
        Numbers in a ``Box`` or a ``Dict``; see ``observations.py``.

    Rewards:
        The events of the chapter: picking, dropping, a penalty for time, and one for hits that is
        proportional to their impulse; see ``rows.py``.

    Ends:
        Terminated when the item is delivered. Truncated when ``max_seconds`` have passed or the
        battery is empty.

    Args:
        layout: layout in any form that ``Warehouse-v0`` takes; ``None`` is the chapter's layout.
        control: quantity that actions command.
        spec: numbers of the robot; ``None`` is the default robot with two wheels.
        disturbances: deviations from the nominal physics; ``None`` is no deviation.
        rate: actions in a second, 1 to 1,000.
        rays: number of rays of the range scan, 0 to ``MAX_RAYS``.
        observation: ``"vector"`` or ``"dict"``.
        randomize: random parts of an episode, like in ``Warehouse-v0``.
        start_pos: start of the robot if it is not random; ``None`` is the default start.
        max_seconds: limit of an episode; ``None`` is the time of 200 moves over one cell.
        battery: joules of a full battery; ``None`` is the energy of 200 moves over one cell.
        crates: number of crates in random cells, or their cells.
        people: number of people, who start in random cells and walk at random; see ``people.py``.
        obstacles: pillars ``(x, y, radius)`` and convex polygons ``[(x, y), ...]``, in metres.
        on_reset: function that gets each new ``pymunk.Space`` and may add bodies, joints and
            collision handlers to it. The robot is its first body: ``next(iter(space.bodies))``.
        render_mode: ``"rgb_array"`` or ``None``.

    Attributes:
        space: the live ``pymunk.Space`` of the episode. Each reset creates a new one and moves
            bodies into it that were added by hand.
        robot: the body of the robot.
        last_motion: ``Outcome`` of the last step, with a row of its path for each substep.

    Raises:
        ValueError: an argument is not allowed; it may be a ``LayoutError``.
        TypeError: an argument has the wrong type.

    Example:
        >>> import gymnasium
        >>> env = gymnasium.make("warehouse_physics.drive:WarehouseDrive-v0")
        >>> observation, info = env.reset(seed=1)
        >>> observation, reward, terminated, truncated, info = env.step([1.0, 0.2])
        >>> observation.shape, round(reward, 3)
        ((29,), -0.005)
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - declared this way in Gymnasium
        "render_modes": ["rgb_array"],
        "render_fps": RENDER_FPS,
    }

    def __init__(
        self,
        layout: GivenLayout | None = None,
        control: str = VELOCITY,
        *,
        spec: RobotSpec | None = None,
        disturbances: Disturbances | None = None,
        rate: float = 10.0,
        rays: int = 16,
        observation: str = VECTOR,
        randomize: bool | str = True,
        start_pos: Cell | None = None,
        max_seconds: float | None = None,
        battery: float | None = None,
        crates: int | Sequence[Cell] = 0,
        people: int = 0,
        obstacles: Sequence[Any] = (),
        on_reset: Callable[[pymunk.Space], object] | None = None,
        render_mode: str | None = None,
    ) -> None:
        check_render_mode(render_mode, self.metadata["render_modes"])
        self.drive_settings = checked_settings(
            layout, control, spec, disturbances, rate, rays,
            randomize=randomize, start_pos=start_pos, max_seconds=max_seconds, battery=battery,
        )  # fmt: skip
        open_cells = len(self.drive_settings.layout.open_cells)
        self._things = Things(crates, people, obstacles, on_reset, most=open_cells)
        self._form = DriveForm(observation, self.drive_settings)
        self.observation_space = self._form.space
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.render_mode = render_mode
        self._given = {"rate": rate, "rays": rays, "max_seconds": max_seconds, "battery": battery}
        self._robot_given = spec or RobotSpec(drive=DIFFERENTIAL)
        self._sight = Sight(VIEW_RADIUS)
        self._painter: TilePainter | None = None
        self._ours: set[Any] = set()
        self._has_foreign = False
        self._rows = DriveRows(self.drive_settings, 1)
        self.last_motion: Outcome | None = None
        self.last_action: tuple[float, float] = (0.0, 0.0)
        self._over = UNSTARTED

    def __deepcopy__(self, memo: object = None) -> NoReturn:
        raise TypeError(
            "a space of bodies cannot be copied exactly, so DriveEnv cannot be copied or pickled; "
            "make another one, reset it with the same seed and repeat the actions"
        )

    __copy__ = __reduce__ = __deepcopy__

    @classmethod
    def from_name(
        cls,
        name: str,
        layout: GivenLayout | None = None,
        *,
        moves: int = BUDGET,
        units: int = BUDGET,
        **others: Any,
    ) -> Self:
        """Return an environment with the settings in a name such as ``drive:control=wheels``.

        A name may set numbers of the robot and disturbances, as in ``physics:mass=70``, and also
        ``control``, ``rate``, ``rays``, ``max_seconds``, ``battery``, ``crates`` and ``people``.

        Args:
            name: name with settings.
            layout: see ``DriveEnv``, as the ``others``.
            moves: limit of an episode without ``max_seconds``: the time of these moves over a cell.
            units: full battery without ``battery``: the energy of these moves over a cell.
            others: further arguments of ``DriveEnv``.

        Raises:
            ValueError: a setting is unknown or its value is not allowed.
        """
        settings = name.partition(":")[2]
        given: dict[str, Any] = read_numbers(settings, WORDS) if settings else {}
        own_names = ("control", *NUMBERS)
        known = (*SETTINGS, *own_names)
        robot = {"drive": DIFFERENTIAL} | {k: v for k, v in given.items() if k not in known}
        trouble = {key: value for key, value in given.items() if key in SETTINGS}
        own = {key: value for key, value in given.items() if key in own_names}
        for key in ("rays", "crates", "people"):
            if key in own:
                if not own[key].is_integer():
                    raise ValueError(f"{key} is {own[key]}; it must be a whole number")
                own[key] = int(own[key])
        spec = RobotSpec.from_numbers(robot, known)
        if moves != BUDGET:
            own.setdefault("max_seconds", moves * spec.move_seconds(loaded=False))
        if units != BUDGET:
            own.setdefault("battery", units * move_joules(spec, loaded=True))
        disturbances = Disturbances.from_settings(trouble)
        return cls(layout, spec=spec, disturbances=disturbances, **own, **others)

    @property
    def space(self) -> pymunk.Space:
        """The live space of the present episode."""
        return self._arena.space

    @property
    def robot(self) -> pymunk.Body:
        """The body of the robot."""
        return self._rows.bodies.body(0)

    @property
    def layout(self) -> Layout:
        """The layout of the present episode, with its stations."""
        return self._rows.layouts[0]

    @property
    def robot_spec(self) -> RobotSpec:
        """The robot, with the substep that is used."""
        return self.drive_settings.spec

    @property
    def pose(self) -> tuple[float, float, float]:
        """Where the robot believes to be: x and y in metres and the heading in radians."""
        x, y, heading = self._rows.poses()[0].tolist()
        return x, y, heading

    @property
    def velocity(self) -> tuple[float, float]:
        """The velocity of the robot in m/s, to the east and to the south."""
        right, down = self._rows.state.velocities[0].tolist()
        return right, down

    @property
    def turn_rate(self) -> float:
        """The turn rate of the robot in rad/s, positive to the right."""
        return float(self._rows.state.turn_rates[0])

    @property
    def cell(self) -> Cell:
        """The cell under the middle of the robot."""
        row, col = self._rows.cells()[0].tolist()
        return row, col

    @property
    def has_item(self) -> bool:
        """Whether the robot carries an item."""
        return bool(self._rows.has_item[0])

    @property
    def battery(self) -> float:
        """Joules left in the battery."""
        return float(self._rows.batteries[0])

    @property
    def seconds(self) -> float:
        """Seconds since the start of the episode."""
        return float(self._rows.seconds[0])

    @property
    def backend(self) -> str:
        """Name with all settings that ``from_name`` needs to make this environment again."""
        settings, default = self.drive_settings, RobotSpec(drive=DIFFERENTIAL)
        parts = [] if settings.control == VELOCITY else [f"control={settings.control}"]
        parts += [
            f"{each.name}={getattr(self._robot_given, each.name)}"
            for each in fields(RobotSpec)
            if getattr(self._robot_given, each.name) != getattr(default, each.name)
        ]
        parts += _named_disturbances(settings.disturbances)
        defaults = {"rate": 10.0, "rays": 16, "max_seconds": None, "battery": None}
        parts += [f"{key}={value}" for key, value in self._given.items() if value != defaults[key]]
        things = {"crates": self._things.crates, "people": self._things.people}
        parts += [f"{key}={count}" for key, count in things.items()
                  if isinstance(count, int) and count]  # fmt: skip
        if self._things.are_own or self._has_foreign:
            parts.append(OWN)
        return f"{DRIVE}:{','.join(parts)}" if parts else DRIVE

    def start_recording(
        self, *, seed: int | None, agent: str, randomize: bool | str
    ) -> DriveRecorder:
        """Reset and return a recorder of the new episode; ``record_episode`` calls this."""
        own = self.drive_settings.randomize
        randomized_parts(randomize)
        if randomize not in (True, own):
            raise ValueError(
                f"randomize is {brief(randomize)}; this DriveEnv was made with randomize={own!r}"
            )
        observation, _ = self.reset(seed=seed)
        return DriveRecorder(self, observation, seed=self._seed, agent=agent)

    @property
    def settings(self) -> Settings:
        """The settings for a record; the battery is in whole joules, and steps are actions."""
        drive = self.drive_settings
        conditions = drive.disturbances.conditions._replace(drive=drive.spec.drive)
        open_cells = set(self.layout.cells(self.layout.open_cells))
        slippery = conditions.slippery
        cells = sorted(open_cells) if isinstance(slippery, str) else slippery
        return Settings(
            backend=self.backend,
            cell_size=drive.spec.cell_size,
            start_pos=self._rows.starts[0],
            max_steps=max(1, round(drive.max_seconds * drive.rate)),
            battery=math.ceil(drive.battery),
            view_radius=VIEW_RADIUS,
            slippery=tuple(cell for cell in cells if cell in open_cells),
            motor_strength=conditions.motor_strength,
            drive=conditions.drive,
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: seed of the stations, the start, the crates, the people and the disturbances.
                ``None`` draws one from ``np_random``.
            options: ``layout`` (with the same walls) and ``start_pos`` for this episode only; they
                replace the random ones.

        Raises:
            ValueError: an option is not allowed, or there is no room for crates or people.
            TypeError: a value has the wrong type.
        """
        options = check_options(options, {"layout", "start_pos"})
        try:
            super().reset(seed=seed_number(seed))
        except (TypeError, ValueError) as error:
            raise gymnasium.error.Error(str(error)) from None
        if seed is None:
            seed = int(self.np_random.integers(2**32))
        rows = DriveRows(self.drive_settings, 1)
        layout = options.get("layout")
        start = options.get("start_pos")
        rows.begin(
            [0],
            [seed],
            None if layout is None else as_layout(layout),
            None if start is None else as_cell("start_pos", start),
        )
        layout, start = rows.layouts[0], rows.starts[0]
        crates = self._things.cells(layout, start, seed)
        people = [
            Person(layout, self.robot_spec, rows.bodies.body(0), cell, f"{seed} person {number}")
            for number, cell in enumerate(self._things.people_in(layout, [start, *crates], seed))
        ]
        foreign = self._foreign()  # From here on, nothing is refused.
        self._rows, self._seed = rows, seed
        [self._arena] = rows.bodies.arenas
        self._things.fill(self._arena, self.robot_spec, crates, people)
        self._ours = {*_objects(self.space), self.space.static_body}
        for each in foreign:
            self.space.add(each)
        self._has_foreign = bool(foreign)
        self._sight.use(self.layout)
        self.last_motion, self._over = None, ""
        if self._things.exist or foreign:
            rows.scanner = partial(self._arena.scan, 0)
        return self._observation(), self._info(0.0, 0.0)

    def step(self, action: ArrayLike) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Carry out one action for the period of the controller.

        ``info`` has the ``cell`` of the robot, and the ``joules`` and the ``impulse`` of hits in
        N·s of this step.

        Raises:
            ValueError: the action does not have two finite numbers; nothing has changed.
            TypeError: the action has no numbers.
            ResetNeeded: there has been no reset, or the episode has ended.
        """
        actions = checked_actions(action, (2,))[None]
        if self._over:
            raise ResetNeeded(f"step(): {self._over}")
        before = self._rows.state
        self.last_action = (float(actions[0, 0]), float(actions[0, 1]))
        step = self._rows.step(actions, is_traced=True)
        self.last_motion = self._outcome(before, step)
        terminated, truncated = bool(step.terminated[0]), bool(step.truncated[0])
        if terminated or truncated:
            self._over = ENDED
        info = self._info(step.joules[0], step.impulses[0])
        return self._observation(), float(step.rewards[0]), terminated, truncated, info

    def observe(self) -> Observation:
        """Return what a grid agent sees in the cell of the robot, as in ``WarehouseEnv``.

        The battery is the share that is left, as units of a battery with 200 units, and the steps
        are the moves over one cell that would have taken as long.
        """
        layout, settings = self.layout, self.drive_settings
        share = self.battery / settings.battery
        return {
            "local_grid": self._sight.window(self.cell, self.has_item),
            "robot_pos": self.cell,
            "has_item": self.has_item,
            "battery": math.ceil(200 * share),
            "steps": int(self.seconds / settings.spec.move_seconds(loaded=False)),
            "pickup_pos": layout.pickups[0] if layout.pickups else None,
            "dropoff_pos": layout.dropoffs[0] if layout.dropoffs else None,
        }

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture ``[H, W, 3]`` uint8 of the warehouse, its things and the robot."""
        if self.render_mode is None:
            gymnasium.logger.warn("render() needs a render_mode, given to gymnasium.make")
            return None
        if self._painter is None:
            self._painter = TilePainter(tile_pixels_for(self.layout.height, self.layout.width))
        return picture_of(
            self._painter, self.layout, self.pose, self.has_item, self.robot_spec, self._visible()
        )

    def _visible(self) -> list[pymunk.Shape]:
        """Return the shapes of crates, obstacles, people and bodies of users."""
        ours = self._arena.walls | self.robot.shapes
        return [each for each in self.space.shapes if each not in ours and not each.sensor]

    def _observation(self) -> Any:
        observation = self._form.of(self._rows)
        if isinstance(observation, dict):
            return {key: values[0] for key, values in observation.items()}
        return observation[0]

    def _info(self, joules: float, impulse: float) -> dict[str, Any]:
        cell = np.array(self.cell, np.int64)
        return {"cell": cell, "joules": float(joules), "impulse": float(impulse)}

    def _foreign(self) -> list[Any]:
        """Take what was added by hand out of the old space, and return it, bodies first.

        Joints and shapes on bodies that end with the old space are left behind.
        """
        if not self._ours:
            return []
        foreign = [each for each in _objects(self.space) if each not in self._ours]
        self.space.remove(*foreign)
        return [each for each in foreign if not self._ours.intersection(_bodies_of(each))]

    def _outcome(self, before: Any, step: DriveStep) -> Outcome:
        """Return the outcome of a step, with a row of the path for each substep."""
        dt, turns = self.robot_spec.time_step, self.robot_spec.is_differential
        states = [before, *(state for state, _, _ in step.trace)]
        zero = np.zeros((1, 2)), np.zeros(1)
        forces = [step.trace[0][1], *(force for _, force, _ in step.trace)]
        used = [zero[1], *(joules for _, _, joules in step.trace)]
        rows = np.empty((len(states), 9))
        for number, (state, force, joules) in enumerate(zip(states, forces, used, strict=True)):
            (right, down), heading = state.velocities[0].tolist(), float(state.angles[0])
            if not turns and (right or down):
                heading = math.atan2(down, right)
            rows[number] = (
                number * dt, *state.positions[0], heading, right, down, *force[0],
                max(joules[0], 0.0),
            )  # fmt: skip
        ends = self._rows.ray_ends()[0] if self.drive_settings.rays else np.empty((0, 2))
        rays = np.column_stack([np.broadcast_to(rows[-1, 1:3], ends.shape), ends])
        outlines = outlines_of(self._visible())
        whole = np.concatenate([rays, outlines])
        lines = np.column_stack([np.arange(len(whole)) < len(rays), whole])
        rows.flags.writeable = lines.flags.writeable = False
        contacts = tuple(
            Contact(seconds, bump.impulse, bump.point, bump.counterpart)
            for seconds, bump in step.bumps
        )
        return Outcome(
            self.cell, bool(contacts), float(rows[-1, 0]), float(rows[-1, 8]), rows[:, :4],
            contacts, readings=rows[:, 4:], lines=lines,
        )  # fmt: skip


def checked_settings(
    layout: GivenLayout | None,
    control: str,
    spec: RobotSpec | None,
    disturbances: Disturbances | None,
    rate: float,
    rays: int,
    **others: Any,
) -> DriveSettings:
    """Return the settings for the arguments of ``DriveEnv``, after checking them."""
    layout = as_layout(layout)
    spec = RobotSpec(drive=DIFFERENTIAL) if spec is None else instance_of("spec", spec, RobotSpec)
    disturbances = (
        Disturbances()
        if disturbances is None
        else instance_of("disturbances", disturbances, Disturbances)
    )
    if disturbances.stops:
        raise ValueError(
            f"stops is {disturbances.stops}; it must be empty, since only DrivingMotion has them"
        )
    drive_of(spec, control, 1)
    randomized_parts(others["randomize"])
    for name in ("max_seconds", "battery"):
        if others[name] is not None:
            others[name] = real_number(name, others[name], LEAST, MOST)
    if others["start_pos"] is not None:
        others["start_pos"] = start = as_cell("start_pos", others["start_pos"])
        check_open(layout, start, "start_pos")
    rate = real_number("rate", rate, MIN_RATE, MAX_RATE)
    rays = whole_number("rays", rays, 0, MAX_RAYS)
    return settings_of(layout, control, spec, disturbances, rate, rays=rays, **others)


def checked_actions(actions: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return actions as a new array, limited to -1..1.

    Raises:
        ValueError: the shape is wrong, or a number is not finite.
        TypeError: they are not numbers.
    """
    try:
        given = np.asarray(actions)
        numbers = given.astype(np.float64)
    except Exception:  # rows of different lengths, or a user's ``__array__``
        raise TypeError(f"the action is {brief(actions)}; it must have numbers") from None
    if given.dtype.kind not in "iuf":
        raise TypeError(f"the action has the type {given.dtype}; it must have numbers")
    if numbers.shape != shape:
        raise ValueError(f"the action has the shape {numbers.shape}; it must be {shape}")
    if not np.isfinite(numbers).all():
        raise ValueError(f"the action is {brief(actions)}; its numbers must be finite")
    return np.clip(numbers, -1.0, 1.0)


def _objects(space: pymunk.Space) -> list[Any]:
    return [*space.bodies, *space.shapes, *space.constraints]


def _bodies_of(each: Any) -> list[Any]:
    """Return the bodies to which a shape or a joint belongs."""
    if isinstance(each, pymunk.Constraint):
        return [each.a, each.b]
    return [each.body] if isinstance(each, pymunk.Shape) else []


def _named_disturbances(disturbances: Disturbances) -> list[str]:
    """Return the settings with which ``Disturbances.from_settings`` makes these disturbances."""
    default, parts = Disturbances(), list[str]()
    for name, field in SETTINGS.items():
        value = getattr(disturbances, field)
        if value == getattr(default, field):
            continue
        if field == SLIPPERY and not isinstance(value, str):
            value = "+".join(f"{row}-{col}" for row, col in sorted(value))
        parts.append(f"{name}={value}")
    return parts
