"""Records of fleets whose robots have headings."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.fleets import SHELVES

from warehouse_core import Episode, FleetEnv, record_episode, replay_episode
from warehouse_core.batch.fleet_settings import FleetSettings
from warehouse_core.errors import RecordError
from warehouse_core.files.npz import write_arrays
from warehouse_core.records import FleetRecorder
from warehouse_core.records.arrays import pack, schema_of, unpack
from warehouse_core.world.actions import INVALID


class Turners:
    """Robots that do anything, also what no robot can."""

    def reset(self) -> None:
        self._stream = np.random.default_rng(3)

    def act(self, env: FleetEnv) -> list[str | int]:
        words = ["forward", 0, 0, "RIGHT", "LEFT", "WAIT", 4, "DROP", "N", 6]
        return [words[each] for each in self._stream.integers(10, size=env.settings.robots)]


def record(**settings: Any) -> Episode:
    given = {"orders": 0.3, "people": 2, "max_steps": 60, "battery": 40, "moves": "turn"}
    env = FleetEnv(SHELVES, 4, **given | settings)
    return record_episode(env, Turners(), seed=4)


def fields_of(episode: Episode) -> dict[str, Any]:
    return {name: getattr(episode, name) for name in episode.__slots__}


@pytest.mark.filterwarnings("ignore:2 chargers can keep")
def test_a_record_has_the_headings_and_is_replayed_and_stored_whole(tmp_path: Path) -> None:
    episode = record()
    env = FleetEnv(SHELVES, 4, **{each: getattr(episode.settings, each) for each in (
        "orders", "people", "max_steps", "battery", "moves"
    )})  # fmt: skip
    env.reset(seed=4)
    assert episode.headings[0].tolist() == env.headings
    for step, actions in enumerate(episode.actions):
        env.step(actions)
        assert episode.headings[step + 1].tolist() == env.headings
    assert {0, 1, INVALID} < {*episode.actions.ravel().tolist()}
    assert replay_episode(episode) == episode
    episode.save(tmp_path / "turns.npz")
    assert Episode.load(tmp_path / "turns.npz") == episode
    start = FleetRecorder(env, seed=4).episode
    start.save(tmp_path / "start.npz")
    assert Episode.load(tmp_path / "start.npz") == start
    assert json.loads(json.dumps(episode.settings.to_json()))["moves"] == "turn"
    assert FleetSettings.from_json(episode.settings.to_json()) == episode.settings


@pytest.mark.filterwarnings("ignore:2 chargers can keep")
@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("headings", 4, r"headings: a number is outside 0\.\.3"),
        ("headings", -1, r"headings: a number is outside 0\.\.3"),
        ("actions", 6, r"actions: a number is outside 0\.\.5 and is not 7"),
        ("headings", None, "headings are missing for moves 'turn'"),
    ],
)
def test_a_damaged_file_is_refused(name: str, value: int | None, message: str, tmp_path) -> None:
    arrays = pack(fields_of(record()))
    if value is None:
        del arrays[name]
    else:
        arrays[name][3, 1] = value
    write_arrays(tmp_path / "bad.npz", arrays, schema_of(arrays))
    with pytest.raises(RecordError, match=message):
        Episode.load(tmp_path / "bad.npz")


@pytest.mark.filterwarnings("ignore:2 chargers can keep")
def test_headings_of_a_fleet_without_them_are_refused() -> None:
    arrays = pack(fields_of(record(moves="compass")))
    arrays["headings"] = arrays["cells"].astype(np.int8)
    with pytest.raises(RecordError, match="headings are not allowed for moves 'compass'"):
        unpack(arrays)
