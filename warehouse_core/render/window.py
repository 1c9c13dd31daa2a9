"""A window that shows pictures as they come, from a loop that goes on by itself.

Matplotlib is imported when a window is made, not when this module is.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import NoDisplayError

DPI = 100
"""Of the figure. Sizes are pixels here, so that it is as good as any."""

NAP_SECONDS = 0.01
"""The longest that a key, a click or a changed size waits while the next picture is not due."""


class PictureWindow:
    """A window for pictures. Once it is closed, by whomever, it stays closed.

    It is none of pyplot's figures: ``plt.plot`` does not draw into it, ``plt.show`` does not wait
    for it, and ``plt.close("all")`` leaves it alone.

    Args:
        title: of the window, which opens with the first picture.

    Raises:
        NoDisplayError: no window can be opened here.
    """

    def __init__(self, title: str) -> None:
        from warehouse_core.render.window import has_display

        if not has_display():
            raise NoDisplayError(
                'render_mode="human" needs a window, and none can be opened here: there is no '
                'display, or no toolkit such as tkinter; render_mode="rgb_array" needs neither'
            )
        self._title = title
        self._canvas: Any = None
        self._image: Any = None
        self._fitted: tuple[float, ...] = ()
        self._is_closed = False
        self._shown_at = 0.0

    @property
    def is_closed(self) -> bool:
        """Whether the window has been closed, by the program or by whoever looked at it."""
        return self._is_closed

    def show(self, picture: NDArray[np.uint8], fps: float) -> None:
        """Show a picture ``[height, width, 3]`` in a window of its size.

        It returns ``1 / fps`` seconds after it last did, or later: whatever the program does
        between two pictures is part of that time. Once the window is closed it does nothing.
        """
        if self._canvas is None and not self._is_closed:
            self._open(picture)
        self._wait_until(0.0)
        if self._is_closed:
            return
        fitted = (*picture.shape, self._canvas.device_pixel_ratio)
        if fitted != self._fitted:
            self._fit(*fitted)
        self._image.set_data(picture)
        self._canvas.draw()
        self._wait_until(self._shown_at + 1 / fps)
        self._shown_at = time.monotonic()

    def close(self) -> None:
        """Close the window, if it is open."""
        was_closed, self._is_closed = self._is_closed, True
        if self._canvas is not None and not was_closed:
            self._canvas.manager.destroy()

    def _open(self, picture: NDArray[np.uint8]) -> None:
        import matplotlib as mpl
        import matplotlib.pyplot as plt
        from matplotlib.backends.registry import backend_registry
        from matplotlib.figure import Figure

        registry: Any = backend_registry
        toolkit = registry.load_backend_module(plt.get_backend())
        height, width = picture.shape[:2]
        figure = Figure((width / DPI, height / DPI), DPI)
        figure.set_layout_engine("none")
        with mpl.rc_context({"toolbar": "None"}):
            manager = toolkit.FigureCanvas.new_manager(figure, 0)
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set_axis_off()
        self._image = axes.imshow(picture, interpolation="nearest")
        self._canvas = figure.canvas
        # Matplotlib's own keys would save a file or change the axes.
        self._canvas.mpl_disconnect(manager.key_press_handler_id)
        self._canvas.mpl_connect("close_event", self._on_close)
        manager.set_window_title(self._title)
        manager.show()
        self._shown_at = time.monotonic()

    def _fit(self, height: int, width: int, channels: int, ratio: float) -> None:
        """Make the window as large as the picture.

        Matplotlib enlarges windows by ``ratio``, 1.04 on one screen and 2 on another. Pictures
        are enlarged by whole numbers alone, which keeps every pixel sharp.
        """
        scale = max(1, round(ratio)) / ratio / DPI
        self._image.set_extent((0, width, height, 0))
        # A hundredth more, for a fraction less would be cut off to a pixel less.
        self._canvas.figure.set_size_inches((width + 0.01) * scale, (height + 0.01) * scale)
        self._fitted = (height, width, channels, ratio)

    def _wait_until(self, due: float) -> None:
        """Handle what the window is told, keys, clicks and sizes, and go on when it is ``due``."""
        while not self._is_closed:
            self._canvas.flush_events()
            left = due - time.monotonic()
            if left <= 0:
                break
            time.sleep(min(left, NAP_SECONDS))

    def _on_close(self, event: object) -> None:
        self._is_closed = True


def has_display() -> bool:
    """Say whether matplotlib can open a window here; a notebook's inline pictures do not count.

    It asks matplotlib, which looks for a display and for a toolkit that is installed.
    """
    import matplotlib.pyplot as plt
    from matplotlib.backends.registry import backend_registry

    registry: Any = backend_registry
    try:
        _, toolkit = registry.resolve_backend(plt.get_backend())
        plt.switch_backend(plt.get_backend())
    except ImportError:
        return False
    return toolkit is not None
