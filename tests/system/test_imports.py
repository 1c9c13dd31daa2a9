"""Imports between modules, libraries that the core does not load, and exported names."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
PACKAGES = ("warehouse_core", "warehouse_physics", "agents")
"""Packages. Each may import only packages before it."""

MAY_IMPORT = {
    "warehouse_core/compiled": "",
    "warehouse_core/copies": "",
    "warehouse_core/errors": "",
    "warehouse_core/extras": "",
    "warehouse_core/listing": "copies",
    "warehouse_core/neighbours": "",
    "warehouse_core/registration": "",
    "warehouse_core/wording": "",
    "warehouse_core/arguments": "wording",
    "warehouse_core/files": "errors wording",
    "warehouse_core/world": "arguments errors files wording",
    "warehouse_core/motion": "arguments compiled errors extras wording world",
    "warehouse_core/orders": "arguments errors files wording world",
    "warehouse_core/task": "arguments errors wording world",
    "warehouse_core/batch": "arguments compiled errors listing motion orders task wording world",
    "warehouse_core/conformance": "errors motion world",
    "warehouse_core/render": "arguments errors task world",
    "warehouse_core/warehouse_env": "arguments copies errors listing motion task wording world",
    "warehouse_core/fleet": ("arguments batch errors listing motion orders task wording world"),
    "warehouse_core/gymnasium_env": (
        "arguments batch errors listing motion registration render task warehouse_env wording world"
    ),
    "warehouse_core/records": (
        "arguments batch errors extras files fleet motion orders task warehouse_env wording world"
    ),
    "warehouse_core/pettingzoo_env": (
        "arguments errors extras fleet gymnasium_env listing render task wording world"
    ),
    "warehouse_core/viz/axes": "records render world",
    "warehouse_core/viz/tracks": "arguments errors motion records render wording world",
    "warehouse_core/viz/player": "arguments files render viz/tracks wording world",
    "warehouse_core/viz/svg": "arguments errors records render viz/tracks wording world",
    "warehouse_core/viz": (
        "arguments errors extras files fleet records render viz/axes viz/player viz/svg "
        "viz/tracks warehouse_env wording world"
    ),
    "warehouse_core/warehouse_viz": (
        "arguments errors files records render viz viz/player viz/tracks warehouse_env"
    ),
    "warehouse_physics/disturbances": "",
    "warehouse_physics/exclusive": "",
    "warehouse_physics/phases": "",
    "warehouse_physics/profile": "",
    "warehouse_physics/pymunk_version": "",
    "warehouse_physics/stepping": "",
    "warehouse_physics/walls": "",
    "warehouse_physics/spec": "profile",
    "warehouse_physics/arena": "profile spec stepping walls",
    "warehouse_physics/energy": "profile spec",
    "warehouse_physics/driven_arena": "arena profile spec",
    "warehouse_physics/odometry": "arena profile",
    "warehouse_physics/robot": "arena disturbances energy phases profile spec stepping",
    "warehouse_physics/batch": (
        "arena driven_arena energy exclusive phases profile robot spec walls"
    ),
    "warehouse_physics/body_motion": "disturbances energy odometry profile spec",
    "warehouse_physics/giving_way": "phases robot",
    "warehouse_physics/wheeled_robot": "arena energy phases profile robot spec",
    "warehouse_physics/driving": (
        "arena body_motion disturbances driven_arena energy exclusive profile spec walls "
        "wheeled_robot"
    ),
    "warehouse_physics/drive": ("arena batch disturbances energy odometry profile spec walls"),
    "warehouse_physics/robot_arena": "arena disturbances robot spec walls wheeled_robot",
    "warehouse_physics/rigid_body_motion": (
        "batch body_motion disturbances energy exclusive giving_way phases robot robot_arena spec"
    ),
    "agents/errors": "",
    "agents/handbook/exercises": "",
    "agents/handbook/exercises/solutions": "",
    "agents/mapf/kernels": "",
    "agents/warehouse_agent_greedy": "",
    "agents/search": "warehouse_agent_greedy",
    "agents/kinds": "search warehouse_agent_greedy",
    "agents/mapf": "errors mapf/kernels",
    "agents/fleet": "errors mapf mapf/kernels",
    "agents/learning": "errors warehouse_agent_greedy",
    "agents/drive": "",
    "agents/lab": "errors fleet mapf",
    "agents/code_names": "",
    "agents/registry": "code_names errors fleet kinds learning mapf search warehouse_agent_greedy",
    "agents/lab/runs": "drive errors fleet learning",
    "agents/lab/console": "code_names errors lab lab/runs registry",
    "agents/lab/trials": "errors lab lab/console lab/runs learning registry",
    "agents/lab/commands/fleet": "errors fleet lab lab/console lab/runs lab/trials registry",
    "agents/lab/commands/planners": (
        "code_names errors fleet lab lab/console lab/trials mapf mapf/kernels registry"
    ),
    "agents/lab/experiments": "errors fleet lab lab/console lab/runs lab/trials registry",
    "agents/lab/grading": (
        "code_names errors lab lab/runs lab/trials registry warehouse_agent_greedy"
    ),
    "agents/lab/training": "lab/console lab/trials learning",
    "agents/lab/datasets": "errors lab/experiments lab/trials registry",
    "agents/lab/reports": "errors lab lab/console lab/experiments lab/trials registry",
    "agents/lab/commands/grade": "errors lab/console lab/grading lab/reports lab/trials",
    "agents/lab/playground": "errors lab lab/grading lab/runs registry",
    "agents/lab/commands": (
        "code_names errors fleet lab lab/commands/fleet "
        "lab/commands/grade lab/commands/planners lab/console lab/datasets "
        "lab/experiments lab/playground lab/reports lab/runs lab/training lab/trials learning mapf "
        "registry search warehouse_agent_greedy"
    ),
    "agents/handbook": "lab/commands",
    "agents/__main__": "lab/commands",
    "agents/run_episode": "lab/commands lab/console",
}
"""Modules and folders that each place may import in its own package, all from rows above it."""

HEAVY = (
    "matplotlib", "gymnasium", "pymunk", "rich", "typer", "PIL", "IPython", "scipy", "jinja2",
    "markupsafe",
)  # fmt: skip
PROGRAM = """
import warehouse_core
env = warehouse_core.WarehouseEnv()
env.reset(randomize=True, seed=1)
env.step("E")

from warehouse_core import BatchEnv
batch = BatchEnv(3)
batch.reset(seed=1)
batch.step([1, 2, 3])

import warehouse_core.render.window
from warehouse_core.render.painter import TilePainter, bar
TilePainter(16).picture(warehouse_core.DEFAULT_LAYOUT, (1, 1), True), bar(0.5, 10, 4)

import agents.mapf.guidance, agents.mapf.lacam

from agents import *
import agents.registry, agents.fleet, agents.mapf, agents.search, agents.learning
GreedyAgent().act(__import__("warehouse_core").WarehouseEnv().observe())
"""
"""A program that loads none of the heavy libraries."""

FILES = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(path): path for path in FILES}


@cache
def nodes_of(path: Path) -> list[ast.AST]:
    """Return the definitions and imports of a file, inside functions too."""
    kinds = (ast.Import, ast.ImportFrom, ast.ClassDef, ast.FunctionDef)
    statements: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    for node in statements:
        for block in ("body", "orelse", "handlers", "finalbody", "cases"):
            inner = getattr(node, block, [])
            statements += inner if isinstance(inner, list) else []
    return [node for node in statements if isinstance(node, kinds)]


def imported_by(path: Path) -> Iterator[str]:
    """Yield the modules that a file imports, inside functions and for types too."""
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.module is not None, f"{path}: relative import"
            assert node.level == 0, f"{path}: relative import"
            for alias in node.names:
                submodule = f"{node.module}.{alias.name}"
                yield submodule if submodule in MODULES else node.module


def place_of(module: str) -> str:
    """Return the folder of a module, or the module itself at the top of its package."""
    folder = MODULES[module].parent.relative_to(ROOT)
    return module.replace(".", "/") if len(folder.parts) == 1 else folder.as_posix()


@cache
def edges() -> list[tuple[str, str]]:
    """Return each import between two modules of the packages."""
    return [
        (module, name)
        for module, path in MODULES.items()
        for name in imported_by(path)
        if name in MODULES
    ]


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


def definitions(kind: type[ast.AST]) -> Iterator[tuple[str, Any]]:
    """Yield the module and the node of each class or function, exercises aside."""
    for module, path in MODULES.items():
        if "exercises" not in path.parts:
            for node in nodes_of(path):
                if isinstance(node, kind):
                    yield module, node


def test_each_class_has_a_name_of_its_own() -> None:
    """Two classes may be called ``Problem``, because both fields use the word."""
    places: dict[str, set[str]] = {}
    for module, node in definitions(ast.ClassDef):
        places.setdefault(node.name, set()).add(module)
    several = {name: modules for name, modules in places.items() if len(modules) > 1}
    assert several == {"Problem": {"agents.search.algorithms", "agents.mapf.problem"}}


def test_functions_have_at_most_twelve_parameters() -> None:
    """Values that belong together form a record. Environments and commands have named settings."""
    found = {
        (module, node.name)
        for module, node in definitions(ast.FunctionDef)
        if len([*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs])
        > 12 + (node.name == "__init__")
        and not module.startswith("agents.lab.commands.")
    }
    assert found == {
        ("warehouse_core.fleet.env", "__init__"),
        ("warehouse_core.gymnasium_env.vector", "__init__"),
        ("warehouse_physics.drive.env", "__init__"),
        ("warehouse_physics.drive.vector", "__init__"),
    }


def test_each_row_of_the_table_names_only_earlier_ones() -> None:
    places = list(MAY_IMPORT)
    for number, (place, names) in enumerate(MAY_IMPORT.items()):
        package = place.split("/")[0]
        assert {f"{package}/{name}" for name in names.split()} <= set(places[:number]), place


def test_no_modules_import_each_other_in_a_circle() -> None:
    graph: dict[str, set[str]] = {}
    for importer, imported in edges():
        graph.setdefault(importer, set()).add(imported)
    assert len(list(TopologicalSorter(graph).static_order())) > 100


def test_gymnasium_is_imported_in_two_folders_of_the_core() -> None:
    core = {name: path for name, path in MODULES.items() if name.startswith("warehouse_core")}
    importing = [path for path in core.values() if "gymnasium" in imported_by(path)]
    assert {path.parent.name for path in importing} == {"gymnasium_env", "pettingzoo_env"}


def loaded_by(program: str, libraries: tuple[str, ...]) -> list[str]:
    """Return the libraries that a program loads in a fresh process."""
    look = f"import sys; print(*(name for name in {libraries} if name in sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", f"{program}\n{look}"],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    return done.stdout.splitlines()[-1].split()


def test_environments_pictures_planners_and_agents_load_none_of_the_heavy_libraries() -> None:
    assert loaded_by(PROGRAM, HEAVY) == []


def test_commands_that_only_print_load_their_parser_and_no_other_heavy_library() -> None:
    program = """
import sys
from agents.__main__ import main
for words in ("--help", "layout", "sweep --help", "compare --help"):
    sys.argv[1:] = words.split()
    try:
        main()
    except SystemExit:
        pass
"""
    assert loaded_by(program, HEAVY) == ["typer"]
