"""The sentences of a report about fleets state what is in the data."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from helpers.results_files import Cases, experiment_of, fleet_row

from agents.lab.reports.analysis.answers import Answer, answers
from agents.lab.reports.analysis.question import MAX_DESCRIBED
from agents.lab.reports.analysis.results import FLEETS


def answered(cases: Cases) -> tuple[Answer, ...]:
    with experiment_of(cases, FLEETS) as experiment:
        return answers(experiment)


def trend(*rates: float, name: str = "robots") -> Sequence[str]:
    """Return the sentences for these deliveries an hour, give or take one, of 2, 4, ... robots."""
    cases = [
        ({name: 2 * number}, [fleet_row(seed, per_hour=rate + seed % 3 - 1) for seed in range(30)])
        for number, rate in enumerate(rates, start=1)
    ]
    [answer] = answered(cases)
    return answer.verdict, *answer.sentences


def test_too_many_robots_are_named_with_the_rise_before_and_the_fall_after() -> None:
    assert trend(40, 60.1, 60.2, 30)[:3] == (
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
    said = trend(*rates)
    assert said[0].startswith(verdict)
    assert said[1].startswith(sentence)


def test_of_people_it_is_not_said_how_many_are_too_many() -> None:
    verdict, sentence, *_ = trend(40, 60, 30, name="people")
    assert sentence.startswith("Deliveries rise from 40.0")
    assert verdict == (
        "The number of items an hour is highest at people 4: 60.0, against 40.0 at people 2 and "
        "30.0 at people 6."
    )


def test_robots_are_too_many_among_the_numbers_that_can_be_compared() -> None:
    sizes = [({"robots": n}, [fleet_row(seed, per_hour=100.0 / n + seed % 3) for seed in range(30)])
             for n in (1, 2, 4)]  # fmt: skip
    other = {"robots": 3, "people": 2, "max_steps": 60}
    answer = answered([*sizes, (other, [fleet_row(seed) for seed in range(30)])])[0]
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
        return answered(cases)[0].verdict

    assert verdict(500).startswith("8 are not too many: "), "the intervals overlap"
    assert verdict(0).startswith("More than 4 are too many: "), "less with each seed that both have"


def test_a_lead_that_chance_explains_makes_no_fleet_too_large() -> None:
    cases = [
        ({"robots": robots}, [fleet_row(n, per_hour=rate + (n * robots) % 7) for n in range(30)])
        for robots, rate in ((2, 20.0), (4, 60.2), (8, 60.0))
    ]
    assert answered(cases)[0].verdict.startswith("8 are not too many: ")


def test_few_episodes_allow_no_verdict_and_no_word_on_what_is_the_same() -> None:
    cases = [
        ({"robots": n}, [fleet_row(0, per_hour=rate)])
        for n, rate in ((4, 9.0), (8, 50.0), (16, 30.0))
    ]
    [answer] = answered(cases)
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
    [answer] = answered(cases)
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
    [answer] = answered([({"robots": 3, "agent": name}, rows) for name, rows in agents])
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
    robots, _ = answered(cases)
    assert robots.sentences[0].startswith("With order_rate 0.06, most are delivered with robots 4")
    assert robots.sentences[-1] == (
        "Elsewhere most are delivered with robots 4 with order_rate 0.1, 6.00 an hour; robots 4 "
        "with order_rate 0.2, 16.0 an hour; robots 4 with order_rate 0.3, 26.0 an hour; robots 4 "
        "with order_rate 0.4, 36.0 an hour, and 1 combination more."
    )


def test_combinations_that_cannot_be_compared_are_each_described() -> None:
    cases = [({"robots": n, "people": n}, [fleet_row(0)]) for n in range(1, MAX_DESCRIBED + 2)]
    [answer] = answered(cases)
    assert answer.question == "How does it do?"
    assert answer.verdict == (
        "No two of the combinations differ in one setting alone, so they cannot be compared."
    )
    assert answer.sentences[0] == (
        "180 an hour are delivered with robots 1, people 1 over 1 episode."
    )
    assert answer.sentences[-1] == "1 further combination cannot be compared with these."


def test_cases_without_a_common_seed_are_not_compared_seed_by_seed() -> None:
    [answer] = answered([({"robots": 2}, [fleet_row(0)]), ({"robots": 4}, [fleet_row(1)])])
    assert answer.sentences[1] == (
        "Robots 2 and robots 4 share no seed, so they are not compared seed by seed."
    )
