"""The legend of a picture; ``tracks/test_signs.py`` has what it explains."""

from matplotlib.colors import to_hex
from matplotlib.lines import Line2D

from warehouse_core.viz.legend import signs_of
from warehouse_core.viz.tracks.track import Frame, Marks, Pose, Track


def test_a_search_has_its_colours_and_weak_motors_have_a_dashed_outline() -> None:
    marks = Marks([0], [(0, 0)], [0], [(1.0, 0.0, 0.0)], ["expanded"], ((0, 0), (0, 1)))
    search = signs_of(Track([Frame(("..",), (), 0.0)], {}, marks=marks))
    assert [*search] == ["expanded", "S start, G goal"]
    expanded, ends = search.values()
    assert isinstance(expanded, Line2D)
    assert to_hex(expanded.get_markerfacecolor()) == "#ff0000"
    assert (expanded.get_marker(), ends.get_marker()) == ("s", "o")  # type: ignore[attr-defined]
    pose = Pose((0.5, 0.5), None, False)
    weak = signs_of(Track([Frame(("..",), (pose,), 0.0)], {}, motor_strength=0.5))
    assert [*weak] == ["R robot (empty)", "motors at 50%"]
    assert isinstance(weak["R robot (empty)"], Line2D)
