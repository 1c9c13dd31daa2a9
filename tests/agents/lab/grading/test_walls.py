"""The filter of system calls, run as in the kernel, and the rules of Landlock."""

import errno
import fcntl
import os
import socket
import struct
import termios
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from agents.lab.grading import walls
from agents.lab.grading.walls import ALLOWED, LIMITED

ALLOW, KILL = 0x7FFF0000, 0x80000000
"""``SECCOMP_RET_ALLOW`` and ``SECCOMP_RET_KILL_PROCESS``."""

REFUSE, UNKNOWN = 0x00050000 | errno.EPERM, 0x00050000 | errno.ENOSYS
"""``SECCOMP_RET_ERRNO`` with the two errors."""

MACHINES = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
TABLE = Path(__file__).parents[3] / "data" / "system_calls.txt"


@cache
def numbers(machine: str) -> dict[str, int]:
    """Return the numbers of all system calls by name, from the headers of the kernel."""
    column = [*MACHINES].index(machine) + 1
    rows = [line.split() for line in TABLE.read_text().splitlines()[1:]]
    return {row[0]: int(row[column]) for row in rows if row[column] != "-"}


def verdict(machine: str, number: int, *arguments: int, audit: int | None = None) -> int:
    """Return the result of a machine's filter for a system call."""
    told = {0: number, 4: MACHINES[machine] if audit is None else audit}
    told |= {16 + 8 * place: value for place, value in enumerate(arguments)}
    program, at, loaded = [*walls.program(machine)], 0, 0
    while True:
        code, if_so, if_not, constant = program[at]
        at += 1
        assert (if_so, if_not) == (0, 0) or code in (0x15, 0x35), "only comparisons skip"
        match code:
            case 0x20:  # load a word
                loaded = told[constant]
            case 0x15:  # jump if equal
                at += if_so if loaded == constant else if_not
            case 0x35:  # jump if greater or equal
                at += if_so if loaded >= constant else if_not
            case 0x06:
                return constant
            case _:
                raise AssertionError(code)


@pytest.mark.parametrize("machine", MACHINES)
def test_the_filter_allows_the_calls_that_it_names_and_no_others(machine: str) -> None:
    known, column, own = numbers(machine), [*MACHINES].index(machine), os.getpid()
    newest = known["faccessat2"]
    for name, number in known.items():
        if name in LIMITED:
            _, place, values = LIMITED[name]
            for value in {*values, 0, own, own + 1, 1, 2, 5, 8, 10, 15, 1024, 2**32 - 1}:
                before = [own] * place
                expected = ALLOW if value in (values or (0, own)) else REFUSE
                assert verdict(machine, number, *before, value) == expected, (name, value)
        elif name in ALLOWED:
            assert verdict(machine, number) == ALLOW, name
        else:
            assert verdict(machine, number) == (UNKNOWN if number > newest else REFUSE), name
    assert ALLOWED.keys() & LIMITED.keys() == set()
    for name, each in ALLOWED.items():
        assert each[column] == known.get(name), name
    for name, (each, *_) in LIMITED.items():
        assert each[column] == known[name], name


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize(
    "name",
    ["inotify_init1", "inotify_add_watch", "fanotify_init", "flock", "utimensat", "setsockopt",
     "connect", "bind", "sendmsg", "mincore", "memfd_create", "prctl", "execve", "clone3", "chroot",
     "name_to_handle_at", "process_vm_readv", "ptrace", "setpriority", "sched_setaffinity"],
)  # fmt: skip
def test_calls_that_reach_beyond_the_process_are_refused(machine: str, name: str) -> None:
    assert verdict(machine, numbers(machine)[name]) == REFUSE


@pytest.mark.parametrize("machine", MACHINES)
def test_of_calls_with_many_commands_only_harmless_ones_are_allowed(machine: str) -> None:
    """Others signal processes, watch folders, lock files, or change the size of a pipe."""
    kinds = socket.SOCK_STREAM, socket.SOCK_STREAM | socket.SOCK_CLOEXEC, socket.SOCK_DGRAM
    for name, allowed, refused in (
        ("fcntl", (fcntl.F_DUPFD_CLOEXEC, fcntl.F_GETFL),
         (fcntl.F_SETOWN, fcntl.F_SETSIG, fcntl.F_NOTIFY, fcntl.F_SETLK, fcntl.F_SETPIPE_SZ)),
        ("ioctl", (termios.TIOCGWINSZ, termios.TCGETS), (termios.TIOCSTI, 0x8901, 0x8902)),
        ("socketpair", kinds[:2], kinds[2:]),
    ):  # fmt: skip
        number = numbers(machine)[name]
        assert {verdict(machine, number, 0, each) for each in allowed} == {ALLOW}, name
        assert {verdict(machine, number, 0, each) for each in refused} == {REFUSE}, name


@pytest.mark.parametrize("machine", MACHINES)
def test_calls_by_another_convention_do_not_exist_or_end_the_process(machine: str) -> None:
    getpid = numbers(machine)["getpid"]
    assert verdict(machine, getpid) == ALLOW
    assert verdict(machine, getpid, audit=0x40000003) == KILL
    assert verdict(machine, 2**30 + getpid) == UNKNOWN


class Kernel:
    """A C library that records calls, of a kernel with a version of Landlock."""

    def __init__(self, version: int) -> None:
        self.version, self.asked = version, list[tuple[Any, ...]]()

    def syscall(self, number: int, *arguments: Any) -> int:
        if number == 444 and arguments[0] is None:
            assert (arguments[1].value, arguments[2]) == (0, 1)
            return self.version
        self.asked.append((number, *arguments))
        return 7

    def __getattr__(self, name: str) -> Any:
        return lambda *arguments: self.asked.append((name, *arguments)) or 0


@pytest.mark.parametrize(
    ("version", "numbers"),
    [(3, (0x7FFF,)), (4, (0x7FFF, 3)), (5, (0xFFFF, 3)), (6, (0xFFFF, 3, 3)), (7, (0xFFFF, 3, 3))],
)
def test_landlock_is_asked_for_all_that_its_version_can_refuse(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, version: int, numbers: tuple[int, ...]
) -> None:
    """Rights have 15 bits up to version 4, and 16 bits from version 5. See landlock(7).

    A folder may be read (4) and listed (8). A file may be read. A device may also be written (2)
    and truncated (1 << 14).
    """
    kernel, file = Kernel(version), tmp_path / "a.py"
    file.touch()
    monkeypatch.setattr(walls, "_libc", lambda: kernel)
    monkeypatch.setattr(os, "open", lambda path, flags: path)
    monkeypatch.setattr(os, "close", lambda place: None)
    monkeypatch.setattr(struct, "pack", _kept(struct.pack))
    assert walls.file_rules("/own", [str(file), str(tmp_path)], [str(tmp_path.parent)]) == 7
    (number, attributes, size, flags), *rules = kernel.asked
    assert (number, size.value, flags) == (444, 8 * len(numbers), 0)
    assert struct.unpack(f"={len(numbers)}Q", attributes) == numbers
    assert {(each[0], each[1], each[2], each[4]) for each in rules} == {(445, 7, 1, 0)}
    allowed = {place: rights for _, _, _, (rights, place), _ in rules}
    assert allowed[str(file)] == 4
    assert allowed[str(tmp_path)] == 4 | 8
    assert allowed[str(tmp_path.parent)] == 8
    assert allowed["/dev/null"] == 2 | 4 | 1 << 14


def _kept(pack: Any) -> Any:
    """Return a ``struct.pack`` that returns the rights and the place of a rule unchanged."""
    return lambda form, *values: values if form == "=Qi" else pack(form, *values)


@pytest.mark.parametrize(
    ("held", "user", "kept"),
    [
        ({"files", "processes"}, (12, 34), 4),
        ({"files"}, (12, 34), 0),
        ({"processes"}, (12, 34), 0),
        ({"files", "processes"}, None, 0),
        ((), (12, 34), None),
        ((), None, None),
    ],
)
def test_privileges_are_given_up_behind_a_wall_but_for_what_another_user_reads(
    monkeypatch: pytest.MonkeyPatch, held: Any, user: Any, kept: int | None
) -> None:
    """Only ``CAP_DAC_READ_SEARCH`` (bit 2) is kept, and only if there are both walls."""
    kernel, asked = Kernel(3), list[Any]()
    monkeypatch.setattr(walls, "_libc", lambda: kernel)
    for name in ("setgroups", "setgid", "setuid"):
        monkeypatch.setattr(os, name, lambda value, name=name: asked.append((name, value)))
    walls.change_user(held, user)
    assert asked == ([("setgroups", []), ("setgid", 34), ("setuid", 12)] if user else [])
    expected: list[Any] = [("prctl", 8, 1, 0, 0, 0)] if kept else []
    if kept is not None:
        header = struct.pack("=II", 0x20080522, 0)
        expected.append(("capset", header, struct.pack("=6I", kept, kept, 0, 0, 0, 0)))
    assert kernel.asked == expected


@pytest.mark.parametrize(
    ("platform", "version", "mode", "machine", "held"),
    [
        ("linux", 3, 0, "x86_64", {"files", "processes"}),
        ("linux", 3, 2, "aarch64", {"files", "processes"}),
        ("linux", 2, 0, "x86_64", {"processes"}),
        ("linux", -1, -1, "x86_64", set()),
        ("linux", 3, 0, "riscv64", {"files"}),
        ("darwin", 3, 0, "x86_64", set()),
    ],
)
def test_a_wall_stands_where_the_kernel_has_what_it_is_made_of(
    monkeypatch: pytest.MonkeyPatch,
    platform: str,
    version: int,
    mode: int,
    machine: str,
    held: set[str],
) -> None:
    kernel: Any = Kernel(version)
    kernel.prctl = lambda *asked: {(21, 0, 0, 0, 0): mode}[asked]
    monkeypatch.setattr(walls, "_libc", lambda: kernel)
    monkeypatch.setattr("sys.platform", platform)
    monkeypatch.setattr("platform.machine", lambda: machine)
    assert walls.enforced() == held


def test_no_process_gets_new_privileges_behind_a_wall(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel, closed = Kernel(3), list[int]()
    monkeypatch.setattr(walls, "_libc", lambda: kernel)
    monkeypatch.setattr(os, "close", closed.append)
    walls.leave_files(9)
    assert kernel.asked == [("prctl", 38, 1, 0, 0, 0), (446, 9, 0)]
    assert closed == [9]
    kernel.asked.clear()
    walls.refuse_calls()
    (*first,), (name, option, mode, _, *rest) = kernel.asked
    assert first == ["prctl", 38, 1, 0, 0, 0]
    assert (name, option, mode, rest) == ("prctl", 22, 2, [0, 0])
