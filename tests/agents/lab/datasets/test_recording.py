"""Recordings that ``warehouse export`` writes of an episode, opened again."""

import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.command_line import Refused, Warehouse
from helpers.fleets import SHELVES, Couriers
from mcap.reader import make_reader

from agents.lab.datasets.recording import save_recording
from warehouse_core import Episode, EpisodeRecorder, FleetEnv, FleetEpisode, Layout, WarehouseEnv
from warehouse_core.records import FleetRecorder

ROOM = Layout(["######", "#PP.D#", "#.C..#", "######"])
ACTIONS = ["N", "W", "PICK", "E", "E", "E", "DROP"]
"""A wall, the pickup, and the dropoff."""

PUBLISHED = {
    "entity": "timestamp frame_id id lifetime frame_locked metadata arrows cubes spheres cylinders "
    "lines triangles texts models",
    "arrows": "pose shaft_length shaft_diameter head_length head_diameter color",
    "cubes": "pose size color",
    "spheres": "pose size color",
    "cylinders": "pose size bottom_scale top_scale color",
    "transform": "timestamp parent_frame_id child_frame_id translation rotation",
}
"""The fields that Foxglove requires, see the source in ``recording.py``."""

KINDS: dict[str, Any] = {
    "object": dict, "array": list, "string": str, "boolean": bool, "integer": int,
    "number": (int, float),
}  # fmt: skip

Rows = list[tuple[int, Any]]


def lone(backend: str) -> Episode:
    env = WarehouseEnv(ROOM, (1, 2), battery=50, backend=backend)
    env.reset(seed=1)
    recorder = EpisodeRecorder(env, seed=1, agent="by\nhand")
    for action in ACTIONS:
        recorder.step(action)
    env.close()
    assert recorder.episode.terminated
    return recorder.episode


def crowd(backend: str) -> tuple[FleetEpisode, list[list[tuple[int, Any]]]]:
    """Return a record, and the contacts of the motion in each step, by robot."""
    env = FleetEnv(SHELVES, 6, orders=0.5, people=2, max_steps=40, battery=90, backend=backend)
    recorder, agent = FleetRecorder(env, seed=3), Couriers()
    agent.reset()
    found = []
    while not recorder.ended:
        recorder.step(agent.act(env))
        motions = env.last_motion if backend == "physics" else env.last_motion[:6]
        found.append([(body, hit) for body, each in enumerate(motions) for hit in each.contacts])
    env.close()
    return recorder.episode, found


def opened(path: Path) -> tuple[dict[str, Rows], dict[str, Any], dict[str, str]]:
    """Return messages by topic, the schema of each topic, and the metadata of the episode."""
    messages: dict[str, Rows] = {}
    schemas = {}
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        times = []
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            times.append(message.log_time)
            messages.setdefault(channel.topic, []).append(
                (message.log_time, json.loads(message.data))
            )
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            schemas[channel.topic] = json.loads(schema.data)
            assert schemas[channel.topic]["title"] == schema.name
        assert times == sorted(times)
        (about,) = reader.iter_metadata()
    return messages, schemas, about.metadata


def saved(tmp_path: Path, record: Any) -> tuple[dict[str, Rows], dict[str, Any], dict[str, str]]:
    save_recording(tmp_path / "e.mcap", record)
    return opened(tmp_path / "e.mcap")


def poses_of(messages: dict[str, Rows]) -> dict[str, dict[int, tuple[float, ...]]]:
    """Return x, y and heading of each body at each time, on the axes of the core."""
    found: dict[str, dict[int, tuple[float, ...]]] = {}
    for time, message in messages["/tf"]:
        for each in message["transforms"]:
            at, turn = each["translation"], each["rotation"]
            angle = -2 * math.atan2(turn["z"], turn["w"])
            assert each["parent_frame_id"] == "warehouse"
            assert each["timestamp"] == {"sec": time // 10**9, "nsec": time % 10**9}
            found.setdefault(each["child_frame_id"], {})[time] = (at["x"], -at["y"], angle)
    return found


def nanoseconds(seconds: float) -> int:
    return round(seconds * 10**9)


def check(value: Any, schema: dict[str, Any]) -> None:
    """Raise an error unless a value has exactly the types and the fields of a schema."""
    assert isinstance(value, KINDS[schema["type"]]), (value, schema)
    if schema["type"] == "object":
        assert value.keys() == schema["properties"].keys() == set(schema["required"])
        for name, each in value.items():
            check(each, schema["properties"][name])
    if schema["type"] == "array":
        for each in value:
            check(each, schema["items"])


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_an_episode_is_opened_again(tmp_path: Path, backend: str) -> None:
    episode = lone(backend)
    messages, _, about = saved(tmp_path, episode)
    ends = [0.0, *np.cumsum([motion.seconds for motion in episode.motions]).tolist()]
    poses = poses_of(messages)["robot_0"]
    for step, motion in enumerate(episode.motions, start=1):
        x, y, heading = motion.path[-1, 1:].tolist()
        found = poses[nanoseconds(ends[step])]
        assert found[:2] == pytest.approx((x, y), abs=1e-6)
        assert math.cos(found[2] - heading) == pytest.approx(1)
    assert len(poses) == (len(ends) if backend == "grid" else pytest.approx(10 * ends[-1], rel=0.1))
    energy = messages["/energy"]
    assert [time for time, _ in energy] == [nanoseconds(end) for end in ends]
    assert [message["step"] for _, message in energy] == list(range(8))
    joules = np.cumsum([0.0, *(motion.joules for motion in episode.motions)])
    assert np.array([message["joules"] for _, message in energy])[:, 0] == pytest.approx(joules)
    assert [message["battery"] for _, message in energy] == [[50 - step] for step in range(8)]
    (bump,) = episode.motions[0].contacts
    ((time, contact),) = messages["/contacts"]
    assert time == nanoseconds(bump.seconds)
    assert (contact["robot"], contact["counterpart"]) == ("robot_0", "wall")
    assert contact["impulse"] == pytest.approx(bump.impulse, abs=1e-6)
    assert (contact["x"], -contact["y"]) == pytest.approx(bump.point, abs=1e-6)
    ((shown, hit),) = messages["/hits"]
    (mark,) = hit["entities"][0]["spheres"]
    assert (shown, mark["pose"]["position"]["x"]) == (time, contact["x"])
    assert about == {
        "agent": "by hand", "backend": backend, "seed": "1", "outcome": "delivered"
    }  # fmt: skip


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_a_fleet_is_opened_again(tmp_path: Path, backend: str) -> None:
    episode, expected = crowd(backend)
    messages, *_ = saved(tmp_path, episode)
    poses = poses_of(messages)
    names = [*(f"robot_{robot}" for robot in range(6)), "person_0", "person_1"]
    assert list(poses) == names
    steps = [[each.seconds for each in found] for found in episode.motions] or episode.seconds
    ends = [0.0, *np.cumsum([max(seconds) for seconds in steps]).tolist()]
    bodies = np.hstack([episode.cells, episode.people])
    for end, cells in zip(ends, bodies, strict=True):
        for name, cell in zip(names, cells.tolist(), strict=True):
            row, col = divmod(cell, SHELVES.width)
            x, y, _ = poses[name][nanoseconds(end)]
            assert (math.floor(y), math.floor(x)) == (row, col)
    hits = [
        (nanoseconds(ends[step] + hit.seconds), names[body], hit)
        for step, found in enumerate(expected)
        for body, hit in found
    ]
    hits.sort(key=lambda hit: hit[0])
    assert len(hits) > 10
    assert {hit.counterpart.split()[0] for *_, hit in hits} >= {"wall", "robot"}
    contacts = messages["/contacts"]
    assert [(time, each["robot"]) for time, each in contacts] == [hit[:2] for hit in hits]
    for (_, each), (*_, hit) in zip(contacts, hits, strict=True):
        who = hit.counterpart.split()
        other = names[int(who[1])] if len(who) > 1 else "wall"
        assert each["counterpart"] == other
        assert (each["x"], -each["y"]) == pytest.approx(hit.point, abs=1e-6)
        assert each["impulse"] == pytest.approx(hit.impulse, abs=1e-6)
    last = messages["/energy"][-1][1]
    assert last["joules"] == pytest.approx(episode.joules.sum(axis=0))
    assert last["battery"] == pytest.approx(episode.battery[-1])


def test_messages_have_the_fields_of_their_schemas(tmp_path: Path) -> None:
    messages, schemas, _ = saved(tmp_path, crowd("grid")[0])
    assert messages.keys() == {"/layout", "/bodies", "/tf", "/hits", "/contacts", "/energy"}
    for _, message in messages["/bodies"]:
        assert len(message["entities"]) == 8, "of all, so that one message says it all"
    for topic, found in messages.items():
        for _, message in found:
            check(message, schemas[topic])
    scene = schemas["/layout"]["properties"]["entities"]["items"]
    shapes = {name: each["items"] for name, each in scene["properties"].items() if "items" in each}
    given = {"entity": scene, **shapes, **schemas["/tf"]["properties"]}
    given["transform"] = given["transforms"]["items"]
    for name, fields in PUBLISHED.items():
        assert sorted(given[name]["required"]) == sorted(fields.split()), name


@pytest.mark.parametrize("record", [lambda: lone("physics"), lambda: crowd("grid")[0]])
def test_a_record_always_gives_the_same_bytes(
    warehouse: Warehouse, tmp_path: Path, record: Callable[[], Any]
) -> None:
    record().save(tmp_path / "e.NPZ")
    for name in ("a.mcap", "b.MCAP"):
        target = tmp_path / name
        result = warehouse("export", tmp_path / "e.NPZ", target)
        assert result == (0, f"saved {target}\n", "")
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.MCAP").read_bytes()


def test_an_episode_without_steps_has_only_its_start(tmp_path: Path) -> None:
    env = WarehouseEnv(ROOM)
    env.reset()
    messages, _, about = saved(tmp_path, EpisodeRecorder(env).episode)
    assert {topic: len(rows) for topic, rows in messages.items()} == {
        "/layout": 1, "/tf": 1, "/bodies": 1, "/energy": 1
    }  # fmt: skip
    assert (about["seed"], about["outcome"]) == ("", "unfinished")


@pytest.fixture
def record(tmp_path: Path) -> Path:
    lone("grid").save(tmp_path / "e.npz")
    return tmp_path / "e.npz"


def test_without_mcap_the_error_gives_the_command_that_installs_it(
    refused: Refused, record: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    line = refused("export", record, record.with_suffix(".mcap"))
    assert line == "saving as .mcap needs mcap: pip install 'mcap>=1.2.2'"
