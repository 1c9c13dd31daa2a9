"""Places the robots and people of a fleet at the start of an episode."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import as_cell
from warehouse_core.batch.fleet.settings import FleetSettings
from warehouse_core.errors import LayoutError
from warehouse_core.motion.base import check_starts
from warehouse_core.task.starts import empty_cells
from warehouse_core.world.layout import Layout


class Placing:
    """The starts on a layout: given, the usual start of a lone robot, or drawn from empty cells.

    If robots and people need more than the empty cells, stations and chargers are drawn too.
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
                f"{settings.robots} robots and {settings.people.count} people have no room on the "
                f"{len(layout.open_cells)} open cells of the layout; one cell is needed for each"
            )
        self._rest = rest

    def draw(self, stream: np.random.Generator) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the cells of the robots, ``[R]``, and of the people, ``[P]``, all different."""
        drawn = stream.choice(self._rest, self._bodies - len(self._fixed), replace=False)
        cells = np.concatenate([self._fixed, drawn])
        return cells[: self._robots], cells[self._robots :]


def _fixed(layout: Layout, settings: FleetSettings) -> list[int]:
    """Return the numbers of the starts that are not drawn."""
    if settings.starts is None:
        return [layout.number(layout.usual_start())] if settings.robots == 1 else []
    cells = [as_cell(f"the start of robot {robot}", it) for robot, it in enumerate(settings.starts)]
    check_starts(layout, cells)
    return list(map(layout.number, cells))
