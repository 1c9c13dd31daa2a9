"""Exported files are read by other libraries than those that wrote them."""

import errno
import html
import io
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import imageio_ffmpeg
import numpy as np
import pytest
from helpers.pictures import named, pixels, replay_of, short_episode, texts
from helpers.player import said_by
from PIL import Image, ImageSequence

from warehouse_core.errors import FormatError
from warehouse_core.viz.export import FORMATS, mp4_frames
from warehouse_core.viz.figure import SceneFigure, save_svg
from warehouse_core.viz.gif_writer import GifWriter, indexed
from warehouse_core.viz.pixel_box import PixelBox

FRAMES = 7
SVG = "{http://www.w3.org/2000/svg}"


def saved(folder: Path, suffix: str, **options: float) -> Path:
    path = folder / f"film{suffix}"
    replay_of(short_episode(), **options).save(path)
    return path


@pytest.fixture(scope="module")
def films(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the short episode in every format."""
    folder = tmp_path_factory.mktemp("films")
    for suffix in FORMATS:
        saved(folder, suffix)
    replay = replay_of(short_episode())
    replay.show_still()
    save_svg(replay.figure, folder / "still.svg")
    return folder


@pytest.fixture(scope="module")
def drawings() -> list[Image.Image]:
    """Return each frame of the short episode, in the 256 colours of files."""
    replay = replay_of(short_episode())
    found = []
    for frame in range(FRAMES):
        replay.go_to(frame)
        found.append(indexed(replay.figure.pixels()).convert("RGB"))
    return found


def drawn(frame: int) -> np.ndarray:
    replay = replay_of(short_episode())
    replay.go_to(frame)
    return pixels(replay)


# GIF.


def frames_of_gif(path: Path) -> tuple[list[np.ndarray], list[int]]:
    images, durations = [], []
    with Image.open(path) as film:
        for index in range(film.n_frames):  # type: ignore[attr-defined]
            film.seek(index)
            images.append(np.asarray(film.convert("RGB")).astype(np.int64))
            durations.append(film.info["duration"])
    return images, durations


def test_a_gif_has_every_frame(films: Path, drawings: list[Image.Image]) -> None:
    images, durations = frames_of_gif(films / "film.gif")
    assert len(images) == FRAMES
    for frame, (image, drawing) in enumerate(zip(images, drawings, strict=True)):
        assert np.array_equal(image, drawing), frame
    # Smooth edges are rounded; plain colours are exact.
    assert (np.abs(images[3] - drawn(3)).max(axis=2) <= 1).mean() > 0.95
    assert durations == [150] * (FRAMES - 1) + [2000]
    with Image.open(films / "film.gif") as film:
        assert film.info["loop"] == 0


def test_a_long_gif_is_thinned_with_a_message(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setattr("warehouse_core.viz.replay.MAX_GIF_FRAMES", 4)
    frames = [["." * col + "R" + "." * (9 - col)] for col in range(10)]
    replay_of(frames, interval_ms=100).save(tmp_path / "film.gif")
    images, durations = frames_of_gif(tmp_path / "film.gif")
    assert len(images) == 4
    assert durations[:-1] == [100] * 3
    assert capsys.readouterr().err.startswith("drawing 4 of 10 frames; a page (.html)")
    replay_of(frames[:4]).save(tmp_path / "film.gif")
    assert len(frames_of_gif(tmp_path / "film.gif")[0]) == 4
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
def test_a_message_announces_a_long_film(tmp_path, monkeypatch, capsys, suffix: str) -> None:
    monkeypatch.setattr("warehouse_core.viz.replay.LONG", 4)
    frames = [["." * col + "R" + "." * (3 - col)] for col in range(4)]
    for shown, words in ((frames[:3], ""), (frames, "drawing 4 of 4 frames; a page")):
        replay_of(shown).save((tmp_path / "film").with_suffix(suffix))
        assert capsys.readouterr().err[: len(words) or None] == words


# GIFs count hundredths of a second, up to a maximum; viewers play shorter frames slowly.
@pytest.mark.parametrize(("frame_ms", "duration"), [(75, 70), (0.15, 20), (6e6, 655_350)])
def test_a_gif_plays_at_the_speed_of_the_replay(tmp_path, frame_ms: float, duration: int) -> None:
    replay_of([["R.P"], [".RP"]], interval_ms=frame_ms).save(tmp_path / "film.gif")
    assert frames_of_gif(tmp_path / "film.gif")[1][:-1] == [duration]


def test_each_frame_of_a_gif_is_drawn_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    replay = replay_of(named("Tester"))
    update, drawn_frames = SceneFigure._update, []

    def counted(self: SceneFigure, renderer: object) -> None:
        drawn_frames.append(self)
        update(self, renderer)

    monkeypatch.setattr(SceneFigure, "_update", counted)
    replay.save(tmp_path / "film.gif")
    assert len(drawn_frames) == 2 + 1, "and at the end the frame that it showed before"


# PNG.


def test_a_png_shows_the_end(films: Path) -> None:
    with Image.open(films / "film.png") as image:
        assert image.format == "PNG"
        assert np.array_equal(image.convert("RGB"), drawn(FRAMES - 1))


# SVG.


def test_a_still_svg_shows_the_end(films: Path) -> None:
    text = (films / "still.svg").read_text(encoding="utf-8")
    assert "dc:date" not in text
    # Letters are shapes; matplotlib adds a comment with their text.
    assert "<!-- step 6 of 6 -->" in text
    assert "<!-- DELIVERED -->" in text
    assert "step 0 of 6" not in text
    root = ElementTree.fromstring(text)
    assert root.tag == f"{SVG}svg"
    assert not list(root.iter(f"{SVG}text")), "no font is needed to show it"
    colors = set(re.findall(r"#[0-9a-f]{6}", text))
    wall, pickup, dropoff, robot = "#1a1a1a", "#3399ff", "#33cc4c", "#e63333"
    assert {wall, pickup, dropoff, robot} <= colors


# MP4.


def run_ffmpeg(*words: object) -> "subprocess.CompletedProcess[bytes]":
    program = imageio_ffmpeg.get_ffmpeg_exe()
    return subprocess.run([program, *map(str, words)], capture_output=True, check=False)


def test_an_mp4_has_every_frame(films: Path, drawings: list[Image.Image]) -> None:
    path = films / "film.mp4"
    about = run_ffmpeg("-i", path).stderr.decode()
    assert re.search(r"Video: h264\b.*\byuv420p\b.* 6\.67 fps", about)
    # Its size is even, which may cost one row and one column.
    rows, columns = (side // 2 * 2 for side in drawings[0].size[::-1])
    data = run_ffmpeg("-v", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-").stdout
    images = np.frombuffer(data, dtype=np.uint8).reshape(-1, rows, columns, 3).astype(np.int64)
    assert len(images) == FRAMES
    expected = [np.asarray(drawing).astype(int)[:rows, :columns] for drawing in drawings]
    distances = [[np.abs(image - other).mean() for other in expected] for image in images]
    assert np.argmin(distances, axis=1).tolist() == list(range(FRAMES))
    assert max(map(min, distances)) < 6


def test_a_full_disk_is_an_error_of_the_file(tmp_path: Path) -> None:
    full = tmp_path / "film.mp4"
    full.symlink_to("/dev/full")
    with pytest.raises(OSError, match=r"No space.*film\.mp4"), mp4_frames(full, 5, 64, 64) as add:
        add(bytes(100 * 64 * 64 * 4))


def test_ffmpeg_that_ends_early_is_an_error_of_the_file(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("warehouse_core.viz.export.ffmpeg", lambda: "/bin/false")
    with pytest.raises(OSError, match="ffmpeg ended with exit code 1: "):
        saved(tmp_path, ".mp4")
    assert not list(tmp_path.iterdir())


def test_an_mp4_without_its_library_names_the_command_that_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(FormatError, match=r"pip install 'imageio-ffmpeg>=0.5'"):
        saved(tmp_path, ".mp4")
    assert list(tmp_path.iterdir()) == []


# HTML.


def title_of(page: str) -> str:
    [title] = re.findall("<title>([^<]*)</title>", page)
    return html.unescape(title)


def test_a_page_plays_at_the_speed_of_the_replay(tmp_path: Path) -> None:
    usual = said_by(saved(tmp_path, ".html").read_text(encoding="utf-8"))["speed"]
    faster = saved(tmp_path, ".html", interval_ms=300, speed=8)
    assert said_by(faster.read_text(encoding="utf-8"))["speed"] == 4 * usual


def test_a_page_of_frames_without_an_episode_has_a_title(tmp_path: Path) -> None:
    replay_of([["R.P"]]).save(tmp_path / "film.html")
    assert title_of((tmp_path / "film.html").read_text(encoding="utf-8")) == "Warehouse replay"


# Errors.


@pytest.mark.parametrize("name", ["film.jpeg", "film", "film.gif.zip", ".gif"])
def test_the_error_of_an_unknown_suffix_lists_the_formats(tmp_path: Path, name: str) -> None:
    with pytest.raises(FormatError) as refused:
        replay_of(short_episode()).save(tmp_path / name)
    assert str(tmp_path / name) in str(refused.value)
    assert str(refused.value).endswith("allowed: .gif, .mp4, .html, .svg, .png")
    assert list(tmp_path.iterdir()) == []


def fail_after_three_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the fourth picture fail, as a full disk would."""
    taken = []
    take = SceneFigure.rgba

    def broken(self: SceneFigure) -> np.ndarray:
        taken.append(self)
        if len(taken) > 3:
            raise OSError(errno.ENOSPC, "No space left on device")
        return take(self)

    monkeypatch.setattr(SceneFigure, "rgba", broken)


def fail_while_writing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make writing fail after half of the file."""

    def broken(self: object, target: object, *_: object, **__: object) -> None:
        Path(str(target)).write_bytes(b"half of it")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Image.Image, "save", broken)
    monkeypatch.setattr(SceneFigure, "savefig", broken)
    monkeypatch.setattr(Path, "write_text", lambda self, *_, **__: broken(self, self))
    monkeypatch.setattr(GifWriter, "finish", lambda self: broken(self, self._file.name))


@pytest.mark.parametrize(
    ("suffix", "break_off"),
    [
        (".gif", fail_after_three_frames),
        (".gif", fail_while_writing),
        (".mp4", fail_after_three_frames),
        (".html", fail_while_writing),
        (".png", fail_while_writing),
        (".svg", fail_while_writing),
    ],
)
def test_an_export_that_fails_keeps_the_existing_file_and_leaves_no_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str, break_off: object
) -> None:
    assert callable(break_off)
    target = tmp_path / f"film{suffix}"
    target.write_bytes(b"the older file")
    replay = replay_of(short_episode())
    replay.go_to(2)
    break_off(monkeypatch)
    with pytest.raises(OSError, match="No space left"):
        replay.save(target)
    assert target.read_bytes() == b"the older file"
    assert list(tmp_path.iterdir()) == [target]
    assert "step 2 of 6" in texts(replay), "the replay shows what it showed before"


def test_a_gif_that_goes_back_to_known_colors_shows_them_again() -> None:
    file = io.BytesIO()
    writer = GifWriter(file, 100)
    shades = [np.full((2, 2, 4), shade, np.uint8) for shade in (0, 255, 0, 255)]
    for shade in shades:
        writer.add(shade, [PixelBox(0, 2, 0, 2)])
    writer.finish()
    with Image.open(file) as gif:
        shown = [frame.convert("L").getpixel((0, 0)) for frame in ImageSequence.Iterator(gif)]
    assert shown[0] == shown[2] != shown[1] == shown[3]
