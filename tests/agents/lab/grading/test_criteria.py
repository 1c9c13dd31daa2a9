"""Measures: their points, words and worst episode."""

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from agents.lab.grading.cases import GradedCase, Run, count_useless
from agents.lab.grading.criteria import Criterion
from agents.lab.grading.grading import Grade, GradeReport, judge
from agents.lab.grading.rubric import LateRule, Rubric
from agents.lab.grading.sandbox import ENDS, FAILS, LOAD, SLOW, AgentFailureError
from agents.lab.grading.submissions import Submission
from warehouse_core import EpisodeRecorder, Layout, WarehouseEnv
from warehouse_core.world.actions import ACTIONS

OPEN = GradedCase("open", max_steps=60)
SHUT = GradedCase("shut", max_steps=60)
HIDDEN = GradedCase("hidden", max_steps=60, visible=False)

GOOD = Run(OPEN, 1, 20, True, 20, 0, 0, "delivered", "It delivered.", slowest=0.1, agent="Agent")
LOST = GOOD._replace(delivered=False, steps=60, mode="oscillation", sentence="It went to and fro.")
CALM = LOST._replace(case=SHUT, needed=None, mode="unreachable", sentence="No path exists.")
CRASH = AgentFailureError(FAILS, "ValueError: 3", "ValueError")


def judged(criterion: Criterion, *runs: Run) -> Grade:
    """Return the grade for episodes, whose seeds begin at 1."""
    return report_of([criterion], *runs).grades[-1]


def report_of(criteria: Sequence[Criterion], *runs: Run) -> GradeReport:
    numbered = [run._replace(seed=seed) for seed, run in enumerate(runs, 1)]
    rubric = SimpleNamespace(criteria=criteria, title="A title", digest="r", late=LateRule())
    submission = Submission("mine", "mine", Path("mine"), "mine", None, None, "c")
    return judge(submission, cast("Rubric", rubric), numbered)


def on(kind: str, full: float, zero: float, case: str = "open", **others: Any) -> Criterion:
    return Criterion("a criterion", 10, kind, (case,), full, zero, **others)


def failed(run: Run, step: int, failure: AgentFailureError = CRASH) -> Run:
    return run._replace(failure=failure, where=f" at step {step}" if step else "")


@pytest.mark.parametrize(
    ("criterion", "runs", "points", "seen", "worst"),
    [
        (on("delivered", 1, 0), [GOOD, LOST, GOOD, failed(LOST, 7)],
         5, "50% of 4 episodes: 2 delivered, 1 fails and 1 oscillation",
         (4, "fails at step 7: ValueError: 3")),
        # Other cases, and episodes without a path, do not count.
        (on("delivered", 1, 0),
         [GOOD, CALM, LOST._replace(case=SHUT), LOST._replace(needed=None)],
         10, "100% of 1 episode: 1 delivered", None),
        # 20 + 90 steps, as it charged its battery on the way.
        (on("steps_of_fewest", 1, 3), [GOOD, LOST._replace(steps=90)],
         1.25, "2.75 times in 2 episodes: 1 delivered and 1 oscillation",
         (2, "oscillation: It went to and fro.")),
        # 50 + 60 steps where 20 + 30 are enough.
        (on("steps_of_fewest", 1, 3), [GOOD._replace(steps=50), LOST._replace(needed=30), CALM],
         4, "2.20 times in 2 episodes: 1 delivered and 1 oscillation", (1, "It delivered.")),
        # One that failed is the worst, however few it needed.
        (on("steps_of_fewest", 1, 3),
         [GOOD._replace(steps=50), failed(LOST._replace(needed=30, steps=9), 10)],
         4, "2.20 times in 2 episodes: 1 delivered and 1 fails",
         (2, "fails at step 10: ValueError: 3")),
        (on("calm_without_way", 1, 0, "shut"),
         [CALM._replace(useless=10), CALM._replace(useless=11), CALM._replace(useless=12)],
         3.33, "33% of 3 episodes: 0 failures, at most 12 useless actions in an episode",
         (3, "unreachable: No path exists.; 12 useless actions")),
        (on("calm_without_way", 1, 0, "shut"), [CALM._replace(useless=60), failed(CALM, 1), CALM],
         3.33, "33% of 3 episodes: 1 failure, at most 60 useless actions in an episode",
         (2, "fails at step 1: ValueError: 3")),
        (on("protocol", 1, 0), [GOOD, GOOD._replace(unknown=2), GOOD._replace(unknown=3), LOST],
         5, "50% of 4 episodes: 0 failures, 5 unknown actions",
         (3, "It delivered.; 3 unknown actions")),
        (on("protocol", 1, 0), [LOST._replace(unknown=60), failed(LOST, 0)],
         0, "0% of 2 episodes: 1 failure, 60 unknown actions", (2, "fails: ValueError: 3")),
        (on("flawless", 1, 0),
         [GOOD, GOOD._replace(useless=2), GOOD._replace(useless=1), LOST, CALM],
         2.5, "25% of 4 episodes: 3 delivered and 1 oscillation; 0 failures, at most 2 useless "
         "actions in an episode", (2, "It delivered.; 2 useless actions")),
        (on("flawless", 1, 0), [GOOD._replace(useless=2), failed(LOST, 3)],
         0, "0% of 2 episodes: 1 delivered and 1 fails; 1 failure, at most 2 useless actions in "
         "an episode", (2, "fails at step 3: ValueError: 3")),
        # An episode in which no path exists counts too.
        (on("reward", 8, 4), [GOOD._replace(reward=12.0), CALM._replace(case=OPEN, reward=-1.0)],
         3.75, "5.50 in 2 episodes: 1 delivered and 1 unreachable",
         (2, "unreachable: No path exists.")),
        # One that failed is the worst, however much it has.
        (on("reward", 8, 4), [LOST._replace(reward=-20.0), failed(LOST._replace(reward=9.0), 2)],
         0, "-5.50 in 2 episodes: 1 fails and 1 oscillation",
         (2, "fails at step 2: ValueError: 3")),
        # The first that is too slow, not the slowest.
        (on("answer_seconds", 0.1, 0.1),
         [GOOD, GOOD._replace(slowest=0.2), GOOD._replace(slowest=0.3)],
         0, "not all in time in 3 episodes: none too slow", (2, "It delivered.")),
        (on("answer_seconds", 0.1, 0.1),
         [GOOD, failed(GOOD, 3, AgentFailureError(SLOW, "an answer"))],
         0, "not all in time in 2 episodes: 1 too slow",
         (2, "takes too long at step 3: an answer")),
        (on("answer_seconds", 0.1, 0.1),
         [GOOD, failed(GOOD, 3, AgentFailureError(ENDS, "exit code 1"))],
         10, "all in time in 2 episodes: none too slow", None),
    ],
)  # fmt: skip
def test_a_measure_is_told_with_the_worst_episode(criterion, runs, points, seen, worst) -> None:
    found = judged(criterion, *runs)
    assert (found.points, found.seen) == (points, seen)
    if worst is None:
        assert (found.is_full, found.worst, found.command) == (True, "", "")
    else:
        seed, told = worst
        assert (found.is_full, found.worst) == (False, told)
        assert found.command == f"warehouse run --agent mine:Agent --seed {seed} --max-steps 60"


def test_the_greedy_agent_is_compared_in_the_same_episodes() -> None:
    """It uses all steps in the trap, and delivers in the open hall."""
    trap = GradedCase("open", "trap", max_steps=60)
    found = judged(on("greedy_steps", 3, 1), GOOD._replace(case=trap), GOOD._replace(case=trap))
    assert (found.points, found.seen) == (10, "3.00 times in 2 episodes: 2 delivered")
    found = judged(on("greedy_steps", 4, 2), GOOD._replace(case=trap, steps=24))
    assert (found.points, found.seen) == (2.5, "2.50 times in 1 episode: 1 delivered")


def test_a_visible_episode_is_shown_before_a_worse_hidden_one() -> None:
    both = on("delivered", 1, 0)._replace(cases=("open", "hidden"))
    hidden = LOST._replace(case=HIDDEN, failure=CRASH)
    assert judged(both, GOOD, hidden, LOST).worst == "oscillation: It went to and fro."
    found = judged(both, GOOD, hidden)
    assert (found.worst, found.command) == ("fails: ValueError (a hidden episode)", "")
    assert judged(both, GOOD, LOST._replace(case=HIDDEN)).worst == "oscillation (a hidden episode)"


def test_without_any_points_for_what_a_criterion_needs_it_gives_none() -> None:
    first = on("delivered", 1, 0)
    second = on("protocol", 1, 0, needs=first.name)._replace(name="another", points=5)
    report = report_of([first, second], LOST)
    assert [each.points for each in report.grades] == [0, 0]
    assert report.grades[1].seen == (
        "100% of 1 episode: 0 failures, 0 unknown actions; no points without 'a criterion'"
    )
    report = report_of([first, second], GOOD, LOST)
    assert [each.points for each in report.grades] == [5, 5]
    assert (report.points, report.max_points, report.episodes) == (10, 15, 2)


def test_points_are_added_to_hundredths() -> None:
    criteria = [on("delivered", 1, 0)._replace(name=name, points=0.07) for name in "abc"]
    report = report_of(criteria, GOOD)
    assert sum(each.points for each in report.grades) != 0.21
    assert report.points == 0.21


def test_an_agent_that_never_began_has_the_first_reason() -> None:
    reasons = [AgentFailureError(LOAD, text) for text in ("no class", "the time is up")]
    unloaded = [LOST._replace(failure=reason, agent="") for reason in reasons]
    report = report_of([on("delivered", 1, 0)], *unloaded)
    assert (report.failure, report.agent) == ("cannot be loaded: no class", "mine")
    assert report.remarks == ["cannot be loaded: no class"]
    report = report_of([on("delivered", 1, 0)], *unloaded, GOOD)
    assert (report.failure, report.agent, report.remarks) == ("", "mine:Agent", [])


def test_a_demand_says_what_gives_none() -> None:
    assert on("greedy_steps", 3, 3).asked == "the greedy agent takes 3.00 times as many steps"
    assert on("greedy_steps", 3, 1).asked == (
        "the greedy agent takes 3.00 times as many steps; no points at 1.00 times"
    )


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_bumps_into_walls_and_what_has_no_effect_are_useless_waits_are_not(backend: str) -> None:
    env = WarehouseEnv(Layout(["P.D"]), (0, 0), backend=backend)
    env.reset(seed=0)
    recorder = EpisodeRecorder(env, seed=0)
    for action in ["N", "S", "W", "WAIT", "DROP", "PICK", "PICK", "E", "E", "E", "DROP"]:
        recorder.step(action)
    env.close()
    useless = {ACTIONS[index]: times for index, times in count_useless(recorder.episode).items()}
    expected = dict.fromkeys(["N", "S", "W", "E", "DROP", "PICK"], 1)
    assert {action: times for action, times in useless.items() if times} == expected
