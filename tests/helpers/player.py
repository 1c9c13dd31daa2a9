"""Content of a page that plays tracks, read without the code that writes it."""

import html
import json
import re
import struct
import zlib
from base64 import b64decode
from typing import Any

import numpy as np


def said_by(page: str) -> Any:
    """Return the JSON value in a page, with lists in place of its columns."""
    [packed] = re.findall(r'<script type="text/plain" id="data">([^<]*)</script>', page)
    block = zlib.decompress(b64decode(packed))
    length = struct.unpack_from("<I", block)[0]
    start = 4 + length

    def column(value: dict[str, Any]) -> Any:
        if "$" not in value:
            return value
        kind, offset, count, is_delta, unit = value["$"]
        stored = np.frombuffer(block, f"<{kind}", count, start + offset)
        numbers = stored.astype(np.float64 if kind == "f4" else np.int64)
        return ((numbers.cumsum() if is_delta else numbers) * unit).tolist()

    return json.loads(block[4:start], object_hook=column)


def page_in(frame: str) -> str:
    """Return the page in a frame."""
    [source] = re.findall(r'<iframe srcdoc="([^"]*)"', frame)
    return html.unescape(source)
