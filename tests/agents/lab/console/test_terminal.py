import re
import sys
from pathlib import Path

import pytest
from helpers.terminal import Terminal

import agents
from agents.lab.console import table as tables
from agents.lab.console.progress import track
from agents.lab.console.table import print_table
from agents.lab.console.terminal import say

NAME = "\x1b[2Ja\x07b\x9bc\u202ed\udcff[/bold]\r"
SHOWN = r"\x1b[2Ja\x07b\x9bc\u202ed\udcff[/bold] "


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_names_are_printed_without_control_characters(monkeypatch, stream: str) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, stream, terminal)
    say(f"saved {NAME}\nin two lines", error=stream == "stderr")
    assert terminal.getvalue() == f"saved {SHOWN}\nin two lines\n"


def test_bold_text_has_no_codes_but_those_of_bold(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stdout", terminal)
    say(NAME, bold=True)
    assert terminal.getvalue() == f"\x1b[1m{SHOWN}\x1b[0m\n"


@pytest.mark.parametrize("columns", ["200", "20"], ids=["a table", "a list"])
def test_names_in_tables_are_printed_without_control_characters(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], columns: str
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    print_table(tables.TextTable(("agent", "steps"), [(NAME, "two\nlines")], NAME, NAME))
    printed = capsys.readouterr().out
    assert "".join(printed.split()).count(SHOWN.strip()) == 3
    assert printed.replace("\n", "").isprintable()


def test_a_name_beside_a_progress_bar_has_no_control_characters_and_no_markup(monkeypatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("COLUMNS", "200")
    assert list(track([1, 2], NAME)) == [1, 2]
    assert SHOWN.strip() in terminal.getvalue()
    assert "\x1b[2J" not in terminal.getvalue()
    assert "\x07" not in terminal.getvalue()


def test_commands_print_by_say_alone() -> None:
    folder = Path(agents.__file__).parent
    printing = re.compile(r"\b(typer\.(echo|secho)|(?<![.\w])print)\(")
    found = {
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*.py")
        if printing.search(path.read_text(encoding="utf-8"))
    }
    assert found == {"lab/console/terminal.py", "__main__.py"}
