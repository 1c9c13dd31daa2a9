"""JSON text as an array of bytes, for what arrays of numbers cannot hold."""

from __future__ import annotations

import json
import operator
from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import RecordError
from warehouse_core.files.json_text import parse_object
from warehouse_core.wording import brief


def pack_header(header: dict[str, Any]) -> NDArray[np.uint8]:
    """Return a header as the bytes of JSON text.

    Raises:
        RecordError: a value cannot be written as JSON.
    """
    texts = []
    for name, value in header.items():
        try:
            texts.append(f"{json.dumps(name)}: {json.dumps(value, default=operator.index)}")
        except (TypeError, ValueError, RecursionError) as error:
            raise RecordError(f"{name} cannot be written as JSON: {error}") from error
    return np.frombuffer(f"{{{', '.join(texts)}}}".encode(), dtype=np.uint8)


def unpack_header(data: NDArray[np.uint8], name: str, allowed: Collection[str]) -> dict[str, Any]:
    """Undo ``pack_header``.

    Args:
        data: bytes of the header.
        name: value that its ``format`` must have.
        allowed: the other keys that it may have.

    Raises:
        RecordError: the data are no JSON object within the limits, the ``format`` is another, or
            a key is unknown.
    """
    try:
        header = parse_object(data.tobytes())
    except ValueError as error:
        raise RecordError(f"its header: {error}") from error
    if header.pop("format", None) != name:
        raise RecordError(f"its format is not {name!r}")
    unknown = [key for key in header if key not in allowed]
    if unknown:
        raise RecordError(f"unknown key {brief(unknown[0])}; allowed: {', '.join(allowed)}")
    return header
