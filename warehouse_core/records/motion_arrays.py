"""Outcomes of ``T`` motions as arrays, and back.

Paths and contacts of all motions are concatenated.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import RecordError
from warehouse_core.files.npz import Arrays, Schema
from warehouse_core.motion.base import Contact, Outcome

MOTION_SCHEMA: Schema = {
    "motion_cells": ("<i4", 2),
    "motion_blocked": ("|b1", 1),
    "motion_seconds": ("<f8", 1),
    "motion_joules": ("<f8", 1),
    "path": ("<f8", 2),
    "path_lengths": ("<i4", 1),
    "contacts": ("<f8", 2),
    "contact_counts": ("<i4", 1),
    "contact_counterparts": ("<i4", 1),
}

Word = TypeVar("Word", bound=Hashable)


def encode_words(words: Sequence[Word]) -> tuple[list[Word], NDArray[np.int32]]:
    """Return the different words and, for each of ``words``, its index among them."""
    codes: dict[Word, int] = {}
    indices = [codes.setdefault(word, len(codes)) for word in words]
    return list(codes), np.array(indices, dtype=np.int32)


def decode_words(vocabulary: Sequence[Word], codes: NDArray[Any], name: str) -> list[Word]:
    """Undo ``encode_words``.

    Raises:
        RecordError: a code beyond the vocabulary.
    """
    if codes.size and not (codes.min() >= 0 and codes.max() < len(vocabulary)):
        raise RecordError(f"{name} has a code outside 0..{len(vocabulary) - 1}")
    return [vocabulary[code] for code in codes.tolist()]


def pack_motions(motions: Sequence[Outcome]) -> tuple[Arrays, list[str]]:
    """Return the arrays of ``MOTION_SCHEMA`` and the vocabulary of counterparts."""
    contacts = [contact for motion in motions for contact in motion.contacts]
    counterparts, codes = encode_words([contact.counterpart for contact in contacts])
    arrays: Arrays = {
        "motion_cells": np.array([motion.cell for motion in motions]).reshape(-1, 2),
        "motion_blocked": np.array([motion.blocked for motion in motions], dtype=bool),
        "motion_seconds": np.array([motion.seconds for motion in motions]),
        "motion_joules": np.array([motion.joules for motion in motions]),
        "path": np.concatenate([np.empty((0, 4)), *(motion.path for motion in motions)]),
        "path_lengths": np.array([len(motion.path) for motion in motions]),
        "contacts": np.array(
            [(contact.seconds, contact.impulse, *contact.point) for contact in contacts]
        ).reshape(-1, 4),
        "contact_counts": np.array([len(motion.contacts) for motion in motions]),
        "contact_counterparts": codes,
    }
    return arrays, counterparts


def unpack_motions(arrays: Arrays, counterparts: list[str], steps: int) -> list[Outcome]:
    """Undo ``pack_motions``, checking that the arrays fit together.

    Raises:
        RecordError: they do not, or a value is impossible.
    """
    _check(arrays, steps)
    names = decode_words(counterparts, arrays["contact_counterparts"], "contact_counterparts")
    contacts = [
        Contact(seconds, impulse, (x, y), name)
        for (seconds, impulse, x, y), name in zip(arrays["contacts"].tolist(), names, strict=True)
    ]
    paths = np.split(arrays["path"], np.cumsum(arrays["path_lengths"])[:-1]) if steps else []
    ends = np.cumsum(arrays["contact_counts"]).tolist()
    rows = zip(
        arrays["motion_cells"].tolist(),
        arrays["motion_blocked"].tolist(),
        arrays["motion_seconds"].tolist(),
        arrays["motion_joules"].tolist(),
        paths,
        [0, *ends],
        ends,
        strict=False,
    )
    return [
        Outcome((row, col), blocked, seconds, joules, path, tuple(contacts[start:end]))
        for (row, col), blocked, seconds, joules, path, start, end in rows
    ]


def _check(arrays: Arrays, steps: int) -> None:
    for name in ("cells", "blocked", "seconds", "joules"):
        _expect(f"motion_{name}", len(arrays[f"motion_{name}"]), steps)
    for name in ("path_lengths", "contact_counts"):
        _expect(name, len(arrays[name]), steps)
    _expect("path columns", arrays["path"].shape[1], 4)
    _expect("contacts columns", arrays["contacts"].shape[1], 4)
    _expect("motion_cells columns", arrays["motion_cells"].shape[1], 2)
    _expect("path", len(arrays["path"]), int(arrays["path_lengths"].sum(dtype=np.int64)))
    counted = int(arrays["contact_counts"].sum(dtype=np.int64))
    _expect("contacts", len(arrays["contacts"]), counted)
    _expect("contact_counterparts", len(arrays["contact_counterparts"]), counted)
    if steps and (arrays["path_lengths"].min() < 2 or arrays["contact_counts"].min() < 0):
        raise RecordError("a path has fewer than two rows, or a count is negative")
    for name in ("motion_seconds", "motion_joules", "path", "contacts"):
        if not np.isfinite(arrays[name]).all():
            raise RecordError(f"{name} holds a number that is not finite")
    if min(arrays["motion_seconds"].min(initial=1), arrays["motion_joules"].min(initial=1)) <= 0:
        raise RecordError("a motion took no time or no energy")


def _expect(name: str, found: int, expected: int) -> None:
    if found != expected:
        raise RecordError(f"{name}: {found}; there must be {expected}")
