"""A figure that redraws only what moves.

Walls, axes and legend never change. They are drawn once into a background, and each frame is the
background with the moving artists on top, in a window as in an exported file.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.backend_bases import DrawEvent
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.figure import Figure
from PIL import Image

from warehouse_core.render.palette import indexed_palette

DPI = 100


class SceneFigure(Figure):
    """A ``Figure`` with movers: artists that are drawn last and do not make it stale."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._movers: list[Artist] = []
        self._background: Any = None
        self._background_size: tuple[float, float, float] | None = None
        self._is_wanted = True
        self.replay: object = None

    def add_mover(self, artist: Artist) -> None:
        """Declare that ``artist`` changes from frame to frame."""
        # Matplotlib keeps the changes of an animated artist from making the figure stale.
        artist.set_animated(True)
        self._movers.append(artist)

    def draw(self, renderer: Any) -> None:
        """Draw the movers over the background, which is drawn again only if it has changed."""
        if not self._is_wanted:
            return
        is_pixels = isinstance(renderer, RendererAgg)
        if not is_pixels:
            self._draw_still(renderer, with_movers=True)
            return
        size = (renderer.width, renderer.height, renderer.dpi)
        if self.stale or size != self._background_size:
            # Listeners are told later: one of them, a replay, would change the movers.
            with self.canvas.callbacks.blocked(signal="draw_event"):
                self._draw_still(renderer, with_movers=False)
            self._background = renderer.copy_from_bbox(self.bbox)
            self._background_size = size
        else:
            renderer.restore_region(self._background)
        for artist in self._movers:
            artist.draw(renderer)
        self.canvas.callbacks.process("draw_event", DrawEvent("draw_event", self.canvas, renderer))

    def savefig(self, fname: Any, *, transparent: bool | None = None, **options: Any) -> None:
        """Save as ``Figure.savefig`` does, but faster for pixels at the figure's own resolution."""
        own_size = options.get("dpi", "figure") in ("figure", self.dpi)
        kind = options.get("format") if hasattr(fname, "write") and own_size else None
        if kind == "png":
            self.indexed_pixels().save(fname, "png")
        elif kind in ("rgba", "raw"):
            fname.write(self.pixels().convert("RGBA").tobytes())
        else:
            super().savefig(fname, transparent=transparent, **options)

    @contextmanager
    def drawn_on_demand(self) -> Iterator[None]:
        """Draw only when ``pixels`` is called.

        Otherwise matplotlib would draw each frame of an animation once more while saving it.
        """
        self._is_wanted = False
        try:
            yield
        finally:
            self._is_wanted = True

    def pixels(self) -> Image.Image:
        """Return the figure as an RGB image."""
        if not isinstance(self.canvas, FigureCanvasAgg):
            raise TypeError(f"a {type(self.canvas).__name__} has no pixels; it must be an Agg one")
        canvas: Any = self.canvas
        before, self._is_wanted = self._is_wanted, True
        try:
            canvas.draw()
        finally:
            self._is_wanted = before
        return Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")

    def indexed_pixels(self) -> Image.Image:
        """Return the figure as an image of 256 colours, the same ones for every frame."""
        palette = Image.new("P", (1, 1))
        palette.putpalette(indexed_palette())
        return self.pixels().quantize(palette=palette, dither=Image.Dither.NONE)

    def _draw_still(self, renderer: Any, *, with_movers: bool) -> None:
        """Draw everything but the movers, or everything."""
        shown = [artist for artist in self._movers if artist.get_visible()]
        for artist in shown:
            artist.set_animated(not with_movers)
            artist.set_visible(with_movers)
        super().draw(renderer)
        for artist in shown:
            artist.set_animated(True)
            artist.set_visible(True)
        self.stale = False


def make_figure(size: tuple[float, float], dpi: float = DPI) -> SceneFigure:
    """Return a figure of ``size`` inches that needs no display."""
    figure = SceneFigure(figsize=size, dpi=dpi)
    FigureCanvasAgg(figure)
    return figure


def make_window(size: tuple[float, float], dpi: float = DPI) -> SceneFigure:
    """Return a figure in a window that ``matplotlib.pyplot.show`` will open.

    Matplotlib's own keys are disabled, because they would clash with those of replays.
    """
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=size, dpi=dpi, FigureClass=SceneFigure)
    assert isinstance(figure, SceneFigure)
    manager = figure.canvas.manager
    assert manager is not None, "pyplot gives each figure one"
    manager.set_window_title("Warehouse")
    if manager.key_press_handler_id is not None:  # pragma: no branch - with a tool manager
        figure.canvas.mpl_disconnect(manager.key_press_handler_id)
    return figure


def save_svg(figure: Figure, target: Path | IO[bytes], dpi: float | None = None) -> None:
    """Write a figure as SVG; figures that show the same give the same bytes."""
    with mpl.rc_context({"svg.hashsalt": "warehouse-lab", "svg.fonttype": "path"}):
        figure.savefig(target, format="svg", dpi=dpi or figure.dpi, metadata={"Date": None})
