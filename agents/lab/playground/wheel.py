"""Wheels of what is installed here, for Python in a browser."""

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
"""Time of all files in a wheel, so that equal files make equal wheels."""

KEPT = ("METADATA", "entry_points.txt")
"""Files of the installed distribution that its wheel has too."""

LEFT_OUT = {"__pycache__", "solutions"}
"""Folders that are not in the wheel: solutions of exercises are for lecturers."""

TAGS = "Wheel-Version: 1.0\nGenerator: warehouse-lab\nRoot-Is-Purelib: true\nTag: py3-none-any\n"


def write_wheel(folder: Path, name: str = DISTRIBUTION) -> str:
    """Write the wheel of a distribution into a folder, and return the name of its file.

    Args:
        folder: folder that is there.
        name: name of an installed distribution in which nothing is compiled.

    Raises:
        PackageNotFoundError: no such distribution is installed.
        OSError: the folder cannot be written.
    """
    found = distribution(name)
    stem = f"{name.replace('-', '_')}-{found.version}"
    path = folder / f"{stem}-py3-none-any.whl"
    rows, record = [], f"{stem}.dist-info/RECORD"
    contents = _own_contents if name == DISTRIBUTION else _contents
    with atomic_path(path) as part, ZipFile(part, "w", ZIP_DEFLATED) as archive:
        for inner, content in contents(found, f"{stem}.dist-info"):
            info = ZipInfo(inner, DATE)
            info.compress_type = ZIP_DEFLATED
            archive.writestr(info, content)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
            rows.append(f"{inner},sha256={digest},{len(content)}\n")
        archive.writestr(ZipInfo(record, DATE), "".join([*rows, f"{record},,\n"]))
    return path.name


def _own_contents(own: Distribution, info: str) -> Iterator[tuple[str, bytes]]:
    """Yield the name and the content of each file of this project's wheel but its record."""
    for package in OWN:
        for path in sorted((ROOT / package).rglob("*")):
            inner = path.relative_to(ROOT)
            if path.is_file() and not LEFT_OUT.intersection(inner.parts):
                yield inner.as_posix(), path.read_bytes()
    yield from _information(own, info)


def _contents(other: Distribution, info: str) -> Iterator[tuple[str, bytes]]:
    """Yield the name and the content of each file of another wheel but its record."""
    for path in sorted(other.files or ()):
        is_in_wheel = path.parts[0] != ".." and not LEFT_OUT.intersection(path.parts)
        if is_in_wheel and not path.parts[0].endswith(".dist-info"):
            yield path.as_posix(), path.read_binary()
    yield from _information(other, info)


def _information(found: Distribution, info: str) -> Iterator[tuple[str, bytes]]:
    yield f"{info}/WHEEL", TAGS.encode()
    for name in KEPT:
        yield f"{info}/{name}", (found.read_text(name) or "").encode()
