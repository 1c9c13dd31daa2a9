"""Animated drawings, sampled at the time of each frame as SMIL defines it."""

import math
import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from helpers.fleets import fleet_episode
from helpers.pictures import HOSTILE_NAMES, named, replay_of, short_episode

from agents.lab.commands.run import run_episode
from warehouse_core import EpisodeRecorder, FleetEpisode, Layout, WarehouseEnv
from warehouse_core.errors import FormatError
from warehouse_core.records.plans import StepPlans
from warehouse_core.render.atlas import UNSEEN
from warehouse_core.viz.svg import animated_svg, drawing
from warehouse_core.viz.svg.drawing import REST_SECONDS
from warehouse_core.viz.tracks.history import skids_of
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import (
    CONTINUOUS_FRAMES,
    INTERVAL_MS,
    Frame,
    Marks,
    Pose,
    Push,
    Track,
)
from warehouse_core.wording import seconds_of

SVG = "{http://www.w3.org/2000/svg}"
Element = ElementTree.Element


class Drawing:
    """A drawing of one track, sampled at a frame."""

    def __init__(self, track: Track) -> None:
        self.text = animated_svg([track])
        root = ElementTree.fromstring(self.text)
        self.moves, self.rests = (
            next(each for each in root.iter(f"{SVG}g") if each.get("class") == name)
            for name in ("moves", "rests")
        )
        seconds = INTERVAL_MS / 1000 / (CONTINUOUS_FRAMES if track.is_continuous else 1)
        self.frames = len(track) + round(REST_SECONDS / seconds)

    def shown(self, frame: int) -> Iterator[tuple[Element, dict[str, Any]]]:
        """Yield the elements that are seen in a frame, and their attributes by then.

        The attribute ``at`` has the numbers of all moves and turns around an element.
        """
        yield from self._shown(self.moves, frame, ())

    def texts(self, frame: int) -> list[str]:
        return [
            "".join(each.itertext()) for each, _ in self.shown(frame) if each.tag == f"{SVG}text"
        ]

    def _shown(
        self, element: Element, frame: int, around: tuple[tuple[float, ...], ...]
    ) -> Iterator[tuple[Element, dict[str, Any]]]:
        attributes: dict[str, Any] = dict(element.attrib)
        for each in element:
            if each.tag in (f"{SVG}animate", f"{SVG}animateTransform"):
                attributes[each.attrib["attributeName"]] = self._sample(each, frame)
        transform = attributes.get("transform")
        if transform is not None:
            numbers = transform if isinstance(transform, list) else _numbers(transform)
            around = (*around, tuple(numbers))
        if attributes.get("opacity") in ([0.0], "0"):
            return
        yield element, attributes | {"at": around}
        for each in element:
            if not each.tag.startswith(f"{SVG}animate"):
                yield from self._shown(each, frame, around)

    def _sample(self, animation: Element, frame: int) -> list[float]:
        times = [float(time) for time in animation.attrib["keyTimes"].split(";")]
        values = [_numbers(value) for value in animation.attrib["values"].split(";")]
        assert len(times) == len(values)
        assert times == sorted(times)
        assert times[0] == 0
        now = frame / self.frames + 1e-6
        place = bisect_right(times, now + 0.01 / self.frames) - 1
        if animation.get("calcMode") == "discrete":
            return values[place]
        assert times[-1] == 1, "times of an animation that glides end with the round"
        share = (now - times[place]) / (times[place + 1] - times[place])
        pairs = zip(values[place], values[place + 1], strict=True)
        return [before + share * (after - before) for before, after in pairs]


def _numbers(text: str) -> list[float]:
    return [float(number) for number in re.findall(r"-?\d*\.?\d+(?:e-?\d+)?", text)]


def places(shown: Drawing, frame: int, look: str) -> list[tuple[float, ...]]:
    """Return the innermost places of the discs and the chassis of a colour, in cells."""
    return [
        tuple(part / 100 for part in [at for at in attributes["at"] if len(at) == 2][-1])
        for _, attributes in shown.shown(frame)
        if attributes.get("class") == f"{look} of-rim"
    ]


def classes(shown: Drawing, frame: int) -> list[str]:
    """Return the classes of all that is seen in a frame."""
    return [str(attributes.get("class")) for _, attributes in shown.shown(frame)]


def near(found: Sequence[tuple[float, ...]], expected: Sequence[tuple[float, float]]) -> bool:
    found = sorted(tuple(round(2 * part) for part in each) + each for each in found)
    expected = sorted((*(round(2 * part) for part in each), *each) for each in expected)
    return [*found] == [pytest.approx(each, abs=0.03) for each in expected]


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_the_robot_its_load_battery_and_words_are_those_of_each_frame(backend: str) -> None:
    track = track_of_record(run_episode("greedy", backend, seed=12))
    shown = Drawing(track)
    assert len(shown.text) < 150_000
    for number in [*range(0, len(track), 7), len(track) - 1]:
        frame = track.frames[number]
        [pose] = frame.robots
        assert pose is not None
        assert near(places(shown, number, "loaded" if pose.loaded else "robot"), [pose.at])
        assert places(shown, number, "robot" if pose.loaded else "loaded") == []
        words = shown.texts(number)
        assert words.count("r" if pose.loaded else "R") == (not track.is_continuous)
        level = track.metrics["battery"][track.step_at(number)]
        assert f"battery {level:g} of 200" in words
        assert not frame.caption or " ".join(words).count(frame.caption.split(";")[0]) == 1
        assert ("DELIVERED" in words) == (number == len(track) - 1)
        counter = f"{seconds_of(frame.clock)} s" if track.is_continuous else f"step {number} of 23"
        assert counter in words
        [bar] = [all_of for each, all_of in shown.shown(number) if all_of.get("class") == "battery"]
        width = bar["width"] if isinstance(bar["width"], list) else _numbers(bar["width"])
        assert width == pytest.approx([130 * level / 200], abs=1.2)


def test_robots_of_a_fleet_have_their_places_numbers_and_orders_in_each_frame() -> None:
    episode = fleet_episode(max_steps=40)
    assert isinstance(episode, FleetEpisode)
    track = track_of_record(episode)
    shown = Drawing(track)
    for number in range(0, len(track), 3):
        frame = track.frames[number]
        assert frame.fleet is not None
        robots = frame.robots[: episode.robots]
        for loaded, look in ((False, "robot"), (True, "loaded")):
            there = [pose.at for pose in robots if pose is not None and pose.loaded == loaded]
            assert near(places(shown, number, look), there)
        words = shown.texts(number)
        assert {str(robot) for robot in range(episode.robots)} <= {*words}
        assert sum(word == "H" for word in words) == len(frame.robots) - episode.robots
        boxes = [
            (attributes["class"], attributes["width"])
            for _, attributes in shown.shown(number)
            if re.match(r"(order-[a-z-]+|item) of-rim", str(attributes.get("class")))
        ]
        carried = sum(age is not None for age in frame.fleet.items)
        assert sum(width == "28" for _, width in boxes) == carried
        assert sum(width == "36" for _, width in boxes) == len(frame.fleet.waiting)
    assert any(frame.fleet and frame.fleet.waiting for frame in track.frames)


@pytest.mark.parametrize(("robots", "size"), [(1, 37), (10, 37), (11, 34), (101, 23)])
def test_all_numbers_of_a_fleet_are_as_large_as_the_longest_can_be(robots: int, size: int) -> None:
    layout = Layout(["." * 21] * 7)
    episode = fleet_episode(layout=layout, robots=robots, people=0, orders=None, max_steps=1)
    shown = Drawing(track_of_record(episode)).shown(0)
    sizes = {each.text: a.get("font-size") for each, a in shown if each.tag == f"{SVG}text"}
    assert {sizes[str(robot)] for robot in range(robots)} == {str(size)}


def test_an_empty_battery_and_a_low_one_are_told() -> None:
    track = track_of_record(fleet_episode(max_steps=40, battery=12))
    shown, last = Drawing(track), len(track) - 1
    fleet = track.frames[-1].fleet
    assert fleet is not None
    assert len(places(shown, last, "stranded")) == sum(level <= 0 for level in fleet.battery) > 0
    assert classes(shown, last).count("warning") == sum(level < 0.25 for level in fleet.battery)


def test_a_wide_floor_has_neither_lines_nor_names_and_few_batteries_but_its_ice() -> None:
    layout = Layout(["P" + "." * 49, "." * 50, "#" + "." * 49, "." * 50])
    track = track_of_record(fleet_episode(layout=layout, robots=13, orders=None, max_steps=2))
    many = fleet_episode(layout=Layout(["P" + "." * 69]), robots=2, orders=None, max_steps=1)
    track.slippery = ((1, 1), (2, 0))
    shown = Drawing(track)
    assert len(places(shown, 1, "robot")) == 13
    assert not {"1", "12"} & {*shown.texts(1)}
    assert Drawing(track_of_record(many)).texts(0).count("P") == 0
    looks = ("of-line", "battery", "ice")
    assert [classes(shown, 1).count(look) for look in looks] == [0, 0, 1]
    few = Drawing(track_of_record(fleet_episode(layout=layout, orders=None, max_steps=2)))
    assert classes(few, 1).count("battery") == 4


def test_a_robot_that_is_not_there_yet_is_not_seen() -> None:
    poses = (None, Pose((0.5, 0.5), None, False), Pose((1.5, 0.5), None, False))
    frames = [Frame(("..",), (pose, None), float(n)) for n, pose in enumerate(poses)]
    shown = Drawing(Track(frames, {}))
    assert [len(places(shown, number, "robot")) for number in range(3)] == [0, 1, 1]


def test_hits_plans_and_pushes_are_seen_only_in_their_frames() -> None:
    track = track_of_record(fleet_episode(max_steps=4))
    fleet = track.frames[2].fleet
    assert fleet is not None
    plans = StepPlans({0: [(1, 1), (1, 2)]}, {0: [(1, 2), (1, 3)]}, {0: 1})
    track.frames[2].fleet = fleet._replace(plans=plans)
    shown = Drawing(track)
    looks = ("plan of-ink", "plan dots of-ink", "rim of-light")
    seen = [classes(shown, number) for number in range(len(track))]
    counts = [[found.count(look) for look in looks] for found in seen]
    assert counts == [[0, 0, 0], [0, 0, 0], [1, 1, 1], [0, 0, 0], [0, 0, 0]]
    pushed, pusher = (pose.at for pose in track.frames[2].robots[:2] if pose is not None)
    [arrow] = [a["at"] for _, a in shown.shown(2) if a.get("class") == "rim of-light"]
    middle = [50 * sum(pair) for pair in zip(pushed, pusher, strict=True)]
    assert arrow[-1][:2] == pytest.approx(middle, abs=0.5)
    bumps = Drawing(track_of_record(short_episode()))
    stars = [classes(bumps, number).count("hit of-rim") for number in range(7)]
    assert stars == [len(frame.hits) for frame in track_of_record(short_episode()).frames]
    assert sum(stars) == 1


def test_what_is_not_seen_yet_is_covered_until_it_is_and_a_plan_is_dotted() -> None:
    rows = ("####", "#P.#", "#..#", "####")
    hidden = ("####", "#?.#", "#?.#", "####")
    half = ("####", "#P.#", "#?.#", "####")
    pose = Pose((2.5, 1.5), None, True)
    frames = [Frame(tiles, (pose,), float(n)) for n, tiles in enumerate((hidden, half, rows, half))]
    frames[1].route = ((2.5, 1.5), (1.5, 1.5))
    shown = Drawing(Track(frames, {}))
    covered = [
        "".join(a["d"] for _, a in shown.shown(n) if a.get("class") == "unseen").count("M")
        for n in range(4)
    ]
    assert covered == [sum(line.count(UNSEEN) for line in frame.tiles) for frame in frames]
    assert classes(shown, 2).count("item of-rim") == 1, "the robot came with it, and none waits"
    dots = [classes(shown, n).count("plan dots of-ink") for n in range(4)]
    assert dots == [0, 1, 0, 0]


def test_the_marks_of_a_search_come_at_their_times() -> None:
    rows = ("....", "....")
    marks = Marks(
        (0, 1, 1, 2), ((0, 0), (0, 0), (0, 1), (0, 0)), (0, 1, 0, 1),
        ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), ("red", "blue"), ((0, 0), (1, 3)),
    )  # fmt: skip
    frames = [Frame(rows, (), float(n), clock=float(n)) for n in range(3)]
    shown = Drawing(Track(frames, {}, marks=marks))
    colors = [
        {a["fill"]: a["d"].count("M") for _, a in shown.shown(n) if str(a.get("fill"))[0] == "#"}
        for n in range(3)
    ]
    assert colors == [{"#ff0000": 1}, {"#0000ff": 1, "#ff0000": 1}, {"#0000ff": 1, "#ff0000": 1}]
    assert {"S", "G"} <= {*shown.texts(0)}


def test_a_drawing_is_one_safe_file_whatever_is_in_its_names() -> None:
    for name in HOSTILE_NAMES:
        text = animated_svg([track_of_record(named(name))], title=name)
        assert {each.tag for each in ElementTree.fromstring(text).iter()} <= {
            f"{SVG}{tag}" for tag in (
                "svg", "title", "style", "g", "rect", "path", "text", "tspan", "circle", "polyline",
                "polygon", "clipPath", "animate", "animateTransform",
            )
        }  # fmt: skip
        assert not re.search(r"href|url\((?!#floor)|@import", text)


def test_who_prefers_less_motion_sees_the_frame_of_a_still() -> None:
    track = track_of_record(run_episode("greedy", "physics", seed=12))
    shown = Drawing(track)
    assert "@media (prefers-reduced-motion:reduce)" in shown.text
    tags = {each.tag for each in shown.rests.iter()}
    assert f"{SVG}text" in tags
    assert not tags & {f"{SVG}animate", f"{SVG}animateTransform"}
    words = ["".join(each.itertext()) for each in shown.rests.iter(f"{SVG}text")]
    assert "DELIVERED" in words


def test_several_tracks_are_side_by_side_and_then_below_each_other() -> None:
    track = track_of_record(short_episode())
    sizes = [
        _numbers(animated_svg([track] * count).split('viewBox="')[1][:30]) for count in (1, 2, 4, 5)
    ]
    (one, two, four, five) = [(width, height) for _, _, width, height, *_ in sizes]
    assert two[0] > 1.9 * one[0]
    assert two[1] == one[1]
    assert four[0] == two[0]
    assert four[1] > 1.8 * two[1]
    assert five[0] > 1.3 * four[0], "five are three and two"
    assert five[1] <= four[1]


def test_a_drawing_that_would_be_too_large_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawing, "MAX_SVG_BYTES", 5_000)
    with pytest.raises(
        FormatError, match=r"MAX_SVG_BYTES = 5,000 bytes: it has 7 frames; .*\.html"
    ):
        animated_svg([track_of_record(short_episode())])


def test_a_replay_is_saved_as_a_moving_drawing_or_a_still_one(tmp_path: Path) -> None:
    replay = replay_of(short_episode(), speed=2)
    replay.save(tmp_path / "moves.svg")
    replay.save(tmp_path / "still.svg", still=True)
    moves, still = (tmp_path.joinpath(f"{name}.svg").read_text() for name in ("moves", "still"))
    assert "<animateTransform" in moves
    assert "<animate" not in still
    assert 'dur="2.55s"' in moves, "seven frames and a rest, at twice the speed"
    with pytest.raises(TypeError, match="still is 1"):
        replay.save(tmp_path / "x.svg", still=1)  # type: ignore[arg-type]


# Bodies.


@pytest.mark.parametrize("drive", ["omnidirectional", "differential"])
def test_a_body_has_its_drive_arrows_and_brake_light_in_each_frame(drive: str) -> None:
    track = track_of_record(run_episode("greedy", f"physics:drive={drive}", seed=12))
    shown = Drawing(track)
    for number in range(0, 60, 4):
        [pose] = track.frames[number].robots
        assert pose is not None
        seen = classes(shown, number)
        assert seen.count("rim") == (2 if drive == "differential" else 0), "wheels"
        assert seen.count("of-rim ring") == (drive == "omnidirectional")
        push = pose.push or Push((0.0, 0.0), (0.0, 0.0))
        assert seen.count("brake of-light") == push.brakes
        for name, scale in (("velocity", 0.7), ("force", 0.011)):
            lines = [a for _, a in shown.shown(number) if a.get("class") == f"of-{name}"]
            along = getattr(push, name)
            length = scale * math.hypot(*along)
            assert len(lines) == (length > 0.06)
            for line in lines:
                tip = [value[0] if isinstance(value, list) else float(value)
                       for value in (line["x2"], line["y2"])]  # fmt: skip
                expected = [100 * (0.3 + length) * part / math.hypot(*along) for part in along]
                assert tip == pytest.approx(expected, abs=3)


def test_skid_marks_appear_at_the_end_of_their_step_and_stay() -> None:
    track = track_of_record(run_episode("greedy", "physics:grip=0.05", seed=12, max_steps=6))
    shown = Drawing(track)
    frames = [track.frames[number] for number, _ in skids_of(track.frames, 0)]
    ends = sorted({math.ceil(frame.progress) for frame in frames})
    assert len(ends) > 2
    marks = [classes(shown, end).count("of-dark skid") for end in track.ends]
    assert marks == [sum(step <= now for step in ends) for now in range(track.steps + 1)]


def test_a_hit_has_the_size_and_the_words_of_its_impulse() -> None:
    env = WarehouseEnv(backend="physics")
    env.reset()
    recorder = EpisodeRecorder(env, seed=None)
    recorder.step("N")
    track = track_of_record(recorder.episode)
    number, [hit] = next((n, frame.hits) for n, frame in enumerate(track.frames) if frame.hits)
    assert hit.label == "28 N·s"
    hit = replace(hit, size=1.6)
    track.frames[number].hits = (hit,)
    shown = Drawing(track)
    assert "28 N·s" in shown.texts(number)
    [words] = [a for each, a in shown.shown(number) if each.text == "28 N·s"]
    assert float(words["y"]) == pytest.approx(100 * hit.at[1] - 1.6 * 32, abs=1)
    [star] = [a for _, a in shown.shown(number) if a.get("class") == "hit of-rim"]
    *_, (x, y, size) = star["at"]
    assert (x / 100, y / 100, size) == pytest.approx((*hit.at, hit.size), abs=0.01)


def test_a_robot_on_the_grid_jumps_and_a_ghost_too() -> None:
    track = track_of_record(run_episode("greedy", "grid", seed=12, max_steps=3))
    track.ghost = [(step + 0.5, 0.5) for step in range(len(track))]
    root = ElementTree.fromstring(animated_svg([track]))
    moves = [each for each in root.iter() if each.tag.startswith(f"{SVG}animate")]
    assert moves
    assert {each.get("calcMode") for each in moves} == {"discrete"}
    shown = Drawing(track)
    ghosts = [[a["at"][-1] for _, a in shown.shown(n) if a.get("class") == "ghost of-ink"]
              for n in range(len(track))]  # fmt: skip
    assert ghosts == [[(100 * n + 50, 50)] for n in range(len(track))]
