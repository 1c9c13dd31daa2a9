"""Which agents are graded: one by its name, or those in a folder."""

from __future__ import annotations

import hashlib
import os
import re
import stat
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from agents.errors import AgentError
from agents.lab.runs.programs import ROOT, digest_of, fingerprint
from warehouse_core.files.kinds import not_a_file
from warehouse_core.wording import counted, printable

__all__ = ["Submission", "find_submission", "in_folder"]

IMPORTED_ONCE = (
    "abc", "agents", "collections", "copy", "dataclasses", "enum", "functools", "heapq",
    "itertools", "json", "math", "matplotlib", "numpy", "queue", "random", "scipy", "torch",
    "typing", "warehouse_core",
)  # fmt: skip
"""Modules that are imported once a submission and not in each of its processes."""

IMPORT = re.compile(
    rb"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]*\(?([\w \t,\n]*)|import[ \t]+([\w \t,.]+))",
    re.MULTILINE,
)
"""An import statement, as far as its modules and names can be told without parsing the source."""

MAX_SOURCE = 1024 * 1024
"""Most bytes of a source in which imports are looked for."""

MAX_FILES, MAX_BYTES = 1_000, 256 * 1024**2
"""Most files and bytes of a submission."""

USUAL = "agent.py"
"""The file of a submission that is a folder with several files."""


class Submission(NamedTuple):
    """An agent to be graded.

    Attributes:
        name: name as it was given, or in a folder the name of its file or folder.
        shown: its file or module as it was given, for commands.
        file: file of the agent, or ``None`` if it is imported.
        module: the name of the file without a suffix, or of the module.
        kind: the name of the class; ``None`` for the only one with ``reset`` and ``act``.
        folder: folder in which its process runs, and looks up imports first; ``None`` for a file
            that has no part in its folder.
        digest: the digest of its code: of its file, of all files of its folder if it is one of
            many, or of its module and what that imports from its package; "" for a built-in one.
        imports: modules that are imported once; none has code of the submission.

    Example:
        >>> from agents.lab.grading.submissions import find_submission
        >>> submission = find_submission("greedy")
        >>> submission.is_built_in, submission.kind
        (True, 'GreedyAgent')
    """

    name: str
    shown: str
    file: Path | None
    module: str
    kind: str | None
    folder: Path | None
    digest: str
    imports: tuple[str, ...] = ()

    def called(self, kind: str | None) -> str:
        """Return the name by which ``warehouse run --agent`` finds it, with the class it loaded."""
        chosen = self.kind or kind
        return self.shown if self.is_built_in or chosen is None else f"{self.shown}:{chosen}"

    @property
    def is_built_in(self) -> bool:
        """Whether it is an agent of this program."""
        return self.file is None and self.shown != self.module

    @property
    def hiding(self) -> list[str]:
        """The names of files and folders beside its file that hide modules from all imports."""
        known = {*sys.stdlib_module_names, *IMPORTED_ONCE}
        beside = sorted(self.folder.iterdir()) if self.folder and self.file else ()
        return [
            printable(path.name) for path in beside
            if path.stem in known and path != ROOT / path.name
            and (path.suffix == ".py" or (path / "__init__.py").exists())
        ]  # fmt: skip


class Unusable(NamedTuple):
    """An entry of a folder that cannot be graded, and why."""

    name: str
    reason: str


def find_submission(name: str) -> Submission:
    """Return the agent ``file.py:Class``, ``file.py``, ``module:Class`` or a built-in one.

    If there is none, or it needs the map, that is an ``AgentError``.

    Example:
        >>> from pathlib import Path
        >>> from agents.lab.grading.submissions import find_submission
        >>> size = Path("mine.py").write_text("class Mine: ...")
        >>> find_submission("mine.py:Mine").kind
        'Mine'
    """
    if name.endswith(".py"):
        return of_file(name, Path(name), None)
    source, colon, kind = name.rpartition(":")
    if not colon:
        return _built_in(name)
    if source.endswith(".py"):
        return of_file(name, Path(source), kind)
    return Submission(name, source, None, source, kind, Path.cwd(), fingerprint(None, source) or "")


def of_file(name: str, file: Path, kind: str | None) -> Submission:
    """Return the agent in a file; that there is none is an ``AgentError``."""
    if not file.is_file():
        raise AgentError(f"agent file {file}: {not_a_file(file) or 'there is no such file'}")
    path = file.resolve().parent / file.name
    return _of_files(name, file, kind, path.parent, [path])


def _of_files(
    name: str, file: Path, kind: str | None, folder: Path | None, files: Iterable[Path]
) -> Submission:
    """Return the agent in a file, which may import from a folder, and consists of some files."""
    path = file.resolve().parent / file.name

    def is_own(top: str) -> bool:
        return folder is not None and any(map(Path.exists, (folder / f"{top}.py", folder / top)))

    imports = {
        module for module in _imports_in(path)
        if (top := module.partition(".")[0]) in IMPORTED_ONCE and not is_own(top)
    }  # fmt: skip
    digest = digest_of(_few(files, path.parent), path.parent, _content_digest)
    once = tuple(sorted(imports))
    return Submission(name, str(file), path, file.stem, kind, folder, digest, once)


def _imports_in(file: Path) -> Iterator[str]:
    """Yield what the source seems to import; it is not parsed, which may take any memory."""
    with file.open("rb") as source:
        text = source.read(MAX_SOURCE)
    for module, names, modules in IMPORT.findall(text):
        if module:
            yield module.decode()
            yield from (f"{module.decode()}.{each.decode()}" for each in re.findall(rb"\w+", names))
        else:
            yield from (each.split()[0].decode() for each in modules.split(b",") if each.split())


def _built_in(name: str) -> Submission:
    from agents.registry import AGENTS

    made = AGENTS.get(name)
    if not isinstance(made, type):
        graded = [each for each, kind in AGENTS.items() if isinstance(kind, type)]
        reason = "plans on the map, which a graded agent does not get" if made else "is no agent"
        raise AgentError(f"{name!r} {reason}; allowed: {', '.join(graded)}, or file.py:Class")
    module = made.__module__
    return Submission(name, name, None, module, made.__name__, Path.cwd(), "", (module,))


def in_folder(folder: Path, kind: str | None) -> Iterator[Submission | Unusable]:
    """Yield the submissions in a folder by name: each ``.py`` file, and each folder with one.

    Files and folders that cannot be graded are ``Unusable``; other files are none of both. Links
    are not followed, so that nobody is graded with the file of another. Each has a class ``kind``.

    Example:
        >>> from pathlib import Path
        >>> from agents.lab.grading.submissions import in_folder
        >>> Path("class").mkdir()
        >>> for name in ("one.py", "two.py"):
        ...     Path("class", name).touch()
        >>> [submission.name for submission in in_folder(Path("class"), None)]
        ['one.py', 'two.py']
    """
    for path in sorted(folder.iterdir()):
        if path.name.startswith((".", "__")) or not (path.suffix == ".py" or path.is_dir()):
            continue
        try:
            yield _entry(path, kind)
        except (AgentError, OSError) as error:
            yield Unusable(path.name, str(error))


def _entry(path: Path, kind: str | None) -> Submission | Unusable:
    if (reason := _unusable(path)) is not None:
        return Unusable(path.name, reason)
    if path.is_file():
        return _of_files(path.name, path, kind, None, [path.resolve()])
    files = sorted(path.glob("*.py"))
    chosen = next((each for each in files if len(files) == 1 or each.name == USUAL), None)
    if chosen is None:
        return Unusable(path.name, f"it has {counted(len(files), '.py file')}, and none is {USUAL}")
    if (reason := _unusable(chosen) or not_a_file(chosen)) is not None:
        return Unusable(path.name, f"{chosen.name}: {reason}")
    folder = path.resolve()
    return _of_files(path.name, chosen, kind, folder, _files_in(folder))


def _unusable(path: Path) -> str | None:
    """Return why neither a file nor a folder is at a path; ``None`` if one is."""
    if path.is_symlink():
        return "it is a link, which is not followed"
    return None if path.is_dir() else not_a_file(path)


def _files_in(folder: Path) -> Iterator[Path]:
    """Yield the regular files in a folder and its folders; links are not followed."""
    for place, _, names in os.walk(folder):
        for name in names:
            if stat.S_ISREG((file := Path(place, name)).lstat().st_mode):
                yield file


def _few(files: Iterable[Path], folder: Path) -> list[Path]:
    """Return files of a folder; ``AgentError`` if they are too many or too large."""
    found, left = list[Path](), MAX_BYTES
    for file in files:
        found.append(file)
        left -= file.stat().st_size
        if left < 0 or len(found) > MAX_FILES:
            limits = f"{MAX_FILES:,} files or {MAX_BYTES // 1024**2:,} MiB"
            raise AgentError(f"{folder.name} has more than {limits}")
    return found


def _content_digest(file: Path) -> str:
    """Return the digest of a file of any size."""
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
