from pathlib import Path

import pytest

from warehouse_core import Order, OrderError
from warehouse_core.errors import WarehouseError
from warehouse_core.orders import files, load_orders, save_orders

HEAD = "released,due,pickup_row,pickup_col,dropoff_row,dropoff_col,robot\n"
ORDERS = [Order(0, 20, (1, 2), (3, 4)), Order(5, 5, (0, 0), (0, 1), robot=2)]


def test_orders_come_back_from_their_file_as_they_were_given(tmp_path: Path) -> None:
    path = tmp_path / "orders.csv"
    save_orders(path, [ORDERS[0]._replace(taken_by=1, taken=2, delivered=9), ORDERS[1]])
    assert path.read_bytes() == f"{HEAD}0,20,1,2,3,4,\n5,5,0,0,0,1,2\n".encode()
    assert load_orders(path) == ORDERS
    save_orders(str(path), [])
    assert load_orders(str(path)) == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1: the column 'released' is missing"),
        ("0,20,1,2,3,4,\n", "line 1: the column 'released' is missing"),
        (HEAD.replace("robot", "due"), "line 1: the column 'due' is there twice"),
        (HEAD + "0,20,1,2,3,4\n", "line 2: 6 fields, not 7"),
        (HEAD + "0,20,1,2,3,4,1,9,9\n", "line 2: 9 fields, not 7"),
        (HEAD + "0,20,1,2,3,4,\n0,x,1,2,3,4,\n", "line 3: due is 'x'; allowed: a whole number of"),
        (HEAD + "\n-1,20,1,2,3,4,\n", "line 3: released is '-1'; allowed: a whole number of at l"),
        (HEAD + "0,20,1,2,3,,\n", "line 2: dropoff_col is ''; allowed: a whole number"),
        (HEAD + "0,20,1,2,3,4,1.5\n", r"line 2: robot is '1\.5'; allowed: a whole number"),
        (HEAD + "0,2\xb2,1,2,3,4,\n", "line 2: due is '2\xb2'; allowed: a whole number"),
    ],
)
def test_a_bad_line_is_named(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "orders.csv"
    path.write_bytes(text.encode())
    with pytest.raises(OrderError, match=f"orders.csv: {message}") as caught:
        load_orders(path)
    assert isinstance(caught.value, WarehouseError)


def test_a_file_is_not_read_beyond_its_limits(tmp_path, monkeypatch) -> None:
    path = tmp_path / "orders.csv"
    save_orders(path, ORDERS)
    monkeypatch.setattr(files, "MAX_ORDERS", 1)
    with pytest.raises(OrderError, match="more than MAX_ORDERS = 1 orders"):
        load_orders(path)
    path.write_bytes(HEAD.encode() + b"1" * 10**6)
    with pytest.raises(OrderError, match="line 2: field larger than field limit"):
        load_orders(path)
    monkeypatch.setattr(files, "MAX_BYTES", 1000)
    with pytest.raises(OSError, match="it is longer than 1,000 bytes"):
        load_orders(path)
    path.write_bytes(HEAD.encode() + b"\xff")
    with pytest.raises(OrderError, match="line 2: can't decode byte 0xff"):
        load_orders(path)
    with pytest.raises(FileNotFoundError):
        load_orders(tmp_path / "none.csv")
