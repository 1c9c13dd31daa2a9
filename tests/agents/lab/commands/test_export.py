"""The command ``warehouse export`` for datasets."""

import sys
from pathlib import Path

import minari
import pytest
from helpers.command_line import Warehouse

from agents.registry import make_agent
from warehouse_core.world.actions import action_index


@pytest.fixture(autouse=True)
def datasets(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    return tmp_path


def test_a_dataset_has_the_episodes_of_an_agent(warehouse: Warehouse, datasets: Path) -> None:
    words = "--agent", "astar", "-n", 5, "--seed", 12, "--layout", "rooms", "--battery", 90
    done = warehouse("export", "warehouse/astar-v0", *words)
    folder = datasets / "warehouse" / "astar-v0"
    assert (done.code, done.out) == (0, f"saved 5 episodes as warehouse/astar-v0 in {folder}\n")
    loaded = minari.load_dataset("warehouse/astar-v0")
    assert loaded.total_episodes == 5
    assert loaded.storage.metadata["algorithm_name"] == "astar"
    env = loaded.recover_environment()
    acting = make_agent("astar", 14, env.unwrapped.warehouse.layout)
    observation, _ = env.reset(seed=14)
    assert (observation == loaded[2].observations[0]).all()
    for action in loaded[2].actions:
        assert action == action_index(acting.act(env.unwrapped.warehouse.observe()))
        ended = env.step(action)[2]
    assert ended


def test_what_cannot_be_is_refused_before_any_episode(refused, monkeypatch, datasets) -> None:
    assert refused("export", "old").startswith("'old' cannot name a dataset; allowed: ")
    line = refused("export", "new-v0", "--backend", "mine.py")
    assert line.startswith("no backend is called 'mine.py'; installed: driving, grid, physics")
    line = refused("export", "new-v0", "-n", 1, "--agent", "greedier")
    assert line.startswith("no agent is called 'greedier'")
    assert [*datasets.iterdir()] == []
    monkeypatch.delitem(sys.modules, "agents.lab.datasets.minari_files", raising=False)
    monkeypatch.setitem(sys.modules, "h5py", None)
    line = refused("export", "new-v0")
    assert line == "datasets need h5py, which is not installed: pip install 'minari[hdf5]>=0.5.2'"


def test_without_a_seed_datasets_differ(warehouse: Warehouse) -> None:
    for version in range(2):
        assert warehouse("export", f"any-v{version}", "-n", 3).code == 0
    first, second = (minari.load_dataset(f"any-v{version}")[0] for version in range(2))
    assert first.observations[0].tolist() != second.observations[0].tolist()
