"""What notebooks show for records, environments and layouts."""

import io
from typing import Any

import numpy as np
import pytest
from helpers.fleets import fleet_episode
from helpers.pictures import ROOM, count_color, replay_of, short_episode
from helpers.player import page_in, said_by
from numpy.typing import NDArray
from PIL import Image

from warehouse_core import FleetEnv, WarehouseEnv
from warehouse_core.render.palette import COLORS
from warehouse_core.viz import notebooks
from warehouse_core.world.display import display

CELLS = (
    "from warehouse_core import WarehouseEnv, record_episode, replay_animation\n"
    "from agents import GreedyAgent\n"
    "env = WarehouseEnv()\n"
    "env",
    "episode = record_episode(env, GreedyAgent(seed=12), seed=12)\nepisode",
    "replay_animation(episode)",
    "replay_animation(episode.frames, episode.metrics)",
)

TITLE = "GreedyAgent on the grid backend, seed 12"


def picture(shown: Any) -> NDArray[np.int64]:
    with Image.open(io.BytesIO(shown._repr_png_())) as image:
        return np.asarray(image.convert("RGB")).astype(np.int64)


def test_a_notebook_shows_pictures_and_players(tmp_path, monkeypatch) -> None:
    for folder in ("IPYTHONDIR", "JUPYTER_RUNTIME_DIR"):
        monkeypatch.setenv(folder, str(tmp_path))
    import nbformat
    from nbclient import NotebookClient

    cells = [nbformat.v4.new_code_cell(source) for source in CELLS]
    notebook = nbformat.v4.new_notebook(cells=cells)
    NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    outputs = [[output["data"] for output in cell["outputs"]] for cell in notebook.cells]
    [[env], [episode], [replay], [frames]] = outputs
    assert env["image/png"].startswith("iVBORw0KGgo")
    for shown, title in ((episode, TITLE), (replay, TITLE), (frames, "")):
        [track] = said_by(page_in(shown["text/html"]))["tracks"]
        assert track["title"] == title
    assert len(nbformat.writes(notebook)) < 500_000


def test_the_player_of_a_record_is_a_frame_without_rights() -> None:
    frame = short_episode()._repr_html_()
    assert frame.startswith("<iframe srcdoc=")
    assert frame.count("<") == 2, "the page is the value of an attribute"
    assert ' sandbox="allow-scripts" ' in frame
    assert said_by(page_in(frame))["tracks"][0]["ending"] == "delivered"
    [track] = said_by(page_in(fleet_episode()._repr_html_()))["tracks"]
    assert (track["isFleet"], track["robots"]) == (True, 4)


def test_the_player_of_a_replay_has_its_speed() -> None:
    replays = (replay_of(short_episode(), speed=speed) for speed in (1, 2))
    usual, faster = (said_by(page_in(replay._repr_html_())) for replay in replays)
    assert faster["speed"] == 2 * usual["speed"]
    assert faster["tracks"] == usual["tracks"]


def test_a_player_too_large_for_a_notebook_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notebooks, "MAX_BYTES", 10_000)
    shown = short_episode()._repr_html_()
    assert "save('replay.html')" in shown
    assert len(shown) < 300


def test_an_environment_is_a_picture_of_its_present_state() -> None:
    env = WarehouseEnv(ROOM, (1, 2))
    env.step("E")
    image = picture(env)
    assert count_color(image[40:80, 120:160], COLORS["R"]) > 100
    env.state.has_item = True
    assert (picture(env) != image).any()


def test_robots_whose_starts_are_known_are_there_before_the_reset() -> None:
    cells = [(1, 2), (2, 1)]
    for env in (FleetEnv(ROOM, 2, starts=cells), FleetEnv(ROOM, 1)):
        image = picture(env)
        assert image.shape == (160, 200, 3)
        env.reset(seed=1)
        assert (picture(env) == image).all()


def test_nothing_else_is_shown() -> None:
    with pytest.raises(TypeError, match="notebooks cannot show int"):
        display(1)
