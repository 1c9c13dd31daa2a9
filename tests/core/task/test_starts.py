from itertools import permutations, product
from typing import Any

import numpy as np
import pytest

from warehouse_core import Layout, LayoutError
from warehouse_core.task.starts import (
    DRAWS,
    NO_RANK,
    Randomized,
    check_room,
    draw_episode,
    draw_ranks,
    has_start,
    motion_seed,
    randomized_parts,
)

BELOW_ONE = 1 - 2**-53
"""The largest random number."""


@pytest.mark.parametrize(
    ("uniforms", "expected"),
    [
        ((0, 0, 0, 0), [0, 1, 2]),
        ((BELOW_ONE, BELOW_ONE, BELOW_ONE, 0), [4, 3, 2]),
        # The third of 0 1 2 3 4, the third of 0 1 3 4, the second of 0 1 4.
        ((0.5, 0.5, 0.5, 0), [2, 3, 1]),
        # The fourth of 0 1 2 3 4, the second of 0 1 2 4, the second of 0 2 4.
        ((0.7, 0.4, 0.4, 0), [3, 1, 2]),
        ((0.3, 0, 0, BELOW_ONE), [1, 0, 2]),
        ((0, BELOW_ONE, BELOW_ONE, 0.3), [0, 4, 3]),
    ],
)
def test_each_cell_is_chosen_from_the_cells_that_are_left(uniforms, expected) -> None:
    assert draw_ranks(np.array(uniforms), 5).tolist() == expected


@pytest.mark.parametrize("count", [3, 5])
def test_every_triple_has_the_same_probability(count: int) -> None:
    places = product(range(count), range(count - 1), range(count - 2))
    middles = [
        [(i + 0.5) / count, (j + 0.5) / (count - 1), (k + 0.5) / (count - 2)] for i, j, k in places
    ]
    found = draw_ranks(np.array(middles), count)
    assert sorted(map(tuple, found.tolist())) == sorted(permutations(range(count), 3))


def test_with_only_two_cells_there_is_no_random_start() -> None:
    uniforms = np.array([[0, 0, 0, 0], [0.6, 0, 0.9, 0], [0.6, 0, 0.9, 0]])
    found = draw_ranks(uniforms, np.array([2, 2, 3]))
    assert found.tolist() == [[0, 1, NO_RANK], [1, 0, NO_RANK], [1, 0, 2]]


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


@pytest.mark.parametrize("randomized", [Randomized(True, True), Randomized(False, True)])
def test_nothing_random_is_on_a_charger(randomized: Randomized) -> None:
    before = Layout(["CP.C", ".CD.", "C.C."])
    empty = {cell for cell in product(range(3), range(4)) if before.rows[cell[0]][cell[1]] == "."}
    starts = set()
    for uniforms in np.random.default_rng(0).random((300, DRAWS)):
        layout, start = draw_episode(before, uniforms, randomized)
        assert layout.chargers == before.chargers
        assert layout.rows[start[0]][start[1]] == "."
        starts.add(start)
    assert starts == empty | set((before.pickups + before.dropoffs) * randomized.stations)


@pytest.mark.parametrize(
    ("rows", "randomized", "expected"),
    [
        (["..C"], Randomized(True, True), False),
        (["...C"], Randomized(True, True), True),
        (["PD.C"], Randomized(False, True), True),
        (["PDC"], Randomized(False, True), False),
    ],
)
def test_a_start_needs_a_cell_besides_stations_and_chargers(rows, randomized, expected) -> None:
    assert has_start(Layout(rows), randomized) is expected


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
