"""Tables on the terminal."""

from agents.lab.console.table import TextTable, print_table

TABLE = TextTable(
    ("agent", "steps\n(all)", "command"),
    [("greedy [0]", "12.5\n(9 to 16)", "warehouse run"), ("uniform-cost", "9", "none")],
    "2 episodes each",
    "of what was delivered",
)


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
