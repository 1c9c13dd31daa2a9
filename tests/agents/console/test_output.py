from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import without_display
from helpers.pictures import short_episode
from PIL import Image

from agents.console import output
from agents.console.output import replay_or_save
from warehouse_core import Episode

NO_DISPLAY = "there is no display to open a window on"


@pytest.fixture(autouse=True)
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, small_pictures: None) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


class FakeReplay:
    """Replaces ``replay_animation`` and the replay, and records the calls."""

    def __init__(self) -> None:
        self.arguments: list[tuple[Any, ...]] = []
        self.shown = 0

    def __call__(self, *arguments: Any, window: bool, plans: object) -> "FakeReplay":
        assert not plans
        self.window = window
        self.arguments.append((*arguments, window))
        return self

    def show(self) -> None:
        self.shown += 1

    def save(self, target: Path) -> None:
        assert not self.window
        target.touch()


def fake(monkeypatch: pytest.MonkeyPatch, *, has_display: bool) -> FakeReplay:
    replay = FakeReplay()
    monkeypatch.setattr(output, "replay_animation", replay)
    monkeypatch.setattr(output, "has_display", lambda: has_display)
    return replay


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("name", ["episode.npz", "episode.NPZ"])
def test_a_record_is_saved(folder: Path, name: str) -> None:
    replay_or_save(short_episode(), [Path(name)], None)
    assert names(folder) == [name]
    assert Episode.load(name) == short_episode()


def test_a_replay_is_saved_at_the_given_speed_and_opens_no_window(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import matplotlib.pyplot as plt

    without_display(monkeypatch)
    replay_or_save(short_episode(), [Path("film.gif")], None, 300, 2.5)
    with Image.open("film.gif") as film:
        assert film.info["duration"] == 120
    assert capsys.readouterr().out == "saved film.gif\n"
    assert plt.get_fignums() == []


@pytest.mark.parametrize(
    ("files", "show", "opened"),
    [
        ([], None, 1),
        ([], True, 1),
        ([], False, 0),
        (["a.svg", "b.npz"], None, 0),
        (["a.svg", "b.npz"], True, 1),
    ],
)
def test_a_window_opens_if_requested_or_if_nothing_is_saved(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    folder: Path,
    files: list[str],
    show: bool | None,
    opened: int,
) -> None:
    replay, episode = fake(monkeypatch, has_display=True), short_episode()
    replay_or_save(episode, [Path(file) for file in files], show, 70, 3.0)
    assert names(folder) == files
    assert replay.shown == opened
    lines = [f"saved {file}" for file in files]
    if opened:
        assert replay.arguments[-1] == (episode, None, 70, 3.0, True)
        lines.append("space pauses, left and right step, q closes the window")
    assert capsys.readouterr().out.splitlines() == lines


@pytest.mark.parametrize(
    ("files", "show", "seed", "lines"),
    [
        (
            [],
            None,
            4,
            [f"{NO_DISPLAY}, so the replay goes to a file", "saved replay-Tester-grid-4.gif"],
        ),
        (
            [],
            True,
            None,
            [
                f"{NO_DISPLAY}, so the replay goes to a file",
                "saved replay-Tester-grid-unseeded.gif",
            ],
        ),
        ([], False, 4, []),
        (["a.npz"], None, 4, ["saved a.npz"]),
        (["a.npz"], True, 4, ["saved a.npz", NO_DISPLAY]),
    ],
)
def test_without_a_display_the_replay_goes_to_a_file(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    folder: Path,
    files: list[str],
    show: bool | None,
    seed: int | None,
    lines: list[str],
) -> None:
    replay = fake(monkeypatch, has_display=False)
    replay_or_save(short_episode(seed=seed), [Path(file) for file in files], show)
    assert replay.shown == 0
    assert capsys.readouterr().out.splitlines() == lines
    saved = [line.removeprefix("saved ") for line in lines if line.startswith("saved")]
    assert names(folder) == saved


def test_a_default_name_does_not_overwrite_an_older_file(
    monkeypatch: pytest.MonkeyPatch, folder: Path
) -> None:
    fake(monkeypatch, has_display=False)
    for _ in range(3):
        replay_or_save(short_episode(), [], None)
    first = "replay-Tester-grid-4"
    assert names(folder) == [f"{first}-2.gif", f"{first}-3.gif", f"{first}.gif"]


def test_the_name_of_an_agent_cannot_lead_to_another_folder(
    monkeypatch: pytest.MonkeyPatch, folder: Path
) -> None:
    fake(monkeypatch, has_display=False)
    episode = short_episode()
    episode.agent = "../my agent"
    replay_or_save(episode, [], None)
    assert names(folder) == ["replay-_my_agent-grid-4.gif"]
