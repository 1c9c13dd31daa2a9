"""The sentences of a report describe the data, and its verdicts do not claim more."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from helpers.results_files import OFF, ON, Cases, experiment_of, fleet_row, hall, outcomes, row

from agents.lab.parameters import PARAMETERS
from agents.lab.reports.answers import MAX_NAMED, Answer, answers
from agents.lab.reports.results import FLEETS, LONE, ReportKind


def answered(cases: Cases, kind: ReportKind = LONE) -> tuple[Answer, ...]:
    with experiment_of(cases, kind) as experiment:
        return answers(experiment)


def verdict(cases: Cases, kind: ReportKind = LONE) -> str:
    return answered(cases, kind)[0].verdict


def of(on: str, off: str) -> Cases:
    return [(ON, outcomes(on)), (OFF, outcomes(off))]


def test_a_question_is_answered_with_the_best_value_and_its_evidence() -> None:
    on = [row(n, steps=40 + n % 2) for n in range(20)] + outcomes("ddw", seed=20)
    off = [row(n, steps=10) for n in range(20)] + outcomes("ooo", seed=20)
    assert answered([(ON, on), (OFF, off)]) == (
        Answer(
            "Does escaping loops cut delivery time, or does it make the robot wander?",
            "No difference was found: success is 96% with escape on and 87% with escape off.",
            (
                "Success is 95.7% (79.0 to 99.2) with escape on and 87.0% (67.9 to 95.5) with "
                "escape off.",
                "A delivery takes 38.6 steps (15.1 to 40.5) with escape on and 10.0 steps "
                "(10.0 to 10.0) with escape off.",
                "Outcomes with escape on are 96% delivered and 4% wandering (23 episodes).",
                "Outcomes with escape off are 87% delivered and 13% oscillation (23 episodes).",
                "Where both deliver, escape on takes 30.5 steps more (30.2 to 30.8) than escape "
                "off.",
            ),
        ),
    )


@pytest.mark.parametrize(
    ("on", "off", "words"),
    [
        ("d" * 20, "o" * 20, "Escape on does best: 100%, 100 points more (74 to 100) than with"),
        # The intervals of 55% and 40% overlap, but no seed is delivered without escape alone.
        ("d" * 22 + "w" * 18, "d" * 16 + "o" * 24, "Escape on does best: 55%, 15.0 points more ("),
        ("d" * 5 + "w" * 35, "w" * 33 + "d" * 7, "No difference was found: success is 18% with "),
        ("ww", "oo", "No difference was found: success is 0% with escape on and 0% with"),
    ],
)
def test_two_values_are_compared_on_the_seeds_that_they_share(
    on: str, off: str, words: str
) -> None:
    assert verdict(of(on, off)).startswith(words)


@pytest.mark.parametrize(
    ("shares", "words"),
    [
        ((10, 30, 50), "Success rises from 10% with battery 1 to 50% with battery 3: 40.0 points "),
        ((50, 20, 10), "Success falls from 50% with battery 1 to 10% with battery 3: 40.0 points "),
        ((50, 52, 51), "No difference was found: success is 51% with battery 3 and 50% with"),
        ((10, 90, 30), "Success is highest with battery 2: 90%, 80.0 points more (70.0 to 86.9) "
                       "than with battery 1 and 60.0 points more (48.9 to 68.8) than with"),
    ],
)  # fmt: skip
def test_the_verdict_on_a_trend_is_about_its_ends_or_its_peak(
    shares: Sequence[int], words: str
) -> None:
    cases = [
        ({"battery": battery}, outcomes("d" * share + "w" * (100 - share)))
        for battery, share in enumerate(shares, start=1)
    ]
    assert verdict(cases).startswith(words)


def test_the_best_of_several_is_compared_with_the_next() -> None:
    cases = [
        ({"layout": "random", "agent": agent}, outcomes("d" * share + "w" * (40 - share)))
        for agent, share in (("q:t.npz", 2), ("greedy", 40), ("ppo:m.npz", 20))
    ]
    [answer] = answered(cases)
    assert answer.verdict.startswith("Agent greedy does best: 100%, 50.0 points more (")
    assert answer.verdict.endswith(") than with agent ppo:m.npz.")
    assert answer.sentences[0].count(" with agent ") == 3


@pytest.mark.parametrize(("easy", "words"), [
    (39, "Layout hall1.txt is hardest: 25%, 72.5 points less ("),
    (12, "No difference was found: success is 25% with layout hall1.txt and 30% with"),
])  # fmt: skip
def test_the_hardest_layout_comes_first_and_equal_seeds_are_different_tasks(
    tmp_path: Path, easy: int, words: str
) -> None:
    cases = [
        ({"layout": hall(tmp_path, number)}, outcomes("d" * share + "w" * (40 - share)))
        for number, share in enumerate((easy, 10))
    ]
    [answer] = answered(cases)
    assert answer.verdict.startswith(words)
    assert not any("both deliver" in each for each in answer.sentences)


def test_few_episodes_allow_no_verdict_on_a_mean() -> None:
    cases = [({"robots": n}, [fleet_row(0, per_hour=rate)]) for n, rate in ((4, 9.0), (8, 50.0))]
    assert verdict(cases, FLEETS) == (
        "Too few episodes to compare: rate of deliveries is 50.0 per hour with robots 8 and 9.00 "
        "per hour with robots 4."
    )


def test_each_other_series_has_a_verdict_of_its_own_as_far_as_there_is_room() -> None:
    cases = [
        ({"escape": escape, "battery": battery}, outcomes(("d" if escape else "o") * 30))
        for battery in (200, *range(1, MAX_NAMED + 3))
        for escape in (True, False)
    ]
    answer = answered(cases)[0]
    assert answer.verdict.startswith("With battery 200, escape on does best: 100%, 100 points more")
    assert answer.sentences[-MAX_NAMED - 1].startswith("With battery 1, escape on does best: 100%")
    assert answer.sentences[-1] == "The table has 2 further combinations."


def test_a_single_case_has_an_answer() -> None:
    [answer] = answered([({}, outcomes("dddw"))])
    assert (answer.question, answer.verdict) == ("What are the results?", "Success is 75%.")
    assert answer.sentences[0] == "Success is 75.0% (30.1 to 95.4)."
    assert answer.sentences[-1] == "Outcomes are 75% delivered and 25% wandering (4 episodes)."


def test_cases_that_cannot_be_compared_are_not_pooled() -> None:
    cases = [({"battery": n, "max_steps": n}, outcomes("d" * n)) for n in range(1, MAX_NAMED + 3)]
    [answer] = answered(cases)
    assert answer.verdict.startswith("No two of the combinations differ in one setting alone")
    assert "Outcomes with battery 3, max_steps 3 are 100% delivered (3 episodes)." in (
        answer.sentences
    )
    assert answer.sentences[-1] == "2 further combinations cannot be compared with these."


def test_every_parameter_has_its_own_question() -> None:
    assert all(each.question.endswith("?") for each in PARAMETERS.values())
    assert len({each.question for each in PARAMETERS.values()}) == len(PARAMETERS)
