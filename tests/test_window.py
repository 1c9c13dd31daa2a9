"""Real windows on a display of their own, and real keys. Run with ``pytest -m window``.

Nothing here goes by the clock: a test waits for what the program prints, and gives up after
``PATIENCE`` seconds in which it has not come.
"""

import os
import queue
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from pictures import ROOM

from warehouse_core import Episode, EpisodeRecorder, WarehouseEnv

pytestmark = pytest.mark.window

PATIENCE = 60
STILL = 6
"""A picture that is drawn so many times without a change is taken to stand still."""

LONG = 400
"""Steps of the episode that is watched: it must not end while a test looks on."""

WAREHOUSE = "from agents.cli import main; main()"

WATCH = """
import sys, zlib
from warehouse_core import Episode
from warehouse_core.warehouse_viz import replay_animation

replay = replay_animation(Episode.load(sys.argv[1]), interval_ms=60)
assert replay.window, "matplotlib finds no display or no toolkit such as tkinter"

def tell(event):
    (counter,) = [t.get_text() for t in replay.figure.texts if t.get_text().startswith("step ")]
    picture = event.canvas.buffer_rgba()
    print(counter.split()[1], zlib.crc32(picture), *picture.shape, flush=True)

replay.figure.canvas.mpl_connect("draw_event", tell)
replay.show()
print("closed", flush=True)
"""


class Picture(NamedTuple):
    """What the watched program says of a picture that it has drawn."""

    step: int
    checksum: int
    height: int
    width: int
    channels: int


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    """Yield the name of an X display that nobody else uses."""
    for program in ("Xvfb", "xdotool"):
        if shutil.which(program) is None:
            pytest.fail(f"{program} is not installed, and window tests need it (xvfb, xdotool)")
    reading, writing = os.pipe()
    # Without -noreset it begins anew, deaf for a moment, whenever its last client has gone.
    options = ["-screen", "0", "1400x1000x24", "-nolisten", "tcp", "-noreset"]
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), *options],
        pass_fds=[writing],
        stderr=subprocess.DEVNULL,
    )
    try:
        os.close(writing)
        with open(reading, encoding="ascii") as pipe:
            number = pipe.readline().strip()
        assert number, "Xvfb did not start"
        yield f":{number}"
    finally:
        stop(server)


class Program:
    """A Python program on the display, its window and what it prints."""

    def __init__(self, display: str, folder: Path, *words: object) -> None:
        names = ("WAYLAND_DISPLAY", "MPLBACKEND")
        environment = {name: value for name, value in os.environ.items() if name not in names}
        self._environment = environment | {"DISPLAY": display}
        self._process = subprocess.Popen(
            [sys.executable, "-u", "-c", *map(str, words)],
            cwd=folder,
            env=self._environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.printed: list[str] = []
        self._lines: queue.Queue[str | None] = queue.Queue()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def close(self) -> None:
        stop(self._process)
        self._reader.join()
        assert self._process.stdout is not None
        self._process.stdout.close()

    def line(self) -> str | None:
        """Return the next line that it prints, ``None`` after the last one."""
        try:
            line = self._lines.get(timeout=PATIENCE)
        except queue.Empty:
            pytest.fail(f"nothing came for {PATIENCE} seconds after {self.printed[-5:]}")
        if line is not None:
            self.printed.append(line)
        return line

    def picture(self) -> Picture:
        """Return the next picture that it draws."""
        line = self.line()
        assert line is not None, f"it ended: {self.printed[-20:]}"
        assert line.replace(" ", "").isdigit(), f"it says: {line}, {self.rest()}"
        return Picture(*map(int, line.split()))

    def pictures_until(self, done: Callable[[Picture], bool]) -> list[Picture]:
        """Return the pictures up to one for which ``done`` holds."""
        pictures = [self.picture()]
        while not done(pictures[-1]):
            assert len(pictures) < 20 * LONG, "it never came"
            pictures.append(self.picture())
        return pictures

    def still(self) -> Picture:
        """Wait until the picture stands still, and return it."""
        last, times = self.picture(), 1
        while times < STILL:
            picture = self.picture()
            times = times + 1 if picture == last else 1
            last = picture
        assert last.step < LONG, "it came to the end"
        return last

    def rest(self) -> list[str]:
        """Return the lines that are still to come, once it has ended by itself."""
        return list(iter(self.line, None))  # type: ignore[arg-type]

    def code(self) -> int:
        """Wait for its end and return its exit code."""
        return self._process.wait(PATIENCE)

    def focus(self) -> str:
        """Wait for its window, give it the keyboard and return its number."""
        found = self._xdotool("search", "--sync", "--onlyvisible", "--name", "^Warehouse$").split()
        self._xdotool("windowfocus", "--sync", found[-1])
        # Keys that mean nothing: on a busy machine the toolkit loses the first after a change.
        self._xdotool("key", "--delay", "150", *["F9"] * 4)
        return found[-1]

    def press(self, *keys: str) -> None:
        """Press and release keys on the keyboard of the display."""
        self._xdotool("key", "--delay", "30", *keys)

    def resize(self, window: str, width: int, height: int) -> None:
        self._xdotool("windowsize", window, str(width), str(height))

    def _xdotool(self, *words: str) -> str:
        done = subprocess.run(
            ["xdotool", *words],
            env=self._environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE,
        )
        assert done.returncode == 0, f"xdotool {words}: {done.stderr}; {self.printed}"
        return done.stdout

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.put(line.rstrip("\n"))
        self._lines.put(None)


def stop(process: "subprocess.Popen[str] | subprocess.Popen[bytes]") -> None:
    """End a process, if need be by force."""
    process.terminate()
    try:
        process.wait(10)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


@pytest.fixture
def start(display: str, tmp_path: Path) -> Iterator[Callable[..., Program]]:
    """Return a function that starts a program; whatever happens, it is ended."""
    programs: list[Program] = []

    def begin(*words: object) -> Program:
        programs.append(Program(display, tmp_path, *words))
        return programs[-1]

    yield begin
    for program in programs:
        program.close()


@pytest.fixture
def long_episode(tmp_path: Path) -> Path:
    env = WarehouseEnv(ROOM, max_steps=LONG, battery=LONG)
    recorder = EpisodeRecorder(env, seed=5, agent="Tester")
    for step in range(LONG):
        recorder.step("ESWN"[step % 4])
    path = tmp_path / "long.npz"
    recorder.episode.save(path)
    return path


@pytest.fixture
def watched(start: Callable[..., Program], long_episode: Path) -> Program:
    """Return a replay in a window with the keyboard, a few frames after its beginning."""
    program = start(WATCH, long_episode)
    program.pictures_until(lambda picture: picture.step >= 3)
    program.focus()
    return program


def paused(watched: Program) -> Picture:
    watched.press("space")
    return watched.still()


def test_a_window_plays_frame_by_frame(watched: Program) -> None:
    steps = [picture.step for picture in watched.pictures_until(lambda p: p.step >= 25)]
    assert sorted(set(steps)) == list(range(steps[0], steps[-1] + 1))
    assert steps == sorted(steps)


def test_space_pauses_and_resumes(watched: Program) -> None:
    first = paused(watched)
    assert {watched.picture() for _ in range(10)} == {first}
    watched.press("space")
    going_on = watched.pictures_until(lambda picture: picture.step >= first.step + 3)
    steps = sorted({picture.step for picture in going_on} | {first.step})
    assert steps == list(range(first.step, first.step + 4))


@pytest.mark.parametrize(("key", "by"), [("Right", 1), ("Left", -1)])
def test_an_arrow_steps_by_exactly_one(watched: Program, key: str, by: int) -> None:
    before = paused(watched)
    watched.press(key)
    *_, changed = watched.pictures_until(lambda picture: picture.step != before.step)
    assert changed.step == before.step + by
    assert watched.still() == changed
    watched.press(key, key)
    *_, changed = watched.pictures_until(lambda picture: picture.step == before.step + 3 * by)
    assert watched.still() == changed


@pytest.mark.parametrize("key", ["Right", "Left"])
def test_an_arrow_pauses(watched: Program, key: str) -> None:
    watched.press(key)
    still = watched.still()
    assert watched.picture() == still


def test_there_and_back_gives_the_same_picture(watched: Program) -> None:
    before = paused(watched)
    watched.press("Right", "Right", "Left", "Left")
    watched.pictures_until(lambda picture: picture.step == before.step + 2)
    assert watched.still() == before


def test_a_paused_window_can_be_resized(watched: Program) -> None:
    window = watched.focus()
    before = paused(watched)
    watched.resize(window, before.width + 120, before.height + 60)
    watched.pictures_until(lambda picture: picture.width != before.width)
    after = watched.still()
    assert after.step == before.step
    assert (after.width, after.height) > (before.width, before.height)
    watched.resize(window, before.width, before.height + before.height - after.height + 60)
    watched.pictures_until(lambda picture: picture.width == before.width)
    assert watched.still() == before


def test_q_closes_the_window_and_the_program_goes_on(watched: Program) -> None:
    watched.press("q")
    assert watched.rest()[-1] == "closed"
    assert watched.code() == 0


# The commands.


@pytest.mark.parametrize("option", [[], ["--show", "--save", "e.npz"]])
def test_run_opens_a_window_that_q_closes(
    start: Callable[..., Program], tmp_path: Path, option: list[str]
) -> None:
    program = start(WAREHOUSE, "run", "--seed", 5, *option)
    program.focus()
    program.press("space", "Right", "Left", "q")
    lines = program.rest()
    assert program.code() == 0, lines
    assert lines[0] == "GreedyAgent on the grid backend, seed 5"
    assert lines[-1] == "space pauses, left and right step, q closes the window"
    assert [path.name for path in tmp_path.iterdir()] == option[2:]


def test_replay_opens_a_window_that_q_closes(
    start: Callable[..., Program], long_episode: Path
) -> None:
    program = start(WAREHOUSE, "replay", long_episode, "--speed", 2)
    program.focus()
    program.press("q")
    lines = program.rest()
    assert program.code() == 0, lines
    assert lines[-1] == "space pauses, left and right step, q closes the window"


@pytest.fixture
def play(start: Callable[..., Program], tmp_path: Path) -> Program:
    """Return ``warehouse play`` with the keyboard.

    This seed puts the robot at (1, 1), P below it at (2, 1) and D beside that at (2, 2).
    """
    ROOM.save(tmp_path / "room.txt")
    program = start(
        WAREHOUSE, "play", "--layout", "room.txt", "--seed", 4, "--save", "e.npz", "--save", "e.png"
    )
    program.focus()
    return program


def test_play_is_driven_by_real_keys(play: Program, tmp_path: Path) -> None:
    play.press("Up", "Right", "space", "Left", "Down", "p", "e", "d", "n", "q")
    lines = play.rest()
    assert play.code() == 0, lines
    episode = Episode.load(tmp_path / "e.npz")
    assert episode.actions == ["N", "E", "WAIT", "W", "S", "PICK", "E", "DROP"]
    assert (episode.agent, episode.seed, episode.outcome) == ("You", 4, "delivered")
    assert lines[0] == "You on the grid backend, seed 4"
    assert lines[-2:] == ["saved e.npz", "saved e.png"]
    assert (tmp_path / "e.png").exists()


def test_play_starts_again_on_enter(play: Program, tmp_path: Path) -> None:
    play.press("Down", "Return", "S", "w", "Escape")
    lines = play.rest()
    assert play.code() == 0, lines
    episode = Episode.load(tmp_path / "e.npz")
    assert (episode.seed, episode.actions) == (5, ["S", "W"])
    assert episode.outcome == "unfinished"
