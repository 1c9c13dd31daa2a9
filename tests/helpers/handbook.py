"""Run the Markdown pages of the README and the handbook, block by block."""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from agents.lab.commands import cli
from agents.lab.console.main import main
from helpers.command_line import ROOT

HANDBOOK = ROOT / "agents" / "handbook"
PAGES = sorted(HANDBOOK.glob("*.md"))
SITE = [str(page.relative_to(HANDBOOK).with_suffix("")) for page in sorted(HANDBOOK.rglob("*.md"))]
"""Names of all pages of the site, including the reference."""

BLOCK = re.compile(
    r"^(?:```(?:\{code-cell\} ipython3|(\w+))( \w+)?\n(?::[^\n]*\n\n)?|<!-- (test)\n)(.*?)"
    r"^(?:```|-->)$",
    flags=re.DOTALL | re.MULTILINE,
)
INSTALL = "python3 -m venv .venv && .venv/bin/pip install -e "
CELL, COMMAND, WRITE, TEXT = "python", "warehouse ", "%%writefile ", "text"
TORCH, RAY = "rl", "neighbours"
"""Words after the language of a block that needs PyTorch, or Ray and Tianshou."""

TEST = "test"
"""Language of hidden comments with code that checks the statements of a page."""


class Block(NamedTuple):
    """A block of a page; its language is ``CELL`` for cells too."""

    language: str
    text: str
    needs: str


def blocks_of(page: Path) -> Iterator[Block]:
    """Yield the blocks of a page that the tests run."""
    for language, needs, test, text in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language != TEXT:
            yield Block(language or test or CELL, text, needs.strip())


def run_page(page: Path, needs: str = "") -> dict[str, object]:
    """Run the blocks of a page in the current folder, and return the names that they define.

    Only the blocks with the same needs are run: none, ``TORCH`` or ``RAY``.
    """
    names: dict[str, object] = {"__name__": "__main__"}
    for language, text, needed in blocks_of(page):
        if needed != needs:
            continue
        if text.startswith(WRITE):
            head, _, rest = text.partition("\n")
            Path(head.removeprefix(WRITE)).write_text(rest, encoding="utf-8")
        elif language in (CELL, TEST) and not text.startswith("!"):
            exec(compile(text, page.name, "exec"), names)
        else:
            for line in text.splitlines():
                if not line.startswith(INSTALL):
                    run_command(line.removeprefix("!"))
    return names


def run_command(line: str) -> None:
    """Run a command of ``warehouse`` in this process."""
    words = shlex.split(line)
    assert words[0] == COMMAND.strip(), f"a command of another program: {line}"
    with pytest.raises(SystemExit) as ended:
        main(cli.app, words[1:])
    assert not ended.value.code, f"{line} failed"
