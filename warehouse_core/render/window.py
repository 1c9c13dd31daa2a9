"""A window in which a program shows one picture after another, from its own loop.

Matplotlib is imported only when it is needed, not together with this module.
"""

from __future__ import annotations

import os
import sys
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import NoDisplayError

DPI = 100
"""Dots per inch of the figure; any value would do, because sizes are given in pixels."""

MAX_WAIT_SECONDS = 0.01
"""Longest time between two checks for window events while waiting for the next picture."""

IS_IN_BROWSER = sys.platform == "emscripten"
"""``True`` if Python runs in a browser, where no window can be opened."""


def may_have_display() -> bool:
    """Return ``False`` if it is certain that no window can be opened; do not import matplotlib."""
    if IS_IN_BROWSER:
        return False
    return sys.platform != "linux" or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))


def has_display() -> bool:
    """Return whether matplotlib can open a window, with a display and an installed toolkit.

    The inline pictures of a notebook do not count as windows.

    Example:
        >>> from warehouse_core.render import has_display
        >>> where = "in a window" if has_display() else "in a file"
    """
    if IS_IN_BROWSER:  # its matplotlib may be too old for the following code
        return False
    import matplotlib.pyplot as plt
    from matplotlib.backends.registry import backend_registry

    registry: Any = backend_registry
    try:
        _, toolkit = registry.resolve_backend(plt.get_backend())
        plt.switch_backend(plt.get_backend())
    except ImportError:
        return False
    return toolkit is not None


def is_in_notebook() -> bool:
    """Return whether the program runs in a notebook, which shows the value of each cell."""
    ipython: Any = sys.modules.get("IPython")
    shell = ipython and ipython.get_ipython()
    return getattr(shell, "kernel", None) is not None


class PictureWindow:
    """A window for pictures. Once closed, by the program or by the user, it stays closed.

    It is independent of pyplot: ``plt.plot`` does not draw into it, ``plt.show`` does not wait for
    it, and ``plt.close("all")`` does not close it.

    Args:
        title: title of the window. The window opens when the first picture is shown.

    Attributes:
        is_closed: ``True`` once it has been closed.

    Raises:
        NoDisplayError: no window can be opened.

    Example:
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> from warehouse_core.render import PictureWindow, TilePainter
        >>> window = PictureWindow("A warehouse")  # doctest: +SKIP
        >>> window.show(TilePainter(32).picture(DEFAULT_LAYOUT, (1, 1), False), 2)  # doctest: +SKIP
    """

    def __init__(self, title: str) -> None:
        if not has_display():
            raise NoDisplayError(
                'render_mode="human" needs a window, but none can be opened here, because there is '
                'no display or no toolkit such as tkinter; render_mode="rgb_array" needs neither'
            )
        self._title = title
        self._canvas: Any = None
        self._image: Any = None
        self._fitted: tuple[float, ...] = ()
        self.is_closed = False
        self._shown_at = 0.0

    def show(self, picture: NDArray[np.uint8], fps: float) -> None:
        """Show a picture ``[height, width, 3]`` in a window of its size.

        The call returns at least ``1 / fps`` seconds after the previous call returned. The time
        that the program takes between two calls counts. Once the window is closed, nothing happens.
        """
        if self._canvas is None and not self.is_closed:
            self._open(picture)
        self._wait_until(0.0)
        if self.is_closed:
            return
        self._fit(picture)
        self._image.set_data(picture)
        self._canvas.draw()
        self._wait_until(self._shown_at + 1 / fps)
        self._shown_at = time.monotonic()

    def close(self) -> None:
        """Close the window, if it is open."""
        was_closed, self.is_closed = self.is_closed, True
        if self._canvas is not None and not was_closed:
            self._canvas.manager.destroy()

    def _open(self, picture: NDArray[np.uint8]) -> None:
        import matplotlib as mpl
        import matplotlib.pyplot as plt
        from matplotlib.backends.registry import backend_registry
        from matplotlib.figure import Figure

        registry: Any = backend_registry
        toolkit = registry.load_backend_module(plt.get_backend())
        figure = Figure(dpi=DPI)
        figure.set_layout_engine("none")
        with mpl.rc_context({"toolbar": "None"}):
            manager = toolkit.FigureCanvas.new_manager(figure, 0)
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set_axis_off()
        self._image = axes.imshow(picture, interpolation="nearest")
        self._canvas = figure.canvas
        # The default keys of matplotlib would save a file or change the axes.
        self._canvas.mpl_disconnect(manager.key_press_handler_id)
        self._canvas.mpl_connect("close_event", self._on_close)
        manager.set_window_title(self._title)
        self._fit(picture)
        manager.show()
        self._shown_at = time.monotonic()

    def _fit(self, picture: NDArray[np.uint8]) -> None:
        """Make the window as large as the picture.

        Matplotlib enlarges windows by ``ratio``, which depends on the screen. Pictures are enlarged
        only by whole factors, so that every pixel stays sharp.
        """
        height, width = picture.shape[:2]
        ratio = self._canvas.device_pixel_ratio
        if self._fitted == (height, width, ratio):
            return
        self._fitted = height, width, ratio
        scale = max(1, round(ratio)) / ratio / DPI
        self._image.set_extent((0, width, height, 0))
        # Figure sizes are rounded down to whole pixels; Matplotlib 3.10 rounds sizes of axes up.
        wide, high = width + 0.01, height + 0.01
        self._canvas.figure.set_size_inches(wide * scale, high * scale)
        self._image.axes.set_position((0, 0, (width - 0.001) / wide, (height - 0.001) / high))

    def _wait_until(self, due: float) -> None:
        """Handle the events of the window until the monotonic time ``due``."""
        while not self.is_closed:
            self._canvas.flush_events()
            left = due - time.monotonic()
            if left <= 0:
                break
            time.sleep(min(left, MAX_WAIT_SECONDS))

    def _on_close(self, event: object) -> None:
        self.is_closed = True
