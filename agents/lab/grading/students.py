"""Students of a class: the entries of a folder, and whose they are.

Learning platforms hand out one folder or file for each part of a submission, with a number of the
student in its name. All parts with the same number belong together. Any other entry is a student
of its own, unless a system or this program has put it there.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Collection, Iterable
from pathlib import Path

MOODLE = re.compile(r"(?P<name>.+)_(?P<number>\d+)_assignsubmission_[a-z]+_?(?P<file>.*)")
"""Names of parts from Moodle, such as ``Full Name_123_assignsubmission_file_``."""

CANVAS = re.compile(
    r"(?P<name>[^_]+)_(?:LATE_)?(?P<number>\d+)_(?:\d+_(?P<file>.*)|(?:text|link)\.html)"
)
"""Names of parts from Canvas, such as ``lastfirst_LATE_123_456_agent.py``."""

BLACKBOARD = re.compile(
    r"(?P<name>.+)_(?P<number>[^_]+)_attempt_(?P<time>\d{4}(?:-\d\d){5})(?:\.txt|_(?P<file>.+))"
)
"""Names of parts from Blackboard, such as ``Lab 1_ann_attempt_2026-11-28-12-00-00_agent.py``."""

AGAIN = re.compile(r"-\d+(?=\.\w+$)")
"""Number that Canvas adds to the name of a file that is handed in again."""

PHANTOM = re.compile(
    r"(\.|__|~\$).*|(eh)?thumbs\.db|desktop\.ini|icon\r|submission_metadata\.yml|"
    r".*\.(lnk|crdownload|part|csv|html|json)"
)
"""Names, in lower case, of files of systems and platforms, and of tables, pages and results."""


Student = tuple[tuple[Path, str], ...]
"""All entries that one student has handed in, each with the name that the student gave to it."""


def students_in(folder: Path, other: Collection[Path] = ()) -> tuple[list[Student], list[str]]:
    """Return the students of a folder in the order of their names, and what is no submission.

    Args:
        folder: folder of the submissions.
        other: files and folders that are neither submissions nor returned.

    Returns:
        the students, and the names of entries that systems or this program have written.
    """
    ours, place = {path.resolve() for path in other}, folder.resolve()
    paths = [path for path in sorted(folder.iterdir()) if place / path.name not in ours]
    parts: dict[tuple[str, ...], list[tuple[Path, str, str]]] = {}
    phantoms = []
    for path in paths:
        owner, given, time = _part(path)
        if len(owner) == 1 and _is_phantom(path):
            phantoms.append(path.name)
        else:
            parts.setdefault(owner, []).append((path, given, time))
    canvas = [owner for owner in parts if owner[0] == CANVAS.pattern]
    if len(canvas) == 1 and not _has_agent(given for _, given, _ in parts[canvas[0]]):
        # Such as lab_3_1_ann.py and lab_3_2_bob.py, which do not come from Canvas.
        parts |= {(path.name,): [(path, path.name, "")] for path, *_ in parts.pop(canvas[0])}
    return sorted(map(_student, parts.values())), phantoms


def _student(parts: list[tuple[Path, str, str]]) -> Student:
    if len(parts) == 1:  # a file that is graded alone keeps its name
        return ((parts[0][0], parts[0][0].name),)
    newest = max(time for _, _, time in parts)
    return tuple((path, given) for path, given, time in parts if time == newest)


def _has_agent(names: Iterable[str]) -> bool:
    code = [name for name in map(str.casefold, names) if name.endswith((".py", ".ipynb", ".zip"))]
    return len(code) < 2 or any(name.startswith("agent.") for name in code)


def _part(path: Path) -> tuple[tuple[str, ...], str, str]:
    """Return whose an entry is, its name without a prefix, and the time of the attempt."""
    name = unicodedata.normalize("NFC", path.name)
    for pattern in (MOODLE, CANVAS, BLACKBOARD):
        found = pattern.fullmatch(name)
        if found is not None:
            who = found["number"] if pattern is MOODLE else f"{found['name']}_{found['number']}"
            given = found["file"] or name
            given = AGAIN.sub("", given) if pattern is CANVAS else given
            return (pattern.pattern, key_of(who)), given, found.groupdict().get("time") or ""
    return (path.name,), path.name, ""


def _is_phantom(path: Path) -> bool:
    """Return whether a system or this program has written an entry, such as pages of a class."""
    inner = list(path.iterdir()) if path.is_dir() and (path / "index.html").exists() else []
    are_pages = bool(inner) and all(each.suffix in (".html", ".json") for each in inner)
    return are_pages or PHANTOM.fullmatch(path.name.casefold()) is not None


def key_of(name: str) -> str:
    """Return a name by which names that differ in case or in the form of Unicode are equal."""
    return unicodedata.normalize("NFC", unicodedata.normalize("NFC", name).casefold())


def finder_of(names: Iterable[str]) -> Callable[[str], str | None]:
    """Return a function that finds a name: the same one, or the only one with the same key."""
    exact, alike = set(names), dict[str, list[str]]()
    for name in exact:
        alike.setdefault(key_of(name), []).append(name)

    def find(name: str) -> str | None:
        found = [name] if name in exact else alike.get(key_of(name), [])
        return found[0] if len(found) == 1 else None

    return find
