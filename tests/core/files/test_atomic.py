import errno
from pathlib import Path

import pytest

from warehouse_core.files.atomic import atomic_path


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


def test_the_temporary_file_is_in_a_private_folder_with_the_name_of_the_target(
    tmp_path: Path,
) -> None:
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
