"""The chapter's environment: the rules (``task/``) applied with a motion backend (``motion/``)."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Any, ClassVar, SupportsIndex

from warehouse_core.arguments import (
    MAX_BUDGET,
    MAX_VIEW_RADIUS,
    as_cell,
    instance_of,
    real_number,
    seed_number,
    whole_number,
)
from warehouse_core.copies import CopiedWhole
from warehouse_core.errors import BackendError
from warehouse_core.listing import DRAWS, LISTED, MOVES, STEPS, Grid, seeded
from warehouse_core.motion.backends import Backend, make_motion
from warehouse_core.motion.base import Motion, Outcome, conditions_of, with_defaults
from warehouse_core.motion.grid import GridMotion
from warehouse_core.task.rules import (
    BLOCKED_REWARD,
    DELIVERY_REWARD,
    STEP_REWARD,
    Verdict,
    charged,
    is_truncated,
    judge,
)
from warehouse_core.task.settings import Settings
from warehouse_core.task.sight import Sight
from warehouse_core.task.starts import (
    Randomized,
    choose_start,
    choose_stations,
    randomized_parts,
)
from warehouse_core.task.state import Observation, WarehouseState
from warehouse_core.wording import brief, listed
from warehouse_core.world.actions import (
    ACTIONS,
    DISPLACEMENTS,
    DROP,
    INVALID,
    PICK,
    WAIT,
    action_index,
)
from warehouse_core.world.display import display
from warehouse_core.world.layout import CHAPTER_START, DEFAULT_LAYOUT, Layout, check_open
from warehouse_core.world.tiles import (
    CHARGER,
    DROPOFF,
    MOVE_DELTAS,
    PICKUP,
    ROBOT_EMPTY,
    ROBOT_LOADED,
    TILES,
    Cell,
    moved,
)

LEGEND = TILES | {ROBOT_EMPTY: "robot (empty)", ROBOT_LOADED: "robot (loaded)"}


def legend(has_chargers: bool) -> dict[str, str]:
    """Return the meaning of each character in a picture; include chargers only if there are any."""
    return {sign: meaning for sign, meaning in LEGEND.items() if has_chargers or sign != CHARGER}


class WarehouseEnv(CopiedWhole):
    """The warehouse of the chapter's exercise.

    Description:
        A robot in a grid with walls picks up an item at a pickup and delivers it to a dropoff. It
        sees the cells around it, and its battery loses one unit in every step. Waiting on a charger
        charges the battery; the chapter itself has no chargers.

    Actions:
        ==========  ==========  ==========================================
        Index       Word        Action
        ==========  ==========  ==========================================
        0, 1, 2, 3  N, E, S, W  move one cell north, east, south or west
        4           WAIT        stay; on a charger, charge the battery
        5           PICK        on a pickup, take the item if it has none
        6           DROP        on a dropoff, deliver the item it carries
        ==========  ==========  ==========================================

    Observations:
        A dictionary; see ``Observation``.

    Rewards:
        See the table in ``warehouse_core/task/rules.py``.

    Ends:
        Terminated when the item is delivered. Truncated when ``max_steps`` steps have been taken or
        the battery is empty. Both may be true. You can call ``step`` after the end of an episode,
        as in the chapter.

    Args:
        grid: strings of equal length with the characters ``#.PDC``, or a ``Layout``; ``None`` is
            the chapter's grid of 7 x 12 cells.
        start_pos: (row, column) of the robot after ``reset()`` without ``randomize``; ``None`` is
            the layout's ``default_start()``.
        max_steps: number of steps after which the episode is truncated, 1 to ``MAX_BUDGET``.
        battery: units in a full battery, 1 to ``MAX_BUDGET``.
        view_radius: number of cells that the robot sees in each direction, 0 to
            ``MAX_VIEW_RADIUS``.
        backend: name, class or instance of the motion that carries out the moves.

    Raises:
        ValueError: the layout is invalid or the start is not open (``LayoutError``), a number is
            out of range, or the backend is unknown (``BackendError``).
        TypeError: an argument has a wrong type.

    A subclass may override the methods of the book's listing, from ``_observe`` to
    ``_randomize_pickup_dropoff``. Its ``step`` and ``reset`` are then composed of them, as in the
    listing. ``_move`` and ``_is_wall`` need ``backend="grid"``.

    Source: the chapter's exercise, section 1.6 of the course book.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> env = WarehouseEnv()
        >>> observation = env.reset()
        >>> observation, reward, terminated, truncated, info = env.step("E")
        >>> observation["robot_pos"], reward, terminated, truncated
        ((1, 2), -0.1, False, False)
    """

    ACTIONS: ClassVar[list[str]] = list(ACTIONS)
    MOVE_DELTAS: ClassVar[dict[str, Cell]] = dict(MOVE_DELTAS)
    _overridden: ClassVar[frozenset[str]] = frozenset()
    _is_drawing = False
    _pickup: Any
    _dropoff: Any

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if cls.ACTIONS != WarehouseEnv.ACTIONS or cls.MOVE_DELTAS != WarehouseEnv.MOVE_DELTAS:
            raise TypeError(
                f"{cls.__name__} changes ACTIONS or MOVE_DELTAS, but a record has the seven "
                "actions of the chapter; override _normalize_action or _move instead"
            )
        # ``observe`` and ``_observe`` are one method: an override of either serves both.
        seeing = {"observe", "_observe"}
        owner = next(vars(each) for each in cls.__mro__ if seeing & vars(each).keys())
        if len(names := seeing & owner.keys()) == 1:
            cls.observe = cls._observe = owner[names.pop()]  # type: ignore[method-assign]
        cls._overridden = frozenset(
            name for name in LISTED if getattr(cls, name) is not getattr(WarehouseEnv, name)
        )
        if "_find_tile" in cls._overridden:
            cls._pickup, cls._dropoff = _found(PICKUP), _found(DROPOFF)

    def __init__(
        self,
        grid: Sequence[str] | Layout | None = None,
        start_pos: Cell | None = CHAPTER_START,
        max_steps: int = 200,
        battery: int = 200,
        view_radius: int = 2,
        *,
        backend: Backend = "grid",
    ) -> None:
        self.max_steps = whole_number("max_steps", max_steps, 1, MAX_BUDGET)
        self.max_battery = whole_number("battery", battery, 1, MAX_BUDGET)
        self._view_radius = whole_number("view_radius", view_radius, 0, MAX_VIEW_RADIUS)
        if grid is None:
            grid = DEFAULT_LAYOUT
        layout = grid if isinstance(grid, Layout) else Layout(grid)
        self._sight = Sight(self._view_radius)
        self._use(layout)
        self._given_layout = layout
        self._start_pos = self._start_in(self.layout, start_pos)
        self._motion = motion = make_motion(backend)
        self._is_listed = not self._overridden.isdisjoint(STEPS)
        self._carries = type(motion).advance is GridMotion.advance
        if with_defaults(self._motion).drives_through:
            raise BackendError(
                f"backend {brief(backend)} drives through the cells of a plan; allowed here: one "
                "whose robots rest in each cell. FleetEnv takes both, and replay_episode drives "
                "the path of a finished episode"
            )
        if not self._carries and (changed := self._overridden.intersection(MOVES)):
            raise BackendError(
                f"{type(self).__name__} overrides {listed(sorted(changed))}, which "
                f"backend {brief(backend)} does not call: a body meets the walls of the "
                "layout. Choose backend='grid', or change the layout or the motion instead"
            )
        self.last_motion: Outcome | None = None
        self._placed: Cell = self._start_pos
        self.backend = backend if isinstance(backend, str) else type(self._motion).__name__
        self.reset()

    _repr_png_ = display  # called by notebooks

    def __repr__(self) -> str:
        return f"<WarehouseEnv {self.layout.summary()}, backend {self.backend!r}>"

    @property
    def grid(self) -> list[str]:
        """The current layout as a list of strings, without the robot.

        ``env.grid[row] = "#..#"`` and ``env.grid = rows`` change the layout for this episode and
        for later ones.

        Raises:
            LayoutError: the new layout is invalid, or the robot or ``start_pos`` is on a wall.
        """
        return Grid(self.layout.rows, self._change_grid)

    @grid.setter
    def grid(self, rows: Sequence[str]) -> None:
        self._change_grid(rows)

    @property
    def height(self) -> int:
        """Number of rows."""
        return self.layout.height

    @property
    def width(self) -> int:
        """Number of columns."""
        return self.layout.width

    @property
    def start_pos(self) -> Cell:
        """Cell at which the robot starts without ``randomize``."""
        return self._start_pos

    @property
    def view_radius(self) -> int:
        """Number of cells that the robot sees in each direction."""
        return self._view_radius

    @property
    def motion(self) -> Motion:
        """The motion backend that carries out the moves."""
        return self._motion

    @property
    def settings(self) -> Settings:
        """The arguments of this environment, except for the layout."""
        return Settings(
            backend=self.backend,
            cell_size=float(self._motion.cell_size),
            start_pos=self._start_pos,
            max_steps=self.max_steps,
            battery=self.max_battery,
            view_radius=self._view_radius,
            **conditions_of(self._motion, self.layout)._asdict(),
        )

    def reset(self, randomize: bool | str = False, seed: int | None = None) -> Observation:
        """Start an episode with no item, a full battery and no steps taken.

        Args:
            randomize: ``True`` draws pickup, dropoff and start, in this order, uniformly from the
                empty cells; ``"stations"`` or ``"start"`` draws only those. The new pickup and
                dropoff replace the old ones, also for later resets.
            seed: seed of ``random.Random``, which draws the cells; ``None`` uses Python's global
                ``random``. With a seed, pickup and dropoff are drawn from the empty cells of the
                layout given to the environment, so that a seed always determines the same episode.
                Without a seed, they are drawn from the empty cells of the current layout, as in the
                chapter, so the episode also depends on the previous stations.

        Returns:
            The first observation.

        Raises:
            LayoutError: stations are to be drawn, and fewer than two open cells have no charger.
            ValueError: ``randomize`` is another word, or ``seed`` is negative.
            TypeError: ``seed`` is not an integer.

        After an error, the environment is unchanged.
        """
        randomized = randomized_parts(randomize)
        seed = seed_number(seed)
        layout, start = self.layout, self._start_pos
        if randomize and not self._overridden.isdisjoint(DRAWS):
            layout, start = self._draw_as_listed(randomized, seed)
        elif randomize:
            stream = random if seed is None else random.Random(seed)
            if randomized.stations and seed is not None:
                layout = self._given_layout
            chargers = layout.ranks(layout.chargers)
            stations = layout.ranks(layout.pickups + layout.dropoffs)
            if randomized.stations:
                layout, stations = choose_stations(stream, layout, stations + chargers)
            if randomized.start:
                start = choose_start(stream, layout, stations + chargers) or start
        return self._begin(layout, start, seed)

    def reset_to(
        self, layout: Layout, start_pos: Cell | None = None, seed: int | None = None
    ) -> Observation:
        """Start an episode in a given layout, and keep the layout for later resets.

        Args:
            layout: layout, which may have any size.
            start_pos: (row, column) of the start of this episode; ``None`` is the layout's
                ``default_start()``.
            seed: seed of the motion backend's random numbers.

        Returns:
            The first observation.

        Raises:
            LayoutError: the start is not open; the environment is unchanged.
            TypeError: an argument has a wrong type.
        """
        instance_of("layout", layout, Layout)
        start = self._start_in(layout, start_pos)
        seed = None if seed is None else whole_number("seed", seed)
        self._given_layout = layout
        return self._begin(layout, start, seed)

    def step(
        self, action: str | SupportsIndex
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Carry out one action, given as a word (in upper or lower case) or as an index.

        Returns:
            Observation, reward, terminated, truncated and info. ``info`` is empty, except after an
            unknown word or an index out of range: then ``info["invalid_action"]`` is true. The
            outcome of the motion is in ``last_motion``.

        Raises:
            TypeError: ``action`` is neither a string nor an integer; the environment is unchanged.
            LayoutError: ``state.robot_pos`` has been set to a cell that is not open.
        """
        index = action_index(self._normalize_action(action) if self._is_listed else action)
        reward, terminated, truncated = self.advance(index)
        info = {"invalid_action": True} if index == INVALID else {}
        return self.observe(), reward, terminated, truncated, info

    def advance(self, index: int) -> tuple[float, bool, bool]:
        """Carry out one action as ``step`` does, but compute no observation.

        Args:
            index: index of the action, or ``INVALID``; it is not checked.

        Returns:
            Reward, terminated and truncated.
        """
        if self._is_listed:
            return self._advance_as_listed(index)
        state = self.state
        # Identity, not equality, detects that a user has assigned a cell to the state.
        if state.robot_pos is not self._placed:
            self._place(state.robot_pos)
        has_item = state.has_item
        outcome = self._motion.advance((DISPLACEMENTS[index],), (has_item,))[0]
        row, col = self._placed = state.robot_pos = outcome.cell
        tile = self.layout.rows[row][col]
        reward, state.has_item, delivered, charges = judge(index, tile, has_item, outcome.blocked)
        state.steps += 1
        state.battery -= 1
        if charges:
            state.battery = charged(state.battery, self.max_battery)
        self.last_motion = outcome
        return reward, delivered, is_truncated(state.steps, self.max_steps, state.battery)

    def observe(self) -> Observation:
        """Return the current observation."""
        state = self.state
        return {
            "local_grid": self._sight.window(state.robot_pos, state.has_item),
            "robot_pos": state.robot_pos,
            "has_item": state.has_item,
            "battery": state.battery,
            "steps": state.steps,
            "pickup_pos": self._pickup,
            "dropoff_pos": self._dropoff,
        }

    _observe = observe

    def render_grid(self) -> list[list[str]]:
        """Return the grid and the robot (``R`` or ``r``) as ``H`` lists of ``W`` characters."""
        frame = [list(row) for row in self.layout.rows]
        row, col = self.state.robot_pos
        frame[row][col] = ROBOT_LOADED if self.state.has_item else ROBOT_EMPTY
        return frame

    def render(self) -> str:
        """Return ``render_grid()`` as one string."""
        return "\n".join("".join(row) for row in self.render_grid())

    def render_with_legend(self) -> str:
        """Return ``render()`` followed by a line for each character."""
        signs = legend(bool(self.layout.chargers))
        lines = "\n".join(f"{character} = {meaning}" for character, meaning in signs.items())
        return f"{self.render()}\n\nLegend:\n{lines}"

    def close(self) -> None:
        """Close the motion backend."""
        self._motion.close()

    @staticmethod
    def _start_in(layout: Layout, start_pos: Cell | None) -> Cell:
        """Return the start as a cell; raise an error if the cell is not open."""
        if start_pos is None:
            return layout.default_start()
        start = as_cell("start_pos", start_pos)
        check_open(layout, start, "start_pos")
        return start

    def _begin(self, layout: Layout, start: Cell, seed: int | None) -> Observation:
        if layout is not self.layout:
            self._use(layout)
        self._seed = seed
        self.state = WarehouseState(start, False, self.max_battery, 0)
        self._place(start)
        return self.observe()

    def _use(self, layout: Layout) -> None:
        self.layout = layout
        self._sight.use(layout)
        self._pickup = layout.pickups[0] if layout.pickups else None
        self._dropoff = layout.dropoffs[0] if layout.dropoffs else None

    def _place(self, cell: Cell) -> None:
        self._motion.reset(self.layout, [cell], self._seed)
        self._placed = cell
        self.last_motion = None

    def _change_grid(self, rows: Sequence[str]) -> None:
        layout = rows if isinstance(rows, Layout) else Layout(rows)
        if not self._is_drawing:
            check_open(layout, self.state.robot_pos, "the robot's cell,")
            check_open(layout, self._start_pos, "start_pos")
            self._given_layout = layout
        self._use(layout)
        if not self._is_drawing:
            self._place(self.state.robot_pos)

    # The methods of the listing, which only environments that override one of them call.

    def _normalize_action(self, action: str | SupportsIndex) -> str:
        """Return the word of an action, or ``"INVALID"``."""
        return (*ACTIONS, "INVALID")[action_index(action)]

    def _is_wall(self, r: int, c: int) -> bool:
        """Return whether a cell is a wall or off the grid."""
        return not self.layout.is_open((r, c))

    def _find_tile(self, tile: str) -> Cell | None:
        """Return the first cell with this tile in row-major order, or ``None``."""
        rows = enumerate(self.layout.rows)
        return next(((row, text.index(tile)) for row, text in rows if tile in text), None)

    def _move(self, act: str) -> float:
        """Move the robot by one cell unless a wall is there; return the reward for it."""
        cell = moved(self.state.robot_pos, MOVE_DELTAS[act])
        if self._is_wall(*cell):
            return BLOCKED_REWARD
        self.state.robot_pos = cell
        return 0.0

    def _pick(self) -> float:
        """Take an item if possible; return the reward for it."""
        return self._judged(PICK)

    def _drop(self) -> float:
        """Deliver the item if possible; return the reward for it."""
        return self._judged(DROP)

    def _random_empty_cell(self) -> Cell:
        """Return a random empty cell, or ``start_pos`` if no cell is empty."""
        return choose_start(random, self.layout) or self._start_pos

    def _randomize_pickup_dropoff(self) -> None:
        """Draw a new pickup and dropoff from the empty cells."""
        self._use(choose_stations(random, self.layout)[0])

    # Steps and draws that are composed of these methods.

    def _advance_as_listed(self, index: int) -> tuple[float, bool, bool]:
        state, move = self.state, DISPLACEMENTS[index]
        if state.robot_pos is not self._placed:
            self._place(state.robot_pos)
        if isinstance(self._motion, GridMotion) and self._carries:
            reward = STEP_REWARD + self._effect(index)
            self.last_motion = self._motion.carry(state.robot_pos, move)
        else:
            self.last_motion = self._motion.advance((move,), (state.has_item,))[0]
            state.robot_pos = self.last_motion.cell
            reward = STEP_REWARD + self._effect(index)
        self._placed = state.robot_pos = self.last_motion.cell
        state.steps += 1
        state.battery -= 1
        if index == WAIT and self._verdict(WAIT).charges:
            state.battery = charged(state.battery, self.max_battery)
        delivered = index == DROP and reward >= DELIVERY_REWARD
        return reward, delivered, is_truncated(state.steps, self.max_steps, state.battery)

    def _effect(self, index: int) -> float:
        """Apply an action and return what it adds to the reward of a step."""
        if index < WAIT:
            if self._carries:
                return self._reward("_move", ACTIONS[index])
            return BLOCKED_REWARD if self.last_motion and self.last_motion.blocked else 0.0
        if index in (PICK, DROP):
            return self._reward("_pick" if index == PICK else "_drop")
        return self._judged(index)

    def _reward(self, name: str, *arguments: str) -> float:
        """Return the reward of a method of the listing, which must be a number."""
        reward = getattr(self, name)(*arguments)
        return real_number(f"reward of {type(self).__name__}.{name}", reward, -math.inf)

    def _judged(self, index: int) -> float:
        verdict = self._verdict(index)
        self.state.has_item = verdict.has_item
        return verdict.reward - STEP_REWARD

    def _verdict(self, index: int) -> Verdict:
        row, col = self.state.robot_pos
        return judge(index, self.layout.rows[row][col], self.state.has_item, False)

    def _draw_as_listed(self, randomized: Randomized, seed: int | None) -> tuple[Layout, Cell]:
        before, start = self.layout, self._start_pos
        self._is_drawing = True
        try:
            with seeded(seed):
                if randomized.stations:
                    self._use(self._given_layout if seed is not None else before)
                    self._randomize_pickup_dropoff()
                if randomized.start:
                    start = as_cell("_random_empty_cell()", self._random_empty_cell())
            check_open(self.layout, start, "the start at")
        except BaseException:
            self._use(before)
            raise
        finally:
            self._is_drawing = False
        return self.layout, start


def _found(tile: str) -> property:
    """Return an attribute that looks for a tile anew, and that cannot be changed otherwise."""
    return property(lambda env: env._find_tile(tile), lambda env, cell: None)
