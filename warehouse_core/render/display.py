"""Whether windows can be opened. Matplotlib is imported by the call, not with this module."""

from __future__ import annotations

from typing import Any


def has_display() -> bool:
    """Return whether matplotlib can open a window: there is a display and an installed toolkit.

    The inline pictures of a notebook are no windows.
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
