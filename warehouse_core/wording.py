"""Text for sentences: counts, lists, and text that can be shown."""

from __future__ import annotations

import reprlib
from collections.abc import Iterable

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""First characters of cells that a spreadsheet would run; texts may come from strangers."""


def counted(number: int, noun: str) -> str:
    """Return a number of things, ``1 failure`` or ``1,239 failures``."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def listed(parts: Iterable[object], word: str = "and") -> str:
    """Return parts as a list, ``a, b and c``."""
    *others, last = map(str, parts)
    return f"{', '.join(others)} {word} {last}" if others else last


def seconds_of(time: float, digits: int = 1) -> str:
    """Return a time in seconds with some decimals: of whole milliseconds, halves are rounded up.

    The same time is a sum in one place and measured in another; the last bits of both differ.
    ``scale.js`` of the player has this rule too.
    """
    return f"{round(time, 3) + 1e-9:.{digits}f}"


def brief(value: object, most: int = 30) -> str:
    """Return a short ``repr`` of any value, even of one that has none, as a very large number.

    Texts have at most ``most`` characters, lists and the like a few times as many.
    """
    short = reprlib.Repr()
    short.maxstring = short.maxother = most
    short.maxlong = max(most, short.maxlong)
    try:
        return short.repr(value)[: 10 * most]
    except Exception:  # that of a user's class may raise anything
        return f"<{type(value).__name__}>"


def printable(text: str) -> str:
    r"""Return text in one line of visible characters, as a terminal, a page or an SVG may show it.

    Blanks and line ends become spaces, and every other invisible character its escape in Python,
    such as ``\x1b``, so that different names stay different.
    """
    return text if text.isprintable() else "".join(map(_visible, text))


def spreadsheet_text(text: str) -> str:
    """Return text that a spreadsheet shows, and does not run as a formula."""
    return f"'{text}" if text.startswith(FORMULA) else text


def _visible(character: str) -> str:
    if character.isprintable():
        return character
    return " " if character.isspace() else ascii(character)[1:-1]
