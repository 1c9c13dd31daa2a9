"""What Python packs, JavaScript reads: run by node."""

import json
import math
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.fleets import fleet_episode
from helpers.pages import HOSTILE

from warehouse_core import Episode, FleetEpisode, WarehouseEnv, record_episode
from warehouse_core.viz.player.tracks import Columns, packed
from warehouse_core.viz.tracks import Track, track_of_record
from warehouse_core.viz.tracks.track import Frame

pytestmark = pytest.mark.browser

FOLDER = Path(__file__).parent
TURN = 120


def said(block: str, *words: str) -> Any:
    """Return what the page makes of a packed block."""
    node = shutil.which("node")
    assert node is not None, "these tests need node: apt-get install nodejs"
    done = subprocess.run(
        [node, FOLDER / "told.mjs", *words],
        input=block,
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_whole_numbers_come_back_in_their_unit_with_and_without_differences() -> None:
    random = np.random.default_rng(3)
    columns, value, expected = Columns(), [], []
    for limit in (1, 127, 128, 32_767, 32_768, 2**30 - 1):
        for unit in (1, 1 / 2, 1 / 1024, 1e-3):
            for is_delta in (False, True):
                for count in (0, 1, 2, 57):
                    numbers = random.integers(-limit, limit, count, endpoint=True) * unit
                    value.append(columns.whole(numbers, is_delta=is_delta, unit=unit))
                    expected.append(numbers.tolist())
    assert said(columns.packed(value)) == expected


def test_real_numbers_come_back_in_single_precision_and_nan_among_them() -> None:
    numbers = [0.1, math.nan, -1e30, 2.5, math.nan]
    columns = Columns()
    value = {"odd": columns.whole([1, 2, 3]), "real": columns.real(numbers)}
    found = said(columns.packed(value))
    expected = ["NaN" if math.isnan(x) else float(np.float32(x)) for x in numbers]
    assert found == {"odd": [1, 2, 3], "real": expected}


def test_texts_come_back_letter_by_letter() -> None:
    texts = ["", "müde 🤖 \u202e\u2066", "$", '{"$": ["i1", 0, 1, 0, 1]}', *HOSTILE, "\0" * 3]
    columns = Columns()
    value = [*texts, columns.whole([1, 300])]
    assert said(columns.packed(value)) == [*texts, [1, 300]]


def check_frame(found: dict[str, Any], frame: Frame, index: int, unit: float) -> None:
    """Compare what the page knows of a frame with the frame."""
    assert found["frame"] == index
    assert found["step"] == math.ceil(frame.progress)
    assert found["caption"] == frame.caption
    assert found["tiles"] == "".join(frame.tiles)
    for body, pose in zip(found["bodies"], frame.robots, strict=True):
        assert pose is not None
        assert math.dist((body["x"], body["y"]), pose.at) <= unit
        assert (body["load"] > 0) == pose.loaded
        if pose.heading is None:
            assert body["heading"] is None
        else:
            turned = (body["heading"] - pose.heading) / (2 * math.pi)
            assert abs(turned - round(turned)) <= 0.51 / TURN
    assert [hit["label"] for hit in found["hits"]] == [hit.label for hit in frame.hits]
    assert [hit["robot"] for hit in found["hits"]] == [hit.robot for hit in frame.hits]
    for hit, known in zip(found["hits"], frame.hits, strict=True):
        assert math.dist((hit["x"], hit["y"]), known.at) <= 1 / 1024


def check_fleet(found: dict[str, Any], frame: Frame, width: int) -> None:
    """Compare what the page knows of orders and batteries with the frame."""
    assert frame.fleet is not None
    waiting = {each["cell"]: (each["count"], each["age"]) for each in found["waiting"]}
    assert waiting == {
        int(each.at[1]) * width + int(each.at[0]): (each.number, each.age)
        for each in frame.fleet.waiting
    }
    loads = [body["load"] for body in found["bodies"]][: len(frame.fleet.items)]
    assert loads == [0 if age is None else 1 + age for age in frame.fleet.items]
    assert found["battery"] == pytest.approx(frame.fleet.battery, abs=0.5e-3)


def test_the_page_knows_each_frame_of_an_episode(episode: Episode, clumsy_agent: Any) -> None:
    bodies = record_episode(WarehouseEnv(backend="physics", max_steps=20), clumsy_agent, seed=3)
    tracks = [track_of_record(episode), track_of_record(bodies)]
    assert any(frame.hits for frame in tracks[1].frames)
    for found, track in zip(said(packed(tracks, "", 1.0), "frames"), tracks, strict=True):
        assert len(found) == len(track)
        for index, (each, frame) in enumerate(zip(found, track.frames, strict=True)):
            check_frame(each, frame, index, 1 / 1024)


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_the_page_knows_each_frame_of_a_fleet(backend: str) -> None:
    record: FleetEpisode = fleet_episode(backend=backend, max_steps=60, battery=30)
    track: Track = track_of_record(record)
    [found] = said(packed([track], "", 1.0), "frames")
    for index, (each, frame) in enumerate(zip(found, track.frames, strict=True)):
        check_frame(each, frame, index, 1 / 1024)
        if frame.progress == int(frame.progress):
            check_fleet(each, frame, record.layout.width)
    assert any(frame.hits for frame in track.frames)
    assert any(frame.fleet and frame.fleet.waiting for frame in track.frames)
