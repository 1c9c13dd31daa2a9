"""Many fleets at once: ``B`` warehouses with ``R`` robots each, for learning."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from warehouse_core.arguments import MAX_ENVS, whole_number
from warehouse_core.batch.fleet.engine import FleetEngine
from warehouse_core.batch.fleet.settings import FleetSettings
from warehouse_core.batch.fleet.tally import FleetMeasures
from warehouse_core.batch.shell.checks import one_layout_each
from warehouse_core.batch.shell.env import NEXT_STEP, ArrayEnv
from warehouse_core.motion.backends import Backend
from warehouse_core.task.encoding import FleetArrays
from warehouse_core.world.layout import Layout


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
        Robots end as in ``FleetEnv``. A robot that has ended before others of its fleet waits,
        without a reward, and its flags stay set; a fleet of which all robots have ended restarts by
        ``autoreset_mode``.

    Args:
        fleets: number of fleets, ``B``, 1 to ``MAX_ENVS``.
        layout: one layout for all fleets, or a list of ``B``; ``None`` is the chapter's.
        robots: number of robots of each fleet, ``R``, at least 1.
        backend: name, class or instance of the motion that carries out the moves.
        autoreset_mode: time at which a fleet that has ended restarts; see ``BatchEnv``.
        settings: all other arguments of ``FleetEnv`` but ``seed``.

    Raises:
        ValueError: a value that is not allowed; also as ``LayoutError``, ``OrderError`` or
            ``BackendError``.
        TypeError: an argument of another type.

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
        """Return how well a fleet has done in its present episode."""
        return self._fleets.measures(whole_number("fleet", fleet, 0, self.fleets - 1))
