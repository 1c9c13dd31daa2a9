"""Names of the program that runs an episode and of its agent's code.

An episode depends on both besides its case. The names contain digests of source files, so that a
change of behaviour cannot go unnoticed. The digest of an agent does not cover the packages that it
imports from ``site-packages``.
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
"""Packages of this program, whose names users' modules cannot have."""

ROOT = Path(__file__).parents[3]

NO_EFFECT = {
    "viz", "warehouse_viz.py", "render", "gymnasium_env", "conformance", "reports", "grading",
    "commands", "console", "__main__.py", "run_episode.py",
}  # fmt: skip
"""Files and folders in these packages that have no effect on the episodes of an experiment."""

DIGITS = 10
"""Number of digits of the digest in the name of a program."""

MAX_BYTES = 64 * 1024 * 1024
"""Maximum size of an agent's file in bytes."""


@cache
def program_for(backend: str) -> str:
    """Return the name of the program that runs episodes on a backend in this process.

    The name contains the version of this package, a digest of its sources, and the versions of
    NumPy and of the package that the backend needs. This package is pymunk or the distribution of
    the backend. Nothing is imported to find the versions.
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
    """Return the source files of this program that affect episodes, in a fixed order."""
    sources = {path: path.relative_to(ROOT / name) for name in OWN
               for path in (ROOT / name).rglob("*.py")}  # fmt: skip
    return sorted(
        path for path, inner in sources.items() if not NO_EFFECT.intersection(inner.parts)
    )


@cache
def _own_digest() -> str:
    return digest_of(own_sources(), ROOT, _content_digest)[:DIGITS]


def fingerprint(file: Path | None, module: str | None) -> str | None:
    """Return the digest of an agent's code or model, or ``None`` for an agent of this program.

    The code consists of the agent's file or module, and of all files that it imports from the same
    folder, including imports inside functions. It is found without running it. A process imports a
    module only once. Therefore the digest of a module is computed only once, while files are read
    each time.

    Raises:
        AgentError: a file is a folder, a pipe or a device, or is longer than ``MAX_BYTES``.
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
    """Return some files and all files in a folder that they import, directly or indirectly.

    In a folder of installed packages, only imports from the files' own package are followed.
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
    """Return the names that a source file imports, with the number of dots before each name."""
    names = []
    with suppress(SyntaxError, ValueError, RecursionError, MemoryError):  # an import would fail too
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Import):
                names += [(0, each.name) for each in node.names]
            elif isinstance(node, ast.ImportFrom):
                before = f"{node.module}." if node.module else ""
                names += [(node.level, before + each.name) for each in node.names]
    return tuple(names)


def _files_of(parts: Sequence[str], folder: Path) -> Iterator[Path]:
    """Yield the files of a module in a folder, preceded by the files of its parent packages."""
    for part in parts:
        if part == "*":  # it may import modules
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
    """Return a digest of the names and contents of files, with their names relative to a folder."""
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
