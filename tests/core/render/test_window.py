"""The window for pictures, with a toolkit that only notes what it is told.

``tests/system/test_picture_window.py`` opens real ones.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.backend_bases import CloseEvent, KeyEvent
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.registry import backend_registry

from warehouse_core.errors import NoDisplayError
from warehouse_core.render import window as window_module
from warehouse_core.render.window import MAX_WAIT_SECONDS, PictureWindow

PICTURE = np.arange(20 * 30 * 3, dtype=np.uint8).reshape(20, 30, 3)


class Desktop:
    """A display, its clock, and all that windows have told it."""

    def __init__(self) -> None:
        self.now, self.told, self.sleeps = 100.0, list[Any](), list[float]()
        self.size = (0, 0)

    def sleep(self, seconds: float) -> None:
        self.sleeps.append(seconds)
        self.now += seconds

    def new_manager(self, figure: Any, number: int) -> Any:
        canvas = FigureCanvasAgg(figure)
        draw = canvas.draw

        def note_drawing() -> None:
            draw()
            self.told.append("drawn")

        canvas.draw = note_drawing  # type: ignore[method-assign]
        canvas.flush_events = lambda: self.told.append("events")  # type: ignore[method-assign]
        canvas.manager = SimpleNamespace(  # type: ignore[assignment]
            key_press_handler_id=canvas.mpl_connect("key_press_event", self.press),
            resize=self.resize,
            set_window_title=lambda title: self.told.append(title),
            show=lambda: self.told.append("open"),
            destroy=lambda: self.told.append("closed"),
        )
        return canvas.manager

    def resize(self, width: int, height: int) -> None:
        self.size = int(width), int(height)

    def press(self, event: object) -> None:
        self.told.append("key")


@pytest.fixture
def desktop(monkeypatch: pytest.MonkeyPatch) -> Desktop:
    desktop = Desktop()
    toolkit = SimpleNamespace(FigureCanvas=desktop)
    monkeypatch.setattr("matplotlib.pyplot.get_backend", lambda: "a toolkit")
    monkeypatch.setattr(backend_registry, "load_backend_module", lambda _: toolkit)
    monkeypatch.setattr(window_module, "has_display", lambda: True)
    clock = SimpleNamespace(monotonic=lambda: desktop.now, sleep=desktop.sleep)
    monkeypatch.setattr(window_module, "time", clock)
    return desktop


def test_a_browser_is_no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(window_module, "IS_IN_BROWSER", True)
    monkeypatch.setattr("matplotlib.pyplot.get_backend", lambda: "tkagg")
    monkeypatch.setattr("matplotlib.pyplot.switch_backend", lambda _: None)
    assert not window_module.may_have_display()
    assert not window_module.has_display()


def test_without_a_display_there_is_no_window(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(window_module, "has_display", lambda: False)
    with pytest.raises(NoDisplayError, match='render_mode="human" needs a window'):
        PictureWindow("a title")


def test_a_window_opens_with_its_first_picture_and_shows_the_next(desktop: Desktop) -> None:
    shown: Any = PictureWindow("a title")
    assert not desktop.told
    shown.show(PICTURE, 10.0)
    assert [each for each in desktop.told if each != "events"] == ["a title", "open", "drawn"]
    shown.show(PICTURE[::-1], 10.0)
    assert [each for each in desktop.told if each != "events"][3:] == ["drawn"]
    pixels = np.asarray(shown._canvas.buffer_rgba())[..., :3]
    assert (pixels == PICTURE[::-1]).all(), "pixel by pixel"
    shown._canvas.callbacks.process(
        "key_press_event", KeyEvent("key_press_event", shown._canvas, "q")
    )
    assert "key" not in desktop.told, "keys of Matplotlib do nothing"
    assert shown._image.axes.axison is False
    assert desktop.told.count("events") >= 4


def test_pictures_come_at_their_pace_and_events_are_handled_while_they_wait(desktop) -> None:
    shown = PictureWindow("a title")
    shown.show(PICTURE, 10.0)
    assert desktop.now == pytest.approx(100.1)
    assert max(desktop.sleeps) == MAX_WAIT_SECONDS
    assert desktop.told.count("events") > 10
    desktop.now += 0.03  # of the program
    shown.show(PICTURE, 10.0)
    assert desktop.now == pytest.approx(100.2)
    desktop.now += 0.5
    desktop.sleeps.clear()
    shown.show(PICTURE, 10.0)
    assert (desktop.now, desktop.sleeps) == (pytest.approx(100.7), [])
    shown.show(PICTURE, 10.0)
    assert desktop.now == pytest.approx(100.8), "what was late is not made up for"


@pytest.mark.parametrize(("ratio", "times"), [(1.0, 1), (1.25, 1), (1.75, 2), (2.0, 2), (0.4, 1)])
def test_a_window_has_whole_pixels_of_the_screen(desktop, ratio, times) -> None:
    shown: Any = PictureWindow("a title")
    shown.show(PICTURE, 1000.0)
    shown._canvas._set_device_pixel_ratio(ratio)
    for picture in (PICTURE, PICTURE[:8, :12]):
        height, width = picture.shape[:2]
        shown.show(picture, 1000.0)
        assert desktop.size == (times * width, times * height)
        assert shown._image.get_extent() == [0, width, height, 0]
        desktop.size = (0, 0)
        shown.show(picture, 1000.0)
        assert desktop.size == (0, 0), "it has that size"


@pytest.mark.parametrize("by_hand", [True, False])
def test_a_window_that_was_closed_stays_closed(desktop: Desktop, by_hand: bool) -> None:
    shown: Any = PictureWindow("a title")
    shown.show(PICTURE, 10.0)
    assert not shown.is_closed
    if by_hand:
        shown._canvas.callbacks.process("close_event", CloseEvent("close_event", shown._canvas))
    else:
        shown.close()
    assert shown.is_closed
    before, now = [*desktop.told], desktop.now
    shown.show(PICTURE, 10.0)
    shown.close()
    assert (desktop.told, desktop.now) == (before, now)
    assert desktop.told.count("closed") == (not by_hand)


def test_a_window_may_be_closed_before_it_opens_and_while_a_picture_waits(desktop: Desktop) -> None:
    early = PictureWindow("a title")
    early.close()
    early.show(PICTURE, 10.0)
    assert not desktop.told
    shown: Any = PictureWindow("another")
    shown.show(PICTURE, 10.0)
    shown._canvas.flush_events = shown.close
    shown.show(PICTURE, 10.0)
    assert desktop.told.count("drawn") == 1
    assert desktop.now == pytest.approx(100.1)
