"""Courses of searches, their tracks, and the panels and frames of their pictures."""

from typing import Any

import numpy as np
import pytest
from helpers.pictures import HOSTILE_NAMES, is_color, patch, pixels, texts
from helpers.player import page_in, said_by
from matplotlib.transforms import Bbox

from agents.search.algorithms import Solution, weighted_astar_search
from agents.search.heuristics import manhattan
from agents.search.picture import MAX_FRAMES, search_replay
from agents.search.problems import RouteProblem
from agents.search.trace import (
    FIRST_SHADE,
    FRONTIER,
    LAST_SHADE,
    MARK_COLORS,
    MAX_PANELS,
    NOW,
    SHADES,
    UNTOUCHED,
    WAITING,
    SearchCourse,
    track_of_course,
)
from warehouse_core import DEFAULT_LAYOUT, Layout
from warehouse_core.render.palette import COLORS, SHELF, WARNING
from warehouse_core.viz.replay import Replay
from warehouse_core.wording import printable
from warehouse_core.world.generators import random_layout
from warehouse_core.world.tiles import EMPTY, WALL, Cell

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


def replay(
    *weights: float, layout: Layout = HALL, start: Cell = START, goal: Cell = GOAL, title: str = ""
) -> Replay:
    courses = [course(weight, layout, start, goal) for weight in weights]
    return search_replay(courses, title)


def counts(shown: Replay) -> list[str]:
    """Return the counts above each panel."""
    return [text for text in texts(shown) if text.startswith("expanded ")]


def corner_of(shown: Replay, cell: Cell, image: np.ndarray | None = None) -> np.ndarray:
    """Return the colour of a cell of the first panel in its corner, where nothing covers it."""
    row, col = cell
    image = pixels(shown) if image is None else image
    return patch(shown, image, col + 0.12, row + 0.12, col + 0.14, row + 0.14)[0, 0]


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
    assert track.frames[0].caption == "expanded 0, frontier 1"
    last = track.frames[-1]
    assert last.caption.startswith(f"expanded {len(shown)}, frontier ")
    assert last.caption.endswith(", cost 12")
    assert last.route[0] == (start[1] + 0.5, start[0] + 0.5)
    assert last.route[-1] == (goal[1] + 0.5, goal[0] + 0.5)
    assert len(last.route) == 13
    assert not any(frame.route for frame in track.frames[:-1])


def test_every_panel_counts_its_own_search_and_keeps_its_last_count() -> None:
    blind, greedy = solve(HALL, START, GOAL, 0), solve(HALL, START, GOAL, INF)
    assert greedy.expanded < blind.expanded
    shown = replay(0, INF)
    shown.go_to(greedy.expanded)
    first, second = counts(shown)
    assert first.startswith(f"expanded {greedy.expanded} ")
    assert "cost" not in first
    assert second.startswith(f"expanded {greedy.expanded} ")
    assert second.endswith(f"cost {greedy.cost:g}")
    shown.show_still()
    assert counts(shown)[0].startswith(f"expanded {blind.expanded} ")
    assert counts(shown)[0].endswith(f"cost {blind.cost:g}")
    assert counts(shown)[1] == second


def test_wall_floor_frontier_and_expanded_cells_have_their_colours() -> None:
    shown = replay(0)
    shown.go_to(2)
    marks, image = course(0).marks_after(2), pixels(shown)
    for cell in np.ndindex(*marks.shape):
        color = corner_of(shown, cell, image)
        if HALL.rows[cell[0]][cell[1]] == WALL:
            assert is_color(color, SHELF)
        elif marks[cell] == WAITING:
            assert is_color(color, FRONTIER)
        elif marks[cell] == UNTOUCHED:
            assert is_color(color, COLORS[EMPTY])
        else:
            assert is_color(color, WARNING if marks[cell] == NOW else SHADES[0])


def test_searches_without_a_path_and_without_a_step_say_so() -> None:
    shown = replay(1, layout=SPLIT, start=(1, 1), goal=(1, 5))
    shown.show_still()
    assert counts(shown) == ["expanded 4   frontier 0   no path"]
    shown = replay(0, INF, goal=START)
    assert [*shown.new_saved_frame_seq()] == [0]
    assert counts(shown) == ["expanded 0   frontier 0   cost 0"] * 2


def test_a_long_search_has_at_most_max_frames() -> None:
    layout = random_layout(40, 60, 0.1, seed=1)
    longest = course(0, layout, layout.pickups[0], layout.dropoffs[0])
    assert len(longest) > 2 * MAX_FRAMES
    shown = replay(0, 1, layout=layout, start=layout.pickups[0], goal=layout.dropoffs[0])
    frames = [*shown.new_saved_frame_seq()]
    assert MAX_FRAMES / 2 < len(frames) <= MAX_FRAMES
    shown.go_to(frames[-1])
    assert counts(shown)[0].startswith(f"expanded {len(longest)} ")
    shown.go_to(frames[-1] - 1)
    assert "cost" not in counts(shown)[0]


@pytest.mark.parametrize("panels", [1, 5, MAX_PANELS])
@pytest.mark.parametrize("size", [(4, 4), (5, 60), (60, 5)])
def test_panels_neither_overlap_nor_leave_the_figure(panels: int, size: tuple[int, int]) -> None:
    layout = random_layout(*size, 0.1, seed=1)
    ends = layout.pickups[0], layout.dropoffs[0]
    title = "Search from (110, 41) to (146, 316), heuristic: manhattan"
    shown = replay(*range(panels), layout=layout, start=ends[0], goal=ends[1], title=title)
    shown.go_to(MAX_FRAMES)
    shown.figure.canvas.draw()
    boxes = [
        Bbox.union([axes.get_tightbbox(), *(text.get_window_extent() for text in axes.texts)])
        for axes in shown.figure.axes
    ]
    assert len(boxes) == panels
    boxes += [text.get_window_extent() for text in (*shown.figure.texts, *shown.figure.legends)]
    for number, box in enumerate(boxes):
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= shown.figure.bbox.x1
        assert box.y1 <= shown.figure.bbox.y1
        assert not any(box.overlaps(other) for other in boxes[number + 1 :])


def test_no_search_and_too_many_are_errors() -> None:
    for count in (0, MAX_PANELS + 1):
        with pytest.raises(ValueError, match=rf"{count} searches; there must be 1\.\.6"):
            search_replay([course(1)] * count, "")


def test_names_are_shown_literally() -> None:
    for name in (*HOSTILE_NAMES[:2], "$\\frac{$"):
        named = SearchCourse(name, HALL, (START, START), solve(HALL, START, START, 1))
        shown = search_replay([named], name)
        shown.figure.canvas.draw()
        assert texts(shown).count(name) == 2
        page = page_in(shown._repr_html_())
        assert "<script>alert" not in page
        assert [track["title"] for track in said_by(page)["tracks"]] == [printable(name)]
