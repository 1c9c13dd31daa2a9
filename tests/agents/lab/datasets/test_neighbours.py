"""Datasets beside those of others: Minari's own recorder, and the validator of Croissant."""

import warnings
from pathlib import Path

import gymnasium
import minari
import pytest

from agents.lab.datasets.infos import EvenInfos
from agents.lab.datasets.lone import LoneSource
from agents.lab.datasets.minari_files import CARD, save_dataset
from agents.registry import make_agent
from warehouse_core.world.actions import action_index

pytestmark = pytest.mark.learning

SEEDS = range(5)


@pytest.fixture(autouse=True)
def datasets(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    return tmp_path


@pytest.mark.filterwarnings("ignore::ResourceWarning")  # of a folder that it leaves to Python
def test_minaris_own_recorder_gives_the_same_dataset() -> None:
    source = LoneSource("greedy", battery=60)
    save_dataset("ours-v0", source, source.episodes(SEEDS))
    env = gymnasium.make(source.spec)
    collector = minari.DataCollector(env, step_data_callback=EvenInfos, record_infos=True)
    for seed in SEEDS:
        collector.reset(seed=seed)
        agent, ended = make_agent("greedy", seed), False
        agent.reset()
        while not ended:
            action = action_index(agent.act(collector.unwrapped.warehouse.observe()))
            *_, terminated, truncated, _ = collector.step(action)
            ended = terminated or truncated
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of an author who is not named
        theirs = collector.create_dataset("theirs-v0")
    collector.close()
    ours = minari.load_dataset("ours-v0")
    assert (theirs.total_episodes, theirs.total_steps) == (len(SEEDS), ours.total_steps)
    for one, other in zip(ours, theirs, strict=True):
        for name in ("observations", "actions", "rewards", "terminations", "truncations"):
            mine, its = getattr(one, name), getattr(other, name)
            assert (mine.dtype, mine.tobytes()) == (its.dtype, its.tobytes()), name
        assert one.infos.keys() == other.infos.keys()
        for name, values in one.infos.items():
            assert values.tobytes() == other.infos[name].tobytes(), name


@pytest.mark.filterwarnings("default::DeprecationWarning")  # of its own libraries
def test_the_validator_of_croissant_finds_no_error_in_a_card() -> None:
    import mlcroissant

    source = LoneSource("astar")
    folder = save_dataset("warehouse/card-v0", source, source.episodes(SEEDS))
    card = mlcroissant.Dataset(folder / CARD)
    assert card.metadata.issues.errors == set()
    assert card.metadata.name == "warehouse/card"
    [file] = card.metadata.distribution
    assert (folder / file.content_url).exists()
    text = (folder / CARD).read_text()
    (folder / CARD).write_text(text.replace("cr:FileObject", "cr:FileObjects"))
    with pytest.raises(mlcroissant.ValidationError):
        mlcroissant.Dataset(folder / CARD)
