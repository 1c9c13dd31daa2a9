"""The network that controls a body: its file, its actions and its use by name."""

from itertools import pairwise

import numpy as np
import pytest

from agents.errors import AgentError
from agents.learning import DriveNetwork, DrivePolicy
from agents.registry import make_agent
from warehouse_core import Episode, RecordError, WarehouseEnv, replay_episode

BACKEND = "drive:drive=omnidirectional,rate=5.0,rays=0,max_seconds=2.0"


def network_of(inputs=13, seed=0):
    stream, widths = np.random.default_rng(seed), [inputs, 4, 4, 2]
    return DriveNetwork(
        BACKEND,
        [
            (stream.normal(size=(b, a)).astype(np.float32), np.zeros(b, np.float32))
            for a, b in pairwise(widths)
        ],
    )


def test_a_file_keeps_the_network_and_its_environment(tmp_path):
    network = network_of()
    network.save(tmp_path / "drive.npz")
    loaded = DriveNetwork.load(tmp_path / "drive.npz")
    inputs = np.random.default_rng(1).normal(size=(5, 13)).astype(np.float32)
    assert (loaded.commands(inputs) == network.commands(inputs)).all()
    assert (loaded.backend, loaded.inputs) == (BACKEND, 13)
    assert np.abs(network.commands(100 * inputs)).max() <= 1


def test_a_network_without_two_outputs_is_refused(tmp_path):
    layers = network_of().layers
    with pytest.raises(ValueError, match="layer"):
        DriveNetwork(BACKEND, [*layers[:2], (np.zeros((3, 4)), np.zeros(3))])
    (tmp_path / "other.npz").write_bytes(b"no")
    with pytest.raises(RecordError):
        DrivePolicy.load(tmp_path / "other.npz")


def test_an_observation_of_the_grid_is_refused():
    policy = DrivePolicy(network_of())
    for observation in (WarehouseEnv().reset(), np.zeros(5)):
        with pytest.raises(AgentError, match="controls a body and needs 13 numbers"):
            policy.act(observation)


def test_the_command_runs_a_policy_in_its_own_environment(warehouse, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    network_of().save("drive.npz")
    assert isinstance(make_agent("drive:drive.npz"), DrivePolicy)
    result = warehouse(
        *("run", "--backend", "drive", "--agent", "drive:drive.npz", "--seed", 3),
        *("--save", "e.npz", "--no-show"),
    )
    assert f"DrivePolicy on the {BACKEND} backend, seed 3" in result.out
    episode = Episode.load("e.npz")
    assert episode.steps == 10
    assert replay_episode(episode) == episode
