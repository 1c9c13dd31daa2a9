"""What a robot observes and what it can usefully do, as arrays, cached by cell."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from warehouse_core.task.encoding import Arrays, _arrays, _numbers, _window
from warehouse_core.task.rules import useful_actions
from warehouse_core.warehouse_env import WarehouseEnv
from warehouse_core.world.tiles import Cell

_Known = tuple[NDArray[np.uint8], NDArray[np.int32], NDArray[np.int8]]


class View:
    """Observations and action masks of one warehouse, as fresh arrays.

    They depend only on the cell, the load and the layout, except for battery and steps.

    Args:
        warehouse: to look at; call ``forget`` whenever its layout changes.
    """

    def __init__(self, warehouse: WarehouseEnv) -> None:
        self._warehouse = warehouse
        self._walls: object = None
        self.forget()

    def forget(self) -> None:
        """Clear the cache, except for what follows from the walls if they are the same."""
        self._known: dict[tuple[Cell, bool], _Known] = {}
        walls = self._warehouse.layout.open_cells
        if walls is not self._walls:
            self._walls = walls
            self._sides: dict[Cell, tuple[bool, ...]] = {}

    def look(self) -> tuple[Arrays, NDArray[np.int8]]:
        """Return what ``encode`` gives for the observation now, and the mask.

        The mask is ``[7]`` int8: 1 for each action that does something now.
        """
        state = self._warehouse.state
        key = (state.robot_pos, state.has_item)
        known = self._known.get(key)
        if known is None:
            known = self._known[key] = self._encode(*key)
        window, numbers, mask = known
        numbers = numbers.copy()
        numbers[6], numbers[7] = state.battery, state.steps
        return _arrays(window.copy(), numbers, state.has_item), mask.copy()

    def _encode(self, cell: Cell, has_item: bool) -> _Known:
        observation, layout = self._warehouse.observe(), self._warehouse.layout
        sides = self._sides.get(cell)
        if sides is None:
            self._sides[cell] = sides = layout.open_sides(cell)
        mask = _as_array(sides, layout.rows[cell[0]][cell[1]], has_item)
        return _window(observation), _numbers(observation), mask


@cache
def _as_array(open_sides: tuple[bool, ...], tile: str, has_item: bool) -> NDArray[np.int8]:
    return np.array(useful_actions(open_sides, tile, has_item), np.int8)
