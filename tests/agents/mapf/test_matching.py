import sys

import numpy as np
import pytest

from agents.mapf.matching import cheapest_matching


def test_without_scipy_the_same_rows_and_columns_match_ties_included(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stream = np.random.default_rng(0)
    drawn = [stream.integers(-3, span, stream.integers(0, 10, 2)) for span in (0, 1, 3, 99) * 100]
    expected = [cheapest_matching(costs.astype(np.float64)) for costs in drawn]
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    for costs, pairs in zip(drawn, expected, strict=True):
        assert np.array_equal(cheapest_matching(costs.astype(np.float64)), pairs)


def test_the_cheapest_pair_gives_way_to_the_cheapest_sum() -> None:
    rows, columns = cheapest_matching(np.array([[1.0, 2.0, 9.0], [1.0, 9.0, 9.0]]))
    assert (rows.tolist(), columns.tolist()) == ([0, 1], [1, 0])
