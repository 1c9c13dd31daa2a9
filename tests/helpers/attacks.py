"""Deeds of hostile agents: each must be refused, and no grade may change."""

import os
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from helpers.submissions import GOOD, good, idle, notebook_of

BEFORE = """
import ctypes, fcntl, importlib, mmap, os, resource, signal, socket, subprocess, sys, threading
libc = ctypes.CDLL(None, use_errno=True)
HERE = os.path.dirname(os.path.abspath(__file__))
CLASS = os.path.dirname(HERE)
def call(result):
    if result == -1:
        raise OSError(ctypes.get_errno(), "refused")
    return result
"""

DEEDS = {
    "kill its parent": "os.kill(os.getppid(), 9)",
    "kill all of its user": "os.kill(-1, 9)",
    "kill by C": "call(libc.kill(os.getppid(), 9))",
    "kill by a number of a call": "call(libc.syscall(62, os.getppid(), 9))",
    "kill a group": "call(libc.killpg(os.getpgid(os.getppid()), 9))",
    "queue a signal": "call(libc.sigqueue(os.getppid(), 19, 0))",
    "kill by a pidfd": "signal.pidfd_send_signal(os.pidfd_open(os.getppid()), 9)",
    "own a pipe for another": "fcntl.fcntl(os.pipe()[0], fcntl.F_SETOWN, os.getppid())",
    "choose its signal": "fcntl.fcntl(os.pipe()[0], fcntl.F_SETSIG, 9)",
    "slow others down": "os.setpriority(os.PRIO_USER, 0, 19)",
    "move its parent": "os.sched_setaffinity(os.getppid(), {0})",
    "limit its parent": "resource.prlimit(os.getppid(), resource.RLIMIT_CPU, (1, 1))",
    "trace its parent": "call(libc.ptrace(16, os.getppid(), 0, 0))",
    "read another memory": "call(libc.process_vm_readv(os.getppid(), 0, 0, 0, 0, 0))",
    "fork": "os.fork()",
    "fork by C": "call(libc.fork())",
    "clone": "call(libc.syscall(56, 17, 0, 0, 0, 0))",
    "start a program": "subprocess.Popen(['sleep', '60'])",
    "start a program by its inner function": (
        "importlib.import_module('_posixsubprocess').fork_exec([b'sleep', b'60'], [b'/bin/sleep'],"
        " True, (), None, None, -1, -1, -1, -1, -1, -1, *os.pipe(), False, False, -1, None, None,"
        " None, -1, None, *([False] if sys.version_info < (3, 14) else []))"
    ),
    "become a program": "os.execv('/bin/sleep', ['sleep', '60'])",
    "become a daemon": "call(libc.daemon(1, 1))",
    "start a thread": "threading.Thread(target=print).start()",
    "open a socket": "socket.socket()",
    "open an abstract socket": "socket.socket(socket.AF_UNIX).bind('\\0warehouse')",
    "keep shared memory": "call(libc.shmget(7, 4096, 0o1666))",
    "keep a queue": "call(libc.msgget(7, 0o1666))",
    "keep semaphores": "call(libc.semget(7, 1, 0o1666))",
    "write beside itself": "open(os.path.join(HERE, 'left'), 'w').write('x')",
    "write into its folder": "open('left', 'w').write('x')",
    "write into memory": "open('/dev/shm/left', 'w').write('x')",
    "write into /tmp": "open('/tmp/left', 'w').write('x')",
    "make a folder": "os.mkdir('/tmp/left')",
    "make a pipe": "os.mkfifo('/tmp/left')",
    "make a link": "os.symlink(__file__, '/tmp/left')",
    "change itself": "open(__file__, 'a').write('x')",
    "cut itself short": "os.truncate(__file__, 0)",
    "remove itself": "os.remove(__file__)",
    "rename itself": "os.rename(__file__, __file__ + 'x')",
    "change its rights": "os.chmod(__file__, 0)",
    "change its times": "os.utime(__file__, (0, 0))",
    "read /proc": "open('/proc/self/maps').read()",
    "read /proc by bytes": "open(b'/proc/self/maps').read()",
    "read its parent": "os.open(b'/proc/%d/mem' % os.getppid(), os.O_RDWR)",
    "read /proc by C": "call(libc.open(b'/proc/self/maps', 0))",
    "read passwords": "open('/etc/passwd').read()",
    "list the root": "os.listdir('/')",
    "list /proc": "os.listdir('/proc')",
    "read the folder of others": "os.listdir(os.path.dirname(HERE))",
    "read a rubric": "open(os.path.join(HERE, 'rubric.toml')).read()",
    "read another rubric": "open(os.path.join(os.path.dirname(HERE), 'rubric.toml')).read()",
    "become root": "call(libc.setuid(0)) if os.getuid() else call(-1)",
    "mount": "call(libc.mount(b'none', b'/tmp', b'tmpfs', 0, None))",
    "have namespaces": "call(libc.unshare(0x10000000))",
    "use a ring of calls": "call(libc.syscall(425, 8, 0))",
    "watch folders": "call(libc.inotify_init1(0))",
    "watch all files": "call(libc.fanotify_init(0x200, 0))",
    "be told about a folder": "fcntl.fcntl(os.open(HERE, 0), fcntl.F_NOTIFY, 1)",
    "be told about a file": "fcntl.fcntl(os.open(__file__, 0), fcntl.F_SETLEASE, fcntl.F_RDLCK)",
    "lock a file": "fcntl.flock(os.open(__file__, 0), fcntl.LOCK_EX)",
    "lock a part of a file": "fcntl.lockf(os.open(__file__, 0), fcntl.LOCK_SH)",
    "shrink its pipe": "fcntl.fcntl(os.pipe()[0], 1031, 4096)",
    "see what lies in memory": "call(libc.mincore(ctypes.c_void_p(id(libc) & -4096), 1, bytes(9)))",
    "drop a file from memory": "os.posix_fadvise(os.open(__file__, 0), 0, 0, 4)",
    "read a file ahead": "call(libc.readahead(os.open(__file__, 0), 0, 4096))",
    "pin its memory": "call(libc.mlock(ctypes.c_void_p(id(libc)), 1))",
    "leave a property": "os.setxattr(__file__, 'user.left', b'x')",
    "read properties": "os.listxattr(HERE)",
    "leave a date by reading": (
        "call([os.listdir(HERE), open(__file__).read(), -(os.stat(HERE).st_atime_ns =="
        " os.stat(__file__).st_atime_ns == (2**31 - 1) * 10**9)][-1])"
    ),
    "leave a compiled file": "importlib.import_module('py_compile').compile(__file__)",
    "keep a file in memory": "os.memfd_create('left')",
    "keep a queue of messages": "call(libc.mq_open(b'/left', 66, 0o666, 0))",
    "copy files in the kernel": "os.sendfile(os.pipe()[1], os.open(__file__, 0), 0, 1)",
    "write all files to disk": "call(libc.syncfs(os.open(HERE, 0)))",
    "reach sockets by datagrams": "socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)",
    "have a timer": "call(libc.timerfd_create(0, 0))",
    "ask about its parent": "os.sched_getaffinity(os.getppid())",
    "ask for the session of its parent": "os.getsid(os.getppid())",
    "ask how nice its parent is": "os.getpriority(os.PRIO_PROCESS, os.getppid())",
    "ask for the group of its parent": "os.getpgid(os.getppid())",
    "yield to others": "os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))",
    "list the class": "os.listdir(CLASS)",
    "list the class by a path": "os.listdir(os.path.join(HERE, os.path.relpath(CLASS, HERE)))",
    "read the grades": "open(os.path.join(os.path.dirname(CLASS), 'grades.csv')).read()",
    "change a grade": "open(os.path.join(os.path.dirname(CLASS), 'grades.csv'), 'a').write('x')",
    "hand in more": "open(os.path.join(CLASS, 'left.py'), 'w').write('x')",
}
"""Deeds that must be impossible for an agent, each as an expression."""

PLACES = ("import", "begin(self)", "before(self, observation)")
"""Places where agents try a deed: when they are loaded, in ``reset`` and in ``act``."""


def attempt(deed: str) -> str:
    """Return statements that raise if a deed succeeds, and continue if it is refused."""
    return (
        f"try:\n    {deed}\n"
        "except (OSError, RuntimeError, ValueError, ImportError):\n    pass\n"
        f"else:\n    raise SystemError({deed!r})"
    )


def attacker(name: str, place: str, folder: Path) -> str:
    """Return an agent that tries a deed in a place, and otherwise delivers like a good agent.

    It knows the folder of the class.
    """
    tried, before = attempt(DEEDS[name]), f"{BEFORE}CLASS = {str(folder)!r}\n"
    if place == "import":
        return f"{before}\n{tried}\n{GOOD}"
    return good(place, tried, before)


QUESTIONER = """
frame = sys._getframe()
while "answers" not in frame.f_locals:
    frame = frame.f_back
word, pipe = frame.f_locals["word"], frame.f_locals["answers"]
answer = json.dumps({"word": word, "action": "WAIT"}).encode() + b"\\n"
"""
"""Beginning of a body of ``act`` that finds its channel and can answer by itself."""

MODULES = "import atexit, ctypes, json, os, signal, sys, time"


def asks(body: str) -> str:
    return idle(f"{QUESTIONER}{body}", MODULES)


AGENTS: dict[str, tuple[str, float]] = {
    "answers and sleeps": (asks("os.write(pipe, answer)\ntime.sleep(600)"), 0),
    "answers twice": (asks("os.write(pipe, answer * 2)"), 0),
    "answers by one byte": (asks("os.write(pipe, b'{')\ntime.sleep(600)"), 0),
    "answers byte by byte": (
        asks("for each in range(600): os.write(pipe, b' ')\n; time.sleep(0.1)".replace("\n;", ";")),
        0,
    ),
    "answers without an end": (asks("while True: os.write(pipe, b'x' * 4096)"), 0),
    "answers deeply": (asks("os.write(pipe, b'[' * 30_000 + b'\\n')"), 0),
    "answers with nothing": (asks("os.write(pipe, b'\\n')"), 0),
    "answers with a list": (asks("os.write(pipe, b'[1]\\n')"), 0),
    "answers with a large number": (asks("os.write(pipe, b'9' * 60_000 + b'\\n')"), 0),
    "answers with no text": (asks("os.write(pipe, b'\\xff\\xfe\\n')"), 0),
    "closes its channel": (asks("os.closerange(3, 64)"), 0),
    "reads its questions": (asks("while True: os.read(frame.f_locals['lines'].fileno(), 9)"), 0),
    "stops itself": (idle("os.kill(os.getpid(), signal.SIGSTOP)", MODULES), 0),
    "aborts": (idle("os.abort()", MODULES), 0),
    "crashes": (idle("ctypes.string_at(0)", MODULES), 0),
    "calls itself": (idle("sys.setrecursionlimit(10**9)\nself.act(0)", MODULES), 0),
    "has a slow number": (
        idle("return type('N', (), {'__index__': lambda self: time.sleep(600)})()", MODULES),
        0,
    ),
    "ignores signals": (
        idle(
            "for each in {*signal.Signals} - {9, 19}: signal.signal(each, 1)\ntime.sleep(600)",
            MODULES,
        ),
        0,
    ),
    "is slow at the end": (good("begin(self)", "atexit.register(time.sleep, 600)", MODULES), 100),
    "moves away": (good("begin(self)", "assert os.getcwd() != '/'\nos.chdir('/')", MODULES), 100),
    "keeps a variable": (
        good("begin(self)", "assert 'LEFT' not in os.environ\nos.environ['LEFT'] = '1'", MODULES),
        100,
    ),
    "keeps a mask": (good("begin(self)", "assert os.umask(0o123) != 0o123", MODULES), 100),
}
"""Agents that attack their channel or the grader's time, or leave something to the next episode,
with their points."""


class Entry(NamedTuple):
    """An entry of a class folder: a function that writes it, and its points.

    There are no points for an entry without a row.
    """

    write: Callable[[Path], object]
    points: float | None


def files(**texts: str) -> Callable[[Path], None]:
    """Return a function that writes a folder of Python files."""

    def write(path: Path) -> None:
        path.mkdir()
        for name, text in texts.items():
            (path / f"{name}.py").write_text(text)

    return write


def archive(name: str, mode: int = 0, text: str = GOOD, again: str = "") -> Callable[[Path], None]:
    """Return a function that writes an archive with one file, and perhaps a second one."""

    def write(path: Path) -> None:
        with zipfile.ZipFile(path, "w") as opened:
            for each in filter(None, (name, again)):
                member = zipfile.ZipInfo(each)
                member.filename, member.external_attr = each, mode << 16
                opened.writestr(member, text)

    return write


def code(text: str | bytes = GOOD) -> Callable[[Path], object]:
    """Return a function that writes a file."""
    return lambda path: path.write_bytes(text.encode() if isinstance(text, str) else text)


def sparse(path: Path) -> None:
    path.touch()
    os.truncate(path, 300 * 1024**2)


ENDS = "raise SystemExit(1)"

ENTRIES = {
    "A.PY": Entry(code(), 100),
    "N.IPYNB": Entry(code(notebook_of("files = !ls\nt = %timeit -o 1", GOOD)), 100),
    "Z.ZIP": Entry(archive("work\\agent.py"), 100),
    "up.zip": Entry(archive("..\\agent.py"), 0),
    "root.zip": Entry(archive("/agent.py"), 0),
    "drive.zip": Entry(archive("C:\\agent.py"), 0),
    "link.zip": Entry(archive("agent.py", 0o120777, "/etc/passwd"), 0),
    "pipe.zip": Entry(archive("agent.py", 0o010666), 0),
    "twice.zip": Entry(archive("agent.py", again="AGENT.PY"), 0),
    "composed.zip": Entry(
        archive("\u00e9t\u00e9/agent.py", again="e\u0301te\u0301/notes.txt"), 100
    ),
    "Thumbs.db": Entry(code("x"), None),
    ".DS_Store": Entry(code("x"), None),
    "desktop.ini": Entry(code("x"), None),
    "__MACOSX": Entry(files(agent=GOOD), None),
    "pipe.py": Entry(os.mkfifo, 0),
    "rubric.py": Entry(lambda path: path.symlink_to(path.parent.parent / "rubric.toml"), 0),
    "linked": Entry(lambda path: path.symlink_to(path.parent), 0),
    "sparse.py": Entry(sparse, 0),
    "nulls.py": Entry(code(b"\0" * 99), 0),
    "marked.py": Entry(code(b"\xef\xbb\xbf" + GOOD.encode()), 100),
    "folder.py": Entry(files(agent=GOOD), 100),
    "own json": Entry(files(agent=GOOD, json=ENDS, os=ENDS, random=ENDS, numpy=ENDS), 100),
    "own site": Entry(files(agent=GOOD, sitecustomize=ENDS, usercustomize=ENDS), 100),
    "own grader": Entry(files(agent=GOOD, agents=ENDS, warehouse_core=ENDS, child=ENDS), 100),
    "many": Entry(files(agent=GOOD, **{f"f{number}": "" for number in range(1_100)}), 0),
    "=cmd|' |'!A1": Entry(files(agent=GOOD), 100),
    "two\nlines": Entry(files(agent=GOOD), 100),
    'quote".py': Entry(code(), 100),
    os.fsdecode(b"\xff\xfe.py"): Entry(code(), 100),
    f"{'long' * 60}.py": Entry(code(), 100),
}
"""Entries of a class folder by name: traps and bad luck with packages."""
