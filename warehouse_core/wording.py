"""Text for sentences: counts, lists, and text that can be shown."""

from __future__ import annotations

from collections.abc import Iterable


def counted(number: int, noun: str) -> str:
    """Return a number of things, ``1 failure`` or ``1,239 failures``."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def listed(parts: Iterable[object], word: str = "and") -> str:
    """Return parts as a list, ``a, b and c``."""
    *others, last = map(str, parts)
    return f"{', '.join(others)} {word} {last}" if others else last


def printable(text: str) -> str:
    """Return text with a space for each character that is invisible or not allowed in SVG."""
    return "".join(character if character.isprintable() else " " for character in text)


def encodable(text: str) -> str:
    """Return text that can be written as UTF-8: names of files may have bytes that cannot."""
    return text.encode(errors="backslashreplace").decode()
