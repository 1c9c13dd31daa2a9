"""``warehouse play --backend drive`` and other commands under continuous control."""

import sys

import matplotlib.pyplot as plt
import pytest
from helpers.command_line import Warehouse
from matplotlib.backend_bases import KeyEvent

from agents.lab.commands import steer
from agents.lab.commands.steer import SteeringWheel
from warehouse_physics import RobotSpec
from warehouse_physics.drive import DriveEnv


@pytest.fixture(autouse=True)
def no_windows_left():
    yield
    plt.close("all")


@pytest.fixture
def clock(monkeypatch):
    """Replace the clock of the steering wheel by a list whose last number is the time."""
    times = [0.0]
    monkeypatch.setattr(steer, "monotonic", lambda: times[-1])
    return times


def send(wheel, kind, key):
    event = KeyEvent(f"key_{kind}_event", wheel.figure.canvas, key)
    wheel.figure.canvas.callbacks.process(f"key_{kind}_event", event)


def test_a_held_key_accelerates_until_it_is_released(clock):
    wheel = SteeringWheel(DriveEnv(), seed=12)
    send(wheel, "press", "up")
    for _ in range(3):
        wheel.tick()
    send(wheel, "release", "up")
    send(wheel, "press", "up")  # a repeated key, which is still held
    clock.append(10.0)
    wheel.tick()
    send(wheel, "release", "up")
    clock.append(10.03)
    wheel.tick()
    clock.append(20.0)
    wheel.tick()
    actions = wheel.games[0].actions
    assert actions == ["0.0 0.0", *["1.0 0.0"] * 5, "0.0 0.0"]
    assert wheel.games[0].reasons[-2:] == ["key", ""]


def test_keys_add_up_and_mean_directions_for_a_disc(clock):
    wheels, disc = (
        SteeringWheel(DriveEnv(spec=spec), seed=12)
        for spec in (None, RobotSpec())
    )  # fmt: skip
    for wheel in (wheels, disc):
        for key in ("up", "d", "x", None):
            send(wheel, "press", key)
        wheel.tick()
    assert wheels.games[0].actions[-1] == "1.0 0.5"
    assert disc.games[0].actions[-1] == "1.0 -1.0"


def test_enter_starts_another_game_and_q_closes_the_window(clock):
    wheel = SteeringWheel(DriveEnv(max_seconds=0.3), seed=12)
    for _ in range(5):
        wheel._show()  # the timer calls this
    assert wheel.games[0].steps == 3
    assert not any(text.get_text().startswith("Hold") for text in wheel.figure.texts)
    send(wheel, "press", "enter")
    assert [game.seed for game in wheel.games] == [12, 13]
    wheel._show()
    assert any(text.get_text().startswith("Hold arrows") for text in wheel.figure.texts)
    send(wheel, "press", "q")
    assert not plt.get_fignums()


def test_run_drives_the_moves_of_an_agent(warehouse: Warehouse) -> None:
    result = warehouse("run", "--backend", "drive", "--agent", "astar", "--seed", 12, "--no-show")
    assert "SearchAgent on the drive backend, seed 12" in result.out
    assert "diagnosis              delivered in" in result.out
    limited = warehouse("run", "--backend", "drive", "--seed", 12, "--max-steps", 2, "--no-show")
    assert "episode length         40 of at most 40 steps" in limited.out


def test_wrong_settings_are_named(warehouse: Warehouse) -> None:
    refused = warehouse("run", "--backend", "drive:wheels=3", "--seed", 1)
    assert refused.code == 1
    assert "no number is called 'wheels'; allowed: radius" in " ".join(refused.err.split())


def test_without_pymunk_the_command_says_what_to_install(warehouse: Warehouse, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "warehouse_physics.drive", None)
    refused = warehouse("run", "--backend", "drive", "--seed", 1)
    assert refused.code == 1
    words = " ".join(refused.err.split())
    assert "backend 'drive' needs warehouse_physics.drive, which is not installed: pip" in words
