"""Pictures in real windows. Run with ``pytest -m window``."""

from collections.abc import Callable

import numpy as np
import pytest
from helpers.windows import Shower
from numpy.typing import NDArray

from warehouse_core import DEFAULT_LAYOUT
from warehouse_core.render.painter import TilePainter

in_a_window = pytest.mark.window


BEGIN = """
import sys, time
from warehouse_core import DEFAULT_LAYOUT
from warehouse_core.render.window import PictureWindow
from warehouse_core.render.painter import TilePainter

def painted(pixels, row, col):
    return TilePainter(pixels).picture(DEFAULT_LAYOUT, (row, col), False)

def show_forever(picture):
    while True:
        window.show(picture, 50)
        print("closed" if window.is_closed else "open", flush=True)
        if window.is_closed:
            time.sleep(0.05)

window = PictureWindow("Warehouse")
"""


def painted(pixels: int, row: int, col: int) -> NDArray[np.uint8]:
    return TilePainter(pixels).picture(DEFAULT_LAYOUT, (row, col), False)


Start = Callable[[str], Shower]


@pytest.fixture
def start(start: Callable[..., Shower]) -> Start:
    """Return a function that starts a program with a window that is not open yet."""
    return lambda text: start(BEGIN + text)


@in_a_window
@pytest.mark.parametrize("pixels", [9, 40])
def test_a_picture_is_shown_pixel_by_pixel(start: Start, pixels: int) -> None:
    program = start(f"show_forever(painted({pixels}, 1, 1))")
    program.wait_for("open", 2)
    assert program.shows(program.focus(), painted(pixels, 1, 1))


@in_a_window
def test_an_enlarged_window_keeps_its_size_and_scales_the_picture(start: Start) -> None:
    program = start("show_forever(painted(20, 1, 1))")
    program.wait_for("open", 2)
    window, picture = program.focus(), painted(20, 1, 1)
    height, width = picture.shape[:2]
    program.resize(window, 3 * width, 2 * height)
    program.wait_for("open", 10)
    doubled = picture.repeat(2, axis=0).repeat(2, axis=1)
    margin = np.full((2 * height, width // 2, 3), 255, np.uint8)
    assert program.shows(window, np.concatenate([margin, doubled, margin], axis=1))


@in_a_window
def test_a_window_closed_by_the_user_stays_closed(start: Start) -> None:
    program = start("show_forever(painted(20, 1, 1))")
    program.wait_for("open", 2)
    program.ask_to_close(program.focus())
    program.wait_for("closed", 5)
    assert program.windows() == []
