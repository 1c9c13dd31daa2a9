"""JSON text as an array of bytes, for what arrays of numbers cannot hold."""

from __future__ import annotations

import json
import operator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import RecordError


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


def unpack_header(data: NDArray[np.uint8], name: str) -> dict[str, Any]:
    """Undo ``pack_header``.

    Raises:
        RecordError: the data are no JSON text, or its ``format`` is not ``name``.
    """
    try:
        header = json.loads(data.tobytes().decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise RecordError(f"its header is no JSON text: {error}") from error
    if not isinstance(header, dict) or header.get("format") != name:
        raise RecordError(f"its format is not {name!r}")
    return header
