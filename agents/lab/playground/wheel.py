"""The wheel of this project, for Python in a browser."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterator
from importlib.metadata import Distribution, distribution
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from agents.lab.runs.programs import OWN, ROOT
from warehouse_core.extras import DISTRIBUTION
from warehouse_core.files.atomic import atomic_path

DATE = (1980, 1, 1, 0, 0, 0)
"""Time of all files in a wheel, so that the same files give the same wheel."""

KEPT = ("METADATA", "entry_points.txt")
"""Files of the installed distribution that are copied to the wheel."""

LEFT_OUT = {"__pycache__", "solutions"}
"""Folders that are not in the wheel; for example, solutions are only for lecturers."""

TAGS = "Wheel-Version: 1.0\nGenerator: warehouse-lab\nRoot-Is-Purelib: true\nTag: py3-none-any\n"


def write_wheel(folder: Path) -> str:
    """Write the wheel of this project to a folder, and return its file name.

    Args:
        folder: existing folder.

    Raises:
        PackageNotFoundError: this project is not installed.
        OSError: the folder cannot be written.
    """
    own = distribution(DISTRIBUTION)
    stem = f"{DISTRIBUTION.replace('-', '_')}-{own.version}"
    path = folder / f"{stem}-py3-none-any.whl"
    rows, record = [], f"{stem}.dist-info/RECORD"
    with atomic_path(path) as part, ZipFile(part, "w", ZIP_DEFLATED) as archive:
        for inner, content in _contents(own, f"{stem}.dist-info"):
            info = ZipInfo(inner, DATE)
            info.compress_type = ZIP_DEFLATED
            archive.writestr(info, content)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
            rows.append(f"{inner},sha256={digest},{len(content)}\n")
        archive.writestr(ZipInfo(record, DATE), "".join([*rows, f"{record},,\n"]))
    return path.name


def _contents(own: Distribution, info: str) -> Iterator[tuple[str, bytes]]:
    """Yield the name and the content of each file in the wheel, except for its record."""
    for package in OWN:
        for path in sorted((ROOT / package).rglob("*")):
            inner = path.relative_to(ROOT)
            if path.is_file() and not LEFT_OUT.intersection(inner.parts):
                yield inner.as_posix(), path.read_bytes()
    yield f"{info}/WHEEL", TAGS.encode()
    for name in KEPT:
        yield f"{info}/{name}", (own.read_text(name) or "").encode()
