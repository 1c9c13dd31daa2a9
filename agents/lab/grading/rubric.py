"""Rubrics: TOML files with limits, cases and criteria, as explained in ``mini_lab.toml``.

The mini-lab and each exercise of the handbook have a rubric, with a starting file next to it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from agents.errors import GradeError
from agents.lab.grading.cases import Call, CallCase, Case, GradedCase
from agents.lab.grading.criteria import MEASURES, VISIBILITIES, Criterion
from agents.lab.grading.sandbox import ENDING_SECONDS, IMPORT_SECONDS, AgentLimits
from agents.lab.parameters import PARAMETERS, CheckValue, Number, Whole, flag, one_of, text
from agents.lab.place import RANDOM, Stations, check_stations
from agents.lab.toml_text import MAX_BYTES, parse_toml
from warehouse_core import LayoutError
from warehouse_core.files.reading import read_file
from warehouse_core.wording import brief

__all__ = ["Rubric", "load_rubric"]

MINI_LAB = Path(__file__).parent / "mini_lab.toml"

EXERCISES = Path(__file__).parents[2] / "handbook" / "exercises"
SOLUTIONS = EXERCISES / "solutions"
"""Folder of the solutions, which are in the repository but not in an installed package."""

MAX_EPISODES, MAX_COUNT, MAX_SEED, MAX_DAYS = 10_000, 1_000_000, 2**31 - 1, 3_650

TAKEN = ("submission", "points", "of", "late", "failure", "outcomes", "code", "rubric")
"""Columns of a table of grades whose names criteria cannot have."""


class LateRule(NamedTuple):
    """Points deducted for each day, and the number of days after which all points are lost.

    Gradescope's times become days after ``grace_minutes``.
    """

    points: float = 0.0
    days: int = MAX_DAYS
    grace_minutes: float = 5.0

    def deducted(self, days: int, points: float) -> float:
        """Return how many of the points are deducted for a delay of some days."""
        return points if days > self.days else min(days * self.points, points)


@dataclass(frozen=True, slots=True)
class Rubric:
    """A rubric: limits, cases and criteria.

    Attributes:
        title: title.
        limits: limits on the agent.
        cases: cases by name.
        criteria: criteria in the order of the file.
        digest: digest of the file and of the layouts that it names.
        file: file of the rubric.
        late: rule for late submissions.

    Example:
        >>> from agents.lab.grading.rubric import MINI_LAB, load_rubric
        >>> rubric = load_rubric(MINI_LAB)
        >>> rubric.title, rubric.points
        ('Mini-lab: a robot that delivers', 100.0)
    """

    title: str
    limits: AgentLimits
    cases: Mapping[str, Case]
    criteria: tuple[Criterion, ...]
    digest: str
    file: Path
    late: LateRule

    @property
    def points(self) -> float:
        """Sum of all points."""
        return sum(criterion.points for criterion in self.criteria)

    @property
    def first_case(self) -> GradedCase | None:
        """First case with episodes that criteria judge; ``None`` if criteria only judge calls."""
        return next((case for case in self.used_cases if isinstance(case, GradedCase)), None)

    @property
    def shown_name(self) -> str:
        """Name that a user types: the name of an exercise, or the path of the file."""
        return self.file.stem if self.file.parent == EXERCISES else str(self.file)

    @property
    def starter(self) -> Path:
        """Starting file for students: a Python file next to the rubric, with the same name."""
        return self.file.with_suffix(".py")

    @property
    def files(self) -> list[Path]:
        """Files of the rubric and its layouts, which agents must not read."""
        return [self.file, *(file for case in self.cases.values() for file in case.files)]

    @property
    def used_cases(self) -> list[Case]:
        """Cases that criteria judge, in the order of the file."""
        used = {name for criterion in self.criteria for name in criterion.cases}
        return [case for name, case in self.cases.items() if name in used]

    @property
    def episodes(self) -> int:
        """Number of episodes and calls with which a submission is graded."""
        return sum(case.episodes for case in self.used_cases)

    @property
    def most_seconds(self) -> float:
        """Time that grading a submission can take, if each process takes as long as it may."""
        limits = self.limits
        process = limits.start_seconds + limits.episode_seconds + 2 * ENDING_SECONDS
        return IMPORT_SECONDS + process * self.episodes


def list_of(
    allowed: str, is_allowed: Callable[[Any], bool], least: int = 0, most: int = MAX_COUNT
) -> CheckValue:
    """Return a check of the length and the values of a list; ``allowed`` describes them."""

    def check(value: Any) -> tuple[Any, ...]:
        is_list = isinstance(value, list) and least <= len(value) <= most
        if not is_list or not all(map(is_allowed, value)):
            raise ValueError(allowed)
        return tuple(value)

    return check


def pair(minimum: int, example: str) -> CheckValue:
    """Return a check that a value is a list of two whole numbers."""
    allowed = f"two whole numbers of at least {minimum}, as in {example}"
    return list_of(allowed, lambda each: type(each) is int and each >= minimum, 2, 2)


def calls(value: Any) -> tuple[Call, ...]:
    """Check that a value is a list of calls with answers, whose values JSON can represent."""
    try:
        found = [Call(**each) for each in value]
        json.dumps(found)
        if not found or not all(isinstance(each.arguments, list) for each in found):
            raise ValueError
    except (TypeError, ValueError):
        raise ValueError(
            "a list of calls, as in [{ arguments = [1, [2, 3]], answer = 4 }]"
        ) from None
    return tuple(found)


NAMES = list_of(
    'a list of names of [cases], as in ["chapter"]', lambda each: isinstance(each, str), least=1
)
MODULES = list_of(
    'a list of names of modules, as in ["math", "numpy"]',
    lambda each: isinstance(each, str) and all(map(str.isidentifier, each.split("."))),
)
SECONDS = Number(0.01, 3600)

LIMITS: dict[str, CheckValue] = {
    "start_seconds": SECONDS, "answer_seconds": SECONDS, "episode_seconds": SECONDS,
    "memory_mb": Whole(64, MAX_COUNT), "give_up_after": Whole(1, MAX_EPISODES),
    "allow_imports": MODULES, "deny_imports": MODULES,
}  # fmt: skip

CASE: dict[str, CheckValue] = {
    "layout": text, "size": pair(4, "[7, 12]"), "density": PARAMETERS["density"].check,
    "first_seed": Whole(0, MAX_SEED), "episodes": Whole(1, MAX_EPISODES),
    "stations": lambda value: Stations(one_of(*Stations)(value)), "start": pair(0, "[1, 1]"),
    **{name: PARAMETERS[name].check for name in ("battery", "max_steps", "view_radius")},
    "visible": flag, "slip": Number(0, 1),
}  # fmt: skip

CALLED: dict[str, CheckValue] = {"function": text, "calls": calls, "visible": flag}
"""Checks of the keys of a case with calls of a function."""

CRITERION: dict[str, CheckValue] = {
    "name": text, "points": Number(0, MAX_COUNT), "measure": one_of(*MEASURES), "cases": NAMES,
    "full": Number(0, MAX_COUNT), "zero": Number(0, MAX_COUNT), "needs": text,
    "visibility": one_of(*VISIBILITIES),
}  # fmt: skip
NEEDED = ("name", "points", "measure", "cases", "full")

LATE: dict[str, CheckValue] = {
    "points": Number(0, MAX_COUNT), "days": Whole(0, MAX_DAYS), "grace_minutes": Number(0, 1440),
}  # fmt: skip

TOP: dict[str, CheckValue] = {"title": text}
PARTS = ("limits", "late", "cases", "criteria")


def table_of(values: Any, checks: Mapping[str, CheckValue], where: str) -> dict[str, Any]:
    """Return the values of a table after checking each of them; errors begin with ``where``."""
    if not isinstance(values, dict):
        raise GradeError(f"{where} is {brief(values)}; it must be a table")
    found = {}
    for key, value in values.items():
        if key not in checks:
            raise GradeError(f"{where}: there is no key {key!r}; allowed: {', '.join(checks)}")
        try:
            found[key] = checks[key](value)
        except ValueError as error:
            raise GradeError(f"{where}: {key} is {brief(value)}; allowed: {error}") from None
    return found


def own_rubrics() -> dict[str, Path]:
    """Return the files of the built-in rubrics by name: the mini-lab first, then the exercises."""
    return {path.stem: path for path in (MINI_LAB, *sorted(EXERCISES.glob("*.toml")))}


def find_rubric(path: Path) -> Path:
    """Return the file of the built-in rubric with this name, or else the path itself.

    Raises:
        GradeError: there is neither such a file nor such a built-in rubric.
    """
    own = own_rubrics()
    if not path.suffix and not path.exists() and str(path) not in own:
        _, first, *_, last = own
        raise GradeError(f"there is no rubric {path}; allowed: a file, or {first} to {last}")
    return own.get(str(path), path)


def load_rubric(path: Path) -> Rubric:
    """Read a rubric.

    Raises:
        GradeError: the file is not a rubric; the message has the table, the key and what is
            allowed.
        OSError: the file is longer than ``toml_text.MAX_BYTES``, or cannot be read.

    Example:
        >>> from agents.lab.grading.rubric import MINI_LAB, load_rubric
        >>> [criterion.name for criterion in load_rubric(MINI_LAB).criteria]
        ['delivers', 'escapes loops', 'delivers in unseen layouts', 'recognises ...
    """
    data = read_file(path, MAX_BYTES)
    try:
        values = parse_toml(data)
    except ValueError as error:
        raise GradeError(f"{path}: it is not TOML: {error}") from None
    return _make_rubric(path, values, hashlib.sha256(data))


def _make_rubric(path: Path, values: dict[str, Any], digest: Any) -> Rubric:
    single = {key: value for key, value in values.items() if key not in PARTS}
    top = table_of(single, TOP | dict.fromkeys(PARTS, text), str(path))
    limits = AgentLimits(**table_of(values.get("limits", {}), LIMITS, f"{path}: [limits]"))
    late = LateRule(**table_of(values.get("late", {}), LATE, f"{path}: [late]"))
    tables, rows = values.get("cases"), values.get("criteria")
    if not isinstance(tables, dict) or not tables:
        raise GradeError(f"{path}: there are no [cases.NAME]; a rubric needs episodes")
    cases = {name: _make_case(path, name, each, digest) for name, each in tables.items()}
    if not isinstance(rows, list) or not rows:
        raise GradeError(f"{path}: there are no [[criteria]]; a rubric needs at least one")
    criteria: list[Criterion] = []
    for number, row in enumerate(rows, 1):
        criteria.append(_make_criterion(f"{path}: criterion {number}", row, cases, criteria))
    title = top.get("title", path.stem)
    return Rubric(title, limits, cases, tuple(criteria), digest.hexdigest(), path, late)


def _make_case(path: Path, name: str, values: Any, digest: Any) -> Case:
    """Return a case after checking that its first episode can begin; add its layout to a digest."""
    where = f"{path}: [cases.{name}]"
    if isinstance(values, dict) and "function" in values:
        found = table_of(values, CALLED, where)
        if "calls" not in found:
            raise GradeError(f"{where}: function needs calls")
        return CallCase(name, **found)
    found = table_of(values, CASE, where)
    if "layout" in found:
        beside = path.resolve().parent / found["layout"]
        # Path.is_file raises an error for a name that is too long.
        if os.path.isfile(beside) or beside.suffix:
            found["layout"] = str(beside)
    for key in ("size", "density"):
        if key in found and found.get("layout") != RANDOM:
            raise GradeError(f'{where}: {key} needs layout = "{RANDOM}"')
    case = GradedCase(name, **found)
    try:
        layout = case.layout_of(case.first_seed)
        check_stations(layout, case.stations_of(layout), case.layout, 'stations = "drawn"')
        case.begin(case.first_seed)
    except (LayoutError, OSError) as error:
        raise GradeError(f"{where}: layout: {error}") from None
    digest.update("\n".join(layout.rows).encode())
    return case


def _make_criterion(
    where: str, values: Any, cases: Mapping[str, Case], before: list[Criterion]
) -> Criterion:
    found = table_of(values, CRITERION, where)
    for key in NEEDED:
        if key not in found:
            raise GradeError(f"{where} has no {key}; needed: {', '.join(NEEDED)}")
    name, kind, earlier = found["name"], found.pop("measure"), [each.name for each in before]
    full, zero = found["full"], found.setdefault("zero", found["full"])
    measure = MEASURES[kind]
    for case in found["cases"]:
        if case not in cases:
            raise GradeError(f"{where}: cases has {case!r}; allowed: {', '.join(cases)}")
        if cases[case].unit != measure.unit:
            raise GradeError(
                f"{where}: measure is {kind!r}, which judges {measure.unit}s, but case {case!r} "
                f"has {cases[case].unit}s"
            )
    if name in (*earlier, *TAKEN):
        raise GradeError(
            f"{where}: name is {name!r}, which an earlier criterion or a column of every table of "
            "grades has"
        )
    if found.get("needs") not in (None, *earlier):
        allowed = ", ".join(earlier) or "none, as there is none before it"
        raise GradeError(f"{where}: needs is {found['needs']!r}; allowed: {allowed}")
    if measure.is_better(zero, full):
        side = "above" if measure.more_is_better else "below"
        raise GradeError(
            f"{where}: full is {full:g} and zero is {zero:g}; for this measure full must be {side} "
            "zero"
        )
    return Criterion(kind=kind, **found)
