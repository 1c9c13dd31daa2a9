"""The signs of the legend, by what the frames of a track have."""

from typing import Any

from warehouse_core.render.palette import LOOK, PALETTE
from warehouse_core.viz.tracks.signs import look_of, signs_of
from warehouse_core.viz.tracks.track import Frame, Pose, Track

FLOOR = ("...", "...", "...")
ROBOT = "R robot (empty)"
LOADED = "r robot (loaded)"


def at(x: int, y: int = 0, *, loaded: bool = False) -> Pose:
    return Pose((x + 0.5, y + 0.5), None, loaded)


def signs(
    *frames: tuple[Pose | None, ...], rows: tuple[str, ...] = FLOOR, **others: Any
) -> set[str]:
    """Return the words for a track of robots on ``rows``."""
    drawn = [Frame(rows, robots, float(step)) for step, robots in enumerate(frames)]
    return of_track(Track(drawn, {}, **others))


def of_track(track: Track) -> set[str]:
    return {words for _, words in signs_of(track)}


def test_robots_have_signs_by_what_they_carry_and_trails_by_what_they_carried() -> None:
    assert signs((at(0),), (at(0),)) == {ROBOT}
    assert signs((at(0),), (at(1),)) == {ROBOT, "trail, empty"}
    assert signs((at(0),), (at(1, loaded=True),)) == {ROBOT, LOADED, "item", "trail, empty"}
    assert signs((at(0, loaded=True),), (at(1, loaded=True),)) == {LOADED, "item", "trail, loaded"}
    assert signs((None,), (at(1),)) == {ROBOT}, "it has only come"


def test_cells_that_the_robot_comes_back_to_have_a_sign() -> None:
    there, back = (at(1),), (at(0),)
    assert "visited often" not in signs(back, there)
    assert "visited often" in signs(back, there, back)


def test_what_is_around_the_view_has_a_sign_if_there_is_a_robot() -> None:
    shaded = "outside the robot's view"
    assert shaded in signs((at(0),), view_radius=1)
    assert shaded not in signs((at(0),))
    assert shaded not in signs((), view_radius=1)


def test_tiles_have_signs_by_where_they_are() -> None:
    assert signs((), rows=("...", ".#.", "...")) == {"shelf"}
    assert signs((), rows=("#..", ".#.", "..?")) == {"wall", "shelf", "not seen yet"}
    assert signs((), rows=("PDC",)) == {"P pickup", "D dropoff", "C charger", "item"}
    taken = [Frame(("P",), (), 0.0), Frame((".",), (), 1.0)]
    assert "item" in of_track(Track(taken, {}))
    assert "item" not in of_track(Track(taken[::-1], {}))
    assert signs((), rows=(".#",), slippery=((0, 1), (7, 7))) == {"wall"}
    assert signs((), rows=(".#",), slippery=((0, 1), (0, 0))) == {"wall", "slippery floor"}


def test_all_signs_have_a_colour_of_the_palette_and_a_shape_that_exists() -> None:
    colors = PALETTE["light"].keys() | PALETTE["both"]
    assert LOOK["signs"].keys() <= {*LOOK["words"], *(f"order-{age}" for age in range(4))}
    for name in (*LOOK["words"], *LOOK["signs"]):
        _, color, shape = look_of(name)
        assert color in colors or color[0] == "#"
        assert shape in ("", *LOOK["shapes"])
