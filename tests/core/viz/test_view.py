"""Where the shapes of a floor are in their cells, as numbers and not as pixels."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from warehouse_core.records.plans import StepPlans
from warehouse_core.render.palette import (
    BATTERY,
    BRAKE,
    COLORS,
    FORCE,
    HIT,
    INK,
    ITEM,
    LOOK,
    ORDER_COLORS,
    PAPER,
    SKID,
    STRANDED,
    VELOCITY,
    VISITED,
    WARNING,
    blend,
    faded_trail,
)
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.tracks.track import (
    DrawnHit,
    FleetFrame,
    Frame,
    Marks,
    Pose,
    Push,
    Track,
    Waiting,
)
from warehouse_core.viz.view import DOTS, FADE_STEPS, GHOST, MAX_FADE, View

FLOOR = ("......",) * 5
EAST, SOUTH, WEST, NORTH = (math.pi / 2 * quarter for quarter in range(4))
RADIUS, FEW = LOOK["robot"]["radius"], LOOK["battery"]["few"]
LINES = LOOK["lines"]

Box = tuple[float, float, float, float]


def at(row: float, col: float, heading: float | None = EAST, *, loaded: bool = False) -> Pose:
    return Pose((col + 0.5, row + 0.5), heading, loaded)


def view_of(*frames: Frame, show: int = -1, cell_points: float = 40.0, **others: Any) -> Any:
    """Return the view of a track at one of its frames."""
    figure = make_figure((3, 2))
    view = View(figure, figure.add_axes((0, 0, 1, 1)), cell_points, Track([*frames], {}, **others))
    view.show(frames, range(len(frames))[show])
    return view


def robot_view(
    *poses: Pose | None, rows: Sequence[str] = FLOOR, part: float = 1.0, **o: Any
) -> Any:
    """Return the view of a robot in a step, by default the last; a step may have parts."""
    frames = [Frame(tuple(rows), (pose,), step * part) for step, pose in enumerate(poses)]
    return view_of(*frames, **o)


def fleet_view(
    *robots: Pose,
    people: tuple[Pose, ...] = (),
    cell_points: float = 40.0,
    waiting: tuple[Waiting, ...] = (),
    items: tuple[int | None, ...] = (),
    battery: tuple[float, ...] = (),
    plans: StepPlans | None = None,
) -> Any:
    """Return the view of a frame of a fleet."""
    none, full = (None,) * len(robots), (1.0,) * len(robots)
    fleet = FleetFrame(waiting, items or none, battery or full, *([plans] if plans else []))
    return view_of(Frame(FLOOR, (*robots, *people), 0.0, fleet=fleet), cell_points=cell_points)


def shapes(view: Any, **wanted: Any) -> list[Any]:
    """Return the shapes of a view that have some values, from the lowest to the highest."""
    drawn = [*view._traces.shapes, *view._bodies.shapes]
    return [s for s in drawn if all(getattr(s, name) == value for name, value in wanted.items())]


def boxes(found: Sequence[Any]) -> list[Box]:
    """Return left, top, right and bottom of each closed polygon of some shapes."""
    corners = [each for shape in found for each in shape.path.to_polygons(closed_only=False)]
    return [(*each.min(axis=0), *each.max(axis=0)) for each in corners]


def middles(found: Sequence[Any]) -> list[tuple[float, float]]:
    return [((left + right) / 2, (top + low) / 2) for left, top, right, low in boxes(found)]


def test_robots_of_a_fleet_are_numbered_discs_in_the_middle_and_people_diamonds() -> None:
    view = fleet_view(at(1, 4), at(3, 0.25), people=(at(2, 2),))
    discs = shapes(view, fill=COLORS["R"])
    assert middles(discs) == [pytest.approx((4.5, 1.5)), pytest.approx((0.75, 3.5))]
    _, person, numbers = (shape.path.to_polygons() for shape in shapes(view, fill=PAPER)[:3])
    assert len(person) == 1 < len(numbers)
    [(left, top, right, bottom)] = boxes(shapes(view, fill=COLORS["H"]))
    assert (left + right, top + bottom) == pytest.approx((5, 5))
    assert right - left == pytest.approx(bottom - top) == pytest.approx(0.72)


@pytest.mark.parametrize(
    ("cell_points", "radius"), [(40, 0.34), (22.5, 0.4), (15, 0.45), (4, 0.625)]
)
def test_robots_of_a_fleet_are_larger_where_cells_are_small(
    cell_points: float, radius: float
) -> None:
    view = fleet_view(at(0, 0), cell_points=cell_points)
    [(left, _, right, _)] = boxes(shapes(view, fill=COLORS["R"]))
    assert right - left == pytest.approx(2 * radius)


def test_colours_of_a_fleet_say_what_is_carried_and_what_is_empty() -> None:
    view = fleet_view(at(0, 0), at(0, 1, loaded=True), at(0, 2), battery=(0.01, 1.0, 0.0))
    for column, color in enumerate((COLORS["R"], COLORS["r"], STRANDED)):
        assert middles(shapes(view, fill=color)) == [pytest.approx((column + 0.5, 0.5))]


def test_batteries_are_bars_below_their_robots_as_long_as_their_share() -> None:
    view = fleet_view(at(1, 1, None), at(1, 3, None), battery=(0.5, 0.2))
    grounds = [each for each in boxes(shapes(view, fill=PAPER, line=INK)) if each[1] > 1.7]
    for x, share, ground, color in zip(
        (1.5, 3.5), (0.5, 0.2), grounds, (BATTERY, WARNING), strict=True
    ):
        left, top, right, bottom = ground
        assert left + right == pytest.approx(2 * x)
        assert 1.5 + RADIUS < top < bottom < 2
        assert right - left == pytest.approx(2 * RADIUS)
        level = (left, top, left + share * (right - left), bottom)
        assert boxes(shapes(view, fill=color)) == [pytest.approx(level)]


def test_a_large_fleet_has_bars_below_robots_with_low_batteries_alone() -> None:
    robots = [at(0, 0)] * FEW
    battery = (0.25, 0.24, *[0.9] * (FEW - 2))
    few = fleet_view(*robots, battery=battery)
    assert len(boxes(shapes(few, fill=BATTERY))) == FEW - 1
    view = fleet_view(*robots, at(2, 2), battery=(*battery, 0.1))
    lefts = [left for left, *_ in boxes(shapes(view, fill=WARNING))]
    assert lefts == pytest.approx([0.5 - RADIUS, 2.5 - RADIUS])
    assert not shapes(view, fill=BATTERY)


def test_items_are_squares_in_the_upper_right_of_their_robots() -> None:
    view = fleet_view(at(1, 1), at(2, 3, loaded=True), at(4, 4, loaded=True), items=(None, 0, 3))
    for (x, y), age in (((3.5, 2.5), 0), ((4.5, 4.5), 3)):
        [item] = shapes(view, fill=ORDER_COLORS[age])
        [(left, top, right, bottom)] = boxes([item])
        assert x < left < right < x + 0.5
        assert y - 0.5 < top < bottom < y
        assert right - left == pytest.approx(bottom - top)
        assert item.line == (PAPER if age == 3 else INK)


def test_the_number_of_orders_is_in_the_lower_right_of_their_pickup() -> None:
    waiting = (Waiting((2.5, 1.5), 7, 1), Waiting((4.5, 3.5), 12, 3))
    view = fleet_view(at(0, 0), waiting=waiting)
    for (x, y), _, age in waiting:
        [(left, top, right, bottom)] = boxes(shapes(view, fill=ORDER_COLORS[age]))
        assert x - 0.2 < left < right < x + 0.7
        assert y < top < bottom < y + 0.6


@pytest.mark.parametrize(
    ("heading", "ahead"),
    [(EAST, (1, 0)), (SOUTH, (0, 1)), (WEST, (-1, 0)), (NORTH, (0, -1))],
)
def test_a_nose_is_a_wedge_ahead_of_its_robot(heading: float, ahead: tuple[int, int]) -> None:
    for view in (fleet_view(at(2, 3, heading), at(0, 0, None)), robot_view(at(2, 3, heading))):
        nose = next(s for s in shapes(view, fill=INK, line=None) if len(s.path.vertices) == 4)
        ways = np.asarray(nose.path.vertices)[:3] - (3.5, 2.5)
        tip, *base = sorted(ways @ ahead, reverse=True)
        assert tip == pytest.approx(0.48)
        assert all(0.2 < each < RADIUS for each in base), "its foot begins under the disc"
        assert abs(ways @ (-ahead[1], ahead[0])).max() == pytest.approx(0.16)


def test_a_lone_robot_is_a_disc_with_a_letter_that_may_be_gone() -> None:
    view = robot_view(at(1, 2), at(1, 3, NORTH))
    [disc] = shapes(view, fill=COLORS["R"])
    assert boxes([disc]) == [
        pytest.approx((3.5 - RADIUS, 1.5 - RADIUS, 3.5 + RADIUS, 1.5 + RADIUS))
    ]
    letter = shapes(view, fill=PAPER)[-1]
    assert middles([letter])[0] == pytest.approx((3.5, 1.5), abs=0.1)
    assert not disc.dashes
    assert shapes(robot_view(at(1, 3), motor_strength=0.5), fill=COLORS["R"])[0].dashes
    gone = robot_view(at(1, 2), None)
    assert not shapes(gone, fill=COLORS["R"]) + shapes(gone, fill=PAPER)


def body_view(*pushes: Push | None, drive: str = "differential", **others: Any) -> Any:
    """Return the view of a body that drives east from column 0, one cell for each push."""
    poses = [Pose((col + 0.5, 2.5), EAST, False, push) for col, push in enumerate(pushes)]
    frames = [Frame(FLOOR, (pose,), float(step)) for step, pose in enumerate(poses)]
    return view_of(*frames, is_continuous=True, drive=drive, **others)


FAST, BRAKING = Push((1.0, 0.0), (60.0, 0.0)), Push((0.5, 0.0), (-60.0, 0.0), skids=True)


def test_a_body_has_a_chassis_with_a_front_and_its_drive_and_no_letter() -> None:
    view = body_view(None, None, drive="differential")
    [chassis] = boxes(shapes(view, fill=COLORS["R"]))
    assert chassis == pytest.approx((1.5 - 0.27, 2.5 - 0.21, 1.8, 2.5 + 0.21))
    [front] = boxes(shapes(view, fill=PAPER))
    assert 1.5 < front[0] < front[2] < 1.8
    wheels = [box for box in boxes(shapes(view, fill=INK)) if box[2] - box[0] < 0.3]
    assert sorted(round((box[1] + box[3]) / 2, 2) for box in wheels) == [2.23, 2.77]
    ring = shapes(body_view(None, None, drive="omnidirectional"), fill=None, line=INK)
    assert boxes(ring)[-1] == pytest.approx((1.15, 2.15, 1.85, 2.85))
    for drive in ("", "tracked"):
        assert not shapes(body_view(None, drive=drive), fill=INK)


def test_a_body_has_arrows_for_velocity_and_force_and_a_brake_light() -> None:
    view = body_view(None, FAST)
    for color, length in ((VELOCITY, 0.7), (FORCE, 0.66)):
        [(left, _, right, _)] = boxes(shapes(view, fill=color))
        assert left == 1.5, "an arrow begins at the centre"
        assert right == pytest.approx(1.5 + 0.3 + length + 0.17 * (1.5 if color == FORCE else 1))
    assert not shapes(view, fill=BRAKE)
    view.has_arrows = False
    view.show(view._track.frames, 1)
    assert not shapes(view, fill=VELOCITY) + shapes(view, fill=FORCE)
    braking = body_view(None, BRAKING)
    assert boxes(shapes(braking, fill=BRAKE)) == [pytest.approx((1.08, 2.3, 1.24, 2.7))]
    [(left, _, right, _)] = boxes(shapes(braking, fill=FORCE))
    assert left < right == 1.5
    assert not shapes(body_view(None, Push((0, 0), (0, 0))), fill=FORCE)
    [(_, _, right, _)] = boxes(shapes(body_view(None, Push((90, 0), (0, 0))), fill=VELOCITY))
    assert right == pytest.approx(1.5 + 1.4 + 0.17), "the longest arrow"


def test_skid_marks_are_beside_the_path_where_a_body_skids() -> None:
    dry, icy = (
        body_view(FAST, FAST, BRAKING, FAST, slippery=slippery) for slippery in ((), ((2, 2),))
    )
    assert boxes(shapes(icy, line=SKID)) == [
        pytest.approx((1.5, row, 2.5, row)) for row in (2.3, 2.7)
    ]
    assert not shapes(dry, line=SKID)


def test_small_bodies_are_discs() -> None:
    [disc] = shapes(body_view(None, FAST, cell_points=12.0), fill=COLORS["R"])
    left, top, right, bottom = boxes([disc])[0]
    assert (right - left, bottom - top) == pytest.approx((2 * 5 / 12, 2 * 5 / 12))


def test_a_burst_has_the_size_of_its_hit() -> None:
    hits = DrawnHit((1.5, 1.5), "", size=1.0), DrawnHit((3.5, 1.5), "", size=1.6)
    stars = boxes(shapes(view_of(Frame(FLOOR, (at(0, 0),), 0.0, hits=hits)), fill=HIT))
    one, other = (right - left for left, _, right, _ in stars)
    assert other == pytest.approx(1.6 * one)


def test_a_ghost_is_a_dashed_circle_where_the_other_robot_is() -> None:
    view = body_view(None, None, ghost=[(0.5, 0.5), (4.5, 1.5)])
    [ghost] = [shape for shape in shapes(view, fill=None, line=INK) if shape.dashes == GHOST]
    assert middles([ghost]) == [pytest.approx((4.5, 1.5))]


def test_an_item_waits_at_its_pickup_is_carried_and_stays_where_it_was_put() -> None:
    rows = ("P....D",)
    course = [at(0, 0), at(0, 0, loaded=True), at(0, 5, loaded=True), at(0, 5)]
    places = []
    for step in range(len(course)):
        [place] = middles(shapes(robot_view(*course, rows=rows, show=step), fill=ITEM))
        places.append(place)
    away = LOOK["item"]["place"]
    expected = (away, away), (0.5, 0.5), (5.5, 0.5), (5 + away, away)
    assert places == [pytest.approx(place) for place in expected]
    assert len(boxes(shapes(robot_view(*course[2:], rows=rows, show=0), fill=ITEM))) == 1


def test_cells_are_tinted_by_the_visits_of_the_robot() -> None:
    course = [at(0, col % 2) for col in range(9)]  # five times at column 0, four at column 1
    view = robot_view(*course, at(1, 0), at(2, 0))
    tints = {box: color for color in VISITED for box in boxes(shapes(view, fill=color))}
    assert tints == {(0, 0, 1, 1): VISITED[1], (1, 0, 2, 1): VISITED[1]}
    slippery = robot_view(*course, slippery=((0, 1),))
    assert boxes(shapes(slippery, fill=VISITED[1])) == [(0, 0, 1, 1)]
    assert not shapes(robot_view(*course, rows=("PD",)), fill=VISITED[1])


def test_a_trail_has_a_piece_for_each_load_and_a_leg_for_the_step_in_progress() -> None:
    course = [at(0, 0), at(0, 1), at(0, 2, loaded=True), at(1, 2, loaded=True)]
    view = robot_view(*course)
    empty, loaded = (shapes(view, line=faded_trail(each, 0.0)) for each in (False, True))
    assert [s.path.vertices.tolist() for s in empty] == [[[0.5, 0.5], [1.5, 0.5], [2.5, 0.5]]]
    assert [s.path.vertices.tolist() for s in loaded if len(s.path) > 1] == [
        [[2.5, 0.5], [2.5, 1.5]]
    ]
    assert loaded[0].dashes
    assert not empty[0].dashes
    halves = robot_view(at(0, 0), at(0, 0.5), at(0, 1), at(0, 1.5), part=0.5)
    leg = shapes(halves, line=faded_trail(False, 0.0))[-1]
    assert leg.path.vertices.tolist() == [[1.5, 0.5], [2, 0.5]]


def test_the_view_of_a_lone_robot_alone_is_shown() -> None:
    for robots, radius, count in ((1, 1, 2), (1, None, 0), (2, 1, 0)):
        view = view_of(Frame(FLOOR, (at(2, 3),) * robots, 0.0), view_radius=radius)
        shaded = [shape for shape in shapes(view, fill=INK) if shape.alpha < 1]
        assert len(boxes(shaded)) == count


@pytest.mark.parametrize(("size", "every"), [(20, 1), (21, 5), (60, 5), (61, 10)])
def test_large_maps_have_fewer_numbers(size: int, every: int) -> None:
    axes = view_of(Frame(("." * size,), (at(0, 0),), 0.0))._tiles.axes
    numbers = [label.get_text() for label in axes.get_xticklabels()]
    assert numbers == [str(number) for number in range(0, size, every)]
    assert (axes.get_xlim(), axes.get_ylim()) == ((0, size), (1, 0))


def test_stations_are_enlarged_on_cells_that_are_too_small_for_them() -> None:
    rows = ("P.D", ".C.")
    large, small = (
        view_of(Frame(rows, (None,), 0.0), cell_points=points)._stations.shapes
        for points in (40, 4)
    )
    assert not large
    assert middles(small) == [pytest.approx(each) for each in ((0.5, 0.5), (2.5, 0.5), (1.5, 1.5))]
    assert [shape.fill for shape in small] == [COLORS[tile] for tile in "PDC"]


def test_a_planned_way_is_drawn_from_point_to_point() -> None:
    ways = ((0.5, 0.5), (1.5, 0.5), (1.5, 2.5)), ((2.5, 2.5), (3.5, 2.5)), ()
    frames = [Frame(FLOOR, (at(0, 0),), float(step), route=way) for step, way in enumerate(ways)]
    view = view_of(*frames)
    for number, way in enumerate(ways):
        view.show(frames, number)
        found = [s.path.vertices.tolist() for s in shapes(view, line=INK, dashes=DOTS)]
        assert found == [[[*point] for point in way]] * bool(way)


def test_plans_of_a_fleet_fade_and_go_on_as_dots_and_pushers_have_arrows() -> None:
    way = tuple((0, col) for col in range(4))
    plans = StepPlans({0: way}, {0: ((0, 3), (1, 3), (1, 3))}, {1: 0})
    view = fleet_view(at(0, 0, None), at(2, 0, None), plans=plans)
    legs = [s for s in shapes(view, fill=None) if s.width == LINES["plan"]]
    assert [s.path.vertices.tolist() for s in legs] == [
        [[col + 0.5, 0.5], [col + 1.5, 0.5]] for col in range(3)
    ]
    for time, leg in enumerate(legs):
        assert leg.line == blend(COLORS["R"], COLORS["."], time / FADE_STEPS * MAX_FADE)
    [wish] = shapes(view, width=LINES["wish"])
    assert wish.path.vertices.tolist() == [[3.5, 0.5], [3.5, 1.5]]
    assert wish.dashes == DOTS
    assert wish.line == blend(COLORS["R"], COLORS["."], 3 / FADE_STEPS * MAX_FADE)
    [(left, top, right, bottom)] = boxes(shapes(view, fill=INK, line=PAPER))
    assert left < 0.5 < right
    assert 1.2 < top < 1.5 < bottom == pytest.approx(1.8), "it points down"


@pytest.mark.parametrize("x", [3.0, 0.0, 6.0])
def test_the_label_of_a_hit_is_above_it_and_on_the_map(x: float) -> None:
    hits = DrawnHit((2.0, 2.0), "first"), DrawnHit((x, 3.0), "wall")
    view = view_of(Frame(FLOOR, (at(0, 0),), 0.0, hits=hits))
    stars, label = shapes(view, fill=HIT)
    assert [place[0] for place in middles([stars])] == pytest.approx([2, x], abs=0.02)
    [(left, top, right, bottom)] = boxes([label])
    assert 0 <= left < right <= 6
    assert abs((left + right) / 2 - x) <= (right - left) / 2
    assert 2.2 < top < bottom < 3
    [(_, top, _, _)] = boxes(shapes(view_of(Frame(FLOOR, (None,), 0.0, hits=(
        DrawnHit((x, 0.0), "wall"),))), fill=HIT)[1:])  # fmt: skip
    assert top >= 0
    plain = view_of(Frame(FLOOR, (at(0, 0),), 0.0, hits=(DrawnHit((x, 3.0), ""),)))
    assert len(shapes(plain, fill=HIT)) == 1


def test_a_search_has_marks_up_to_its_clock_a_path_and_its_ends() -> None:
    colors, cells = [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)], [(0, 0), (0, 1), (0, 0)]
    marks = Marks([0, 1, 2], cells, [0, 0, 1], colors, ["one", "two"], ((0, 0), (4, 5)))
    way = ((0.5, 0.5), (5.5, 4.5))
    frames = [Frame(FLOOR, (), float(n), clock=float(n)) for n in range(3)]
    frames[2].route = way
    for number, blue, red in ((0, [(0.5, 0.5)], []), (2, [(1.5, 0.5)], [(0.5, 0.5)])):
        view = view_of(*frames, show=number, marks=marks)
        for color, places in zip(colors, (blue, red), strict=True):
            assert middles(shapes(view, fill=color)) == [pytest.approx(each) for each in places]
        assert [*map(len, (shapes(view, line=PAPER), shapes(view, line=WARNING)))] == [
            number // 2
        ] * 2
        discs = middles(shapes(view, fill=PAPER, line=INK))
        assert discs == [pytest.approx(each) for each in way]
