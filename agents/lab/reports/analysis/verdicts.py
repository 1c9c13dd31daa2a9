"""The verdict on a question: one short sentence without intervals.

It claims no more than the intervals do. Like the other sentences it begins in lower case and has
no full stop.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from agents.lab.trials.interval import Interval
from warehouse_core.wording import counted, listed

BEST, HARDEST = ("does best", "do best"), ("is hardest", "are hardest")
"""Verbs of the first of a ranking, and of several first ones."""

MAX_FIRST = 3
"""Most first ones that are named if they cannot be told apart."""


class Standing(NamedTuple):
    """A value of the factor in question, such as ``battery 20``, its result, and that as text."""

    name: str
    result: Interval
    words: str


def ranking(
    ranked: Sequence[Standing], verbs: tuple[str, str], unit: str, *, is_clear: bool | None = None
) -> str:
    """Return which of two places or more is the first, or which ones cannot be told apart.

    It is clear if the first two differ, and ``None`` if only their intervals tell.
    """
    if not all(place.result.is_known for place in ranked):
        return f"too few episodes to tell: {_ends(ranked, unit)}"
    first, *others = ranked
    if is_clear is None:
        is_clear = _differ(first, others[0])
    alike = [place for place in others if not _differ(first, place)]
    # What differs by its intervals may be no clear difference seed by seed, and the reverse.
    alike = [] if is_clear else alike or others
    if len(alike) == len(others):
        return f"no clear difference: {_ends(ranked, unit)}"
    behind = next(place for place in others if place not in alike)
    against = f"against {behind.words} with {behind.name}"
    if not alike:
        return f"{first.name} {verbs[0]}: {first.words} {unit}, {against}"
    named = [first, *alike][:MAX_FIRST]
    names = [place.name for place in named]
    if len(alike) >= MAX_FIRST:
        names.append(counted(len(alike) + 1 - MAX_FIRST, "other"))
    words = listed([place.words for place in named])
    return f"{listed(names)} {verbs[1]}, too close to tell apart: {words} {unit}, {against}"


def trend(measure: str, line: Sequence[Standing], *, is_clear: bool | None = None) -> str:
    """Return whether a measure rises or falls along a factor, or has its best or worst between.

    It is clear if the ends differ, and ``None`` if only their intervals tell.
    """
    first, last = line[0], line[-1]
    if not all(place.result.is_known for place in line):
        peak = max(line, key=lambda place: place.result.estimate)
        told = [f"{each.words} at {each.name}" for each in dict.fromkeys((first, peak, last))]
        return f"too few episodes to tell: {measure} is {listed(told)}"
    both = f"{first.words} at {first.name} and {last.words} at {last.name}"
    peak, dip = (pick(line, key=lambda place: place.result.estimate) for pick in (max, min))
    for place, word in ((peak, "highest"), (dip, "lowest")):
        if place not in (first, last) and _differ(place, first) and _differ(place, last):
            return f"{measure} is {word} at {place.name}: {place.words}, against {both}"
    if _differ(first, last) if is_clear is None else is_clear:
        verb = "rises" if last.result.estimate > first.result.estimate else "falls"
        return f"{measure} {verb} from {first.words} at {first.name} to {last.words} at {last.name}"
    return f"no clear change: {measure} is {both}"


def _differ(one: Standing, other: Standing) -> bool:
    """Return whether the intervals of two results have nothing in common."""
    return one.result.high < other.result.low or other.result.high < one.result.low


def _ends(ranked: Sequence[Standing], unit: str) -> str:
    """Return the first and the last result."""
    first, last = ranked[0], ranked[-1]
    start, joint = ("", "and") if len(ranked) == 2 else ("from ", "to")
    return f"{start}{first.words} {unit} with {first.name} {joint} {last.words} with {last.name}"
