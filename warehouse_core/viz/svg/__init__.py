"""Animated drawings of tracks: SVG files that need no script."""

from warehouse_core.viz.svg.drawing import MAX_SVG_BYTES, animated_svg

__all__ = ["MAX_SVG_BYTES", "animated_svg"]
