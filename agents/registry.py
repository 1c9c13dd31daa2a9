"""Agents by name: a built-in agent, a trained one from its file, or a class of the user.

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
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple, cast

import numpy as np

from agents.errors import AgentError, reason_of
from agents.fleet.charging import costs_around_chargers
from agents.fleet.guided import Guided, on_directed, on_lanes, on_learned
from agents.fleet.planned import DEFAULT_ASSIGNMENT, PlannedFleet
from agents.fleet.team import Team
from agents.kinds.goal_based import GoalBasedAgent
from agents.kinds.model_based import ModelBasedAgent
from agents.kinds.simple_reflex import ReflexAgent
from agents.kinds.utility_based import UtilityBasedAgent
from agents.learning.baselines import RandomAgent
from agents.learning.clone_agent import CloneAgent
from agents.learning.ppo_agent import PPOAgent
from agents.learning.q_table import load_agent
from agents.mapf.assignment import ASSIGNMENTS
from agents.mapf.circulation import Circulation
from agents.mapf.graph import Graph
from agents.mapf.pibt import PIBT
from agents.mapf.planner import Planner
from agents.mapf.problem import Solver
from agents.mapf.windows import WindowedPlanner
from agents.search.agents import ALGORITHMS, ExploringAgent, SearchAgent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import DEFAULT_LAYOUT, Agent, Layout, Motion, RecordError
from warehouse_core.files.reading import not_a_file
from warehouse_core.motion.backends import Backend, backend_names
from warehouse_core.records.recorder import FleetAgent

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
"""Agents of a lone robot, by name."""

PLANNERS: dict[str, Callable[..., Planner]] = {
    "pibt": PIBT,
    "pibt-lanes": Guided(PIBT, on_lanes),
    "pibt-learned": Guided(PIBT, on_learned),
    "windowed": WindowedPlanner,
    "windowed-lanes": Guided(WindowedPlanner, on_lanes),
    "windowed-learned": Guided(WindowedPlanner, on_learned),
    "windowed-directed": Guided(WindowedPlanner, on_directed),
    "circulation": Circulation,
    "circulation-lanes": Guided(Circulation, on_lanes),
    "circulation-directed": Guided(Circulation, on_directed),
}
"""Planners of the robots of a fleet, by name."""

TRAINED: dict[str, Callable[..., Agent]] = {
    "clone": CloneAgent.load,
    "ppo": PPOAgent.load,
    "q": load_agent,
}
"""Functions that load an agent of ``warehouse train``, by the word before the colon."""

FIXED = ("seed", "layout", "graph", "algorithm")
"""Arguments that a name does not give: parts of the episode, and what the name itself says."""


class Sort(NamedTuple):
    """What is made by name: agents or planners.

    What is loaded from files is in ``trained``. A class of a user must have all methods of one set
    in ``methods``.
    """

    word: str
    known: Mapping[str, Callable[..., Any]]
    trained: Mapping[str, Callable[..., Any]]
    methods: Sequence[tuple[str, ...]]


AGENT = Sort("agent", AGENTS, TRAINED, [("reset", "act")])
PLANNER = Sort("planner", PLANNERS, {}, [("reset", "next_cells"), ("reset", "act")])
BACKEND = Sort("backend", {}, {}, [("reset", "advance", "close")])


def make_agent(name: str, seed: int | None = None, layout: Layout = DEFAULT_LAYOUT) -> Agent:
    """Return an agent by name.

    Args:
        name: one of ``AGENTS``, or ``file.py:Class`` or ``package.module:Class``, or ``file.py``
            with one such class, or one of ``TRAINED``, a colon and a file. Arguments may follow, as
            in ``greedy:memory=20,escape_steps=0`` or ``ppo:model.npz:revisit=4``.
        seed: passed to the agent if it takes a ``seed``. The global streams of Python and NumPy are
            seeded with it too, if the agent is a user's class, which may draw from them.
        layout: passed to the agent if it takes a ``layout``.

    Raises:
        AgentError: there is no such agent, or it does not take the arguments; the message says why.

    Example:
        >>> from agents.registry import make_agent
        >>> make_agent("greedy:memory=20", seed=1).memory
        20
    """
    return cast(Agent, _make(AGENT, name, [seed], layout)[0])


def make_team(
    name: str, robots: int, seed: int | None = None, layout: Layout = DEFAULT_LAYOUT
) -> Team:
    """Return an agent by name for each robot of a fleet, each with a seed of its own.

    The agents get the walls of the layout; they observe which stations are theirs. Names and errors
    are those that ``make_agent`` has.

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
    name: str, seed: int | None = None, layout: Layout = DEFAULT_LAYOUT, robots: int | None = None
) -> Planner | FleetAgent:
    """Return a planner of the robots of a fleet, or an agent that directs them, by name.

    Names are as for ``make_agent``, but with ``PLANNERS`` and without trained ones. A class of a
    user that has ``next_cells`` is a ``Planner``, one that has ``act`` a ``FleetAgent``. Besides
    seed and layout it gets ``robots`` if it takes them and the name does not give them, and if it
    takes a ``graph`` the graph of the layout, where ways lead around chargers.

    Raises:
        AgentError: as ``make_agent``.

    Example:
        >>> from agents.registry import make_planner
        >>> make_planner("windowed:window=20", seed=1).window
        20
    """
    [planner] = _make(PLANNER, name, [seed], layout, robots)
    return cast("Planner | FleetAgent", planner)


def make_solver(name: str, known: Mapping[str, Solver], seed: int = 0) -> Solver | None:
    """Return a solver of whole problems by name, or ``None`` if the name is of something else.

    Args:
        name: one of ``known``, or ``file.py:function`` or ``package.module:function``. Arguments
            behind the problem and the seconds may follow, as in ``ecbs:w=1.2``.
        known: solvers by name.
        seed: passed to the solver if it takes a ``seed``.

    Raises:
        AgentError: its file or module cannot be imported, or it does not take the arguments.

    Example:
        >>> from agents.mapf.eecbs import solve_eecbs
        >>> from agents.registry import make_solver
        >>> solve = make_solver("ecbs:w=1.1", {"ecbs": solve_eecbs})
    """
    source, options = _split(name)
    solve = known.get(source) or _load_function(source)
    if solve is None:
        return None
    try:
        rest = partial(solve, None, 0.0)  # type: ignore[arg-type]
        takes_seed = "seed" in inspect.signature(rest).parameters
    except ValueError:
        raise AgentError(
            f"function {source!r} takes no problem and seconds; needed: these two arguments"
        ) from None
    given = {"seed": seed} if takes_seed else {}
    return partial(solve, **given, **_options(f"planner {source!r}", rest, options))


def make_backend(name: str) -> Backend:
    """Return a backend by name, for an environment.

    Only commands call it, with what their user has typed: the name in a record runs no code.

    Args:
        name: name of an installed backend, which stays as it is, or a class of a user as
            ``make_agent`` takes it, which is made. Arguments may follow.

    Raises:
        AgentError: there is no such class, it cannot be made, or it is no motion.

    Example:
        >>> from agents.registry import make_backend
        >>> make_backend("physics:top_speed=2")
        'physics:top_speed=2'
    """
    source, _ = _split(name)
    if _split_class(source)[0] is None or source.partition(":")[0] in backend_names():
        return name
    [motion] = _make(BACKEND, name, [None], DEFAULT_LAYOUT)
    if not isinstance(motion, Motion):
        raise AgentError(f"class {source!r} has no cell_size; needed: side of a cell in metres")
    return motion


def make_fleet_agent(
    planner: str,
    assignment: str | None = None,
    seed: int | None = None,
    layout: Layout = DEFAULT_LAYOUT,
    robots: int | None = None,
    **options: Any,
) -> FleetAgent:
    """Return an agent that directs all robots of a fleet, by the names of its parts.

    ``make_planner`` makes the planner, for which ``PlannedFleet`` takes the options. An agent that
    directs all robots assigns orders itself; for others ``None`` is ``DEFAULT_ASSIGNMENT``.

    Raises:
        AgentError: as ``make_planner``, or an assignment that does not exist or is not used.

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
    made = make_planner(planner, seed, layout, robots)
    if isinstance(made, Planner):
        return PlannedFleet(made, assignment or DEFAULT_ASSIGNMENT, **options)
    if options.get("log"):
        raise AgentError(f"planner {planner!r} has act(), so its plans are not known")
    if assignment is not None:
        raise AgentError(
            f"planner {planner!r} has act(), so it assigns orders itself; leave out "
            f"assignment {assignment!r}"
        )
    return made


def _make(
    sort: Sort, name: str, seeds: Sequence[int | None], layout: Layout, robots: int | None = None
) -> list[Any]:
    """Return one by name for each seed."""
    word, colon, rest = name.partition(":")
    if colon and word in sort.trained:
        return [_load_trained(sort, word, rest, seed, layout) for seed in seeds]
    source, options = _split(name)
    if seeds[0] is not None and source not in sort.known:
        random.seed(seeds[0])
        np.random.seed(seeds[0] % 2**32)
    kind = sort.known.get(source) or _load_class(sort, source)
    given = _options(f"{sort.word} {source!r}", kind, options)
    try:
        return [kind(**(_wanted(kind, seed, layout, robots) | given)) for seed in seeds]
    except (Exception, SystemExit) as error:  # the code of a user may raise anything
        if source in sort.known:
            raise AgentError(f"{sort.word} {name!r}: {error}") from error
        reason = reason_of(error, agent_file(name))
        raise AgentError(f"{sort.word} {name!r} cannot be made: {reason}") from error


def _split(name: str) -> tuple[str, str]:
    """Return the name of an agent without its arguments, and these."""
    source, _, options = name.rpartition(":")
    return (source, options) if "=" in options else (name, "")


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
    return _split(name)[0] not in AGENTS and name.partition(":")[0] not in TRAINED


def agent_file(name: str) -> Path | None:
    """Return the file that an agent is read from, or ``None`` if its name has no file."""
    word, colon, rest = name.partition(":")
    if colon and word in TRAINED:
        return Path(_split_trained(rest)[0])
    source, _ = _split_class(_split(name)[0])
    return Path(source) if source is not None and source.endswith(".py") else None


def agent_module(name: str) -> str | None:
    """Return the module that an agent of a user is imported from, ``None`` for all others."""
    source, _ = _split_class(_split(name)[0])
    if not source or source.endswith(".py") or not is_own_code(name):
        return None
    return source


def _wanted(
    make: Callable[..., Any], seed: int | None, layout: Layout, robots: int | None = None
) -> dict[str, Any]:
    """Return the arguments that ``make`` takes, out of seed, layout, graph and robots."""
    taken = inspect.signature(make).parameters.keys()
    parts: dict[str, Any] = {"seed": seed, "layout": layout}
    if robots is not None:
        parts["robots"] = robots
    if "graph" in taken:
        parts["graph"] = Graph(layout, costs_around_chargers(layout))
    return {name: part for name, part in parts.items() if name in taken}


def _split_trained(rest: str) -> tuple[str, str]:
    """Return the file of a trained agent and its arguments; a file may have ``:`` and ``=``."""
    file, _, options = rest.rpartition(":")
    return (file, options) if re.match(r"[a-z_]+=", options) else (rest, "")


def _load_trained(sort: Sort, word: str, rest: str, seed: int | None, layout: Layout) -> Any:
    file, options = _split_trained(rest)
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


def _load_class(sort: Sort, name: str) -> type[Any]:
    source, class_name = _split_class(name)
    if source is None:
        raise AgentError(
            f"no {sort.word} is called {name!r}; allowed: "
            f"{', '.join([*sort.known, *(f'{word}:FILE' for word in sort.trained)])}, or your "
            "own as file.py, file.py:Class or module:Class"
        )
    module = _load_module(source)
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


def _load_function(name: str) -> Callable[..., Any] | None:
    """Return the function of a user that a name stands for; ``None`` if it is none."""
    source, function = _split_class(name)
    if source is None or function is None:
        return None
    found = getattr(_load_module(source), function, None)
    return found if inspect.isfunction(found) else None


def _split_class(name: str) -> tuple[str | None, str | None]:
    """Return the file or module of a class and its name, ``None`` for what is not given."""
    if name.endswith(".py"):
        return name, None
    source, colon, class_name = name.rpartition(":")
    return (source, class_name) if colon else (None, class_name)


def _missing(sort: Sort, kind: type[Any]) -> list[list[str]]:
    """Return the methods that a class does not have of each set."""
    return [
        [each for each in names if not callable(getattr(kind, each, None))]
        for names in sort.methods
    ]


def _only_class(sort: Sort, source: str, module: ModuleType) -> type[Any]:
    """Return the only class that a module defines with the methods that are needed."""
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


def _load_module(source: str) -> ModuleType:
    if not source.endswith(".py"):
        if not all(part.isidentifier() for part in source.split(".")):
            raise AgentError(f"{source!r} is neither a .py file nor the name of a module")
        try:
            return importlib.import_module(source)
        except ImportError as error:
            raise AgentError(
                f"cannot import agent module {source!r}: {error}{_hint(Path.cwd())}"
            ) from error
        except (Exception, SystemExit) as error:  # too many parts, or the code of a user
            raise AgentError(
                f"cannot import agent module {source!r}: {reason_of(error)}"
            ) from error
    path = Path(source)
    if not path.is_file():
        raise AgentError(f"agent file {source}: {not_a_file(path) or 'there is no such file'}")
    # The name must differ from those of modules that can be imported.
    spec = importlib.util.spec_from_file_location(f"agent file {path.stem}", path)
    assert spec is not None, "a .py file always has a spec"
    assert spec.loader is not None, "a .py file always has a loader"
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look it up there
    folder = path.resolve().parent
    try:
        with _modules_of(folder):
            spec.loader.exec_module(module)
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

    What was imported from there is forgotten afterwards: it is read each time, as the agent is, and
    another folder may have modules of the same names. For imports in functions the folder stays the
    last that is searched.
    """
    before = sys.modules.copy()
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        sys.path[:] = [each for each in sys.path if each != str(folder)] + [str(folder)]
        for name in sys.modules.keys() - before.keys():
            file = getattr(sys.modules[name], "__file__", None)
            if file and Path(file).is_relative_to(folder) and not name.startswith("agent file "):
                del sys.modules[name]


def _hint(folder: Path) -> str:
    """Return what to do if a folder has a module with the name of this package."""
    own = [name for name in ("agents.py", "agents") if (folder / name).exists()]
    if not own or Path(__file__).parent == folder / "agents":
        return ""
    return (
        f"; 'agents' is the package of this program, so {folder / own[0]} cannot be imported: "
        "give it another name"
    )
