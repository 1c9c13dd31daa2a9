from pathlib import Path

import pytest
from helpers.command_line import without_display
from helpers.pictures import short_episode
from PIL import Image

from agents.console import output as replaying
from agents.console.output import check_targets, replay_or_save, save_episode
from warehouse_core import Episode
from warehouse_core.errors import FormatError

NO_DISPLAY = "there is no display to open a window on"


@pytest.fixture(autouse=True)
def no_display(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    without_display(monkeypatch)
    monkeypatch.chdir(tmp_path)


class Window:
    """Stands in for a replay with a window, and notes that it was opened."""

    window = True

    def __init__(self) -> None:
        self.opened: list[tuple[object, ...]] = []

    def __call__(self, *arguments: object, **options: object) -> "Window":
        self.arguments = (*arguments, *options.items())
        return self

    def show(self) -> None:
        self.opened.append(self.arguments)


@pytest.fixture
def window(monkeypatch: pytest.MonkeyPatch) -> Window:
    window = Window()
    monkeypatch.setattr(replaying, "replay_animation", window)
    return window


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


# Targets.


def test_every_format_and_the_record_are_targets(tmp_path: Path) -> None:
    suffixes = ("gif", "mp4", "html", "svg", "png", "npz", "NPZ")
    check_targets([tmp_path / f"film.{suffix}" for suffix in suffixes])
    check_targets([])
    check_targets([Path("here.gif")])
    assert names(tmp_path) == []


def test_an_unknown_suffix_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"film\.txt: .* \.png, \.npz$"):
        check_targets([tmp_path / "film.gif", tmp_path / "film.txt"])


def test_a_missing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="missing does not exist"):
        check_targets([tmp_path / "missing" / "film.gif"])


def test_a_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "film.gif").mkdir()
    with pytest.raises(IsADirectoryError, match="is a folder"):
        check_targets([tmp_path / "film.gif"])


# Saving.


@pytest.mark.parametrize("name", ["episode.npz", "episode.NPZ"])
def test_a_record_is_saved_as_it_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    target = tmp_path / name
    save_episode(short_episode(), target)
    assert Episode.load(target) == short_episode()
    assert capsys.readouterr().out == f"saved {target}\n"


def test_a_picture_is_saved_at_the_speed_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "film.gif"
    save_episode(short_episode(), target, 300, 2.5)
    with Image.open(target) as film:
        assert film.info["duration"] == 120
    assert capsys.readouterr().out == f"saved {target}\n"


def test_saving_opens_no_window(tmp_path: Path) -> None:
    import matplotlib.pyplot as plt

    save_episode(short_episode(), tmp_path / "end.png")
    assert plt.get_fignums() == []


def test_every_target_is_written_and_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    targets = [tmp_path / name for name in ("a.svg", "b.png", "c.npz")]
    replay_or_save(short_episode(), targets, show=None)
    assert names(tmp_path) == ["a.svg", "b.png", "c.npz"]
    assert capsys.readouterr().out.splitlines() == [f"saved {target}" for target in targets]


# Showing.


def test_a_window_opens_where_nothing_is_saved(
    window: Window, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    episode = short_episode()
    replay_or_save(episode, [], None, 70, 3.0)
    assert window.opened == [(episode, None, 70, 3.0, ("window", None))]
    assert capsys.readouterr().out == "space pauses, left and right step, q closes the window\n"
    assert names(tmp_path) == []


def test_no_window_opens_where_something_is_saved(window: Window, tmp_path: Path) -> None:
    replay_or_save(short_episode(), [tmp_path / "a.npz"], None)
    assert window.opened == []
    assert names(tmp_path) == ["a.npz"]


def test_a_window_opens_after_saving_if_asked_for(window: Window, tmp_path: Path) -> None:
    replay_or_save(short_episode(), [tmp_path / "a.npz"], show=True)
    assert len(window.opened) == 1
    assert names(tmp_path) == ["a.npz"]


def test_no_window_opens_if_it_is_not_wanted(window: Window, tmp_path: Path) -> None:
    replay_or_save(short_episode(), [], show=False)
    assert window.opened == []
    assert names(tmp_path) == []


@pytest.mark.parametrize("show", [None, True])
def test_without_a_display_the_replay_goes_to_a_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], show: bool | None
) -> None:
    replay_or_save(short_episode(), [], show)
    assert names(tmp_path) == ["replay-4.gif"]
    with Image.open("replay-4.gif") as film:
        assert film.n_frames == 7  # type: ignore[attr-defined]
    assert capsys.readouterr().out.splitlines() == [
        f"{NO_DISPLAY}, so the replay goes to a file",
        "saved replay-4.gif",
    ]


def test_an_episode_without_a_seed_goes_to_a_file_too(tmp_path: Path) -> None:
    replay_or_save(short_episode(seed=None), [], None)
    assert names(tmp_path) == ["replay-unseeded.gif"]


def test_without_a_display_a_window_that_is_asked_for_is_missed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    replay_or_save(short_episode(), [Path("a.npz")], show=True)
    assert capsys.readouterr().out.splitlines() == ["saved a.npz", NO_DISPLAY]
    assert names(tmp_path) == ["a.npz"]


def test_without_a_display_nothing_is_written_if_no_window_is_wanted(tmp_path: Path) -> None:
    replay_or_save(short_episode(), [], show=False)
    assert names(tmp_path) == []
