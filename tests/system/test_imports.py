"""Which module imports which, what a bare environment does without, and what packages export."""

import ast
import importlib
import subprocess
import sys
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("warehouse_core", "warehouse_physics", "agents")
"""Each may import those before it."""

MAX_FLOORS = {"warehouse_core": 8, "warehouse_physics": 8, "agents": 7}
MAX_ROOMS = {"warehouse_core": 17, "agents": 13}
MAX_FILES, MAX_LINES = 12, 400

# TABLE

HEAVY = ("matplotlib", "gymnasium", "pymunk", "rich", "typer")
PROGRAMS = {
    "one": """
import warehouse_core
env = warehouse_core.WarehouseEnv()
env.reset(randomize=True, seed=1)
env.step("E")
""",
    "a batch": """
from warehouse_core import BatchEnv
batch = BatchEnv(3)
batch.reset(seed=1)
batch.step([1, 2, 3])
""",
}
"""Programs that need none of them."""

FILES = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(path): path for path in FILES}


def imported_by(path: Path) -> Iterator[str]:
    """Yield the modules that a file imports, inside functions and for types too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.module and not node.level, f"{path}: relative import"
            for alias in node.names:
                submodule = f"{node.module}.{alias.name}"
                yield submodule if submodule in MODULES else node.module


def place_of(module: str) -> str:
    """Return the folder of a module, or the module itself at the top of its package."""
    folder = MODULES[module].parent.relative_to(ROOT)
    return module.replace(".", "/") if len(folder.parts) == 1 else folder.as_posix()


def edges() -> Iterator[tuple[str, str]]:
    """Yield each import between two modules of the packages."""
    for module, path in MODULES.items():
        yield from ((module, name) for name in imported_by(path) if name in MODULES)


def test_imports_between_folders_are_those_of_the_table() -> None:
    used: dict[str, set[str]] = {place: set() for place in map(place_of, MODULES)}
    for importer, imported in edges():
        place, other = place_of(importer), place_of(imported)
        package, other_package = place.split("/")[0], other.split("/")[0]
        if package == other_package and "/" in place and place != other:
            used[place].add(other.partition("/")[2])
        assert PACKAGES.index(other_package) <= PACKAGES.index(package), (importer, imported)
    table = {place: set(names.split()) for place, names in MAY_IMPORT.items()}
    assert {place: names for place, names in used.items() if "/" in place} == table


def test_no_row_of_the_table_names_a_later_one() -> None:
    places = list(MAY_IMPORT)
    floors: dict[str, int] = {}
    for number, (place, names) in enumerate(MAY_IMPORT.items()):
        package = place.split("/")[0]
        below = [f"{package}/{name}" for name in names.split()]
        assert set(below) <= set(places[:number]), place
        floors[place] = 1 + max((floors[name] for name in below), default=0)
        assert floors[place] <= MAX_FLOORS[package], place


def test_no_modules_import_each_other_in_a_circle() -> None:
    graph: dict[str, set[str]] = {}
    for importer, imported in edges():
        graph.setdefault(importer, set()).add(imported)
    assert len(list(TopologicalSorter(graph).static_order())) > 100


@pytest.mark.parametrize("package", PACKAGES)
def test_folders_have_few_files_and_files_have_few_lines(package: str) -> None:
    folders = [path for path in (ROOT / package).rglob("*") if path.is_dir()]
    assert not [str(folder) for folder in folders if len(list(folder.glob("*.py"))) > MAX_FILES]
    rooms = {place for place in MAY_IMPORT if place.startswith(package) and place.count("/") == 1}
    assert len(rooms) <= MAX_ROOMS.get(package, 17)
    for path in FILES:
        assert len(path.read_text(encoding="utf-8").splitlines()) <= MAX_LINES, path


def test_gymnasium_is_imported_in_one_folder_of_the_core() -> None:
    core = {name: path for name, path in MODULES.items() if name.startswith("warehouse_core")}
    importing = [path for path in core.values() if "gymnasium" in imported_by(path)]
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


def test_the_packages_export_these_names() -> None:
    packages = {name: importlib.import_module(name) for name in EXPORTS}
    exporting = {
        module_of(path) for path in FILES if path.name == "__init__.py" and "__all__" in path.read_text()
    }
    assert exporting == EXPORTS.keys()
    for name, package in packages.items():
        assert package.__all__ == EXPORTS[name].split(), name
        assert all(hasattr(package, each) for each in package.__all__)
