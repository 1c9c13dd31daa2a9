"""Recordings that ``warehouse export`` writes of an episode, opened again."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import Refused
from helpers.fleets import SHELVES, Couriers
from mcap.reader import make_reader

from agents.lab.datasets.recording import entries, save_recording
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


def crowd(backend: str = "grid") -> FleetEpisode:
    env = FleetEnv(SHELVES, 6, orders=0.5, people=2, max_steps=40, battery=90, backend=backend)
    recorder, agent = FleetRecorder(env, seed=3), Couriers()
    agent.reset()
    while not recorder.ended:
        recorder.step(agent.act(env))
    return recorder.episode


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


@pytest.mark.parametrize("make", [lambda: lone("physics"), crowd], ids=["lone", "fleet"])
def test_a_file_has_the_messages_of_its_record(tmp_path: Path, make: Callable[[], Any]) -> None:
    """``test_recorded.py`` has the messages themselves."""
    record = make()
    messages, _, about = saved(tmp_path, record)
    expected: dict[str, Rows] = {}
    for time, topic, message in entries(record):
        expected.setdefault(topic, []).append((time, message))
    assert messages == expected
    assert about["outcome"] == record.outcome
    assert record.is_fleet or about == {
        "agent": "by hand", "backend": "physics", "seed": "1", "outcome": "delivered"
    }  # fmt: skip


def test_messages_have_the_fields_of_their_schemas(tmp_path: Path) -> None:
    messages, schemas, _ = saved(tmp_path, crowd("physics"))
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


@pytest.mark.parametrize("record", [lambda: lone("physics"), crowd])
def test_a_record_always_gives_the_same_bytes(warehouse, tmp_path, record) -> None:
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
