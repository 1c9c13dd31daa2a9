"""Datasets in the file format of Minari.

This module does not use Minari's own writer, which creates each array of an episode as a resizable
array. That takes several times as long as running the episode.

Source: https://minari.farama.org/content/dataset_standards/
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from agents.errors import StoreError
from agents.lab.datasets.source import FIELDS, EpisodeArrays, Source
from warehouse_core.extras import not_installed
from warehouse_core.files.atomic import atomic_path
from warehouse_core.wording import brief

try:
    import h5py
    import minari
    from h5py import h5a, h5d, h5g, h5p, h5s, h5t
    from minari.dataset.minari_storage import MinariStorage
    from minari.namespace import (
        NAMESPACE_METADATA_FILENAME,
        create_namespace,
        list_local_namespaces,
    )
    from minari.storage import get_dataset_path
except ImportError as error:
    raise StoreError(not_installed("datasets need", error, "minari")) from error

NAME = re.compile(r"(?:[\w-]{2,}/)*[\w-]+-v\d{1,9}", re.ASCII)
"""Pattern for the name of a dataset: optional namespaces, its own name and its version."""

DATA, FILE = "data", "main_data.hdf5"


def save_dataset(name: str, source: Source, episodes: Iterable[EpisodeArrays]) -> Path:
    """Write episodes as a Minari dataset, and return its folder.

    The dataset is written where ``minari.load_dataset`` finds it: in ``MINARI_DATASETS_PATH``, or
    else in ``~/.minari/datasets``. No incomplete dataset is left after an error. The same episodes
    always give the same bytes.

    Args:
        name: name and version, such as ``warehouse/greedy-v0``.
        source: source of the episodes.
        episodes: episodes in the order of their numbers.

    Raises:
        StoreError: the name has another form, or a dataset with this name exists.
    """
    path = _prepare(name)
    with atomic_path(path) as folder:
        folder.mkdir()
        storage = MinariStorage.new(
            folder / DATA, source.observation_space, source.action_space, source.spec
        )
        totals = _write_episodes(folder / DATA / FILE, episodes)
        about = {
            "dataset_id": name,
            "algorithm_name": source.agent,
            "description": source.task,
            "fields": FIELDS,
            "layout": source.layout.rows,
            "minari_version": minari.__version__,
        }
        storage.update_metadata(about | totals)
        storage.update_metadata({"dataset_size": storage.get_size()})
    return path


def check_name(name: str) -> str:
    """Return the name of a new dataset.

    Raises:
        StoreError: the name has another form, or a dataset with this name exists.
    """
    if not NAME.fullmatch(name):
        raise StoreError(
            f"{brief(name)} cannot name a dataset; allowed: optional namespaces, a name and a "
            "version, such as warehouse/greedy-v0"
        )
    if (path := get_dataset_path(name)).exists():
        raise StoreError(f"{path} exists; choose another name or version than {name}")
    return name


def _prepare(name: str) -> Path:
    """Return the path of a new dataset, after creating its namespace."""
    # Absolute, because Minari does not find the sizes of files at relative paths.
    path = Path(get_dataset_path(check_name(name))).absolute()
    space = Path(name).parent.as_posix()
    if space != "." and space not in list_local_namespaces():
        try:
            create_namespace(space)
        except OSError as error:  # of a full disk, which names no file
            (path.parent / NAMESPACE_METADATA_FILENAME).unlink(missing_ok=True)
            raise OSError(error.errno, error.strerror, str(path)) from error
    return path


def _write_episodes(path: Path, episodes: Iterable[EpisodeArrays]) -> dict[str, int]:
    """Write episodes to a file in Minari's layout, and return the numbers of episodes and steps.

    The low-level interface of h5py takes a third of the time of the high-level one.
    """
    undated, nested = h5p.create(h5p.DATASET_CREATE), h5p.create(h5p.LINK_CREATE)
    undated.set_obj_track_times(False)
    nested.set_create_intermediate_group(True)
    count = steps = 0
    with h5py.File(path, "w", track_order=True) as file:
        for count, episode in enumerate(episodes, start=1):
            group = h5g.create(file.id, f"episode_{count - 1}".encode())
            about = {"id": count - 1, "seed": episode.seed, "total_steps": episode.steps}
            for name, value in about.items():
                number = np.asarray(value, np.int64)
                h5a.create(group, name.encode(), _type(number.dtype), _space(())).write(number)
            for name, values in episode.arrays.items():
                made = h5d.create(
                    group, name.encode(), _type(values.dtype), _space(values.shape), undated, nested
                )
                made.write(h5s.ALL, h5s.ALL, values)
            steps += episode.steps
    return {"total_episodes": count, "total_steps": steps}


@cache
def _type(dtype: np.dtype[Any]) -> Any:
    return h5t.py_create(dtype, logical=True)


@cache
def _space(shape: tuple[int, ...]) -> Any:
    return h5s.create_simple(shape) if shape else h5s.create(h5s.SCALAR)
