"""JSON text from untrusted sources: in files, and as headers next to arrays.

Limits on its size are checked before it is parsed.
"""

from __future__ import annotations

import json
import operator
import re
from collections.abc import Collection
from itertools import accumulate
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import RecordError
from warehouse_core.wording import brief

MAX_BYTES = 8 * 2**20
"""Limit on the bytes of a text."""

MAX_ITEMS = 1_000_000
"""Limit on the commas and opening brackets of a text, including those in its strings.

Their number bounds the number of values, and a value takes up to a hundred bytes of memory.
"""

MAX_DEPTH = 20
"""Limit on the depth of nested brackets."""

_NO_BRACKETS = re.compile(r'"(?:[^"\\]++|\\.?)*+"?|[^][{}"]++', re.DOTALL)
"""Strings and other text without brackets.

A string without an end matches too, so that each character is read only once.
"""


def parse_object(data: bytes, max_bytes: int = MAX_BYTES) -> dict[str, Any]:
    """Return the JSON object in a UTF-8 text.

    Raises:
        ValueError: the text exceeds a limit, is not JSON, or is a JSON value that is not an object.
    """
    if len(data) > max_bytes:
        raise ValueError(f"{len(data):,} bytes of JSON are more than MAX_BYTES = {max_bytes}")
    items = sum(map(data.count, (b",", b"[", b"{")))
    if items > MAX_ITEMS:
        raise ValueError(f"{items:,} values are more than MAX_ITEMS = {MAX_ITEMS}")
    text = data.decode("utf-8-sig")
    brackets = _NO_BRACKETS.sub("", text)
    depth = max(accumulate(1 if each in "[{" else -1 for each in brackets), default=0)
    if depth > MAX_DEPTH:
        raise ValueError(f"{depth:,} open brackets are more than MAX_DEPTH = {MAX_DEPTH}")
    try:
        value = json.loads(text)
    except ValueError as error:  # also raised for numbers with too many digits
        raise ValueError(f"not JSON: {error}") from error
    if not isinstance(value, dict):
        raise ValueError(f"a JSON {type(value).__name__} where there must be an object")
    return value


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
    """Return the header that ``pack_header`` has packed.

    Args:
        data: bytes of the header.
        name: value that its ``format`` must have.
        allowed: other keys that the header may have.

    Raises:
        RecordError: the data are not a JSON object within the limits, the ``format`` differs, or
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
