"""Animated drawings; ``system/test_drawing.py`` has them in a browser."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from helpers.pictures import HOSTILE_NAMES, named, replay_of, short_episode

from agents.lab.commands.run import run_episode
from warehouse_core.errors import FormatError
from warehouse_core.viz.svg import animated_svg, drawing
from warehouse_core.viz.tracks.record_track import track_of_record

SVG = "{http://www.w3.org/2000/svg}"


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
    text = animated_svg([track])
    assert "@media (prefers-reduced-motion:reduce)" in text
    groups = ElementTree.fromstring(text).iter(f"{SVG}g")
    rests = next(each for each in groups if each.get("class") == "rests")
    tags = {each.tag for each in rests.iter()}
    assert f"{SVG}text" in tags
    assert not tags & {f"{SVG}animate", f"{SVG}animateTransform"}
    words = ["".join(each.itertext()) for each in rests.iter(f"{SVG}text")]
    assert "DELIVERED" in words


def test_a_drawing_that_would_be_too_large_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawing, "MAX_SVG_BYTES", 5_000)
    with pytest.raises(
        FormatError, match=r"MAX_SVG_BYTES = 5,000 bytes: it has 7 frames; .*\.html"
    ):
        animated_svg([track_of_record(short_episode())])


def test_a_replay_is_saved_as_a_moving_drawing(tmp_path: Path) -> None:
    replay_of(short_episode(), speed=2).save(tmp_path / "moves.svg")
    moves = (tmp_path / "moves.svg").read_text()
    assert "<animateTransform" in moves
    assert 'dur="2.55s"' in moves, "seven frames and a rest, at twice the speed"
