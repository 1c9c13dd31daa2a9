"""Pictures as arrays of pixels, painted with NumPy."""

from warehouse_core.render.observation_image import ObservationImage
from warehouse_core.render.painter import TilePainter, tile_pixels_for
from warehouse_core.render.window import PictureWindow, has_display

__all__ = ["ObservationImage", "PictureWindow", "TilePainter", "has_display", "tile_pixels_for"]
