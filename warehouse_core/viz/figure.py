"""A figure that redraws only what moves.

Walls, axes and legend never change. They are drawn once into a background, and each frame is the
background with the moving artists on top, both in a window and in an exported file. The moving
artists are redrawn only in those parts of the figure that have changed. A part is the area of some
axes, or one text of the figure. Each mover of axes has a layer, which is the picture of its part
with this mover and all below it. Only the smallest box around the changed shapes is drawn again.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import DrawEvent
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

from warehouse_core.render.palette import INK
from warehouse_core.viz.axes import POINTS
from warehouse_core.viz.gif_writer import ColorValues
from warehouse_core.viz.line_of_text import LineOfText
from warehouse_core.viz.pixel_box import PixelBox, around, box_around
from warehouse_core.viz.shapes import Shape, Shapes

DPI = 100
"""Pixels in an inch."""

AROUND_AXES, AROUND_TEXT = 8.0, 3.0
"""Margins in points around axes and around a text, into which their movers may draw."""

Part = tuple[float, ...] | Artist

Layer = tuple[ColorValues, Sequence[Shape]]
"""The pixels of a part with a mover and all below it, and the shapes of this mover."""


class SceneFigure(Figure):
    """A ``Figure`` with movers: artists that are drawn last and do not make it stale.

    Attributes:
        replay: replay that plays the figure, if there is one.
        changed: boxes around the parts that changed when the figure was last drawn.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._movers: list[Artist] = []
        self._background: ColorValues = np.empty((0, 0, 4), np.uint8)
        self._shown = self._background
        self._background_size: tuple[float, float, float] | None = None
        self._parts: dict[Part, list[Artist]] = {}
        self._boxes: dict[Part, PixelBox] = {}
        self._layers: dict[Artist, Layer] = {}
        self.changed: list[PixelBox] = []
        self.replay: object = None

    def add_mover(self, artist: Artist) -> None:
        """Declare that ``artist`` changes from frame to frame."""
        # Matplotlib keeps the changes of an animated artist from making the figure stale.
        artist.set_animated(True)
        self._movers.append(artist)
        self.stale = True

    def add_movers(self, axes: Axes, *artists: Artist) -> None:
        """Add artists to axes, and declare that they change from frame to frame."""
        for artist in artists:
            axes.add_artist(artist)
            self.add_mover(artist)

    def add_text(self, left: float, top: float, **style: Any) -> Text:
        """Add a text that changes from frame to frame, in inches from the top left corner."""
        width, height = self.get_size_inches()
        usual: dict[str, Any] = {"color": INK, "va": "center", "parse_math": False}
        text = LineOfText(left / width, 1 - top / height, **usual | style)
        text.set_figure(self)
        text.set_transform(self.transFigure)
        self.texts.append(text)
        self.add_mover(text)
        return text

    def draw(self, renderer: Any) -> None:
        """Draw the movers over the background, which is redrawn only if it has changed."""
        if not isinstance(renderer, RendererAgg):
            self._draw_still(renderer, with_movers=True)
            return
        self._update(renderer)
        canvas: ColorValues = np.asarray(renderer.buffer_rgba())  # type: ignore[no-untyped-call]
        canvas[:] = self._shown
        self.canvas.callbacks.process("draw_event", DrawEvent("draw_event", self.canvas, renderer))

    def _update(self, renderer: Any) -> None:
        """Draw what has changed since the last call, and store the result."""
        canvas: ColorValues = np.asarray(renderer.buffer_rgba())
        size = (renderer.width, renderer.height, renderer.dpi)
        is_new = self.stale or size != self._background_size
        boxes = []
        if is_new:
            renderer.clear()
            # Listeners are notified later, because one of them, a replay, would change the movers.
            with self.canvas.callbacks.blocked(signal="draw_event"):
                self._draw_still(renderer, with_movers=False)
            self._background, self._shown = canvas.copy(), canvas.copy()
            self._parts, self._boxes, self._layers = self._find_parts(), {}, {}
            self._background_size = size
            height, width, _ = canvas.shape
            boxes.append(PixelBox(0, height, 0, width))
        for part, movers in self._parts.items():
            if is_new or any(mover.stale for mover in movers):
                draw = self._draw_axes if movers[0].axes else self._draw_text
                boxes += draw(renderer, canvas, part, movers)
        self.changed = boxes

    def _find_parts(self) -> dict[Part, list[Artist]]:
        """Return the movers of each part. Axes in the same place are a single part."""
        parts: dict[Part, list[Artist]] = {}
        for mover in self._movers:
            axes = mover.axes
            parts.setdefault(axes.bbox.bounds if axes else mover, []).append(mover)
        return parts

    def _draw_text(
        self, renderer: Any, canvas: ColorValues, part: Part, movers: list[Artist]
    ) -> list[PixelBox]:
        """Redraw the area of a text before and after the change; ignore anything drawn outside."""
        (text,) = movers
        now = self._box_of(text, renderer)
        box = around([now, self._boxes.get(part, now)])
        canvas[box.area] = self._background[box.area]
        text.draw(renderer)
        text.stale = False
        self._boxes[part] = now
        self._shown[box.area] = canvas[box.area]
        return [box]

    def _draw_axes(
        self, renderer: Any, canvas: ColorValues, part: Part, movers: list[Artist]
    ) -> list[PixelBox]:
        """Redraw what has changed in some axes; ignore anything drawn outside."""
        if part not in self._boxes:
            self._boxes[part] = self._box_of(movers[0], renderer)
        whole = self._boxes[part]
        drawing, below, shown = (
            pixels[whole.area] for pixels in (canvas, self._background, self._shown)
        )
        changed: list[PixelBox] = []
        for mover in movers:
            layer = below.copy() if mover not in self._layers else self._layers[mover][0]
            changed += self._changed_box(mover, whole, renderer)
            if changed:
                box = around(changed)
                inside = box.moved(-whole.top, -whole.left).area
                drawing[inside] = below[inside]
                if isinstance(mover, Shapes):
                    mover.needed = box.bounds(renderer.height)
                mover.draw(renderer)
                mover.stale = False
                layer[inside] = drawing[inside]
            self._layers[mover] = layer, getattr(mover, "shapes", ())
            below = layer
        if not changed:
            return []
        shown[inside] = below[inside]
        return [box]

    def _changed_box(self, mover: Artist, whole: PixelBox, renderer: Any) -> list[PixelBox]:
        """Return the box in which a mover of axes has changed, or no box."""
        if mover in self._layers and not mover.stale:
            return []
        if mover not in self._layers or not isinstance(mover, Shapes):
            return [whole]
        extent = mover.changed_since(self._layers[mover][1])
        return [] if extent is None else [whole.common(box_around(extent, 0, renderer.height))]

    def _box_of(self, mover: Artist, renderer: Any) -> PixelBox:
        """Return the box of pixels around a text or axes, with its margin.

        The box of an empty text has no margin, because it would erase the text next to it.
        """
        extent = mover.axes.bbox if mover.axes else mover.get_window_extent(renderer)
        margin = (AROUND_AXES if mover.axes else AROUND_TEXT) * self.dpi / POINTS
        return box_around(extent, margin * (extent.width > 0), renderer.height)

    def rgba(self) -> ColorValues:
        """Return the pixels of the figure, ``[height, width, 4]``, until it is drawn again."""
        if not isinstance(self.canvas, FigureCanvasAgg):
            kind = type(self.canvas).__name__
            raise TypeError(f"a {kind} has no pixels; the canvas must be a FigureCanvasAgg")
        canvas: Any = self.canvas
        self._update(canvas.get_renderer())
        return self._shown

    def pixels(self) -> Image.Image:
        """Return the figure as an RGB image."""
        return Image.fromarray(self.rgba()).convert("RGB")

    def _draw_still(self, renderer: Any, *, with_movers: bool) -> None:
        """Draw the figure, either with the movers or without them."""
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


WINDOW_MARGIN = 90
"""Pixels of the height of a screen for the title and the toolbar of a window, and for a panel."""


def make_window(size: tuple[float, float], dpi: float = DPI) -> SceneFigure:
    """Return a figure in a window that ``matplotlib.pyplot.show`` will open.

    On a small screen, the figure has fewer dots per inch, so that all of it is in view.
    Matplotlib's own keys are disabled, because they would clash with the keys of replays.
    """
    import matplotlib.pyplot as plt

    if plt.get_backend().lower() == "tkagg":  # pragma: no cover - needs a display
        dpi = min(dpi, _fitting_dpi(size))
    figure = plt.figure(figsize=size, dpi=dpi, FigureClass=SceneFigure)
    assert isinstance(figure, SceneFigure)
    manager = figure.canvas.manager
    assert manager is not None, "pyplot gives each figure a manager"
    manager.set_window_title("Warehouse")
    if manager.key_press_handler_id is not None:  # pragma: no branch - with a tool manager
        figure.canvas.mpl_disconnect(manager.key_press_handler_id)
    return figure


def _fitting_dpi(size: tuple[float, float]) -> float:  # pragma: no cover - needs a display
    """Return the largest dots per inch with which a window of this size fits the screen."""
    import tkinter

    root = tkinter.Tk()
    root.withdraw()
    width, height = root.winfo_screenwidth(), root.winfo_screenheight() - WINDOW_MARGIN
    # Matplotlib multiplies the dots per inch by this ratio when the window opens.
    ratio = max(1.0, root.winfo_fpixels("1i") / 96)
    root.destroy()
    return min(width / size[0], height / size[1]) / ratio


def save_svg(figure: Figure, target: Path | IO[bytes], dpi: float | None = None) -> None:
    """Write a figure as SVG. Equal figures give equal bytes."""
    with mpl.rc_context({"svg.hashsalt": "warehouse-lab", "svg.fonttype": "path"}):
        figure.savefig(target, format="svg", dpi=dpi or figure.dpi, metadata={"Date": None})
