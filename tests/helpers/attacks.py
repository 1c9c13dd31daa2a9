"""Deeds of hostile agents: each must be refused, and no grade may change."""

from helpers.submissions import GOOD, good

BEFORE = """
import ctypes, fcntl, importlib, mmap, os, resource, signal, socket, subprocess, sys, threading
libc = ctypes.CDLL(None, use_errno=True)
HERE = os.path.dirname(os.path.abspath(__file__))
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


def attacker(name: str, place: str) -> str:
    """Return an agent that tries a deed in a place, and otherwise delivers like a good agent."""
    tried = attempt(DEEDS[name])
    if place == "import":
        return f"{BEFORE}\n{tried}\n{GOOD}"
    return good(place, tried, BEFORE)
