"""The form in which a notebook shows the value of a cell.

Classes that notebooks can show call ``display``. The module ``viz/notebooks.py``, which may import
all of them, registers an implementation for each class.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Any


@singledispatch
def display(value: object) -> Any:
    """Return the HTML or the bytes of a PNG that a notebook shows for a value."""
    raise TypeError(f"notebooks cannot show {type(value).__name__}")
