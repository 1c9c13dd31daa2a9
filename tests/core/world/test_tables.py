import numpy as np
import pytest

from warehouse_core import Layout, LayoutError
from warehouse_core.world import tables as floor_tables
from warehouse_core.world.tables import LayoutSet, windows_table

SHOP = Layout(["P.#", "D.."])
LANE = Layout([".#P."])


def test_bare_layouts_keep_their_walls_but_no_stations() -> None:
    other = Layout(["..#", "PD."])
    bare = LayoutSet([SHOP, other, SHOP], [LANE, SHOP], bare=True)
    assert [layout.rows for layout in bare.rows] == [("..#", "...")] * 3
    assert bare.base.tolist() == [0, 0, 0], "layouts that are now equal are stored once"
    assert [layout.rows for layout in bare.others] == [(".#..",), ("..#", "...")]


def test_rows_change_to_layouts_that_are_known_and_to_new_ones() -> None:
    new = Layout(["....."])
    layouts = LayoutSet([LANE, LANE, LANE], [SHOP])
    base = layouts.base
    assert layouts.others == (SHOP,)
    layouts.change(np.array([2, 0]), [new, SHOP])
    assert layouts.kinds == (LANE, SHOP, new)
    assert layouts.rows == [SHOP, LANE, new]
    assert base.tolist() == [4, 0, 10], "in place, as others read it"
    assert layouts.width.tolist() == [3, 4, 5]


def test_windows_above_the_limit_raise_before_they_are_allocated(monkeypatch) -> None:
    monkeypatch.setattr(floor_tables, "_windows", lambda *_: pytest.fail("allocated"))
    with pytest.raises(
        LayoutError, match=r"windows of 20001 x 20001 for 2 layouts take 400\d{7} b"
    ):
        windows_table([SHOP, LANE], 10_000)
