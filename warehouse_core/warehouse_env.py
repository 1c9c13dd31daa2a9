"""The chapter's environment: the rules (``task/``) applied with a motion backend (``motion/``)."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any, ClassVar, SupportsIndex

from warehouse_core.arguments import (
    MAX_BUDGET,
    MAX_VIEW_RADIUS,
    as_cell,
    instance_of,
    seed_number,
    whole_number,
)
from warehouse_core.copies import CopiedWhole
from warehouse_core.errors import BackendError
from warehouse_core.motion.backends import Backend, make_motion
from warehouse_core.motion.base import Motion, Outcome, conditions_of, with_defaults
from warehouse_core.task.rules import charged, is_truncated, judge
from warehouse_core.task.settings import Settings
from warehouse_core.task.sight import Sight
from warehouse_core.task.starts import check_room, randomized_parts
from warehouse_core.task.state import Observation, WarehouseState
from warehouse_core.wording import brief
from warehouse_core.world.actions import ACTIONS, DISPLACEMENTS, INVALID, action_index
from warehouse_core.world.display import display
from warehouse_core.world.layout import CHAPTER_START, DEFAULT_LAYOUT, Layout, check_open
from warehouse_core.world.tiles import CHARGER, MOVE_DELTAS, ROBOT_EMPTY, ROBOT_LOADED, TILES, Cell

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
        self._motion = make_motion(backend)
        if with_defaults(self._motion).drives_through:
            raise BackendError(
                f"backend {brief(backend)} drives through the cells of a plan; allowed here: one "
                "whose robots rest in each cell. FleetEnv takes both, and replay_episode drives "
                "the path of a finished episode"
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
        """A copy of the current layout as a list of strings, without the robot."""
        return list(self.layout.rows)

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
        if randomize:
            stream = random if seed is None else random.Random(seed)
            if randomized.stations and seed is not None:
                layout = self._given_layout
            chargers = layout.ranks(layout.chargers)
            stations = layout.ranks(layout.pickups + layout.dropoffs)
            if randomized.stations:
                layout, stations = _draw_stations(stream, layout, stations + chargers)
            if randomized.start:
                start = self._draw_start(stream, layout, stations + chargers)
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
        index = action_index(action)
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

    def _draw_start(self, stream: Any, layout: Layout, taken: list[int]) -> Cell:
        """Return a random empty cell, or ``start_pos`` if no cell is empty."""
        count = len(layout.open_cells)
        if count <= len(taken):
            return self._start_pos
        return layout.open_cell(_draw(stream, count, without=taken))


def _draw_stations(stream: Any, layout: Layout, taken: list[int]) -> tuple[Layout, list[int]]:
    """Return a layout with a random pickup and dropoff, and the ranks of these two.

    Args:
        stream: random stream.
        layout: layout whose empty cells are drawn from.
        taken: ranks of the present stations and chargers, which are not empty. With fewer than two
            empty cells, the layout gets no stations, as in the chapter's recorded episodes.
    """
    check_room(layout)
    count = len(layout.open_cells)
    new: list[int] = []
    if count - len(taken) >= 2:
        for _ in range(2):
            new.append(_draw(stream, count, without=taken + new))
    pickup, dropoff = map(layout.open_cell, new) if new else (None, None)
    return layout.with_stations(pickup, dropoff), new


def _draw(stream: Any, count: int, without: list[int]) -> int:
    """Return a random number of ``range(count)`` that is not in ``without``.

    The result is the same as with ``choice`` from a list of the remaining numbers, but the list is
    not built.
    """
    index: int = stream.choice(range(count - len(without)))
    for taken in sorted(without):
        index += index >= taken
    return index
