"""The environment of a fleet: several robots in a warehouse with orders, chargers and people."""

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
from warehouse_core.errors import EndedError, OrderError
from warehouse_core.fleet.observation import FleetObservation, observation_of
from warehouse_core.listing import Unlisted
from warehouse_core.motion.backends import Backend, make_motion
from warehouse_core.motion.base import BaseMotion, Outcome, Routes, conditions_of, with_defaults
from warehouse_core.orders.book import NONE, OrderBook
from warehouse_core.orders.order import Order, OrderArrays, Orders
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


class FleetEnv(Unlisted):
    """A fleet of ``R`` robots that move items from pickups to dropoffs in one warehouse.

    Description:
        Each robot follows the same rules as the robot of ``WarehouseEnv``, with the same backends.
        Robots block each other according to the table in ``motion/traffic.py``. Orders determine
        the stations of a robot: its pickups are the cells where orders wait for it, and its dropoff
        is the cell to which it must bring its item. Without orders each robot has the task of the
        chapter, and a fleet of one robot equals ``WarehouseEnv``.

        A step consists of these parts, in this order:

        1. Robots and people move. Robots that have ended wait.
        2. The rules judge each robot in its new cell.
        3. Picks and deliveries are recorded.
        4. The step costs battery units, and robots that wait on a charger are charged.
        5. New orders are released, and open orders are assigned.
        6. Robots end.

    Actions:
        The actions of ``WarehouseEnv`` for each robot. With ``moves="turn"`` they are FORWARD,
        RIGHT, LEFT, WAIT, PICK and DROP, see ``world/moves.py``.

    Observations:
        ``FleetArrays`` with a leading ``R``. ``observe(robot)`` returns one observation as a
        dictionary.

    Rewards:
        The table in ``task/rules.py`` for each robot, minus ``late_penalty`` for each step by which
        a delivery is late.

    Ends:
        Without orders, a robot is terminated by its delivery. With a list of orders, all robots are
        terminated when all orders have been delivered. A robot is truncated when its battery is
        empty. All robots are truncated after ``max_steps``, or when all undelivered orders are
        lost, see ``FleetMeasures``. A robot that has ended stays in its cell, blocks others, and
        gets no more rewards. If a robot can no longer drive, the orders that it holds or blocks are
        lost, and other robots that carry items of these orders lose the items.

    Args:
        layout: layout of the warehouse; ``None`` is the chapter's layout.
        robots: number of robots ``R``, at least 1.
        backend: name, class or instance of the motion that carries out the moves.
        orders: rate of orders per step, one or several ``OrderStream``, an ``OrderQueue``, or a
            list of ``Order``, see ``load_orders`` for files. With ``None`` each robot delivers one
            item, as in the chapter.
        starts: start of each robot. ``None`` is the default start for a single robot, and random
            empty cells for several robots.
        max_steps: limit of an episode, at least 1.
        battery: units of a full charge, of which a step costs one; or a ``Battery``.
        view_radius: cells seen in each direction, 0 to ``MAX_VIEW_RADIUS``.
        people: number of people who walk on the floor; or ``People``.
        dispatch: ``True`` to assign open orders, the oldest first, to the nearest robots without an
            order. Otherwise an open order waits for the first robot that picks it, or for a call of
            ``assign``.
        late_penalty: reward lost for each step by which a delivery is late, at least 0.
        team_reward: ``True`` to give the mean of all rewards to each robot that has not ended.
        moves: ``"compass"`` for moves N, E, S and W; ``"turn"`` for robots with headings, which
            move forward and turn in their cells by 90 degrees per step.
        seed: seed of the first reset that is called without a seed.

    Attributes:
        layout: layout of the warehouse.
        settings: all arguments except layout, backend and seed.
        backend: name of the backend, or of its class if it was given as a class or instance.
        motion: motion of the backend.
        cell_size: side of a cell in metres.
        conditions: conditions of floor and motors, as the backend reports them.
        assignments: calls of ``assign`` in this episode, each with steps taken, robot and order.

    Raises:
        ValueError: an argument is not allowed; it may be a ``LayoutError``, ``OrderError`` or
            ``BackendError``.
        TypeError: an argument has the wrong type.

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

    _repr_png_ = display  # called by notebooks

    def __repr__(self) -> str:
        return f"<FleetEnv {self.settings.robots} robots, {self.layout.summary()}>"

    def reset(self, seed: int | None = None) -> tuple[FleetArrays, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: seed of all random numbers of starts, orders, people and the motion. Without a
                seed the random streams continue.

        Returns:
            The observations, and info with ``action_mask``, see ``step``.

        Raises:
            ValueError: the seed is negative; nothing has changed.
            TypeError: the seed is not an integer.
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
            actions: ``R`` words or indices, as a sequence, an array, or a mapping from robot
                numbers. A mapping may omit robots that have ended. An unknown word or an index out
                of range is an invalid action, which costs a step, as in the chapter.

        Returns:
            Observations, ``[R]`` float64 rewards, ``[R]`` bool terminated and truncated, and info.
            Info has ``action_mask`` ``[R, 7]`` int8, or ``[R, 6]`` with headings;
            ``invalid_action`` ``[R]`` bool; and ``motion`` with ``blocked``, ``stopped_by`` (see
            ``BatchOutcome``), ``seconds`` and ``joules``. All arrays are new.

        Raises:
            ValueError: the number of actions is not ``R``, or a mapping has an unknown robot or
                lacks one that has not ended; nothing has changed.
            TypeError: an action is neither a word nor an integer.
            EndedError: there is no episode yet, or all robots have ended.
        """
        if not self._started or not self._engine.running:
            problem = "all robots have ended" if self._started else "there is no episode yet"
            raise EndedError(f"step() needs a reset() before it: {problem}")
        chosen = self.action_indices(actions)
        is_invalid = chosen == INVALID
        if np.count_nonzero(is_invalid):
            # An invalid action gets the verdict of a pick or drop that is certainly a mistake.
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
        """Return the observation of a robot as a new dictionary.

        Raises:
            ValueError: the robot does not exist.
            EndedError: there is no episode yet.
        """
        self._check_started("observe")
        row = whole_number("robot", robot, 0, self.settings.robots - 1)
        return observation_of(self._engine.observe(np.array([row])), 0)

    def observations(self) -> list[FleetObservation]:
        """Return the observations of all robots, faster than by calling ``observe`` for each.

        Raises:
            EndedError: there is no episode yet.
        """
        self._check_started("observations")
        arrays = self._engine.observe()
        return [observation_of(arrays, row) for row in range(self.settings.robots)]

    def arrays(self) -> FleetArrays:
        """Return the observations of all robots as new arrays.

        Raises:
            EndedError: there is no episode yet.
        """
        self._check_started("arrays")
        return self._engine.observe()

    def assign(self, robot: int, order: int | None) -> None:
        """Assign an order to a robot; with ``None``, give back the order that the robot has.

        An order that is given back is open again, unless only this robot may take it. Then it
        waits until the robot has no other order.

        Args:
            robot: number of the robot.
            order: index in ``orders`` of an open order, or of one that only this robot may take.

        Raises:
            OrderError: the robot has ended or carries an item, or the order is neither open nor
                reserved for this robot.
            ValueError: the robot does not exist, or the fleet has no orders.
            EndedError: there is no episode yet.
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
        """The orders released so far in this episode, with their progress."""
        return self._book.records() if self._book else []

    @property
    def order_arrays(self) -> OrderArrays:
        """The orders released so far as arrays ``[K]``, which must not be changed.

        Raises:
            ValueError: the fleet has no orders.
        """
        if (book := self._book) is None:
            raise ValueError("this fleet has no orders")
        return book.released_orders

    @property
    def open_orders(self) -> list[int]:
        """The indices of the open orders, in order of release."""
        return self._book.open_orders if self._book else []

    @property
    def order_of(self) -> list[int | None]:
        """The index of each robot's order, or ``None`` for robots without an order."""
        orders = self._book.order_of.tolist() if self._book else [NONE] * self.settings.robots
        return [None if order == NONE else order for order in orders]

    @property
    def cells(self) -> list[Cell]:
        """The cell of each robot."""
        return self.layout.cells(self._engine.robots.cells)

    @property
    def headings(self) -> list[int]:
        """The heading of each robot, 0 to 3 for N, E, S and W; empty if robots have no headings."""
        return list(self._engine.headings.tolist())

    @property
    def routes(self) -> Routes:
        """The routes ahead of the robots, and then of the people.

        A route ends in the cell of its robot unless the motion ``drives_through``.
        """
        every = [True] * self.settings.bodies
        return self._routes() if self._routes else Routes(self.cells + self.people, every, every)

    @property
    def loaded(self) -> list[bool]:
        """Flags of the robots that hold an item."""
        return list(self._engine.robots.has_item.tolist())

    @property
    def battery(self) -> list[float]:
        """The battery units left of each robot."""
        return list(self._engine.battery.tolist())

    @property
    def state_of_charge(self) -> list[float]:
        """The state of charge of each robot, as a share of a full charge, 0 to 1."""
        return list((self._engine.battery / self.settings.battery.capacity).tolist())

    @property
    def ended(self) -> list[bool]:
        """Flags of the robots that have ended. They wait in their cells and block others."""
        return list(self._engine.ended.tolist())

    @property
    def people(self) -> list[Cell]:
        """The cell of each person."""
        return self.layout.cells(self._engine.walkers.cells[0])

    @property
    def steps(self) -> int:
        """The number of joint steps taken in this episode."""
        return int(self._engine.steps[0])

    @property
    def last_motion(self) -> Sequence[Outcome]:
        """The outcomes of the robots, and then of the people, in the last step.

        Raises:
            RuntimeError: no step has been taken since the reset.
        """
        return self._engine.motion.outcomes(0)

    @property
    def measures(self) -> FleetMeasures:
        """The measures of the fleet in this episode."""
        return self._engine.measures(0)

    def close(self) -> None:
        """Close the motion backend."""
        self._engine.close()

    @property
    def _book(self) -> OrderBook | None:
        return self._engine.orders.book(0) if self._engine.orders else None

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
            # Negative numbers are very large as unsigned numbers.
            given[given.view(np.uintp) >= len(allowed)] = INVALID
        elif isinstance(actions, str) or not isinstance(actions, (Sequence, np.ndarray)):
            raise TypeError(
                f"actions are {brief(actions)}; allowed: a sequence, an array or a mapping"
            )
        else:
            # Convert only one action more than allowed, because a range can be very long.
            given = np.array([allowed.index(each) for each in islice(actions, robots + 1)], np.intp)
        if given.shape != (robots,):
            raise ValueError(
                f"actions have the shape {given.shape}; they must have the shape ({robots},), one "
                "action for each robot"
            )
        return given

    def _listed(self, actions: Mapping[int, ActionLike]) -> list[ActionLike]:
        """Return the actions of all robots in order, given a mapping that may omit ended robots."""
        robots, ended = self.settings.robots, self._engine.ended
        unknown = [robot for robot in actions if robot not in range(robots)]
        if unknown:
            raise ValueError(f"an action for robot {brief(unknown[0])}; allowed: 0..{robots - 1}")
        missing = [robot for robot in range(robots) if robot not in actions and not ended[robot]]
        if missing:
            raise ValueError(
                f"robot {missing[0]} has no action; every robot that has not ended needs one"
            )
        return [actions.get(robot, self.settings.actions.wait) for robot in range(robots)]

    def _warn_of_supply(self) -> None:
        """Warn if batteries cannot last an episode and chargers supply less than the robots use."""
        battery, robots = self.settings.battery, self.settings.robots
        cost, chargers = battery.step_cost(self.cell_size), len(self.layout.chargers)
        if self.settings.orders is None and not chargers:
            return  # in the chapter's task, an empty battery simply ends the episode
        supply = chargers * battery.step_charge(self.cell_size)
        if self.settings.max_steps * cost > battery.capacity and supply < robots * cost:
            warnings.warn(
                f"{counted(chargers, 'charger')} can keep {int(supply / cost)} of "
                f"{counted(robots, 'robot')} running, and a full battery lasts "
                f"{battery.capacity / cost:.0f} of {self.settings.max_steps} steps: robots will "
                "run out of battery and block others",
                stacklevel=3,
            )
