r"""Names of code on the command line: built-in names, files and modules, with a class and options.

The grammar, in which square brackets mark optional parts::

    NAME    = SOURCE [":" CLASS] [":" OPTIONS]
    SOURCE  = built-in name | file.py | package.module
    OPTIONS = KEY "=" VALUE {"," KEY "=" VALUE}

Paths may contain the same signs, as in ``a=b/my.py`` and ``C:\robots\my.py``. A file that exists
therefore comes first.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

CODE = (".py",)
"""Suffix of files with code; the case of letters does not matter."""

REST = re.compile(r"(:[^:=/\\]*)?(:[^:=/\\]*=.*)?", re.DOTALL)
"""Class and options after a source."""

DRIVE_LENGTH = 2
r"""Length of the drive in a path of Windows such as ``C:\my.py``, whose colon separates nothing."""


class CodeName(NamedTuple):
    """Parts of a name.

    Attributes:
        source: built-in name, file or module.
        kind: name of the class or function; ``None`` if there is none.
        options: options as they were given, or "".
    """

    source: str
    kind: str | None = None
    options: str = ""

    @property
    def file(self) -> Path | None:
        """File with the code, or ``None`` for a built-in name or a module."""
        return Path(self.source) if self.source.lower().endswith(CODE) else None

    @property
    def module(self) -> str | None:
        """Module with the class, or ``None`` for a built-in name or a file."""
        return self.source if self.kind is not None and self.file is None else None


def split_name(name: str, suffixes: Collection[str] = CODE) -> CodeName:
    r"""Return the parts of a name.

    The longest file that exists is the source. If there is none, the source ends as early as
    the grammar allows.

    Args:
        name: name as a user typed it.
        suffixes: suffixes of files in lower case. With "" any file is meant, and has no class.

    Example:
        >>> from agents.code_names import split_name
        >>> split_name("robots/my.py:Agent:memory=20")
        CodeName(source='robots/my.py', kind='Agent', options='memory=20')
        >>> split_name(r"C:\a=b\my.py").source
        'C:\\a=b\\my.py'
    """
    splits = [*_splits(name)]
    if "" in suffixes:
        splits = [each for each in splits if each.kind is None]
    files = (
        each for each in reversed(splits)
        if each.source.lower().endswith(tuple(suffixes)) and os.path.isfile(each.source)
    )  # fmt: skip
    return next(files, splits[0])


def _splits(name: str) -> Iterator[CodeName]:
    """Yield the splits that the grammar allows, from the shortest source to the whole name."""
    has_drive = re.match(r"[A-Za-z]:[/\\]", name) is not None
    for colon in re.finditer(r":|\Z", name[DRIVE_LENGTH:] if has_drive else name):
        end = colon.start() + DRIVE_LENGTH * has_drive
        if (rest := REST.fullmatch(name, end)) is not None:
            kind, options = rest.groups()
            yield CodeName(name[:end], kind and kind[1:], (options or "")[1:])
