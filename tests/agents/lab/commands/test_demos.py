import re

import pytest

from agents.lab.commands.demos import DEMOS


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
