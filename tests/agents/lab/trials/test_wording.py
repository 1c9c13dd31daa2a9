"""Numbers in sentences: their digits and plurals."""

import pytest

from agents.lab.trials import wording
from agents.lab.trials.interval import Interval


def test_a_share_has_its_interval_in_brackets() -> None:
    assert wording.share(Interval(0.8744, 0.852, 0.8931)) == "87.4% (85.2 to 89.3)"


@pytest.mark.parametrize(
    ("estimate", "words"),
    [(0.05, "0.05 s (0.05 to 0.05)"), (9.99, "9.99 s (9.99 to 9.99)"),
     (48.91, "48.9 s (48.9 to 48.9)"), (107.4, "107 s (107 to 107)"),
     (3863.2, "3,863 s (3,863 to 3,863)"), (-12.34, "-12.3 s (-12.3 to -12.3)")],
)  # fmt: skip
def test_a_mean_has_three_digits_or_all_of_its_integer_part(estimate: float, words: str) -> None:
    assert wording.mean(Interval(estimate, estimate, estimate), "s") == words


def test_a_mean_may_have_no_unit_and_a_note_in_its_brackets() -> None:
    assert wording.mean(Interval(20, 10, 30), "", "shortest 8") == "20.0 (10.0 to 30.0; shortest 8)"


@pytest.mark.parametrize(
    ("probability", "words"), [(0.0, "p < 0.001"), (0.00099, "p < 0.001"), (0.05, "p = 0.050")]
)
def test_a_p_value_is_never_zero(probability: float, words: str) -> None:
    assert wording.chance(probability) == words


def test_a_mean_without_an_interval_has_no_limits() -> None:
    assert wording.mean(Interval(20), "steps") == "20.0 steps"
    assert wording.mean(Interval(20), "s", "shortest 8") == "20.0 s (shortest 8)"


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (0, "0%"),
        (0.001, "<1%"),
        (0.005, "0%"),
        (0.126, "13%"),
        (0.96, "96%"),
        (0.996, ">99%"),
        (1, "100%"),
    ],
)
def test_a_share_is_not_rounded_to_none_or_all(part: float, words: str) -> None:
    assert wording.percent(part) == words


def test_changes_have_their_sign() -> None:
    assert wording.points(0.0423) == "+4.2 points"
    assert wording.points(-0.5) == "-50.0 points"


def test_a_sentence_begins_with_a_capital_and_keeps_the_others() -> None:
    assert wording.sentence("with PPO on the grid") == "With PPO on the grid."
