"""The design of an experiment: how its cases differ, and which of them can be compared.

A *factor* is a parameter that has several values. The cases of a *series* differ in one factor and
in nothing else. A parameter that does not apply to a case, such as the memory of an agent without
memory, does not count as a difference.
"""

from __future__ import annotations

import hashlib
import operator
import re
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import compress
from typing import NamedTuple

from agents.lab.experiments.case import FINGERPRINT, TILES, Case
from agents.lab.parameters import PARAMETERS, PLANNER, Value, find, shown

Labels = dict[str, Value | None]
"""Displayed values of a case by parameter; ``None`` where a parameter does not apply."""

FOLDERS = re.compile(r"(\b[A-Za-z]:)?[^:]*[/\\]")
"""Pattern for the folders in the path of a file, which may follow a word and a colon."""

Combination = tuple[Value | None, ...]
"""Values of some factors, in the order of the factors."""

MARK_LENGTH = 6
"""Number of digits of a digest that distinguish two files with the same name."""


@dataclass(frozen=True, slots=True)
class Factor:
    """A parameter that differs, with its values in the order in which they are displayed."""

    name: str
    values: tuple[Value, ...]

    @property
    def is_numeric(self) -> bool:
        """Whether all values are numbers."""
        return all(type(value) in (int, float) for value in self.values)

    @property
    def is_ordered(self) -> bool:
        """Whether the values have an order."""
        return self.is_numeric or self.name == "size"


class CaseSeries(NamedTuple):
    """Cases that differ in one factor alone.

    Attributes:
        others: Values of the other factors.
        cases: Numbers of the cases by their values of the factor.
    """

    others: Labels
    cases: dict[Value, int]


@dataclass(frozen=True)
class Design:
    """The cases of an experiment, and the parameters that differ between them.

    Attributes:
        labels: Displayed values of each case, by the number of the case.
        factors: Parameters that differ, in the order of ``PARAMETERS``.
        fixed: Values of the other parameters.
    """

    labels: dict[int, Labels]
    factors: tuple[Factor, ...]
    fixed: Labels

    def series(self, factor: Factor) -> list[CaseSeries]:
        """Return every series of a factor, beginning with the one nearest to the defaults."""
        others = [each.name for each in self.factors if each != factor]
        exact: dict[Combination, list[int]] = {}
        for case_id, labels in self.labels.items():
            exact.setdefault(tuple(labels[name] for name in others), []).append(case_id)
        series = []
        for combination, comparable in _comparable(exact).items():
            cases = {
                value: case_id
                for each in comparable
                for case_id in exact[each]
                if (value := self.labels[case_id][factor.name]) is not None
            }
            if len(cases) > 1:
                labels = dict(zip(others, combination, strict=True))
                series.append(
                    CaseSeries(labels, {v: cases[v] for v in factor.values if v in cases})
                )
        return sorted(series, key=lambda each: -_defaults_in(each.others))

    def name_of(self, case_id: int) -> str:
        """Return the values of a case that differ between cases, in words."""
        return described({each.name: self.labels[case_id][each.name] for each in self.factors})


def make_design(cases: Mapping[int, Case]) -> Design:
    """Return the design of an experiment, given its cases by number."""
    labels = _labels(cases)
    known = {name for each in labels.values() for name in each}
    names = [*PARAMETERS, *sorted(known - PARAMETERS.keys())]
    factors, fixed = [], Labels()
    for name in names:
        values = dict.fromkeys(each.get(name) for each in labels.values())
        for each in labels.values():
            each.setdefault(name, None)
        shown = [value for value in values if value is not None]
        if len(shown) > 1:
            factors.append(Factor(name, tuple(sorted(shown, key=_rank))))
        elif shown:
            fixed[name] = shown[0]
    return Design(labels, tuple(factors), fixed)


def described(labels: Mapping[str, Value | None]) -> str:
    """Return values as a list in words, such as ``battery 20, escape on``."""
    given = [f"{name} {shown(value)}" for name, value in labels.items() if value is not None]
    return ", ".join(given)


def _labels(cases: Mapping[int, Case]) -> dict[int, Labels]:
    """Return the displayed values of each case, with files named without their folders.

    Files that have the same name and different contents are marked with a digest.
    """
    contents = {"layout": TILES, "agent": FINGERPRINT, PLANNER: FINGERPRINT}
    found = {
        case_id: {k: v for k, v in case.items() if k not in (TILES, FINGERPRINT)}
        for case_id, case in cases.items()
    }
    for name, content in contents.items():
        having = {case_id: case for case_id, case in cases.items() if name in case}
        short = {each: FOLDERS.sub("", case[name]) or case[name] for each, case in having.items()}
        files = {(short[each], str(case.get(content))) for each, case in having.items()}
        versions = Counter(file for file, _ in files)
        for case_id, case in having.items():
            found[case_id][name] = short[case_id]
            if versions[short[case_id]] > 1:
                digest = hashlib.sha256(repr(case.get(content)).encode()).hexdigest()
                found[case_id][name] += f" ({digest[:MARK_LENGTH]})"
    _name_stations_with_layouts(found.values())
    return found


def _name_stations_with_layouts(labels: Collection[Labels]) -> None:
    """Merge stations into the layout if they differ between layouts, but not within any layout.

    This is common, because by default the stations of a layout file are kept, and other stations
    are random. Layout and stations are then one factor instead of two.
    """
    pairs = {(each["layout"], each.get("stations")) for each in labels}
    layouts, stations = ({each[place] for each in pairs} for place in (0, 1))
    if len(pairs) == len(layouts) and len(stations) > 1:
        for each in labels:
            each["layout"] = f"{each['layout']} (stations {each.pop('stations')})"


def _rank(value: Value) -> tuple[object, ...]:
    """Return a sort key for a value: on before off, sizes by area, names in their given order."""
    if isinstance(value, bool):
        return (0, not value)
    if isinstance(value, str):
        height, x, width = value.partition("x")
        is_size = x and height.isdecimal() and width.isdecimal()
        return (1, int(height) * int(width)) if is_size else (2, 0)
    return (1, value)


def _comparable(
    combinations: Collection[Combination],
) -> dict[Combination, list[Combination]]:
    """Return the combinations that are comparable with each combination, and last itself.

    Two combinations are comparable if they are equal wherever both have a value. A combination
    that equals another one with some values left out is not among the keys.
    """
    groups: dict[tuple[bool, ...], list[Combination]] = {}
    for each in combinations:
        groups.setdefault(tuple(value is not None for value in each), []).append(each)
    found: dict[Combination, list[Combination]] = {each: [] for each in combinations}
    for own, members in groups.items():
        for mask, others in groups.items():
            both = tuple(map(operator.and_, own, mask))
            index: dict[Combination, list[Combination]] = {}
            for other in others:
                index.setdefault(tuple(compress(other, both)), []).append(other)
            for each in members:
                equal = index.get(tuple(compress(each, both)), [])
                if equal and own == both != mask:
                    found.pop(each, None)
                elif each in found:
                    found[each] += [other for other in equal if other != each]
    # The combination itself is last, so that no case with fewer values replaces its case.
    return {each: [*others, each] for each, others in found.items()}


def _defaults_in(labels: Labels) -> int:
    return sum(value is not None and find(name).default == value for name, value in labels.items())
