"""Arrays of a page as one block of bytes, and references to them in its JSON.

A reference is ``{"$": [kind, offset, length, is_delta, unit]}``, where ``kind`` is the type of the
stored numbers (``i1``, ``i2``, ``i4`` or ``f4``, little-endian) and ``offset`` counts bytes. With
``is_delta`` a number is the difference to the one before. ``player/decode.js`` reads them.
"""

from __future__ import annotations

import json
import struct
import zlib
from base64 import b64encode
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

ALIGNMENT = 4
LEVEL = 6
"""Level of compression; the highest takes ten times as long and makes pages 7% smaller."""

KINDS = {"i1": 2**7, "i2": 2**15, "i4": 2**31}
"""Types of whole numbers, and what their absolute values are below."""

Reference = dict[str, list[Any]]


class Columns:
    """Collects arrays, and packs them behind a JSON value that refers to them."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._length = 0

    def whole(self, values: ArrayLike, *, is_delta: bool = False, unit: float = 1) -> Reference:
        """Add numbers, rounded to multiples of ``unit``.

        Raises:
            ValueError: a number is not finite, or too large for 32 bits.
        """
        stored = np.rint(np.asarray(values, np.float64).ravel() / unit)
        largest = _largest(stored)
        if is_delta:
            stored = np.diff(stored, prepend=0)
            largest = _largest(stored)
        kind = next(name for name, limit in KINDS.items() if largest < limit)
        return self._add(kind, stored.astype(f"<{kind}"), is_delta=is_delta, unit=unit)

    def real(self, values: ArrayLike) -> Reference:
        """Add numbers of single precision; NaN is one of them."""
        return self._add("f4", np.asarray(values, "<f4").ravel(), is_delta=False, unit=1)

    def packed(self, value: Any) -> str:
        """Return a JSON value and all columns, compressed, as base64."""
        text = json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
        words = text.encode("utf-8", "backslashreplace")
        words += b" " * (-len(words) % ALIGNMENT)
        block = b"".join([struct.pack("<I", len(words)), words, *self._parts])
        return b64encode(zlib.compress(block, LEVEL)).decode("ascii")

    def _add(self, kind: str, stored: Any, *, is_delta: bool, unit: float) -> Reference:
        data = stored.tobytes()
        reference = [kind, self._length, len(stored), int(is_delta), unit]
        data += b"\0" * (-len(data) % ALIGNMENT)
        self._parts.append(data)
        self._length += len(data)
        return {"$": reference}


def _largest(numbers: NDArray[np.float64]) -> float:
    """Return the largest absolute value of some numbers, or 0; raise unless 32 bits hold it."""
    largest = float(np.abs(numbers).max(initial=0))
    if not largest < KINDS["i4"]:
        raise ValueError("a number of a page is not finite, or too large for 32 bits")
    return largest
