"""Parts of sentences: counts, lists, and text that is safe to show."""

from __future__ import annotations

import reprlib
from collections.abc import Iterable

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""First characters that make a spreadsheet run a cell as a formula.

The texts may come from strangers.
"""


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, such as ``1 failure`` or ``1,239 failures``."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def listed(parts: Iterable[object], word: str = "and") -> str:
    """Return parts as a list in words, such as ``a, b and c``."""
    *others, last = map(str, parts)
    return f"{', '.join(others)} {word} {last}" if others else last


def seconds_of(time: float, digits: int = 1) -> str:
    """Return a time in seconds with some decimals, with halves rounded up.

    The time is rounded to milliseconds first. One place may add up the same time that another place
    measures, and the results then differ in their last bits. The player's ``scale.js`` follows the
    same rule.
    """
    return f"{round(time, 3) + 1e-9:.{digits}f}"


def brief(value: object, most: int = 30) -> str:
    """Return a short ``repr`` of any value, even if it has no ``repr``, like a very large number.

    A text is cut to ``most`` characters, and a list or another container to a few times as many.
    """
    short = reprlib.Repr()
    short.maxstring = short.maxother = most
    short.maxlong = max(most, short.maxlong)
    try:
        return short.repr(value)[: 10 * most]
    except Exception:  # the ``repr`` of a user's class may raise anything
        return f"<{type(value).__name__}>"


def printable(text: str) -> str:
    r"""Return text as one line of visible characters, for a terminal, a page or an SVG.

    Whitespace becomes spaces. Every other invisible character becomes its Python escape, such as
    ``\x1b``, so that different names stay different.
    """
    return text if text.isprintable() else "".join(map(_visible, text))


def spreadsheet_text(text: str) -> str:
    """Return text that a spreadsheet shows and does not run as a formula."""
    return f"'{text}" if text.startswith(FORMULA) and len(text) > 1 else text


def without_guard(text: str) -> str:
    """Return text of a spreadsheet without the quote that ``spreadsheet_text`` puts before it."""
    return text[1:] if text[:1] == "'" and spreadsheet_text(text[1:]) == text else text


def _visible(character: str) -> str:
    if character.isprintable():
        return character
    return " " if character.isspace() else ascii(character)[1:-1]
