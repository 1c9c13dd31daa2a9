"""A class of submissions in all forms: folders, files, notebooks, archives, copies and others."""

from collections.abc import Callable, Iterator
from itertools import count, islice
from pathlib import Path
from typing import NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile

from helpers.submissions import GOOD, SUBMISSIONS, notebook_of

BEFORE, AFTER = GOOD.split("class Agent:")
NESTED = f"from helper import *\nclass Agent:{AFTER}"
RENAMED = GOOD.replace("walls", "w").replace("queue", "q").replace("first", "f")

Write = Callable[[Path], object]


class Sent(NamedTuple):
    """A submission: what writes it to a path, its points, and whether it is a copy."""

    write: Write
    points: float
    is_copy: bool = False


def text_of(text: str) -> Write:
    return lambda path: path.write_text(text, encoding="utf-8")


def tree_of(**files: str) -> Write:
    """Return what writes a folder; names have ``__`` for ``/`` and ``_`` for a dot."""

    def write(path: Path) -> None:
        for name, text in files.items():
            file = path / name.replace("__", "/").replace("_", ".")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")

    return write


def archive_of(**files: str) -> Write:
    """Return what writes an archive; names are as for ``tree_of``."""

    def write(path: Path) -> None:
        with ZipFile(path, "w") as archive:
            for name, text in files.items():
                archive.writestr(name.replace("__", "/").replace("_", "."), text, ZIP_DEFLATED)

    return write


FORMS = {
    "file.py": Sent(text_of(GOOD), 100, is_copy=True),
    "other_name.py": Sent(text_of(GOOD.replace("Agent", "MyRobot")), 100, is_copy=True),
    "renamed.py": Sent(text_of(RENAMED), 100, is_copy=True),
    "cells.ipynb": Sent(text_of(notebook_of(BEFORE, f"class Agent:{AFTER}")), 100, is_copy=True),
    "draws.ipynb": Sent(
        text_of(notebook_of("%matplotlib inline\n!pip install x", GOOD, "1 / 0")), 100, is_copy=True
    ),
    "wrong.ipynb": Sent(text_of(notebook_of("class Agent\n")), 0),
    "none.ipynb": Sent(text_of("{}"), 0),
    "deep.ipynb": Sent(text_of("[" * 100_000), 0),
    "flat.zip": Sent(archive_of(agent_py=GOOD), 100, is_copy=True),
    "inner.zip": Sent(
        archive_of(ann__src__agent_py=NESTED, ann__src__helper_py=BEFORE), 100, is_copy=True
    ),
    "cells.zip": Sent(archive_of(hw_ipynb=notebook_of(GOOD)), 100, is_copy=True),
    "leaves.zip": Sent(archive_of(____src__agent_py=GOOD), 0),
    "none.zip": Sent(archive_of(notes_txt=""), 0),
    "bomb.zip": Sent(archive_of(agent_py="0" * 300_000_000), 0),
    "no_archive.zip": Sent(text_of("PK"), 0),
    "nested": Sent(tree_of(src__agent_py=NESTED, src__helper_py=BEFORE), 100, is_copy=True),
    "notebook": Sent(tree_of(hw_ipynb=notebook_of(GOOD), notes_txt=""), 100, is_copy=True),
    "two": Sent(tree_of(a_py=GOOD, b_py=GOOD), 0),
    "empty": Sent(tree_of(notes_txt=""), 0),
    "notes.txt": Sent(text_of("I was ill."), 0),
    "agents.java": Sent(text_of("class Agent {}"), 0),
    "link.py": Sent(lambda path: path.symlink_to(path.parent / "file.py"), 0),
}
"""Submissions beside those of ``SUBMISSIONS``, which are folders; their names are of files."""


def write_class(folder: Path, size: int) -> dict[str, Sent]:
    """Write as many submissions, and return them by their names."""
    folder.mkdir()
    written = dict(islice(_sent(), size))
    for name, sent in written.items():
        sent.write(folder / name)
    return written


def _sent() -> Iterator[tuple[str, Sent]]:
    """Yield submissions without end, each time around under other names."""
    for number in count():
        start = f"{number} " if number else ""
        for name, each in SUBMISSIONS.items():
            yield f"{start}{name}", Sent(tree_of(agent_py=each.source), each.points)
        for name, sent in FORMS.items():
            yield f"{start}{name}", sent
