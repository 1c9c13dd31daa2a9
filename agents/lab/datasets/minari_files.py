"""Datasets in the files of Minari with a Croissant card, whole or not there.

Minari's own writer makes each array of an episode anew with room to grow, which takes several times
as long as the episode; arrays that stay as they are fit into the headers of HDF5.

Sources: https://minari.farama.org/content/dataset_standards/ and
https://docs.mlcommons.org/croissant/docs/croissant-spec-1.1.html
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.errors import StoreError
from agents.lab.datasets.source import EpisodeArrays, Source
from warehouse_core.extras import install_command
from warehouse_core.files.atomic import atomic_path
from warehouse_core.wording import brief

try:
    import h5py
    import minari
    from h5py import h5a, h5d, h5g, h5p, h5s, h5t
    from minari.dataset.minari_storage import MinariStorage
    from minari.namespace import create_namespace, list_local_namespaces
    from minari.storage import get_dataset_path
except ImportError as error:
    raise StoreError(
        f"datasets need {error.name}, which is not installed: {install_command('minari')}"
    ) from error

NAME = re.compile(r"(?:[\w-]{2,}/)*[\w-]+-v\d{1,9}", re.ASCII)
"""A name of a dataset: namespaces, if any, its own name and its version."""

DATA, FILE = "data", "main_data.hdf5"

CARD = "croissant.json"
"""Name of the card, in the folder of the dataset."""

CROISSANT = "http://mlcommons.org/croissant/1.1"

OF_CROISSANT = (
    "citeAs", "column", "equivalentProperty", "extract", "field", "fileProperty", "fileObject",
    "fileSet", "format", "includes", "isLiveDataset", "jsonPath", "key", "md5", "parentField",
    "path", "recordSet", "references", "regex", "repeated", "replace", "samplingRate", "separator",
    "source", "subField", "transform",
)  # fmt: skip
"""Words of the format that are its own and stand for no data."""

CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "dct": "http://purl.org/dc/terms/",
    "sc": "https://schema.org/",
    "conformsTo": "dct:conformsTo",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "examples": {"@id": "cr:examples", "@type": "@json"},
    **{word: f"cr:{word}" for word in OF_CROISSANT},
}
"""Meanings of the words of a card, the same for each card of the format."""

MAX_COMPACT = 60_000
"""Most bytes of an array within its header; the format allows 64 KiB less what else is there."""


def save_dataset(name: str, source: Source, episodes: Iterable[EpisodeArrays]) -> Path:
    """Write episodes as a dataset of Minari with a Croissant card, and return its folder.

    It is where ``minari.load_dataset`` looks: in ``MINARI_DATASETS_PATH``, or else in
    ``~/.minari/datasets``. The same episodes give the same bytes.

    Args:
        name: name and version, as in ``warehouse/greedy-v0``.
        source: source of the episodes.
        episodes: the episodes, in the order in which they are numbered.

    Raises:
        StoreError: the name has another form, or there is a dataset of this name.
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
            "fields": source.fields,
            "layout": source.layout.rows,
            "minari_version": minari.__version__,
        }
        storage.update_metadata(about | totals)
        storage.update_metadata({"dataset_size": storage.get_size()})
        write_card(folder, name, source, totals)
    return path


def write_card(folder: Path, name: str, source: Source, totals: Mapping[str, int]) -> None:
    """Write the card of a dataset into its folder, given the numbers of episodes and of steps."""
    file = f"{DATA}/{FILE}"
    title, _, version = name.rpartition("-v")
    counts = ", ".join(f"{count:,} {what}" for what, count in totals.items())
    card = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": CROISSANT,
        "name": title,
        "version": f"{version}.0.0",
        "description": f"{source.task} {counts}.".replace("total_", ""),
        "variableMeasured": [
            {"@type": "PropertyValue", "name": name, "description": meaning}
            for name, meaning in source.fields.items()
        ],
        "distribution": [
            {
                "@type": "cr:FileObject",
                "@id": file,
                "name": file,
                "contentUrl": file,
                "contentSize": f"{(folder / file).stat().st_size} B",
                "encodingFormat": "application/x-hdf5",
                "sha256": _digest(folder / file),
            }
        ],
    }
    (folder / CARD).write_text(json.dumps(card, indent=2) + "\n", encoding="utf-8")


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def check_name(name: str) -> str:
    """Return the name of a dataset that does not exist yet; see ``save_dataset``."""
    if not NAME.fullmatch(name):
        raise StoreError(
            f"{brief(name)} cannot name a dataset; allowed: a name and a version, after "
            "namespaces if you like, as in warehouse/greedy-v0"
        )
    if (path := get_dataset_path(name)).exists():
        raise StoreError(f"{path} exists; give the dataset another name or version than {name}")
    return name


def _prepare(name: str) -> Path:
    """Return the path of a new dataset, whose namespace exists."""
    # Absolute, as the sizes of files at relative paths are not found by Minari.
    path = Path(get_dataset_path(check_name(name))).absolute()
    space = Path(name).parent.as_posix()
    if space != "." and space not in list_local_namespaces():
        create_namespace(space)
    return path


def _write_episodes(path: Path, episodes: Iterable[EpisodeArrays]) -> dict[str, int]:
    """Write a file of episodes as Minari lays it out, and return how many there are."""
    count = steps = 0
    with h5py.File(path, "w", track_order=True) as file:
        for count, episode in enumerate(episodes, start=1):
            number = count - 1
            group = h5g.create(file.id, f"episode_{number}".encode())
            about = {"id": number, "seed": episode.seed, "total_steps": episode.steps}
            for name, value in about.items():
                values = np.asarray(value, np.int64)
                h5a.create(group, name.encode(), _type(values.dtype), _space(())).write(values)
            for name, values in episode.arrays.items():
                _write_array(group, name, values)
            steps += episode.steps
    return {"total_episodes": count, "total_steps": steps}


def _write_array(group: Any, name: str, values: NDArray[Any]) -> None:
    """Write an array into a group; its name may begin with groups within it."""
    made = h5d.create(
        group, name.encode(), _type(values.dtype), _space(values.shape),
        _settings(values.nbytes <= MAX_COMPACT), _with_groups(),
    )  # fmt: skip
    made.write(h5s.ALL, h5s.ALL, values)


@cache
def _type(dtype: np.dtype[Any]) -> Any:
    return h5t.py_create(dtype, logical=True)


@cache
def _space(shape: tuple[int, ...]) -> Any:
    return h5s.create_simple(shape) if shape else h5s.create(h5s.SCALAR)


@cache
def _settings(is_compact: bool) -> Any:
    """Return the settings of an array: it is in its header, or not, and has no date."""
    settings = h5p.create(h5p.DATASET_CREATE)
    settings.set_layout(h5d.COMPACT if is_compact else h5d.CONTIGUOUS)
    settings.set_obj_track_times(False)
    return settings


@cache
def _with_groups() -> Any:
    settings = h5p.create(h5p.LINK_CREATE)
    settings.set_create_intermediate_group(True)
    return settings
