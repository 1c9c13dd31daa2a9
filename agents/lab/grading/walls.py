"""Walls around the process of a graded agent on Linux: files, system calls and privileges.

Landlock lets the process read only the files that it needs, and write none. A seccomp filter allows
only the system calls that Python and NumPy make in one process without threads. Whatever is not
listed is refused, such as calls that start processes or threads, open sockets, watch folders,
lock files, change properties of files, or create objects that outlive the process. Both also apply
to compiled code, and the process cannot undo them. The process can still ask for the size and dates
of a file if it knows the path, because Python does so in every import.

This module imports only the standard library, and is loaded by its path, because the process of an
agent must not contain modules of this program that the agent did not import.

Sources: landlock(7), seccomp(2) and capabilities(7) in the Linux manual pages; the numbers are in
``asm/unistd.h``, ``linux/landlock.h``, ``linux/seccomp.h``, ``linux/filter.h`` and
``linux/audit.h``.
"""

from __future__ import annotations

import ctypes
import os
import platform
import struct
import sys
from collections.abc import Iterable, Iterator, Sequence

FILES, PROCESSES = "files", "processes"
"""Walls: they keep an agent from the files of others, and from other processes."""

MIN_LANDLOCK = 3
"""First version of Landlock that also refuses to truncate files (Linux 6.2)."""

CREATE_RULESET, ADD_RULE, RESTRICT_SELF, PATH_BENEATH = 444, 445, 446, 1
READ_FILE, READ_DIR = 1 << 2, 1 << 3
FILE_RIGHTS = 1 << 1 | READ_FILE | 1 << 14
"""Rights to write, read and truncate a file."""

RIGHTS = ((1, (1 << 13) - 1), (2, 1 << 13), (3, 1 << 14), (5, 1 << 15))
"""Rights to files that are refused, each with the first version of Landlock that knows it."""

DEVICES = ("/dev/null", "/dev/zero", "/dev/random", "/dev/urandom")

SYSTEM = (
    "/usr", "/lib", "/lib64", "/etc/ld.so.cache", "/etc/localtime", "/proc/cpuinfo",
    "/proc/meminfo", "/sys/devices/system/cpu",
)  # fmt: skip
"""Files and folders of the system that libraries read when they are imported."""

NO_NEW_PRIVILEGES, SET_SECCOMP, GET_SECCOMP, FILTER = 38, 22, 21, 2
"""Options of ``prctl``, and the mode of seccomp for a filter program."""

KEEP_CAPABILITIES, CAPABILITIES, READ_ALL = 8, 0x20080522, 1 << 2
"""An option of ``prctl``, the version of ``capset``, and the capability to read all files."""

ALLOW, REFUSE, UNKNOWN, KILL = 0x7FFF0000, 0x00050001, 0x00050026, 0x80000000
"""Results of a filter: allow the call, fail with ``EPERM`` or ``ENOSYS``, or end the process."""

LOAD, EQUAL, AT_LEAST, RETURN = 0x20, 0x15, 0x35, 0x06
"""Instructions of a filter: load a word, compare it with a constant, return."""

NUMBER, ARCHITECTURE, ARGUMENTS = 0, 4, 16
"""Offsets in the data of a system call that a filter receives; an argument has eight bytes."""

AUDIT = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
"""Numbers of the machines whose system calls are listed here."""

ALLOWED: dict[str, tuple[int | None, int | None]] = {
    "access": (21, None), "alarm": (37, None), "brk": (12, 214), "chdir": (80, 49),
    "clock_getres": (229, 114), "clock_gettime": (228, 113), "clock_nanosleep": (230, 115),
    "close": (3, 57), "close_range": (436, 436), "dup": (32, 23), "dup2": (33, None),
    "dup3": (292, 24), "epoll_create1": (291, 20), "epoll_ctl": (233, 21), "epoll_pwait": (281, 22),
    "epoll_wait": (232, None), "eventfd2": (290, 19), "exit": (60, 93), "exit_group": (231, 94),
    "faccessat": (269, 48), "faccessat2": (439, 439), "fchdir": (81, 50), "fstat": (5, 80),
    "fstatfs": (138, 44), "futex": (202, 98), "getcpu": (309, 168), "getcwd": (79, 17),
    "getdents64": (217, 61), "getegid": (108, 177), "geteuid": (107, 175), "getgid": (104, 176),
    "getgroups": (115, 158), "getitimer": (36, 102), "getpeername": (52, 205),
    "getpgrp": (111, None), "getpid": (39, 172), "getppid": (110, 173), "getrandom": (318, 278),
    "getrusage": (98, 165), "getsockname": (51, 204), "gettid": (186, 178),
    "gettimeofday": (96, 169), "getuid": (102, 174), "lseek": (8, 62), "lstat": (6, None),
    "madvise": (28, 233), "mbind": (237, 235), "mkdir": (83, None), "mkdirat": (258, 34),
    "mmap": (9, 222), "mprotect": (10, 226), "mremap": (25, 216), "munmap": (11, 215),
    "nanosleep": (35, 101), "newfstatat": (262, 79), "open": (2, None), "openat": (257, 56),
    "pipe": (22, None), "pipe2": (293, 59), "poll": (7, None), "ppoll": (271, 73),
    "pread64": (17, 67), "pselect6": (270, 72), "pwrite64": (18, 68), "read": (0, 63),
    "readlink": (89, None), "readlinkat": (267, 78), "readv": (19, 65), "recvfrom": (45, 207),
    "rename": (82, None), "renameat": (264, 38), "renameat2": (316, 276),
    "restart_syscall": (219, 128), "rmdir": (84, None), "rt_sigaction": (13, 134),
    "rt_sigpending": (127, 136), "rt_sigprocmask": (14, 135), "rt_sigreturn": (15, 139),
    "rt_sigsuspend": (130, 133), "rt_sigtimedwait": (128, 137), "sched_yield": (24, 124),
    "select": (23, None), "sendto": (44, 206), "setitimer": (38, 103), "shutdown": (48, 210),
    "sigaltstack": (131, 132), "stat": (4, None), "statfs": (137, 43), "statx": (332, 291),
    "sysinfo": (99, 179), "time": (201, None), "times": (100, 153), "umask": (95, 166),
    "uname": (63, 160), "unlink": (87, None), "unlinkat": (263, 35), "write": (1, 64),
    "writev": (20, 66),
}  # fmt: skip
"""System calls that an agent may make: their numbers on x86-64 and on ARM.

Measured with strace on x86-64 for the standard library, NumPy, SciPy, Numba and Matplotlib. Calls
that change folders are refused by Landlock, with the errors that programs expect.
"""

LIMITED: dict[str, tuple[tuple[int, int], int, tuple[int, ...]]] = {
    "kill": ((62, 129), 0, ()),
    "tgkill": ((234, 131), 0, ()),
    "prlimit64": ((302, 261), 0, ()),
    "sched_getaffinity": ((204, 123), 0, ()),
    "getpgid": ((121, 155), 0, ()),
    "getsid": ((124, 156), 0, ()),
    "getpriority": ((140, 141), 1, ()),
    "fcntl": ((72, 25), 1, (0, 1, 2, 3, 1030)),  # F_DUPFD, F_GETFD, F_SETFD, F_GETFL, *_CLOEXEC
    # TCGETS, TIOCGWINSZ, FIONBIO, FIONCLEX, FIOCLEX
    "ioctl": ((16, 29), 1, (0x5401, 0x5413, 0x5421, 0x5450, 0x5451)),
    # Two connected streams cannot reach other sockets; datagrams could.
    "socketpair": ((53, 199), 1, (1, 0x801, 0x80001, 0x80801)),
}
"""System calls that are allowed for some values of an argument: their numbers, the place of the
argument, and the values; () for this process, given by its number or as 0."""

Instruction = tuple[int, int, int, int]
"""Code of an instruction, instructions to skip if a comparison is true or false, and constant."""


def enforced() -> frozenset[str]:
    """Return the walls that this system can enforce."""
    if sys.platform != "linux":
        return frozenset()
    files = {FILES} if landlock_version() >= MIN_LANDLOCK else set()
    filters = platform.machine() in AUDIT and _libc().prctl(GET_SECCOMP, 0, 0, 0, 0) != -1
    return frozenset(files | ({PROCESSES} if filters else set()))


def file_rules(own: str, readable: Iterable[str], listed: Iterable[str]) -> int:
    """Return a file descriptor of the rules for reading files.

    Args:
        own: folder of the packages of this program. It may contain other files, and therefore does
            not count as part of Python even if it is on the path.
        readable: files and folders that may be read, besides files of the system and of Python.
        listed: folders whose entries may be listed, without reading the files.

    Raises:
        OSError: the system refused the rules.
    """
    version = landlock_version()
    refused = sum(rights for since, rights in RIGHTS if since <= version)
    network, scopes = 3 * (version >= 4), 3 * (version >= 6)
    attributes = struct.pack("=QQQ", refused, network, scopes)
    attributes = attributes[: 24 if version >= 6 else 16 if version >= 4 else 8]
    size = ctypes.c_size_t(len(attributes))
    rules = _check(_libc().syscall(CREATE_RULESET, attributes, size, 0))
    python = [sys.prefix, sys.base_prefix, *(path for path in sys.path if path != own)]
    for path in dict.fromkeys([*SYSTEM, *python, *readable]):
        _allow(rules, path, READ_FILE | READ_DIR)
    for path in DEVICES:
        _allow(rules, path, FILE_RIGHTS)
    for path in listed:
        _allow(rules, path, READ_DIR)
    return rules


def leave_files(rules: int) -> None:
    """Restrict this process and all its children to the files of the rules, irreversibly."""
    _check(_libc().prctl(NO_NEW_PRIVILEGES, 1, 0, 0, 0))
    _check(_libc().syscall(RESTRICT_SELF, rules, 0))
    os.close(rules)


def change_user(walls: Iterable[str], user: Sequence[int] | None) -> None:
    """Change to another user, if one is given, and give up the privileges of root.

    Args:
        walls: walls of this process. If there are both, the other user may read all files that
            the wall allows, even root's: Python may be installed in root's home folder.
        user: IDs of the user and of its group, or ``None``.
    """
    walls = set(walls)
    may_read = user is not None and walls >= {FILES, PROCESSES}
    if may_read:
        _check(_libc().prctl(KEEP_CAPABILITIES, 1, 0, 0, 0))
    if user is not None:
        os.setgroups([])
        os.setgid(user[1])
        os.setuid(user[0])
    if walls:
        kept = READ_ALL if may_read else 0
        header = struct.pack("=II", CAPABILITIES, 0)
        _check(_libc().capset(header, struct.pack("=6I", kept, kept, 0, 0, 0, 0)))


def refuse_calls() -> None:
    """Forbid all but the listed system calls in this process and its children, irreversibly."""
    _check(_libc().prctl(NO_NEW_PRIVILEGES, 1, 0, 0, 0))
    code = b"".join(struct.pack("=HBBI", *each) for each in program(platform.machine()))
    kept = ctypes.create_string_buffer(code)
    length_and_place = struct.pack("@HP", len(code) // 8, ctypes.addressof(kept))
    _check(_libc().prctl(SET_SECCOMP, FILTER, length_and_place, 0, 0))


def landlock_version() -> int:
    """Return the version of Landlock in this kernel, or -1 if it has none."""
    return int(_libc().syscall(CREATE_RULESET, None, ctypes.c_size_t(0), 1))


def _allow(rules: int, path: str, rights: int) -> None:
    """Allow access to a path and its contents; ignore paths that do not exist."""
    try:
        place = os.open(os.path.realpath(path), os.O_PATH | os.O_CLOEXEC)
    except OSError:
        return
    if not os.path.isdir(path):
        rights &= FILE_RIGHTS
    _check(_libc().syscall(ADD_RULE, rules, PATH_BENEATH, struct.pack("=Qi", rights, place), 0))
    os.close(place)


def program(machine: str) -> Iterator[Instruction]:
    """Yield the filter of system calls for this process on a machine, such as ``"x86_64"``."""
    column = list(AUDIT).index(machine)
    yield LOAD, 0, 0, ARCHITECTURE
    yield EQUAL, 1, 0, AUDIT[machine]
    yield RETURN, 0, 0, KILL
    yield LOAD, 0, 0, NUMBER
    known = {number for each in ALLOWED.values() if (number := each[column]) is not None}
    # Libraries try newer calls first and then do without them. This includes the x32 convention.
    yield AT_LEAST, 0, 1, max(known) + 1
    yield RETURN, 0, 0, UNKNOWN
    for number in sorted(known):
        yield EQUAL, 0, 1, number
        yield RETURN, 0, 0, ALLOW
    for numbers, place, values in LIMITED.values():
        accepted = values or (0, os.getpid())
        yield EQUAL, 0, len(accepted) + 3, numbers[column]
        yield LOAD, 0, 0, ARGUMENTS + 8 * place
        for index, value in enumerate(accepted):
            yield EQUAL, len(accepted) - index, 0, value
        yield RETURN, 0, 0, REFUSE
        yield RETURN, 0, 0, ALLOW
    yield RETURN, 0, 0, REFUSE


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _check(result: int) -> int:
    if result < 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return result
