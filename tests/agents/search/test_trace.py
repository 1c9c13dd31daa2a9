"""Courses of searches, and their tracks."""

from typing import Any

import numpy as np
import pytest

from agents.search.algorithms import Solution, weighted_astar_search
from agents.search.heuristics import manhattan
from agents.search.problems import RouteProblem
from agents.search.trace import (
    FIRST_SHADE,
    LAST_SHADE,
    MARK_COLORS,
    MAX_TRACK_FRAMES,
    NOW,
    UNTOUCHED,
    WAITING,
    SearchCourse,
    track_of_course,
)
from warehouse_core import DEFAULT_LAYOUT, Layout
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.scene import Scene
from warehouse_core.world.generators import random_layout
from warehouse_core.world.tiles import Cell

HALL = Layout(["########", "#......#", "#.####.#", "#......#", "########"])
START, GOAL = (1, 1), (3, 6)
SPLIT = Layout(["#######", "#..#..#", "#..#..#", "#######"])
INF = float("inf")


def solve(layout: Layout, start: Cell, goal: Cell, weight: float) -> Solution[Cell, str]:
    problem = RouteProblem(layout, start, goal)
    return weighted_astar_search(problem, manhattan(problem), weight, with_events=True)


def course(
    weight: float, layout: Layout = HALL, start: Cell = START, goal: Cell = GOAL
) -> SearchCourse:
    solution = solve(layout, start, goal, weight)
    return SearchCourse(f"W = {weight:g}", layout, (start, goal), solution)


def test_marks_equal_those_of_a_search_repeated_step_by_step() -> None:
    layout = random_layout(12, 20, 0.3, seed=2)
    start, goal = layout.pickups[0], layout.dropoffs[0]
    for weight in (0.0, 1.0, 3.0, INF):
        solution = solve(layout, start, goal, weight)
        shown = SearchCourse("", layout, (start, goal), solution)
        waits, expanded = {start}, dict[Cell, int]()
        assert (shown.marks_after(0) != UNTOUCHED).sum() == 1
        assert shown.marks_after(0)[start] == WAITING
        for count, event in enumerate(solution.events[:-1], start=1):
            waits.discard(event.expanded)  # type: ignore[arg-type]
            expanded[event.expanded] = count  # type: ignore[index]
            waits.update(event.reached)  # type: ignore[arg-type]
            marks = shown.marks_after(count)
            assert set(zip(*np.nonzero(marks == WAITING), strict=True)) == waits
            shades = {cell: FIRST_SHADE + (n - 1) * 4 // len(shown) for cell, n in expanded.items()}
            shades[event.expanded] = NOW  # type: ignore[index]
            rows, columns = np.nonzero(marks > WAITING)
            found = {(r, c): marks[r, c] for r, c in zip(rows, columns, strict=True)}
            assert found == {cell: shade for cell, shade in shades.items() if cell not in waits}


def test_a_cell_that_is_reached_again_is_on_the_frontier_again() -> None:
    # Expanded, then reached by a better path, then expanded again.
    events = [((1, 1), ((1, 2),)), ((1, 2), ((1, 3),)), ((1, 3), ((1, 2),)), ((1, 2), ())]
    shown = SearchCourse("", HALL, (START, GOAL), Solution((), (), INF, 4, 4, 2, tuple(events)))  # type: ignore[arg-type]
    marks = [shown.marks_after(count)[1, 2] for count in range(5)]
    assert marks == [UNTOUCHED, WAITING, NOW, WAITING, LAST_SHADE]


def test_a_search_without_events_is_an_error() -> None:
    problem = RouteProblem(HALL, START, GOAL)
    silent = weighted_astar_search(problem, manhattan(problem), 1)
    with pytest.raises(ValueError, match=r"A\* has 0 events .* with_events=True"):
        SearchCourse("A*", HALL, (START, GOAL), silent)


SEARCHES = [
    *((weight, DEFAULT_LAYOUT, (2, 10), (1, 3)) for weight in (0, 1, 5, INF)),
    (1, SPLIT, (1, 1), (2, 5)),
    (1, SPLIT, (1, 1), (1, 1)),
    (0, random_layout(30, 40, 0.2, seed=3), (1, 1), (28, 38)),
]


@pytest.mark.parametrize("search", SEARCHES)
def test_the_marks_of_a_track_are_in_order_and_have_names(search: Any) -> None:
    marks = track_of_course(course(*search)).marks
    assert marks is not None
    assert list(marks.times) == sorted(marks.times)
    assert max(marks.values) < len(MARK_COLORS) == len(marks.names)


def test_frames_count_what_is_expanded_and_end_with_the_path() -> None:
    shown = course(*SEARCHES[1])
    start, goal = shown.ends
    track = track_of_course(shown)
    assert [frame.clock for frame in track.frames] == list(range(len(shown) + 1))
    assert track.frames[0].caption == "0 expanded, 1 in the frontier"
    last = track.frames[-1]
    assert last.caption.startswith(f"{len(shown)} expanded, ")
    assert last.caption.endswith(", cost 12")
    assert last.route[0] == (start[1] + 0.5, start[0] + 0.5)
    assert last.route[-1] == (goal[1] + 0.5, goal[0] + 0.5)
    assert len(last.route) == 13
    assert not any(frame.route for frame in track.frames[:-1])


def test_a_long_search_has_few_frames_and_one_without_a_path_says_so() -> None:
    layout = random_layout(40, 60, 0.1, seed=1)
    track = track_of_course(course(0, layout, layout.pickups[0], layout.dropoffs[0]))
    assert len(track) == MAX_TRACK_FRAMES
    captions = [
        track_of_course(course(1, SPLIT, *ends)).frames[-1].caption
        for ends in (((1, 1), (1, 5)), ((1, 1), (1, 1)))
    ]
    assert captions == [
        "4 expanded, 0 in the frontier, no path",
        "0 expanded, 0 in the frontier, cost 0",
    ]


def test_searches_beside_each_other_have_as_many_expansions() -> None:
    blind, greedy = course(0), course(INF)
    assert len(greedy) < len(blind)
    scene = Scene([track_of_course(each) for each in (blind, greedy)], make_figure)
    scene.show(len(greedy) + 1)
    said = [text.get_text() for text in scene.root.texts]
    assert f"after {len(greedy) + 1} of {len(blind)} expansions" in said
    assert blind.words_after(len(greedy) + 1)[0] == f"{len(greedy) + 1} expanded"
    for each in (blind, greedy):
        assert ", ".join(each.words_after(len(greedy) + 1)) in said
