"""Agents and planners by name: built-in ones, trained ones from files, and users' classes.

Example:
    >>> from agents.registry import AGENTS, PLANNERS
    >>> "greedy" in AGENTS, "pibt" in PLANNERS
    (True, True)
"""

from __future__ import annotations

import ast
import importlib
import importlib.util
import inspect
import random
import sys
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple, cast

import numpy as np

from agents.code_names import CodeName, split_name
from agents.errors import AgentError, reason_of
from agents.fleet.charging import costs_around_chargers
from agents.fleet.guided import NAMED, auto
from agents.fleet.planned import DEFAULT_ASSIGNMENT, PlannedFleet
from agents.fleet.team import Team
from agents.kinds.goal_based import GoalBasedAgent
from agents.kinds.model_based import ModelBasedAgent
from agents.kinds.simple_reflex import ReflexAgent
from agents.kinds.utility_based import UtilityBasedAgent
from agents.learning.baselines import RandomAgent
from agents.learning.clone_agent import CloneAgent
from agents.learning.drive_policy import DrivePolicy
from agents.learning.ppo_agent import PPOAgent
from agents.learning.q_table import load_agent
from agents.mapf.assignment import ASSIGNMENTS
from agents.mapf.graph import Graph
from agents.mapf.planner import Planner
from agents.mapf.problem import Solver
from agents.search.agents import ALGORITHMS, ExploringAgent, SearchAgent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import (
    DEFAULT_LAYOUT,
    Agent,
    Episode,
    Layout,
    Motion,
    RecordError,
    replay_episode,
)
from warehouse_core.files.reading import not_a_file
from warehouse_core.motion.backends import Backend, backend_names, make_motion
from warehouse_core.motion.base import with_defaults
from warehouse_core.records.episode import DRIVE, is_drive
from warehouse_core.records.recorder import FleetAgent
from warehouse_core.world.moves import COMPASS

__all__ = [
    "AGENTS",
    "PLANNERS",
    "make_agent",
    "make_backend",
    "make_fleet_agent",
    "make_planner",
    "make_solver",
    "make_team",
]

AGENTS: dict[str, Callable[..., Agent]] = {
    "random": RandomAgent,
    "reflex": ReflexAgent,
    "model": ModelBasedAgent,
    "goal": GoalBasedAgent,
    "utility": UtilityBasedAgent,
    "greedy": GreedyAgent,
    "exploring": ExploringAgent,
    **{name: partial(SearchAgent, algorithm=name) for name in ALGORITHMS},
}
"""Agents for one robot, by name."""

PLANNERS: dict[str, Callable[..., Planner]] = {"auto": auto, **NAMED}
"""Planners for the robots of a fleet, by name."""

TRAINED: dict[str, Callable[..., Agent]] = {
    "clone": CloneAgent.load,
    DRIVE: DrivePolicy.load,
    "ppo": PPOAgent.load,
    "q": load_agent,
}
"""Functions that load an agent trained by ``warehouse train``, by the word before the colon."""

FIXED = ("seed", "layout", "graph", "robots", "moves", "algorithm")
"""Arguments that cannot follow a name, because the episode or the name itself determines them."""


class Sort(NamedTuple):
    """A sort of objects that are made by name: agents, planners or backends.

    Attributes:
        word: name of the sort in messages.
        known: built-in classes and functions, by name.
        trained: functions that load an object from a file, by the word before the colon.
        methods: sets of methods; a user's class must have all methods of one set.
    """

    word: str
    known: Mapping[str, Callable[..., Any]]
    trained: Mapping[str, Callable[..., Any]]
    methods: Sequence[tuple[str, ...]]


AGENT = Sort("agent", AGENTS, TRAINED, [("reset", "act")])
PLANNER = Sort("planner", PLANNERS, {}, [("reset", "next_cells"), ("reset", "act")])
BACKEND = Sort("backend", {}, {}, [("reset", "advance", "close")])


def make_agent(name: str, seed: int | None = None, layout: Layout = DEFAULT_LAYOUT) -> Agent:
    """Return the agent with a name.

    Args:
        name: one of ``AGENTS``; ``file.py:Class``, ``package.module:Class``, or ``file.py`` with
            exactly one agent; or one of ``TRAINED``, a colon and a file. Arguments may follow, as
            in ``greedy:memory=20,escape_steps=0`` or ``ppo:model.npz:revisit=4``.
        seed: passed to the agent if it takes a ``seed``. For a user's class, the global random
            generators of Python and NumPy are seeded too, because the class may use them.
        layout: passed to the agent if it takes a ``layout``.

    Raises:
        AgentError: there is no such agent, or it does not take the arguments.

    Example:
        >>> from agents.registry import make_agent
        >>> make_agent("greedy:memory=20", seed=1).memory
        20
    """
    return cast(Agent, _make(AGENT, name, [seed], layout)[0])


def make_team(
    name: str, robots: int, seed: int | None = None, layout: Layout = DEFAULT_LAYOUT
) -> Team:
    """Return a team with one agent for each robot of a fleet, each with a seed of its own.

    The agents get the layout without stations, because they observe the stations of their orders.
    Names and errors are the same as for ``make_agent``.

    Example:
        >>> from agents.registry import make_team
        >>> from warehouse_core import FleetEnv, record_episode, shelf_layout
        >>> env = FleetEnv(shelf_layout(aisle=2), 4, orders=0.1, max_steps=50, seed=1)
        >>> shift = record_episode(env, make_team("greedy", 4, 1, env.layout), seed=1)
    """
    seeds = [seed] * robots
    if seed is not None and robots > 1:
        seeds = np.random.SeedSequence(seed).generate_state(robots).tolist()
    return Team(_make(AGENT, name, seeds, layout.with_tiles((), (), ())), seed)


def make_planner(
    name: str,
    seed: int | None = None,
    layout: Layout = DEFAULT_LAYOUT,
    robots: int | None = None,
    moves: str = COMPASS,
) -> Planner | FleetAgent:
    """Return the planner with a name, or a user's agent that controls all robots of a fleet.

    Names have the same form as for ``make_agent``, with ``PLANNERS`` in place of ``AGENTS`` and
    without trained planners. A user's class with ``next_cells`` is a ``Planner``, and one with
    ``act`` is a ``FleetAgent``. It may take ``seed``, ``layout``, ``robots`` and ``moves``, and a
    ``graph`` of the layout, in which paths avoid chargers.

    Raises:
        AgentError: see ``make_agent``.

    Example:
        >>> from agents.registry import make_planner
        >>> make_planner("windowed:window=20", seed=1).window
        20
    """
    [planner] = _make(PLANNER, name, [seed], layout, robots, moves)
    return cast("Planner | FleetAgent", planner)


def make_solver(name: str, known: Mapping[str, Solver], seed: int = 0) -> Solver | None:
    """Return the solver of whole problems with a name, or ``None`` if there is no such solver.

    Args:
        name: one of ``known``, or ``file.py:function`` or ``package.module:function``. Arguments
            may follow the name, as in ``ecbs:w=1.2``.
        known: solvers by name.
        seed: passed to the solver if it takes a ``seed``.

    Raises:
        AgentError: its file or module cannot be imported, or it does not take the arguments.

    Example:
        >>> from agents.mapf.eecbs import solve_eecbs
        >>> from agents.registry import make_solver
        >>> solve = make_solver("ecbs:w=1.1", {"ecbs": solve_eecbs})
    """
    code = split_name(name)
    what = _without_options(code)
    solve = known.get(what) or _load_function(code)
    if solve is None:
        return None
    try:
        rest = partial(solve, None, 0.0)  # type: ignore[arg-type]
        takes_seed = "seed" in inspect.signature(rest).parameters
    except ValueError:
        raise AgentError(
            f"function {what!r} cannot be called with two arguments; needed: problem and seconds"
        ) from None
    given = {"seed": seed} if takes_seed else {}
    return partial(solve, **given, **_options(f"planner {what!r}", rest, code.options))


def make_backend(name: str) -> Backend:
    """Return the backend with a name, as environments take it.

    Only commands call this function, with a name that their user typed. The names in records never
    run code.

    Args:
        name: name of an installed backend, which is returned unchanged, or a user's class as in
            ``make_agent``, which is instantiated. Arguments may follow.

    Raises:
        AgentError: there is no such class, it cannot be instantiated, or it is not a ``Motion``.

    Example:
        >>> from agents.registry import make_backend
        >>> make_backend("physics:top_speed=2")
        'physics:top_speed=2'
    """
    code = split_name(name)
    if code.file is None and (code.module is None or code.source in backend_names()):
        return name
    [motion] = _make(BACKEND, name, [None], DEFAULT_LAYOUT)
    if not isinstance(motion, Motion):
        raise AgentError(
            f"class {_without_options(code)!r} has no cell_size; needed: side of a cell in metres"
        )
    return motion


def on_backend(backend: str, act: Callable[[str], Episode]) -> Episode:
    """Return the record of an agent on a backend.

    Bodies that drive through need a whole path. For them the agent acts on the grid, and then they
    drive its path. Continuous control has no motion, but an environment of its own.

    Args:
        backend: name of a motion backend, see ``make_backend``.
        act: function that lets the agent act on a backend with a name, and returns the record.
    """
    if is_drive(backend):
        return act(backend)
    made = make_backend(backend)
    if with_defaults(make_motion(made)).drives_through:
        return replay_episode(act("grid"), made)
    return act(backend)


def make_fleet_agent(
    planner: str,
    assignment: str | None = None,
    seed: int | None = None,
    layout: Layout = DEFAULT_LAYOUT,
    robots: int | None = None,
    moves: str = COMPASS,
    **options: Any,
) -> FleetAgent:
    """Return an agent that controls all robots of a fleet, from the names of its parts.

    Args:
        planner: name for ``make_planner``.
        assignment: one of ``ASSIGNMENTS``; ``None`` is ``DEFAULT_ASSIGNMENT``. A user's class with
            ``act`` assigns orders itself and must be given ``None``.
        seed: see ``make_planner``.
        layout: see ``make_planner``.
        robots: see ``make_planner``.
        moves: name of the moves of the robots, which decides what ``auto`` chooses.
        options: further arguments of ``PlannedFleet``.

    Raises:
        AgentError: see ``make_planner``; or the assignment does not exist or cannot be used.

    Example:
        >>> from agents.registry import make_fleet_agent
        >>> from warehouse_core import FleetEnv, record_episode, shelf_layout
        >>> layout = shelf_layout(aisle=2, pickups=4)
        >>> env = FleetEnv(layout, 8, orders=0.2, max_steps=50, dispatch=False, seed=1)
        >>> shift = record_episode(env, make_fleet_agent("pibt", "urgent", 1, layout, 8), seed=1)
    """
    if assignment is not None and assignment not in ASSIGNMENTS:
        raise AgentError(
            f"no assignment is called {assignment!r}; allowed: {', '.join(ASSIGNMENTS)}"
        )
    made = make_planner(planner, seed, layout, robots, moves)
    if isinstance(made, Planner):
        return PlannedFleet(made, assignment or DEFAULT_ASSIGNMENT, **options)
    if options.get("log"):
        raise AgentError(f"planner {planner!r} has act(), so it has no plans to show")
    if assignment is not None:
        raise AgentError(
            f"planner {planner!r} has act(), so it assigns orders itself; leave out "
            f"assignment {assignment!r}"
        )
    return made


def _make(
    sort: Sort,
    name: str,
    seeds: Sequence[int | None],
    layout: Layout,
    robots: int | None = None,
    moves: str = COMPASS,
) -> list[Any]:
    """Return an object with a name for each seed."""
    word, colon, rest = name.partition(":")
    if colon and word in sort.trained:
        return [_load_trained(sort, word, rest, seed, layout) for seed in seeds]
    code = split_name(name)
    what = _without_options(code)
    if seeds[0] is not None and what not in sort.known:
        random.seed(seeds[0])
        np.random.seed(seeds[0] % 2**32)
    kind = sort.known.get(what) or _load_class(sort, code)
    given = _options(f"{sort.word} {what!r}", kind, code.options)
    try:
        wanted = (_wanted(kind, seed, layout, robots) for seed in seeds)
        if "moves" in inspect.signature(kind).parameters:
            given["moves"] = moves
        return [kind(**(each | given)) for each in wanted]
    except (Exception, SystemExit) as error:  # a user's code may raise anything
        if what in sort.known:
            raise AgentError(f"{sort.word} {name!r}: {error}") from error
        reason = reason_of(error, agent_file(name))
        raise AgentError(f"{sort.word} {name!r} cannot be made: {reason}") from error


def _without_options(code: CodeName) -> str:
    return code.source if code.kind is None else f"{code.source}:{code.kind}"


def _options(what: str, kind: Callable[..., Any], text: str) -> dict[str, Any]:
    """Return the arguments in a text such as ``memory=20,escape_steps=0``."""
    if not text:
        return {}
    allowed = [each for each in inspect.signature(kind).parameters if each not in FIXED]
    given = {}
    for part in text.split(","):
        key, equals, value = part.partition("=")
        if not equals or key not in allowed:
            raise AgentError(
                f"{what} takes no argument {key!r}; "
                f"allowed: {', '.join(f'{each}=VALUE' for each in allowed) or 'none'}"
            )
        try:
            given[key] = ast.literal_eval(value)
        except (ValueError, SyntaxError, RecursionError, MemoryError):  # too deep for the parser
            given[key] = value
    return given


def is_own_code(name: str) -> bool:
    """Return whether a name stands for a user's class, whose code ``make_agent`` would run."""
    is_trained = name.partition(":")[0] in TRAINED
    return not is_trained and _without_options(split_name(name)) not in AGENTS


def agent_file(name: str) -> Path | None:
    """Return the file in the name of an agent, or ``None`` if it has none."""
    word, colon, rest = name.partition(":")
    if colon and word in TRAINED:
        return Path(split_name(rest, [""]).source)
    return split_name(name).file


def agent_module(name: str) -> str | None:
    """Return the module from which a user's agent is imported, or ``None`` for other agents."""
    return (split_name(name).module or None) if is_own_code(name) else None


def _wanted(
    make: Callable[..., Any], seed: int | None, layout: Layout, robots: int | None = None
) -> dict[str, Any]:
    """Return the arguments for ``make``: seed, layout, graph and robots, if it takes them."""
    taken = inspect.signature(make).parameters.keys()
    parts: dict[str, Any] = {"seed": seed, "layout": layout}
    if robots is not None:
        parts["robots"] = robots
    if "graph" in taken:
        parts["graph"] = Graph(layout, costs_around_chargers(layout))
    return {name: part for name, part in parts.items() if name in taken}


def _load_trained(sort: Sort, word: str, rest: str, seed: int | None, layout: Layout) -> Any:
    file, _, options = split_name(rest, [""])
    load = partial(sort.trained[word], Path(file))
    what = f"{sort.word} {f'{word}:{file}'!r}"
    if not file or "\0" in file:
        raise AgentError(f"{what} names no file; allowed: {word}:FILE")
    try:
        if (kind := not_a_file(Path(file))) is not None:
            raise AgentError(f"{sort.word} file {file}: {kind}")
        given = _options(what, load, options)
        return load(**_wanted(load, seed, layout), **given)
    except OSError as error:
        raise AgentError(f"{sort.word} file {file}: {error.strerror or error}") from error
    except RecordError as error:
        raise AgentError(
            f"{error}; {sort.word} {word} needs what 'warehouse train {word}' saves"
        ) from error


def _load_class(sort: Sort, code: CodeName) -> type[Any]:
    name, source, class_name = _without_options(code), code.source, code.kind
    if code.file is None and class_name is None:
        raise AgentError(
            f"no {sort.word} is called {name!r}; allowed: "
            f"{', '.join([*sort.known, *(f'{word}:FILE' for word in sort.trained)])}, or your "
            "own as file.py, file.py:Class or module:Class"
        )
    module = _load_module(code)
    if class_name is None:
        return _only_class(sort, source, module)
    kind: Any = getattr(module, class_name, None)
    if not isinstance(kind, type):
        raise AgentError(f"{source} has no class {class_name!r}")
    missing = _missing(sort, kind)
    if all(missing):
        needed = ", or ".join(" and ".join(names) for names in sort.methods)
        fewest = min(missing, key=lambda names: len(names))
        raise AgentError(f"class {name!r} has no {' and no '.join(fewest)}; needed: {needed}")
    return kind


def _load_function(code: CodeName) -> Callable[..., Any] | None:
    """Return the user's function with a name, or ``None`` if there is no such function."""
    found = None if code.kind is None else getattr(_load_module(code), code.kind, None)
    return found if inspect.isfunction(found) else None


def _missing(sort: Sort, kind: type[Any]) -> list[list[str]]:
    """Return, for each set of methods, the methods that a class lacks."""
    return [
        [each for each in names if not callable(getattr(kind, each, None))]
        for names in sort.methods
    ]


def _only_class(sort: Sort, source: str, module: ModuleType) -> type[Any]:
    """Return the only class in a module that has the needed methods."""
    own = [
        each
        for each in vars(module).values()
        if isinstance(each, type) and each.__module__ == module.__name__
    ]
    found = [each for each in own if not all(_missing(sort, each))]
    if len(found) != 1:
        needed = ", or ".join(" and ".join(names) for names in sort.methods)
        names = ", ".join(each.__name__ for each in found) or "none"
        raise AgentError(
            f"{source} has {len(found)} classes with {needed} ({names}); name one as file.py:Class"
        )
    return found[0]


def _load_module(code: CodeName) -> ModuleType:
    source, path = code.source, code.file
    if path is None:
        if not all(part.isidentifier() for part in source.split(".")):
            raise AgentError(f"{source!r} is neither a .py file nor the name of a module")
        try:
            return importlib.import_module(source)
        except ImportError as error:
            raise AgentError(
                f"cannot import agent module {source!r}: {error}{_hint(Path.cwd())}"
            ) from error
        except (Exception, SystemExit) as error:  # too many parts, or an error in a user's code
            raise AgentError(
                f"cannot import agent module {source!r}: {reason_of(error)}"
            ) from error
    if not path.is_file():
        raise AgentError(f"agent file {source}: {not_a_file(path) or 'there is no such file'}")
    # No module that can be imported has this name, because of its spaces.
    loader = SourceFileLoader(f"agent file {path.stem}", str(path))
    spec = importlib.util.spec_from_file_location(loader.name, path, loader=loader)
    assert spec is not None, "a file with a loader has a spec"
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look it up there
    folder = path.resolve().parent
    try:
        with _modules_of(folder):
            loader.exec_module(module)
    except SyntaxError as error:
        raise AgentError(f"{error.filename or source}, line {error.lineno}: {error.msg}") from error
    except ImportError as error:
        raise AgentError(f"cannot import agent file {source}: {error}{_hint(folder)}") from error
    except (Exception, SystemExit) as error:
        reason = reason_of(error, path)
        raise AgentError(f"cannot import agent file {source}: {reason}") from error
    return module


@contextmanager
def _modules_of(folder: Path) -> Iterator[None]:
    """Allow imports from a folder, as Python does for a script in it.

    Modules imported from the folder are forgotten afterwards, so that they are read again next
    time, as the agent is. Another folder may also have modules of the same names. The folder
    remains the last one that is searched, because functions may import modules later.

    No compiled files are written: Python would take one for a file of the same size that is written
    within the same second, as programs may do.
    """
    before, writes_none = {*sys.modules}, sys.dont_write_bytecode
    sys.path.insert(0, str(folder))
    sys.dont_write_bytecode = True
    try:
        yield
    finally:
        sys.dont_write_bytecode = writes_none
        sys.path[:] = [each for each in sys.path if each != str(folder)] + [str(folder)]
        forget_modules(before, [folder])


def forget_modules(before: Collection[str], folders: Collection[Path]) -> None:
    """Forget the modules from some folders that were imported after those with names ``before``.

    Modules that are agents stay, because dataclasses look them up.
    """
    for name in sys.modules.keys() - before:
        file = getattr(sys.modules[name], "__file__", None) or ""
        is_own = any(Path(file).is_relative_to(folder) for folder in folders)
        if is_own and not name.startswith("agent file "):
            del sys.modules[name]


def _hint(folder: Path) -> str:
    """Return advice if a module in a folder has the name of this package, or ""."""
    own = [name for name in ("agents.py", "agents") if (folder / name).exists()]
    if not own or Path(__file__).parent == folder / "agents":
        return ""
    return (
        f"; 'agents' is the package of this program, so {folder / own[0]} cannot be imported: "
        "give it another name"
    )
