"""The Python part of the playground, which runs and grades the agent in a worker of the page.

Requests and answers are JSON objects. The page shows all parts of an answer, whatever the request.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from itertools import count
from pathlib import Path
from typing import Any

from agents.errors import AgentError, frames_in, reason_of
from agents.lab.grading.cases import GradedCase
from agents.lab.grading.grading import grade
from agents.lab.grading.rubric import load_rubric, own_rubrics
from agents.lab.grading.sandbox import SameProcess
from agents.lab.grading.submissions import find_submission
from agents.lab.place import Stations
from agents.registry import make_agent
from warehouse_core import EpisodeRecorder, Layout, WarehouseError
from warehouse_core.records.failure_modes import diagnose
from warehouse_core.viz.player.page import player_page
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.wording import counted

FILE = Path("agent.py")
"""File to which the code on the page is written."""

MAX_OUTPUT = 10_000
"""Limit on the characters shown of an agent's output: the last ones."""


class Session:
    """The agent on the page and its current episode.

    Args:
        file: file to which the agent is written, and from which it is loaded.
    """

    def __init__(self, file: Path = FILE) -> None:
        self._file = file
        self._recorder: EpisodeRecorder | None = None
        self._agent: Any = None
        self._observation: Any = None

    def answer(self, question: str, advance: Callable[[int, int], None]) -> str:
        """Carry out a request of the page, and return the answer.

        Args:
            question: JSON object. Its key ``do`` is ``"step"`` for one step, ``"run"`` for all
                remaining steps, or ``"grade"`` to grade ``code`` with the rubric of ``exercise``.
                If it has an object ``start``, an episode begins before the steps. ``start`` has
                the ``code`` of the agent; ``rows``, ``stations`` and ``seed`` of the warehouse;
                and an ``exercise``, whose first case gives the other settings.
            advance: function that is called with the number of graded episodes, and of all.

        Returns:
            JSON object with ``printed``. An episode adds ``page``, ``summary``, ``steps`` and
            ``ended``. An error adds ``error`` and its ``line`` in the agent's file. A grade adds
            ``summary``, ``points``, ``max`` and ``grades``.
        """
        asked, output = json.loads(question), io.StringIO()
        found: dict[str, Any] = {}
        with redirect_stdout(output):
            try:
                with self._named_errors():
                    if asked["do"] == "grade":
                        found |= self._grade(asked["code"], asked["exercise"], advance)
                    else:
                        self._play(asked["do"], asked.get("start"))
            except WarehouseError as error:
                found["error"] = str(error)
                found["line"] = _line_of(error, self._file)
        if self._recorder is not None and asked["do"] != "grade":
            found |= self._shown(rests=asked["do"] == "step")
        found["printed"] = output.getvalue()[-MAX_OUTPUT:]
        return json.dumps(found)

    def _play(self, what: str, start: dict[str, Any] | None) -> None:
        """Take one step or all remaining steps, in a new episode if there is a start."""
        if start is not None:
            self._begin(start)
        while self._recorder is not None and not self._recorder.ended:
            self._observation = self._recorder.step(self._agent.act(self._observation))
            if what == "step":
                return

    def _begin(self, start: dict[str, Any]) -> None:
        self._recorder = None
        self._file.write_text(start["code"], encoding="utf-8")
        layout, seed = Layout(start["rows"]), start["seed"]
        self._agent = make_agent(str(self._file), seed, layout)
        case = load_rubric(own_rubrics()[start["exercise"]]).first_case or GradedCase("own")
        env, self._observation = case.begin(seed, layout, Stations(start["stations"]))
        self._agent.reset()
        self._recorder = EpisodeRecorder(env, seed=seed, agent=self._file.name)

    def _grade(
        self, code: str, exercise: str, advance: Callable[[int, int], None]
    ) -> dict[str, Any]:
        """Return the grades of some code, without criteria that are not visible to students."""
        self._file.write_text(code, encoding="utf-8")
        rubric, done = load_rubric(own_rubrics()[exercise]), count(1)
        total = rubric.episodes
        report = grade(
            find_submission(str(self._file)),
            rubric,
            advance=lambda: advance(next(done), total),
            make_runner=SameProcess,
        ).shown()
        rows = [
            {"name": row.criterion.name, "points": row.points, "max": row.criterion.points,
             "seen": row.seen}
            for row in report.grades
        ]  # fmt: skip
        summary = [f"{report.points:g} of {report.max_points:g} points", *report.remarks]
        return {
            "points": report.points,
            "max": report.max_points,
            "grades": rows,
            "summary": "; ".join(summary),
        }

    @contextmanager
    def _named_errors(self) -> Iterator[None]:
        """Raise errors in the code of the page as ``AgentError``."""
        try:
            yield
        except WarehouseError:
            raise
        except (Exception, SystemExit) as error:
            raise AgentError(reason_of(error, self._file)) from error

    def _shown(self, *, rests: bool) -> dict[str, Any]:
        assert self._recorder is not None
        episode = self._recorder.episode
        done = counted(episode.steps, "step")
        if self._recorder.ended:
            found = diagnose(episode)
            done = (
                found.sentence
                if found.mode in found.sentence
                else f"{found.mode}: {found.sentence}"
            )
        opens_at = float(episode.steps) if rests else None
        return {
            "page": player_page([track_of_record(episode)], opens_at=opens_at),
            "summary": f"{done}; reward {episode.total_reward:.1f}",
            "steps": episode.steps,
            "ended": self._recorder.ended,
        }


def _line_of(error: BaseException | None, file: Path) -> int | None:
    """Return the last line of a file in the traceback of an error or of its causes."""
    while error is not None:
        if isinstance(error, SyntaxError):
            return error.lineno
        if frames := frames_in(file, error):
            return frames[-1].lineno
        error = error.__cause__
    return None
