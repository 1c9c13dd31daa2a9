"""Where the shapes of a floor are in their cells, as numbers and not as pixels."""

import math
from collections.abc import Sequence
from typing import Any

import pytest

from warehouse_core.records.plans import NO_PLANS, StepPlans
from warehouse_core.render.palette import (
    BATTERY,
    BRAKE,
    COLORS,
    FORCE,
    HIT,
    INK,
    ITEM,
    LOOK,
    PAPER,
    SKID,
    STRANDED,
    VELOCITY,
    VISITED,
    WARNING,
)
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.shapes import DOTS, Shape, Shapes, lines
from warehouse_core.viz.tracks.track import DrawnHit, FleetFrame, Frame, Marks, Pose, Push, Track
from warehouse_core.viz.view import GHOST, View

FLOOR = ("......",) * 5
EAST, NORTH = 0.0, -math.pi / 2
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


def robot_view(*poses: Pose | None, rows: tuple[str, ...] = FLOOR, **others: Any) -> Any:
    """Return the view of a robot in a step, by default the last."""
    return view_of(*(Frame(rows, (pose,), float(n)) for n, pose in enumerate(poses)), **others)


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


def fleet_view(
    *robots: Pose,
    battery: Sequence[float] = (),
    plans: StepPlans = NO_PLANS,
    cell_points: float = 40.0,
) -> Any:
    """Return the view of a frame of a fleet without items."""
    levels = tuple(battery) or (1.0,) * len(robots)
    fleet = FleetFrame((), (None,) * len(robots), levels, plans)
    return view_of(Frame(FLOOR, robots, 0.0, fleet=fleet), cell_points=cell_points)


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
    [ring] = boxes(shapes(body_view(None, None, drive="omnidirectional"), fill=INK))
    assert ring == pytest.approx((1.125, 2.125, 1.875, 2.875))
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


def test_plans_of_a_fleet_go_on_as_dots_and_pushers_have_arrows() -> None:
    path = tuple((0, col) for col in range(4))
    plans = StepPlans({0: path}, {0: ((0, 3), (1, 3), (1, 3))}, {1: 0})
    view = fleet_view(at(0, 0, None), at(2, 0, None), plans=plans)
    legs = [s.path.vertices.tolist() for s in shapes(view, fill=None, width=LINES["plan"])]
    assert legs == [[[col + 0.5, 0.5], [col + 1.5, 0.5]] for col in range(3)]
    [wish] = shapes(view, width=LINES["wish"], dashes=DOTS)
    assert wish.path.vertices.tolist() == [[3.5, 0.5], [3.5, 1.5]]
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


def test_a_line_has_its_width_in_cells_also_in_pixels() -> None:
    figure = make_figure((2, 1))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, 4), ylim=(2, 0))
    axes.set_axis_off()
    line = Shapes()
    axes.add_artist(line)
    line.show([Shape(lines([[(0, 1), (4, 1)]]), None, INK, 0.2)])
    assert (figure.rgba()[:, 100, 0] < 128).sum() == 0.2 * 50
