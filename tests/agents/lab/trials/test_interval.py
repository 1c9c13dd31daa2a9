"""Intervals: their widths, their estimates, and how they are written."""

import numpy as np
import pytest

from agents.lab.trials.interval import (
    MIN_VALUES,
    Interval,
    difference_interval,
    mean,
    mean_interval,
    paired_share_interval,
    percent,
    ratio_interval,
    share,
    share_interval,
)


@pytest.mark.parametrize(
    ("count", "total", "low", "high"),
    # By hand, from (p + z^2/2n +- z sqrt(p(1-p)/n + z^2/4n^2)) / (1 + z^2/n) with z = 1.959964;
    # the values for 81 of 263 are in Newcombe, Statistics in Medicine 17, 1998, table I.
    [(0, 10, 0.0, 0.277533), (5, 10, 0.236593, 0.763407), (81, 263, 0.255289, 0.366210),
     (10, 10, 0.722467, 1.0), (1, 1, 0.206549, 1.0)],
)  # fmt: skip
def test_a_share_has_the_wilson_interval(count: int, total: int, low: float, high: float) -> None:
    assert share_interval(count, total) == pytest.approx((count / total, low, high), abs=1e-6)


def test_the_difference_of_paired_shares_has_the_interval_of_bonett_and_price() -> None:
    # By hand: (21 - 6) / 102 +- z sqrt((27 / 102 - (15 / 102)^2) / 102).
    assert paired_share_interval(20, 5, 100) == pytest.approx((0.15, 0.051379, 0.242739), abs=1e-6)
    assert paired_share_interval(5, 20, 100).low == pytest.approx(-0.242739, abs=1e-6)
    assert paired_share_interval(9, 0, 9).high == 1


def test_the_difference_of_independent_shares_has_the_interval_of_newcombe() -> None:
    # Newcombe, Statistics in Medicine 17, 1998, page 873, table II, method 10: 56/70 - 48/80.
    found = difference_interval(share_interval(56, 70), share_interval(48, 80))
    assert found == pytest.approx((0.2, 0.0524, 0.3339), abs=1e-4)
    assert not difference_interval(Interval(1.0), Interval(0.5, 0.4, 0.6)).is_known


def test_the_interval_of_a_mean_is_as_wide_as_for_a_normal_distribution() -> None:
    values = np.random.default_rng(1).normal(50, 10, 4000)
    found = mean_interval(values)
    assert found is not None
    reach = 1.96 * values.std() / np.sqrt(len(values))
    assert found.estimate == pytest.approx(values.mean())
    assert found.estimate - found.low == pytest.approx(reach, rel=0.1)
    assert found.high - found.estimate == pytest.approx(reach, rel=0.1)


def test_the_interval_of_a_mean_is_longer_on_the_side_of_outliers() -> None:
    found = mean_interval(np.array([1.0, 2.0] * 20 + [100.0] * 4))
    assert found is not None
    assert found.high - found.estimate > 1.5 * (found.estimate - found.low)


def test_values_that_are_nearly_all_equal_have_no_interval() -> None:
    found = mean_interval(np.array([0.1] * 39 + [100.0]))
    assert found is not None
    assert found.estimate == pytest.approx(2.5975)
    assert not found.is_known


def test_a_ratio_has_the_error_of_its_linearisation() -> None:
    stream = np.random.default_rng(5)
    delivered = stream.random(3000) < 0.4
    costs = np.where(delivered, stream.exponential(15, 3000), 200.0)
    found = ratio_interval(costs, delivered)
    assert found is not None
    ratio = costs.sum() / delivered.sum()
    assert found.estimate == pytest.approx(ratio)
    error = np.sqrt(((costs - ratio * delivered) ** 2).sum()) / delivered.sum()
    assert found.high - found.low == pytest.approx(2 * 1.96 * error, rel=0.1)


@pytest.mark.parametrize(("count", "is_known"), [(MIN_VALUES - 1, False), (MIN_VALUES, True)])
def test_a_ratio_to_few_successes_has_no_interval(count: int, is_known: bool) -> None:
    found = ratio_interval(np.arange(100.0), np.arange(100) < count)
    assert found is not None
    assert found.estimate == pytest.approx(4950 / count)
    assert found.is_known is is_known
    assert ratio_interval(np.arange(5.0), np.zeros(5, bool)) is None


def test_few_values_have_no_interval_and_equal_values_have_one_of_width_zero() -> None:
    assert mean_interval(np.array([])) is None
    assert mean_interval(np.full(MIN_VALUES, 7.0)) == Interval(7.0, 7.0, 7.0)
    few = mean_interval(np.arange(MIN_VALUES - 1, dtype=float))
    assert few is not None
    assert few.estimate == (MIN_VALUES - 2) / 2
    assert not few.is_known
    enough = mean_interval(np.arange(MIN_VALUES, dtype=float))
    assert enough is not None
    assert enough.is_known


def test_a_share_has_its_interval_in_brackets() -> None:
    assert share(Interval(0.8744, 0.852, 0.8931)) == "87.4% (85.2 to 89.3)"


@pytest.mark.parametrize(
    ("estimate", "words"),
    [(0.05, "0.05 s (0.05 to 0.05)"), (9.99, "9.99 s (9.99 to 9.99)"),
     (48.91, "48.9 s (48.9 to 48.9)"), (107.4, "107 s (107 to 107)"),
     (3863.2, "3,863 s (3,863 to 3,863)"), (-12.34, "-12.3 s (-12.3 to -12.3)")],
)  # fmt: skip
def test_a_mean_has_three_digits_or_all_of_its_integer_part(estimate: float, words: str) -> None:
    assert mean(Interval(estimate, estimate, estimate), "s") == words


def test_a_mean_without_an_interval_has_no_limits() -> None:
    assert mean(Interval(20), "steps") == "20.0 steps"
    assert mean(Interval(20, 10, 30), "") == "20.0 (10.0 to 30.0)"


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (0, "0%"),
        (0.001, "<1%"),
        (0.005, "0%"),
        (0.126, "13%"),
        (0.96, "96%"),
        (0.996, ">99%"),
        (1, "100%"),
    ],
)
def test_a_share_is_not_rounded_to_none_or_all(part: float, words: str) -> None:
    assert percent(part) == words
