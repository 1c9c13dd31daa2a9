"""Counts have the right plural, lists end with a conjunction, and text is safe to show."""

import pytest

from warehouse_core.wording import brief, counted, listed, printable, seconds_of


def test_a_list_ends_with_a_word() -> None:
    assert [listed(parts) for parts in ("a", "ab", [1, 2, 3])] == ["a", "a and b", "1, 2 and 3"]
    assert listed("ab", "or") == "a or b"


def test_only_one_thing_is_singular() -> None:
    counts = [counted(number, "seed") for number in (0, 1, 12345)]
    assert counts == ["0 seeds", "1 seed", "12,345 seeds"]


@pytest.mark.parametrize(
    ("time", "words"),
    [(49.75, "49.8"), (49.74999999999999, "49.8"), (49.749, "49.7"), (0.25, "0.3"), (0.15, "0.2")],
)
def test_a_time_has_a_decimal_whatever_its_last_bits_are(time: float, words: str) -> None:
    # scale.test.mjs has the same times.
    assert seconds_of(time) == words
    assert seconds_of(10 * time, 0) == words.replace(".", "").lstrip("0")


def test_any_value_has_a_short_form() -> None:
    values = ("N", 1.5, 10**5000, [[[10**5000]]])
    assert [brief(value) for value in values] == ["'N'", "1.5", "<int>", "<list>"]


def test_a_long_or_deep_value_is_cut() -> None:
    deep: list[object] = []
    for _ in range(100_000):
        deep = [deep]
    assert len(brief(deep)) < 100
    assert len(brief("x" * 10**6)) == 30


def test_blanks_become_spaces_and_what_is_invisible_its_escape() -> None:
    text = "a\x00b\u200bc\u202ed\ud800 \u00e9\n\tf\u3000"
    assert printable(text) == r"a\x00b\u200bc\u202ed\ud800 " + "\u00e9  f "
