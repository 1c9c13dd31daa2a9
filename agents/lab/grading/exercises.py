"""The exercises of the handbook: rubrics by name, each with its starting file beside it."""

from __future__ import annotations

from pathlib import Path

from agents.errors import GradeError
from agents.lab.grading.rubric import MINI_LAB

FOLDER = Path(__file__).parents[2] / "handbook" / "exercises"
SOLUTIONS = FOLDER / "solutions"
"""Folder of the solutions, which the repository has, and an installed package has not."""


def exercise_names() -> list[str]:
    """Return the names of all exercises, such as ``"exercise-07"``."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def own_rubrics() -> dict[str, Path]:
    """Return the files of the rubrics of this program by name: mini-lab first, then exercises."""
    return {MINI_LAB.stem: MINI_LAB} | {name: FOLDER / f"{name}.toml" for name in exercise_names()}


def find_rubric(path: Path) -> Path:
    """Return the file of a rubric: the path itself, or the file of an exercise named by it.

    Raises:
        GradeError: there is no such file, and no such exercise.
    """
    names = exercise_names()
    if str(path) in names:
        return FOLDER / f"{path}.toml"
    if not path.suffix and not path.exists():
        first, last = names[0], names[-1]
        raise GradeError(f"there is no rubric {path}; allowed: a file, or {first} to {last}")
    return path


def rubric_name(path: Path) -> str:
    """Return what a user types for a rubric: the name of an exercise, or the path."""
    return path.stem if path.parent == FOLDER else str(path)
