"""Which values a verdict names, and what it does not claim."""

import pytest

from agents.lab.reports.analysis.verdicts import BEST, HARDEST, Standing, ranking
from agents.lab.trials.interval import Interval


def places(*ends: tuple[int, int]) -> list[Standing]:
    """Return places a, b, ... whose intervals have these ends, in percent."""
    return [
        Standing(name, Interval((low + high) / 200, low / 100, high / 100), f"{(low + high) // 2}%")
        for name, (low, high) in zip("abcdef", ends, strict=False)
    ]


@pytest.mark.parametrize(
    ("ends", "is_clear", "words"),
    [
        ([(80, 90), (40, 60)], None, "a does best: 85% delivered, against 50% with b"),
        ([(80, 90), (70, 85)], None, "no clear difference: 85% delivered with a and 77% with b"),
        ([(80, 90), (70, 85)], True, "a does best: 85% delivered, against 77% with b"),
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
    assert ranking(places(*ends), BEST, "delivered", is_clear=is_clear) == words


def test_the_first_of_a_ranking_may_be_the_lowest() -> None:
    assert ranking(places((0, 9), (20, 30), (90, 99)), HARDEST, "delivered") == (
        "a is hardest: 4% delivered, against 25% with b"
    )


def test_without_intervals_nothing_is_claimed() -> None:
    few = [Standing(name, Interval(value), f"{value}") for name, value in (("a", 9.0), ("b", 1.0))]
    assert ranking(few, BEST, "items an hour") == (
        "too few episodes to tell: 9.0 items an hour with a and 1.0 with b"
    )
