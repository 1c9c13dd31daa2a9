import re

import pytest
from PIL import Image

from agents import cli
from agents.commands.demos import bump, cbs, delivery, head_on, lanes, load, pibt, ring, slip
from agents.console.main import main
from warehouse_core.viz.figure import make_figure


def run(*arguments: str) -> int:
    with pytest.raises(SystemExit) as ended:
        main(cli.app, arguments)
    return ended.value.code or 0


def places_of(track, robot=0):
    return [frame.robots[robot].at for frame in track.frames]


def test_the_delivery_delivers():
    demo = delivery()
    assert demo.track.ending == "delivered"
    assert demo.said.startswith("delivered in 23 steps")


def test_the_bump_flashes_with_its_impulse_and_goes_back():
    track = bump().track
    hits = [hit for frame in track.frames for hit in frame.hits]
    assert hits
    assert all("N·s" in hit.label for hit in hits)
    places = places_of(track)
    assert places[-1] == pytest.approx(places[0], abs=1e-3)
    assert min(x for x, _ in places) == pytest.approx(1.35, abs=0.02)


def test_a_load_makes_the_same_route_slower_and_costlier():
    demo = load()
    empty, loaded = demo.track, demo.beside
    assert not empty.frames[0].robots[0].loaded
    assert loaded.frames[0].robots[0].loaded
    assert loaded.frames[-1].clock > empty.frames[-1].clock
    assert loaded.frames[-1].energy > empty.frames[-1].energy
    assert places_of(loaded)[-1] == pytest.approx(places_of(empty)[-1], abs=1e-3)


def test_the_plan_fails_on_the_slippery_floor():
    demo = slip()
    assert demo.track.ending == "delivered"
    assert demo.beside.ending != "delivered"
    assert "slippery" in demo.beside.title


def test_the_two_robots_meet_and_both_go_back():
    track = head_on().track
    left, right = places_of(track), places_of(track, 1)
    gap = min(b[0] - a[0] for a, b in zip(left, right, strict=True))
    assert gap == pytest.approx(0.7, abs=0.02)
    assert left[-1] == pytest.approx((2.5, 2.5), abs=1e-3)
    assert right[-1] == pytest.approx((3.5, 2.5), abs=1e-3)
    assert track.ending == "both blocked"
    assert track.frames[-1].clock < 3


def test_the_robots_of_a_ring_follow_each_other():
    track = ring().track
    before, after = ([pose.at for pose in track.frames[frame].robots] for frame in (0, -1))
    for robot in range(4):
        assert after[robot] == pytest.approx(before[(robot + 1) % 4], abs=1e-3)
    assert track.ending == "4 moved on"


def test_robots_push_each_other_only_to_cells_beside_them():
    frames = pibt().track.frames
    pushes = [(frame, pair) for frame in frames for pair in frame.fleet.plans.pushers.items()]
    assert len(pushes) > 50
    for frame, pair in pushes:
        (x, y), (to_x, to_y) = (frame.robots[robot].at for robot in pair)
        assert abs(x - to_x) + abs(y - to_y) == 1
    assert [*frames[0].fleet.plans.ways] == [0, 1, 2]


def test_the_optimal_plan_costs_more_than_the_ways_alone():
    assert cbs().said == "the ways alone cost 8, the optimal plan 11, found after 9 nodes"


def test_lanes_deliver_much_more_on_the_crowded_floor():
    picture = lanes()
    without, with_lanes, gain = re.findall(r"[\d,]+(?= del| with:)|[+-]\d+%", picture.said)
    assert int(with_lanes.replace(",", "")) > 1.4 * int(without.replace(",", ""))
    assert gain.startswith("+")
    texts = [text.get_text() for text in picture.draw(make_figure).texts]
    assert {"Without lanes", "With lanes", f"{without} deliveries an hour"} <= {*texts}


@pytest.mark.parametrize("name", ["load", "head-on", "cbs"])
def test_every_demo_is_one_command_and_one_picture(name, tmp_path, capsys):
    target = tmp_path / f"{name}.png"
    assert run("demo", name, "--save", str(target)) == 0
    assert "saved" in capsys.readouterr().out
    with Image.open(target) as image:
        assert len(image.convert("RGB").getcolors(1 << 20)) > 10


def test_without_a_display_the_animation_goes_to_a_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setenv("MPLBACKEND", "agg")
    assert run("demo", "bump") == 0
    with Image.open(tmp_path / "demo-bump.gif") as image:
        assert image.n_frames > 20
    assert "demo-bump.gif" in capsys.readouterr().out


def test_an_unknown_demo_is_one_line_with_the_names(capsys):
    assert run("demo", "ballet") == 2
    error = capsys.readouterr().err
    assert "ballet" in error
    assert "head-on" in error
    assert error.count("\n") == 1
