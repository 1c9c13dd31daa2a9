"""Who imports whom, and what a bare environment does without."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import warehouse_core

ROOT = Path(__file__).parents[2]
HEAVY = ("matplotlib", "gymnasium", "pymunk", "rich", "typer")
FORBIDDEN = {
    "warehouse_core": ("warehouse_physics", "agents", "tests"),
    "warehouse_physics": ("agents", "tests"),
    "agents": ("tests",),
}
PROGRAMS = {
    "one": """
import warehouse_core
env = warehouse_core.WarehouseEnv()
env.reset(randomize=True, seed=1)
env.step("E")
""",
    "a batch": """
from warehouse_core.vector.env import BatchEnv
batch = BatchEnv(3)
batch.reset(seed=1)
batch.step([1, 2, 3])
""",
}
"""What can be done without them."""

FILES = [path for package in FORBIDDEN for path in sorted((ROOT / package).rglob("*.py"))]


def imported_by(path: Path) -> set[str]:
    """Return the top-level packages that a file imports, inside functions too."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names.add((node.module or "").partition(".")[0])
    return names


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_imports_run_one_way(path: Path) -> None:
    package = path.relative_to(ROOT).parts[0]
    assert not imported_by(path) & set(FORBIDDEN[package])


def test_every_package_is_looked_at() -> None:
    assert {path.relative_to(ROOT).parts[0] for path in FILES} == set(FORBIDDEN)


def test_gymnasium_is_imported_in_one_place() -> None:
    core = [path for path in FILES if path.relative_to(ROOT).parts[0] != "agents"]
    importing = [path for path in core if "gymnasium" in imported_by(path)]
    assert {path.parent.name for path in importing} == {"gymnasium_env"}


@pytest.mark.parametrize("program", PROGRAMS.values(), ids=PROGRAMS.keys())
def test_a_bare_environment_loads_none_of_the_heavy_libraries(program: str) -> None:
    look = f"import sys; print([name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", f"{program}\n{look}"],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    assert done.stdout.strip() == "[]"


def test_the_public_names_exist_and_are_sorted() -> None:
    names = warehouse_core.__all__
    assert all(hasattr(warehouse_core, name) for name in names)
    constants = [name for name in names if name.isupper()]
    classes = [name for name in names if name[0].isupper() and not name.isupper()]
    functions = [name for name in names if name.islower()]
    assert names == [*sorted(constants), *sorted(classes), *sorted(functions)]
