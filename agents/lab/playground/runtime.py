"""Files of Pyodide for the page, copied from a folder or a server and checked by digest."""

from __future__ import annotations

import hashlib
import http.client
import json
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from urllib.error import URLError
from urllib.parse import urljoin, urlsplit
from urllib.request import urlopen

from agents.errors import PyodideError
from warehouse_core.files.atomic import atomic_path
from warehouse_core.wording import brief

PINNED = json.loads((files("agents.lab.playground") / "pyodide.json").read_text(encoding="utf-8"))

VERSION: str = PINNED["version"]
"""Version of Pyodide."""

FILES: dict[str, str] = PINNED["files"]
"""SHA-256 digests by file name, for Python, its library and NumPy."""

SERVER = f"https://cdn.jsdelivr.net/pyodide/v{VERSION}/full/"
"""Default address of the files."""

TIMEOUT = 60.0
"""Seconds without an answer after which a server is given up."""

MAX_BYTES = 64 * 1024 * 1024
"""Limit on the bytes of a file."""


def copy_runtime(source: str, folder: Path, advance: Callable[[], None] = lambda: None) -> None:
    """Copy the files of Pyodide to a folder; correct files that are already there are kept.

    Args:
        source: folder, or an address that begins with ``http://`` or ``https://``.
        folder: folder to copy to, created when the first file is written.
        advance: function that is called after each file.

    Raises:
        PyodideError: a file cannot be read, or belongs to another version.
        OSError: the folder cannot be written.
    """
    for name, digest in FILES.items():
        target = folder / name
        if not (target.is_file() and digest_of(target.read_bytes()) == digest):
            content = _read(source, name)
            if digest_of(content) != digest:
                raise PyodideError(
                    f"{name} in {brief(source)} does not belong to Pyodide {VERSION}: its SHA-256 "
                    f"is {digest_of(content)}; needed: {digest}"
                )
            folder.mkdir(parents=True, exist_ok=True)
            with atomic_path(target) as part:
                part.write_bytes(content)
        advance()


def _read(source: str, name: str) -> bytes:
    try:
        if urlsplit(source).scheme in ("http", "https"):
            with urlopen(urljoin(source.rstrip("/") + "/", name), timeout=TIMEOUT) as answer:
                content: bytes = answer.read(MAX_BYTES + 1)
        else:
            with (Path(source) / name).open("rb") as file:
                content = file.read(MAX_BYTES + 1)
    except (OSError, URLError, http.client.HTTPException) as error:
        raise PyodideError(
            f"{name} cannot be read from {brief(source)}: {error}; needed: a folder or an "
            f"address with the files of Pyodide {VERSION}"
        ) from None
    return content


def digest_of(content: bytes) -> str:
    """Return the SHA-256 digest of some bytes as hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()
