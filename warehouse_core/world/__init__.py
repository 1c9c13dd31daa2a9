"""The world of a robot: tiles, actions, and layouts with their generators and files.

Example:
    >>> from warehouse_core.world import DEFAULT_LAYOUT, Cell
    >>> start: Cell = (1, 1)  # row and column
    >>> DEFAULT_LAYOUT, DEFAULT_LAYOUT.is_open(start)
    (<Layout 7 x 12, pickup (1, 3), dropoff (5, 6)>, True)
"""

from warehouse_core.world.generators import benchmark_warehouse, random_layout, shelf_layout
from warehouse_core.world.layout import DEFAULT_LAYOUT, Layout
from warehouse_core.world.map_files import load_layout, load_map, save_layout, save_map
from warehouse_core.world.tiles import Cell

__all__ = [
    "DEFAULT_LAYOUT",
    "Cell",
    "Layout",
    "benchmark_warehouse",
    "load_layout",
    "load_map",
    "random_layout",
    "save_layout",
    "save_map",
    "shelf_layout",
]
