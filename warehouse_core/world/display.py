"""What a notebook shows for the last value of a cell.

Classes that a notebook shows call ``display``; ``viz/notebooks.py``, which stands above them, says
what it returns for each.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Any


@singledispatch
def display(value: object) -> Any:
    """Return the HTML or the bytes of a PNG that a notebook shows for a value."""
    raise TypeError(f"notebooks show no {type(value).__name__}")
