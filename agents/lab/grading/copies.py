"""Submissions that are alike: a hint for who grades them, and no verdict."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import combinations
from pathlib import Path, PurePosixPath

from agents.errors import AgentError
from agents.lab.grading.archives import members_of, read_member
from agents.lab.grading.rubric import Rubric
from agents.lab.grading.sandbox import OWN, AgentFailureError, Sandbox
from agents.lab.grading.submissions import CODE, MAX_SOURCE, NOTEBOOK, Submission
from agents.lab.trials.wording import percent
from warehouse_core.files.reading import open_file

ALIKE, FEWEST = 0.8, 60
"""Least share of the fingerprints of the smaller one that the other has too, and fewest of them."""

MAX_NAMED = 3
"""Most others that are named for a submission."""

OURS = ("agents/warehouse_agent_greedy.py", "agents/search/agents.py")
"""Files of this program that a submission may be alike."""

Shapes = dict[str, frozenset[int]]


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


def _shapes_of(submissions: Iterable[Submission], rubric: Rubric) -> Shapes:
    """Return the shape of each submission that can be parsed, and of our own agents."""
    no_agent = Submission("", "", None, "", None, None, "")
    sources = {each.name: _sources_of(each) for each in submissions}
    sources |= {name: [(CODE, _read(Path(OWN, name)))] for name in OURS}
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
    """Return the kind and the text of each source, together at most ``MAX_SOURCE`` bytes."""
    found, left = list[tuple[str, str]](), MAX_SOURCE
    try:
        for name, text in _texts_of(submission).items():
            found.append((PurePosixPath(name).suffix, text[:left]))
            left -= len(text[:left])
    except (AgentError, OSError):  # which its grade says
        return []
    return found


def _texts_of(submission: Submission) -> Mapping[str, str]:
    if submission.archive is not None:
        path = submission.archive
        names = [each for each in members_of(path) if each.suffix in (CODE, NOTEBOOK)]
        return {
            str(name): read_member(path, name, MAX_SOURCE).decode("utf-8", "replace")
            for name in names
            if not str(name).startswith("__")
        }
    if submission.file is None or submission.folder is None:
        return {} if submission.file is None else {str(submission.file): _read(submission.file)}
    paths = (each for each in sorted(submission.folder.rglob("*")) if not each.is_symlink())
    return {
        str(path): _read(path)
        for path in paths
        if path.suffix in (CODE, NOTEBOOK) and path.is_file()
    }


def _read(path: Path) -> str:
    with open_file(path) as file:
        return file.read(MAX_SOURCE).decode("utf-8", "replace")
