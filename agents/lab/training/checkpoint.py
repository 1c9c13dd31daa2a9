"""Checkpoints, from which a training continues as if it had never stopped.

A file has two lines of text, which are a digest of the rest and the options as JSON, and then
pickled Python objects. Load only files that you trust, because the pickle can run any program.
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
    """Write a checkpoint, and leave no incomplete file after an error.

    Args:
        path: file to write.
        options: everything that determines the training, as JSON values.
        learner: learner whose state is saved.
        progress: any other object to save.
    """
    content = json.dumps(options).encode() + b"\n" + pickle.dumps((learner.state(), progress))
    with atomic_path(path) as part:
        part.write_bytes(f"{FORMAT} {_digest(content)}\n".encode() + content)


def load_checkpoint(path: Path, options: Mapping[str, Any], learner: Resumable) -> Any:
    """Restore the state of a learner, and return the progress that was saved with it.

    Raises:
        RecordError: the file is damaged or is not a checkpoint, or its options differ.
        OSError: the file cannot be read.
    """
    head, _, content = path.read_bytes().partition(b"\n")
    if not head.startswith(FORMAT.encode()):
        raise RecordError(f"{path}: its first line does not begin with {FORMAT!r}")
    if head.decode(errors="replace") != f"{FORMAT} {_digest(content)}":
        raise RecordError(f"{path}: the file is damaged; its digest does not match")
    text, _, pickled = content.partition(b"\n")
    stored = json.loads(text)
    # Compared after a conversion to JSON, which has no tuples.
    for name, value in json.loads(json.dumps(options)).items():
        if stored.get(name) != value:
            raise RecordError(
                f"{path}: {name} was {brief(stored.get(name))} and is {brief(value)} now; resume "
                "a training with the options and versions with which it began"
            )
    state, progress = pickle.loads(pickled)
    learner.restore(state)
    return progress


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
