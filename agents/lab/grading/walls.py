"""Walls around the process of a graded agent on Linux: files, system calls and privileges.

Landlock lets the process read only the files that it needs, and write none. A seccomp filter
refuses system calls that start processes or threads, reach other processes, open sockets, change
properties of files, or create objects that outlive the process. Both also apply to compiled code,
and the process cannot undo them.

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

ALLOW, REFUSE, KILL = 0x7FFF0000, 0x00050001, 0x80000000
"""Results of a filter: allow the call, fail with ``EPERM``, or end the process."""

LOAD, EQUAL, AT_LEAST, RETURN = 0x20, 0x15, 0x35, 0x06
"""Instructions of a filter: load a word, compare it with a constant, return."""

NUMBER, ARCHITECTURE, ARGUMENTS = 0, 4, 16
"""Offsets in the data of a system call that a filter receives; an argument has eight bytes."""

X32 = 0x40000000
"""Smallest number of a system call in the x32 convention, which would bypass the other numbers."""

AUDIT = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
"""Numbers of the machines whose system calls are listed here."""

REFUSED = {
    "add_key": (248, 217), "bpf": (321, 280), "chmod": (90, None), "chown": (92, None),
    "clone": (56, 220), "clone3": (435, 435), "execve": (59, 221), "execveat": (322, 281),
    "fchmod": (91, 52), "fchmodat": (268, 53), "fchmodat2": (452, 452), "fchown": (93, 55),
    "fchownat": (260, 54), "fork": (57, None), "fremovexattr": (199, 16),
    "fsetxattr": (190, 7), "futimesat": (261, None), "io_uring_setup": (425, 425),
    "ioprio_set": (251, 30), "keyctl": (250, 219), "lchown": (94, None),
    "lremovexattr": (198, 15), "lsetxattr": (189, 6), "mount": (165, 40), "mq_open": (240, 180),
    "msgget": (68, 186), "open_by_handle_at": (304, 265),
    "perf_event_open": (298, 241), "pidfd_getfd": (438, 438),
    "pidfd_open": (434, 434), "pidfd_send_signal": (424, 424), "process_vm_readv": (310, 270),
    "process_vm_writev": (311, 271), "ptrace": (101, 117), "removexattr": (197, 14),
    "request_key": (249, 218),
    "semget": (64, 190), "setns": (308, 268), "setpriority": (141, 140),
    "setxattr": (188, 5), "shmget": (29, 194),
    "socket": (41, 198), "unshare": (272, 97), "userfaultfd": (323, 282), "utime": (132, None),
    "utimensat": (280, 88), "utimes": (235, None), "vfork": (58, None),
}  # fmt: skip
"""System calls that an agent must not make: their numbers on x86-64 and on ARM."""

OWN_ONLY = {
    "kill": (62, 129), "prlimit64": (302, 261), "rt_sigqueueinfo": (129, 138),
    "rt_tgsigqueueinfo": (297, 240), "sched_setaffinity": (203, 122),
    "sched_setattr": (314, 274), "sched_setparam": (142, 118),
    "sched_setscheduler": (144, 119), "tgkill": (234, 131), "tkill": (200, 130),
}  # fmt: skip
"""System calls that an agent may make only for its own process, given as argument or as 0."""

COMMANDS = {
    "fcntl": ((72, 25), (8, 10, 15)),  # F_SETOWN, F_SETSIG, F_SETOWN_EX
    "ioctl": ((16, 29), (0x5412, 0x8901, 0x8902)),  # TIOCSTI, FIOSETOWN, SIOCSPGRP
}
"""System calls with commands (their second argument) that could signal other processes."""

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
    """Forbid some system calls in this process and all its children, irreversibly."""
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
    yield AT_LEAST, 0, 1, X32
    yield RETURN, 0, 0, REFUSE
    for numbers in REFUSED.values():
        if (number := numbers[column]) is not None:
            yield EQUAL, 0, 1, number
            yield RETURN, 0, 0, REFUSE
    for numbers in OWN_ONLY.values():
        yield EQUAL, 0, 5, numbers[column]
        yield LOAD, 0, 0, ARGUMENTS
        yield EQUAL, 2, 0, 0
        yield EQUAL, 1, 0, os.getpid()
        yield RETURN, 0, 0, REFUSE
        yield RETURN, 0, 0, ALLOW
    for numbers, commands in COMMANDS.values():
        yield EQUAL, 0, len(commands) + 3, numbers[column]
        yield LOAD, 0, 0, ARGUMENTS + 8
        for index, command in enumerate(commands):
            yield EQUAL, len(commands) - index, 0, command
        yield RETURN, 0, 0, ALLOW
        yield RETURN, 0, 0, REFUSE
    yield RETURN, 0, 0, ALLOW


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _check(result: int) -> int:
    if result < 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return result
