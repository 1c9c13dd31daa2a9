import math
from typing import Any

import pytest

from warehouse_core import OrderStream
from warehouse_core.orders.order import OrderQueue


@pytest.mark.parametrize(
    ("settings", "error", "message"),
    [
        ({"rate": -0.1}, ValueError, r"^rate is -0.1; it must be at least 0 and finite$"),
        ({"start": -1}, ValueError, "^start is -1; it must be at least 0$"),
        ({"start": 2**31}, ValueError, "^start is 2147483648; it must be at most 2147483647$"),
        ({"due": (5, 4)}, ValueError, r"^due is \(5, 4\); it must be fewest and most steps"),
        ({"due": (-1, 4)}, ValueError, r"^due is \(-1, 4\)"),
        ({"due": (0, 2**31)}, ValueError, r"^due is \(0, 2147483648\)"),
        ({"due": 5}, TypeError, r"^due is 5; it must be two integers \(fewest, most\)$"),
        ({"pickup_weights": "12"}, TypeError, "^pickup_weights is '12'; it must be a tuple"),
        ({"pickup_weights": (1, -1)}, ValueError, r"^pickup_weights\[1\] is -1; it must be"),
        ({"dropoff_weights": (math.nan,)}, ValueError, r"^dropoff_weights\[0\] is nan"),
        ({"dropoff_weights": (0, 0)}, ValueError, r"^dropoff_weights is \(0, 0\); their sum must"),
        ({"pickup_weights": (1e308, 1e308)}, ValueError, "their sum must be above 0 and finite$"),
    ],
)
def test_a_stream_names_what_is_wrong(settings: Any, error: Any, message: str) -> None:
    with pytest.raises(error, match=message):
        OrderStream(**settings)
    if not {"rate", "start"} & set(settings):
        with pytest.raises(error, match=message):
            OrderQueue(3, **settings)
