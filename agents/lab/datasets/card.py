"""The card of a dataset for search engines and loaders, in the format Croissant.

Source of the format: https://docs.mlcommons.org/croissant/docs/croissant-spec-1.1.html
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from agents.lab.datasets.source import Source

CARD = "croissant.json"
"""Name of the card, in the folder of the dataset."""

VERSION = "http://mlcommons.org/croissant/1.1"

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


def write_card(
    folder: Path, file: str, name: str, source: Source, totals: Mapping[str, int]
) -> None:
    """Write the card of a dataset.

    Args:
        folder: folder of the dataset.
        file: path in it of the file that has the data.
        name: name of the dataset and its version, as in ``warehouse/greedy-v0``.
        source: source of the episodes.
        totals: number of episodes and of steps.
    """
    title, _, version = name.rpartition("-v")
    counts = ", ".join(f"{count:,} {what}" for what, count in totals.items())
    card = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": VERSION,
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
