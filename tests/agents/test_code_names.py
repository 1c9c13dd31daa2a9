from pathlib import Path

import pytest

from agents.code_names import split_name

SIGNS = ["my", "a=b/my", "a:b/my", "x=1:y=2/my", "c:a=b", "my.py:Old", "robots.v2/my", "a b,c=d/my"]
"""Paths of files without suffix, with the signs that separate the parts of a name."""

WINDOWS = [r"C:\a=b\my.py", "D:/robots/my.py", r"C:\a=b\C=d:\my.PY", r"\\server\a=b\my.py"]


@pytest.mark.parametrize("suffix", [".py", ".PY"])
@pytest.mark.parametrize("path", SIGNS)
@pytest.mark.parametrize("kind", [None, "Mine", ""])
@pytest.mark.parametrize("options", ["", "speed=2", "speed=2,name=a:b/c.py=d"])
def test_a_file_that_exists_is_never_split(
    path: str,
    suffix: str,
    kind: str | None,
    options: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    file = Path(path + suffix)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.touch()
    name = str(file) + (f":{kind}" if kind is not None else "") + (f":{options}" if options else "")
    parts = split_name(name)
    assert parts == (str(file), kind, options)
    assert (parts.file, parts.module) == (file, None)


@pytest.mark.parametrize("file", [*WINDOWS, "a=b/my.py", "my.py"])
def test_a_missing_file_ends_at_the_first_colon_after_its_drive(file: str) -> None:
    for rest, expected in {
        "": (file, None, ""),
        ":Mine": (file, "Mine", ""),
        ":speed=2": (file, None, "speed=2"),
        ":Mine:other=b.py": (file, "Mine", "other=b.py"),
    }.items():
        assert split_name(file + rest) == expected


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("greedy", ("greedy", None, "")),
        ("greedy:memory=20,escape_steps=0", ("greedy", None, "memory=20,escape_steps=0")),
        ("physics:drive=differential", ("physics", None, "drive=differential")),
        ("robots.slow:Mine", ("robots.slow", "Mine", "")),
        ("robots.slow:Mine:at=1:2", ("robots.slow", "Mine", "at=1:2")),
        (":Mine", ("", "Mine", "")),
        ("", ("", None, "")),
        ("a=b", ("a=b", None, "")),
        ("a:/b/c", ("a:/b/c", None, "")),
        ("a\n", ("a\n", None, "")),
    ],
)
def test_other_names_are_built_in_names_or_modules(name, expected) -> None:
    parts = split_name(name)
    assert parts == expected
    assert (parts.file, parts.module) == (None, None if expected[1] is None else expected[0])


def test_of_two_files_the_longer_one_is_meant(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("my.py", "my.py:x=1.py", "greedy"):
        Path(name).touch()
    Path("folder.py").mkdir()
    assert split_name("my.py:x=1.py") == ("my.py:x=1.py", None, "")
    assert split_name("my.py:x=1.npz") == ("my.py", None, "x=1.npz")
    assert split_name("greedy:x=1.py:y=2").source == "greedy"  # a file without a suffix
    assert split_name("folder.py:x=1.py").source == "folder.py"


def test_a_file_with_any_suffix_has_no_class(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    for file in ("a:b", "rate=1.npz", "a:b=c"):
        Path(file).touch()
        assert split_name(file, [""]) == (file, None, "")
        assert split_name(f"{file}:revisit=4", [""]) == (file, None, "revisit=4")
    assert split_name("missing=1.npz", [""]).source == "missing=1.npz"
    assert split_name(r"C:\missing.npz:revisit=4", [""]) == (
        r"C:\missing.npz", None, "revisit=4",
    )  # fmt: skip
    assert split_name("run 12:30.npz", [""]).source == "run 12:30.npz"
