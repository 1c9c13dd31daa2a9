"""The command ``warehouse play``, with keys sent to a figure without a window.

``tests/system/test_window.py`` presses real keys.
"""

from collections.abc import Callable

import matplotlib.pyplot as plt
import pytest
from helpers.command_line import Warehouse
from helpers.pictures import ROOM
from matplotlib.backend_bases import KeyEvent
from PIL import Image

from agents.lab.commands import play as module
from agents.lab.commands.play import KeyDriver
from agents.lab.trials.task import Task
from warehouse_core import Episode, WarehouseEnv
from warehouse_core.viz.figure import SceneFigure


@pytest.fixture
def driver() -> KeyDriver:
    # This seed puts the robot at (1, 1), P below it at (2, 1), and D next to P at (2, 2).
    return KeyDriver(WarehouseEnv(ROOM, max_steps=8), SEED, Task(ROOM))


SEED = 4
DELIVERY = ("down", "p", "right", "d")


def words_in(figure: SceneFigure) -> list[str]:
    return [text.get_text() for text in figure.texts if text.get_text()]


def press(figure: SceneFigure, *keys: str | None) -> None:
    for key in keys:
        event = KeyEvent("key_press_event", figure.canvas, key)
        figure.canvas.callbacks.process("key_press_event", event)


@pytest.fixture(autouse=True)
def no_windows_left() -> object:
    yield
    plt.close("all")


def test_the_first_frame_explains_the_keys(driver: KeyDriver) -> None:
    words = words_in(driver.figure)
    assert "step 0 of 8" in words
    assert any(text.startswith("Arrows or NESW move, P picks, D drops") for text in words)
    assert f"You on the grid backend, seed {SEED}" in words


@pytest.mark.parametrize(
    "keys",
    [
        ["up", "right", "down", "left", "p", "d", " "],
        ["n", "e", "s", "w", "P", "D", " "],
        ["N", "E", "S", "W", "P", "D", " "],
    ],
)
def test_a_key_is_an_action(driver: KeyDriver, keys: list[str]) -> None:
    press(driver.figure, *keys, "x", "ctrl+p", "shift", "f", "home", "1", None)
    assert driver.episode.actions == ["N", "E", "S", "W", "PICK", "DROP", "WAIT"]
    assert driver.episode.reasons == ["key"] * 7
    assert "Wait: key pressed" in words_in(driver.figure)
    assert "step 7 of 8" in words_in(driver.figure)


@pytest.mark.parametrize(("key", "steps"), [("enter", 12), ("return", 3)])
def test_enter_starts_again_from_the_next_seed(driver: KeyDriver, key: str, steps: int) -> None:
    press(driver.figure, *[" "] * steps)
    ended = min(steps, 8)
    assert driver.episode.actions == ["WAIT"] * ended
    assert ("INEFFECTIVE" in words_in(driver.figure)) == (ended == 8)
    press(driver.figure, key)
    assert (driver.episode.seed, driver.episode.actions) == (SEED + 1, [])
    fresh = WarehouseEnv(ROOM)
    assert driver.episode.cells[0] == fresh.reset(randomize=True, seed=SEED + 1)["robot_pos"]
    assert f"You on the grid backend, seed {SEED + 1}" in words_in(driver.figure)
    assert "step 0 of 8" in words_in(driver.figure)
    assert "INEFFECTIVE" not in words_in(driver.figure)
    press(driver.figure, "n")
    assert driver.episode.actions == ["N"]


# The command.


@pytest.fixture
def keys(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Return a function that chooses the keys that are pressed when the window is open."""
    monkeypatch.setattr(module, "has_display", lambda: True)

    def will_be(*pressed: str) -> None:
        def show() -> None:
            (number,) = plt.get_fignums()
            figure = plt.figure(number)
            assert isinstance(figure, SceneFigure)
            press(figure, *pressed)

        monkeypatch.setattr(plt, "show", show)

    return will_be


def test_play_reports_and_saves_a_game(warehouse, tmp_path, keys) -> None:
    ROOM.save(tmp_path / "room.txt")
    keys(*DELIVERY, "q")
    result = warehouse(
        *("play", "--layout", "room.txt", "--stations", "drawn", "--seed", SEED),
        *("--battery", 90, "--max-steps", 50),
        *("--save", "e.npz", "--save", "e.png"),
    )
    assert result.code == 0
    episode = Episode.load("e.npz")
    assert episode.actions == ["S", "PICK", "E", "DROP"]
    assert (episode.agent, episode.seed, episode.outcome) == ("You", SEED, "delivered")
    assert result.out.splitlines() == [
        module.HELP,
        "game 1",
        f"You on the grid backend, seed {SEED}, random stations",
        "outcome         delivered",
        "diagnosis       delivered in 4 steps; the minimum is 4",
        "total reward    14.60",
        "final battery   86 of 90",
        "episode length  4 of at most 50 steps",
        "saved e.npz",
        "saved e.png",
    ]
    with Image.open("e.png") as image:
        assert image.format == "PNG"


def test_every_game_is_reported_and_saved(warehouse: Warehouse, keys: Callable[..., None]) -> None:
    keys("n", "enter", "e", "e", "enter", "q")
    result = warehouse("play", "--seed", 8, "--save", "e.npz", "--save", "e.svg")
    games = [Episode.load(name) for name in ("e.npz", "e-2.npz")]
    assert [(game.seed, game.actions) for game in games] == [(8, ["N"]), (9, ["E", "E"])]
    lines = result.out.splitlines()
    for number in (1, 2):
        after = lines.index(f"game {number}") + 1
        assert lines[after] == f"You on the grid backend, seed {7 + number}, random stations"
    assert "game 3" not in lines
    assert lines[-4:] == ["saved e.npz", "saved e.svg", "saved e-2.npz", "saved e-2.svg"]
