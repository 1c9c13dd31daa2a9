import math

import pytest

from warehouse_core.viz.player.tracks import Columns


@pytest.mark.parametrize("values", [[2**31 - 0.4], [0, 2**31 - 1, -1], [math.nan], [math.inf] * 2])
def test_numbers_or_differences_that_32_bits_cannot_hold_are_refused(values: list[float]) -> None:
    with pytest.raises(ValueError, match="32 bits"):
        Columns().whole(values, is_delta=True)
