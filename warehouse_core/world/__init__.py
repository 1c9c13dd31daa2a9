"""The world of a robot: tiles, actions, layouts, their generators and their files."""

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
