"""``B`` single robots, each on a floor of its own, which NumPy steps together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import (
    MAX_ENVS,
    MAX_STEPS,
    MAX_VIEW_RADIUS,
    as_cell,
    one_of,
    sequence_of,
    whole_number,
)
from warehouse_core.batch.array_env import (
    NEXT_STEP,
    NO_FLOORS,
    ArrayEnv,
    EngineStep,
    check_pool,
    one_layout_each,
)
from warehouse_core.batch.floor import ALL, BatchFloor
from warehouse_core.batch.robots import RobotArrays
from warehouse_core.batch.verdicts import spend_and_charge
from warehouse_core.errors import BackendError
from warehouse_core.motion.backends import Backend, make_batch_motion
from warehouse_core.motion.base import BaseBatchMotion
from warehouse_core.task.encoding import ObservationArrays
from warehouse_core.task.starts import (
    DRAWS,
    NO_RANK,
    Randomized,
    check_room,
    draw_ranks,
    draw_start_ranks,
    empty_cells,
    randomized_parts,
    station_cells,
)
from warehouse_core.task.state import WarehouseState
from warehouse_core.wording import brief
from warehouse_core.world.actions import WAIT
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tables import Integers, LayoutSet, Rows
from warehouse_core.world.tiles import TILES, Cell


class EpisodeDraws:
    """Random stations and starts of ``B`` rows; see ``task/starts.py``.

    If ``layouts`` has ``others``, each row gets a random one of them.
    """

    def __init__(
        self, layouts: LayoutSet, start_pos: Cell | Sequence[Cell] | None, randomized: Randomized
    ) -> None:
        self._randomized, self._layouts = randomized, layouts
        start, starts = _given_starts(len(layouts.kind), start_pos)
        self._start_of_kind = np.array([_start_in(kind, start) for kind in layouts.kinds])
        self._starts = layouts.of_rows(self._start_of_kind)
        for row, each in enumerate(starts):
            self._starts[row] = _start_in(layouts.rows[row], each, f"start_pos[{row}]")
        # Random stations are cells without a charger, and random starts cells without a station.
        cells = [station_cells(k) if randomized.stations else empty_cells(k) for k in layouts.kinds]
        counts = [len(each) for each in cells]
        self._counts = np.array(counts)
        self._cells = np.concatenate(cells)
        self._first = np.cumsum([0, *counts])[:-1]
        self._seeds: dict[int, int] = {}
        self._streams: dict[int, np.random.Generator] = {}
        if randomized.stations:
            for layout in layouts.kinds:
                check_room(layout)

    def seed(self, rows: Integers, seeds: Sequence[int | None]) -> None:
        """Restart the random streams of the rows that have a seed."""
        for row, seed in zip(rows.tolist(), seeds, strict=True):
            if seed is not None:
                self._seeds[row] = seed
                self._streams.pop(row, None)

    def seed_of(self, row: int) -> int:
        """Return the last seed of a row, or choose a random one if the row has none."""
        if row not in self._seeds:
            entropy = np.random.SeedSequence().entropy
            assert isinstance(entropy, int), "it comes from the operating system"
            self._seeds[row] = entropy
        return self._seeds[row]

    def stream(self, row: int) -> np.random.Generator:
        """Return the random stream of a row, which is created when it is first needed."""
        if row not in self._streams:
            self._streams[row] = np.random.default_rng(self.seed_of(row))
        return self._streams[row]

    def draw_layouts(self, rows: Integers) -> list[Layout]:
        """Give some rows random layouts from the ``others``, and return these layouts."""
        others = self._layouts.others
        chosen = [others[int(self.stream(row).random() * len(others))] for row in rows.tolist()]
        self._layouts.change(rows, chosen)
        self._starts[rows] = self._start_of_kind[self._layouts.kind[rows]]
        return chosen

    def draw(self, rows: Integers) -> tuple[Integers | None, Integers]:
        """Return the stations and starts of the next episodes of some rows.

        Returns:
            Pickups and dropoffs ``[2, N]``, or ``None`` if they are not random, and starts ``[N]``,
            all as cell numbers within their layouts.
        """
        starts = self._starts[rows]
        if not any(self._randomized):
            return None, starts
        uniforms = np.array([self.stream(row).random(DRAWS) for row in rows.tolist()])
        uniforms, kinds = uniforms.reshape(-1, DRAWS), self._layouts.kind[rows]
        counts, first, stations = self._counts[kinds], self._first[kinds], None
        if self._randomized.stations:
            ranks = draw_ranks(uniforms, counts).T
            stations, ranks = self._cells.take(first + ranks[:2]), ranks[2]
        else:
            ranks = draw_start_ranks(uniforms, counts)
        if self._randomized.start:
            cells = self._cells.take(first + ranks, mode="clip")
            starts = np.where(ranks == NO_RANK, starts, cells)
        return stations, starts


def _given_starts(rows: int, start_pos: Any) -> tuple[Any, Sequence[Any]]:
    """Return the common start of all rows, or ``None``, and the starts given for each row."""
    if start_pos is None:
        return None, ()
    if not isinstance(start_pos, (list, tuple, np.ndarray)):
        raise TypeError(f"start_pos is {brief(start_pos)}; it must be a cell, or one for each row")
    try:
        given = np.asarray(start_pos)
    except ValueError:  # rows of different lengths
        given = np.asarray(start_pos, object)
    if given.shape == (2,):
        return given.tolist(), ()
    if given.shape == (rows, 2):
        return None, given.tolist()
    raise ValueError(
        f"start_pos has the shape {given.shape}; allowed: one cell (row, column) for all "
        f"rows, or one for each, shape ({rows}, 2)"
    )


def _start_in(layout: Layout, start_pos: Any, name: str = "start_pos") -> int:
    """Return the cell number of a start in a layout; ``None`` is the default start."""
    if start_pos is None:
        return layout.number(layout.default_start())
    cell = as_cell(name, start_pos)
    check_open(layout, cell, name)
    return layout.number(cell)


class LoneEngine:
    """The episodes of ``B`` single robots; see ``Engine``."""

    def __init__(
        self,
        layouts: LayoutSet,
        draws: EpisodeDraws,
        floor: BatchFloor,
        motion: BaseBatchMotion,
        max_steps: int,
        battery: int,
    ) -> None:
        count = len(layouts.kind)
        self.layouts, self.draws, self._floor, self._motion = layouts, draws, floor, motion
        self._robots = RobotArrays(floor, motion, count)
        self._max_steps, self._max_battery = max_steps, battery
        self._steps = np.zeros(count, np.int32)
        self.ended = np.zeros(count, np.bool_)
        # Without chargers the battery follows from the steps and needs no array.
        self._battery = np.zeros(count, np.int32) if floor.has_chargers else None
        self._last_step = min(max_steps, battery)

    def begin(self, floors: Integers, seeds: Sequence[int | None]) -> None:
        """Start an episode on some floors; see ``Engine.begin``."""
        self.draws.seed(floors, seeds)
        if self.layouts.others:
            self._motion.change(floors, self.draws.draw_layouts(floors))
        stations, starts = self.draws.draw(floors)
        if stations is None:
            self._floor.put_own_stations(floors)
        else:
            self._floor.put_stations(floors, stations)
        self._robots.place(floors, starts)
        self.ended[floors], self._steps[floors] = False, 0
        if self._battery is not None:
            self._battery[floors] = self._max_battery

    def step(self, actions: NDArray[np.intp], over: Integers = NO_FLOORS) -> EngineStep:
        """Carry out one action for each robot; see ``Engine.step``."""
        if over.size:
            self.begin(over, [None] * over.size)
            actions[over] = WAIT
        outcome, rewards, terminated, charging = self._robots.step(actions)
        rewards[over] = 0.0
        self._steps += 1
        self._steps[over] = 0
        if self._battery is None or charging is None:
            truncated = self._steps >= self._last_step
        else:
            spend_and_charge(self._battery, self._max_battery, charging)
            self._battery[over] = self._max_battery
            truncated = (self._steps >= self._max_steps) | (self._battery <= 0)
        self.ended = terminated | truncated
        return EngineStep(outcome, rewards, terminated, truncated)

    def observe(self, rows: Rows = ALL) -> ObservationArrays:
        """Return the observations of some robots, as new arrays."""
        steps = self._steps[rows][:, None]
        return self._robots.observe(rows, self._units(rows)[:, None], steps.copy())

    def masks(self) -> NDArray[np.int8]:
        """Return the masks ``[B, 7]`` int8: 1 for each action with an effect."""
        return self._robots.masks()

    def state(self, row: int) -> tuple[Layout, WarehouseState]:
        """Return the layout of a row, including its stations, and the state of its robot."""
        layout, robots = self.layouts.kinds[self.layouts.kind[row]], self._robots
        if self._floor.moving_stations:
            layout = layout.with_stations(*map(tuple, self._floor.station_places[:, row].tolist()))
        cell, has_item = layout.cell(robots.cells[row]), bool(robots.has_item[row])
        battery, steps = int(self._units(np.array([row]))[0]), int(self._steps[row])
        return layout, WarehouseState(cell, has_item, battery, steps)

    def close(self) -> None:
        """Close the motion backend."""
        self._motion.close()

    def _units(self, rows: Rows) -> NDArray[np.int32]:
        """Return the battery units of some rows as a new array."""
        if self._battery is None:
            return self._max_battery - self._steps[rows]
        return self._battery[rows].copy()


class BatchEnv(ArrayEnv[ObservationArrays]):
    """``B`` warehouses with one robot each.

    Description:
        Row ``b`` equals a ``WarehouseEnv`` in its layout with the same actions. The rules and
        backends are the same.

    Actions:
        ``[B]`` integers, 0 to 6: N, E, S, W, WAIT, PICK, DROP.

    Observations:
        The ``ObservationArrays`` of ``task/encoding.py`` with a leading ``B``.

    Rewards:
        The table in ``task/rules.py``, ``[B]`` float64.

    Ends:
        A row is terminated by the delivery, and truncated when its steps or battery are used up.
        Rows that have ended restart as ``autoreset_mode`` determines.

    Args:
        num_envs: number of warehouses, ``B``, 1 to ``MAX_ENVS``.
        layout: one layout for all rows, or a list of ``B``; ``None`` is the chapter's layout.
        start_pos: start of robots whose start is not random: one cell for all rows or, without a
            pool, a cell for each. ``None`` is the default start of each layout.
        max_steps: limit of an episode, 1 to ``MAX_STEPS``.
        battery: units of a full charge, 1 to ``MAX_STEPS``. Every step costs one unit, and waiting
            on a charger charges the battery.
        view_radius: cells seen in each direction, 0 to ``MAX_VIEW_RADIUS``. With 0 a robot sees
            only its own cell.
        randomize: ``True`` for a random pickup, dropoff and start in each episode, ``"stations"``
            for the first two, or ``"start"`` for the last.
        autoreset_mode: time at which a row that has ended restarts: in the next step, which takes
            no action (``"NextStep"``), in the same step (``"SameStep"``), or only in a ``reset``
            with a mask (``"Disabled"``).
        backend: name, class or instance of a motion with a method ``batch``.
        pool: layouts of the same size, instead of ``layout``. Each episode of a row uses a random
            one of them, which is chosen before the start.
        marked: tiles of ``encoding.vector`` for which ``local_grid`` has ``marks``. Making vectors
            from marks is several times as fast as from codes. By default, and on very large floors,
            ``local_grid`` has codes.

    Raises:
        ValueError: an argument is not allowed; it may be a ``LayoutError`` or ``BackendError``.
        TypeError: an argument has the wrong type.

    Example:
        >>> from warehouse_core import BatchEnv
        >>> batch = BatchEnv(3)
        >>> observation, info = batch.reset(seed=1)
        >>> observation, rewards, terminated, truncated, info = batch.step([0, 1, 2])
        >>> rewards.shape, observation["robot_pos"].shape
        ((3,), (3, 2))
    """

    def __init__(
        self,
        num_envs: int,
        layout: Layout | Sequence[Layout] | None = None,
        start_pos: Cell | Sequence[Cell] | None = None,
        max_steps: int = 200,
        battery: int = 200,
        view_radius: int = 2,
        *,
        randomize: bool | str = True,
        autoreset_mode: str = NEXT_STEP,
        backend: Backend = "grid",
        pool: Sequence[Layout] | None = None,
        marked: tuple[str, ...] = (),
    ) -> None:
        num_envs = whole_number("num_envs", num_envs, 1, MAX_ENVS)
        self.max_steps = whole_number("max_steps", max_steps, 1, MAX_STEPS)
        self.max_battery = whole_number("battery", battery, 1, MAX_STEPS)
        self.view_radius = whole_number("view_radius", view_radius, 0, MAX_VIEW_RADIUS)
        self.randomize, randomized = randomize, randomized_parts(randomize)
        if pool is not None:
            check_pool(pool, layout, start_pos)
        rows = one_layout_each(pool[0] if pool else layout, num_envs)
        layouts = LayoutSet(rows, pool or (), bare=randomized.stations)
        draws = EpisodeDraws(layouts, start_pos, randomized)
        marked = sequence_of("marked", marked, str)
        for tile in marked:
            one_of("marked", tile, TILES)
        floor = BatchFloor(
            layouts, self.view_radius, moving_stations=randomized.stations, tiles=marked
        )
        motion = make_batch_motion(backend, layouts.rows)
        if pool is not None and not motion.changes_layouts:
            raise BackendError(
                f"backend {brief(backend)} cannot change layouts, which a pool needs; its batch "
                "would need a method change(floors, layouts)"
            )
        self._lone = LoneEngine(layouts, draws, floor, motion, self.max_steps, self.max_battery)
        super().__init__(self._lone, num_envs, 1, autoreset_mode)

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seed of each row, random for rows without a given seed."""
        return tuple(map(self._lone.draws.seed_of, range(self.num_envs)))

    @property
    def streams(self) -> tuple[np.random.Generator, ...]:
        """The random stream of each row, which ``reset`` uses."""
        return tuple(map(self._lone.draws.stream, range(self.num_envs)))

    def row(self, row: int) -> tuple[Layout, WarehouseState]:
        """Return the layout and the state of a row; negative numbers count from the end.

        Raises:
            EndedError: the batch has not been reset yet.
            ValueError: the row does not exist.
        """
        self._check_started("row")
        return self._lone.state(whole_number("row", row, -self.num_envs, self.num_envs - 1))
