"""The packages that notebooks in a browser import, served with Pyodide from one folder.

Pyodide's lock names the file of each package, the packages that it needs and the modules that it
has; a cell that imports one of these modules loads it. The lock that is written here names those
that are there: packages of Pyodide, and wheels of pure packages as they are installed here.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any

from agents.lab.playground.runtime import FILES, SCRIPT, copy_files, digest_of
from agents.lab.playground.wheel import write_wheel
from warehouse_core.extras import DISTRIBUTION
from warehouse_core.files.atomic import atomic_path

LOCK = "pyodide-lock.json"

KERNEL = ("comm", "ipython", "micropip", "sqlite3", DISTRIBUTION)
"""Packages that the kernel of a notebook loads."""

APART = {"fonttools", "pytz"}
"""Packages that Matplotlib imports only for PDF and PostScript, or never; a cell that imports them
loads them.
"""

IMPORTED = ("matplotlib", "scipy")
"""Packages of Pyodide that cells import."""

INSTALLED: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    DISTRIBUTION: (
        ("numpy", "pillow"),
        ("warehouse_core", "warehouse_physics", "agents"),
    ),
    "gymnasium": (
        ("numpy", "cloudpickle", "farama-notifications", "typing-extensions"),
        ("gymnasium", "warehouse_core.gymnasium_env"),
    ),
    "pettingzoo": (("gymnasium",), ("pettingzoo", "warehouse_core.pettingzoo_env")),
    "cloudpickle": ((), ("cloudpickle",)),
    "comm": ((), ("comm",)),
    "farama-notifications": ((), ("farama_notifications",)),
    "typing-extensions": ((), ("typing_extensions",)),
}
"""Packages that each package needs, and modules whose import in a cell loads it, by its name."""


def write_packages(folder: Path, source: str) -> None:
    """Write Pyodide and all packages into a folder, which is made if it is missing.

    Args:
        folder: folder of the files.
        source: place of Pyodide's files, as for ``copy_files``.

    Raises:
        PyodideError: as ``copy_files``.
        PackageNotFoundError: a package of ``INSTALLED`` is not installed.
        OSError: the folder cannot be written.
    """
    copy_files(FILES | SCRIPT, source, folder)
    lock = json.loads((folder / LOCK).read_text(encoding="utf-8"))
    needed = _needed(lock["packages"], [*KERNEL, *IMPORTED, *INSTALLED])
    kept = {name: lock["packages"][name] for name in needed - INSTALLED.keys()}
    copy_files({each["file_name"]: each["sha256"] for each in kept.values()}, source, folder)
    for each in kept.values():
        each["depends"] = [name for name in each["depends"] if name not in APART]
    lock["packages"] = kept | {name: _entry(folder, name) for name in INSTALLED}
    with atomic_path(folder / LOCK) as part:
        part.write_text(json.dumps(lock), encoding="utf-8")


def _needed(known: dict[str, Any], names: Iterable[str]) -> set[str]:
    """Return the names of packages and of all that they need."""
    found: set[str] = set()
    waiting = [*names]
    while waiting:
        name = waiting.pop().lower().replace("_", "-")
        if name not in found:
            found.add(name)
            waiting += known[name]["depends"] if name in known else INSTALLED[name][0]
    return found


def _entry(folder: Path, name: str) -> dict[str, Any]:
    """Write the wheel of an installed package, and return what the lock says about it."""
    file = write_wheel(folder, name)
    needs, modules = INSTALLED[name]
    return {
        "name": name,
        "version": version(name),
        "file_name": file,
        "install_dir": "site",
        "sha256": digest_of((folder / file).read_bytes()),
        "package_type": "package",
        "imports": modules,
        "depends": needs,
        "unvendored_tests": False,
    }
