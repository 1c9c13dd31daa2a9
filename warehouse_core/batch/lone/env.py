"""Many warehouses at once: ``B`` environments stepped together by NumPy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warehouse_core.arguments import (
    MAX_ENVS,
    MAX_STEPS,
    MAX_VIEW_RADIUS,
    one_of,
    sequence_of,
    whole_number,
)
from warehouse_core.batch.lone.draws import EpisodeDraws
from warehouse_core.batch.lone.engine import LoneEngine
from warehouse_core.batch.shell.checks import check_pool, one_layout_each
from warehouse_core.batch.shell.env import NEXT_STEP, ArrayEnv
from warehouse_core.batch.shell.floor import Floor
from warehouse_core.errors import BackendError
from warehouse_core.motion.backends import Backend, make_batch_motion
from warehouse_core.task.encoding import ObservationArrays
from warehouse_core.task.starts import what_is_drawn
from warehouse_core.task.state import WarehouseState
from warehouse_core.wording import brief
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import LayoutSet
from warehouse_core.world.tiles import TILES, Cell


class BatchEnv(ArrayEnv[ObservationArrays]):
    """``B`` warehouses with one robot each.

    Description:
        Row ``b`` equals a ``WarehouseEnv`` in its layout with the same actions, by the same rules
        and the same backends.

    Actions:
        ``[B]`` integers, 0 to 6: N, E, S, W, WAIT, PICK, DROP.

    Observations:
        The ``ObservationArrays`` of ``task/encoding.py`` with a leading ``B``.

    Rewards:
        The table in ``task/rules.py``, ``[B]`` float64.

    Ends:
        Terminated by the delivery; truncated when the steps or the battery are used up. Rows that
        have ended restart by ``autoreset_mode``.

    Args:
        num_envs: number of warehouses, ``B``, 1 to ``MAX_ENVS``.
        layout: one layout for all rows, or a list of ``B``; ``None`` is the chapter's.
        start_pos: start of robots that is not drawn, one for all rows or, without a pool, ``B`` of
            them; ``None`` is the usual start of each layout.
        max_steps: limit of an episode, 1 to ``MAX_STEPS``.
        battery: units of a full charge, 1 to ``MAX_STEPS``; every step costs one, and waiting on
            a charger charges.
        view_radius: cells seen in each direction, 0 to ``MAX_VIEW_RADIUS``; with 0 a robot sees
            only itself.
        randomize: ``True`` to draw pickup, dropoff and start for each episode, or ``"stations"`` or
            ``"start"`` for one of the two.
        autoreset_mode: time at which a row that has ended restarts: in the next step, which takes
            no action (``"NextStep"``), in the same step (``"SameStep"``), or only in a ``reset``
            with a mask (``"Disabled"``).
        backend: name, class or instance of a motion with a method ``batch``.
        pool: layouts of one size, instead of ``layout``. For each episode a row draws one of them,
            from its stream and before its start.
        marked: tiles of ``encoding.vector``: ``local_grid`` is then their ``marks``, from which
            vectors are made several times as fast as from codes; by default, and on very large
            floors, it is codes.

    Raises:
        ValueError: a value that is not allowed; also as ``LayoutError`` or ``BackendError``.
        TypeError: an argument of another type.

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
        self.randomize, drawn = randomize, what_is_drawn(randomize)
        if pool is not None:
            check_pool(pool, layout, start_pos)
        rows = one_layout_each(pool[0] if pool else layout, num_envs)
        layouts = LayoutSet(rows, pool or (), bare=drawn.stations)
        draws = EpisodeDraws(layouts, start_pos, drawn)
        marked = sequence_of("marked", marked, str)
        for tile in marked:
            one_of("marked", tile, TILES)
        floor = Floor(layouts, self.view_radius, moving_stations=drawn.stations, tiles=marked)
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
        """The seed of each row, which is random if none was given."""
        return tuple(map(self._lone.draws.seed_of, range(self.num_envs)))

    @property
    def streams(self) -> tuple[np.random.Generator, ...]:
        """The random stream of each row, from which ``reset`` draws its starts."""
        return tuple(map(self._lone.draws.stream, range(self.num_envs)))

    def row(self, row: int) -> tuple[Layout, WarehouseState]:
        """Return the layout and the state of one row; negative ones count from the end.

        Raises:
            EndedError: before a reset.
            ValueError: there is no such row.
        """
        self._check_started("row")
        return self._lone.state(whole_number("row", row, -self.num_envs, self.num_envs - 1))
