"""A fixture that times two calls in turn, so that a change of the machine's speed affects both."""

from collections.abc import Callable
from statistics import median

import pytest
from helpers.timing import seconds

ROUNDS = 7


@pytest.fixture
def times_faster(benchmark, capsys):
    """Return a function that measures how many times faster ``ours`` is than ``baseline``.

    Both run once unmeasured and then in turn; the median of the ratios counts. The ratio is
    printed, and stored with the figures of pytest-benchmark for ``ours``.
    """

    def measure(
        ours: Callable[[], object], baseline: Callable[[], object], rounds: int = ROUNDS
    ) -> float:
        ours(), baseline()
        pairs = [(seconds(ours), seconds(baseline)) for _ in range(rounds)]
        ratio = median(theirs / mine for mine, theirs in pairs)
        benchmark.extra_info["times faster than the baseline"] = round(ratio, 2)
        with capsys.disabled():
            mine, theirs = (median(column) for column in zip(*pairs, strict=True))
            print(f"\n{benchmark.name}: {mine:.3g} s to {theirs:.3g} s, ratio {ratio:.2f}")
        benchmark.pedantic(ours, rounds=1)
        return ratio

    return measure
