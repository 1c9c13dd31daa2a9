"""Run an agent in processes of its own, a fresh one for each episode, and ask it for actions.

The operating system enforces the limits, and what an agent starts is killed with it. Linux also
keeps it from files and other processes, see ``walls.py``. Where it does not, an agent can use the
network, and all files that its user can, and must be trusted. macOS does not limit memory, nor find
what has left the session of the agent. Where there are no processes, as in a browser, an agent runs
in this one.
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
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import Any, NamedTuple

from agents.errors import GradeError
from agents.lab.grading import child, walls
from agents.lab.grading.submissions import Submission
from agents.lab.grading.walls import FILES, PROCESSES
from agents.lab.runs import programs
from warehouse_core import Observation
from warehouse_core.wording import printable

VARIABLES = {
    "PYTHONHASHSEED": "0", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1", "LANG": "C.UTF-8", "PATH": os.defpath,
}  # fmt: skip
"""All environment variables of an agent; no others, which may have secrets."""

MAX_LINE, MAX_TEXT = 65_536, 200
"""Most bytes of an answer, and most characters of a name or a message of an agent."""

MAX_FILES = 256
"""Most files that an agent may have open."""

IMPORT_SECONDS = 60.0
"""Longest time in which the fork server imports the modules that all agent processes share."""

ENDING_SECONDS = 5.0
"""Longest time in which the fork server ends an agent process, and then itself."""

DEEDS = {
    FILES: "read files that are neither theirs nor Python's, or write any",
    PROCESSES: "reach other processes or the network",
}
"""The deeds of agents that each wall prevents, in words."""


class AgentLimits(NamedTuple):
    """Limits on an agent.

    Attributes:
        start_seconds: time to load it, to make it, and for its ``reset``.
        answer_seconds: time for an action.
        episode_seconds: time for all actions of an episode together.
        memory_mb: address space in MiB.
        give_up_after: number of successive episodes of a case in which it takes too long or ends
            its process; further ones of the case count as the last one, unrun. If it cannot be
            loaded, further cases do too.
        allow_imports: modules that an agent may import, beside its own; ``None`` for all.
        deny_imports: modules that it may not import.
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

        No processes, and no files that are not empty. Root has no limit of processes.
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
    """An agent that has not answered.

    Attributes:
        kind: ``"cannot be loaded"``, ``"fails"``, ``"takes too long"`` or ``"ends its process"``.
        text: message for who may see the case.
        public: part of the message that does not come from the agent, whose own words may tell
            what it has observed.
    """

    def __init__(self, kind: str, text: str, public: str = "") -> None:
        super().__init__(text)
        self.kind, self.text = kind, printable(text)
        self.public = public


LOAD, FAILS, SLOW, ENDS = "cannot be loaded", "fails", "takes too long", "ends its process"


class AgentProcess:
    """An agent in the process of one episode.

    Attributes:
        name: name of its class or function; "" until it is loaded.
        slowest: seconds of its slowest answer.
    """

    def __init__(self, submission: Submission, limits: AgentLimits, *pipes: int) -> None:
        self._submission, self._limits, self._pipes = submission, limits, pipes
        self._left = limits.episode_seconds
        self.name, self.slowest = "", 0.0

    def start(self, seed: int, function: str | None = None) -> None:
        """Load and reset the agent, or load a function, or raise its ``AgentFailureError``."""
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
        """Return the action for an observation, or raise the ``AgentFailureError``."""
        action = self._ask_in_time({"observation": observation}).get("action")
        if not isinstance(action, str | int):
            raise AgentFailureError(ENDS, "it wrote to the channel of its answers")
        return action

    def call(self, arguments: Sequence[Any]) -> Any:
        """Return the answer of a function to its arguments, or raise the ``AgentFailureError``."""
        return self._ask_in_time({"arguments": arguments}).get("value")

    def _ask_in_time(self, question: dict[str, Any]) -> dict[str, Any]:
        begin, seconds = monotonic(), min(self._limits.answer_seconds, self._left)
        answer = self._ask(question, seconds)
        taken = monotonic() - begin
        self._left -= taken
        self.slowest = max(self.slowest, taken)
        return answer

    def _ask(self, question: dict[str, Any], seconds: float) -> dict[str, Any]:
        word = secrets.token_hex(8)
        try:
            os.write(self._pipes[0], json.dumps(question | {"word": word}).encode() + b"\n")
        except BrokenPipeError:
            raise AgentFailureError(ENDS, "") from None
        line = self._read_line(seconds)
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

    def _read_line(self, seconds: float) -> bytes:
        found, until = b"", monotonic() + seconds
        ready = select.poll()
        ready.register(self._pipes[1], select.POLLIN)
        while not found.endswith(b"\n"):
            if not ready.poll(max(until - monotonic(), 0.0) * 1000):
                raise self._too_slow(seconds)
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
    """Return the failure of an agent that answers by an exception, see ``child.described``."""
    name, text, place = (str(answer.get(key, ""))[:MAX_TEXT] for key in ("error", "text", "place"))
    where = f" ({place})" if place else ""
    kind = getattr(builtins, name, None)
    is_known = isinstance(kind, type) and issubclass(kind, BaseException)
    message = f"{name}: {text}" if text else name
    return AgentFailureError(FAILS, f"{message}{where}", name if is_known else "an exception")


class Sandbox:
    """Starts the processes of a submission; to be used as a context manager.

    Args:
        submission: agent to run.
        limits: limits on it.
        user: another user as which it runs, which only root may choose.
        secrets: files that it must not read, even in its folder.
    """

    def __init__(
        self,
        submission: Submission,
        limits: AgentLimits,
        user: str | None = None,
        secrets: Iterable[Path] = (),
    ) -> None:
        if sys.platform == "win32":
            raise GradeError("agents are graded on Linux and macOS; on Windows, use WSL")
        if submission.is_built_in:  # it is one of the packages that may be denied to others
            limits = limits._replace(allow_imports=None, deny_imports=())
        self._submission, self._limits = submission, limits
        readable, listed = _files_of(submission, secrets, limits.deny_imports)
        self._bounds = {
            "user": None if user is None else _ids_of(user),
            "walls": sorted(walls.held()),
            "own": str(programs.ROOT),
            "readable": readable,
            "listed": listed,
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

        The failure of an agent in the block says how its process ended, if it did.
        """
        (theirs, questions), (answers, also_theirs) = os.pipe(), os.pipe()
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
            except OSError:  # something has ended it since the previous episode
                self._stop()
                self._start()
                socket.send_fds(self._control, [b"f"], pipes)
        finally:
            for pipe in pipes:
                os.close(pipe)

    def _end(self) -> int | None:
        """End the process of an episode and return its exit code, if that is known.

        It is not if compiled code of the agent has ended or stopped what started its process.
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
            raise GradeError(f"importing {', '.join(imports)} ended the process")
        self._control.settimeout(ENDING_SECONDS)

    def _stop(self) -> None:
        """End the server and what its agents have started."""
        if self._server is not None:
            self._control.close()  # which ends it, if nothing has happened to it
            try:
                code = self._server.wait(ENDING_SECONDS)
            except subprocess.TimeoutExpired:
                self._server.kill()
                code = self._server.wait()
            self._server = None
            if code < 0:
                child.kill_strays(self._children)


def _files_of(
    submission: Submission, secrets: Iterable[Path], denied: Collection[str]
) -> tuple[list[str], list[str]]:
    """Return the files and folders that an agent may read, and the folders that it may list."""
    own = [str(programs.ROOT / name) for name in programs.OWN if name not in denied]
    folder = submission.folder
    if folder is None:
        return [*own, str(submission.file)], []
    hidden = [each for each in map(Path.resolve, secrets) if each.is_relative_to(folder)]
    if not hidden:
        return [*own, str(folder)], []
    readable = [
        str(path) for path in folder.iterdir()
        if not path.is_symlink() and not any(each.is_relative_to(path) for each in hidden)
    ]  # fmt: skip
    return [*own, *readable], [str(folder)]


def _ids_of(user: str) -> tuple[int, int]:
    """Return the numbers of a user and its group."""
    import pwd

    if os.getuid() != 0:
        raise GradeError(f"--user {user}: only root may run agents as another user")
    try:
        found = pwd.getpwnam(user)
    except KeyError:
        raise GradeError(f"--user {user}: there is no such user") from None
    return found.pw_uid, found.pw_gid


def _ending(status: int | None) -> str:
    """Return how a process has ended, in words."""
    if status is None:
        return "it ended or stopped the process that had started it"
    if status >= 0:
        return f"exit code {status}"
    return f"signal {-status} ({signal.strsignal(-status)})"


class SameProcess:
    """Runs an agent in this process, where there can be no other, as in a browser.

    Nothing keeps such an agent from anything, and it is not interrupted when it takes too long:
    whoever grades it so has to trust it, and to end the process. It is used like a ``Sandbox``,
    without its user and secrets.
    """

    def __init__(self, submission: Submission, limits: AgentLimits, *_: object) -> None:
        self._submission, self._limits = submission, limits

    def __enter__(self) -> SameProcess:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    @contextmanager
    def episode(self) -> Iterator[AgentProcess]:
        """Yield an agent that is not loaded yet; what it may import is forgotten after."""
        paths, by_statement, by_name = sys.path[:], builtins.__import__, importlib.import_module
        try:
            yield _AgentHere(self._submission, self._limits)
        finally:
            sys.path[:] = paths
            builtins.__import__, importlib.import_module = by_statement, by_name


class _AgentHere(AgentProcess):
    """An agent in this process; it is asked like one in another, and answers at once."""

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
            raise failure_of(child.described(error, self._file)) from error


Runner = Sandbox | SameProcess
"""Runs the agent of a submission, afresh in each episode."""


def check_trust(user: str | None, is_trusted: bool, are_many: bool) -> str:
    """Return what agents cannot do here, and what they can, in words.

    Args:
        user: user that runs the agents, or ``None`` for the one that grades.
        is_trusted: promise that the agents do no harm.
        are_many: true for a folder of agents, false for one agent.

    Raises:
        GradeError: root would run agents that are not trusted, or nothing keeps the agents of a
            class from the files of others.
    """
    kept = walls.held()
    prevented = [deed for wall, deed in DEEDS.items() if wall in kept]
    possible = [deed for wall, deed in DEEDS.items() if wall not in kept]
    if not is_trusted and user is None:
        if sys.platform != "win32" and os.getuid() == 0:
            raise GradeError(
                "root does not run agents with its own rights: choose a user without any, such as "
                "--user nobody, or --trust the agents"
            )
        if are_many and possible:
            raise GradeError(
                f"on this system agents can {', and '.join(possible)}: grade them as root with a "
                "--user without rights, such as nobody, or --trust them"
            )
    told = f"agents cannot {', nor '.join(prevented)}" if prevented else ""
    also = f"agents can {', and '.join(possible)}" if possible else ""
    return "; ".join(filter(None, (told, also)))


def most_jobs(user: str | None, jobs: int) -> int:
    """Return how many agents may run at once: of one user only one, if it could reach others."""
    return 1 if user is not None and PROCESSES not in walls.held() else jobs
