"""Tracks of searches, against the marks of the search after each expansion."""

import numpy as np
import pytest

from agents.search.algorithms import weighted_astar_search
from agents.search.heuristics import manhattan
from agents.search.problems import RouteProblem
from agents.search.trace import (
    FIRST_SHADE,
    MARK_COLORS,
    NOW,
    UNTOUCHED,
    WAITING,
    WAITS,
    SearchCourse,
    track_of_course,
)
from warehouse_core import DEFAULT_LAYOUT, Layout, random_layout
from warehouse_core.world.tiles import Cell

INF = float("inf")
SPLIT = Layout(["#######", "#..#..#", "#..#..#", "#######"])


def course(layout: Layout, start: Cell, goal: Cell, weight: float) -> SearchCourse:
    problem = RouteProblem(layout, start, goal)
    found = weighted_astar_search(problem, manhattan(problem), weight, with_events=True)
    return SearchCourse(f"W = {weight:g}", layout, (start, goal), found)


SEARCHES = [
    *((DEFAULT_LAYOUT, (2, 10), (1, 3), weight) for weight in (0, 1, 5, INF)),
    (SPLIT, (1, 1), (2, 5), 1),
    (SPLIT, (1, 1), (1, 1), 1),
    (random_layout(30, 40, 0.2, seed=3), (1, 1), (28, 38), 0),
]


@pytest.mark.parametrize(("layout", "start", "goal", "weight"), SEARCHES)
def test_the_marks_are_those_of_the_search(
    layout: Layout, start: Cell, goal: Cell, weight: float
) -> None:
    shown = course(layout, start, goal, weight)
    marks = track_of_course(shown).marks
    assert marks is not None
    assert marks.ends == (start, goal)
    assert list(marks.times) == sorted(marks.times)
    codes, next_mark = np.full((layout.height, layout.width), -1), 0
    for count in range(len(shown) + 1):
        while next_mark < len(marks.times) and marks.times[next_mark] <= count:
            codes[marks.cells[next_mark]] = marks.values[next_mark]
            next_mark += 1
        expected = shown.marks_after(count)
        assert ((codes == WAITING) == (expected == WAITS)).all(), count
        assert ((codes == -1) == (expected == UNTOUCHED)).all(), count
        now = np.argwhere(codes == NOW).tolist()
        assert now == ([list(at)] if (at := shown.expanded_by(count)) else []), count
    quarters = (shown.marks_after(count) - 1) * 4 // max(len(shown), 1)
    is_expanded = shown.marks_after(count) > 0
    assert (codes[is_expanded] == FIRST_SHADE + quarters[is_expanded]).all()
    assert next_mark == len(marks.times)
    assert max(marks.values) < len(MARK_COLORS) == len(marks.names)


def test_frames_count_what_is_expanded_and_end_with_the_path() -> None:
    layout, start, goal, weight = SEARCHES[1]
    shown = course(layout, start, goal, weight)
    track = track_of_course(shown)
    assert [frame.clock for frame in track.frames] == list(range(len(shown) + 1))
    assert track.frames[0].caption == "expanded 0, frontier 1"
    last = track.frames[-1]
    assert last.caption.startswith(f"expanded {len(shown)}, frontier ")
    assert last.caption.endswith(", cost 12")
    assert last.route[0] == (start[1] + 0.5, start[0] + 0.5)
    assert last.route[-1] == (goal[1] + 0.5, goal[0] + 0.5)
    assert len(last.route) == 13
    assert not any(frame.route for frame in track.frames[:-1])


def test_a_long_search_has_few_frames() -> None:
    layout, start, goal, weight = SEARCHES[-1]
    shown = course(layout, start, goal, weight)
    track = track_of_course(shown)
    assert len(shown) > 500
    assert len(track) == 300
    assert track.frames[-1].clock == len(shown)
    assert [track.step_at(index) for index in range(len(track))] == list(range(len(track)))


def test_without_a_path_there_is_none_to_draw() -> None:
    track = track_of_course(course(*SEARCHES[4]))
    assert track.frames[-1].caption.endswith("no path")
    assert not any(frame.route for frame in track.frames)
