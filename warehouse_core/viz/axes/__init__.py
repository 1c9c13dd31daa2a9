"""The style of axes, and heat maps of layouts."""

from warehouse_core.viz.axes.look import box_in, draw_grid, style_chart

__all__ = ["box_in", "draw_grid", "style_chart"]
