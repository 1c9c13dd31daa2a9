from pathlib import Path

import pytest

from warehouse_core.files.atomic import atomic_path


def test_a_file_appears_whole(tmp_path: Path) -> None:
    target = tmp_path / "film.gif"
    with atomic_path(target) as part:
        part.write_text("all of it")
        assert not target.exists()
    assert target.read_text() == "all of it"
    assert list(tmp_path.iterdir()) == [target]


def test_a_text_path_will_do(tmp_path: Path) -> None:
    with atomic_path(str(tmp_path / "a.txt")) as part:
        part.write_text("x")
    assert (tmp_path / "a.txt").read_text() == "x"


def test_the_part_is_a_neighbour_with_the_same_suffix(tmp_path: Path) -> None:
    with atomic_path(tmp_path / "film.gif") as part:
        assert part.parent == tmp_path
        assert part.suffix == ".gif"
        part.touch()


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_a_failure_leaves_what_was_there_and_no_part(
    tmp_path: Path, error: type[BaseException]
) -> None:
    target = tmp_path / "film.gif"
    target.write_text("the old one")
    with pytest.raises(error), atomic_path(target) as part:  # noqa: PT012
        part.write_text("half of")
        raise error
    assert target.read_text() == "the old one"
    assert list(tmp_path.iterdir()) == [target]


def test_a_failure_leaves_nothing_where_nothing_was(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError), atomic_path(tmp_path / "film.gif") as part:  # noqa: PT012
        part.write_text("half of")
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_replaced(tmp_path: Path) -> None:
    target = tmp_path / "film.gif"
    for text in ("one", "two"):
        with atomic_path(target) as part:
            part.write_text(text)
    assert target.read_text() == "two"


def test_a_block_that_writes_nothing_fails(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), atomic_path(tmp_path / "film.gif"):
        pass


def test_a_folder_is_no_target(tmp_path: Path) -> None:
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
