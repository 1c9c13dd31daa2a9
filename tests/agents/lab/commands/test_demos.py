import math
import re
from itertools import pairwise

import pytest
from PIL import Image

from agents.lab.commands.demos import DEMOS


def places_of(track, robot=0):
    return [frame.robots[robot].at for frame in track.frames]


def test_the_bump_flashes_with_its_impulse_and_goes_back():
    [track] = DEMOS["bump"]().tracks
    hits = [hit for frame in track.frames for hit in frame.hits]
    assert hits
    assert all("N·s" in hit.label for hit in hits)
    places = places_of(track)
    assert places[-1] == pytest.approx(places[0], abs=1e-3)
    assert min(x for x, _ in places) == pytest.approx(1.35, abs=0.02)


def test_the_plan_fails_on_the_slippery_floor():
    plan, slipped = DEMOS["slip"]().tracks
    assert (plan.ending, slipped.ending) == ("delivered", "not delivered")
    assert "slippery" in slipped.title


def test_a_robot_with_two_wheels_turns_on_the_spot_before_it_drives_on():
    free, wheeled = DEMOS["wheels"]().tracks
    assert wheeled.frames[-1].clock > free.frames[-1].clock + 3 * 1.2
    assert places_of(wheeled)[-1] == pytest.approx(places_of(free)[-1], abs=1e-3)
    poses = [(*pose.at, pose.heading or 0.0) for pose in (it.robots[0] for it in wheeled.frames)]
    turns = [
        (x % 1, y % 1)
        for (x, y, heading), (_, _, later) in pairwise(poses)
        if abs(math.remainder(later - heading, math.tau)) > 0.02
    ]
    assert len(turns) > 10
    assert turns == [pytest.approx((0.5, 0.5), abs=0.02)] * len(turns)


def test_robots_push_each_other_only_to_cells_beside_them():
    frames = DEMOS["pibt"]().tracks[0].frames
    pushes = [(frame, pair) for frame in frames for pair in frame.fleet.plans.pushers.items()]
    assert len(pushes) > 50
    for frame, pair in pushes:
        (x, y), (to_x, to_y) = (frame.robots[robot].at for robot in pair)
        assert abs(x - to_x) + abs(y - to_y) == 1
    assert [*frames[0].fleet.plans.paths] == [0, 1, 2]


def test_lanes_deliver_much_more_on_the_crowded_floor():
    picture = DEMOS["lanes"]()
    without, with_lanes, gain = re.findall(r"[\d,]+(?= del| with lanes:)|[+-]\d+%", picture.result)
    assert int(with_lanes.replace(",", "")) > 1.4 * int(without.replace(",", ""))
    assert gain.startswith("+")
    texts = [text.get_text() for text in picture.draw().texts]
    assert {"Without lanes", "With lanes", f"{without} deliveries per hour"} <= {*texts}


def test_a_demo_is_one_command_and_one_picture(tmp_path, warehouse):
    target = tmp_path / "slip.png"
    result = warehouse("demo", "slip", "--save", target)
    assert (result.code, "saved" in result.out) == (0, True)
    with Image.open(target) as image:
        assert len(image.convert("RGB").getcolors(1 << 20)) > 10


@pytest.mark.parametrize("name", ["demo-lanes.gif", "demo-lanes.html", "demo-lanes"])
def test_a_picture_has_no_frames_to_save(name, tmp_path, monkeypatch, refused):
    monkeypatch.setitem(DEMOS, "lanes", lambda: pytest.fail("computed before the check"))
    error = refused("demo", "lanes", "--save", tmp_path / name)
    assert name in error
    assert ".svg" in error


def test_without_a_name_the_demos_are_listed(warehouse):
    lines = warehouse("demo").out.splitlines()
    assert [line.split()[0] for line in lines] == [*DEMOS]
    assert "A robot runs into a wall" in lines[0]


def test_demos_of_bodies_need_their_backend(install, refused):
    install()
    assert "no backend is called 'physics'" in refused("demo", "slip", "--no-show")
