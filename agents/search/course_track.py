"""The track of a search, which a page plays."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from agents.search.trace import FRONTIER, SHADES, SearchCourse
from warehouse_core.render.palette import WARNING
from warehouse_core.viz.tracks.track import Frame, Marks, Track, middle
from warehouse_core.wording import printable
from warehouse_core.world.tiles import EMPTY, WALL, Cell

COLORS = {
    "frontier": FRONTIER,
    "expanded now": WARNING,
    "expanded first": SHADES[0],
    "second quarter": SHADES[1],
    "third quarter": SHADES[2],
    "expanded last": SHADES[3],
}
"""Colours of the marks, by the names of the marks."""

WAITING, NOW, FIRST_SHADE = range(3)
"""Values of marks: indices into ``COLORS``."""

MAX_FRAMES = 300
"""Most frames of a track; marks are exact between them."""

Mark = tuple[int, Cell, int]


def track_of_course(course: SearchCourse) -> Track:
    """Return the track of a search; its clock is the number of expansions."""
    times, cells, values = zip(*_marks(course), strict=True)
    marks = Marks(times, cells, values, [*COLORS.values()], [*COLORS], course.ends)
    rows = tuple(re.sub(f"[^{WALL}]", EMPTY, row) for row in course.layout.rows)
    counts = np.linspace(0, len(course), min(len(course) + 1, MAX_FRAMES)).round().tolist()
    frames = [
        Frame(rows, (), float(step), ", ".join(course.words_after(int(count))), clock=count)
        for step, count in enumerate(counts)
    ]
    frames[-1].route = tuple(map(middle, course.solution.states))
    return Track(frames, {}, title=printable(course.name), marks=marks)


def _marks(course: SearchCourse) -> Iterator[Mark]:
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
