"""Tables on the terminal."""

import pytest

from agents.lab.console.table import TextTable, print_table

TABLE = TextTable(
    ("agent", "steps\n(all)", "command"),
    [("greedy [0]", "12.5\n(9 to 16)", "warehouse run"), ("uniform-cost", "9", "none")],
    "2 episodes each",
    "of what was delivered",
)


@pytest.mark.parametrize("columns", [80, 40, 30, 8])
def test_a_table_keeps_every_text_at_every_width(capsys, monkeypatch, columns: int) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    print_table(TABLE)
    words = set(capsys.readouterr().out.replace("\n", " ").split())
    texts = [*TABLE.header[1:], *(cell for row in TABLE.rows for cell in row)]
    assert {word for text in texts for word in text.split()} <= {word.rstrip(":") for word in words}
    assert "\u2026" not in words


def test_a_table_that_is_too_wide_is_a_list(capsys, monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "28")
    print_table(TABLE)
    assert capsys.readouterr().out.splitlines() == [
        "2 episodes each",
        "greedy [0]",
        "  steps (all): 12.5 (9 to 16)",
        "  command: warehouse run",
        "uniform-cost",
        "  steps (all): 9",
        "  command: none",
        "of what was delivered",
    ]
