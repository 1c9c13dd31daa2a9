"""Tables on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from agents.lab.console.terminal import printable_lines, say


class TextTable(NamedTuple):
    """A table of texts, with a title above and a caption below; each row begins with its name."""

    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    title: str = ""
    caption: str = ""


def print_table(table: TextTable) -> None:
    """Print a table, or one list for each row if the table is wider than the terminal."""
    import rich.table  # here, because it takes long to import
    from rich.console import Console

    table = TextTable(
        table.header,
        [tuple(map(printable_lines, row)) for row in table.rows],
        printable_lines(table.title),
        printable_lines(table.caption),
    )
    # Without markup, because names and messages may have square brackets.
    console = Console(markup=False, highlight=False)
    drawn = rich.table.Table(title=table.title or None, caption=table.caption or None)
    columns = list(zip(table.header, *table.rows, strict=True))
    widths = _widths(columns, console.width - len(columns) * len("|  ") - len("|"))
    for (title, *column), width in zip(columns, widths, strict=False):
        is_number = any(text[:1].isdigit() for text in column)
        drawn.add_column(title, justify="right" if is_number else "left", width=width)
    for row in table.rows:
        drawn.add_row(*row)
    if widths:
        console.print(drawn)
        return
    lines = [table.title]
    for name, *cells in table.rows:
        lines += [
            name,
            *(
                f"  {' '.join(title.split())}: {' '.join(cell.split())}"
                for title, cell in zip(table.header[1:], cells, strict=True)
            ),
        ]
    say("\n".join(line for line in [*lines, table.caption] if line.strip()))


def _widths(columns: Sequence[Sequence[str]], room: int) -> list[int]:
    """Return widths of columns at which no word is broken, or [] if the room is too small.

    Room that is left over is given to cells before titles, and to the first columns before others,
    because they have the names.
    """
    from rich.cells import cell_len

    def longest(parts: Sequence[str]) -> int:
        return max(map(cell_len, parts), default=0)

    widths = [longest(" ".join(column).split()) for column in columns]
    room -= sum(widths)
    if room < 0:
        return []
    for part in (slice(1, None), slice(1)):
        for number, column in enumerate(columns):
            wanted = longest("\n".join(column[part]).splitlines()) - widths[number]
            more = min(max(wanted, 0), room)
            widths[number] += more
            room -= more
    return widths
