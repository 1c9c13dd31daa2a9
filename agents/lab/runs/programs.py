"""What an episode depends on beside its case: the program that runs it, and the code of its agent.

Both are named by digests of source files, so that no change of what they do goes unnoticed. Other
packages that an agent imports, from ``site-packages``, are not part of its digest.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import site
import sysconfig
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from functools import cache, lru_cache
from importlib.machinery import all_suffixes
from importlib.metadata import PackageNotFoundError, entry_points, version
from pathlib import Path

from agents.errors import AgentError
from warehouse_core.files.reading import not_a_file
from warehouse_core.motion.backends import GROUP

OWN = ("agents", "warehouse_core", "warehouse_physics")
"""Packages of this program; no module of a user can have one of these names."""

ROOT = Path(__file__).parents[3]

NO_EFFECT = {
    "viz", "warehouse_viz.py", "render", "gymnasium_env", "conformance", "reports", "grading",
    "commands", "console", "__main__.py", "run_episode.py",
}  # fmt: skip
"""Files and folders of these packages that have no effect on an episode of an experiment."""

DIGITS = 10
"""Length of the digest in the name of a program."""

MAX_BYTES = 64 * 1024 * 1024
"""Most bytes in a file of an agent."""


@cache
def program_for(backend: str) -> str:
    """Return the name of the program that runs the episodes of a backend in this process.

    It has the version of this package and a digest of its sources, and the versions of NumPy and of
    what the backend needs: pymunk, or its own distribution. Nothing is imported to find them.
    """
    names = ["numpy", *(["pymunk"] if backend == "physics" else [])]
    for entry_point in entry_points(group=GROUP, name=backend):
        if entry_point.dist is not None and entry_point.dist.name != "warehouse-lab":
            names.append(entry_point.dist.name)
    own = f"warehouse-lab {_version('warehouse-lab')} ({_own_digest()})"
    return ", ".join([own, *(f"{name} {_version(name)}" for name in names)])


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "(not installed)"


def own_sources() -> list[Path]:
    """Return the source files of this program that have an effect on episodes, in a fixed order."""
    sources = {path: path.relative_to(ROOT / name) for name in OWN
               for path in (ROOT / name).rglob("*.py")}  # fmt: skip
    return sorted(
        path for path, inner in sources.items() if not NO_EFFECT.intersection(inner.parts)
    )


@cache
def _own_digest() -> str:
    return digest_of(own_sources(), ROOT, _content_digest)[:DIGITS]


def fingerprint(file: Path | None, module: str | None) -> str | None:
    """Return the digest of the code or model of an agent; ``None`` for an agent of this program.

    The code is its file, or its module, and what these import from the same folder, also in
    functions. It is found without being run. A process imports a module once, so the digest of one
    is made once too; files are read each time. A file that is a folder, a pipe, a device, or longer
    than ``MAX_BYTES`` is an ``AgentError``.
    """
    if module is not None:
        return _module_fingerprint(module)
    if file is None:
        return None
    data, file = _read(file), file.resolve()
    if file.suffix == ".py":
        files = _with_imports([file], file.parent, own=None)
        if len(files) > 1:
            return digest_of(files, file.parent, _content_digest)
    return hashlib.sha256(data).hexdigest()


@cache
def _module_fingerprint(name: str) -> str | None:
    top = name.partition(".")[0]
    spec = None if top in OWN else importlib.util.find_spec(top)
    if spec is None:
        return None
    [place, *_] = spec.submodule_search_locations or [spec.origin or ""]
    folder = Path(place).parent
    files = _with_imports(_files_of(name.split("."), folder), folder, top)
    return digest_of(files, folder, _content_digest)


def _with_imports(files: Iterable[Path], folder: Path, own: str | None) -> set[Path]:
    """Return files, what they import from a folder, what that imports from there, and so on.

    Of a folder of installed packages only the files' own package is looked up.
    """
    is_shared = folder.resolve() in _installed()
    reached, waiting = set[Path](), list(files)
    while waiting:
        file = waiting.pop()
        if file in reached:
            continue
        reached.add(file)
        for level, name in imports_of(_read(file)) if file.suffix == ".py" else ():
            parts = name.split(".")
            if level:
                base = folder.joinpath(*file.relative_to(folder).parts[:-level])
                waiting += _files_of(parts, base)
            elif parts[0] not in OWN and (not is_shared or parts[0] == own):
                waiting += _files_of(parts, folder)
    return reached


@lru_cache
def imports_of(source: bytes) -> tuple[tuple[int, str], ...]:
    """Return the names that a source imports, with the number of dots before each."""
    names = []
    with suppress(SyntaxError, ValueError, RecursionError, MemoryError):  # it cannot be imported
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Import):
                names += [(0, each.name) for each in node.names]
            elif isinstance(node, ast.ImportFrom):
                before = f"{node.module}." if node.module else ""
                names += [(node.level, before + each.name) for each in node.names]
    return tuple(names)


def _files_of(parts: Sequence[str], folder: Path) -> Iterator[Path]:
    """Yield the files of a module in a folder, after the packages around it."""
    for part in parts:
        if part == "*":  # perhaps modules
            yield from folder.glob("*.py")
        for name in (part, f"{part}/__init__"):
            files = (folder / f"{name}{suffix}" for suffix in all_suffixes())
            yield from (file for file in files if file.is_file())
        folder /= part


@cache
def _installed() -> set[Path]:
    """Return the folders of the standard library and of installed packages."""
    names = ("stdlib", "platstdlib", "purelib", "platlib")
    folders = [*map(sysconfig.get_path, names), site.getusersitepackages()]
    return {Path(each).resolve() for each in folders}


def digest_of(files: Iterable[Path], folder: Path, digest: Callable[[Path], str]) -> str:
    """Return the digest of the names of files in a folder, and of the digest of each."""
    lines = (f"{file.relative_to(folder).as_posix()} {digest(file)}" for file in sorted(files))
    return hashlib.sha256("\n".join(lines).encode(errors="surrogateescape")).hexdigest()


def _content_digest(path: Path) -> str:
    return hashlib.sha256(_read(path)).hexdigest()


def _read(path: Path) -> bytes:
    if (kind := not_a_file(path)) is not None:
        raise AgentError(f"agent file {path}: {kind}")
    with path.open("rb") as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise AgentError(f"agent file {path}: it is longer than MAX_BYTES = {MAX_BYTES}")
    return data
