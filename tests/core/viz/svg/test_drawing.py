"""Animated drawings, sampled at the time of each frame as SMIL defines it."""

import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from helpers.fleets import fleet_episode
from helpers.pictures import HOSTILE_NAMES, named, replay_of, short_episode

from agents.lab.commands.run import run_episode
from warehouse_core import FleetEpisode
from warehouse_core.errors import FormatError
from warehouse_core.viz.svg import animated_svg, drawing
from warehouse_core.viz.svg.drawing import REST_SECONDS
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import CONTINUOUS_FRAMES, INTERVAL_MS, Track
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
        for (_, box), (above, _) in pairwise(shown.shown(number)):
            assert box.get("width") != "36" or above.tag == f"{SVG}text", "no box is on its number"
    assert any(frame.fleet and frame.fleet.waiting for frame in track.frames)


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
