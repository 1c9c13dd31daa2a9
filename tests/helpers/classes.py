"""Folders of classes as Moodle, Canvas, Gradescope, nbgrader, Windows and macOS produce them."""

import unicodedata
from collections.abc import Callable, Iterator
from io import BytesIO
from itertools import count, cycle, islice
from pathlib import Path
from typing import NamedTuple
from zipfile import ZipFile

from helpers.submissions import notebook_of

DOUBLE = """
title = "Double it"
[late]
points = 1
[cases.double]
function = "double"
calls = [{ arguments = [1], answer = 2 }, { arguments = [3], answer = 6 }]
[[criteria]]
name = "double"
points = 10
measure = "answered"
cases = ["double"]
full = 1.0
zero = 0.0
"""
"""A rubric whose calls take little time."""

GOOD = "def double(x):\n    return 2 * x\n"
HALF = "def double(x):\n    return 2\n"
IMPORTS = "from helper import double\n"

Tree = dict[str, str | bytes]
"""Contents of files by their paths."""


def packed(**files: str) -> bytes:
    """Return an archive; names have ``__`` for a backslash and ``_`` for a dot."""
    data = BytesIO()
    with ZipFile(data, "w") as archive:
        for name, text in files.items():
            archive.writestr(name.replace("__", "\\").replace("_", "."), text)
    return data.getvalue()


def notebook(code: str) -> str:
    """Return a notebook with commands around a definition, which a class uses."""
    cells = ("files = !ls\nt = %timeit -o 1", f"{code}class Used:\n    own = double", "Used?")
    return notebook_of(*cells)


FORMS: tuple[Callable[[str], Tree], ...] = (
    lambda code: {"agent.py": code},
    lambda code: {"A.PY": code},
    lambda code: {"N.IPYNB": notebook(code)},
    lambda code: {"Z.ZIP": packed(src__agent_py=IMPORTS, src__helper_py=code)},
    lambda code: {"agent.py": IMPORTS, "helper.py": code, "notes.txt": "none"},
    lambda code: {"work/Agent.py": f"\ufeff{code}", "__MACOSX/._Agent.py": "", ".DS_Store": ""},
)  # fmt: skip
"""Files of a submission in all forms."""


def placed(prefix: str, files: Tree) -> Tree:
    return {f"{prefix}{name}": data for name, data in files.items()}


def moodle(name: str, number: int, files: Tree) -> Tree:
    start = f"{name}_{number}_assignsubmission_"
    is_flat = number % 2 and not any("/" in each for each in files)
    text = {f"{start}onlinetext_onlinetext.html" if is_flat else f"{start}onlinetext_/a.html": "."}
    return placed(f"{start}file_" if is_flat else f"{start}file_/", files) | text


def canvas(name: str, number: int, files: Tree) -> Tree:
    start = f"{name.lower()}_LATE_{number}_" if number % 2 else f"{name.lower()}_{number}_"
    again = {each.replace("agent.py", "agent-1.py"): data for each, data in files.items()}
    numbers = count(1000 * number)
    flat = {
        f"{start}{next(numbers)}_{each.rpartition('/')[2]}": data
        for each, data in again.items() if not each.startswith((".", "__"))
    }  # fmt: skip
    return flat | {f"{start}text.html": "I tried."}


SYSTEMS: dict[str, Callable[[str, int, Tree], Tree]] = {
    "Moodle": moodle,
    "Canvas": canvas,
    "Gradescope": lambda _, number, files: placed(f"submission_{number}/", files),
    "nbgrader": lambda name, number, files: (
        placed(f"{name}{number}/ps1/", files)
        | {f"{name}{number}/ps1/timestamp.txt": "2026-11-28 12:00:00 UTC"}
    ),
    "Windows": lambda name, number, files: placed(f"{name} {number}/", files),
    "macOS": lambda name, number, files: placed(
        unicodedata.normalize("NFD", f"{name} {number}/"), files
    ),
}
"""Functions that give the entries of a student, by system."""

PHANTOMS: Tree = {
    "Thumbs.db": b"\0", "desktop.ini": "", ".DS_Store": b"\0", "__MACOSX/._x.py": b"\0",
    "submission_metadata.yml": "", "~$list.docx": "", "pages/index.html": "", "pages/a.json": "",
    "m.csv": "Identifier,Full name,Grade\n", "c.csv": "Student,ID\n", "index.html": "",
    "old.csv": "\ufeffSubmission;points\n",
}  # fmt: skip
"""Files of systems and of this program, which are in every class."""

NAMES = ("Ann Lee", "Zo\u00eb", "bob", "\u00c5sa \u00d6rn", "I\u00f1aki")


class Entry(NamedTuple):
    """What is expected of a student, with an entry by which a table of late days names it."""

    late_name: str
    points: float
    days: int


def write_class(folder: Path, system: str) -> list[Entry]:
    """Write the folder of a class of 30 students, and return what is expected."""
    expected = [*islice(_written(folder, system), 30)]
    _write(folder, PHANTOMS)
    return expected


def _written(folder: Path, system: str) -> Iterator[Entry]:
    many = {f".venv/{number}.py": "" for number in range(40)}
    codes = cycle(((GOOD, 10), (HALF, 5), (GOOD, 10), ("def double(x)", 0)))
    for number, name, (code, points) in zip(count(1), cycle(NAMES), codes, strict=False):
        files = FORMS[number % len(FORMS)](code)
        if number == 6:
            files |= many
        if number == 7:
            files, points = {"answer.txt": "I was ill."}, 0
        entries = SYSTEMS[system](name, number, files)
        _write(folder, entries)
        days, [first, *_] = number % 3, sorted(entries)
        late_name = unicodedata.normalize("NFC", first.partition("/")[0]).upper()
        yield Entry(late_name, max(points - days, 0), days)


def _write(folder: Path, files: Tree) -> None:
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
