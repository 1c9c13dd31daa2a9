import inspect
import math
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from helpers.fleets import fleet_episode
from helpers.pictures import press, short_episode, texts
from matplotlib.animation import FuncAnimation

from warehouse_core import WarehouseEnv
from warehouse_core.records.plans import StepPlans
from warehouse_core.viz import figure as figures
from warehouse_core.warehouse_viz import (
    _grid_to_rgb,
    _legend_handles,
    replay_animation,
    save_frames_to_svg,
)

SVG = "{http://www.w3.org/2000/svg}"
FRAME_FILES = [f"frame_{frame:04d}.svg" for frame in range(7)]


# The chapter's two functions.


def test_both_functions_take_the_arguments_of_the_chapter() -> None:
    parameters = [*inspect.signature(replay_animation).parameters.values()]
    asked = {parameter.name: parameter.default for parameter in parameters[:4]}
    assert asked == {"frames": inspect.Parameter.empty, "metrics": None, "interval_ms": 150,
                     "speed": 1.0}  # fmt: skip
    assert {other.kind for other in parameters[4:]} == {inspect.Parameter.KEYWORD_ONLY}
    saving = inspect.signature(save_frames_to_svg).parameters
    assert [*saving] == ["frames", "output_dir", "dpi"]
    assert saving["dpi"].default == 120


def test_the_chapters_loop_can_be_replayed() -> None:
    env = WarehouseEnv()
    first = env.reset()
    frames, seen, rewards = [env.render_grid()], [first], [0.0]
    for _ in range(3):
        observation, reward, *_ = env.step("E")
        frames.append(env.render_grid())
        seen.append(observation)
        rewards.append(reward)
    metrics: Any = {"rewards": rewards, "battery": [each["battery"] for each in seen]}
    for name in ("pickup", "dropoff"):
        away = [np.subtract(each["robot_pos"], each[f"{name}_pos"]) for each in seen]
        metrics[f"dist_{name}"] = [float(np.abs(each).sum()) for each in away]
    animation = replay_animation(frames, metrics, 100, 2.0, window=False)
    assert isinstance(animation, FuncAnimation)
    animation.go_to(3)
    assert {"step 3 of 3", "battery 197 of 200"} <= set(texts(animation))


def test_metrics_given_with_an_episode_are_refused() -> None:
    for episode in (short_episode(), fleet_episode(max_steps=1)):
        with pytest.raises(TypeError, match="has its own metrics"):
            replay_animation(episode, {}, window=False)


def test_plans_are_for_the_record_of_a_fleet() -> None:
    for frames in (short_episode(), [["R"]]):
        with pytest.raises(TypeError, match="plans are for the record of a fleet"):
            replay_animation(frames, plans=[StepPlans({}, {}, {})], window=False)


@pytest.mark.parametrize("frames", [[], np.empty((0, 2, 2))])
def test_without_frames_there_is_no_animation(frames: Any) -> None:
    assert replay_animation(frames) is None
    assert replay_animation(frames, {"rewards": []}) is None


def test_without_frames_no_folder_is_made(tmp_path: Path) -> None:
    save_frames_to_svg([], tmp_path / "frames")
    assert list(tmp_path.iterdir()) == []


def test_without_matplotlib_both_functions_print_a_message_and_return(tmp_path: Path) -> None:
    program = """
import sys
sys.modules["matplotlib"] = None
from warehouse_core.warehouse_viz import replay_animation, save_frames_to_svg
print(replay_animation([["R."]], {"rewards": [0.0]}))
print(save_frames_to_svg([["R."]], "frames"))
"""
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, check=True, capture_output=True, text=True
    )
    says = "matplotlib is not installed, so nothing is drawn: pip install matplotlib"
    assert done.stdout.splitlines() == [says, "None", says, "None"]
    assert done.stderr == ""
    assert list(tmp_path.iterdir()) == []


# Windows, if there is a display.


@pytest.mark.parametrize("display", [False, True])
def test_a_window_is_made_where_there_is_a_display(monkeypatch, display: bool) -> None:
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    monkeypatch.setattr("warehouse_core.viz.replay.has_display", lambda: display)
    replay = replay_animation(short_episode())
    assert replay is not None
    assert replay.window == display
    assert (plt.get_fignums() != []) == display
    plt.close("all")


@pytest.mark.parametrize("display", [False, True])
def test_frames_are_shown_at_once_and_a_record_is_only_returned(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], display: bool
) -> None:
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    monkeypatch.setattr("warehouse_core.viz.replay.has_display", lambda: display)
    opened = []
    monkeypatch.setattr(plt, "show", lambda: opened.append(plt.get_fignums()))
    episode = short_episode()
    for window in (False, True):
        assert isinstance(replay_animation(episode.frames, window=window), FuncAnimation)
    plt.close("all")
    assert isinstance(replay_animation(episode), FuncAnimation)
    plt.close("all")
    assert (opened, capsys.readouterr().out) == ([], "")
    replay = replay_animation(episode.frames, episode.metrics)
    assert isinstance(replay, FuncAnimation)
    assert opened == ([[replay.figure.number]] if display else [])
    said = capsys.readouterr().out.splitlines()
    assert [".save('replay.gif')" in line for line in said] == ([] if display else [True])
    plt.close("all")


def test_a_replay_can_be_saved_after_its_window_was_closed(tmp_path, monkeypatch) -> None:
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    monkeypatch.setattr(plt, "show", lambda: plt.close("all"))
    monkeypatch.setattr("warehouse_core.viz.replay.has_display", lambda: True)
    replay = replay_animation(short_episode().frames)
    assert replay is not None
    replay.save(tmp_path / "replay.png")
    replay.show()
    assert (tmp_path / "replay.png").stat().st_size > 1000
    still_open = replay_animation(short_episode(), window=True)
    assert still_open is not None
    canvas = still_open.figure.canvas
    still_open.save(tmp_path / "open.png")
    assert still_open.figure.canvas is canvas
    plt.close("all")


def test_in_a_notebook_frames_are_not_shown_and_no_message_is_printed(monkeypatch, capsys) -> None:
    monkeypatch.setattr("warehouse_core.viz.replay.has_display", lambda: False)
    shell = SimpleNamespace(kernel=object())
    notebook = SimpleNamespace(get_ipython=lambda: shell, version_info=(9, 0))
    monkeypatch.setitem(sys.modules, "IPython", notebook)
    assert isinstance(replay_animation(short_episode().frames), FuncAnimation)
    assert capsys.readouterr().out == ""


def test_a_window_is_closed_by_q_and_opened_by_show(monkeypatch: pytest.MonkeyPatch) -> None:
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    replay = replay_animation(short_episode(), window=True)
    assert replay is not None
    shown = []
    monkeypatch.setattr(plt, "show", lambda: shown.append(plt.get_fignums()))
    replay.show()
    assert shown == [[replay.figure.number]]  # type: ignore[attr-defined]
    press(replay, "x")
    assert plt.get_fignums()
    press(replay, "q")
    assert plt.get_fignums() == []


def test_a_toolkit_that_cannot_open_a_window_is_no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    import matplotlib.pyplot as plt

    from warehouse_core.render.window import has_display

    def switched(backend: str) -> None:
        if backend == "qtagg":
            raise ImportError("there is no such toolkit here")

    monkeypatch.setattr(plt, "switch_backend", switched)
    for backend, expected in (("tkagg", True), ("qtagg", False), ("agg", False), ("svg", False)):
        monkeypatch.setattr(plt, "get_backend", lambda backend=backend: backend)
        assert has_display() == expected, backend


# Frames as files.


def svg_folder(folder: Path, frames: Any = None, **options: float) -> Path:
    save_frames_to_svg(short_episode() if frames is None else frames, folder, **options)
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def test_every_frame_is_a_file_and_the_legend_is_one(tmp_path: Path) -> None:
    # Letters are shapes; matplotlib writes the text as a comment next to them.
    files = contents(svg_folder(tmp_path / "new" / "folder"))
    assert sorted(files) == [*FRAME_FILES, "legend.svg"]
    assert all(ElementTree.fromstring(file).tag == f"{SVG}svg" for file in files.values())
    for frame, name in enumerate(FRAME_FILES):
        assert f"<!-- step {frame} of 6 -->".encode() in files[name]
        assert (b"<!-- DELIVERED -->" in files[name]) == (frame == 6)
        assert not any(words in files[name] for words in (b"robot (loaded)", b"battery"))
    for words in ("# wall", ". empty", "P pickup", "D dropoff"):
        assert words.encode() in files["legend.svg"]
    for words in ("R robot (empty)", "r robot (loaded)"):
        assert words.encode() in files["legend.svg"]
    assert b"charger" not in files["legend.svg"]


def test_files_show_chargers_and_their_legend_explains_them(tmp_path: Path) -> None:
    save_frames_to_svg([["R..", "..."], ["R.C", "..."]], tmp_path)
    files = contents(tmp_path)
    assert b"C charger" in files["legend.svg"]
    assert files[FRAME_FILES[0]] != files[FRAME_FILES[1]]


def test_files_of_other_names_are_left_alone_and_of_these_names_replaced(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "frame_0000.svg").write_text("an older one")
    files = contents(svg_folder(tmp_path))
    assert files.pop("notes.txt") == b"mine"
    assert sorted(files) == [*FRAME_FILES, "legend.svg"]
    assert files["frame_0000.svg"].startswith(b"<?xml")


@pytest.mark.parametrize("dpi", [0, math.nan])
def test_dpi_must_be_positive_and_finite(tmp_path: Path, dpi: float) -> None:
    with pytest.raises(ValueError, match=r"dpi is .*; it must be above 0 and finite"):
        svg_folder(tmp_path / "frames", dpi=dpi)
    assert list(tmp_path.iterdir()) == []


def test_a_mistake_in_the_frames_makes_no_folder(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="frame 0, row 0, column 1"):
        svg_folder(tmp_path / "frames", [["R!"]])
    assert list(tmp_path.iterdir()) == []


def test_a_failure_leaves_the_frames_before_it_and_no_part(tmp_path, monkeypatch) -> None:
    save_svg, done = figures.save_svg, []

    def broken(figure: Any, path: Path, dpi: float) -> None:
        save_svg(figure, path, dpi)
        done.append(path)
        if len(done) == 3:
            raise OSError("No space left on device")

    monkeypatch.setattr(figures, "save_svg", broken)
    with pytest.raises(OSError, match="No space left"):
        svg_folder(tmp_path)
    assert sorted(contents(tmp_path)) == FRAME_FILES[:2]


def test_frames_and_legend_have_the_colours_of_the_chapter() -> None:
    grid = _grid_to_rgb([["#", ".", "P"], ["D", "R", "r"]])
    colors = [(0.1, 0.1, 0.1), (0.95, 0.95, 0.95), (0.2, 0.6, 1)]
    colors += [(0.2, 0.8, 0.3), (0.9, 0.2, 0.2), (0.95, 0.6, 0.2)]
    assert grid.tolist() == [[*map(list, colors[:3])], [*map(list, colors[3:])]]
    handles = _legend_handles()
    assert [handle.get_facecolor()[:3] for handle in handles] == colors
    assert [handle.get_label() for handle in handles] == [
        "wall", "empty", "pickup", "dropoff", "robot (empty)", "robot (loaded)",
    ]  # fmt: skip
