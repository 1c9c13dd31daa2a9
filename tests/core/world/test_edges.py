import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core.world.edges import Edges


@st.composite
def networks(draw: st.DrawFn) -> Edges:
    """Return random edges in both directions, of different costs, between a few nodes."""
    nodes = draw(st.integers(1, 12))
    pairs = st.tuples(st.integers(0, nodes - 1), st.integers(0, nodes - 1))
    directed = sorted({pair for pair in draw(st.lists(pairs, max_size=30)) if len({*pair}) == 2})
    both = sorted({*directed, *((end, start) for start, end in directed)})
    starts, ends = np.array(both, np.intp).reshape(-1, 2).T
    stream = np.random.default_rng(draw(st.integers(0, 99)))
    return Edges(starts, ends, stream.choice([0.1, 0.7, 1.0, 3.0], len(both)), nodes)


def without_scipy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy.sparse.csgraph", None)


@settings(max_examples=100)
@given(networks(), st.data())
def test_costs_of_paths_are_the_same_bits_without_scipy(network, data) -> None:
    nodes = len(network.parts())
    sources = data.draw(st.lists(st.integers(0, nodes - 1), min_size=1, max_size=3, unique=True))
    expected, parts = network.cheapest(sources), network.parts()
    with pytest.MonkeyPatch.context() as patch:
        without_scipy(patch)
        assert network.cheapest(sources).tobytes() == expected.tobytes()
        found = network.parts()
    assert ((found[:, None] == found) == (parts[:, None] == parts)).all()


@pytest.mark.parametrize("has_scipy", [True, False])
def test_a_longer_path_may_be_cheaper(has_scipy: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not has_scipy:
        without_scipy(monkeypatch)
    starts, ends, costs = np.array([0, 0, 1]), np.array([2, 1, 2]), np.array([3.0, 1.0, 1.0])
    assert Edges(starts, ends, costs, 4).cheapest([0]).tolist() == [0.0, 1.0, 2.0, np.inf]
