from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import Contact, Episode, Outcome, RecordError
from warehouse_core.files.npz import Arrays
from warehouse_core.records.arrays import (
    MAX_NUMBER,
    MOTION_SCHEMA,
    decode_words,
    encode_words,
    pack_motions,
    unpack_motions,
)

floats = st.floats(-MAX_NUMBER, MAX_NUMBER)
contacts = st.builds(
    Contact, floats, floats, st.tuples(floats, floats), st.sampled_from(["wall", "robot 3"])
)
paths = st.lists(st.tuples(floats, floats, floats, floats), min_size=2, max_size=5).map(np.array)
amounts = st.floats(0, MAX_NUMBER, exclude_min=True)
outcomes = st.builds(
    Outcome,
    st.tuples(st.integers(0, 2**31 - 1), st.integers(0, 2**31 - 1)),
    st.booleans(),
    amounts,
    amounts,
    paths,
    st.lists(contacts, max_size=3).map(tuple),
    st.just(False),
)

STRAIGHT = np.array([[0.0, 0.5, 0.5, 0.0], [1.0, 1.5, 0.5, 0.0]])
TWO = [
    Outcome((0, 1), False, 1.0, 2.0, STRAIGHT),
    Outcome((0, 1), True, 1.0, 2.0, STRAIGHT, (Contact(0.5, 9.0, (2.0, 0.5), "wall"),) * 2),
]


def packed(motions: list[Outcome]) -> tuple[Arrays, dict[str, Any]]:
    """Return the arrays with the dtypes that they have in a file."""
    arrays, header = pack_motions(motions)
    typed = {name: arrays[name].astype(dtype) for name, (dtype, _) in MOTION_SCHEMA.items()}
    return typed, header


@settings(max_examples=20)
@given(st.lists(outcomes, max_size=6))
def test_outcomes_load_as_they_were_packed(motions: list[Outcome]) -> None:
    arrays, header = packed(motions)
    assert {name: array.ndim for name, array in arrays.items()} == {
        name: dimensions for name, (_, dimensions) in MOTION_SCHEMA.items()
    }
    assert unpack_motions(arrays, header, len(motions)) == motions


@settings(max_examples=30)
@given(st.lists(st.text(max_size=2) | st.integers()))
def test_words_load_in_their_order(words: list[str | int]) -> None:
    vocabulary, codes = encode_words(words)
    assert len(set(vocabulary)) == len(vocabulary)
    assert decode_words(vocabulary, codes, "words") == words


@pytest.mark.parametrize("code", [-1, 2])
def test_a_code_beyond_the_vocabulary_raises(code: int) -> None:
    with pytest.raises(RecordError, match=r"words has a code outside 0\.\.1"):
        decode_words(["a", "b"], np.array([0, code], dtype=np.int32), "words")
    with pytest.raises(RecordError, match="words has a code outside"):
        decode_words([], np.array([0], dtype=np.int32), "words")


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"motion_cells": np.zeros((1, 2), int)}, "motion_cells: 1; there must be 2"),
        ({"motion_cells": np.zeros((2, 3), int)}, "motion_cells columns: 3; there must be 2"),
        ({"motion_blocked": np.zeros(3, bool)}, "motion_blocked: 3; there must be 2"),
        ({"motion_seconds": np.zeros(0)}, "motion_seconds: 0; there must be 2"),
        ({"motion_joules": np.zeros(1)}, "motion_joules: 1; there must be 2"),
        ({"path_lengths": np.array([4])}, "path_lengths: 1; there must be 2"),
        ({"path_lengths": np.array([2, 3])}, "path: 4; there must be 5"),
        ({"path_lengths": np.array([1, 3])}, "fewer than two rows"),
        ({"path_lengths": np.array([-2, 6])}, "fewer than two rows"),
        ({"path_lengths": np.array([2**31 - 1] * 2, "<i4")}, "path: 4; there must be 4294967294"),
        ({"path": np.zeros((4, 3))}, "path columns: 3; there must be 4"),
        ({"path": np.zeros((5, 4))}, "path: 5; there must be 4"),
        ({"contacts": np.zeros((2, 5))}, "contacts columns: 5; there must be 4"),
        ({"contacts": np.zeros((3, 4))}, "contacts: 3; there must be 2"),
        ({"contact_counts": np.array([0, 1])}, "contacts: 2; there must be 1"),
        ({"contact_counts": np.array([-1, 3])}, "a count is negative"),
        ({"contact_counts": np.array([2])}, "contact_counts: 1; there must be 2"),
        ({"contact_counterparts": np.array([0])}, "contact_counterparts: 1; there must be 2"),
        ({"contact_counterparts": np.array([0, 7])}, "contact_counterparts has a code outside"),
    ],
)
def test_inconsistent_arrays_raise(changed: Arrays, message: str) -> None:
    arrays, header = packed(TWO)
    with pytest.raises(RecordError) as caught:
        unpack_motions(arrays | changed, header, 2)
    assert message in str(caught.value)


@pytest.mark.parametrize("name", ["motion_seconds", "motion_joules", "path", "contacts"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1.1e12])
def test_a_number_that_is_too_large_raises(name: str, value: float) -> None:
    arrays, header = packed(TWO)
    arrays[name].flat[-1] = value
    with pytest.raises(RecordError, match=rf"{name} has a number outside -1e\+12..1e\+12"):
        unpack_motions(arrays, header, 2)


def test_motions_are_checked_when_a_record_is_loaded(
    arrays: Arrays, load_changed: Callable[..., Any], episode: Episode
) -> None:
    assert load_changed() == episode
    lengths = arrays["path_lengths"].copy()
    lengths[0] += 1
    with pytest.raises(RecordError, match=r"changed\.npz: path: 120; there must be 121"):
        load_changed(path_lengths=lengths)


@pytest.mark.parametrize(
    ("name", "amount"), [("motion_seconds", 0.0), ("motion_seconds", -1.0), ("motion_joules", -1.0)]
)
def test_a_motion_takes_some_time_and_no_negative_energy(name: str, amount: float) -> None:
    arrays, header = packed(TWO)
    arrays[name][1] = amount
    with pytest.raises(RecordError, match="no time, or less than no energy"):
        unpack_motions(arrays, header, len(TWO))
