"""Real windows on a display of their own, and real keys. Run with ``pytest -m window``.

No test measures time. Each waits for the output of the program, for at most ``TIMEOUT`` seconds.
"""

from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.pictures import ROOM
from helpers.windows import MAX_STEPS, Program

from warehouse_core import Episode, EpisodeRecorder, WarehouseEnv

pytestmark = pytest.mark.window

WAREHOUSE = "from agents.lab.commands.cli import main; main()"

WATCH = """
import sys, zlib
from warehouse_core import Episode
from warehouse_core.warehouse_viz import replay_animation

replay = replay_animation(Episode.load(sys.argv[1]), interval_ms=60)
assert replay.window, "matplotlib finds no display or no toolkit such as tkinter"

def report(event):
    (counter,) = [t.get_text() for t in replay.figure.texts if t.get_text().startswith("step ")]
    picture = event.canvas.buffer_rgba()
    print(counter.split()[1], zlib.crc32(picture), *picture.shape, flush=True)

replay.figure.canvas.mpl_connect("draw_event", report)
replay.show()
print("closed", flush=True)
"""

BOOK = """
from warehouse_core import WarehouseEnv, replay_animation

env = WarehouseEnv()
env.reset()
frames, rewards = [env.render_grid()], [0.0]
for _ in range(3):
    _, reward, *_ = env.step("E")
    frames.append(env.render_grid())
    rewards.append(reward)
animation = replay_animation(frames, {"rewards": rewards})
print("closed", flush=True)
animation.save("book.gif")
"""


@pytest.fixture
def long_episode(tmp_path: Path) -> Path:
    env = WarehouseEnv(ROOM, max_steps=MAX_STEPS, battery=MAX_STEPS)
    recorder = EpisodeRecorder(env, seed=5, agent="Tester")
    for step in range(MAX_STEPS):
        recorder.step("ESWN"[step % 4])
    path = tmp_path / "long.npz"
    recorder.episode.save(path)
    return path


@pytest.fixture
def watched(start: Callable[..., Program], long_episode: Path) -> Program:
    """Return a replay in a window with the keyboard focus, at frame 3 or later."""
    program = start(WATCH, long_episode)
    program.pictures_until(lambda picture: picture.step >= 3)
    program.focus()
    return program


def test_a_window_plays_frame_by_frame(watched: Program) -> None:
    steps = [picture.step for picture in watched.pictures_until(lambda p: p.step >= 25)]
    assert sorted(set(steps)) == list(range(steps[0], steps[-1] + 1))
    assert steps == sorted(steps)


def test_q_closes_the_window_and_the_program_continues(watched: Program) -> None:
    watched.press("q")
    assert watched.rest()[-1] == "closed"
    assert watched.code() == 0


def test_a_script_of_the_book_shows_its_frames_until_q_and_can_save_them(start, tmp_path) -> None:
    program = start(BOOK)
    program.focus()
    assert not program.printed
    program.press("q")
    assert program.rest() == ["closed"]
    assert program.code() == 0
    assert [path.name for path in tmp_path.iterdir()] == ["book.gif"]


# The commands.


@pytest.mark.parametrize("option", [[], ["--show", "--save", "e.npz"]])
def test_run_opens_a_window_that_q_closes(start, tmp_path, option) -> None:
    program = start(WAREHOUSE, "run", "--seed", 5, *option)
    program.focus()
    program.press("space", "Right", "Left", "q")
    lines = program.rest()
    assert program.code() == 0, lines
    assert lines[0] == "GreedyAgent on the grid backend, seed 5, random stations"
    assert lines[-1] == "Space pauses, the left and right arrow keys step, and Q closes the window"
    assert [path.name for path in tmp_path.iterdir()] == option[2:]


@pytest.fixture
def play(start: Callable[..., Program], tmp_path: Path) -> Program:
    """Return ``warehouse play`` with the keyboard focus.

    This seed puts the robot at (1, 1), P below it at (2, 1) and D to the right of P at (2, 2).
    """
    ROOM.save(tmp_path / "room.txt")
    layout = ("--layout", "room.txt", "--stations", "drawn", "--seed", 4)
    program = start(WAREHOUSE, "play", *layout, "--save", "e.npz", "--save", "e.png")
    program.focus()
    return program


def test_play_takes_real_keys(play: Program, tmp_path: Path) -> None:
    play.press("Up", "Right", "space", "Left", "Down", "p", "e", "d", "n", "q")
    lines = play.rest()
    assert play.code() == 0, lines
    episode = Episode.load(tmp_path / "e.npz")
    assert episode.actions == ["N", "E", "WAIT", "W", "S", "PICK", "E", "DROP"]
    assert (episode.agent, episode.seed, episode.outcome) == ("You", 4, "delivered")
    assert lines[0].startswith("Arrows or NESW move")
    assert lines[1:3] == ["game 1", "You on the grid backend, seed 4, random stations"]
    assert lines[-2:] == ["saved e.npz", "saved e.png"]
    assert (tmp_path / "e.png").exists()
