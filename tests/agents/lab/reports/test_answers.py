"""The sentences of a report state what is in the data, and its verdicts claim no more."""

import re
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from helpers.results_files import OFF, ON, Cases, experiment_of, fleet_row, hall, outcomes, row

from agents.lab.parameters import PARAMETERS
from agents.lab.reports.answers import (
    MAX_DESCRIBED,
    Answer,
    FactorValue,
    answers,
    verdict_on_ranking,
)
from agents.lab.reports.results import FLEETS, LONE, ReportKind
from agents.lab.trials.interval import Interval
from agents.lab.trials.rows import Row


def answered(cases: Cases) -> tuple[Answer, ...]:
    with experiment_of(cases) as experiment:
        return answers(experiment)


def answered_of_fleets(cases: Cases) -> tuple[Answer, ...]:
    with experiment_of(cases, FLEETS) as experiment:
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


def rates_told(*rates: float, name: str = "robots") -> Sequence[str]:
    """Return the sentences for these deliveries an hour, give or take one, of 2, 4, ... robots."""
    cases = [
        ({name: 2 * number}, [fleet_row(seed, per_hour=rate + seed % 3 - 1) for seed in range(30)])
        for number, rate in enumerate(rates, start=1)
    ]
    [answer] = answered_of_fleets(cases)
    return answer.verdict, *answer.sentences


def test_too_many_robots_are_named_with_the_rise_before_and_the_fall_after() -> None:
    assert rates_told(40, 60.1, 60.2, 30)[:3] == (
        "More than 6 are too many: the number of items an hour is highest at robots 6: 60.2, "
        "against 40.0 at robots 2 and 30.0 at robots 8.",
        "Deliveries rise from 40.0 an hour (39.7 to 40.3) at robots 2 "
        "to 60.2 an hour (59.9 to 60.5) at robots 6, and fall to 30.0 an hour (29.7 to 30.3) at "
        "robots 8; the intervals allow as many 60.1 an hour (59.8 to 60.4) at robots 4.",
        "Seed by seed, robots 6 against robots 4: 0.10 (0.10 to 0.10) more an hour.",
    )


@pytest.mark.parametrize(
    ("rates", "verdict", "sentence"),
    [
        ((40, 50, 60), "6 are not too many: the number of items an hour rises from 40.0 at",
         "Deliveries rise from 40.0"),
        ((60, 50, 40), "More than 2 are too many: the number of items an hour falls from 60.0",
         "Deliveries fall from 60.0"),
        ((40, 60.1, 60), "More than 4 are too many: the number of items an hour rises from 40.0 at",
         "Deliveries rise from 40.0 an hour (39.7 to 40.3) at robots 2 to 60.1 an hour (59.8 to "
         "60.4) at robots 4, and are about the same, 60.0"),
        ((60, 60.1, 60), "More than 4 are too many: no clear change: ",
         "Deliveries are all but the same, 60.0"),
        ((40, 60, 60, 30), "More than 6 are too many: the number of items an hour is highest at",
         "Deliveries rise from 40.0"),
    ],
)  # fmt: skip
def test_a_trend_is_told_by_its_ends_and_its_best_value_that_is_not_clearly_worse(
    rates: Sequence[float], verdict: str, sentence: str
) -> None:
    said = rates_told(*rates)
    assert said[0].startswith(verdict)
    assert said[1].startswith(sentence)


def test_of_people_it_is_not_said_how_many_are_too_many() -> None:
    verdict, sentence, *_ = rates_told(40, 60, 30, name="people")
    assert sentence.startswith("Deliveries rise from 40.0")
    assert verdict == (
        "The number of items an hour is highest at people 4: 60.0, against 40.0 at people 2 and "
        "30.0 at people 6."
    )


def test_robots_are_too_many_among_the_numbers_that_can_be_compared() -> None:
    sizes = [({"robots": n}, [fleet_row(seed, per_hour=100.0 / n + seed % 3) for seed in range(30)])
             for n in (1, 2, 4)]  # fmt: skip
    other = {"robots": 3, "people": 2, "max_steps": 60}
    answer = answered_of_fleets([*sizes, (other, [fleet_row(seed) for seed in range(30)])])[0]
    assert answer.question == "How many robots are too many?"
    assert "more than 1 are too many: " in answer.verdict


def test_the_verdict_on_fleets_is_that_of_the_seeds_they_share() -> None:
    def verdict(first_seed: int) -> str:
        cases = [
            ({"robots": robots}, [
                fleet_row(start + n, per_hour=rate + 9 * (n % 5) + n % robots / robots)
                for n in range(30)
            ])
            for robots, rate, start in ((2, 20.0, 0), (4, 60.0, 0), (8, 58.0, first_seed))
        ]  # fmt: skip
        return answered_of_fleets(cases)[0].verdict

    assert verdict(500).startswith("8 are not too many: "), "the intervals overlap"
    assert verdict(0).startswith("More than 4 are too many: "), "less with each seed that both have"


def test_a_lead_that_chance_explains_makes_no_fleet_too_large() -> None:
    cases = [
        ({"robots": robots}, [fleet_row(n, per_hour=rate + (n * robots) % 7) for n in range(30)])
        for robots, rate in ((2, 20.0), (4, 60.2), (8, 60.0))
    ]
    assert answered_of_fleets(cases)[0].verdict.startswith("8 are not too many: ")


def test_few_episodes_allow_no_verdict_and_no_word_on_what_is_the_same() -> None:
    cases = [
        ({"robots": n}, [fleet_row(0, per_hour=rate)])
        for n, rate in ((4, 9.0), (8, 50.0), (16, 30.0))
    ]
    [answer] = answered_of_fleets(cases)
    assert answer.verdict == (
        "Too few episodes to tell: the number of items an hour is 9.00 at robots 4, 50.0 at robots "
        "8 and 30.0 at robots 16."
    )
    assert answer.sentences[0] == (
        "Deliveries rise from 9.00 an hour at robots 4 to 50.0 an hour at robots 8, and are 30.0 "
        "an hour at robots 16."
    )


def test_the_hardest_layout_of_a_fleet_comes_first(tmp_path: Path) -> None:
    cases = []
    for name, rate in (("easy", 90.0), ("hard", 30.0)):
        file = tmp_path / f"{name}.txt"
        file.write_text("######\n#P...#\n#...D#\n######\n" + "######\n" * (name == "easy"))
        rows = [fleet_row(seed, per_hour=rate + seed % 3) for seed in range(30)]
        cases.append(({"robots": 2, "layout": str(file)}, rows))
    [answer] = answered_of_fleets(cases)
    assert answer.question == "Which layout is hardest?"
    assert answer.verdict == (
        "Layout hard.txt is hardest: 31.0 items an hour, against 91.0 with layout easy.txt."
    )
    assert answer.sentences[0].startswith("Fewest are delivered with layout hard.txt: 31.0 ")


def test_the_best_of_values_without_an_order_comes_first_with_its_measures() -> None:
    slow = [
        fleet_row(0, "late", on_time=0.25, joules_per_delivery=2000.0, per_hour=50.0),
        fleet_row(1),
    ]
    fast = [fleet_row(seed, per_hour=200.0) for seed in range(2)]
    none = fleet_row(0, delivered=0, per_hour=0.0, on_time=None, joules_per_delivery=None,
                 distance=0, blocked_by_robot=0)  # fmt: skip
    agents = (("a", slow), ("b", fast), ("c", [none]))
    [answer] = answered_of_fleets([({"robots": 3, "agent": name}, rows) for name, rows in agents])
    assert answer == Answer(
        "Which agent does best?",
        "Too few episodes to tell: from 200 items an hour with agent b to 0.00 with agent c.",
        (
            "Most are delivered with agent b: 200 an hour with agent b, 115 an hour with agent a "
            "and 0.00 an hour with agent c.",
            "There are 2 episodes with agent a, 2 episodes with agent b and 1 episode with agent "
            "c.",
            "The share on time is 50.0% with agent b and 37.5% with agent a.",
            "A delivery costs 1.00 kJ with agent b and 1.50 kJ with agent a.",
            "The share of moves that other robots block is 10% with agent b and 10% with agent a.",
            "The episodes with agent b are 100% served.",
            "The episodes with agent a are 50% late and 50% served.",
            "The episodes with agent c are 100% served.",
        ),
    )


def test_other_combinations_are_told_in_short() -> None:
    cases = [
        ({"order_rate": rate, "robots": robots}, [fleet_row(0, per_hour=100.0 * rate - robots)])
        for rate in (0.06, 0.1, 0.2, 0.3, 0.4, 0.5)
        for robots in (4, 8)
    ]
    robots, _ = answered_of_fleets(cases)
    assert robots.sentences[0].startswith("With order_rate 0.06, most are delivered with robots 4")
    assert robots.sentences[-1] == (
        "Elsewhere most are delivered with robots 4 with order_rate 0.1, 6.00 an hour; robots 4 "
        "with order_rate 0.2, 16.0 an hour; robots 4 with order_rate 0.3, 26.0 an hour; robots 4 "
        "with order_rate 0.4, 36.0 an hour, and 1 combination more."
    )


def test_combinations_that_cannot_be_compared_are_each_described() -> None:
    cases = [({"robots": n, "people": n}, [fleet_row(0)]) for n in range(1, MAX_DESCRIBED + 2)]
    [answer] = answered_of_fleets(cases)
    assert answer.question == "How does it do?"
    assert answer.verdict == (
        "No two of the combinations differ in one setting alone, so they cannot be compared."
    )
    assert answer.sentences[0] == (
        "180 an hour are delivered with robots 1, people 1 over 1 episode."
    )
    assert answer.sentences[-1] == "1 further combination cannot be compared with these."


def test_cases_without_a_common_seed_are_not_compared_seed_by_seed() -> None:
    [answer] = answered_of_fleets(
        [({"robots": 2}, [fleet_row(0)]), ({"robots": 4}, [fleet_row(1)])]
    )
    assert answer.sentences[1] == (
        "Robots 2 and robots 4 share no seed, so they are not compared seed by seed."
    )


def places(*ends: tuple[int, int]) -> list[FactorValue]:
    """Return places a, b, ... whose intervals have these ends, in percent."""
    return [
        place(name, Interval((low + high) / 200, low / 100, high / 100))
        for name, (low, high) in zip("abcdef", ends, strict=False)
    ]


def place(name: str, main: Interval, kind: ReportKind = LONE) -> FactorValue:
    results: Any = SimpleNamespace(main=main, kind=kind)
    return FactorValue(name, 0, results)


@pytest.mark.parametrize(
    ("ends", "is_clear", "words"),
    [
        ([(80, 90), (40, 60)], None, "a does best: 85% delivered, against 50% with b"),
        ([(80, 90), (70, 84)], None, "no clear difference: 85% delivered with a and 77% with b"),
        ([(80, 90), (70, 84)], True, "a does best: 85% delivered, against 77% with b"),
        ([(80, 90), (0, 9)], False, "no clear difference: 85% delivered with a and 4% with b"),
        (
            [(80, 90), (75, 85), (70, 82)],
            None,
            "no clear difference: from 85% delivered with a to 76% with c",
        ),
        (
            [(80, 90), (75, 85), (0, 8), (0, 6)],
            False,
            "a and b do best, too close to tell apart: 85% and 80% delivered, against 4% with c",
        ),
        (
            [(80, 90), (79, 89), (78, 88), (77, 87), (76, 86), (0, 6)],
            None,
            "a, b, c and 2 others do best, too close to tell apart: 85%, 84% and 83% delivered, "
            "against 3% with f",
        ),
    ],
)
def test_the_first_are_named_as_far_as_they_can_be_told_apart(
    ends: list[tuple[int, int]], is_clear: bool | None, words: str
) -> None:
    assert verdict_on_ranking(places(*ends), is_clear=is_clear) == words


def test_the_first_of_a_ranking_may_be_the_lowest() -> None:
    assert verdict_on_ranking(places((0, 9), (20, 30), (90, 99)), is_hardest=True) == (
        "a is hardest: 4% delivered, against 25% with b"
    )


def test_without_intervals_nothing_is_claimed() -> None:
    few = [place(name, Interval(value), FLEETS) for name, value in (("a", 9.0), ("b", 1.0))]
    assert verdict_on_ranking(few) == (
        "too few episodes to tell: 9.00 items an hour with a and 1.00 with b"
    )
