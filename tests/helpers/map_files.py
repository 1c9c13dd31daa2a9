"""Helpers for tests of map files and scenario files."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import strategies as st

from warehouse_core import LayoutError


@st.composite
def grids(draw: st.DrawFn) -> list[str]:
    width = draw(st.integers(1, 7))
    return draw(st.lists(st.text("#.PDC", min_size=width, max_size=width), min_size=1, max_size=7))


def refusal(load: Callable[[Path], Any], file: Path, data: str | bytes) -> str:
    """Return the error of a file, without the name of the file."""
    file.write_bytes(data.encode() if isinstance(data, str) else data)
    with pytest.raises(LayoutError) as caught:
        load(file)
    name, _, message = str(caught.value).partition(f"{file}: ")
    assert name == ""
    assert "\n" not in message
    return message
