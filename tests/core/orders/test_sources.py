from typing import Any

import numpy as np
import pytest

from warehouse_core import Layout, LayoutError, Order, OrderError, OrderStream
from warehouse_core.orders import sources
from warehouse_core.orders.order import OPEN, OrderQueue
from warehouse_core.orders.sources import ListedOrders, QueuedOrders, RandomOrders

HALL = Layout(["PPP.D", "..#C.", "....D"])
PICKUPS, DROPOFFS = [0, 1, 2], [4, 14]
GOOD = Order(0, 9, (0, 0), (0, 4))


def random_orders(*streams: OrderStream, steps: int = 100_000, seed: int = 1) -> Any:
    return RandomOrders(streams, HALL, steps).draw(np.random.default_rng(seed))


def shares(cells: Any, among: list[int]) -> list[float]:
    """Return the share of each of these cells in all chosen cells."""
    found = [(cells == cell).mean() for cell in among]
    assert sum(found) == pytest.approx(1)
    return found


def test_a_stream_is_a_poisson_process() -> None:
    orders = random_orders(OrderStream(0.3, due=(10, 20)))
    assert len(orders.released) == pytest.approx(30_000, rel=0.03)
    assert (np.diff(orders.released) >= 0).all()
    in_a_step = np.bincount(orders.released, minlength=100_000)
    assert len(in_a_step) == 100_000
    assert in_a_step.var() == pytest.approx(0.3, rel=0.03)  # the mean, as it is in no other process
    due = orders.due - orders.released
    assert (due.min(), due.max()) == (10, 20)
    assert due.mean() == pytest.approx(15, rel=0.01)
    assert shares(orders.pickup, PICKUPS) == pytest.approx([1 / 3] * 3, abs=0.01)
    assert shares(orders.dropoff, DROPOFFS) == pytest.approx([0.5] * 2, abs=0.01)
    assert set(orders.robot.tolist()) == {OPEN}


def test_stations_occur_in_proportion_to_their_weights() -> None:
    orders = random_orders(OrderStream(0.3, pickup_weights=(0, 3, 1), dropoff_weights=(1, 0)))
    assert shares(orders.pickup, PICKUPS) == pytest.approx([0, 0.75, 0.25], abs=0.01)
    assert shares(orders.dropoff, DROPOFFS) == [1, 0]


def test_streams_follow_one_another() -> None:
    orders = random_orders(
        OrderStream(0.5, start=20_000, pickup_weights=(1, 0, 0)),
        OrderStream(0, start=40_000),
        OrderStream(0.1, due=(7, 7), start=60_000, pickup_weights=(0, 1, 0)),
        OrderStream(9, start=100_000),
    )
    counts = np.histogram(orders.released, [0, 20_000, 40_000, 60_000, 100_000])[0].tolist()
    assert counts[0] == counts[2] == 0
    assert counts[1] == pytest.approx(10_000, rel=0.05)
    assert counts[3] == pytest.approx(4_000, rel=0.07)
    late = orders.released >= 60_000
    assert set(orders.pickup[late].tolist()) == {1}
    assert set((orders.due - orders.released)[late].tolist()) == {7}
    assert set(orders.pickup[~late].tolist()) == {0}


def test_listed_orders_come_in_order_of_release() -> None:
    late, first = GOOD._replace(released=5, robot=1), GOOD._replace(pickup=[1, 1], due=0)  # type: ignore[arg-type]
    orders = ListedOrders([late, first, GOOD], HALL, 2).draw(np.random.default_rng(0))
    assert orders.released.tolist() == [0, 0, 5]
    assert orders.due.tolist() == [0, 9, 9]
    assert orders.pickup.tolist() == [6, 0, 0]
    assert orders.dropoff.tolist() == [4, 4, 4]
    assert orders.robot.tolist() == [OPEN, OPEN, 1]


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"pickup": (1, 2)}, OrderError, "order 1: pickup row 1, column 2 is wall; it must be"),
        ({"dropoff": (3, 0)}, OrderError, "order 1: dropoff row 3, column 0 is off the grid"),
        ({"dropoff": (1, 3)}, OrderError, "order 1: dropoff row 1, column 3 is charger; a charger"),
        ({"pickup": (1, 3)}, OrderError, "order 1: pickup row 1, column 3 is charger; a charger"),
        ({"pickup": [0, 4]}, OrderError, "order 1: pickup and dropoff are both"),
        ({"released": 10}, OrderError, "order 1: released at 10 and due at 9; needed: 0 <= "),
        ({"released": -1}, OrderError, "order 1: released at -1 and due at 9"),
        ({"due": 2**31}, OrderError, "order 1: released at 0 and due at 2147483648"),
        ({"robot": 2}, OrderError, r"order 1: robot 2; allowed: 0\.\.1, or none"),
        ({"robot": -1}, OrderError, "order 1: robot -1"),
    ],
)
def test_an_order_names_what_is_wrong(changes: Any, error: Any, message: str) -> None:
    with pytest.raises(error, match=f"^{message}"):
        ListedOrders([GOOD, GOOD._replace(**changes)], HALL, 2)


@pytest.mark.parametrize(
    ("streams", "message"),
    [
        ([OrderStream(start=5), OrderStream(start=5)], r"the streams start at \[5, 5\]; each must"),
        ([OrderStream(start=5), OrderStream()], r"the streams start at \[5, 0\]"),
        ([OrderStream(pickup_weights=(1, 1))], "2 pickup_weights for the layout's 3 pickups"),
        ([OrderStream(1001)], r"the rate 1001 leads to about 1001000 orders in 1000 steps; MAX_O"),
        ([OrderStream(1e308)], "the rate 1e[+]308 leads to about inf orders"),
    ],
)
def test_streams_name_what_is_wrong(streams: Any, message: str) -> None:
    with pytest.raises(OrderError, match=f"^{message}"):
        RandomOrders(streams, HALL, 1000)


def test_there_are_limits_and_stations(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(LayoutError, match=r"^the layout has no dropoff; random orders need one"):
        RandomOrders([OrderStream()], Layout(["P.."]), 10)
    with pytest.raises(LayoutError, match=r"^the layout has no pickup; random orders"):
        QueuedOrders(OrderQueue(1), Layout(["D.."]))
    monkeypatch.setattr(sources, "MAX_ORDERS", 1)
    with pytest.raises(OrderError, match=r"^2 orders are more than MAX_ORDERS = 1$"):
        ListedOrders([GOOD, GOOD], HALL, 1)
    assert len(ListedOrders([GOOD], HALL, 1).draw(np.random.default_rng(0)).released) == 1
    RandomOrders([OrderStream(0.125)], HALL, 8)
    with pytest.raises(OrderError, match="MAX_ORDERS = 1"):
        RandomOrders([OrderStream(0.125)], HALL, 9)
