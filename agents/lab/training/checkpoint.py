"""Checkpoints: all that a training needs to go on as if it had never stopped.

A file is two lines of text, the digest of what follows and JSON of the options, and then pickled
Python. Whoever writes such a file can have any program run where it is read.
"""

from __future__ import annotations

import hashlib
import json
import pickle
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from agents.learning.learner import Resumable
from warehouse_core.errors import RecordError
from warehouse_core.files.atomic import atomic_path
from warehouse_core.wording import brief

FORMAT = "warehouse-lab checkpoint 1"


def save_checkpoint(
    path: Path, options: Mapping[str, Any], learner: Resumable, progress: object
) -> None:
    """Write a checkpoint, whole or not at all.

    Args:
        path: file to write.
        options: all that the training follows from, as values that JSON has.
        learner: training that is being watched.
        progress: anything else that is to be kept.
    """
    content = json.dumps(options).encode() + b"\n" + pickle.dumps((learner.state(), progress))
    with atomic_path(path) as part:
        part.write_bytes(f"{FORMAT} {_digest(content)}\n".encode() + content)


def load_checkpoint(path: Path, options: Mapping[str, Any], learner: Resumable) -> Any:
    """Restore a learner, and return the progress that was saved with it.

    Raises:
        RecordError: the file is damaged or no checkpoint, or its options differ.
        OSError: the file cannot be read.
    """
    head, _, content = path.read_bytes().partition(b"\n")
    if not head.startswith(FORMAT.encode()):
        raise RecordError(f"{path}: its first line is not that of a {FORMAT!r}")
    if head.decode(errors="replace") != f"{FORMAT} {_digest(content)}":
        raise RecordError(f"{path}: it is damaged; its digest is another")
    text, _, pickled = content.partition(b"\n")
    stored = json.loads(text)
    # JSON has no tuples.
    for name, value in json.loads(json.dumps(options)).items():
        if stored.get(name) != value:
            raise RecordError(
                f"{path}: {name} was {brief(stored.get(name))} and is {brief(value)} now; a "
                "training is resumed with the options and versions with which it began"
            )
    state, progress = pickle.loads(pickled)
    learner.restore(state)
    return progress


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
