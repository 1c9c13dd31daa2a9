"""The sentences of a report state what is in the data."""

import re
from collections.abc import Sequence
from pathlib import Path

import pytest
from helpers.results_files import OFF, ON, Cases, experiment_of, hall, outcomes, row

from agents.lab.parameters import PARAMETERS
from agents.lab.reports.analysis.answers import Answer, answers
from agents.lab.reports.analysis.question import MAX_DESCRIBED
from agents.lab.trials.rows import Row


def answered(cases: Cases) -> tuple[Answer, ...]:
    with experiment_of(cases) as experiment:
        return answers(experiment)


def said(cases: Cases) -> str:
    [answer] = answered(cases)
    return "\n".join(answer.sentences)


def trend(*shares: int) -> str:
    """Return the first sentence for these deliveries of 200 episodes at battery 10, 20, ..."""
    cases = [
        ({"battery": 10 * number}, outcomes("d" * share + "w" * (200 - share)))
        for number, share in enumerate(shares, start=1)
    ]
    return said(cases).splitlines()[0]


def test_the_question_of_escape_is_answered_seed_by_seed() -> None:
    on = [*outcomes("d" * 8 + "w" * 2, steps=12), row(10, steps=40), row(11, steps=40)]
    off = [*outcomes("o" * 10), row(10, steps=10), row(11, steps=10)]
    assert answered([(ON, on), (OFF, off)]) == (
        Answer(
            "Does escaping loops cut delivery time, or does it make the robot wander?",
            "Escape on does best: 83% delivered, against 17% with escape off.",
            (
                "Success is 83.3% (55.2 to 95.3) with escape on and 16.7% (4.7 to 44.8) with "
                "escape off.",
                "Of the same 12 seeds, escape on alone delivers 8 and escape off alone none, "
                "more than chance explains (p = 0.008).",
                "Oscillation with escape off (10 episodes) becomes, with escape on, delivered (8) "
                "and wandering (2).",
                "Where both deliver (2 seeds), it takes 40.0 steps with escape on and 10.0 with "
                "escape off.",
                "The mean of all deliveries, easy and hard, is 17.6 steps (shortest ways 10.0) "
                "with escape on and 10.0 steps (shortest ways 10.0) with escape off.",
                "Every failure with escape on is wandering (2 episodes).",
                "Every failure with escape off is oscillation (10 episodes).",
            ),
        ),
    )


@pytest.mark.parametrize(
    ("shares", "words"),
    [
        ((20, 60, 100), r"Success rises from 10\.0% \(.*\) at battery 10 to 50\.0% \(.*\) at "
                        r"battery 30\."),
        ((100, 60, 20), r"Success falls from 50\.0% \(.*\) at battery 30\."),
        ((20, 160, 30), r"Success rises from .*; it is highest at battery 20, 80\.0% \([^;]*"),
        ((50, 10, 90), r"Success rises from .*; it is lowest at battery 20, 5\.0% \([^;]*"),
        ((100, 101, 100), r"Success is all but the same, 50\.0% \([^;]*"),
        ((100, 160, 100), r"Success is nearly the same at both ends, 50\.0% \(.*; it is highest at "
                          r"battery 20, 80\.0% \(.*"),
        ((100, 106, 90), r"[^;]*"),
    ],
    ids=["rises", "falls", "highest", "lowest", "the same", "the same ends", "within the noise"],
)  # fmt: skip
def test_the_first_sentence_states_how_success_changes(shares: Sequence[int], words: str) -> None:
    assert re.fullmatch(words, trend(*shares))


def costly(*steps: int) -> Cases:
    """Return 30 deliveries that take these steps in turn, and 30 that take 31."""
    return of(
        [row(n, steps=steps[n % len(steps)]) for n in range(30)], outcomes("d" * 30, steps=31)
    )


def of(on: Sequence[Row], off: Sequence[Row]) -> Cases:
    return [(ON, on), (OFF, off)]


SAID: dict[str, tuple[Cases, list[str]]] = {
    "the best first": (
        of(outcomes("ddww"), outcomes("dddw")),
        ["Success is 75.0% (30.1 to 95.4) with escape off and "],
    ),
    "a clear difference": (
        of(outcomes("d" * 20), outcomes("o" * 20)),
        ["escape on alone delivers 20 and escape off alone none, more than chance"],
    ),
    "a difference by chance": (
        of(outcomes("ddd"), outcomes("doo")),
        ["escape on alone delivers 2 and escape off alone none, no more than", "(p = 0.500)"],
    ),
    "no delivery": (
        of(outcomes("w"), outcomes("o")),
        ["Of the same 1 seed, escape on and escape off deliver the same ones."],
    ),
    "no common seed": (
        of(outcomes("dd"), outcomes("od", seed=50)), ["Escape on and escape off share no seed"]
    ),
    "steps where both deliver": (
        of([row(n, steps=30 + n) for n in range(30)], outcomes("d" * 30, steps=30)),
        ["Where both deliver (30 seeds), it takes 44.5 steps with escape on and 30.0 with",
         ": escape off takes 14.5 less ("],
    ),
    "equal means": (costly(30, 31, 32), ["and 31.0 with escape off.\n"]),
    "means that differ by chance": (
        costly(30, 32, 30, 32, 30, 33), ["with escape off, a difference that chance explains.\n"]
    ),
    "means of few": (
        of(outcomes("dd", steps=30), outcomes("dd", steps=10)),
        ["it takes 30.0 steps with escape on and 10.0 with escape off.\n"],
    ),
    "failures by mode": (
        of(outcomes("dddd"), outcomes("dooowd")),
        ["No episode with escape on fails.",
         "Failures with escape off are 75% oscillation and 25% wandering (4 episodes)."],
    ),
    "what the failures of the worse case become": (
        of(outcomes("dddww"), outcomes("doooo")),
        ["off (4 episodes) becomes, with escape on, delivered (2) and wandering (2)."],
    ),
    "what its most frequent failures become": (
        of(outcomes("dddddd"), outcomes("dooowd")),
        ["Oscillation with escape off (3 episodes) becomes, with escape on, delivered (3)."],
    ),
    "the best against the next, of three pairs": (  # 2 / 2**6 each
        [({"layout": "random", "agent": agent}, outcomes(6 * letter))
         for agent, letter in (("q:t.npz", "w"), ("greedy", "d"), ("ppo:m.npz", "w"))],
        ["agent greedy alone delivers 6 and agent q:t.npz alone none", "(p = 0.094)"],
    ),
}  # fmt: skip


@pytest.mark.parametrize(("cases", "phrases"), SAID.values(), ids=SAID)
def test_the_sentences_state(cases: Cases, phrases: list[str]) -> None:
    words = said(cases)
    assert all(phrase in words for phrase in phrases), words


def test_seeds_that_are_different_tasks_are_not_compared() -> None:
    cases = [
        ({"layout": "random", "density": density}, outcomes("dw")) for density in (0.0, 0.1, 0.2)
    ]
    words = said(cases)
    assert "seed" not in words
    assert "both deliver" not in words


def test_time_and_energy_are_stated_where_they_are_measured() -> None:
    rows = [row(n, seconds=60.0 + n, joules=4000.0) for n in range(25)]
    words = said([({"backend": name}, rows) for name in ("grid", "physics")])
    assert "A delivery with backend physics, easy or hard, takes 72.0 s (" in words
    assert "4,000 J (4,000 to 4,000)" in words
    assert "A delivery with backend grid" not in words
    assert "it takes 72.0 s" not in words


def test_time_and_energy_are_compared_seed_by_seed_where_both_measure_them() -> None:
    cases = [
        ({"backend": "physics", "robot.mass": mass},
         [row(n, seconds=60.0 + n, joules=mass * (50 + n)) for n in range(25)])
        for mass in (50.0, 80.0)
    ]  # fmt: skip
    words = said(cases)
    assert "it takes 72.0 s with robot.mass 50 and 72.0 with robot.mass 80.\n" in words
    assert (
        "it takes 3,100 J with robot.mass 50 and 4,960 with robot.mass 80: robot.mass 80 " in words
    )
    assert " takes 1,860 more (" in words


def test_the_extremes_of_the_other_combinations_are_stated() -> None:
    cases = [
        ({"escape": escape, "battery": battery}, outcomes("d" * share + "o" * (10 - share)))
        for battery, shares in ((200, (9, 4)), (50, (6, 4)), (20, (4, 3)))
        for escape, share in zip((True, False), shares, strict=True)
    ]
    answer = answered(cases)[0]
    assert answer.sentences[0].startswith("With battery 200, success is 90.0%")
    assert answer.sentences[-1] == (
        "In the other 2 combinations escape on is between +10.0 points (battery 20) and +20.0 "
        "points (battery 50) ahead of the next."
    )


def test_the_extremes_of_the_other_changes_from_first_to_last_are_stated() -> None:
    cases = [
        ({"view_radius": radius, "battery": battery}, outcomes("d" * share + "w" * (10 - share)))
        for radius, shares in ((2, (1, 5, 9)), (3, (2, 2, 5)), (4, (2, 2, 3)))
        for battery, share in zip((20, 40, 60), shares, strict=True)
    ]
    sentences = [line for answer in answered(cases) for line in answer.sentences]
    one = answered([(each, rows) for each, rows in cases if each["view_radius"] != 3])[0]
    assert one.question == "How does battery capacity affect success?"
    assert one.sentences[-1] == "With view_radius 4, success changes by +10.0 points from 20 to 60."
    assert (
        "In the other 2 combinations success changes by between +10.0 points (view_radius 4, from "
        "20 to 60) and +30.0 points (view_radius 3, from 20 to 60)."
    ) in sentences


def test_a_single_case_has_an_answer() -> None:
    [answer] = answered([({}, outcomes("dddw"))])
    assert answer.question == "How does it do?"
    assert answer.verdict == "75% of 4 episodes are delivered."
    assert answer.sentences[0] == "Success is 75.0% (30.1 to 95.4) over 4 episodes."
    assert answer.sentences[-1] == "Every failure is wandering (1 episode)."


def test_unequal_numbers_of_episodes_are_stated() -> None:
    cases = [
        ({"battery": battery, "view_radius": radius}, outcomes("dw" * (count // 2)))
        for radius, counts in ((2, (50, 4, 50)), (3, (6, 6, 6)))
        for battery, count in zip((20, 60, 200), counts, strict=True)
    ]
    about_radius, about_battery = sorted(answered(cases), reverse=True)
    assert (
        "There are 50 episodes with battery 20, 50 episodes with battery 200 and 4 episodes with "
        "battery 60." in about_battery.sentences
    )
    assert about_battery.sentences[-1].endswith("+0.0 points from 20 to 200, 6 episodes each.")
    assert (
        "There are 50 episodes with view_radius 2 and 6 episodes with view_radius 3."
        in about_radius.sentences
    )
    assert about_radius.sentences[-1].endswith(", from 4 to 50 episodes each.")
    equal = said([(ON, outcomes("dw")), (OFF, outcomes("do"))])
    assert "There are" not in equal


def test_cases_that_cannot_be_compared_are_not_pooled() -> None:
    cases = [
        ({"battery": 20, "max_steps": 30}, outcomes("w" * 5)),
        ({"battery": 60, "max_steps": 90}, outcomes("d" * 50)),
    ]
    [answer] = answered(cases)
    assert answer.sentences[0] == (
        "Success is 0.0% (0.0 to 43.4) with battery 20, max_steps 30 over 5 episodes."
    )
    assert (
        "Success is 100.0% (92.9 to 100.0) with battery 60, max_steps 90 over 50 episodes."
        in answer.sentences
    )
    several = [({"battery": n, "max_steps": n}, outcomes("d")) for n in range(1, MAX_DESCRIBED + 3)]
    [answer] = answered(several)
    assert answer.sentences[-1] == "2 further combinations cannot be compared with these."


def test_of_many_values_only_the_best_and_the_worst_are_named(tmp_path: Path) -> None:
    layouts = []
    for number in range(9):
        file = hall(tmp_path, number)
        layouts.append(({"layout": file}, outcomes("d" * number + "w" * (9 - number))))
    first = said(layouts).splitlines()[0]
    assert first.count(" with layout ") == 6
    assert first.startswith("Success is 0.0% (0.0 to 29.9) with layout hall0.txt, 11.1%")
    assert "88.9% (56.5 to 98.0) with layout hall8.txt; 3 others lie between." in first


def test_every_parameter_has_its_own_question() -> None:
    assert all(each.question.endswith("?") for each in PARAMETERS.values())
    assert len({each.question for each in PARAMETERS.values()}) == len(PARAMETERS)


def test_the_hardest_layout_comes_first(tmp_path: Path) -> None:
    cases = []
    for number, outcome in enumerate(("d" * 40, "d" * 10 + "w" * 30, "d" * 25 + "w" * 15)):
        file = hall(tmp_path, number)
        cases += [
            ({"layout": file}, outcomes(outcome)),
            ({"layout": file, "battery": 9}, outcomes("d" * 20)),
        ]
    answer = next(each for each in answered(cases) if "hardest" in each.question)
    assert answer.verdict == (
        "With battery 200, layout hall1.txt is hardest: 25% delivered, against 62% with layout "
        "hall2.txt."
    )
    assert answer.sentences[0].startswith("With battery 200, success is 25.0% (")
    assert "40.2) with layout hall1.txt, 62.5% (" in answer.sentences[0]
    assert answer.sentences[-1].startswith(
        "With battery 9, layout hall1.txt is +0.0 points behind the next"
    )


def test_the_verdict_is_that_of_the_seeds_where_they_are_the_same_tasks() -> None:
    def verdict(first: str, second: str) -> str:
        return answered([(ON, outcomes(first)), (OFF, outcomes(second))])[0].verdict

    # The intervals of 55% and 40% overlap, but no seed is delivered without escape alone.
    assert verdict("d" * 22 + "w" * 18, "d" * 16 + "o" * 24).startswith("Escape on does best: 55%")
    assert verdict("d" * 5 + "w" * 35, "w" * 33 + "d" * 7) == (
        "No clear difference: 18% delivered with escape off and 12% with escape on."
    )


def test_the_verdict_on_a_trend_is_that_of_its_ends() -> None:
    def verdict(*shares: int) -> str:
        cases = [
            ({"battery": battery}, outcomes("d" * share + "w" * (100 - share)))
            for battery, share in zip((10, 20, 30), shares, strict=True)
        ]
        return answered(cases)[0].verdict

    assert verdict(10, 30, 50) == "Success rises from 10% at battery 10 to 50% at battery 30."
    assert verdict(50, 20, 10) == "Success falls from 50% at battery 10 to 10% at battery 30."
    assert verdict(50, 52, 51) == (
        "No clear change: success is 50% at battery 10 and 51% at battery 30."
    )
    assert verdict(10, 90, 30) == (
        "Success is highest at battery 20: 90%, against 10% at battery 10 and 30% at battery 30."
    )
    assert verdict(60, 5, 55).startswith("Success is lowest at battery 20: 5%, against 60% at ")
