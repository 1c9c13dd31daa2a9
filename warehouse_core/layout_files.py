"""Layouts in files of either format: rows of tiles, or MovingAI's ``.map``."""

from __future__ import annotations

from pathlib import Path

from warehouse_core.layout import Layout
from warehouse_core.moving_ai import SUFFIX, load_map, save_map


def load_layout(path: str | Path) -> Layout:
    """Read a layout; the suffix ``.map`` is MovingAI's.

    Raises:
        LayoutError: it is no layout; with the file's name in front.
        OSError: the file cannot be read.
    """
    return load_map(path) if Path(path).suffix.lower() == SUFFIX else Layout.load(path)


def save_layout(layout: Layout, path: str | Path) -> None:
    """Write a layout; as ``.map`` its stations become floor.

    Raises:
        OSError: the file cannot be written.
    """
    if Path(path).suffix.lower() == SUFFIX:
        save_map(layout, path)
    else:
        layout.save(path)
