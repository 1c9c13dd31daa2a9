"""Grade an agent: run the episodes of a rubric and judge each criterion."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import NamedTuple

from agents.errors import GradeError
from agents.lab.grading.cases import GradedCase
from agents.lab.grading.criteria import Criterion, Runs
from agents.lab.grading.rubric import Rubric
from agents.lab.grading.runs import Run, run_cases
from agents.lab.grading.submissions import Submission
from agents.lab.trials.wording import percent
from warehouse_core.wording import counted, printable

__all__ = ["Grade", "GradeReport", "grade"]


class Grade(NamedTuple):
    """The points for a criterion, and the evidence that was seen, in words.

    Attributes:
        worst: course of the worst episode in words, or "" if all points were given.
        command: command that shows the worst episode, or "" if there is none or it is hidden.

    Example:
        >>> from agents.lab.grading.criteria import Criterion
        >>> from agents.lab.grading.grading import Grade
        >>> criterion = Criterion("delivers", 10, "delivered", ("hidden",), full=1.0, zero=0.5)
        >>> Grade(criterion, 5.0, seen="75% of 8 episodes").is_full
        False
    """

    criterion: Criterion
    points: float
    seen: str
    worst: str = ""
    command: str = ""

    @property
    def is_full(self) -> bool:
        """Whether all points were given."""
        return self.points >= self.criterion.points


class GradeReport(NamedTuple):
    """The grade of an agent, with one for each criterion.

    Attributes:
        agent: name of the agent and of its class.
        rubric: the digest of the rubric; ``code`` is the digest of the agent's code.
        failure: reason why no episode could begin, or "".
        note: names of its files that hide modules, as a sentence, or "".

    Example:
        >>> from dataclasses import replace
        >>> from agents.lab.grading.grading import grade
        >>> from agents.lab.grading.rubric import MINI_LAB, load_rubric
        >>> from agents.lab.grading.submissions import find_submission
        >>> rubric = load_rubric(MINI_LAB)
        >>> one = rubric.criteria[3]._replace(needs=None)
        >>> report = grade(find_submission("greedy"), replace(rubric, criteria=(one,)))
        >>> report.agent, report.points, report.max_points, report.failure
        ('greedy', 10.0, 10.0, '')
    """

    agent: str
    title: str
    rubric: str
    code: str
    grades: tuple[Grade, ...]
    failure: str
    note: str
    episodes: int

    @property
    def remarks(self) -> list[str]:
        """The failure and the note, if there are any."""
        return list(filter(None, (self.failure, self.note)))

    @property
    def points(self) -> float:
        """The sum of the points."""
        return round(sum(grade.points for grade in self.grades), 2)

    @property
    def max_points(self) -> float:
        """The sum of all points that there are."""
        return sum(grade.criterion.points for grade in self.grades)


def grade(
    submission: Submission,
    rubric: Rubric,
    user: str | None = None,
    advance: Callable[[], None] = lambda: None,
) -> GradeReport:
    """Run the episodes of a rubric with an agent, and judge them.

    The report depends on the agent and the rubric alone, if the agent does, except that an answer
    near a time limit may be within it or not. If no episode counts for a criterion, or agents
    cannot be run here, that is a ``GradeError``. The agent may run as another ``user``, see
    ``Sandbox``; ``advance`` is called after each episode.

    Example:
        >>> from dataclasses import replace
        >>> from agents.lab.grading.grading import grade
        >>> from agents.lab.grading.rubric import MINI_LAB, load_rubric
        >>> from agents.lab.grading.submissions import find_submission
        >>> rubric = load_rubric(MINI_LAB)
        >>> one = rubric.criteria[3]._replace(needs=None)
        >>> report = grade(find_submission("greedy"), replace(rubric, criteria=(one,)))
        >>> [(grade.criterion.name, grade.points) for grade in report.grades]
        [('handles that there is no way', 10.0)]
    """
    # Hidden ones last: what an agent keeps of them in files is not told in visible ones.
    cases = sorted(rubric.used_cases, key=lambda case: not case.visible)
    runs = run_cases(submission, cases, rubric.limits, user, rubric.files, advance)
    played = (run.agent for run in runs if run.agent and isinstance(run.case, GradedCase))
    name = submission.called(next(played, None))
    grades: dict[str, Grade] = {}
    for criterion in rubric.criteria:
        grades[criterion.name] = _judge(criterion, runs, grades, name)
    is_loaded = any(run.agent for run in runs)
    failure = "" if is_loaded else runs[0].told
    return GradeReport(
        printable(name), rubric.title, rubric.digest, submission.digest, tuple(grades.values()),
        failure, _note(submission.hiding), len(runs),
    )  # fmt: skip


def _note(hiding: Collection[str]) -> str:
    if not hiding:
        return ""
    hide, modules = ("hide", "modules") if len(hiding) > 1 else ("hides", "a module")
    return f"{', '.join(hiding)} {hide} {modules} of that name from all imports"


def _judge(criterion: Criterion, runs: Runs, before: dict[str, Grade], name: str) -> Grade:
    measure = criterion.measure
    asked = [run for run in runs if run.case.name in criterion.cases and measure.counts(run)]
    if not asked:
        raise GradeError(
            f"criterion {criterion.name!r}: none of its cases has an episode {measure.counted}"
        )
    value = measure.value(asked)
    joint = "of" if measure.shown is percent else "in"
    episodes = counted(len(asked), measure.unit)
    seen = f"{_told(criterion, value)} {joint} {episodes}: {measure.seen(asked)}"
    found = Grade(criterion, criterion.points_for(value), seen)
    if not found.is_full:
        worst = _worst(criterion, asked)
        if worst.case.visible:
            command = worst.case.command(name, worst.seed)
            found = found._replace(worst=worst.told, command=command)
        else:
            found = found._replace(worst=f"{worst.told} (a hidden {measure.unit})")
    if criterion.needs is not None and not before[criterion.needs].points:
        found = found._replace(points=0.0, seen=f"{seen}; no points without {criterion.needs!r}")
    return found


def _worst(criterion: Criterion, runs: Runs) -> Run:
    """Return the worst episode; a visible one if any of them is not as it should be.

    Of times, which are different each time, it is the first that is above the limit.
    """

    def badness(run: Run) -> float:
        found = criterion.measure.badness(run)
        return found > criterion.full if criterion.measure.is_secret else found

    visible = [run for run in runs if run.case.visible and badness(run) > 0]
    return max(visible or runs, key=badness)


def _told(criterion: Criterion, value: float) -> str:
    """Return a number in words, of times only whether they are below the limit."""
    measure = criterion.measure
    if measure.is_secret:
        return "not all in time" if measure.is_better(criterion.full, value) else "all in time"
    return measure.shown(value)
