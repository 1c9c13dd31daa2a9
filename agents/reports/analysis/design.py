"""What differs between the cases of an experiment, and which cases can be compared.

A *factor* is a setting that has several values. A *row of cases* (``Series``) differs in one factor
and in nothing else; a setting that means nothing for a case, such as the memory of an agent that
has none, differs from no value.
"""

from __future__ import annotations

import hashlib
import operator
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import compress
from typing import NamedTuple

from agents.experiments.case import FINGERPRINT, TILES, Case
from agents.experiments.parameters import SETTINGS, Value, find, shown

Labels = dict[str, Value | None]
"""The settings of a case as they are shown; ``None`` where one means nothing."""

FOLDERS = re.compile(r"(\b[A-Za-z]:)?[^:]*[/\\]")
"""Of a file, which may stand after a word and a colon."""

Combination = tuple[Value | None, ...]
"""Values of some factors, in their order."""

Mask = tuple[bool, ...]
"""Which of these factors mean something."""

MARK = 6
"""Letters of a fingerprint that tell two files of one name apart."""


@dataclass(frozen=True, slots=True)
class Factor:
    """A setting that differs.

    Attributes:
        name: of the setting.
        values: all but ``None``, in the order in which they are shown.
    """

    name: str
    values: tuple[Value, ...]

    @property
    def is_numeric(self) -> bool:
        """Whether the values are points on a line."""
        return all(type(value) in (int, float) for value in self.values)

    @property
    def is_ordered(self) -> bool:
        """Whether the values grow."""
        return self.is_numeric or self.name == "size"


class Series(NamedTuple):
    """Cases that differ in one factor alone.

    Attributes:
        others: what the other factors are in all of them.
        cases: the number of the case for each value of the factor, in its order.
    """

    others: Labels
    cases: dict[Value, int]


@dataclass(frozen=True)
class Design:
    """The cases of an experiment by what differs between them.

    Attributes:
        labels: of each case by its number.
        factors: what differs, in the order of ``SETTINGS``.
        fixed: the settings that are the same in all cases.
    """

    labels: dict[int, Labels]
    factors: tuple[Factor, ...]
    fixed: Labels

    def series(self, factor: Factor) -> list[Series]:
        """Return every row of cases along a factor, the one nearest to the defaults first."""
        others = [each.name for each in self.factors if each != factor]
        exact: dict[Combination, list[int]] = {}
        for case_id in self.labels:
            exact.setdefault(self._at(case_id, others), []).append(case_id)
        agreeing = _agreeing(exact)
        found: dict[Combination, dict[Value, int]] = {}
        for combination in _widest(exact):
            cases = {
                value: case_id
                for each in agreeing(combination)
                for case_id in exact[each]
                if (value := self.labels[case_id][factor.name]) is not None
            }
            if len(cases) > 1:
                found[combination] = {v: cases[v] for v in factor.values if v in cases}
        rows = [
            Series(dict(zip(others, each, strict=True)), cases) for each, cases in found.items()
        ]
        return sorted(rows, key=lambda row: -_defaults_in(row.others))

    def _at(self, case_id: int, names: list[str]) -> Combination:
        return tuple(self.labels[case_id][name] for name in names)


def make_design(cases: Mapping[int, Case]) -> Design:
    """Return the design of some cases, by their numbers."""
    labels = _labels(cases)
    names = [*SETTINGS, *sorted({name for each in labels.values() for name in each} - {*SETTINGS})]
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
    """Return settings as a list in words, ``battery 20, escape on``."""
    given = [f"{name} {shown(value)}" for name, value in labels.items() if value is not None]
    return ", ".join(given)


def _labels(cases: Mapping[int, Case]) -> dict[int, Labels]:
    """Return the settings of each case, with files of one name and other contents told apart."""
    contents = {"layout": TILES, "agent": FINGERPRINT}
    versions = {
        setting: Counter(name for name, _ in {
            (case[setting], str(case.get(content))) for case in cases.values()
        })
        for setting, content in contents.items()
    }  # fmt: skip
    short = {
        setting: _without_folders({case[setting] for case in cases.values()})
        for setting in contents
    }
    found = {}
    for case_id, case in cases.items():
        labels: Labels = {k: v for k, v in case.items() if k not in (TILES, FINGERPRINT)}
        for setting, content in contents.items():
            labels[setting] = short[setting][case[setting]]
            if versions[setting][case[setting]] > 1:
                labels[setting] = f"{labels[setting]} ({_mark(case[content])})"
        found[case_id] = labels
    return found


def _without_folders(names: Collection[str]) -> dict[str, str]:
    """Return names of files without their folders, where that makes no two of them alike."""
    short = {name: FOLDERS.sub("", name) or name for name in names}
    counts = Counter(short.values())
    return {name: each if counts[each] == 1 else name for name, each in short.items()}


def _mark(content: object) -> str:
    return hashlib.sha256(repr(content).encode()).hexdigest()[:MARK]


def _rank(value: Value) -> tuple[object, ...]:
    """Return what values are sorted by: on before off, sizes by their cells, names as they are."""
    if isinstance(value, bool):
        return (0, not value)
    if isinstance(value, str):
        height, x, width = value.partition("x")
        is_size = x and height.isdecimal() and width.isdecimal()
        return (1, int(height) * int(width)) if is_size else (2, 0)
    return (1, value)


def _mask(combination: Combination) -> Mask:
    """Say of each factor whether it means something."""
    return tuple(value is not None for value in combination)


def _only(combination: Combination, mask: Mask) -> Combination:
    """Return the values where a mask says so."""
    return tuple(compress(combination, mask))


def _by_mask(combinations: Iterable[Combination]) -> dict[Mask, list[Combination]]:
    found: dict[Mask, list[Combination]] = {}
    for each in combinations:
        found.setdefault(_mask(each), []).append(each)
    return found


def _agreeing(
    combinations: Collection[Combination],
) -> Callable[[Combination], list[Combination]]:
    """Return what finds the combinations that differ in nothing that means something for both."""
    groups = _by_mask(combinations)

    @cache
    def index(mask: Mask, own: Mask) -> dict[Combination, list[Combination]]:
        both = tuple(map(operator.and_, mask, own))
        found: dict[Combination, list[Combination]] = {}
        for each in groups[mask]:
            found.setdefault(_only(each, both), []).append(each)
        return found

    def find_agreeing(combination: Combination) -> list[Combination]:
        own = _mask(combination)
        agreeing = [
            each
            for mask in groups
            for each in index(mask, own).get(
                _only(combination, tuple(map(operator.and_, mask, own))), []
            )
        ]
        # The case itself comes last, so that nothing that is less sure takes its place.
        return [each for each in agreeing if each != combination] + [combination]

    return find_agreeing


def _widest(combinations: Collection[Combination]) -> list[Combination]:
    """Return the combinations that are not another one with something left out."""
    groups = _by_mask(combinations)
    covered: set[Combination] = set()
    for mask, own in groups.items():
        for wider, others in groups.items():
            if wider != mask and all(map(operator.le, mask, wider)):
                known = {_only(each, mask) for each in others}
                covered.update(each for each in own if _only(each, mask) in known)
    return [each for each in combinations if each not in covered]


def _defaults_in(labels: Labels) -> int:
    return sum(value is not None and find(name).default == value for name, value in labels.items())
