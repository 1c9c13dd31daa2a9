"""Submissions that are alike: a hint for who grades them, and no verdict."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import combinations
from pathlib import Path

from agents.errors import AgentError
from agents.lab.grading.archives import members_of, read_member
from agents.lab.grading.rubric import Rubric
from agents.lab.grading.sandbox import AgentFailureError, Sandbox
from agents.lab.grading.submissions import CODE, MAX_SOURCE, NOTEBOOK, Submission, files_in
from agents.lab.runs.programs import ROOT
from agents.lab.trials.wording import percent
from warehouse_core.files.reading import open_file

ALIKE, FEWEST = 0.8, 60
"""Least share of the fingerprints of the smaller one that the other has too, and fewest of them."""

MAX_NAMED = 3
"""Most others that are named for a submission."""

OURS = ("agents/warehouse_agent_greedy.py", "agents/search/agents.py")
"""Files of this program that a submission may be alike."""

SOURCES = (CODE, NOTEBOOK)


def find_copies(submissions: Iterable[Submission], rubric: Rubric) -> dict[str, str]:
    """Return by the name of a submission others that it is like, in words.

    Names, values, comments and the order of functions play no part, nor does what is in the
    starting file of the rubric too. Sources are parsed under the limits of agents.
    """
    shapes = _shapes_of(submissions, rubric)
    found: dict[str, list[tuple[float, str]]] = {}
    for (name, one), (other_name, other) in combinations(shapes.items(), 2):
        fewest = min(len(one), len(other))
        if fewest >= FEWEST and (share := len(one & other) / fewest) >= ALIKE:
            found.setdefault(name, []).append((share, other_name))
            found.setdefault(other_name, []).append((share, name))
    return {
        name: ", ".join(
            f"{other} ({percent(share)})" for share, other in sorted(rows, reverse=True)[:MAX_NAMED]
        )
        for name, rows in found.items()
        if name not in OURS
    }


def _shapes_of(submissions: Iterable[Submission], rubric: Rubric) -> dict[str, frozenset[int]]:
    """Return the shape of each submission that can be parsed, and of our own agents."""
    no_agent = Submission("", "", None, "", None, None, "")
    sources = {each.name: _sources_of(each) for each in submissions}
    sources |= {name: [(CODE, _read(ROOT / name))] for name in OURS}
    start = [(CODE, _read(rubric.starter))] if rubric.starter.exists() else []
    with Sandbox(no_agent, rubric.limits) as sandbox:
        given = _shape(sandbox, start)
        return {name: _shape(sandbox, each) - given for name, each in sources.items()}


def _shape(sandbox: Sandbox, sources: list[tuple[str, str]]) -> frozenset[int]:
    try:
        with sandbox.episode() as process:
            return process.shape(sources)
    except AgentFailureError:  # it cannot be parsed, or not under the limits
        return frozenset()


def _sources_of(submission: Submission) -> list[tuple[str, str]]:
    """Return the kind and the text of each source, together at most ``MAX_SOURCE`` characters."""
    found, left = list[tuple[str, str]](), MAX_SOURCE
    try:
        for suffix, text in _texts_of(submission):
            found.append((suffix, text[:left]))
            left -= len(found[-1][1])
    except (AgentError, OSError):  # which its grade says
        return []
    return found


def _texts_of(submission: Submission) -> Iterator[tuple[str, str]]:
    """Yield the kind and the text of each source, by the order of their names."""
    path = submission.archive
    if path is not None:
        for name in members_of(path):
            if name.suffix in SOURCES and not str(name).startswith("__"):
                text = read_member(path, name, MAX_SOURCE)
                yield name.suffix, text.decode("utf-8", "replace")
    elif submission.file is not None:
        folder = submission.folder
        for file in [submission.file] if folder is None else sorted(files_in(folder)):
            if file.suffix in SOURCES and file.is_file() and not file.is_symlink():
                yield file.suffix, _read(file)


def _read(path: Path) -> str:
    with open_file(path) as file:
        return file.read(MAX_SOURCE).decode("utf-8", "replace")
