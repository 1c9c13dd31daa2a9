"""A missing or broken plugin raises a single error of one line, and the grid still works."""

import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest

from warehouse_core import BackendError
from warehouse_core.motion.backends import GROUP, load_backend
from warehouse_physics import RigidBodyMotion
from warehouse_physics.pymunk_version import check_version

# Registers both backends, even if the installed distribution does not, and tries them twice.
TRY_BOTH = """
import sys
import importlib.metadata as metadata
from importlib.metadata import EntryPoint

{damage}
from warehouse_core import BackendError, WarehouseEnv
from warehouse_core.motion.backends import GROUP

found = [
    EntryPoint("grid", "warehouse_core.motion.grid:GridMotion", GROUP),
    EntryPoint("physics", "warehouse_physics:RigidBodyMotion", GROUP),
]
metadata.entry_points = lambda group: found
for point in found:
    vars(point).update(dist=None)
for attempt in range(2):
    try:
        WarehouseEnv(backend="physics")
    except BackendError as error:
        print(error)
    print(WarehouseEnv(backend="grid").step("E")[1])
"""
COMMAND = "pip install 'warehouse_physics'"


@pytest.mark.parametrize(
    ("damage", "line"),
    [
        ("sys.modules['pymunk'] = None", "needs pymunk, which is not installed: "),
        ("", "cannot be loaded: libchipmunk.so: invalid ELF header; to repair it: "),
    ],
    ids=["absent", "broken"],
)
def test_a_plugin_that_cannot_be_loaded_raises_one_line_and_the_grid_works(
    damage: str, line: str, tmp_path: Path
) -> None:
    if not damage:
        broken = "raise OSError('libchipmunk.so:\\n invalid ELF header')"
        (tmp_path / "pymunk.py").write_text(broken)
    code = TRY_BOTH.format(damage=damage)
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, check=True, text=True
    )
    assert run.stderr == ""
    # The second attempt shows that a failed import leaves no half-loaded package behind.
    assert run.stdout.splitlines() == [f"backend 'physics' {line}{COMMAND}", "-0.1"] * 2


@pytest.mark.parametrize("version", ["7.1", "7.10.2", "7.2.0rc1"])
def test_supported_versions_are_accepted(version: str) -> None:
    check_version(version)


@pytest.mark.parametrize("version", ["7.0.9", "8.0", "70.1", ""])
def test_the_error_of_an_unsupported_version_names_it(version: str) -> None:
    with pytest.raises(ImportError, match=rf"^pymunk {version} is installed; 7\.1 or later"):
        check_version(version)


def test_the_plugin_is_found_by_its_entry_point(install: Any) -> None:
    install(EntryPoint("physics", "warehouse_physics:RigidBodyMotion", GROUP))
    assert load_backend("physics") is RigidBodyMotion
    point = EntryPoint("physics", "warehouse_physics:NoSuchMotion", GROUP)
    vars(point).update(dist=None)
    install(point)
    with pytest.raises(BackendError, match=r"^backend 'physics' cannot be loaded: .*NoSuchMotion"):
        load_backend("physics")
