import math
import re
from itertools import pairwise

import pytest
from matplotlib.backend_bases import KeyEvent
from PIL import Image

from agents.lab.commands.demos import CROSSING_PLAN, DEMOS, STILLS, STOP
from agents.lab.console import output
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.replay import replay_of_tracks
from warehouse_core.viz.sheet import LEGEND_WIDTH


def places_of(track, robot=0):
    return [frame.robots[robot].at for frame in track.frames]


def test_the_delivery_delivers():
    demo = DEMOS["delivery"]()
    assert demo.tracks[0].ending == "delivered"
    assert demo.said.startswith("delivered in 23 steps")


def test_the_bump_flashes_with_its_impulse_and_goes_back():
    [track] = DEMOS["bump"]().tracks
    hits = [hit for frame in track.frames for hit in frame.hits]
    assert hits
    assert all("N·s" in hit.label for hit in hits)
    places = places_of(track)
    assert places[-1] == pytest.approx(places[0], abs=1e-3)
    assert min(x for x, _ in places) == pytest.approx(1.35, abs=0.02)


def test_a_load_makes_the_same_route_slower_and_costlier():
    empty, loaded = DEMOS["load"]().tracks
    assert not empty.frames[0].robots[0].loaded
    assert loaded.frames[0].robots[0].loaded
    assert loaded.frames[-1].clock > empty.frames[-1].clock
    assert loaded.frames[-1].energy > empty.frames[-1].energy
    assert places_of(loaded)[-1] == pytest.approx(places_of(empty)[-1], abs=1e-3)


def test_the_plan_fails_on_the_slippery_floor():
    plan, slipped = DEMOS["slip"]().tracks
    assert (plan.ending, slipped.ending) == ("delivered", "not delivered")
    assert "slippery" in slipped.title


def test_robots_behind_one_that_stops_wait_or_cross_before_it():
    demo = DEMOS["passing"]()
    kept, bent = map(float, re.findall(r"([\d.]+) s", demo.said))
    assert bent < STOP < kept
    ends = [[robot.at for robot in track.frames[-1].robots] for track in demo.tracks]
    cells = [(col + 0.5, row + 0.5) for row, col in CROSSING_PLAN[-1]]
    for places in ends:
        for place, cell in zip(places, cells, strict=True):
            assert place == pytest.approx(cell, abs=0.02)


def test_a_robot_on_two_wheels_turns_on_the_spot_before_it_drives_on():
    free, wheeled = DEMOS["wheels"]().tracks
    assert wheeled.frames[-1].clock > free.frames[-1].clock + 3 * 1.2
    assert places_of(wheeled)[-1] == pytest.approx(places_of(free)[-1], abs=1e-3)
    poses = [(*pose.at, pose.heading or 0.0) for pose in (it.robots[0] for it in wheeled.frames)]
    turns = [
        (x, y)
        for (x, y, heading), (_, _, later) in pairwise(poses)
        if abs(math.remainder(later - heading, math.tau)) > 0.02
    ]
    assert len(turns) > 10
    for x, y in turns:
        assert (x % 1, y % 1) == pytest.approx((0.5, 0.5), abs=0.02)


def test_the_two_robots_meet_and_both_go_back():
    [track] = DEMOS["head-on"]().tracks
    left, right = places_of(track), places_of(track, 1)
    gap = min(b[0] - a[0] for a, b in zip(left, right, strict=True))
    assert gap == pytest.approx(0.7, abs=0.02)
    assert left[-1] == pytest.approx((2.5, 2.5), abs=1e-3)
    assert right[-1] == pytest.approx((3.5, 2.5), abs=1e-3)
    assert track.ending == "both blocked"
    assert track.frames[-1].clock < 3


def test_the_robots_of_a_ring_follow_each_other():
    [track] = DEMOS["ring"]().tracks
    before, after = ([pose.at for pose in track.frames[frame].robots] for frame in (0, -1))
    for robot in range(4):
        assert after[robot] == pytest.approx(before[(robot + 1) % 4], abs=1e-3)
    assert track.ending == "4 moved on"


def test_robots_push_each_other_only_to_cells_beside_them():
    frames = DEMOS["pibt"]().tracks[0].frames
    pushes = [(frame, pair) for frame in frames for pair in frame.fleet.plans.pushers.items()]
    assert len(pushes) > 50
    for frame, pair in pushes:
        (x, y), (to_x, to_y) = (frame.robots[robot].at for robot in pair)
        assert abs(x - to_x) + abs(y - to_y) == 1
    assert [*frames[0].fleet.plans.ways] == [0, 1, 2]


def test_the_optimal_plan_costs_more_than_the_ways_alone():
    assert STILLS["cbs"]().said == "the ways alone cost 9, the optimal plan 12, found after 8 nodes"


def test_lanes_deliver_much_more_on_the_crowded_floor():
    picture = STILLS["lanes"]()
    without, with_lanes, gain = re.findall(r"[\d,]+(?= del| with:)|[+-]\d+%", picture.said)
    assert int(with_lanes.replace(",", "")) > 1.4 * int(without.replace(",", ""))
    assert gain.startswith("+")
    texts = [text.get_text() for text in picture.draw(make_figure).texts]
    assert {"Without lanes", "With lanes", f"{without} deliveries an hour"} <= {*texts}


@pytest.mark.parametrize("name", ["bump", "head-on", "ring"])
def test_a_single_step_is_in_seconds_from_0_beside_a_large_map(name):
    figure = replay_of_tracks(*DEMOS[name]().tracks, window=False).figure
    floor, speed, energy = figure.axes
    assert speed.get_xlabel() == "seconds"
    assert speed.get_ylim()[0] == energy.get_ylim()[0] == 0
    beside_legend = 1 - LEGEND_WIDTH / figure.get_figwidth()
    assert floor.get_window_extent().width > 0.55 * beside_legend * figure.bbox.width
    assert figure.get_figwidth() <= 13.66


@pytest.mark.parametrize("name", ["load", "head-on"])
def test_every_demo_is_one_command_and_one_picture(name, tmp_path, warehouse):
    target = tmp_path / f"{name}.png"
    result = warehouse("demo", name, "--save", target)
    assert (result.code, "saved" in result.out) == (0, True)
    with Image.open(target) as image:
        assert len(image.convert("RGB").getcolors(1 << 20)) > 10


@pytest.mark.parametrize("name", ["demo-cbs.gif", "demo-cbs.html", "demo-cbs"])
def test_a_picture_has_no_frames_to_save(name, tmp_path, monkeypatch, refused):
    monkeypatch.setitem(STILLS, "cbs", lambda: pytest.fail("computed before the check"))
    error = refused("demo", "cbs", "--save", tmp_path / name)
    assert name in error
    assert ".svg" in error


def test_a_picture_is_shown_in_a_window_that_q_closes(monkeypatch, warehouse):
    import matplotlib.pyplot as plt

    figures = []

    def show():
        [number] = plt.get_fignums()
        figure = plt.figure(number)
        figures.append(figure)
        for key in ("x", "q"):
            assert plt.get_fignums() == [number]
            event = KeyEvent("key_press_event", figure.canvas, key)
            figure.canvas.callbacks.process("key_press_event", event)

    monkeypatch.setattr(output, "has_display", lambda: True)
    monkeypatch.setattr(plt, "show", show)
    plt.switch_backend("agg")
    assert "q closes the window" in warehouse("demo", "cbs").out
    assert len(figures) == 1
    assert plt.get_fignums() == []


def test_without_a_name_the_demos_are_listed(warehouse):
    lines = warehouse("demo").out.splitlines()
    assert [line.split()[0] for line in lines] == [*DEMOS, *STILLS]
    assert "A robot runs into a wall" in lines[1]


def test_demos_of_bodies_need_their_backend(install, refused):
    install()
    assert "no backend is called 'physics'" in refused("demo", "wheels", "--no-show")
