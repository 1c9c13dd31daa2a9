"""Counts have the right plural, lists end with a word, and text can be shown."""

from warehouse_core.wording import brief, counted, listed, printable


def test_a_list_ends_with_a_word() -> None:
    assert [listed(parts) for parts in ("a", "ab", [1, 2, 3])] == ["a", "a and b", "1, 2 and 3"]
    assert listed("ab", "or") == "a or b"


def test_only_one_thing_is_singular() -> None:
    counts = [counted(number, "seed") for number in (0, 1, 12345)]
    assert counts == ["0 seeds", "1 seed", "12,345 seeds"]


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
