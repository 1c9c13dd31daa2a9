import re
from pathlib import Path

import numpy as np
import pytest
from helpers.pictures import pixels, press, replay_of, short_episode, texts
from matplotlib.animation import PillowWriter

from warehouse_core.errors import NoDisplayError
from warehouse_core.viz.replay import Replay

LAST = 6


@pytest.fixture
def replay() -> Replay:
    """Return a replay without charts that has been drawn once, which starts it."""
    replay = replay_of(short_episode().frames)
    replay.figure.canvas.draw()
    return replay


def tick(replay: Replay, times: int = 1) -> None:
    """Let the timer of the animation tick."""
    for _ in range(times):
        assert replay.event_source is not None
        replay.event_source._on_timer()


def shown(replay: Replay) -> int:
    """Return the step in the counter of the picture."""
    (counter,) = [text for text in texts(replay) if text.startswith("step ")]
    found = re.fullmatch(rf"step (\d+) of {LAST}", counter)
    assert found is not None
    return int(found.group(1))


def played(replay: Replay, ticks: int) -> list[int]:
    frames = []
    for _ in range(ticks):
        tick(replay)
        frames.append(shown(replay))
    return frames


def test_a_replay_plays_every_frame_and_stays_at_the_end(replay: Replay) -> None:
    assert shown(replay) == 0
    assert played(replay, 9) == [0, 1, 2, 3, 4, 5, 6, 6, 6]
    assert replay.frame == LAST
    assert not replay.playing


def test_the_counter_matches_the_drawn_frame(replay: Replay) -> None:
    tick(replay, 4)
    assert shown(replay) == replay.frame == 3
    fresh = replay_of(short_episode().frames)
    fresh.go_to(3)
    assert np.array_equal(pixels(replay), pixels(fresh))


@pytest.mark.parametrize(
    ("ticks", "keys", "frame", "next_frames"),
    [
        (3, [" "], 2, [2, 2, 2]),
        (3, [" ", " "], 2, [3, 4]),
        (4, ["left"], 2, [2, 2]),
        (4, ["left", "left"], 1, [1]),
        (4, ["right"], 4, [4, 4]),
        (4, ["right", "right"], 5, [5]),
        (5, ["left", "left", " "], 2, [3, 4, 5]),
        (0, ["left", "left"], 0, [0]),
        (0, ["left", "left", "right"], 1, [1]),
        (0, ["right"] * 9, 6, [6]),
        (0, [*["right"] * 9, "left"], 5, [5]),
        (9, [" "], 0, [1, 2, 3]),
        (3, ["q", "p", "up", "shift+left", "home", "x", "escape"], 2, [3, 4]),
    ],
)
def test_space_pauses_and_resumes_and_arrows_step(replay, ticks, keys, frame, next_frames) -> None:
    tick(replay, ticks)
    press(replay, *keys)
    assert shown(replay) == frame
    assert replay.playing == (next_frames[0] > frame)
    assert played(replay, len(next_frames)) == next_frames


def test_a_replay_of_one_frame_can_be_paused_and_stepped() -> None:
    replay = replay_of([["R."]])
    replay.figure.canvas.draw()
    tick(replay, 3)
    press(replay, " ", "left", "right", " ")
    tick(replay, 2)
    assert replay.frame == 0
    assert "step 0 of 0" in texts(replay)


def test_a_replay_may_go_to_a_frame_before_it_is_drawn() -> None:
    replay = replay_of(short_episode())
    replay.go_to(4)
    replay.figure.canvas.draw()
    assert shown(replay) == 4
    assert played(replay, 2) == [4, 4]


@pytest.mark.parametrize("name", ["interval_ms", "speed"])
@pytest.mark.parametrize("value", [0, float("nan")])
def test_intervals_and_speeds_have_limits(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf"{name} is {value!r}; it must be at least 1e-06 and at"):
        replay_of([["R."]], **{name: value})


@pytest.mark.parametrize(
    ("interval_ms", "speed", "frame_ms", "ticks_ms"),
    [(150, 1, 150, 150), (150, 2, 75, 75), (100, 0.5, 200, 200), (1, 50, 0.02, 1)],
)
def test_speed_divides_the_interval_and_ticks_are_a_millisecond_apart_at_least(
    interval_ms: float, speed: float, frame_ms: float, ticks_ms: float
) -> None:
    replay = replay_of([["R."]], interval_ms=interval_ms, speed=speed)
    assert replay.frame_ms == frame_ms
    assert replay.fps == 1000 / frame_ms
    assert replay.event_source is not None
    assert replay.event_source.interval == ticks_ms


def test_show_without_a_window_raises(replay: Replay) -> None:
    with pytest.raises(NoDisplayError, match="there is no display"):
        replay.show()


# Saving.


@pytest.mark.parametrize("suffix", [".gif", ".html", ".PNG"])
def test_saving_leaves_the_current_frame_as_it_was(replay: Replay, tmp_path, suffix: str) -> None:
    tick(replay, 3)
    replay.save(str(tmp_path / f"film{suffix}"))
    assert (shown(replay), replay.frame, replay.playing) == (2, 2, True)
    assert played(replay, 2) == [3, 4]


def test_a_writer_of_matplotlib_gets_every_frame(replay: Replay, tmp_path: Path) -> None:
    from PIL import Image

    target = tmp_path / "film.gif"
    replay.go_to(4)
    seen = []
    replay.save(
        target,
        writer=PillowWriter(fps=5),
        progress_callback=lambda frame, frames: seen.append(frame),
    )
    with Image.open(target) as film:
        assert film.n_frames == LAST + 1  # type: ignore[attr-defined]
    assert seen == list(range(LAST + 1))
    assert shown(replay) == 4


def test_a_replay_that_is_never_drawn_causes_no_warning() -> None:
    import gc

    replay_of(short_episode())
    gc.collect()


def test_a_figure_keeps_its_replay() -> None:
    import gc

    figure = replay_of(short_episode()).figure
    gc.collect()
    assert isinstance(figure.replay, Replay)
    press(figure.replay, "right")
    assert shown(figure.replay) == 1
