"""Helpers for tests of pictures: a short episode, and the colours in a drawn figure."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.backend_bases import KeyEvent
from numpy.typing import NDArray

from warehouse_core import Episode, EpisodeRecorder, Layout, WarehouseEnv
from warehouse_core.viz.replay import Replay
from warehouse_core.warehouse_viz import replay_animation

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])
DELIVERY = (("N", "why not"), ("W", ""), ("PICK", ""), ("E", ""), ("E", ""), ("DROP", ""))

HOSTILE_NAMES = (
    "</title>]]>--><script>alert(1)</script>\"><img src='http://example.com/x' onerror=alert(1)>",
    "$\\frac$ & $x",
    "a\nb\tc\x00d\x1be\ufffef\ud800g",
)


def short_episode(**changes: Any) -> Episode:
    """Return seven frames in ``ROOM``: a bump into the wall, then a delivery."""
    env = WarehouseEnv(ROOM, start_pos=(1, 2), battery=10, max_steps=30)
    recorder = EpisodeRecorder(env, seed=4, agent="Tester")
    for action, reason in DELIVERY:
        recorder.step(action, reason)
    assert recorder.episode.outcome == "delivered"
    return dataclasses.replace(recorder.episode, **changes)


def named(name: str) -> Episode:
    """Return an episode of two frames with ``name`` as its agent, action and reason."""
    env = WarehouseEnv(ROOM, start_pos=(1, 2), battery=10, max_steps=1)
    recorder = EpisodeRecorder(env, seed=4, agent=name)
    recorder.step("W", name)
    return dataclasses.replace(recorder.episode, actions=[name], truncated=False)


def replay_of(frames: Any, metrics: Any = None, **options: Any) -> Replay:
    """Return a replay that opens no window."""
    replay = replay_animation(frames, metrics, window=False, **options)
    assert replay is not None
    return replay


def press(replay: Replay, *keys: str, at: Sequence[float] = (0, 0)) -> None:
    """Press keys while the mouse is at a place of the figure, in pixels."""
    canvas = replay.figure.canvas
    for key in keys:
        event = KeyEvent("key_press_event", canvas, key, *at)  # type: ignore[arg-type]
        canvas.callbacks.process("key_press_event", event)


def pixels(replay: Replay) -> NDArray[np.int64]:
    """Draw the figure and return its colours, ``[H, W, 3]``, 0..255."""
    return np.asarray(replay.figure.pixels()).astype(np.int64)


def point_of(replay: Replay, x: float, y: float) -> tuple[int, int]:
    """Return the row and column of the pixel at a place in the grid, given in cells."""
    column, height = replay.figure.axes[0].transData.transform((x, y))
    return round(replay.figure.bbox.height) - 1 - int(height), int(column)


def patch(
    replay: Replay, image: NDArray[Any], left: float, top: float, right: float, bottom: float
) -> NDArray[Any]:
    """Cut a rectangle of the grid, given in cells, out of an image."""
    (first_row, first_column), (last_row, last_column) = (
        point_of(replay, left, top),
        point_of(replay, right, bottom),
    )
    return image[first_row : last_row + 1, first_column : last_column + 1]


def count_color(image: NDArray[Any], color: tuple[float, float, float]) -> int:
    """Return how many pixels are ``color`` (0..1), to the nearest step of 1/255."""
    return int((np.abs(image - 255 * np.array(color)) <= 0.5 + 1e-9).all(axis=-1).sum())


def texts(replay: Replay) -> list[str]:
    """Return every visible text of the figure and its axes."""
    figure = replay.figure
    found = [*figure.texts, *(text for axes in figure.axes for text in axes.texts)]
    return [text.get_text() for text in found if text.get_visible() and text.get_text()]
