"""Where the parts of robots are in their cells, as numbers and not as pixels."""

import math
from typing import Any

import numpy as np
import pytest

from warehouse_core.render.palette import (
    BATTERY,
    COLORS,
    ORDER_COLORS,
    STRANDED,
    TRAIL_COLORS,
    VISITED,
    WARNING,
)
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.tracks.track import DrawnHit, FleetFrame, Frame, Pose, Track, Waiting
from warehouse_core.viz.view import FEW, FleetView, RobotView, View, boxes_around, nose_of

FLOOR = ("......",) * 5
EAST, SOUTH, WEST, NORTH = (math.pi / 2 * quarter for quarter in range(4))


def at(row: float, col: float, heading: float | None = EAST, *, loaded: bool = False) -> Pose:
    return Pose((col + 0.5, row + 0.5), heading, loaded)


def fleet_view(
    *robots: Pose,
    people: tuple[Pose, ...] = (),
    items: tuple[int | None, ...] = (),
    battery: tuple[float, ...] = (),
    cell_points: float = 40.0,
) -> Any:
    """Return the view of a frame of a fleet."""
    figure = make_figure((3, 2))
    view = FleetView(figure, figure.add_axes((0, 0, 1, 1)), cell_points, len(robots))
    none, full = (None,) * len(robots), (1.0,) * len(robots)
    fleet = FleetFrame((), items or none, battery or full)
    view.show([Frame(FLOOR, (*robots, *people), 0.0, fleet=fleet)], 0)
    return view


def boxes_of(collection: Any) -> list[tuple[float, float, float, float]]:
    """Return left, top, right and bottom of each shape of a collection."""
    corners = [path.vertices for path in collection.get_paths()]
    return [(*each.min(axis=0), *each.max(axis=0)) for each in corners]


def colors_of(collection: Any) -> list[tuple[float, ...]]:
    return [tuple(color[:3]) for color in collection.get_facecolor()]


def test_robots_of_a_fleet_are_discs_in_the_middle_and_people_diamonds() -> None:
    view = fleet_view(at(1, 4), at(3, 0.25), people=(at(2, 2),))
    assert view._discs.get_offsets().tolist() == [[4.5, 1.5], [0.75, 3.5]]
    assert view._numbers.get_offsets().tolist() == [[4.5, 1.5], [0.75, 3.5]]
    assert len(view._numbers.get_paths()) == 2
    [(left, top, right, bottom)] = boxes_of(view._people)
    assert (left + right, top + bottom) == pytest.approx((5, 5))
    assert 0.6 < right - left < 0.9
    assert bottom - top == pytest.approx(right - left)


@pytest.mark.parametrize(
    ("cell_points", "radius"), [(40, 0.36), (25, 0.36), (22.5, 0.4), (15, 0.45), (4, 0.625)]
)
def test_robots_of_a_fleet_are_larger_where_cells_are_small(
    cell_points: float, radius: float
) -> None:
    view = fleet_view(at(0, 0), cell_points=cell_points)
    assert view._discs.get_widths() == view._discs.get_heights() == pytest.approx([2 * radius])


def test_colours_of_a_fleet_say_what_is_carried_and_what_is_empty() -> None:
    view = fleet_view(at(0, 0), at(0, 1, loaded=True), at(0, 2), battery=(0.01, 1.0, 0.0))
    assert colors_of(view._discs) == [COLORS["R"], COLORS["r"], STRANDED]


def test_batteries_are_bars_below_their_robots_as_long_as_their_share() -> None:
    view = fleet_view(at(1, 1), at(1, 3), battery=(0.5, 0.2))
    grounds, levels = boxes_of(view._grounds), boxes_of(view._levels)
    for (x, y), share, ground, level in zip(
        [(1.5, 1.5), (3.5, 1.5)], (0.5, 0.2), grounds, levels, strict=True
    ):
        left, top, right, bottom = ground
        assert left + right == pytest.approx(2 * x)
        assert y + 0.2 < top < bottom < y + 0.5, "in the lower half of the cell"
        assert 0.08 < bottom - top < 0.2
        assert right - left == pytest.approx(0.72)
        assert level == pytest.approx((left, top, left + share * (right - left), bottom))
    assert colors_of(view._levels) == [BATTERY, WARNING]


def test_a_large_fleet_has_bars_below_robots_with_low_batteries_alone() -> None:
    robots = [at(0, 0)] * FEW
    battery = (0.25, 0.24, *[0.9] * (FEW - 2))
    assert len(boxes_of(fleet_view(*robots, battery=battery)._levels)) == FEW
    view = fleet_view(*robots, at(2, 2), battery=(*battery, 0.1))
    lefts = [left for left, *_ in boxes_of(view._levels)]
    assert lefts == pytest.approx([0.14, 2.14])
    assert colors_of(view._levels) == [WARNING] * 2


def test_items_are_squares_in_the_upper_right_of_their_robots() -> None:
    view = fleet_view(at(1, 1), at(2, 3, loaded=True), at(4, 4, loaded=True), items=(None, 0, 2))
    middles = (3.5, 2.5), (4.5, 4.5)
    for (x, y), (left, top, right, bottom) in zip(middles, boxes_of(view._items), strict=True):
        assert x < left < right < x + 0.5
        assert y - 0.5 < top < bottom < y
        assert right - left == pytest.approx(bottom - top)
    assert colors_of(view._items) == [ORDER_COLORS[0], ORDER_COLORS[2]]


def test_the_number_of_orders_is_in_the_lower_right_of_their_pickup() -> None:
    figure = make_figure((3, 2))
    view = FleetView(figure, figure.add_axes((0, 0, 1, 1)), 40.0, 1)
    waiting = (Waiting((2.5, 1.5), 7, 1), Waiting((4.5, 3.5), 12, 3))
    view.show([Frame(FLOOR, (at(0, 0),), 0.0, fleet=FleetFrame(waiting, (None,), (1.0,)))], 0)
    texts = figure.axes[0].texts
    assert [text.get_text() for text in texts] == ["7", "12!"]
    for orders, text in zip(waiting, texts, strict=True):
        (x, y), (to_x, to_y) = orders.at, text.get_position()
        assert x < to_x < x + 0.6
        assert y < to_y < y + 0.6


@pytest.mark.parametrize(
    ("heading", "ahead"),
    [(EAST, (1, 0)), (SOUTH, (0, 1)), (WEST, (-1, 0)), (NORTH, (0, -1))],
)
def test_a_nose_is_a_wedge_ahead_of_its_robot(heading: float, ahead: tuple[int, int]) -> None:
    pose, aside = at(2, 3, heading), (-ahead[1], ahead[0])
    ways = (nose_of(pose, 0.3, 1.4) - np.array(pose.at)) / 0.3
    left, tip, right = [(float(way @ ahead), float(way @ aside)) for way in ways]
    assert tip == pytest.approx((1.4, 0))
    assert left == pytest.approx((right[0], -right[1]))
    assert 0.9 < math.hypot(*left) < 1, "its foot begins under the disc"
    assert 0.5 < abs(left[1]) < 0.8
    [box] = boxes_of(fleet_view(pose, at(0, 0, None))._noses)
    assert all(3 <= x <= 4 for x in box[::2])
    assert all(2 <= y <= 3 for y in box[1::2])


@pytest.mark.parametrize("shown", [(0, 0, 8, 6), (0.5, 0.5, 7.5, 5.5)])
@pytest.mark.parametrize("cell", [(2, 3), (0, 0), (5, 7), (0, 4), (3, 7)])
@pytest.mark.parametrize("radius", [0, 1, 2, 9])
def test_the_boxes_around_a_view_cover_once_what_it_does_not_see(
    shown: tuple[float, float, float, float], cell: tuple[int, int], radius: int
) -> None:
    boxes = [(*box.min(axis=0), *box.max(axis=0)) for box in boxes_around(cell, radius, shown)]
    for x in np.arange(shown[0] + 0.25, shown[2], 0.5):
        for y in np.arange(shown[1] + 0.25, shown[3], 0.5):
            covered = sum(left < x < right and top < y < low for left, top, right, low in boxes)
            is_seen = abs(int(y) - cell[0]) <= radius and abs(int(x) - cell[1]) <= radius
            assert covered == (not is_seen), (x, y)


def robot_view(
    *poses: Pose | None,
    rows: tuple[str, ...] = FLOOR,
    show: int = -1,
    part: float = 1.0,
    **others: Any,
) -> Any:
    """Return the view of a robot at the last step, or in another; a step may have parts."""
    figure = make_figure((3, 2))
    frames = [Frame(rows, (pose,), step * part) for step, pose in enumerate(poses)]
    track = Track(frames, {}, **others)
    view = RobotView(figure, figure.add_axes((0, 0, 1, 1)), 40.0, 0, track)
    view.show(frames, range(len(frames))[show])
    return view


def test_a_lone_robot_is_a_disc_with_a_letter_and_a_nose() -> None:
    view = robot_view(at(1, 2), at(1, 3, NORTH))
    assert view._disc.center == (3.5, 1.5)
    assert (view._disc.get_facecolor()[:3], view._disc.radius) == (COLORS["R"], 0.31)
    middle = view._letter.get_path().get_extents()
    assert (middle.x0 + middle.x1, middle.y0 + middle.y1) == pytest.approx((7, 3), abs=0.1)
    assert view._nose.get_xy()[1].tolist() == pytest.approx([3.5, 1.5 - 0.31 * 1.5])
    assert robot_view(at(1, 3, None))._nose.get_visible() is False
    gone = robot_view(at(1, 2), None)
    parts = (gone._disc, gone._nose, gone._letter)
    assert not any(each.get_visible() for each in parts)


def test_an_item_waits_at_its_pickup_is_carried_and_stays_where_it_was_put() -> None:
    rows = ("P....D",)
    course = [at(0, 0), at(0, 0, loaded=True), at(0, 5, loaded=True), at(0, 5)]
    places = []
    for step in range(len(course)):
        [box] = boxes_of(robot_view(*course, rows=rows, show=step)._items)
        places.append(((box[0] + box[2]) / 2, (box[1] + box[3]) / 2))
    station, _, carried, put = places
    assert places[1:3] == [pytest.approx((0.5, 0.5)), pytest.approx((5.5, 0.5))]
    assert 0.5 < station[0] < 1
    assert 0.5 < station[1] < 1
    assert put == pytest.approx((5 + station[0], station[1]))
    assert carried != put
    assert not boxes_of(robot_view(*course[2:], rows=("P....D",), show=0)._items)[1:]


def test_cells_are_tinted_by_the_visits_of_the_robot() -> None:
    course = [at(0, col % 2) for col in range(9)]  # five times at column 0, four at column 1
    view = robot_view(*course, at(1, 0), at(2, 0))
    tints = dict(zip([box[:2] for box in boxes_of(view._floor)], colors_of(view._floor),
                     strict=True))  # fmt: skip
    cells = {(round(x - 0.02), round(y - 0.02)): color for (x, y), color in tints.items()}
    assert cells == {(0, 0): VISITED[min(5 // 2, len(VISITED)) - 1],
                     (1, 0): VISITED[min(4 // 2, len(VISITED)) - 1]}  # fmt: skip
    for box in boxes_of(view._floor):
        assert box[2] - box[0] == pytest.approx(box[3] - box[1])
        assert 0.9 < box[2] - box[0] < 1
    assert len(boxes_of(robot_view(*course, slippery=((0, 1),))._floor)) == 1
    assert not boxes_of(robot_view(*course, rows=("PD",))._floor)


def test_a_trail_has_a_piece_for_each_load_and_a_leg_for_the_step_in_progress() -> None:
    course = [at(0, 0), at(0, 1), at(0, 2, loaded=True), at(1, 2, loaded=True)]
    trails = robot_view(*course)._trails
    empty, loaded = ([way.tolist() for way in trails[each].get_segments()] for each in (0, 1))
    assert empty == [[[0.5, 0.5], [1.5, 0.5], [2.5, 0.5]]]
    assert loaded == [[[2.5, 0.5], [2.5, 1.5]]]
    halves = robot_view(at(0, 0), at(0, 0.5), at(0, 1), at(0, 1.5), part=0.5)
    assert halves._leg.get_xydata().tolist() == [[1.5, 0.5], [2, 0.5]]
    assert halves._leg.get_color() == TRAIL_COLORS[False]
    carrying = robot_view(at(0, 0, loaded=True), at(0, 0.5, loaded=True), part=0.5)
    assert carrying._leg.get_color() == TRAIL_COLORS[True]


def test_the_view_of_a_lone_robot_alone_is_shown() -> None:
    frames = [Frame(FLOOR, (at(2, 3),), 0.0)]
    for robots, radius, boxes in ((1, 1, 4), (1, None, 0), (2, 1, 0)):
        frames[0].robots = (at(2, 3),) * robots
        figure = make_figure((3, 2))
        track = Track(frames, {}, view_radius=radius)
        view: Any = RobotView(figure, figure.add_axes((0, 0, 1, 1)), 40.0, 0, track)
        view.show(frames, 0)
        assert len(view._shadow.get_paths()) == boxes


def view_of(frame: Frame, **others: Any) -> Any:
    figure = make_figure((3, 2))
    view = View(figure, figure.add_axes((0, 0, 1, 1)), 40.0, Track([frame], {}, **others))
    view.show([frame], 0)
    return view


@pytest.mark.parametrize(
    ("size", "every", "has_lines"),
    [(20, 1, True), (21, 5, True), (40, 5, True), (41, 5, False), (60, 5, False), (61, 10, False)],
)
def test_large_maps_have_fewer_numbers_and_no_lines(size: int, every: int, has_lines: bool) -> None:
    axes = view_of(Frame(("." * size,), (at(0, 0),), 0.0))._axes
    numbers = [label.get_text() for label in axes.get_xticklabels()]
    assert numbers == [str(number) for number in range(0, size, every)]
    grid = [each for each in axes.collections if len(each.get_paths()) == size + 1 + 2]
    assert bool(grid) == has_lines
    assert (axes.get_xlim(), axes.get_ylim()) == ((0, size), (1, 0))


def test_a_planned_way_is_drawn_from_point_to_point() -> None:
    ways = ((0.5, 0.5), (1.5, 0.5), (1.5, 2.5)), ((2.5, 2.5), (3.5, 2.5)), ()
    frames = [Frame(FLOOR, (at(0, 0),), float(step), route=way) for step, way in enumerate(ways)]
    figure = make_figure((3, 2))
    view: Any = View(figure, figure.add_axes((0, 0, 1, 1)), 40.0, Track(frames, {}))
    for number, way in enumerate(ways):
        view.show(frames, number)
        assert [tuple(point) for point in view._route.get_xydata()] == [*way]


@pytest.mark.parametrize(
    ("x", "side", "left"),
    [(3.0, "center", 3.0), (1.2, "center", 1.2), (1.1, "left", 1.1), (0.0, "left", 0.1),
     (4.8, "center", 4.8), (4.9, "right", 4.9), (6.0, "right", 5.9)],
)  # fmt: skip
def test_the_label_of_a_hit_is_above_it_and_on_the_map(x: float, side: str, left: float) -> None:
    hits = DrawnHit((2.0, 2.0), "first"), DrawnHit((x, 3.0), "wall")
    view = view_of(Frame(FLOOR, (at(0, 0),), 0.0, hits=hits))
    assert view._hits.get_xydata().tolist() == [[2, 2], [x, 3]]
    label = view._hit_label
    assert (label.get_text(), label.get_ha(), label.get_va()) == ("wall", side, "bottom")
    assert label.get_position() == pytest.approx((left, 2.75))
    high = view_of(Frame(FLOOR, (at(0, 0),), 0.0, hits=(DrawnHit((x, 0.0), "wall"),)))
    assert high._hit_label.get_position()[1] == 0.5
    assert not view_of(Frame(FLOOR, (at(0, 0),), 0.0))._hit_label.get_visible()
    assert not view_of(Frame(FLOOR, (at(0, 0),), 0.0, hits=(DrawnHit((x, 3.0), ""),))
                       )._hit_label.get_visible()  # fmt: skip
