"""``B`` fleets of ``R`` robots as one structure of arrays, which are stepped together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import MAX_ENVS, as_cell, whole_number
from warehouse_core.batch.array_env import (
    NEXT_STEP,
    NO_FLOORS,
    ArrayEnv,
    EngineStep,
    one_layout_each,
)
from warehouse_core.batch.fleet_settings import STEPS, FleetSettings
from warehouse_core.batch.floor import ALL, FleetFloor
from warehouse_core.batch.kernels import (
    CHARGES,
    DELIVERED,
    OUT,
    OVER,
    PICKED,
    Fleets,
    Motions,
    Seen,
    judge_robots,
    mask_all,
    observe_all,
    show_all,
)
from warehouse_core.batch.order_books import OrderBooks
from warehouse_core.batch.people import MingledMotion, Walkers
from warehouse_core.batch.robots import HeadedRobots, RobotArrays
from warehouse_core.batch.tally import FleetMeasures, Tally
from warehouse_core.batch.verdicts import VERDICTS
from warehouse_core.compiled import IS_COMPILED
from warehouse_core.errors import LayoutError
from warehouse_core.motion.backends import Backend, make_fleet_motion, make_motion
from warehouse_core.motion.base import WALL, BaseBatchMotion, BatchOutcome, check_starts
from warehouse_core.motion.grid import GridFleetBatch
from warehouse_core.task.encoding import FleetArrays
from warehouse_core.task.rules import judge
from warehouse_core.task.starts import empty_cells
from warehouse_core.wording import brief
from warehouse_core.world.actions import PICK
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Flags, Integers, LayoutSet, Rows, size_of
from warehouse_core.world.tiles import EMPTY


class Placing:
    """The starts of robots and people on a layout.

    The starts of robots are given, or the default start of a single robot. All others are random
    empty cells. If these are too few, cells with stations and chargers are used too.
    """

    def __init__(self, layout: Layout, settings: FleetSettings) -> None:
        self._robots, self._bodies = settings.robots, settings.bodies
        self._fixed = np.array(_fixed(layout, settings), np.intp)
        rest = np.setdiff1d(empty_cells(layout), self._fixed)
        needed = self._bodies - len(self._fixed)
        if len(rest) < needed:
            rest = np.setdiff1d(layout.open_cells, self._fixed)
        if len(rest) < needed:
            raise LayoutError(
                f"{settings.robots} robots and {settings.people.count} people do not fit on the "
                f"{len(layout.open_cells)} open cells of the layout; each needs a cell"
            )
        self._rest = rest

    def draw(self, stream: np.random.Generator) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return random cells of the robots ``[R]`` and the people ``[P]``, all different."""
        random = stream.choice(self._rest, self._bodies - len(self._fixed), replace=False)
        cells = np.concatenate([self._fixed, random])
        return cells[: self._robots], cells[self._robots :]


def _fixed(layout: Layout, settings: FleetSettings) -> list[int]:
    """Return the cell numbers of the starts that are not random."""
    if settings.starts is None:
        return [layout.number(layout.default_start())] if settings.robots == 1 else []
    cells = [as_cell(f"the start of robot {robot}", it) for robot, it in enumerate(settings.starts)]
    check_starts(layout, cells)
    return list(map(layout.number, cells))


Numbers = NDArray[np.intp]

MAX_LOOPED_VIEWS = 1000
"""Most robots whose windows and masks loops fill in faster than NumPy, which copies whole rows."""

NO_HEADINGS = NO_ROWS = np.empty(0, np.intp)
NO_FLAGS = np.empty(0, np.bool_)
NO_DUE = np.empty(0, np.int32)

MOTION_TYPES = np.intp, np.bool_, np.float64, np.float64, np.intp, np.bool_
"""Types of the fields of ``Motions``."""

TAKEN = judge(PICK, EMPTY, False, False)
"""Verdict on a robot whose item has just been taken by another robot."""


class Judged(NamedTuple):
    """The results of the rules for ``N`` robots in a step.

    Attributes:
        rewards: ``[N]`` rewards, 0 for robots that had ended before.
        picked: rows of robots on a pickup that have picked.
        delivered: rows of robots that have delivered their items.
        out: rows of robots that can no longer drive.
        is_over: ``True`` if a floor has reached the limit of steps.
    """

    rewards: NDArray[np.float64]
    picked: Integers
    delivered: Integers
    out: Integers
    is_over: bool


class FleetEngine:
    """``B`` fleets, each on a floor of its own, with ``N = B * R`` robots in all.

    The rows of the robots are in order of their floors.

    Attributes:
        orders: order books; ``None`` without orders.
        battery: ``[N]`` float64, units left.
        steps: ``[B]`` steps taken.
        terminated: ``[N]`` flags of robots whose task is done.
        truncated: ``[N]`` flags of robots that are out of steps or battery or have failed, and of
            all robots in a fleet without any order left to deliver.
        failed: ``[N]`` flags of robots that have stopped for good, as the motion reports.
        ended: ``[N]`` flags of robots that are terminated or truncated; see ``Engine``.
        running: number of robots that have not ended.
    """

    def __init__(
        self, layouts: Sequence[Layout], settings: FleetSettings, backend: Backend
    ) -> None:
        motion: BaseBatchMotion = make_fleet_motion(backend, layouts, settings.bodies)
        self.layouts, self.settings = LayoutSet(layouts), settings
        floors, rows = len(layouts), len(layouts) * settings.robots
        self._floor = floor = FleetFloor(self.layouts, settings)
        self.orders = OrderBooks(self.layouts, settings, floor) if settings.has_orders else None
        self._starts = [Placing(kind, settings) for kind in self.layouts.kinds]
        self.walkers = Walkers(settings.people, self.layouts)
        self._is_grid = type(motion) is GridFleetBatch
        sizes = [size_of(kind) for kind in self.layouts.kinds]
        self._sizes = np.repeat(self.layouts.of_rows(sizes), settings.robots).astype(np.uintp)
        if settings.people.count:
            motion = MingledMotion(motion, settings.robots, self.walkers)
        self.motion = motion
        make_robots = HeadedRobots if settings.has_headings else RobotArrays
        self.robots = make_robots(self._floor, motion, rows)
        self._wait = settings.actions.wait
        self.tally = Tally(floors, settings.robots, settings.people.count, settings.actions)
        self._streams = [np.random.default_rng() for _ in layouts]
        self._costs_steps = settings.battery.unit == STEPS
        self._step_charge = settings.battery.step_charge(make_motion(backend).cell_size)
        self.battery = np.zeros(rows)
        self.steps = np.zeros(floors, np.int32)
        self.terminated, self.truncated, self.failed, self.ended = np.zeros((4, rows), np.bool_)
        self._views_in_loops = IS_COMPILED and rows <= MAX_LOOPED_VIEWS
        self._every_row, self._rows_ended, self.running = np.arange(rows), NO_ROWS, rows
        if not settings.has_orders:
            floor.put_own_stations(self._every_row)

    def begin(self, floors: Integers, seeds: Sequence[int | None]) -> None:
        """Start an episode on some floors; see ``Engine.begin``."""
        cells, motion_seeds = [], []
        for floor, seed in zip(floors.tolist(), seeds, strict=True):
            if seed is not None:
                self._streams[floor] = np.random.default_rng(seed)
            starts, orders, people, motion = self._streams[floor].spawn(4)
            robots, persons = self._starts[self.layouts.kind[floor]].draw(starts)
            cells.append(robots)
            self.walkers.enter(floor, persons, people)
            motion_seeds.append(int(motion.integers(2**32)))
            if self.orders:
                self.orders.begin(floor, orders)
        rows = self.rows_of(floors)
        self.robots.place(rows, np.concatenate(cells), motion_seeds)
        self.battery[rows] = self.settings.battery.capacity
        self.terminated[rows] = self.truncated[rows] = self.failed[rows] = False
        self.steps[floors] = 0
        self.tally.clear(floors)
        self._note_ended()
        self._release(self._rows_out())

    def step(self, actions: NDArray[np.intp], over: Integers = NO_FLOORS) -> EngineStep:
        """Carry out one action for each robot; see ``Engine.step``."""
        ended = self._rows_ended
        if len(ended):
            actions[ended] = self._wait
        outcome, counted = self.robots.move(actions)
        if outcome.failed is not None:
            self.failed = outcome.failed.copy()
        judge = self._judge_in_a_loop if IS_COMPILED else self._judge
        judged = judge(actions, counted, outcome)
        rewards = judged.rewards
        if self.orders and (len(judged.picked) or len(judged.delivered)):
            self._book(self.orders, judged)
        self._release(judged.out)
        self._end(judged)
        if self.settings.team_reward:
            teams = rewards.reshape(-1, self.settings.robots)
            teams[:] = teams.mean(axis=1, keepdims=True)
            rewards[ended] = 0.0
        flags = self.terminated.copy(), self.truncated.copy()
        if over.size:  # after the motion, because people must not walk before the first action
            self.begin(over, [None] * over.size)
        return EngineStep(outcome, rewards, *flags)

    def observe(self, rows: Rows = ALL) -> FleetArrays:
        """Return the observations of some robots, as new arrays."""
        if self._views_in_loops:
            every = self._every_row
            return self._observe_in_a_loop(every if rows is ALL else every[rows])
        self._floor.show(self.robots.cells, self.robots.has_item, self.walkers.cells)
        steps = self.steps.repeat(self.settings.robots)[rows]
        battery = self.battery[rows].astype(np.int32)  # this rounds down, as units are not negative
        arrays = cast(FleetArrays, self.robots.observe(rows, battery[:, None], steps[:, None]))
        if self.orders:
            arrays["due"] = self.orders.due[rows, None].copy()
        if self._floor.has_chargers and not self.settings.is_lone:
            arrays["charger_pos"] = self._floor.nearest_chargers(rows, self.robots.cells[rows])
        return arrays

    def masks(self) -> NDArray[np.int8]:
        """Return ``[N, 7]`` int8, or ``[N, 6]`` with headings: 1 for each action with an effect."""
        if not self._views_in_loops:
            return self.robots.masks()
        masks = np.empty((len(self.ended), len(self.settings.actions)), np.int8)
        cells, headings = self.robots.cells, self.headings
        mask_all(self._state(), self._floor.for_kernels, VERDICTS, cells, headings, masks)
        return masks

    def _observe_in_a_loop(self, rows: Numbers) -> FleetArrays:
        """Do the same as ``observe`` with a compiled loop."""
        count, settings, floor = len(rows), self.settings, self._floor
        arrays: dict[str, Any] = {
            "local_grid": np.empty((count, floor.views.windows.shape[1]), np.uint8),
            "robot_pos": np.empty((count, 2), np.int32),
            "has_item": np.empty(count, np.int64),
            "battery": np.empty((count, 1), np.int32),
            "steps": np.empty((count, 1), np.int32),
            "pickup_pos": np.empty((count, 2), np.int32),
            "dropoff_pos": np.empty((count, 2), np.int32),
        }
        if settings.has_headings:
            arrays["heading"] = np.empty(count, np.int64)
        if self.orders:
            arrays["due"] = np.empty((count, 1), np.int32)
        if floor.has_chargers and not settings.is_lone:
            arrays["charger_pos"] = np.empty((count, 2), np.int32)
        ground, views, state = floor.for_kernels, floor.views, self._state()
        cells, headings = self.robots.cells, self.headings
        due = self.orders.due if self.orders else NO_DUE
        show_all(state, ground, views, cells, self.walkers.cells)
        observe_all(state, ground, views, cells, due, headings, rows, Seen(**arrays))
        return cast(FleetArrays, arrays)

    @property
    def headings(self) -> Numbers:
        """Headings ``[N]``, 0 to 3 for N, E, S and W; an empty array if robots have no headings."""
        return self.robots.headings if isinstance(self.robots, HeadedRobots) else NO_HEADINGS

    def measures(self, floor: int) -> FleetMeasures:
        """Return the measures of the current episode on a floor."""
        rows = self.rows_of(np.array([floor]))
        book = self.orders.book(floor) if self.orders else None
        records = book.records() if book else None
        counted = self.tally.measures(floor, int(self.steps[floor]), records)
        stranded = int(np.isin(self._rows_out(), rows).sum())
        return replace(counted, stranded=stranded, lost=book.lost if book else 0)

    def rows_of(self, floors: Integers) -> NDArray[np.intp]:
        """Return the rows of all robots on some floors."""
        robots = self.settings.robots
        return (floors[:, None] * robots + np.arange(robots)).ravel()

    def close(self) -> None:
        """Close the motion backend."""
        self.motion.close()

    def _judge(self, actions: Numbers, counted: Numbers, outcome: BatchOutcome) -> Judged:
        """Apply the rules to the robots, and count the step.

        Args:
            actions: ``[N]`` actions of the robots.
            counted: ``[N]`` index in ``ACTIONS`` as which each action counts.
            outcome: outcome of the motion.
        """
        ended, had_item, before = self._rows_ended, self.robots.has_item, self.battery
        rewards, delivers, charging = self.robots.judge(counted, outcome)
        rewards[ended] = 0.0
        self.steps += 1
        self.battery = before - (1.0 if self._costs_steps else outcome.joules)
        self.battery[ended] = before[ended]
        if charging is not None:
            charging[ended] = False
            if np.count_nonzero(charging):
                self._charge(charging)
        np.maximum(self.battery, 0.0, out=self.battery)  # the last step may cost more than is left
        delivered = delivers.nonzero()[0]
        self.tally.add(actions, outcome, charging, delivered, ended)
        picked = (self.robots.has_item > had_item).nonzero()[0] if self.orders else NO_ROWS
        is_over = bool(np.count_nonzero(self.steps >= self.settings.max_steps))
        return Judged(rewards, picked, delivered, self._rows_out(), is_over)

    def _judge_in_a_loop(self, actions: Numbers, counted: Numbers, outcome: BatchOutcome) -> Judged:
        """Do the same as ``_judge`` with a compiled loop."""
        count, motions = len(self.ended), self._checked(outcome)
        self.robots.cells = motions.cells
        rewards, events = np.empty(count), np.empty(count, np.uint8)
        every = judge_robots(
            self._state(), self._floor.for_kernels, VERDICTS, self.tally.for_kernels, motions,
            actions, counted, rewards, events,
        )  # fmt: skip
        picked, delivered, out = (
            (events & kind).nonzero()[0] if every & kind else NO_ROWS
            for kind in (PICKED, DELIVERED, OUT)
        )
        if every & CHARGES:
            self._charge((events & CHARGES) > 0)
            np.maximum(self.battery, 0.0, out=self.battery)
            out = self._rows_out()
        return Judged(rewards, picked, delivered, out, every & OVER > 0)

    def _state(self) -> Fleets:
        settings = self.settings
        return Fleets(
            settings.robots, settings.max_steps, not self._costs_steps, self.steps,
            self.robots.has_item, self.battery, self.ended, self.failed,
        )  # fmt: skip

    def _checked(self, outcome: BatchOutcome) -> Motions:
        """Return the outcome of a motion for a kernel, which reads wherever its numbers lead.

        Raises:
            ValueError: an array has the wrong shape, or a cell or an obstacle does not exist.
        """
        cells, blocked, seconds, joules, stopped_by, _, driving, _ = outcome
        assert stopped_by is not None, "motions of fleets set it"
        motions = Motions(
            cells, blocked, seconds, joules, stopped_by, NO_FLAGS if driving is None else driving
        )
        if self._is_grid:
            return motions
        motions = Motions(*map(np.ascontiguousarray, motions, MOTION_TYPES))
        shapes = {each.shape for each in motions if each is not NO_FLAGS}
        # Negative numbers are very large as unsigned numbers.
        if (
            shapes != {self._sizes.shape}
            or np.any(motions.cells.view(np.uintp) >= self._sizes)
            or np.any((motions.stopped_by - WALL).view(np.uintp) >= self.settings.bodies - WALL)
        ):
            raise ValueError(f"the motion returned {brief(outcome)} for {len(self._sizes)} robots")
        return motions

    def _book(self, orders: OrderBooks, judged: Judged) -> None:
        """Record picks and deliveries, in the order of the robots."""
        robots, rewards = self.settings.robots, judged.rewards
        for row in judged.picked.tolist():
            step = int(self.steps[row // robots])
            if not orders.take(row, int(self.robots.cells[row]), step):
                self.robots.has_item[row], rewards[row] = False, TAKEN.reward
        for row in judged.delivered.tolist():
            late = orders.deliver(row, int(self.steps[row // robots]))
            rewards[row] -= self.settings.late_penalty * late

    def _charge(self, charging: Flags) -> None:
        """Charge the batteries of some robots after the cost of the step."""
        battery = self.settings.battery
        missing = battery.capacity - self.battery
        self.battery += charging * battery.supplied(missing, self._step_charge)

    def _release(self, out: Integers) -> None:
        """Release new orders, and handle the orders of robots that can no longer drive.

        Such robots give back the orders whose items they have not picked up. Orders that they hold
        or block are lost.

        Args:
            out: rows of robots that can no longer drive.
        """
        if self.orders:
            if len(out):
                self.orders.strand(out[~self.ended[out]])
            self.orders.release(self.steps, self.robots.cells, out)
            if len(out):
                freed = self.orders.lose(out, self.robots.cells[out])
                self.robots.has_item[freed] = False

    def _end(self, judged: Judged) -> None:
        """Set the flags of robots that end in this step."""
        robots, orders, out = self.settings.robots, self.orders, judged.out
        is_done = orders.has_ended if orders else len(judged.delivered)
        if not (len(out) or is_done or judged.is_over):
            return
        active, is_over = ~self.ended, self.steps >= self.settings.max_steps
        done, is_out = np.zeros((2, len(active)), np.bool_)
        if orders:
            done, is_over = np.repeat(orders.all_delivered, robots), is_over | orders.rest_is_lost
        else:
            done[judged.delivered] = True
        self.terminated |= active & done
        is_out[out] = True
        flat = np.flatnonzero(active & is_out & ~self.failed)
        if len(flat):
            self.motion.fail(flat)
        self.truncated |= active & (is_out | np.repeat(is_over, robots))
        self._note_ended()

    def _note_ended(self) -> None:
        self.ended = self.terminated | self.truncated
        self._rows_ended = self.ended.nonzero()[0]
        self.running = len(self.ended) - len(self._rows_ended)

    def _rows_out(self) -> Numbers:
        """Return the rows of robots that can no longer drive: battery empty, or failed."""
        return ((self.battery <= 0) | self.failed).nonzero()[0]


class FleetBatch(ArrayEnv[FleetArrays]):
    """``B`` fleets of ``R`` robots; row ``b * R + r`` is robot ``r`` of fleet ``b``.

    Description:
        Fleet ``b`` equals a ``FleetEnv`` in its layout with the same seed and actions. A policy
        that is trained on the rows is shared by all robots.

    Actions:
        ``[N]`` integers, indices of the actions of ``FleetEnv``; ``N = B * R``.

    Observations:
        ``FleetArrays`` with a leading ``N``.

    Rewards:
        The rewards of ``FleetEnv``, ``[N]`` float64.

    Ends:
        Robots end as in ``FleetEnv``. A robot that ends before others of its fleet waits, gets no
        reward, and keeps its flags. A fleet restarts when all its robots have ended, as
        ``autoreset_mode`` determines.

    Args:
        fleets: number of fleets, ``B``, 1 to ``MAX_ENVS``.
        layout: one layout for all fleets, or a list of ``B``; ``None`` is the chapter's layout.
        robots: number of robots of each fleet, ``R``, at least 1.
        backend: name, class or instance of the motion that carries out the moves.
        autoreset_mode: time at which a fleet that has ended restarts, see ``BatchEnv``.
        settings: other arguments of ``FleetEnv``, except ``seed``.

    Raises:
        ValueError: an argument is not allowed; it may be a ``LayoutError``, ``OrderError`` or
            ``BackendError``.
        TypeError: an argument has the wrong type.

    Example:
        >>> from warehouse_core.fleet import FleetBatch
        >>> batch = FleetBatch(8, robots=4, orders=0.1)
        >>> observation, info = batch.reset(seed=1)
        >>> observation["robot_pos"].shape
        (32, 2)
    """

    def __init__(
        self,
        fleets: int,
        layout: Layout | Sequence[Layout] | None = None,
        robots: int = 2,
        *,
        backend: Backend = "grid",
        autoreset_mode: str = NEXT_STEP,
        **settings: Any,
    ) -> None:
        self.fleets = whole_number("fleets", fleets, 1, MAX_ENVS)
        layouts = one_layout_each(layout, self.fleets)
        self.settings = FleetSettings.of(robots, **settings)
        self.max_steps, self.max_battery = self.settings.max_steps, self.settings.battery.capacity
        self.view_radius = self.settings.view_radius
        self._fleets = FleetEngine(layouts, self.settings, backend)
        actions = len(self.settings.actions)
        super().__init__(self._fleets, self.fleets, self.settings.robots, autoreset_mode, actions)

    def measures(self, fleet: int) -> FleetMeasures:
        """Return the measures of a fleet in its current episode."""
        return self._fleets.measures(whole_number("fleet", fleet, 0, self.fleets - 1))
