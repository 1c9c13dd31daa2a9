"""The filter of system calls, run as the kernel runs it."""

import os
import termios
from functools import cache
from pathlib import Path

import pytest

from agents.lab.grading import walls
from agents.lab.grading.walls import COMMANDS, OWN_ONLY, REFUSED

ALLOW, REFUSE, KILL = 0x7FFF0000, 0x00050000 | 1, 0x80000000
"""``SECCOMP_RET_ALLOW``, ``SECCOMP_RET_ERRNO`` with ``EPERM``, and ``SECCOMP_RET_KILL_PROCESS``."""

MACHINES = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
TABLE = Path(__file__).parents[3] / "data" / "system_calls.txt"


@cache
def numbers(machine: str) -> dict[str, int]:
    """Return the numbers of all system calls by name, from the headers of the kernel."""
    column = [*MACHINES].index(machine) + 1
    rows = [line.split() for line in TABLE.read_text().splitlines()[1:]]
    return {row[0]: int(row[column]) for row in rows if row[column] != "-"}


def verdict(machine: str, number: int, *arguments: int, audit: int | None = None) -> int:
    """Return what the filter of a machine returns for a system call."""
    told = {0: number, 4: MACHINES[machine] if audit is None else audit}
    told |= {16 + 8 * place: value for place, value in enumerate(arguments)}
    program, at, loaded = [*walls.program(machine)], 0, 0
    while True:
        code, if_so, if_not, constant = program[at]
        at += 1
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
def test_the_filter_refuses_the_calls_that_it_names_and_no_others(machine: str) -> None:
    known, own = numbers(machine), os.getpid()
    for name, number in known.items():
        if name in REFUSED:
            assert verdict(machine, number) == REFUSE, name
        elif name in OWN_ONLY:
            found = [verdict(machine, number, whose) for whose in (0, own, own + 1, 1, 2**32 - 1)]
            assert found == [ALLOW, ALLOW, REFUSE, REFUSE, REFUSE], name
        elif name not in COMMANDS:
            assert verdict(machine, number) == ALLOW, name
    column = [*MACHINES].index(machine)
    for name, each in (REFUSED | OWN_ONLY).items():
        assert each[column] == known.get(name), name


@pytest.mark.parametrize("machine", MACHINES)
def test_commands_that_would_signal_others_are_refused(machine: str) -> None:
    refused = {
        "fcntl": (8, 10, 15),  # F_SETOWN, F_SETSIG, F_SETOWN_EX of fcntl(2)
        "ioctl": (termios.TIOCSTI, 0x8901, 0x8902),  # FIOSETOWN, SIOCSPGRP
    }
    for name, commands in refused.items():
        number = numbers(machine)[name]
        near = {command + step for command in commands for step in (-1, 0, 1)}
        for command in {*near, 0, 1, 2, termios.TIOCGWINSZ}:
            expected = REFUSE if command in commands else ALLOW
            assert verdict(machine, number, 0, command) == expected, (name, command)


@pytest.mark.parametrize("machine", MACHINES)
def test_calls_by_another_convention_are_refused_or_end_the_process(machine: str) -> None:
    getpid = numbers(machine)["getpid"]
    assert verdict(machine, getpid) == ALLOW
    assert verdict(machine, getpid, audit=0x40000003) == KILL
    assert verdict(machine, 2**30 + getpid) == REFUSE
    assert verdict(machine, 2**30) == REFUSE
    assert verdict(machine, 2**30 - 1) == ALLOW
