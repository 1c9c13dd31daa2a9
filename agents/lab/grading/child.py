"""The process of a graded agent: a script that imports only the standard library.

The script is a fork server. It is started once for each submission. For each episode it forks a
fresh process that loads the agent, so that an episode costs a fork and not a start of Python. The
environment is in the process that asked for the episode. This process only receives observations:
no hidden seeds, no layout and no rubric.

Messages are lines of JSON on two pipes that are not standard input or output. Each question
contains a random word that its answer must repeat, so that other output cannot pass for an answer.
"""

from __future__ import annotations

import builtins
import gc
import importlib
import importlib.util
import inspect
import json
import os
import random
import signal
import socket
import sys
import tempfile
import traceback
from collections.abc import Callable
from contextlib import suppress
from functools import reduce
from importlib.machinery import SourceFileLoader
from operator import getitem
from types import ModuleType
from typing import Any

SUBREAPER, DEATH_SIGNAL = 36, 1
"""Options of Linux's ``prctl``: adopt orphans, and get a signal when the parent ends."""

MAX_TEXT = 200
"""Limit on the characters of an action or of an exception's message that are sent."""

ALLOWED = "graded agents may only compute and read their own files"
"""Reason that is added if the system has refused what an agent tried."""

MAX_KILLS = 100
"""Rounds of killing the processes that an agent left behind, which may start further ones."""

CELLS = ("robot_pos", "pickup_pos", "dropoff_pos")
"""Values of an observation that are tuples and become lists in JSON."""

MAP = ("layout", "graph")
"""Arguments with the map that ``warehouse run`` passes to agents. Graded agents have no map."""


def load_file(name: str, file: str) -> Any:
    """Return the module in a file, loaded under a name that is not an identifier."""
    loader = SourceFileLoader(name, file)  # whatever the suffix is
    spec: Any = importlib.util.spec_from_file_location(name, file, loader=loader)
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def load_sibling(name: str) -> Any:
    """Return a module of this folder, from its file if this one runs as a script."""
    if __package__:
        return importlib.import_module(f"{__package__}.{name}")
    return load_file(f"{name} of an agent", os.path.join(os.path.dirname(__file__), f"{name}.py"))


walls, notebook = map(load_sibling, ("walls", "notebook"))


def serve(control: socket.socket, bounds: dict[str, Any], rules: int | None) -> None:
    """Fork a process for each pair of pipes received, until the other end closes."""
    while True:
        _, pipes, _, _ = socket.recv_fds(control, 1, 2)
        if not pipes:
            return
        pid = os.fork()
        if pid == 0:
            control.close()
            try:
                play(pipes[0], pipes[1], bounds, rules)
            finally:
                os._exit(1)
        for pipe in pipes:
            os.close(pipe)
        control.recv(1)  # the episode or the grader has ended
        control.sendall(f"{end(pid):6d}".encode())


def end(pid: int) -> int:
    """Kill a child and all processes that it started, and return its exit code.

    The code is negative if a signal ended the child.
    """
    for kill in (os.killpg, os.kill):
        with suppress(ProcessLookupError, PermissionError):
            kill(pid, signal.SIGKILL)
    status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    kill_strays(())
    return status


def kill_strays(keep: tuple[int, ...]) -> None:
    """Kill all children of this process except for ``keep``; on Linux this includes orphans."""
    for _ in range(MAX_KILLS):
        if not keep and _has_no_child():
            return
        strays = [pid for pid in children() if pid not in keep]
        if not strays:
            return
        for pid in strays:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
            with suppress(ChildProcessError):
                os.waitpid(pid, 0)


def _has_no_child() -> bool:
    try:
        os.waitpid(-1, os.WNOHANG)
    except ChildProcessError:
        return True
    return False


def children() -> list[int]:
    """Return the children of this process, started or adopted; [] if there is no ``/proc``."""
    found = []
    with suppress(FileNotFoundError):
        for name in os.listdir("/proc"):
            with suppress(OSError, ValueError, IndexError):
                with open(f"/proc/{int(name)}/stat", "rb") as file:
                    parent = int(file.read().rpartition(b")")[2].split()[1])
                if parent == os.getpid():
                    found.append(int(name))
    return found


def control_process(option: int, value: int) -> None:
    """Call Linux's ``prctl``; do nothing on other systems."""
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


def play(questions: int, answers: int, bounds: dict[str, Any], rules: int | None) -> None:
    """Load the agent or function named in the first line, and answer each question.

    An agent answers observations with actions, and a function answers arguments with values.
    """
    lines = os.fdopen(questions, "rb")
    task = json.loads(lines.readline())

    def answer(word: str, **values: object) -> None:
        os.write(answers, json.dumps({"word": word, **values}).encode() + b"\n")

    word = task["word"]
    try:
        limit(bounds, rules)
        if task["allowed"] is not None or task["denied"]:
            guard_imports(task)
        name, reply = begin(task)
        answer(word, name=name)
        for line in lines:
            question = json.loads(line)
            word = question["word"]
            answer(word, **reply(question))
    except BaseException as error:  # an agent may raise anything, even SystemExit
        answer(word, **description_of(error, task.get("file")))


def begin(task: dict[str, Any]) -> tuple[str, Callable[[dict[str, Any]], dict[str, Any]]]:
    """Load the agent or function of a task; return its name and a function for answers."""
    if task["function"] is not None:
        called = find_function(task)
        return task["function"], lambda question: {
            "value": as_value(called(as_tuples(question["arguments"])))
        }
    agent = make_agent(task)
    agent.reset()

    def act(question: dict[str, Any]) -> dict[str, Any]:
        observation = question["observation"]
        for key in CELLS:
            observation[key] = observation[key] and tuple(observation[key])
        return {"action": as_action(agent.act(observation))}

    return type(agent).__name__, act


def limit(bounds: dict[str, Any], rules: int | None) -> None:
    """Set the walls, the user and the limits of this process and of its future children."""
    import resource  # does not exist on Windows

    os.setsid()
    for number in range(3):  # an open file shared with later processes could pass flags to them
        os.close(number)
        os.open(os.devnull, os.O_RDWR)
    if rules is not None:
        walls.leave_files(rules)
    walls.change_user(bounds["walls"], bounds["user"])
    control_process(DEATH_SIGNAL, signal.SIGKILL)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    for name, value in bounds["limits"].items():
        kind = getattr(resource, name)
        hard = resource.getrlimit(kind)[1]
        value = value if hard == resource.RLIM_INFINITY else min(value, hard)
        # macOS does not allow some of these limits.
        with suppress(ValueError, OSError):
            resource.setrlimit(kind, (value, value))
    if walls.PROCESSES in bounds["walls"]:
        walls.refuse_calls()
    forbid(tuple(bounds["denied"]))


def forbid(denied: tuple[str, ...]) -> None:
    """Make Python raise clear errors for what an agent must not do.

    The system would refuse the same with unclear errors. This is not a wall, because compiled code
    can bypass it.
    """
    own, error, decode, is_from = os.getpid(), PermissionError, os.fsdecode, str.startswith
    absolute = os.path.abspath

    def refuse(event: str, values: tuple[Any, ...]) -> None:
        if event in {"os.kill", "os.killpg"} and values[0] == own:
            return
        if event in {
            "os.fork", "os.forkpty", "os.exec", "os.posix_spawn", "os.system", "os.spawn",
            "os.kill", "os.killpg", "subprocess.Popen", "pty.spawn", "_thread.start_new_thread",
            "_thread.start_joinable_thread", "resource.prlimit",
        }:  # fmt: skip
            raise error(f"a graded agent may not use {event}")
        if event == "ctypes.dlsym" and values[1] in {
            "fork", "vfork", "clone", "syscall", "kill", "killpg", "tgkill", "system", "execve",
            "execv", "execvp", "posix_spawn", "popen", "ptrace", "process_vm_readv", "prctl",
        }:  # fmt: skip
            raise error(f"a graded agent may not use {values[1]}")
        is_path = event == "open" and isinstance(values[0], str | bytes)
        if is_path and is_from(decode(values[0]), "/proc/"):
            raise error("a graded agent may not read /proc")
        if is_path and denied and is_from(absolute(decode(values[0])), denied):
            raise error("the rubric denies the import of this module")

    sys.addaudithook(refuse)


def guard_imports(task: dict[str, Any]) -> None:
    """Refuse imports in the files of an agent that its rubric does not allow.

    Other modules may import what they need. This is not a wall. However, the wall of files, where
    there is one, also hides the packages of this program that the rubric denies.
    """
    allowed, denied, folders = task["allowed"], task["denied"], (*task["paths"], task["file"])
    real, by_name = builtins.__import__, importlib.import_module

    def is_of(name: str, modules: list[str]) -> bool:
        return any(name == each or name.startswith(f"{each}.") for each in modules)

    def is_own(name: str) -> bool:
        top = name.partition(".")[0]
        return any(os.path.exists(os.path.join(each, top + end))
                   for each in task["paths"] for end in (".py", ""))  # fmt: skip

    def check(name: str) -> None:
        if is_of(name, denied):
            raise ImportError(f"the rubric denies the import of {name}")
        if allowed is not None and not is_of(name, [*allowed, "__future__"]) and not is_own(name):
            raise ImportError(
                f"the rubric does not allow the import of {name}; allowed: {', '.join(allowed)}"
            )

    def guarded(
        name: str,
        globals: Any = None,  # noqa: A002
        locals: Any = None,  # noqa: A002
        fromlist: Any = (),
        level: int = 0,
    ) -> Any:
        if level == 0 and globals and str(globals.get("__file__", "")).startswith(folders):
            check(name)
            for each in fromlist or ():
                if is_of(f"{name}.{each}", denied):
                    check(f"{name}.{each}")
        return real(name, globals, locals, fromlist, level)

    def guarded_by_name(name: str, package: str | None = None) -> Any:
        if is_of(name, denied):
            check(name)
        return by_name(name, package)

    builtins.__import__, importlib.import_module = guarded, guarded_by_name


def make_agent(task: dict[str, Any]) -> Any:
    """Return the agent of a task, created in the same way as by ``agents.registry.make_agent``."""
    seed = task["seed"]
    random.seed(seed)
    seed_numpy(seed)
    had_numpy = "numpy" in sys.modules
    kind = find_class(load_module(task), task)
    if not had_numpy:
        seed_numpy(seed)
    wanted = inspect.signature(kind).parameters
    taken = [name for name in MAP if name in wanted]
    if taken:
        raise TypeError(f"{kind.__name__} takes a {taken[0]}; graded agents get only observations")
    return kind(**({"seed": seed} if "seed" in wanted else {}))


def seed_numpy(seed: int) -> None:
    """Seed the global random numbers of NumPy, if it is imported."""
    if "numpy" in sys.modules:
        sys.modules["numpy"].random.seed(seed % 2**32)


def load_module(task: dict[str, Any]) -> Any:
    """Return the module of the agent, loaded from its file, or imported if it has no file."""
    sys.path[:] = [*task["paths"], *sys.path]
    if task["file"] is None:
        return importlib.import_module(task["module"])
    name = f"agent file {task['module']}"
    if task["file"].lower().endswith(".ipynb"):
        module = sys.modules[name] = ModuleType(name)
        notebook.load(module, task["file"])
        return module
    return load_file(name, task["file"])


def find_class(module: Any, task: dict[str, Any]) -> Any:
    """Return the class of the agent: by its name, or the only one with ``reset`` and ``act``."""

    def is_agent(kind: object) -> bool:
        has_both = all(callable(getattr(kind, name, None)) for name in ("reset", "act"))
        return isinstance(kind, type) and has_both

    if task["class"] is not None:
        kind = getattr(module, task["class"], None)
        if not is_agent(kind):
            raise AttributeError(f"there is no class {task['class']} with reset() and act()")
        return kind
    found = [
        kind for kind in vars(module).values()
        if is_agent(kind) and kind.__module__ == module.__name__
    ]  # fmt: skip
    if len(found) != 1:
        names = ", ".join(kind.__name__ for kind in found) or "none"
        raise AttributeError(f"one class with reset() and act() is needed; there are: {names}")
    return found[0]


def find_function(task: dict[str, Any]) -> Callable[[tuple[Any, ...]], Any]:
    """Return a function of arguments: from the file, or one that looks them up in a dictionary."""
    random.seed(task["seed"])
    name = task["function"]
    found = getattr(load_module(task), name, None)
    if callable(found):
        return lambda arguments: found(*arguments)
    if isinstance(found, dict):
        return lambda arguments: reduce(getitem, arguments, found)
    raise AttributeError(f"there is neither a function nor a dictionary {name}")


def as_tuples(value: Any) -> Any:
    """Return a value with tuples in place of lists, because JSON has no tuples."""
    if isinstance(value, list):
        return tuple(map(as_tuples, value))
    if isinstance(value, dict):
        return {key: as_tuples(each) for key, each in value.items()}
    return value


def as_value(value: Any) -> Any:
    """Return an answer as a JSON value; raise ``TypeError`` if there is no equivalent."""
    if isinstance(value, dict):
        return {str(key): as_value(each) for key, each in value.items()}
    if isinstance(value, set | frozenset):
        value = sorted(value)
    if isinstance(value, list | tuple):
        return list(map(as_value, value))
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if hasattr(value, "tolist"):  # a number or an array of NumPy
        return value.tolist()
    name = type(value).__name__
    raise TypeError(f"an answer is of type {name}; allowed: numbers, words, lists and dictionaries")


def as_action(action: Any) -> str | int:
    """Return an action as a word or an index; raise ``TypeError`` if it is neither."""
    if isinstance(action, str):
        return str(action[:MAX_TEXT])
    try:
        number = action.__index__()
    except AttributeError:
        name = type(action).__name__
        raise TypeError(f"act() returned {name}; allowed: a word or an index") from None
    return int(number) if abs(number) < 2**31 else -1


def description_of(error: BaseException, file: str | None) -> dict[str, Any]:
    """Return the class of an exception, its message, and its last line in the agent's folder."""
    frames = [
        frame for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename != __file__
        and (file is None or os.path.dirname(frame.filename) == os.path.dirname(file))
    ]  # fmt: skip
    try:
        text = str(error)[:MAX_TEXT]
        if isinstance(error, PermissionError) and error.errno is not None:
            text = f"{text}; {ALLOWED}"
    except BaseException:  # an exception of the agent may itself be broken
        text = ""
    place = f"{os.path.basename(frames[-1].filename)}, line {frames[-1].lineno}" if frames else ""
    if isinstance(error, SyntaxError) and error.filename:
        place = f"{os.path.basename(error.filename)}, line {error.lineno}"
        text = str(error.msg)
    return {"error": type(error).__name__[:MAX_TEXT], "text": text, "place": place}


def main() -> None:
    """Import the modules named on the command line, and serve episodes."""
    _, number, text, *modules = sys.argv
    bounds = json.loads(text)
    sys.path.append(bounds["own"])
    control_process(SUBREAPER, 1)
    control_process(DEATH_SIGNAL, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for name in modules:
        with suppress(ImportError, ValueError):
            import_name(name)
    sys.argv = [""]
    # Libraries ask for this folder. To search for one, Python would write to it.
    tempfile.tempdir = "/tmp"
    gc.freeze()
    control = socket.socket(fileno=int(number))
    control.sendall(b"r")
    has_files = walls.FILES in bounds["walls"]
    places = bounds["own"], bounds["readable"], bounds["listed"]
    serve(control, bounds, walls.file_rules(*places) if has_files else None)


def import_name(name: str) -> None:
    """Import a module, or a name from one."""
    try:
        importlib.import_module(name)
    except ImportError:
        module, _, last = name.rpartition(".")
        getattr(importlib.import_module(module), last, None)


if __name__ == "__main__":
    main()
