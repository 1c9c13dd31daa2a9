"""Layouts in files of either format, told apart by the suffix."""

from pathlib import Path

import pytest

from warehouse_core import Layout, LayoutError
from warehouse_core.world.map_files import load_layout, save_layout

HALL = Layout(["####", "#P.#", "#.D#", "####"])


@pytest.mark.parametrize("name", ["hall.txt", "hall", "hall.map.txt"])
def test_rows_of_tiles_keep_their_stations(tmp_path: Path, name: str) -> None:
    save_layout(HALL, tmp_path / name)
    assert load_layout(tmp_path / name) == HALL


@pytest.mark.parametrize("name", ["hall.map", "HALL.MAP"])
def test_a_map_of_movingai_has_the_same_walls(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    save_layout(HALL, path)
    assert path.read_text().startswith("type octile\n")
    assert load_layout(path) == HALL.with_stations(None, None)


def test_the_suffix_decides(tmp_path: Path) -> None:
    path = tmp_path / "hall.map"
    HALL.save(path)
    with pytest.raises(LayoutError, match="line 1"):
        load_layout(path)
