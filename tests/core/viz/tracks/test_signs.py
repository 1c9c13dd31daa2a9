"""The signs of the legend, by what the frames of a track have."""

from dataclasses import replace
from typing import Any

import pytest

from warehouse_core.records.plans import StepPlans
from warehouse_core.render.palette import LOOK, PALETTE
from warehouse_core.viz.tracks.signs import look_of, signs_of
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


def of_fleet(*fleets: FleetFrame, people: int = 0) -> set[str]:
    """Return the signs of frames of a fleet beside those of its robots."""
    frames = [
        Frame(FLOOR, (at(0),) * (len(fleet.battery) + people), float(step), fleet=fleet)
        for step, fleet in enumerate(fleets)
    ]
    return of_track(Track(frames, {})) - {"robot (empty)"}


def fleet(*battery: float, **others: Any) -> FleetFrame:
    return FleetFrame((), (None,) * len(battery), battery or (1.0,))._replace(**others)


def test_robots_have_signs_by_what_they_carry_and_trails_by_what_they_carried() -> None:
    assert signs((at(0),), (at(0),)) == {ROBOT}
    assert signs((at(0),), (at(1),)) == {ROBOT, "trail, empty"}
    assert signs((at(0),), (at(1, loaded=True),)) == {ROBOT, LOADED, "item", "trail, empty"}
    assert signs((at(0, loaded=True),), (at(1, loaded=True),)) == {LOADED, "item", "trail, loaded"}
    assert signs((at(0), None), (at(0), at(1))) == {ROBOT}, "one has only come"


@pytest.mark.parametrize("robots", [1, 2])
def test_cells_that_one_of_the_robots_comes_back_to_have_a_sign(robots: int) -> None:
    others = (at(2, 2),) * (robots - 1)
    there, back = (at(1), *others), (at(0), *others)
    assert "visited often" not in signs(back, there)
    assert "visited often" in signs(back, there, back)


def test_what_is_around_the_view_has_a_sign_if_one_robot_alone_sees() -> None:
    shaded = "outside the robot's view"
    assert shaded in signs((at(0),), view_radius=1)
    assert shaded not in signs((at(0),))
    assert shaded not in signs((at(0), at(1)), view_radius=1)


def test_tiles_have_signs_by_where_they_are() -> None:
    assert signs((), rows=("...", ".#.", "...")) == {"shelf"}
    assert signs((), rows=("#..", ".#.", "..?")) == {"wall", "shelf", "not seen yet"}
    assert signs((), rows=("PDC",)) == {"P pickup", "D dropoff", "C charger", "item"}
    taken = [Frame(("P",), (), 0.0), Frame((".",), (), 1.0)]
    assert "item" in of_track(Track(taken, {}))
    assert "item" not in of_track(Track(taken[::-1], {}))
    assert signs((), rows=(".#",), slippery=((0, 1), (7, 7))) == {"wall"}
    assert signs((), rows=(".#",), slippery=((0, 1), (0, 0))) == {"wall", "slippery floor"}


def test_hits_plans_and_searches_have_signs() -> None:
    hit = DrawnHit((0.0, 0.5), "wall")
    frames = [Frame(FLOOR, (at(0),), 0.0), Frame(FLOOR, (at(0),), 1.0, hits=(hit,))]
    assert of_track(Track(frames, {})) == {ROBOT, "hit"}
    frames[0].route = ((0.5, 0.5), (1.5, 0.5))
    assert "plan" in of_track(Track(frames, {}))
    marks = Marks([0], [(0, 0)], [0], [(1.0, 0.0, 0.0)], ["expanded"], ((0, 0), (0, 1)))
    track = Track([Frame(("PD.",), (), 0.0, route=frames[0].route)], {}, marks=marks)
    assert of_track(track) == {"expanded", "path", "S start, G goal"}
    assert signs_of(track)[0] == ("#ff0000", "expanded")


def test_bodies_have_signs_of_what_their_pictures_show() -> None:
    poses = [Pose((0.5, 0.5), 0.0, loaded) for loaded in (False, True)]
    pushes = (
        Push((1.0, 0.0), (0.0, 0.0)),
        Push((1.0, 0.0), (-9.0, 0.0)),
        Push((0.0, 0.0), (2.0, 0.0), skids=True),
    )
    pushed = [replace(poses[0], push=push) for push in pushes]
    words = [
        of_track(Track([Frame((".",), (pose,), 0.0)], {}, is_continuous=True))
        for pose in (*poses, *pushed)
    ]
    assert words == [
        {"robot (empty)"},
        {"robot (loaded)", "item"},
        {"robot (empty)", "velocity"},
        {"robot (empty)", "velocity", "force of the motor", "brake light"},
        {"robot (empty)", "force of the motor", "skid marks"},
    ]
    ghost = Track([Frame((".",), (poses[0],), 0.0)], {}, is_continuous=True, ghost=[(0.5, 0.5)])
    assert of_track(ghost) == {"robot (empty)", "ghost of the other robot"}


def test_all_signs_have_a_colour_of_the_palette_and_a_shape_that_exists() -> None:
    colors = PALETTE["light"].keys() | PALETTE["both"]
    assert LOOK["signs"].keys() <= {*LOOK["words"], *(f"order-{age}" for age in range(4))}
    for name in (*LOOK["words"], *LOOK["signs"]):
        _, color, shape = look_of(name)
        assert color in colors or color[0] == "#"
        assert shape in ("", *LOOK["shapes"])


def test_orders_of_a_fleet_have_signs_by_their_age() -> None:
    for age, words in enumerate(LOOK["ages"]):
        waits = fleet(waiting=(Waiting((0.5, 0.5), 2, age),))
        carried = fleet(1.0, 1.0, items=(None, age))
        for each in (waits, carried):
            assert of_fleet(fleet(), each) == {f"order, {words}"}


def test_people_and_batteries_of_a_fleet_have_signs() -> None:
    assert of_fleet(fleet(1.0, 0.25)) == set()
    assert of_fleet(fleet(1.0, 0.25), fleet(1.0, 0.24)) == {"battery low"}
    assert of_fleet(fleet(0.0, 1.0), fleet(1.0, 1.0)) == {"battery low", "battery empty"}
    assert of_fleet(fleet(1.0, 1.0), people=1) == {"person"}


@pytest.mark.parametrize(
    ("plans", "sign"),
    [
        (StepPlans(paths={0: [(0, 1), (0, 2)]}), "plan of a robot"),
        (StepPlans(wishes={0: [(0, 1)]}), "shortest path to the goal"),
        (StepPlans(pushers={0: 1}), "pushes another robot"),
    ],
)
def test_plans_of_a_fleet_have_a_sign_each(plans: StepPlans, sign: str) -> None:
    assert of_fleet(fleet(1.0, 1.0), fleet(1.0, 1.0, plans=plans)) == {sign}
