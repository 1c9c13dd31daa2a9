"""Animated drawings of tracks: one file of SVG each, without a script."""

from warehouse_core.viz.svg.drawing import MAX_SVG_BYTES, animated_svg

__all__ = ["MAX_SVG_BYTES", "animated_svg"]
