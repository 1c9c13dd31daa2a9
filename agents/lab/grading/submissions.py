"""Submissions: an agent to be graded by name, or all agents in a folder."""

from __future__ import annotations

import hashlib
import os
import re
import stat
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path, PurePath, PurePosixPath
from tempfile import TemporaryDirectory
from typing import NamedTuple

from agents.errors import AgentError
from agents.lab.grading.archives import (
    MAX_BYTES,
    MAX_FILES,
    copy_files,
    members_of,
    read_member,
    set_dates,
    unpack,
)
from agents.lab.runs.programs import digest_of, fingerprint
from warehouse_core.files.reading import not_a_file
from warehouse_core.wording import listed

__all__ = ["Submission", "find_submission", "in_folder"]

IMPORTED_ONCE = (
    "abc", "agents", "collections", "copy", "dataclasses", "enum", "functools", "heapq",
    "itertools", "json", "math", "matplotlib", "numpy", "queue", "random", "scipy", "torch",
    "typing", "warehouse_core",
)  # fmt: skip
"""Modules that are imported once for each submission instead of in each of its processes."""

IMPORT = re.compile(
    rb"^[ \t]*\"?(?:from[ \t]+([\w.]+)[ \t]+import[ \t]*\(?([\w \t,\n]*)|import[ \t]+([\w \t,.]+))",
    re.MULTILINE,
)
"""An import statement with its modules and names, found without parsing the source.

In a notebook the statement is in quotes."""

MAX_SOURCE = 1024 * 1024
"""Limit on the bytes of source code that are searched for imports."""

CODE, NOTEBOOK, ARCHIVE = SUFFIXES = ".py", ".ipynb", ".zip"

PREFERRED = "agent"
"""Name, without suffix, of the file that has the agent if a submission has several files."""


class Submission(NamedTuple):
    """An agent to be graded.

    Attributes:
        name: name as it was typed; in a folder, the name of the file or folder.
        shown: file or module as it was typed, for use in commands.
        file: file of the agent, relative to the archive if there is one; ``None`` for a module.
        module: name of the file without its suffix, or of the module.
        kind: name of the class; ``None`` for the only class with ``reset`` and ``act``.
        folder: folder in which the process runs and from which it imports first; ``None`` for a
            file that is graded alone.
        digest: digest of the code. It covers the file; or all files of the submission if it is a
            folder; or the module and what it imports from its package. "" for a built-in agent.
        imports: modules that are imported once, because they contain no code of the submission.
        archive: archive that ``private`` unpacks, or ``None``.
        files: files that ``private`` copies.

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
    archive: Path | None = None
    files: tuple[Path, ...] = ()

    @property
    def paths(self) -> list[str]:
        """Folders from which the process imports first."""
        if self.folder is None or self.file is None:
            return [] if self.folder is None else [str(self.folder)]
        return list(dict.fromkeys([str(self.file.parent), str(self.folder)]))

    @contextmanager
    def private(self, user: str | None, hidden: Collection[Path] = ()) -> Iterator[Submission]:
        """Yield the submission in a private folder, which is removed at the end of the block.

        The folder has only files of the submission. All of them have the same dates, and reading
        them does not change the dates, so that no process of the agent can leave a sign for the
        next one. A module, or a file in a folder that exceeds ``MAX_FILES`` or ``MAX_BYTES``, stays
        where it is.

        Args:
            user: user that runs the agent and must be able to read the files, or ``None``.
            hidden: files that are not copied.

        Raises:
            AgentError: the archive cannot be unpacked.
            OSError: a file cannot be copied.
        """
        if self.file is None or not (self.files or self.archive):
            yield self
            return
        with TemporaryDirectory(prefix="warehouse-") as name:
            place, base = Path(name).resolve(), self.folder or self.file.parent
            if self.archive is not None:
                unpack(self.archive, place)
                own = self._replace(file=place / self.file, folder=place)
            else:
                copy_files(self.files, base, place, {each.resolve() for each in hidden})
                file = place / self.file.relative_to(base)
                own = self._replace(file=file, folder=self.folder and place)
            if user is not None:
                place.chmod(0o755)
            set_dates(place)
            yield own

    def called(self, kind: str | None) -> str:
        """Return the name for ``warehouse run --agent``, with the name of the loaded class."""
        chosen = self.kind or kind
        return self.shown if self.is_built_in or chosen is None else f"{self.shown}:{chosen}"

    @property
    def is_built_in(self) -> bool:
        """Whether the agent is part of this program."""
        return self.file is None and self.shown != self.module


class Unusable(NamedTuple):
    """An entry of a folder that cannot be graded, with the reason."""

    name: str
    reason: str


def find_submission(name: str) -> Submission:
    """Return the submission named ``file.py:Class``, ``file.py``, ``module:Class``, or built-in.

    The file may also be a notebook or an archive.

    Raises:
        AgentError: there is no such agent, or it needs the map.

    Example:
        >>> from pathlib import Path
        >>> from agents.lab.grading.submissions import find_submission
        >>> size = Path("mine.py").write_text("class Mine: ...")
        >>> find_submission("mine.py:Mine").kind
        'Mine'
    """
    source, colon, last = name.rpartition(":")
    if name.endswith(SUFFIXES):
        source, kind = name, None
    elif colon:
        kind = last
    else:
        return _built_in(name)
    if not source.endswith(SUFFIXES):
        code = fingerprint(None, source) or ""
        return Submission(name, source, None, source, kind, Path.cwd(), code)
    file = Path(source)
    try:
        if not file.is_file():
            raise AgentError(not_a_file(file) or "there is no such file")
        if file.suffix == ARCHIVE:
            return _of_archive(name, file, kind)
        return _of_file(name, file, kind)
    except AgentError as error:
        raise AgentError(f"agent file {file}: {error}") from None


def in_folder(
    folder: Path, kind: str | None, other: Collection[Path] = ()
) -> Iterator[Submission | Unusable]:
    """Yield the submissions in a folder in the order of their names.

    Each file and each folder is a submission, except for hidden ones. Links are not followed, so
    that nobody is graded with another student's file.

    Args:
        folder: folder of the submissions.
        kind: name of the class in each submission; ``None`` for the only one.
        other: files and folders that are not submissions.

    Yields:
        submissions; ``Unusable`` for entries that cannot be graded.

    Example:
        >>> from pathlib import Path
        >>> from agents.lab.grading.submissions import in_folder
        >>> Path("class").mkdir()
        >>> for name in ("one.py", "two.py"):
        ...     Path("class", name).touch()
        >>> [submission.name for submission in in_folder(Path("class"), None)]
        ['one.py', 'two.py']
    """
    ours = {path.resolve() for path in other}
    for path in sorted(folder.iterdir()):
        if path.name.startswith((".", "__")) or folder.resolve() / path.name in ours:
            continue
        try:
            yield submission_at(path, kind)
        except (AgentError, OSError) as error:
            yield Unusable(path.name, str(error))


def submission_at(path: Path, kind: str | None) -> Submission:
    """Return the submission in a file, an archive or a folder.

    A file is graded alone. A folder that contains only an archive, as made by Moodle, is treated as
    the archive.

    Raises:
        AgentError: there is no agent, or the path is a link.
    """
    _check_kind(path)
    file, files, folder = path, list[Path](), None
    if path.is_dir():
        folder = path.resolve()
        files = files_in(folder)
        file = path / _choose((each.relative_to(folder) for each in files), SUFFIXES)
        try:
            _check_kind(file)
        except AgentError as error:
            raise AgentError(f"{file.relative_to(path).as_posix()}: {error}") from None
    if file.suffix == ARCHIVE:
        return _of_archive(path.name, file, kind)
    if file.suffix not in SUFFIXES:
        raise AgentError(f"it is neither a {CODE}, {NOTEBOOK} or {ARCHIVE} file nor a folder")
    return _of_files(path.name, file, kind, files, folder)


def files_in(folder: Path) -> list[Path]:
    """Return the files in a folder and its subfolders, at most one more than ``MAX_FILES``.

    Links are not followed. They and all other entries that are not folders count as files.
    """
    walk = (Path(place, name) for place, _, names in os.walk(folder) for name in names)
    return list(islice(walk, MAX_FILES + 1))


def _check_kind(path: Path) -> None:
    """Raise ``AgentError`` if a path is neither a file nor a folder."""
    if path.is_symlink():
        raise AgentError("it is a link, which is not followed")
    if not path.is_dir() and (kind := not_a_file(path)) is not None:
        raise AgentError(kind)


def _choose(names: Iterable[PurePath], suffixes: Sequence[str]) -> PurePath:
    """Return the file of the agent among the files of a submission.

    Files in the topmost folder that has any are preferred. If exactly one of them is called
    ``agent.py``, it is chosen, otherwise the only ``.py`` file. If there is no ``.py`` file, the
    next suffix is tried.

    Raises:
        AgentError: there is no such file, or there are several.
    """
    shown = [each for each in names if not any(part[:1] == "." or part[:2] == "__"
                                               for part in each.parts)]  # fmt: skip
    for suffix in suffixes:
        found = [each for each in shown if each.suffix == suffix]
        for group in ([each for each in found if each.stem == PREFERRED], found):
            depth = min((len(each.parts) for each in group), default=0)
            top = [each for each in group if len(each.parts) == depth]
            if len(top) == 1:
                return top[0]
        if found:
            raise AgentError(
                f"it has {len(found)} {suffix} files, but none is called {PREFERRED}{suffix}"
            )
    raise AgentError(f"it has no {listed(suffixes, 'or')} file")


def _of_archive(name: str, file: Path, kind: str | None) -> Submission:
    """Return the submission in an archive, without unpacking it."""
    members = members_of(file)
    inner = _choose(members, (CODE, NOTEBOOK))
    own = {PurePath(part).stem for member in members for part in member.parts}
    once = _imported_once(read_member(file, PurePosixPath(inner), MAX_SOURCE), own.__contains__)
    return Submission(
        name, str(inner), Path(inner), inner.stem, kind, None, _content_digest(file), once,
        file.resolve(),
    )  # fmt: skip


def _of_files(
    name: str, file: Path, kind: str | None, files: Iterable[Path] = (), folder: Path | None = None
) -> Submission:
    """Return the submission in a file.

    Args:
        name: name of the submission.
        file: file of the agent.
        kind: name of the class, or ``None``.
        files: all files of the submission, if there are others.
        folder: folder from which the agent may import, or ``None``.
    """
    path = file.resolve().parent / file.name

    def is_own(top: str) -> bool:
        places = () if folder is None else (folder, path.parent)
        return any((place / each).exists() for place in places for each in (f"{top}.py", top))

    base, found = folder or path.parent, {each: each.lstat() for each in files or [path]}
    if len(found) > MAX_FILES or sum(each.st_size for each in found.values()) > MAX_BYTES:
        raise AgentError(f"it has more than {MAX_FILES:,} files or {MAX_BYTES // 1024**2:,} MiB")
    regular = (each for each, status in found.items() if stat.S_ISREG(status.st_mode))
    digest = digest_of(regular, base, _content_digest)
    with path.open("rb") as source:
        once = _imported_once(source.read(MAX_SOURCE), is_own)
    own = tuple(found)
    return Submission(name, str(file), path, file.stem, kind, folder, digest, once, files=own)


def _of_file(name: str, file: Path, kind: str | None) -> Submission:
    """Return the submission in a file that may import and read what lies next to it."""
    folder = file.resolve().parent
    submission = _of_files(name, file, kind, folder=folder)
    near = [*dict.fromkeys([folder / file.name, *files_in(folder)])]
    size = sum(each.lstat().st_size for each in near)
    is_small = len(near) <= MAX_FILES and size <= MAX_BYTES
    return submission._replace(files=tuple(near) if is_small else ())


def _imported_once(text: bytes, is_own: Callable[[str], bool]) -> tuple[str, ...]:
    """Return modules to import once; the source is not parsed, which might need much memory."""
    return tuple(sorted({
        module for module in _imports_in(text)
        if (top := module.partition(".")[0]) in IMPORTED_ONCE and not is_own(top)
    }))  # fmt: skip


def _imports_in(text: bytes) -> Iterator[str]:
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
        reason = "needs the map, which graded agents do not get" if made else "is not an agent"
        raise AgentError(f"{name!r} {reason}; allowed: {', '.join(graded)}, or file.py:Class")
    module = made.__module__
    return Submission(name, name, None, module, made.__name__, Path.cwd(), "", (module,))


def _content_digest(file: Path) -> str:
    """Return the SHA-256 digest of a file, which is not read into memory at once."""
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
