"""Grade an agent: run the episodes of a rubric and judge each criterion."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

from agents.errors import GradeError
from agents.lab.grading.archives import NOTEBOOK
from agents.lab.grading.cases import CALL, Run, run_cases
from agents.lab.grading.criteria import VISIBLE, Criterion, Runs, outcomes
from agents.lab.grading.rubric import Rubric
from agents.lab.grading.sandbox import SameProcess, Sandbox
from agents.lab.grading.submissions import Submission
from agents.lab.trials.interval import percent
from warehouse_core.wording import counted, printable

__all__ = ["Grade", "GradeReport", "grade"]


REPLAY = "replay"
"""Label of the command that replays the worst episode."""


class Grade(NamedTuple):
    """Points for a criterion, with the evidence in words.

    Attributes:
        criterion: criterion.
        points: points.
        seen: result of the measure, in words.
        worst: course of the worst episode in words, or "" if all points were given.
        command: command that runs the worst episode again. It is "" if there is no worst episode,
            if it is hidden, and for a notebook, which ``warehouse run`` cannot read.
        run: worst episode, or ``None`` if there is none or if it is hidden.

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
    run: Run | None = None

    @property
    def is_full(self) -> bool:
        """Whether all points were given."""
        return self.points >= self.criterion.points

    @property
    def lines(self) -> list[tuple[str, str]]:
        """Requirement, result, worst episode and command to replay it, each with its label."""
        lines = (("required", self.criterion.asked), ("result", self.seen), ("worst", self.worst),
                 (REPLAY, self.command))  # fmt: skip
        return [(name, text) for name, text in lines if text]


class GradeReport(NamedTuple):
    """The result of grading an agent, with a grade for each criterion.

    Attributes:
        agent: name of the agent and of its class.
        title: title of the rubric.
        rubric: digest of the rubric.
        code: digest of the agent's code.
        grades: grades of all criteria.
        failure: reason why no episode could begin, or "".
        reason: reason why there are no points at all, or "".
        episodes: number of episodes.
        outcomes: number of episodes with each outcome, in words.
        withheld: points of criteria that are not shown yet.
        late: days by which the submission is late; ``deducted`` is how many points this costs.

    Example:
        >>> from agents.lab.grading.grading import GradeReport
        >>> report = GradeReport("mine.py", "Mini-lab", "", "", (), "it ended", "", 0, late=1)
        >>> report.points, report.remarks
        (0.0, ['it ended', '1 day late: 0 points deducted'])
    """

    agent: str
    title: str
    rubric: str
    code: str
    grades: tuple[Grade, ...]
    failure: str
    reason: str
    episodes: int
    outcomes: str = ""
    withheld: float = 0.0
    late: int = 0
    deducted: float = 0.0

    @property
    def remarks(self) -> list[str]:
        """Reason for no points, points deducted, and points not shown yet, each as a sentence."""
        late = f"{counted(self.late, 'day')} late: {self.deducted:g} points deducted"
        withheld = f"{self.withheld:g} more points are not shown yet" if self.withheld else ""
        return list(
            filter(None, (self.failure or self.reason, late if self.late else "", withheld))
        )

    @property
    def points(self) -> float:
        """Sum of the points, minus the points deducted because the submission is late."""
        return max(round(sum(grade.points for grade in self.grades) - self.deducted, 2), 0.0)

    @property
    def max_points(self) -> float:
        """Sum of the points that all criteria are worth."""
        return sum(grade.criterion.points for grade in self.grades)

    @property
    def worst(self) -> Grade | None:
        """Grade with the most missing points among those whose worst episode can be shown."""
        shown = [each for each in self.grades if each.run and each.run.episode]
        return max(shown, key=lambda each: each.criterion.points - each.points, default=None)

    def shown(self) -> GradeReport:
        """Return the report without criteria that students do not see on their pages."""
        grades = tuple(each for each in self.grades if each.criterion.visibility == VISIBLE)
        withheld = self.max_points - sum(each.criterion.points for each in grades)
        reason = "" if withheld else self.reason
        return self._replace(grades=grades, withheld=withheld, reason=reason)


def grade(
    submission: Submission,
    rubric: Rubric,
    user: str | None = None,
    advance: Callable[[], None] = lambda: None,
    *,
    make_runner: type[Sandbox | SameProcess] = Sandbox,
) -> GradeReport:
    """Run the episodes of a rubric with an agent, and return the report.

    The report of a deterministic agent depends only on the agent and the rubric, unless an answer
    takes about as long as the time limit.

    Args:
        submission: agent to be graded.
        rubric: criteria, cases and limits.
        user: user that runs the agent, see ``Sandbox``; ``None`` is the current user.
        advance: function that is called after each episode.
        make_runner: class that runs episodes, in processes of their own or in the current one.

    Raises:
        GradeError: no episode counts for a criterion, or the system cannot run agents.

    Example:
        >>> from dataclasses import replace
        >>> from agents.lab.grading.grading import grade
        >>> from agents.lab.grading.rubric import MINI_LAB, load_rubric
        >>> from agents.lab.grading.submissions import find_submission
        >>> rubric = load_rubric(MINI_LAB)
        >>> one = rubric.criteria[3]._replace(needs=None)
        >>> report = grade(find_submission("greedy"), replace(rubric, criteria=(one,)))
        >>> [(grade.criterion.name, grade.points) for grade in report.grades]
        [('recognises unreachable goals', 10.0)]
    """
    # Hidden cases last, so that nothing an agent remembers of them can show in visible cases.
    cases = sorted(rubric.used_cases, key=lambda case: not case.visible)
    limits = rubric.limits
    with (
        submission.private(user, rubric.files) as own,
        make_runner(own, limits, user) as runner,
    ):
        runs = run_cases(runner, cases, limits.give_up_after, advance)
    return judge(submission, rubric, runs)


def judge(submission: Submission, rubric: Rubric, runs: Runs) -> GradeReport:
    """Return the report of a submission from its runs; see ``grade``."""
    played = (run.agent for run in runs if run.agent and run.case.unit != CALL)
    name = submission.called(next(played, None))
    grades: dict[str, Grade] = {}
    for criterion in rubric.criteria:
        grades[criterion.name] = _judge(criterion, runs, grades, name)
    is_loaded = any(run.agent for run in runs)
    report = GradeReport(
        printable(name), rubric.title, rubric.digest, submission.digest, tuple(grades.values()),
        failure="" if is_loaded else runs[0].description,
        reason="" if any(each.points for each in grades.values()) else _reason(runs),
        episodes=len(runs), outcomes=outcomes(runs), late=submission.late,
    )  # fmt: skip
    return report._replace(deducted=rubric.late.deducted(report.late, report.points))


def _reason(runs: Runs) -> str:
    """Return why an agent has no points: its most frequent failure, or how its episodes end."""
    failures = Counter(run.failure.kind for run in runs if run.failure)
    unit = runs[0].case.unit
    if not failures:
        return f"no points: {counted(len(runs), unit)}, {outcomes(runs)}"
    [(kind, count)] = failures.most_common(1)
    failed = [run for run in runs if run.failure and run.failure.kind == kind]
    first = next((run for run in failed if run.case.visible), failed[0])
    return f"no points: {count} of {counted(len(runs), unit)} failed: it {first.description}"


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
    seen = f"{_in_words(criterion, value)} {joint} {episodes}: {measure.seen(asked)}"
    found = Grade(criterion, criterion.points_for(value), seen)
    if not found.is_full:
        worst = _worst(criterion, asked)
        if worst.case.visible:
            command = "" if NOTEBOOK in name.lower() else worst.case.command(name, worst.seed)
            found = found._replace(worst=worst.description, command=command, run=worst)
        else:
            found = found._replace(worst=f"{worst.description} (a hidden {measure.unit})")
    if criterion.needs is not None and not before[criterion.needs].points:
        found = found._replace(points=0.0, seen=f"{seen}; no points without {criterion.needs!r}")
    return found


def _worst(criterion: Criterion, runs: Runs) -> Run:
    """Return the worst run, preferably a visible one.

    For measured times, which differ each time, it is the first run that exceeds the limit.
    """

    def badness(run: Run) -> float:
        found = criterion.measure.badness(run)
        return found > criterion.full if criterion.measure.is_secret else found

    visible = [run for run in runs if run.case.visible and badness(run) > 0]
    return max(visible or runs, key=badness)


def _in_words(criterion: Criterion, value: float) -> str:
    """Return a number in words; for times, only whether they are below the limit."""
    measure = criterion.measure
    if measure.is_secret:
        return "not all in time" if measure.is_better(criterion.full, value) else "all in time"
    return measure.shown(value)
