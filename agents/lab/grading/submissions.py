"""Which agents are graded: one by its name, or those in a folder."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from agents.errors import AgentError
from agents.lab.runs.programs import fingerprint, imports_of
from warehouse_core.files.kinds import not_a_file
from warehouse_core.wording import counted

IMPORTED_ONCE = (
    "abc", "agents", "collections", "copy", "dataclasses", "enum", "functools", "heapq",
    "itertools", "json", "math", "numpy", "queue", "random", "scipy", "typing", "warehouse_core",
)  # fmt: skip
"""Modules that are imported once a submission and not in each of its processes."""

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
        folder: folder in which its process runs, and looks up imports first.
        imports: modules that are imported once; none has code of the submission.
    """

    name: str
    shown: str
    file: Path | None
    module: str
    kind: str | None
    folder: Path
    imports: tuple[str, ...] = ()

    def called(self, kind: str | None) -> str:
        """Return the name by which ``warehouse run --agent`` finds it, with the class it loaded."""
        is_built_in = self.file is None and self.shown != self.module
        chosen = self.kind or kind
        return self.shown if is_built_in or chosen is None else f"{self.shown}:{chosen}"

    @property
    def digest(self) -> str:
        """The digest of its code, with what it imports from its folder."""
        return fingerprint(self.file, self.module if self.file is None else None) or ""


def find_submission(name: str) -> Submission:
    """Return the agent ``file.py:Class``, ``file.py``, ``module:Class`` or a built-in one.

    If there is none, or it needs the map, that is an ``AgentError``.
    """
    if name.endswith(".py"):
        return of_file(name, Path(name), None)
    source, colon, kind = name.rpartition(":")
    if not colon:
        return _built_in(name)
    if source.endswith(".py"):
        return of_file(name, Path(source), kind)
    return Submission(name, source, None, source, kind, Path.cwd())


def of_file(name: str, file: Path, kind: str | None) -> Submission:
    """Return the agent in a file; that there is none is an ``AgentError``."""
    if not file.is_file():
        raise AgentError(f"agent file {file}: {not_a_file(file) or 'there is no such file'}")
    folder = file.resolve().parent
    found = {
        module for level, module in imports_of(file.read_bytes())
        if not level and module.partition(".")[0] in IMPORTED_ONCE
        and not (folder / f"{module.partition('.')[0]}.py").exists()
        and not (folder / module.partition(".")[0]).exists()
    }  # fmt: skip
    path = folder / file.name
    return Submission(name, str(file), path, file.stem, kind, folder, tuple(sorted(found)))


def _built_in(name: str) -> Submission:
    from agents.registry import AGENTS

    made = AGENTS.get(name)
    if not isinstance(made, type):
        graded = [each for each, kind in AGENTS.items() if isinstance(kind, type)]
        reason = "plans on the map, which a graded agent does not get" if made else "is no agent"
        raise AgentError(f"{name!r} {reason}; allowed: {', '.join(graded)}, or file.py:Class")
    module = made.__module__
    return Submission(name, name, None, module, made.__name__, Path.cwd(), (module,))


def in_folder(folder: Path, kind: str | None) -> Iterator[Submission | str]:
    """Yield the submissions in a folder by name: each ``.py`` file, and each folder with one.

    Of a folder without exactly one agent it is a line ``NAME: REASON``. Each has a class ``kind``.
    """
    for path in sorted(folder.iterdir()):
        if path.name.startswith((".", "__")):
            continue
        if path.suffix == ".py" and path.is_file():
            yield of_file(path.name, path, kind)
        elif path.is_dir():
            files = sorted(path.glob("*.py"))
            chosen = [each for each in files if len(files) == 1 or each.name == USUAL]
            if chosen:
                yield of_file(path.name, chosen[0], kind)
            else:
                yield f"{path.name}: it has {counted(len(files), '.py file')}, and none is {USUAL}"
