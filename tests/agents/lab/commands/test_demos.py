import re

import pytest
from helpers.command_line import command, refusal, without_display
from matplotlib.backend_bases import KeyEvent
from PIL import Image

from agents.lab.commands.demos import (
    DEMOS,
    STILLS,
    bump,
    cbs,
    delivery,
    head_on,
    lanes,
    load,
    pibt,
    ring,
    slip,
)
from agents.lab.console import output
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.replay import replay_of_tracks
from warehouse_core.viz.sheet import LEGEND_WIDTH


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
    assert demo.beside.ending == "not delivered"
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


@pytest.mark.parametrize("make", [bump, head_on, ring])
def test_a_single_step_is_in_seconds_from_0_beside_a_large_map(make):
    figure = replay_of_tracks(make().track, window=False).figure
    floor, speed, energy = figure.axes
    assert speed.get_xlabel() == "seconds"
    assert speed.get_ylim()[0] == energy.get_ylim()[0] == 0
    beside_legend = 1 - LEGEND_WIDTH / figure.get_figwidth()
    assert floor.get_window_extent().width > 0.55 * beside_legend * figure.bbox.width
    assert figure.get_figwidth() <= 13.66


@pytest.mark.parametrize("name", ["load", "head-on", "cbs"])
def test_every_demo_is_one_command_and_one_picture(name, tmp_path, capsys):
    target = tmp_path / f"{name}.png"
    result = command(capsys, "demo", name, "--save", target)
    assert (result.code, "saved" in result.out) == (0, True)
    with Image.open(target) as image:
        assert len(image.convert("RGB").getcolors(1 << 20)) > 10


def test_without_a_display_the_animation_goes_to_a_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setenv("MPLBACKEND", "agg")
    assert "demo-bump.gif" in command(capsys, "demo", "bump").out
    with Image.open(tmp_path / "demo-bump.gif") as image:
        assert image.n_frames > 20


@pytest.mark.parametrize("name", ["demo-cbs.gif", "demo-cbs.html", "demo-cbs"])
def test_a_picture_has_no_frames_to_save(name, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(STILLS, "cbs", lambda: pytest.fail("computed before the check"))
    error = refusal(capsys, "demo", "cbs", "--save", tmp_path / name)
    assert name in error
    assert ".svg" in error


def test_a_picture_is_saved_as_svg_and_opens_no_window(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(output, "has_display", lambda: pytest.fail("a window was asked for"))
    target = tmp_path / "tree.svg"
    assert command(capsys, "demo", "cbs", "--save", target).code == 0
    assert target.read_text(encoding="utf-8").startswith("<?xml")


def test_a_picture_is_shown_in_a_window_that_q_closes(monkeypatch, capsys):
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
    assert "q closes the window" in command(capsys, "demo", "cbs").out
    assert len(figures) == 1
    assert plt.get_fignums() == []


def test_without_a_display_a_picture_goes_to_a_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    without_display(monkeypatch)
    out = command(capsys, "demo", "cbs").out
    assert "so the picture goes to a file\nsaved demo-cbs.png" in out
    assert (tmp_path / "demo-cbs.png").exists()


def test_without_a_name_the_demos_are_listed(capsys):
    lines = command(capsys, "demo").out.splitlines()
    assert [line.split()[0] for line in lines] == [*DEMOS, *STILLS]
    assert "A robot runs into a wall" in lines[1]


def test_no_demo_to_save_and_an_unknown_one_are_named(capsys, tmp_path):
    words = ("demo", "--save", tmp_path / "a.gif")
    assert "--save is of a demo; allowed: delivery" in refusal(capsys, *words, code=2)
    assert "no demo is called 'ballet'; allowed: " in refusal(capsys, "demo", "ballet", code=2)
