from pathlib import Path

import pytest
from helpers.command_line import without_display
from helpers.pictures import short_episode
from PIL import Image

from agents.lab.console import output
from agents.lab.console.output import replay_or_save
from warehouse_core.viz.tracks.track import Track

NO_DISPLAY = "there is no display for a window"
KEYS = "Space pauses, the left and right arrow keys step, and Q closes the window"
TO_FILE = f"{NO_DISPLAY}, so the replay is saved to a file"


@pytest.fixture(autouse=True)
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, small_pictures: None) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


class FakeReplay:
    """A stand-in for the replay of tracks that records calls."""

    def __init__(self) -> None:
        self.speeds: list[float] = []
        self.shown = 0

    def __call__(self, track: Track, *, speed: float, window: bool) -> "FakeReplay":
        assert track.title.endswith("on the grid backend, seed 4") or "seed" not in track.title
        self.window = window
        self.speeds.append(speed)
        return self

    def show(self) -> None:
        assert self.window
        self.shown += 1

    def save(self, target: Path) -> None:
        assert not self.window
        target.touch()


def fake(monkeypatch: pytest.MonkeyPatch, *, has_display: bool) -> FakeReplay:
    replay = FakeReplay()
    monkeypatch.setattr("warehouse_core.viz.replay.replay_of_tracks", replay)
    monkeypatch.setattr(output, "has_display", lambda: has_display)
    return replay


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_replay_is_saved_at_the_given_speed_and_opens_no_window(monkeypatch, capsys) -> None:
    import matplotlib.pyplot as plt

    without_display(monkeypatch)
    replay_or_save(short_episode(), [Path("film.gif")], None, 1.25)
    with Image.open("film.gif") as film:
        assert film.info["duration"] == 120
    assert capsys.readouterr().out == "saved film.gif\n"
    assert plt.get_fignums() == []


@pytest.mark.parametrize(
    ("has_display", "files", "show", "lines"),
    [
        (True, [], None, [KEYS]),
        (True, [], True, [KEYS]),
        (True, [], False, []),
        (True, ["a.svg", "b.npz"], None, []),
        (True, ["a.svg", "b.npz"], True, [KEYS]),
        (False, [], None, [TO_FILE, "saved replay-Tester-grid-4.gif"]),
        (False, [], True, [TO_FILE, "saved replay-Tester-grid-4.gif"]),
        (False, [], False, []),
        (False, ["a.npz"], None, []),
        (False, ["a.npz"], True, [NO_DISPLAY]),
    ],
)
def test_a_window_opens_if_requested_or_if_nothing_is_saved(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    folder: Path,
    has_display: bool,
    files: list[str],
    show: bool | None,
    lines: list[str],
) -> None:
    replay = fake(monkeypatch, has_display=has_display)
    replay_or_save(short_episode(), [Path(file) for file in files], show, 3.0)
    lines = [*(f"saved {file}" for file in files), *lines]
    assert capsys.readouterr().out.splitlines() == lines
    assert names(folder) == [line[6:] for line in lines if line.startswith("saved ")]
    assert replay.shown == lines.count(KEYS)
    assert set(replay.speeds) <= {3.0}


def test_a_default_name_does_not_overwrite_an_older_file(monkeypatch, folder: Path) -> None:
    fake(monkeypatch, has_display=False)
    for _ in range(3):
        replay_or_save(short_episode(seed=None), [], None)
    first = "replay-Tester-grid-unseeded"
    assert names(folder) == [f"{first}-2.gif", f"{first}-3.gif", f"{first}.gif"]


def test_the_name_of_an_agent_cannot_lead_to_another_folder(monkeypatch, folder: Path) -> None:
    fake(monkeypatch, has_display=False)
    episode = short_episode()
    episode.agent = "../my agent"
    replay_or_save(episode, [], None)
    assert names(folder) == ["replay-_my_agent-grid-4.gif"]
