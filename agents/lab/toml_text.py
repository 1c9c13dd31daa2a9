"""TOML from untrusted files: limits are checked before the text is parsed.

The time and memory to parse a key grow with the square of its depth.
"""

from __future__ import annotations

import re
import tomllib
from typing import Any

MAX_BYTES = 100_000
"""Largest size of a file in bytes."""

MAX_LINE = 2_000
"""Largest size of a line in bytes, and therefore of a key."""

MAX_DEPTH = 10
"""Limit on the parts of a key, such as two in ``robot.mass``, and of dotted names in texts."""

_DEEP = re.compile(rf"""(?<![\w-])((?:[\w-]++|"[^"]*+"|'[^']*+')[ \t]*+\.[ \t]*+){{{MAX_DEPTH}}}""")


def parse_toml(data: bytes) -> dict[str, Any]:
    """Return the table in a TOML text, encoded in UTF-8.

    Raises:
        ValueError: a limit is exceeded, or the text is not TOML.
    """
    for number, line in enumerate(data.split(b"\n"), start=1):
        if len(line) > MAX_LINE:
            raise ValueError(f"line {number} is longer than MAX_LINE = {MAX_LINE} bytes")
        if _DEEP.search(line.decode(errors="replace")):
            raise ValueError(f"line {number} has a key of more than MAX_DEPTH = {MAX_DEPTH} parts")
    try:
        return tomllib.loads(data.decode("utf-8-sig"))
    except RecursionError as error:
        raise ValueError("it has too many open brackets") from error
