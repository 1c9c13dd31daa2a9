"""Figures with a window where there is a display, and without one everywhere else.

``matplotlib.pyplot`` is imported inside the functions: it is slow, and windows alone need it.
"""

from __future__ import annotations

from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg

from warehouse_core.scene_figure import SceneFigure

DPI = 100

PAIR_DPI = 70
"""Of two pictures side by side, which would be wider than a screen."""


class NoDisplayError(RuntimeError):
    """A window was asked for where none can be opened."""


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


def make_figure(size: tuple[float, float], dpi: float = DPI) -> SceneFigure:
    """Return a figure of ``size`` inches that needs no display."""
    figure = SceneFigure(figsize=size, dpi=dpi)
    FigureCanvasAgg(figure)
    return figure


def make_window(size: tuple[float, float], dpi: float = DPI) -> SceneFigure:
    """Return a figure in a window that ``matplotlib.pyplot.show`` will open.

    Matplotlib's own keys are taken off it: its arrows and ``p`` would clash with ours.
    """
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=size, dpi=dpi, FigureClass=SceneFigure)
    assert isinstance(figure, SceneFigure)
    manager = figure.canvas.manager
    if manager is not None:
        manager.set_window_title("Warehouse")
        if manager.key_press_handler_id is not None:
            figure.canvas.mpl_disconnect(manager.key_press_handler_id)
    return figure
