"""Which actions do something in one warehouse, as arrays, remembered from one look to the next."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from warehouse_core.task.encoding import Arrays, _arrays, _numbers, _window
from warehouse_core.task.rules import useful_actions
from warehouse_core.warehouse_env import WarehouseEnv
from warehouse_core.world.tiles import Cell


class ActionMasks:
    """The masks of one warehouse.

    Args:
        warehouse: in which the robot is; ``forget`` must be called where its layout changes.
    """

    def __init__(self, warehouse: WarehouseEnv) -> None:
        self._warehouse = warehouse
        self._walls: object = None
        self.forget()

    def forget(self) -> None:
        """Remember nothing any more but what follows from walls that are still the same."""
        self._masks: dict[tuple[Cell, bool], NDArray[np.int8]] = {}
        if self._walls is not self._warehouse.layout.open_cells:
            self._walls = self._warehouse.layout.open_cells
            self._sides: dict[Cell, tuple[bool, ...]] = {}

    def mask(self) -> NDArray[np.int8]:
        """Return ``[7]`` int8, fresh: 1 for each action that does something now."""
        state = self._warehouse.state
        key = (state.robot_pos, state.has_item)
        mask = self._masks.get(key)
        if mask is None:
            self._masks[key] = mask = self._look(*key)
        return mask.copy()

    def _look(self, cell: Cell, has_item: bool) -> NDArray[np.int8]:
        layout, (row, col) = self._warehouse.layout, cell
        sides = self._sides.get(cell)
        if sides is None:
            self._sides[cell] = sides = layout.open_sides(cell)
        return _as_array(sides, layout.rows[row][col], has_item)


@cache
def _as_array(open_sides: tuple[bool, ...], tile: str, has_item: bool) -> NDArray[np.int8]:
    return np.array(useful_actions(open_sides, tile, has_item), np.int8)


class Encoder:
    """Encodes what a robot senses in one episode, remembering what there is at each cell.

    What comes out is what ``encode`` gives, in less time.

    Args:
        warehouse: in which the robot is; ``forget`` must be called where its layout changes.
    """

    def __init__(self, warehouse: WarehouseEnv) -> None:
        self._warehouse = warehouse
        self._known: dict[tuple[Cell, bool], tuple[NDArray[np.uint8], NDArray[np.int32]]] = {}

    def forget(self) -> None:
        """Remember nothing any more."""
        self._known = {}

    def encode(self) -> Arrays:
        """Return what the robot senses now as fresh arrays."""
        state = self._warehouse.state
        key = (state.robot_pos, state.has_item)
        known = self._known.get(key)
        if known is None:
            observation = self._warehouse.observe()
            known = self._known[key] = _window(observation), _numbers(observation)
        numbers = known[1].copy()
        numbers[6], numbers[7] = state.battery, state.steps
        return _arrays(known[0].copy(), numbers, state.has_item)
