import errno
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import in_a_process

from warehouse_core import Layout
from warehouse_core.files import write_arrays
from warehouse_core.files.atomic import atomic_path
from warehouse_core.files.tables import write_table


def test_a_file_appears_complete(tmp_path: Path) -> None:
    target = tmp_path / "film.gif"
    with atomic_path(target) as part:
        part.write_text("all of it")
        assert not target.exists()
    assert target.read_text() == "all of it"
    assert list(tmp_path.iterdir()) == [target]
    with atomic_path(str(target)) as part:
        part.write_text("replaced")
    assert target.read_text() == "replaced"


def test_the_temporary_file_is_in_a_private_folder_with_the_name_of_the_target(tmp_path) -> None:
    with atomic_path(tmp_path / "film.gif") as part:
        assert part.name == "film.gif"
        assert part.parent.parent == tmp_path
        assert part.parent.stat().st_mode & 0o777 == 0o700
        part.touch()


@pytest.mark.parametrize("old", ["old", None])
@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_an_error_leaves_the_old_file_if_there_was_one_and_no_temporary_file(
    tmp_path: Path, error: type[BaseException], old: str | None
) -> None:
    target = tmp_path / "film.gif"
    if old is not None:
        target.write_text(old)
    before = [*tmp_path.iterdir()]
    with pytest.raises(error), atomic_path(target) as part:  # noqa: PT012
        part.write_text("half of")
        raise error
    assert [*tmp_path.iterdir()] == before
    assert old is None or target.read_text() == old


def test_a_block_that_writes_nothing_raises(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), atomic_path(tmp_path / "film.gif"):
        pass


def test_a_folder_as_target_raises(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError, match="is a folder"), atomic_path(tmp_path):
        pass
    assert tmp_path.is_dir()


def test_the_folder_must_exist(tmp_path: Path) -> None:
    folder = tmp_path / "missing"
    with (
        pytest.raises(FileNotFoundError, match="missing does not exist"),
        atomic_path(folder / "film.gif"),
    ):
        pass
    assert not folder.exists()


@pytest.mark.parametrize("names_file", [True, False], ids=["in the folder", "no file"])
def test_an_error_of_writing_names_the_target(tmp_path: Path, names_file: bool) -> None:
    target = tmp_path / "film.gif"
    with pytest.raises(OSError, match="No space") as caught, atomic_path(target) as part:
        raise OSError(errno.ENOSPC, "No space left on device", str(part) if names_file else None)
    assert str(caught.value) == f"[Errno {errno.ENOSPC}] No space left on device: '{target}'"


def test_an_error_of_another_file_keeps_its_name(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught, atomic_path(tmp_path / "film.gif"):
        (tmp_path / "ffmpeg").open()
    assert caught.value.filename == str(tmp_path / "ffmpeg")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
def test_a_writer_that_is_killed_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "agent.npz"
    target.write_text("old")
    program = (
        "import os, signal, sys\n"
        "from warehouse_core.files import atomic_path\n"
        "with atomic_path(sys.argv[1]) as part:\n"
        "    part.write_text('half of')\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = in_a_process("-c", program, str(target), folder=tmp_path)
    assert (done.code, target.read_text()) == (-signal.SIGKILL, "old")


@pytest.fixture
def full_disk(tmp_path: Path) -> Iterator[Path]:
    """Return a folder on a disk of its own with 4 KiB left and an old file; only root can."""
    folder = tmp_path / "disk"
    folder.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(folder)]
    if not shutil.which("mount") or subprocess.run(words, capture_output=True).returncode:
        pytest.skip("only root can mount a disk")
    try:
        (folder / "old").write_text("old")
        (folder / "filler").write_bytes(bytes(52 * 1024))
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


NOISE = np.random.default_rng(1).random(10_000)
WRITERS: dict[str, Callable[[Path], object]] = {
    "arrays": lambda path: write_arrays(path, {"noise": NOISE}, {"noise": ("<f8", 1)}),
    "table": lambda path: write_table(path, ["noise"], [[str(each)] for each in NOISE]),
    "text": lambda path: Layout(["." * 300] * 300).save(path),
}
"""Writers of files that need more than 4 KiB."""


# NumPy 1 leaves a ZIP file open that it could not write; Python closes it later and warns.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("writer", WRITERS)
def test_on_a_full_disk_the_old_file_stays_and_the_message_names_it(full_disk, writer) -> None:
    target, before = full_disk / "old", [*full_disk.iterdir()]
    with pytest.raises(OSError, match=rf"No space left on device: '{target}'$"):
        WRITERS[writer](target)
    assert target.read_text() == "old"
    assert [*full_disk.iterdir()] == before
