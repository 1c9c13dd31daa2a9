"""A fleet of robots in one warehouse, with orders, chargers and people."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import seed_number, whole_number
from warehouse_core.batch.fleet_settings import Battery, FleetSettings, People
from warehouse_core.batch.fleets import FleetEngine
from warehouse_core.batch.tally import FleetMeasures
from warehouse_core.copies import CopiedWhole
from warehouse_core.errors import EndedError, OrderError
from warehouse_core.fleet.observation import FleetObservation, observation_of
from warehouse_core.motion.backends import Backend, make_motion
from warehouse_core.motion.base import BaseMotion, Outcome, Routes, conditions_of, with_defaults
from warehouse_core.orders.book import NONE, OrderBook
from warehouse_core.orders.order import Order, OrderArrays, Orders
from warehouse_core.renamed import Renamed
from warehouse_core.task.encoding import FleetArrays
from warehouse_core.wording import brief, counted
from warehouse_core.world.actions import INVALID
from warehouse_core.world.display import display
from warehouse_core.world.layout import DEFAULT_LAYOUT, Layout
from warehouse_core.world.moves import COMPASS
from warehouse_core.world.tables import Flags
from warehouse_core.world.tiles import Cell

ActionLike = str | SupportsIndex
Actions = Sequence[ActionLike] | NDArray[Any] | Mapping[int, ActionLike]
FleetStepResult = tuple[FleetArrays, NDArray[np.float64], Flags, Flags, dict[str, Any]]

MOTION_KEYS = ("blocked", "stopped_by", "seconds", "joules")


class FleetEnv(CopiedWhole):
    """``R`` robots that bring items from pickups to dropoffs in one warehouse.

    Description:
        Each robot is like the one of ``WarehouseEnv``, by the same rules and backends; several get
        in each other's way by the table of ``motion/traffic.py``. An order only decides what a cell
        is to a robot: a pickup where an order waits for it, a dropoff where its item is due.
        Without orders each robot has the task of the chapter, and a fleet of one equals
        ``WarehouseEnv``.

        A step, in this order: robots that have ended wait; the robots and people move; the rules
        judge each robot where it is then; picks and deliveries are booked; the step costs battery,
        and those who wait on a charger charge; orders released now appear and are assigned; robots
        end.

    Actions:
        The actions of ``WarehouseEnv`` for each robot; with ``moves="turn"``, FORWARD, RIGHT,
        LEFT, WAIT, PICK and DROP, see ``world/moves.py``.

    Observations:
        ``FleetArrays`` with a leading ``R``; ``observe(robot)`` is one of them as a dictionary.

    Rewards:
        The table of ``task/rules.py`` for each robot, less ``late_penalty`` for each step by which
        a delivery is late.

    Ends:
        Without orders, a robot is terminated by its delivery; with a list of orders, all robots are
        when all are delivered. A robot is truncated when its battery is empty, all when
        ``max_steps`` are taken or the orders that are left are lost, see ``FleetMeasures``. A robot
        that has ended stays where it is, in the way of others, and has no more rewards. An order
        ends as lost with a robot that cannot drive any more; another robot that carries its item
        puts this aside.

    Args:
        layout: ``None`` is the chapter's.
        robots: number of robots, ``R``, at least 1.
        backend: name, class or instance of the motion that carries out the moves.
        orders: a rate of orders a step, an ``OrderStream`` or several, an ``OrderQueue``, or a list
            of ``Order``; see ``load_orders`` for files. ``None``: each robot delivers one item, as
            in the chapter.
        starts: a cell for each robot; ``None`` is the usual start of a lone robot, and draws those
            of several from the empty cells.
        max_steps: limit of an episode, at least 1.
        battery: units of a full charge, of which a step costs one; or a ``Battery``.
        view_radius: cells seen in each direction, 0 to ``MAX_VIEW_RADIUS``.
        people: number of people who walk on the floor; or ``People``.
        dispatch: assign each open order, the oldest first, to the nearest robot without one. If
            not, open orders are for whoever picks them first, or for ``assign``.
        late_penalty: reward lost for each step by which a delivery is late, at least 0.
        team_reward: give each robot that has not ended the mean of all rewards.
        moves: ``"compass"``: each robot moves N, E, S or W; ``"turn"``: it has a heading, at first
            east, moves forward, and turns in its cell, a quarter a step.
        seed: seed of the first reset without one.

    Attributes:
        layout: layout of the warehouse.
        settings: all arguments but layout, backend and seed.
        backend: name of the backend, or of its class if it was given as a class or instance.
        motion: motion of the backend.
        cell_size: side of a cell in metres.
        conditions: conditions of floor and motors, as the backend gives them.
        assignments: calls of ``assign`` in this episode: steps taken, robot and order.

    Raises:
        ValueError: an invalid argument; also as ``LayoutError``, ``OrderError``, ``BackendError``.
        TypeError: an argument of another type.

    Example:
        >>> from warehouse_core import FleetEnv, OrderStream, shelf_layout
        >>> env = FleetEnv(shelf_layout(), robots=2, orders=OrderStream(rate=0.1), seed=1)
        >>> observations, info = env.reset()
        >>> observations, rewards, terminated, truncated, info = env.step(["E", "WAIT"])
        >>> rewards
        array([-0.1 , -0.15])
    """

    def __init__(
        self,
        layout: Layout | Sequence[str] | None = None,
        robots: int = 2,
        *,
        backend: Backend = "grid",
        orders: Orders | None = None,
        starts: Sequence[Cell] | None = None,
        max_steps: int = 200,
        battery: int | Battery = 200,
        view_radius: int = 2,
        people: int | People = 0,
        dispatch: bool = True,
        late_penalty: float = 0.0,
        team_reward: bool = False,
        moves: str = COMPASS,
        seed: int | None = None,
    ) -> None:
        if layout is None:
            layout = DEFAULT_LAYOUT
        self.layout = layout if isinstance(layout, Layout) else Layout(layout)
        self.settings = FleetSettings.of(
            robots,
            orders=orders,
            starts=starts,
            max_steps=max_steps,
            battery=battery,
            view_radius=view_radius,
            people=people,
            dispatch=dispatch,
            late_penalty=late_penalty,
            team_reward=team_reward,
            moves=moves,
        )
        self.motion = motion = make_motion(backend)
        self.cell_size, self.conditions = motion.cell_size, conditions_of(motion, self.layout)
        self.backend = backend if isinstance(backend, str) else type(motion).__name__
        complete: BaseMotion = with_defaults(motion)
        self._routes = complete.routes if complete.drives_through else None
        self._engine = FleetEngine([self.layout], self.settings, motion)
        self._warn_of_supply()
        self.seed = seed_number(seed)
        self.assignments: list[tuple[int, int, int | None]] = []
        self._started = False

    _repr_png_ = display  # which notebooks call

    def __repr__(self) -> str:
        return f"<FleetEnv {self.settings.robots} robots, {self.layout.summary()}>"

    def reset(self, seed: int | None = None) -> tuple[FleetArrays, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: seed of all random numbers: starts, orders, people and the motion; without one
                they continue.

        Returns:
            The observations, and info with ``action_mask``, see ``step``.

        Raises:
            ValueError: a negative seed; nothing has changed.
            TypeError: a seed that is not an integer.
        """
        if seed is None:
            seed, self.seed = self.seed, None
        else:
            seed, self.seed = seed_number(seed), None
        self._engine.begin(np.array([0]), [seed])
        self.assignments = []
        self._started = True
        return self._engine.observe(), {"action_mask": self._engine.masks()}

    def step(self, actions: Actions) -> FleetStepResult:
        """Carry out one action for each robot.

        Args:
            actions: ``R`` words or indices, as a sequence, an array, or a mapping from the robot's
                number. A mapping may leave out robots that have ended. An unknown word or an index
                out of range is an invalid action, which costs a step, as in the chapter.

        Returns:
            Observations, ``[R]`` float64 rewards, ``[R]`` bool terminated and truncated, and info,
            with ``action_mask``, int8 ``[R, 7]`` or with headings ``[R, 6]``, ``invalid_action``
            ``[R]`` bool, and ``motion``, which has ``blocked``, ``stopped_by`` (see
            ``BatchOutcome``), ``seconds`` and ``joules``. All arrays are fresh.

        Raises:
            ValueError: a number of actions that is not ``R``, an action for a robot that does not
                exist or none for one that does; nothing has changed.
            TypeError: an action that is neither a word nor an integer.
            EndedError: before the first reset, or when all robots have ended.
        """
        if not self._started or not self._engine.running:
            problem = "all robots have ended" if self._started else "there is no episode yet"
            raise EndedError(f"step() needs a reset() before it: {problem}")
        chosen = self.action_indices(actions)
        is_invalid = chosen == INVALID
        if np.count_nonzero(is_invalid):
            # The same verdict: the mistake that the robot cannot help making.
            pick, drop = self.settings.actions.pick, self.settings.actions.drop
            mistakes = np.where(self._engine.robots.has_item, pick, drop)
            chosen = np.where(is_invalid, mistakes, chosen)
        outcome, rewards, terminated, truncated = self._engine.step(chosen)
        info = {
            "action_mask": self._engine.masks(),
            "invalid_action": is_invalid,
            "motion": {name: getattr(outcome, name) for name in MOTION_KEYS},
        }
        return self._engine.observe(), rewards, terminated, truncated, info

    def observe(self, robot: int) -> FleetObservation:
        """Return what one robot observes now, as a new dictionary.

        Raises:
            ValueError: there is no such robot.
            EndedError: before the first reset.
        """
        self._check_started("observe")
        row = whole_number("robot", robot, 0, self.settings.robots - 1)
        return observation_of(self._engine.observe(np.array([row])), 0)

    def observations(self) -> list[FleetObservation]:
        """Return what each robot observes now, faster than ``observe`` of one after the other.

        Raises:
            EndedError: before the first reset.
        """
        self._check_started("observations")
        arrays = self._engine.observe()
        return [observation_of(arrays, row) for row in range(self.settings.robots)]

    def arrays(self) -> FleetArrays:
        """Return what all robots observe now, as fresh arrays.

        Raises:
            EndedError: before the first reset.
        """
        self._check_started("arrays")
        return self._engine.observe()

    def assign(self, robot: int, order: int | None) -> None:
        """Let an order wait for one robot only; ``None`` makes the robot's order open again.

        Orders that only this robot may take stay its own: one that it gives back waits among them.

        Args:
            robot: number of the robot.
            order: index in ``orders`` of an open order, or of one that only this robot may take.

        Raises:
            OrderError: the robot has ended or carries an item, or the order waits neither for it
                nor for all.
            ValueError: there is no such robot, or the fleet has no orders.
            EndedError: before the first reset.
        """
        self._check_started("assign")
        robot = whole_number("robot", robot, 0, self.settings.robots - 1)
        order = None if order is None else whole_number("order", order)
        if self._engine.orders is None:
            raise ValueError(f"order {brief(order)} for robot {robot}: this fleet has no orders")
        if self._engine.ended[robot]:
            raise OrderError(f"order {brief(order)} for robot {robot}: this robot has ended")
        self._engine.orders.assign(0, robot, order)
        self.assignments.append((self.steps, robot, order))

    @property
    def orders(self) -> list[Order]:
        """The orders released so far in this episode, and what has become of them."""
        return self._book.records() if self._book else []

    @property
    def order_arrays(self) -> OrderArrays:
        """The orders released so far as arrays ``[K]``, which are not to be changed.

        Raises:
            ValueError: the fleet has no orders.
        """
        if (book := self._book) is None:
            raise ValueError("this fleet has no orders")
        return book.released_orders

    @property
    def open_orders(self) -> list[int]:
        """The indices of the orders that wait for any robot, in order of release."""
        return self._book.open_orders if self._book else []

    @property
    def order_of(self) -> list[int | None]:
        """For each robot the index of the order that it is to take or carries, or ``None``."""
        orders = self._book.order_of.tolist() if self._book else [NONE] * self.settings.robots
        return [None if order == NONE else order for order in orders]

    @property
    def cells(self) -> list[Cell]:
        """Where each robot is."""
        return self.layout.cells(self._engine.robots.cells)

    @property
    def headings(self) -> list[int]:
        """Where each robot heads, 0 to 3 for N, E, S and W; none of robots without headings."""
        return list(self._engine.headings.tolist())

    @property
    def routes(self) -> Routes:
        """The routes ahead of the robots, and then of the people.

        A route ends in the cell of its robot unless the motion ``drives_through``.
        """
        every = [True] * self.settings.bodies
        return self._routes() if self._routes else Routes(self.cells + self.people, every, every)

    ways = Renamed("routes")

    @property
    def loaded(self) -> list[bool]:
        """Whether each robot holds an item."""
        return list(self._engine.robots.has_item.tolist())

    @property
    def battery(self) -> list[float]:
        """Battery units that each robot has left."""
        return list(self._engine.battery.tolist())

    @property
    def state_of_charge(self) -> list[float]:
        """Battery units that each robot has left, as a share of a full charge."""
        return list((self._engine.battery / self.settings.battery.capacity).tolist())

    @property
    def ended(self) -> list[bool]:
        """Whether each robot has ended: it waits, and stays in the way."""
        return list(self._engine.ended.tolist())

    @property
    def people(self) -> list[Cell]:
        """Where each person is."""
        return self.layout.cells(self._engine.walkers.cells[0])

    @property
    def steps(self) -> int:
        """Joint steps taken in this episode."""
        return int(self._engine.steps[0])

    @property
    def last_motion(self) -> Sequence[Outcome]:
        """What the robots, and then the people, did in the last step.

        Raises:
            RuntimeError: no step has been taken since the reset.
        """
        return self._engine.motion.outcomes(0)

    @property
    def measures(self) -> FleetMeasures:
        """How well the fleet has done in this episode."""
        return self._engine.measures(0)

    def close(self) -> None:
        """Close the motion backend."""
        self._engine.close()

    @property
    def _book(self) -> OrderBook | None:
        return self._engine.orders.books[0] if self._engine.orders else None

    def _check_started(self, method: str) -> None:
        if not self._started:
            raise EndedError(f"{method}() needs a reset() before it")

    def action_indices(self, actions: Actions) -> NDArray[np.intp]:
        """Return the indices ``[R]`` of actions, ``INVALID`` for unknown ones; see ``step``."""
        robots, allowed = self.settings.robots, self.settings.actions
        if isinstance(actions, Mapping):
            actions = self._listed(actions)
        if isinstance(actions, np.ndarray) and actions.dtype.kind in "iu":
            given = actions.astype(np.intp)
            # As unsigned numbers, negative ones are very large.
            given[given.view(np.uintp) >= len(allowed)] = INVALID
        elif isinstance(actions, str) or not isinstance(actions, (Sequence, np.ndarray)):
            raise TypeError(
                f"actions are {brief(actions)}; allowed: a sequence, an array or a mapping"
            )
        else:
            # One more than there may be, as a range can be very long.
            given = np.array([allowed.index(each) for each in islice(actions, robots + 1)], np.intp)
        if given.shape != (robots,):
            raise ValueError(f"actions of the shape {given.shape} for {robots} robots; one each")
        return given

    def _listed(self, actions: Mapping[int, ActionLike]) -> list[ActionLike]:
        """Return the actions of all robots in order; those that have ended may be left out."""
        robots, ended = self.settings.robots, self._engine.ended
        unknown = [robot for robot in actions if robot not in range(robots)]
        if unknown:
            raise ValueError(f"an action for robot {brief(unknown[0])}; allowed: 0..{robots - 1}")
        missing = [robot for robot in range(robots) if robot not in actions and not ended[robot]]
        if missing:
            raise ValueError(f"no action for robot {missing[0]}; each that has not ended needs one")
        return [actions.get(robot, self.settings.actions.wait) for robot in range(robots)]

    def _warn_of_supply(self) -> None:
        """Warn if the batteries do not last, and the chargers supply less than the robots use."""
        battery, robots = self.settings.battery, self.settings.robots
        cost, chargers = battery.step_cost(self.cell_size), len(self.layout.chargers)
        if self.settings.orders is None and not chargers:
            return  # the task of the chapter, which ends with the battery
        supply = chargers * battery.step_charge(self.cell_size)
        if self.settings.max_steps * cost > battery.capacity and supply < robots * cost:
            warnings.warn(
                f"{counted(chargers, 'charger')} can keep {int(supply / cost)} of "
                f"{counted(robots, 'robot')} going, and their batteries last "
                f"{battery.capacity / cost:.0f} of {self.settings.max_steps} steps: robots will "
                "stop in the way of others",
                stacklevel=3,
            )
