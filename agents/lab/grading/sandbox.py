"""Run a graded agent in a fresh process for each episode, and ask it for actions.

The operating system enforces the limits. Processes that an agent starts are killed with it. Linux
also keeps an agent from files and other processes, see ``walls.py``. On other systems an agent can
use the network and all files of its user, and must be trusted. macOS neither limits memory nor
finds processes that have left the session of the agent. In a browser, which has no processes, an
agent runs in the current one.
"""

from __future__ import annotations

import builtins
import importlib
import json
import math
import os
import secrets
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic
from typing import Any, NamedTuple

from agents.errors import GradeError
from agents.lab.grading import child, walls
from agents.lab.grading.submissions import Submission
from agents.lab.grading.walls import FILES, PROCESSES
from agents.lab.runs import programs
from agents.registry import forget_modules
from warehouse_core import Observation
from warehouse_core.wording import listed, printable

VARIABLES = {
    "PYTHONHASHSEED": "0", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1", "LANG": "C.UTF-8", "PATH": os.defpath,
}  # fmt: skip
"""All environment variables of an agent. Others may contain secrets."""

MAX_LINE, MAX_TEXT = 65_536, 200
"""Limits on the bytes of an answer, and on the characters of an agent's names and messages."""

MAX_FILES = 256
"""Limit on the files that an agent may have open."""

IMPORT_SECONDS = 60.0
"""Time limit for the fork server to import the modules that all agent processes share."""

ENDING_SECONDS = 5.0
"""Time limit for the fork server to end an agent process, and to end itself."""

NOBODY = "nobody"
"""User that runs agents if the grader is root, as in most containers."""

DEEDS = {
    FILES: ("read files other than their own and Python's", "write files"),
    PROCESSES: ("reach other processes", "use the network"),
}
"""Actions of agents that each wall prevents, in words."""


class AgentLimits(NamedTuple):
    """Limits on an agent.

    Attributes:
        start_seconds: time to load and create the agent, and for its ``reset``.
        answer_seconds: time for one action.
        episode_seconds: time for all actions of an episode together.
        memory_mb: address space in MiB.
        give_up_after: number of successive episodes in which the agent takes too long or ends its
            process, after which the rest of the case is not run and counts the same. If the agent
            cannot be loaded, this includes all further cases.
        allow_imports: modules that an agent may import besides its own; ``None`` for all.
        deny_imports: modules that an agent must not import.
    """

    start_seconds: float = 10.0
    answer_seconds: float = 1.0
    episode_seconds: float = 20.0
    memory_mb: int = 1024
    give_up_after: int = 3
    allow_imports: tuple[str, ...] | None = None
    deny_imports: tuple[str, ...] = ()

    def of_process(self) -> dict[str, int]:
        """Return the limits that the operating system enforces, by their names in ``resource``.

        An agent can start no processes and write only empty files. For root, the limit on
        processes has no effect.
        """
        return {
            "RLIMIT_AS": self.memory_mb * 1024**2,
            "RLIMIT_FSIZE": 0,
            "RLIMIT_MSGQUEUE": 0,
            "RLIMIT_CPU": math.ceil(self.start_seconds + self.episode_seconds) + 1,
            "RLIMIT_NOFILE": MAX_FILES,
            "RLIMIT_NPROC": 0,
            "RLIMIT_CORE": 0,
        }


class AgentFailureError(Exception):
    """The failure of an agent to answer.

    Attributes:
        kind: ``"cannot be loaded"``, ``"fails"``, ``"takes too long"`` or ``"ends its process"``.
        text: message for reports of visible cases.
        public: part of the message for reports of hidden cases. It contains no words of the agent,
            because they might reveal its observations.
    """

    def __init__(self, kind: str, text: str, public: str = "") -> None:
        super().__init__(text)
        self.kind, self.text = kind, printable(text)
        self.public = public


LOAD, FAILS, SLOW, ENDS = "cannot be loaded", "fails", "takes too long", "ends its process"


class AgentProcess:
    """An agent in the process of one episode.

    Attributes:
        name: name of the class or function; "" until it is loaded.
        slowest: seconds of the slowest answer.
    """

    def __init__(self, submission: Submission, limits: AgentLimits, *pipes: int) -> None:
        self._submission, self._limits, self._pipes = submission, limits, pipes
        self._left = limits.episode_seconds
        self.name, self.slowest = "", 0.0

    def start(self, seed: int, function: str | None = None) -> None:
        """Load and reset the agent, or load a function, or raise ``AgentFailureError``."""
        submission = self._submission
        task = {
            "file": None if submission.file is None else str(submission.file),
            "module": submission.module,
            "class": submission.kind,
            "seed": seed,
            "function": function,
            "paths": submission.paths,
            "allowed": self._limits.allow_imports,
            "denied": self._limits.deny_imports,
        }
        try:
            answer = self._ask(task, self._limits.start_seconds)
            self.name = printable(str(answer.get("name"))[:MAX_TEXT])
        except AgentFailureError as failure:
            if failure.kind == FAILS:
                failure.kind = LOAD
            raise

    def act(self, observation: Observation) -> str | int:
        """Return the action for an observation, or raise ``AgentFailureError``."""
        action = self._ask_in_time({"observation": observation}).get("action")
        if not isinstance(action, str | int):
            raise AgentFailureError(ENDS, "it wrote to the channel of its answers")
        return action

    def call(self, arguments: Sequence[Any]) -> Any:
        """Return the value of a function for some arguments, or raise ``AgentFailureError``."""
        return self._ask_in_time({"arguments": arguments}).get("value")

    def _ask_in_time(self, question: dict[str, Any]) -> dict[str, Any]:
        begin, seconds = monotonic(), min(self._limits.answer_seconds, self._left)
        answer = self._ask(question, seconds)
        taken = monotonic() - begin
        self._left -= taken
        self.slowest = max(self.slowest, taken)
        return answer

    def _ask(self, question: dict[str, Any], seconds: float) -> dict[str, Any]:
        word, until = secrets.token_hex(8), monotonic() + seconds
        try:
            self._write(json.dumps(question | {"word": word}).encode() + b"\n", until, seconds)
        except BrokenPipeError:
            raise AgentFailureError(ENDS, "") from None
        line = self._read_line(until, seconds)
        try:
            answer: dict[str, Any] = json.loads(line)
            is_own = answer["word"] == word
        except (ValueError, LookupError, TypeError, RecursionError):
            is_own = False
        if not is_own:
            raise AgentFailureError(ENDS, "it wrote to the channel of its answers")
        if "error" in answer:
            raise failure_of(answer)
        return answer

    def _write(self, rest: bytes, until: float, seconds: float) -> None:
        """Write a question; an agent that does not read it has the same time as for an answer."""
        while rest:
            self._wait(self._pipes[0], select.POLLOUT, until, seconds)
            with suppress(BlockingIOError):  # an agent may fill or shrink the pipe meanwhile
                rest = rest[os.write(self._pipes[0], rest) :]

    def _wait(self, pipe: int, event: int, until: float, seconds: float) -> None:
        ready = select.poll()
        ready.register(pipe, event)
        if not ready.poll(max(until - monotonic(), 0.0) * 1000):
            raise self._too_slow(seconds)

    def _read_line(self, until: float, seconds: float) -> bytes:
        found = b""
        while not found.endswith(b"\n"):
            self._wait(self._pipes[1], select.POLLIN, until, seconds)
            part = os.read(self._pipes[1], MAX_LINE)
            found += part
            if not part:
                raise AgentFailureError(ENDS, "")
            if len(found) > MAX_LINE:
                raise AgentFailureError(ENDS, f"an answer has more than {MAX_LINE:,} bytes")
        return found

    def _too_slow(self, seconds: float) -> AgentFailureError:
        limits = self._limits
        if not self.name:
            return AgentFailureError(SLOW, f"it was not ready after {limits.start_seconds:g} s")
        if seconds < limits.answer_seconds:
            return AgentFailureError(SLOW, f"its answers took {limits.episode_seconds:g} s in all")
        return AgentFailureError(SLOW, f"no answer within {limits.answer_seconds:g} s")


def failure_of(answer: dict[str, Any]) -> AgentFailureError:
    """Return the failure for an exception in an agent, as given by ``child.description_of``."""
    name, text, place = (str(answer.get(key, ""))[:MAX_TEXT] for key in ("error", "text", "place"))
    where = f" ({place})" if place else ""
    kind = getattr(builtins, name, None)
    is_known = isinstance(kind, type) and issubclass(kind, BaseException)
    message = f"{name}: {text}" if text else name
    return AgentFailureError(FAILS, f"{message}{where}", name if is_known else "an exception")


class Sandbox:
    """Context manager that starts the processes of a submission.

    Args:
        submission: agent to run.
        limits: limits on the agent.
        user: user that runs the agent. Only root may choose another user; ``None`` is the current
            user.

    Raises:
        GradeError: the system cannot run agents, or the user cannot be chosen.
    """

    def __init__(
        self, submission: Submission, limits: AgentLimits, user: str | None = None
    ) -> None:
        if sys.platform == "win32":
            raise GradeError("agents are graded on Linux and macOS; on Windows, use WSL")
        if submission.is_built_in:  # its package may be denied to other agents
            limits = limits._replace(allow_imports=None, deny_imports=())
        self._submission, self._limits = submission, limits
        packages = [name for name in programs.OWN if name not in limits.deny_imports]
        files = [submission.folder or submission.file, *map(programs.ROOT.joinpath, packages)]
        self._bounds = {
            "user": None if user is None else _ids_of(user),
            "walls": sorted(walls.enforced()),
            "own": str(programs.ROOT),
            "readable": [str(each) for each in files if each],
            "listed": [],
            "limits": limits.of_process(),
            "denied": [
                str(programs.ROOT.joinpath(*name.split("."))) for name in limits.deny_imports
            ],
        }
        self._server: subprocess.Popen[bytes] | None = None
        self._children: tuple[int, ...] = ()

    def __enter__(self) -> Sandbox:
        child.control_process(child.SUBREAPER, 1)
        self._children = tuple(child.children())
        return self

    def __exit__(self, *error: object) -> None:
        self._stop()

    @contextmanager
    def episode(self) -> Iterator[AgentProcess]:
        """Yield an agent in a new process, which is killed at the end of the block.

        If the process of the agent ends inside the block, ``AgentFailureError`` says how.
        """
        (theirs, questions), (answers, also_theirs) = os.pipe(), os.pipe()
        os.set_blocking(questions, False)
        failure = None
        try:
            self._fork(theirs, also_theirs)
            try:
                yield AgentProcess(self._submission, self._limits, questions, answers)
            except AgentFailureError as found:
                failure = found
            finally:
                status = self._end()
        finally:
            os.close(questions)
            os.close(answers)
        if failure is not None:
            if failure.kind == ENDS and not failure.text:
                failure = AgentFailureError(ENDS, _ending(status))
            raise failure

    def _fork(self, *pipes: int) -> None:
        try:
            if self._server is None:
                self._start()
            try:
                socket.send_fds(self._control, [b"f"], pipes)
            except OSError:  # the server has ended since the previous episode
                self._stop()
                self._start()
                socket.send_fds(self._control, [b"f"], pipes)
        finally:
            for pipe in pipes:
                os.close(pipe)

    def _end(self) -> int | None:
        """End the process of an episode, and return its exit code.

        The result is ``None`` if compiled code of the agent has ended or stopped the fork server.
        """
        try:
            self._control.sendall(b"e")
            status = self._control.recv(6)
        except OSError:
            status = b""
        if not status:
            self._stop()
            return None
        return int(status)

    def _start(self) -> None:
        self._control, theirs = socket.socketpair()
        denied = self._limits.deny_imports
        imports = [
            each for each in self._submission.imports
            if not any(f"{each}.".startswith(f"{name}.") for name in denied)
        ]  # fmt: skip
        words = [
            sys.executable, "-s", "-P", "-B", child.__file__, str(theirs.fileno()),
            json.dumps(self._bounds), *imports,
        ]  # fmt: skip
        try:
            self._server = subprocess.Popen(
                words,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
                start_new_session=True,
                cwd=self._submission.folder or "/",
                env=VARIABLES,
            )
        finally:
            theirs.close()
        self._control.settimeout(IMPORT_SECONDS)
        if not self._control.recv(1):
            raise GradeError(f"the grader's process ended while it imported {', '.join(imports)}")
        self._control.settimeout(ENDING_SECONDS)

    def _stop(self) -> None:
        """End the fork server and all processes that its agents have started."""
        if self._server is not None:
            self._control.close()  # this ends the server if it still works
            try:
                code = self._server.wait(ENDING_SECONDS)
            except subprocess.TimeoutExpired:
                self._server.kill()
                code = self._server.wait()
            self._server = None
            if code < 0:
                child.kill_strays(self._children)


def _ids_of(user: str) -> tuple[int, int]:
    """Return the IDs of a user and of its group."""
    import pwd

    if os.getuid() != 0:
        raise GradeError(f"--user {user}: only root may run agents as another user")
    try:
        found = pwd.getpwnam(user)
    except KeyError:
        raise GradeError(f"--user {user}: there is no such user") from None
    return found.pw_uid, found.pw_gid


def _ending(status: int | None) -> str:
    """Return how a process ended, in words."""
    if status is None:
        return "it ended or stopped the process that started it"
    if status >= 0:
        return f"exit code {status}"
    return f"signal {-status} ({signal.strsignal(-status)})"


class SameProcess:
    """Runner of an agent in the current process, for browsers, which have no other processes.

    It is used like a ``Sandbox``, but it has no walls, user or secrets, and does not interrupt
    slow answers. Therefore the agent must be trusted.
    """

    def __init__(self, submission: Submission, limits: AgentLimits, *_: object) -> None:
        self._submission, self._limits = submission, limits

    def __enter__(self) -> SameProcess:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    @contextmanager
    def episode(self) -> Iterator[AgentProcess]:
        """Yield an agent that is not loaded yet; its rules for imports end with the block."""
        paths, by_statement, by_name = sys.path[:], builtins.__import__, importlib.import_module
        modules = {*sys.modules}
        try:
            yield _AgentHere(self._submission, self._limits)
        finally:
            # Another agent may have modules of the same names.
            forget_modules(modules, [Path(each) for each in sys.path if each not in paths])
            sys.path[:] = paths
            builtins.__import__, importlib.import_module = by_statement, by_name


class _AgentHere(AgentProcess):
    """An agent in the current process, with the interface of an agent in another process."""

    _reply: Callable[[dict[str, Any]], dict[str, Any]] | None = None
    _file: str | None = None

    def _ask(self, question: dict[str, Any], seconds: float) -> dict[str, Any]:
        asked = json.loads(json.dumps(question))
        try:
            if self._reply is not None:
                return self._reply(asked)
            self._file = asked["file"]
            if asked["allowed"] is not None or asked["denied"]:
                child.guard_imports(asked)
            name, self._reply = child.begin(asked)
            return {"name": name}
        except (Exception, SystemExit) as error:
            raise failure_of(child.description_of(error, self._file)) from error


Runner = Sandbox | SameProcess
"""A runner of the agent of a submission, which starts it afresh for each episode."""


def check_trust(user: str | None, is_trusted: bool, are_many: bool) -> str:
    """Return what agents can and cannot do on this system, in words.

    Args:
        user: user that runs the agents, or ``None`` for the current user.
        is_trusted: true if the agents are trusted to do no harm.
        are_many: true for a folder of agents, false for one agent.

    Raises:
        GradeError: root would run agents that are not trusted, or agents of a class that are not
            trusted could reach each other's files.
    """
    kept = walls.enforced()
    prevented = [deed for wall, deeds in DEEDS.items() if wall in kept for deed in deeds]
    possible = [deed for wall, deeds in DEEDS.items() if wall not in kept for deed in deeds]
    if not is_trusted and user is None:
        if sys.platform != "win32" and os.getuid() == 0:
            raise GradeError(
                "refusing to run student code as root; use --user nobody, or --trust if you wrote "
                "the code yourself"
            )
        if are_many and possible:
            raise GradeError(
                f"on this system agents can {listed(possible)}; grade as root with --user "
                "nobody, or use --trust if you wrote the code yourself"
            )
    cannot = f"agents cannot {listed(prevented, 'or')}" if prevented else ""
    can = f"agents can {listed(possible)}" if possible else ""
    return "; ".join(filter(None, (cannot, can)))


def agents_user(user: str | None, is_trusted: bool) -> str | None:
    """Return the user that runs agents: for root, behind both walls, one without any rights."""
    is_root = sys.platform != "win32" and os.getuid() == 0
    is_safe = walls.enforced() >= {FILES, PROCESSES}
    return NOBODY if user is None and not is_trusted and is_root and is_safe else user


def most_jobs(user: str | None, jobs: int) -> int:
    """Return how many agents may run at once: one if agents could reach another's process."""
    return 1 if user is not None and PROCESSES not in walls.enforced() else jobs
