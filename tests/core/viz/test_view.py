"""Numbers and labels of a floor; ``test_recorded.py`` has the shapes of all that it shows."""

from collections.abc import Sequence
from typing import Any

import pytest

from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.tracks.track import DrawnHit, Frame, Pose, Track
from warehouse_core.viz.view import View

FLOOR = ("......",) * 5
ROBOT = Pose((0.5, 0.5), 0.0, False)

Box = tuple[float, float, float, float]


def view_of(frame: Frame) -> Any:
    """Return the view of a frame."""
    figure = make_figure((3, 2))
    view = View(figure, figure.add_axes((0, 0, 1, 1)), 40.0, Track([frame], {}))
    view.show([frame], 0)
    return view


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


@pytest.mark.parametrize(("size", "every"), [(20, 1), (21, 5), (60, 5), (61, 10)])
def test_large_maps_have_fewer_numbers(size: int, every: int) -> None:
    axes = view_of(Frame(("." * size,), (ROBOT,), 0.0))._tiles.axes
    numbers = [label.get_text() for label in axes.get_xticklabels()]
    assert numbers == [str(number) for number in range(0, size, every)]
    assert (axes.get_xlim(), axes.get_ylim()) == ((0, size), (1, 0))


@pytest.mark.parametrize("x", [3.0, 0.0, 6.0])
def test_the_label_of_a_hit_is_above_it_and_on_the_map(x: float) -> None:
    hits = DrawnHit((2.0, 2.0), "first"), DrawnHit((x, 3.0), "wall")
    view = view_of(Frame(FLOOR, (ROBOT,), 0.0, hits=hits))
    stars, label = shapes(view, fill="hit")
    assert [place[0] for place in middles([stars])] == pytest.approx([2, x], abs=0.02)
    [(left, top, right, bottom)] = boxes([label])
    assert 0 <= left < right <= 6
    assert abs((left + right) / 2 - x) <= (right - left) / 2
    assert 2.2 < top < bottom < 3
    [(_, top, _, _)] = boxes(shapes(view_of(Frame(FLOOR, (None,), 0.0, hits=(
        DrawnHit((x, 0.0), "wall"),))), fill="hit")[1:])  # fmt: skip
    assert top >= 0
    plain = view_of(Frame(FLOOR, (ROBOT,), 0.0, hits=(DrawnHit((x, 3.0), ""),)))
    assert len(shapes(plain, fill="hit")) == 1
