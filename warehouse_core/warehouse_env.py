"""The chapter's environment: it joins the rules (``task/``) and a motion backend (``motion/``)."""

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
from warehouse_core.task.starts import check_room, what_is_drawn
from warehouse_core.task.state import Observation, WarehouseState
from warehouse_core.wording import brief
from warehouse_core.world.actions import ACTIONS, DISPLACEMENTS, INVALID, action_index
from warehouse_core.world.display import display
from warehouse_core.world.layout import CHAPTER_START, DEFAULT_LAYOUT, Layout, check_open
from warehouse_core.world.tiles import CHARGER, MOVE_DELTAS, ROBOT_EMPTY, ROBOT_LOADED, TILES, Cell

LEGEND = TILES | {ROBOT_EMPTY: "robot (empty)", ROBOT_LOADED: "robot (loaded)"}


def legend(has_chargers: bool) -> dict[str, str]:
    """Return the meaning of each character of a picture; chargers only where there are any."""
    return {sign: meaning for sign, meaning in LEGEND.items() if has_chargers or sign != CHARGER}


class WarehouseEnv(CopiedWhole):
    """The warehouse of the chapter's exercise.

    Description:
        A robot in a grid of walls picks up an item at a pickup and delivers it to a dropoff. It
        sees the cells around it, and its battery loses one unit in every step. On a charger, a tile
        that the chapter does not have, waiting charges the battery.

    Actions:
        ==========  ==========  ==========================================
        Index       Word        Action
        ==========  ==========  ==========================================
        0, 1, 2, 3  N, E, S, W  move one cell north, east, south or west
        4           WAIT        stay; charge the battery, on a charger
        5           PICK        take the item, on a pickup without an item
        6           DROP        deliver the item, on a dropoff with it
        ==========  ==========  ==========================================

    Observations:
        A dictionary, see ``Observation``.

    Rewards:
        See the table of ``warehouse_core/task/rules.py``.

    Ends:
        Terminated: the item is delivered. Truncated: ``max_steps`` are taken, or the battery is
        empty. Both may be true. Later steps are allowed, as in the chapter.

    Args:
        grid: equally long strings of ``#.PDC``, or a ``Layout``; ``None`` is the chapter's 7 x 12.
        start_pos: cell of the robot after ``reset()`` without ``randomize``; ``None`` is the
            layout's ``usual_start()``.
        max_steps: steps until the episode is truncated, 1 to ``MAX_BUDGET``.
        battery: battery units of a full charge, 1 to ``MAX_BUDGET``.
        view_radius: cells seen in each direction, 0 to ``MAX_VIEW_RADIUS``.
        backend: name, class or instance of the motion that carries out the moves.

    Raises:
        ValueError: an invalid layout or a start that is not open (``LayoutError``), a number that
            is too small, or an unknown backend (``BackendError``).
        TypeError: an argument of another type.

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
                "whose robots rest in each cell. FleetEnv takes both"
            )
        self.last_motion: Outcome | None = None
        self._placed: Cell = self._start_pos
        self.backend = backend if isinstance(backend, str) else type(self._motion).__name__
        self.reset()

    _repr_png_ = display  # which notebooks call

    def __repr__(self) -> str:
        return f"<WarehouseEnv {self.layout.summary()}, backend {self.backend!r}>"

    @property
    def grid(self) -> list[str]:
        """The current layout as a new list of strings, without the robot."""
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
        """Start of the robot without ``randomize``."""
        return self._start_pos

    @property
    def view_radius(self) -> int:
        """Number of cells that the robot sees in each direction."""
        return self._view_radius

    @property
    def motion(self) -> Motion:
        """The motion that carries out the moves."""
        return self._motion

    @property
    def settings(self) -> Settings:
        """The arguments of this environment without its layout."""
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
        """Start an episode: no item, full battery, no steps taken.

        Args:
            randomize: ``True`` to draw pickup, dropoff and start uniformly from the empty cells, in
                this order; ``"stations"`` or ``"start"`` to draw only those. A new pickup and
                dropoff replace the old ones for later resets too.
            seed: seed of ``random.Random``, from which the cells are drawn; ``None`` draws from
                the global ``random``. Pickup and dropoff are drawn from the cells that are empty
                before. With a seed that is before any draw, in the layout that was given to the
                environment, so a seed names the same episode in each of its uses. Without one it
                is before this draw, as in the chapter, so the episode also depends on the stations
                drawn last.

        Raises:
            LayoutError: fewer than two open cells without a charger, and stations are to be drawn.
            ValueError: ``randomize`` is another word, or ``seed`` is negative.
            TypeError: ``seed`` is not an integer. Nothing has changed after any of these.
        """
        drawn = what_is_drawn(randomize)
        seed = seed_number(seed)
        layout, start = self.layout, self._start_pos
        if randomize:
            stream = random if seed is None else random.Random(seed)
            if drawn.stations and seed is not None:
                layout = self._given_layout
            chargers = layout.ranks(layout.chargers)
            stations = layout.ranks(layout.pickups + layout.dropoffs)
            if drawn.stations:
                layout, stations = _draw_stations(stream, layout, stations + chargers)
            if drawn.start:
                start = self._draw_start(stream, layout, stations + chargers)
        return self._begin(layout, start, seed)

    def reset_to(
        self, layout: Layout, start_pos: Cell | None = None, seed: int | None = None
    ) -> Observation:
        """Start an episode in a given layout, which is kept for later resets.

        Args:
            layout: layout of any size.
            start_pos: start of this episode; ``None`` is the layout's ``usual_start()``.
            seed: seed of the random numbers of the motion backend.

        Raises:
            LayoutError: the start is not open; nothing has changed.
            TypeError: an argument of another type.
        """
        instance_of("layout", layout, Layout)
        start = self._start_in(layout, start_pos)
        seed = None if seed is None else whole_number("seed", seed)
        self._given_layout = layout
        return self._begin(layout, start, seed)

    def step(
        self, action: str | SupportsIndex
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Carry out one action, given as a word (any case) or an index.

        Returns:
            Observation, reward, terminated, truncated and info. ``info`` is empty, or contains
            ``invalid_action`` after an unknown word or an index out of range. The outcome of the
            motion is in ``last_motion``.

        Raises:
            TypeError: ``action`` is neither a string nor an integer; nothing has changed.
            LayoutError: ``state.robot_pos`` has been set to a cell that is not open.
        """
        index = action_index(action)
        reward, terminated, truncated = self.advance(index)
        info = {"invalid_action": True} if index == INVALID else {}
        return self.observe(), reward, terminated, truncated, info

    def advance(self, index: int) -> tuple[float, bool, bool]:
        """Carry out one action as ``step`` does, without an observation.

        Args:
            index: index of the action, or ``INVALID``; it is not checked.

        Returns:
            Reward, terminated and truncated.
        """
        state = self.state
        # Compared by identity: a cell that was assigned is another object, even if it is equal.
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
        """Return the grid as ``H`` lists of ``W`` characters, the robot ``R`` or ``r`` on top."""
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
        """Return a start given as a cell or as ``None``, checked."""
        if start_pos is None:
            return layout.usual_start()
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
        """Return a random empty cell, the usual start if there is none."""
        count = len(layout.open_cells)
        if count <= len(taken):
            return self._start_pos
        return layout.open_cell(_draw(stream, count, without=taken))


def _draw_stations(stream: Any, layout: Layout, taken: list[int]) -> tuple[Layout, list[int]]:
    """Return a layout with random pickup and dropoff, from the cells that are empty before.

    ``taken`` are the ranks of the present stations and chargers; the ranks of the new stations are
    returned too. With fewer than two empty cells there are none, as in the chapter's recorded
    episodes.
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
    """Draw one of ``range(count)`` that is not in ``without``.

    Equals ``choice`` from a list of what remains, without building the list.
    """
    index: int = stream.choice(range(count - len(without)))
    for taken in sorted(without):
        index += index >= taken
    return index
