from itertools import permutations, product
from typing import Any

import numpy as np
import pytest

from warehouse_core import Layout, LayoutError
from warehouse_core.task.starts import DRAWS, check_room, draw_ranks, motion_seed, randomized_parts

BELOW_ONE = 1 - 2**-53
"""The largest random number."""


@pytest.mark.parametrize("count", [3, 5])
def test_every_triple_has_the_same_probability(count: int) -> None:
    places = product(range(count), range(count - 1), range(count - 2))
    middles = [
        [(i + 0.5) / count, (j + 0.5) / (count - 1), (k + 0.5) / (count - 2)] for i, j, k in places
    ]
    found = draw_ranks(np.array(middles), count)
    assert sorted(map(tuple, found.tolist())) == sorted(permutations(range(count), 3))


def test_the_seed_of_the_motion_is_the_last_number() -> None:
    assert motion_seed(np.array([0.1, 0.2, 0.3, 0.5])) == 2**31
    assert motion_seed(np.array([0.9, 0.9, 0.9, 0.0])) == 0
    assert motion_seed(np.array([0, 0, 0, BELOW_ONE])) == 2**32 - 1
    assert type(motion_seed(np.zeros(DRAWS))) is int


def test_a_layout_needs_room_for_pickup_and_dropoff() -> None:
    check_room(Layout(["P#D"]))
    with pytest.raises(LayoutError, match=r"needs two open cells .*; the layout has 1"):
        check_room(Layout(["P##"]))
    with pytest.raises(LayoutError, match=r"needs two open .*; the layout has 1 without a charg"):
        check_room(Layout(["P#CC"]))


@pytest.mark.parametrize(
    ("randomize", "parts"),
    [
        (False, (False, False)),
        (True, (True, True)),
        ("stations", (True, False)),
        ("start", (False, True)),
        (0, (False, False)),
        (np.True_, (True, True)),
    ],
)
def test_a_value_of_randomize_says_which_parts_are_random(randomize, parts) -> None:
    assert randomized_parts(randomize) == parts


@pytest.mark.parametrize("randomize", ["all", "", 2, 1.0, None, [True], np.zeros(2)])
def test_other_values_of_randomize_are_refused(randomize: Any) -> None:
    """A float is refused although it equals a flag."""
    with pytest.raises(ValueError, match=r"^randomize is .*; allowed: False, True, 'stations', "):
        randomized_parts(randomize)
