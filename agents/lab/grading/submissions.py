"""Submissions: an agent to be graded by name, or all agents in a folder."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from typing import NamedTuple

from agents.code_names import split_name
from agents.errors import AgentError
from agents.lab.grading.archives import (
    CODE,
    MAX_BYTES,
    MAX_FILES,
    NOTEBOOK,
    copy_files,
    members_of,
    place_of,
    read_member,
    set_dates,
    unpack,
)
from agents.lab.grading.students import students_in
from agents.lab.runs.programs import digest_of
from warehouse_core.files.reading import not_a_file
from warehouse_core.wording import listed

__all__ = ["Submission", "find_submission"]

IMPORTED_ONCE = (
    "abc", "agents", "collections", "copy", "dataclasses", "enum", "functools", "heapq",
    "itertools", "json", "math", "matplotlib", "numpy", "queue", "random", "scipy", "torch",
    "typing", "warehouse_core",
)  # fmt: skip
"""Modules that are imported once for each submission instead of in each of its processes."""

IMPORT = re.compile(
    rb"^[ \t]*\"?(?:from|import)[ \t]+([\w.]+)(?:[ \t]+import[ \t]*\(?([\w \t,\n]*))?",
    re.MULTILINE,
)
"""An import statement with its first module and names, found without parsing the source.

In a notebook the statement is in quotes."""

MAX_SOURCE = 1024 * 1024
"""Limit on the bytes of source code that are searched for imports."""

ARCHIVE = ".zip"
SUFFIXES = (CODE, NOTEBOOK, ARCHIVE)

LIBRARY = re.compile(r"\..*|__.*|node_modules|site-packages|venv")
"""Names of folders that students do not write, whose files are not part of a submission."""

HIDDEN = re.compile(r"\.|__")
"""Beginnings of names of files and folders that have no agent."""

PREFERRED = "agent"
"""Name, without suffix, of the file that has the agent if a submission has several files."""


class Submission(NamedTuple):
    """An agent to be graded.

    Attributes:
        name: the typed name; in a folder, the name of the entry that has the agent.
        shown: path of the file as the user typed it, which printed commands repeat, or the name of
            a built-in agent.
        file: file of the agent, relative to the archive if there is one; ``None`` for a built-in
            agent.
        module: name of the file without its suffix, or of the module of a built-in agent.
        kind: name of the class; ``None`` for the only class with ``reset`` and ``act``.
        folder: folder in which the process runs and from which it imports first; ``None`` for a
            file that is graded alone and for a built-in agent.
        digest: digest of the file, or of all files of the submission if it is a folder; "" for a
            built-in agent.
        imports: modules that are imported once, because they contain no code of the submission.
        archive: archive that ``private`` unpacks, or ``None``.
        files: files that ``private`` copies, each with its place in the copy.
        entries: names of all entries of the folder that the student has handed in.
        late: number of days by which it is late.

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
    files: tuple[tuple[Path, PurePath], ...] = ()
    entries: tuple[str, ...] = ()
    late: int = 0

    @property
    def paths(self) -> list[str]:
        """Folders from which the process imports first."""
        if self.folder is None or self.file is None:
            return []
        return list(dict.fromkeys([str(self.file.parent), str(self.folder)]))

    @contextmanager
    def private(self, user: str | None, hidden: Collection[Path] = ()) -> Iterator[Submission]:
        """Yield the submission in a private folder, which is removed at the end of the block.

        The folder has only files of the submission. All of them have the same dates, and reading
        them does not change the dates, so that no process of the agent can leave a sign for the
        next one. A built-in agent needs no folder.

        Args:
            user: user that runs the agent and must be able to read the files, or ``None``.
            hidden: files that are not copied.

        Raises:
            AgentError: the archive cannot be unpacked.
            OSError: a file cannot be copied.
        """
        if self.file is None:
            yield self
            return
        with TemporaryDirectory(prefix="warehouse-") as name:
            place = Path(name).resolve()
            if self.archive is not None:
                unpack(self.archive, place)
                own = self._replace(file=place / self.file, folder=place)
            else:
                copy_files(self.files, place, {each.resolve() for each in hidden})
                file = place / dict(self.files)[self.file]
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
        return self.file is None


class Unusable(NamedTuple):
    """A student whose submission cannot be graded, with the reason; see ``Submission``."""

    name: str
    reason: str
    entries: tuple[str, ...] = ()
    late: int = 0
    digest: str = ""


def find_submission(name: str) -> Submission:
    """Return the submission named ``file.py:Class``, ``file.py``, or like a built-in agent.

    The file may also be a notebook or an archive.

    Raises:
        AgentError: there is no such agent, it needs the map, or arguments follow its name.

    Example:
        >>> from pathlib import Path
        >>> from agents.lab.grading.submissions import find_submission
        >>> size = Path("mine.py").write_text("class Mine: ...")
        >>> find_submission("mine.py:Mine").kind
        'Mine'
    """
    source, kind, options = split_name(name, SUFFIXES)
    if options:
        raise AgentError(f"agent {name!r}: graded agents take no arguments; given: {options}")
    if not source.lower().endswith(SUFFIXES):
        return _built_in(name)
    file = Path(source)
    try:
        if not file.is_file():
            raise AgentError(not_a_file(file) or "there is no such file")
        if _kind_of(file) == ARCHIVE:
            return _of_archive(name, file, kind)
        return _of_file(name, file, kind)
    except AgentError as error:
        raise AgentError(f"agent file {file}: {error}") from None


def in_folder(
    folder: Path, kind: str | None, other: Collection[Path] = ()
) -> Iterator[Submission | Unusable]:
    """Yield the submissions in a folder in the order of their names.

    All parts with the same number of a student are one submission, and so is any file or folder
    that is not in ``other``, see ``students.py``. Links are not followed, so that nobody is graded
    with another student's file. ``kind`` is the name of the class; ``None`` for the only one.
    """
    for student in students_in(folder, other)[0]:
        try:
            yield submission_of(student, kind)
        except (AgentError, OSError) as error:
            entries = tuple(path.name for path, _ in student)
            yield Unusable(entries[0], str(error), entries)


def submission_of(student: Sequence[tuple[Path, str]], kind: str | None) -> Submission:
    """Return the submission of a student, given the parts and the names that they had.

    A single file is graded alone. If there is an archive and no code next to it, as in folders
    from Moodle, the archive is graded.

    Raises:
        AgentError: there is no agent, or a part is a link.
    """
    found, parts = dict[PurePath, Path](), dict[Path, Path]()
    entries = tuple(path.name for path, _ in student)
    for part, given in student:
        _check_kind(part)
        base = part.resolve() if part.is_dir() else part.parent.resolve() / part.name
        inner = {PurePath(file.relative_to(base)): file for file in files_in(base)}
        _add(found, inner if part.is_dir() else {PurePath(given): base})
        parts[base] = part
    if not any(map(Path.is_dir, parts)) and not any(_kind_of(each) in SUFFIXES for each in found):
        raise AgentError(f"it is neither a {CODE}, {NOTEBOOK} or {ARCHIVE} file nor a folder")
    chosen = _choose(found, SUFFIXES)
    file = found[chosen]
    base = next(base for base in parts if file.is_relative_to(base))
    name, shown = parts[base].name, parts[base] / file.relative_to(base)
    _check_kind(file, f"{chosen.as_posix()}: ")
    if _kind_of(chosen) == ARCHIVE:
        return _of_archive(name, file, kind)._replace(entries=entries)
    folder = None
    if len(parts) > 1 or base.is_dir():
        folder = base if len(parts) == 1 else base.parent
    return _of_files(name, shown, chosen, kind, found, folder)._replace(entries=entries)


def _add(found: dict[PurePath, Path], files: Mapping[PurePath, Path]) -> None:
    """Add files to the files of a submission, by their places in its private copy."""
    for inner, file in sorted(files.items(), key=lambda each: place_of(each[0]) != each[0]):
        place = place_of(inner)
        if place in found and inner == place and _kind_of(place) in SUFFIXES:
            raise AgentError(f"two of its files are called {place.as_posix()}")
        found.setdefault(inner if place in found else place, file)


def _kind_of(path: PurePath) -> str:
    """Return the suffix of a file in lower case."""
    return path.suffix.lower()


def files_in(folder: Path) -> list[Path]:
    """Return the files in a folder and its subfolders except for ``LIBRARY``.

    There is at most one file too many. Links are not followed. They and all other entries that are
    not folders count as files.
    """
    return list(islice(_files_in(folder), MAX_FILES + 1))


def _files_in(folder: Path) -> Iterator[Path]:
    for place, inner, names in os.walk(folder):
        inner[:] = [each for each in inner if not LIBRARY.fullmatch(each)]
        yield from (Path(place, name) for name in names)


def _is_too_large(files: Collection[Path]) -> bool:
    return len(files) > MAX_FILES or sum(each.lstat().st_size for each in files) > MAX_BYTES


def _check_kind(path: Path, where: str = "") -> None:
    """Raise ``AgentError`` if a path is neither a file nor a folder."""
    if path.is_symlink():
        raise AgentError(f"{where}it is a link, which is not followed")
    if not path.is_dir() and (kind := not_a_file(path)) is not None:
        raise AgentError(f"{where}{kind}")


def _choose(names: Iterable[PurePath], suffixes: Sequence[str]) -> PurePath:
    """Return the file of the agent among the files of a submission.

    Files in the topmost folder that has any are preferred. If exactly one of them is called
    ``agent.py``, in whatever case, it is chosen, otherwise the only ``.py`` file. If there is no
    ``.py`` file, the next suffix is tried.

    Raises:
        AgentError: there is no such file, or there are several.
    """
    shown = [each for each in names if not any(map(HIDDEN.match, each.parts))]
    for suffix in suffixes:
        found = [each for each in shown if _kind_of(each) == suffix]
        for group in ([each for each in found if each.stem.lower() == PREFERRED], found):
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
    once = _imported_once(read_member(file, inner, MAX_SOURCE), members)
    return Submission(
        name, str(inner), Path(inner), inner.stem, kind, None, _content_digest(file), once,
        file.resolve(),
    )  # fmt: skip


def _of_files(
    name: str,
    shown: Path,
    inner: PurePath,
    kind: str | None,
    files: Mapping[PurePath, Path],
    folder: Path | None,
    nearby: Mapping[PurePath, Path] | None = None,
) -> Submission:
    """Return the submission in some files.

    Args:
        name: name of the submission.
        shown: file of the agent, for use in commands.
        inner: place of this file in the private copy.
        kind: name of the class, or ``None``.
        files: files of the submission by their places in the private copy.
        folder: folder from which the agent may import, or ``None``.
        nearby: further files that are copied, but not part of the digest.
    """
    path, own = files[inner], dict(files)
    if _is_too_large(files.values()):
        raise AgentError(f"it has more than {MAX_FILES:,} files or {MAX_BYTES // 1024**2:,} MiB")
    _add(own, nearby or {})
    regular = (file for file in files.values() if file.is_file() and not file.is_symlink())
    digest = digest_of(regular, folder or path.parent, _content_digest)
    with path.open("rb") as source:
        text = source.read(MAX_SOURCE)
    once = _imported_once(text, () if folder is None else own)
    copied = tuple((file, place) for place, file in own.items())
    return Submission(name, str(shown), path, inner.stem, kind, folder, digest, once, files=copied)


def _of_file(name: str, file: Path, kind: str | None) -> Submission:
    """Return the submission in a file that may import and read what lies next to it.

    If there is too much, it may import the code in its folder.
    """
    folder, place = file.resolve().parent, place_of(PurePath(file.name))
    near, path = files_in(folder), folder / file.name
    if _is_too_large(near):
        near = [each for each in folder.glob(f"*{CODE}") if not _is_too_large([each])][:MAX_FILES]
    nearby = {PurePath(each.relative_to(folder)): each for each in near if each != path}
    return _of_files(name, file, place, kind, {place: path}, folder, nearby)


def _imported_once(text: bytes, files: Iterable[PurePath]) -> tuple[str, ...]:
    """Return modules to import once: none of which the submission has a file or folder.

    The source is not parsed, which might need much memory.
    """
    own, found = {PurePath(part).stem for each in files for part in each.parts}, set[str]()
    for module, names in IMPORT.findall(text):
        top = module.decode().partition(".")[0]
        if top in IMPORTED_ONCE and top not in own:
            inner = re.findall(rb"\w+", names)
            found |= {module.decode(), *(f"{module.decode()}.{each.decode()}" for each in inner)}
    return tuple(sorted(found))


def _built_in(name: str) -> Submission:
    from agents.registry import AGENTS

    made = AGENTS.get(name)
    if not isinstance(made, type):
        graded = [each for each, kind in AGENTS.items() if isinstance(kind, type)]
        reason = "needs the map, which graded agents do not get" if made else "is not an agent"
        raise AgentError(f"{name!r} {reason}; allowed: {', '.join(graded)}, or file.py:Class")
    module = made.__module__
    return Submission(name, name, None, module, made.__name__, None, "", (module,))


def _content_digest(file: Path) -> str:
    """Return the SHA-256 digest of a file, which is not read into memory at once."""
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
