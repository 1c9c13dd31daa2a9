"""Digests of this program and of an agent's code, on which a row depends besides its case."""

import hashlib
import os
from pathlib import Path

import pytest
from helpers.command_line import ROOT, in_a_process

from agents.errors import AgentError
from agents.lab.runs import programs
from agents.lab.runs.programs import fingerprint, own_sources, program_for

MODULES = {
    "mine.py": "import numpy, helper\nclass Mine: pass\n",
    "helper.py": "def late():\n    from inner.deep import word\n",
    "inner/deep.py": "from . import word\n",
    "inner/word.py": "from ..helper import late\n",
    "starred.py": "from inner import *\n",
    "unused.py": "x = 1\n",
}
IMPORTED = ["mine.py", "helper.py", "inner/deep.py", "inner/word.py"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in MODULES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_a_program_is_named_by_its_version_its_sources_and_its_libraries_unimported() -> None:
    own, numpy = program_for("grid").split(", ")
    assert own.startswith("warehouse-lab ")
    assert numpy.startswith("numpy ")
    assert program_for("physics").startswith(f"{own}, {numpy}, pymunk 7.")
    look = (
        "import sys; from agents.lab.runs.programs import program_for; "
        "print(program_for('physics')); "
        "print('pymunk' in sys.modules)"
    )
    name, is_imported = in_a_process("-c", look, folder=ROOT).out.splitlines()
    assert (name, is_imported) == (program_for("physics"), "False")


def test_the_sources_of_a_program_are_the_files_that_affect_rows() -> None:
    names = {path.relative_to(ROOT).as_posix() for path in own_sources()}
    assert names >= {
        "agents/lab/experiments/case.py", "agents/lab/place.py", "agents/registry.py",
        "agents/search/algorithms.py", "warehouse_core/task/rules.py",
        "warehouse_core/records/failure_modes.py", "warehouse_physics/robot.py",
    }  # fmt: skip
    assert not [
        name for name in names if name.split("/")[1] in ("viz", "render", "reports", "commands")
    ]
    assert not [name for name in names if name.startswith("agents/lab/console/")][1:]


def own_digest(folder: Path, name: str, text: str) -> str:
    (folder / name).parent.mkdir(exist_ok=True, parents=True)
    (folder / name).write_text(text)
    programs._own_digest.cache_clear()
    return programs._own_digest()


@pytest.mark.parametrize(
    ("name", "is_another"),
    [("agents/rules.py", True), ("agents/more.py", True), ("agents/viz/chart.py", False)],
)
def test_the_name_of_a_program_changes_with_a_source_that_affects_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, is_another: bool
) -> None:
    monkeypatch.setattr(programs, "ROOT", tmp_path)
    before = own_digest(tmp_path, "agents/rules.py", "COST = 1\n")
    assert (own_digest(tmp_path, name, "COST = 2\n") != before) == is_another
    programs._own_digest.cache_clear()


def test_the_fingerprint_of_one_file_is_its_digest(folder: Path) -> None:
    file = folder / "unused.py"
    assert fingerprint(file, None) == hashlib.sha256(file.read_bytes()).hexdigest()
    own = folder / "own.py"
    own.write_text("import agents.registry, numpy, missing, random\n")
    (folder / "agents").mkdir()
    (folder / "agents" / "registry.py").write_text("")
    assert fingerprint(own, None) == hashlib.sha256(own.read_bytes()).hexdigest()


@pytest.mark.parametrize("changed", MODULES)
def test_a_fingerprint_covers_the_file_and_its_imports_from_the_same_folder(
    folder: Path, changed: str
) -> None:
    before = fingerprint(folder / "mine.py", None)
    assert fingerprint(folder / "mine.py", None) == before
    with (folder / changed).open("a") as file:
        file.write("# changed")
    assert (fingerprint(folder / "mine.py", None) != before) == (changed in IMPORTED)


def test_all_modules_of_a_package_may_be_imported_by_a_star(folder: Path) -> None:
    before = fingerprint(folder / "starred.py", None)
    (folder / "inner" / "word.py").write_text("")
    assert fingerprint(folder / "starred.py", None) != before


@pytest.mark.parametrize("text", [b"import (", b"\xff\xfe", b"\x00", b"(" * 10_000])
def test_a_file_that_cannot_be_parsed_has_a_fingerprint(folder: Path, text: bytes) -> None:
    file = folder / "mine.py"
    file.write_bytes(text)
    assert fingerprint(file, None) == hashlib.sha256(text).hexdigest()


LOOK = """
import sys
sys.path.insert(0, sys.argv[1])
from agents.lab.runs.programs import fingerprint
print(fingerprint(None, sys.argv[2]))
print("inner.deep" in sys.modules)
"""


def test_the_fingerprint_of_a_module_covers_its_package_and_folder(folder: Path) -> None:
    found = []
    for changed in ("helper.py", "inner/__init__.py", "mine.py", ""):
        result = in_a_process("-c", LOOK, folder, "inner.deep", folder=ROOT)
        digest, is_imported = result.out.splitlines()
        assert (len(digest), is_imported) == (64, "False")
        found.append(digest)
        if changed:
            with (folder / changed).open("a") as file:
                file.write("# changed")
    assert len({*found[:3]}) == 3
    assert found[2] == found[3]


def test_only_the_agents_own_package_is_read_among_installed_packages(folder, monkeypatch) -> None:
    monkeypatch.setattr(programs, "_installed", lambda: {folder})
    names = [
        {file.name for file in programs._with_imports([folder / name], folder, own)}
        for name, own in (("mine.py", None), ("mine.py", "helper"), ("inner/deep.py", "inner"))
    ]
    assert names == [{"mine.py"}, {"mine.py", "helper.py"}, {"deep.py", "word.py", "helper.py"}]


def test_the_agents_of_this_program_have_no_fingerprint() -> None:
    assert fingerprint(None, None) is None
    assert fingerprint(None, "agents.warehouse_agent_greedy") is None


def test_only_files_of_a_limited_size_are_read(folder: Path, monkeypatch) -> None:
    os.mkfifo(folder / "pipe.py")
    for other in (folder, folder / "pipe.py", Path("/dev/zero")):
        with pytest.raises(AgentError, match=r"it is a (folder|pipe|device), not a file"):
            fingerprint(other, None)
    monkeypatch.setattr(programs, "MAX_BYTES", 3)
    with pytest.raises(AgentError, match=r"unused\.py: it is longer than MAX_BYTES = 3"):
        fingerprint(folder / "unused.py", None)
