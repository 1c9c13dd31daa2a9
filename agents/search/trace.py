"""The course of a search over cells: its marks after each expansion, and a track of them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.search.algorithms import Solution
from warehouse_core.render.palette import COLORS, HIT, WARNING, Color, blend
from warehouse_core.viz.tracks.track import Frame, Marks, Track, middle
from warehouse_core.wording import printable
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import EMPTY, PICKUP, WALL, Cell

# Most are in the palette of a replay's files, which have no other colours.
SHADES: tuple[Color, ...] = tuple(
    blend(COLORS[PICKUP], COLORS[EMPTY], share) for share in (0.75, 0.5, 0.25, 0.0)
)
"""Colours of expanded cells: the first quarter of them, the second, and so on."""

FRONTIER: Color = HIT

MAX_PANELS = 6
"""Most searches side by side."""

WAITS, UNTOUCHED = -1, 0
"""Marks of a cell on the frontier and of a cell not reached yet."""

MarkGrid = NDArray[np.int32]
"""``[H, W]``: ``WAITS``, ``UNTOUCHED``, or the number of the cell's expansion, from 1."""

MARK_COLORS = {
    "frontier": FRONTIER,
    "expanded now": WARNING,
    "expanded first": SHADES[0],
    "second quarter": SHADES[1],
    "third quarter": SHADES[2],
    "expanded last": SHADES[3],
}
"""Colours of the marks, by the names of the marks."""

WAITING, NOW, FIRST_SHADE = range(3)
"""Values of marks: indices into ``MARK_COLORS``."""

MAX_TRACK_FRAMES = 300
"""Most frames of a track; marks are exact between them."""


class SearchCourse:
    """The marks of a search from one end to the other, after any number of its expansions.

    Raises:
        ValueError: the solution has no events.
    """

    def __init__(
        self, name: str, layout: Layout, ends: tuple[Cell, Cell], solution: Solution[Cell, str]
    ) -> None:
        if len(solution.events) != solution.expanded:
            raise ValueError(
                f"{name} has {len(solution.events)} events of {solution.expanded} expansions; "
                "a search is recorded by with_events=True"
            )
        self.name, self.layout, self.ends, self.solution = name, layout, ends, solution
        cells, marks, self._counts = [ends[0]], [WAITS], [1]
        for number, (expanded, reached) in enumerate(solution.events, start=1):
            cells += [expanded, *reached]  # type: ignore[list-item] # a state is a cell here
            marks += [number, *[WAITS] * len(reached)]
            self._counts.append(len(cells))
        self._cells = layout.numbers(cells)
        self._marks = np.array(marks, dtype=np.int32)

    def __len__(self) -> int:
        return self.solution.expanded

    def is_over(self, count: int) -> bool:
        """Return whether the search has ended after ``count`` expansions."""
        return count >= len(self)

    def marks_after(self, count: int) -> MarkGrid:
        """Return the marks after ``count`` expansions, or after all if there are fewer."""
        end = self._counts[min(count, len(self))]
        marks = np.full((self.layout.height, self.layout.width), UNTOUCHED, dtype=np.int32)
        # A cell that is reached or expanded again has several marks, and NumPy keeps the last.
        marks.flat[self._cells[:end]] = self._marks[:end]
        if self.is_over(count) and self.solution.found:
            # The goal was the last cell taken from the frontier.
            marks[self.ends[1]] = max(len(self), 1)
        return marks

    def shades(self, numbers: MarkGrid) -> MarkGrid:
        """Return for numbers of expansions the index of its shade in ``SHADES``."""
        return (numbers - 1) * len(SHADES) // max(len(self), 1)

    def words_after(self, count: int) -> list[str]:
        """Return in words what ``marks_after`` shows, and the cost at the end."""
        waiting = int((self.marks_after(count) == WAITS).sum())
        words = [f"expanded {min(count, len(self))}", f"frontier {waiting}"]
        if self.is_over(count):
            words.append(f"cost {self.solution.cost:g}" if self.solution.found else "no path")
        return words

    def expanded_by(self, count: int) -> Cell | None:
        """Return the cell of expansion ``count``; ``None`` before the first and at the end."""
        if count == 0 or self.is_over(count):
            return None
        return self.layout.cell(self._cells[self._counts[count - 1]])


def track_of_course(course: SearchCourse) -> Track:
    """Return the track of a search; its clock is the number of expansions."""
    times, cells, values = zip(*_marks(course), strict=True)
    marks = Marks(times, cells, values, [*MARK_COLORS.values()], [*MARK_COLORS], course.ends)
    rows = tuple(re.sub(f"[^{WALL}]", EMPTY, row) for row in course.layout.rows)
    counts = np.linspace(0, len(course), min(len(course) + 1, MAX_TRACK_FRAMES)).round().tolist()
    frames = [
        Frame(rows, (), float(step), ", ".join(course.words_after(int(count))), clock=count)
        for step, count in enumerate(counts)
    ]
    frames[-1].route = tuple(map(middle, course.solution.states))
    return Track(frames, {}, title=printable(course.name), marks=marks)


def _marks(course: SearchCourse) -> Iterator[tuple[int, Cell, int]]:
    """Yield the marks of cells as ``SearchCourse.marks_after`` has them."""
    numbers = np.arange(1, max(len(course), 1) + 1, dtype=np.int32)
    events: Any = course.solution.events  # a state is a cell here
    shades = [FIRST_SHADE + shade for shade in course.shades(numbers).tolist()]
    before, goal = course.ends
    yield 0, before, WAITING
    for number, (expanded, reached) in enumerate(events, start=1):
        if number > 1:
            yield number, before, shades[number - 2]
        yield number, expanded, shades[-1] if number == len(course) else NOW
        yield from ((number, cell, WAITING) for cell in reached)
        before = expanded
    if course.solution.found:
        yield len(course), goal, shades[-1]
