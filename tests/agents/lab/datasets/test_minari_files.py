"""Minari datasets, which Minari reads exactly as they were recorded."""

import errno
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import minari
import pytest
from minari.namespace import create_namespace

from agents.errors import StoreError
from agents.lab.datasets import minari_files
from agents.lab.datasets.minari_files import DATA, FILE, check_name, save_dataset
from agents.lab.datasets.source import FIELDS, EpisodeArrays, Source
from agents.lab.trials.task import Task

SEEDS = range(3, 15)


@pytest.fixture(autouse=True)
def datasets(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    return tmp_path


def lone() -> Source:
    return Source("greedy", Task(battery=90))


def nested(arrays: dict[str, Any]) -> dict[str, Any]:
    """Return the arrays of nested dictionaries by name, which is how Minari stores infos."""
    found: dict[str, Any] = {}
    for name, values in arrays.items():
        group, _, rest = name.partition("/")
        if rest:
            found.setdefault(group, {})[rest] = values
        else:
            found[name] = values
    return found


def test_what_minari_loads_is_bit_for_bit_what_was_recorded() -> None:
    source = lone()
    episodes = [*source.episodes(SEEDS)]
    save_dataset("warehouse/test-v3", source, episodes)
    loaded = minari.load_dataset("warehouse/test-v3")
    assert (loaded.total_episodes, loaded.total_steps) == (
        len(SEEDS), sum(each.steps for each in episodes),
    )  # fmt: skip
    assert loaded.observation_space == source.observation_space
    assert loaded.action_space == source.action_space
    for number, (seed, arrays) in enumerate(episodes):
        read = vars(loaded[number])
        assert read.pop("id") == number
        for name, values in nested(arrays).items():
            pairs = values.items() if isinstance(values, dict) else [(None, values)]
            for key, array in pairs:
                back = read[name] if key is None else read[name][key]
                assert (back.dtype, back.shape) == (array.dtype, array.shape)
                assert back.tobytes() == array.tobytes()
        assert read.keys() == nested(arrays).keys()
        [about] = loaded.storage.get_episode_metadata([number])
        assert about == {"id": number, "seed": seed, "total_steps": len(arrays["rewards"])}


def test_the_same_episodes_give_the_same_bytes() -> None:
    source = lone()
    folders = [save_dataset(name, source, source.episodes(SEEDS)) for name in ("one-v0", "two-v12")]
    one, two = ((folder / DATA / FILE).read_bytes() for folder in folders)
    assert one == two
    assert {*FIELDS} == {*next(source.episodes(SEEDS)).arrays}


def test_a_dataset_is_never_incomplete(datasets: Path) -> None:
    source = lone()

    def interrupted() -> Iterator[EpisodeArrays]:
        yield from source.episodes(SEEDS)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        save_dataset("space/part-v0", source, interrupted())
    assert [path.name for path in datasets.rglob("*")] == ["space", "namespace_metadata.json"]
    save_dataset("space/part-v0", source, source.episodes(SEEDS))
    assert minari.list_local_datasets().keys() == {"space/part-v0"}


def test_on_a_full_disk_no_namespace_is_left_and_the_dataset_is_named(
    datasets: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(name: str) -> None:
        create_namespace(name)
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(minari_files, "create_namespace", fails)
    with pytest.raises(OSError, match=rf"No space left on device: '{datasets}/space/part-v0'$"):
        save_dataset("space/part-v0", lone(), [])
    assert minari.namespace.list_local_namespaces() == []


def test_a_name_must_be_valid_in_minari_and_new() -> None:
    names = "test", "test-v", "a/b-v0", "../up-v0", "/root-v0", "one/two/-v0", "", "ä-v0", "x-v0\n"
    for name in names:
        with pytest.raises(
            StoreError,
            match="cannot name a dataset; allowed: optional namespaces, a name and a version",
        ):
            check_name(name)
    source = lone()
    save_dataset("one/two/three-v0", source, source.episodes(range(1)))
    with pytest.raises(StoreError, match="three-v0 exists; choose another name"):
        check_name("one/two/three-v0")
