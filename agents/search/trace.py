"""The course of a search over cells: its marks after each expansion, and its track for a replay."""

from __future__ import annotations

import re
from bisect import bisect_right
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

# Most of these colours are in the palette of files, which limits the colours of a saved replay.
SHADES: tuple[Color, ...] = tuple(
    blend(COLORS[PICKUP], COLORS[EMPTY], share) for share in (0.75, 0.5, 0.25, 0.0)
)
"""Colours of expanded cells, one for each quarter of the expansions."""

FRONTIER: Color = HIT

MAX_PANELS = 6
"""Most searches that are shown side by side."""

MARK_COLORS = {
    "frontier": FRONTIER,
    "expanded now": WARNING,
    "expanded first": SHADES[0],
    "second quarter": SHADES[1],
    "third quarter": SHADES[2],
    "expanded last": SHADES[3],
}
"""Colours of the marks by name."""

WAITING, NOW, FIRST_SHADE, LAST_SHADE = 0, 1, 2, len(MARK_COLORS) - 1
"""Values of marks, which are indices into ``MARK_COLORS``."""

MAX_TRACK_FRAMES = 120
"""Most frames of a track. On a page, marks also change at the right time between frames."""

UNTOUCHED = -1
"""Value of a cell that has not been reached yet."""

MarkGrid = NDArray[np.int8]
"""``[H, W]`` value of the mark of each cell, or ``UNTOUCHED``."""


class SearchCourse:
    """The marks of a search for a route between two cells, after any number of expansions.

    Attributes:
        marks: all marks in order of their times, which are numbers of expansions.

    Raises:
        ValueError: the solution has no events.
    """

    def __init__(
        self, name: str, layout: Layout, ends: tuple[Cell, Cell], solution: Solution[Cell, str]
    ) -> None:
        if len(solution.events) != solution.expanded:
            raise ValueError(
                f"{name} has {len(solution.events)} events for {solution.expanded} expansions; "
                "run the search with with_events=True"
            )
        self.name, self.layout, self.ends, self.solution = name, layout, ends, solution
        times, cells, values = zip(*self._marks(), strict=True)
        self.marks = Marks(times, cells, values, [*MARK_COLORS.values()], [*MARK_COLORS], ends)
        self._numbers, self._values = layout.numbers(cells), np.array(values, np.int8)

    def __len__(self) -> int:
        return self.solution.expanded

    def is_over(self, count: int) -> bool:
        """Return whether the search has ended after ``count`` expansions."""
        return count >= len(self)

    def marks_after(self, count: int) -> MarkGrid:
        """Return the marks after ``count`` expansions, or at the end if there are fewer."""
        end = bisect_right(self.marks.times, count)
        grid = np.full((self.layout.height, self.layout.width), UNTOUCHED, np.int8)
        # A cell that is reached or expanded again has several marks; the last assignment counts.
        grid.flat[self._numbers[:end]] = self._values[:end]
        return grid

    def words_after(self, count: int) -> list[str]:
        """Return in words the numbers of expanded and waiting cells, and at the end the cost."""
        waiting = int((self.marks_after(count) == WAITING).sum())
        words = [f"{min(count, len(self))} expanded", f"{waiting} in the frontier"]
        if self.is_over(count):
            words.append(f"cost {self.solution.cost:g}" if self.solution.found else "no path")
        return words

    def _marks(self) -> Iterator[tuple[int, Cell, int]]:
        """Yield the time, cell and value of each mark."""
        events: Any = self.solution.events  # a state is a cell here
        last = max(len(self), 1)
        before, goal = self.ends
        yield 0, before, WAITING
        for number, (expanded, reached) in enumerate(events, start=1):
            if number > 1:
                yield number, before, FIRST_SHADE + (number - 2) * len(SHADES) // last
            yield number, expanded, LAST_SHADE if number == len(self) else NOW
            yield from ((number, cell, WAITING) for cell in reached)
            before = expanded
        if self.solution.found:  # the goal is the last cell taken from the frontier
            yield len(self), goal, LAST_SHADE


def track_of_course(course: SearchCourse) -> Track:
    """Return the track of a search. Its clock counts expansions."""
    rows = tuple(re.sub(f"[^{WALL}]", EMPTY, row) for row in course.layout.rows)
    counts = np.linspace(0, len(course), min(len(course) + 1, MAX_TRACK_FRAMES)).round().tolist()
    frames = [
        Frame(rows, (), float(step), ", ".join(course.words_after(int(count))), clock=count)
        for step, count in enumerate(counts)
    ]
    frames[-1].route = tuple(map(middle, course.solution.states))
    return Track(frames, {}, title=printable(course.name), marks=course.marks)
