"""The legend of a picture; ``tracks/test_signs.py`` has what it explains."""

from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from warehouse_core.render.palette import COLORS, LOOK
from warehouse_core.viz.legend import LINES, MARKERS, PATCHES, signs_of
from warehouse_core.viz.tracks.track import Frame, Marks, Pose, Track


def test_all_words_have_one_look() -> None:
    looks = [*LINES, *MARKERS, *PATCHES, *COLORS]
    assert [name for name in LOOK["words"] if looks.count(name) != 1] == ["R", "r", "H"]


def test_a_search_has_its_colours_and_weak_motors_have_a_dashed_outline() -> None:
    marks = Marks([0], [(0, 0)], [0], [(1.0, 0.0, 0.0)], ["expanded"], ((0, 0), (0, 1)))
    search = signs_of(Track([Frame(("..",), (), 0.0)], {}, marks=marks))
    assert [*search] == ["expanded", "S start, G goal"]
    assert isinstance(search["expanded"], Rectangle)
    assert to_hex(search["expanded"].get_facecolor()) == "#ff0000"
    pose = Pose((0.5, 0.5), None, False)
    weak = signs_of(Track([Frame(("..",), (pose,), 0.0)], {}, motor_strength=0.5))
    assert [*weak] == ["R robot (empty)", "motors at 50%"]
    assert isinstance(weak["R robot (empty)"], Line2D)
