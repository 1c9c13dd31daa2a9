"""Tables on the terminal."""

from __future__ import annotations

from typing import NamedTuple

import typer


class Table(NamedTuple):
    """A table of texts.

    Attributes:
        header: the title of each column.
        rows: the cells; the first of a row is its name.
        title: a line above the table.
        caption: a line below it.
    """

    header: tuple[str, ...]
    rows: list[tuple[str, ...]]
    title: str = ""
    caption: str = ""


def print_table(table: Table) -> None:
    """Print a table; one that is wider than the terminal is printed as a list for each row."""
    import rich.table  # here, because it takes long to import
    from rich.console import Console

    # Without markup: names and messages may have square brackets.
    console = Console(markup=False, highlight=False)
    drawn = rich.table.Table(title=table.title or None, caption=table.caption or None)
    for title, *column in zip(table.header, *table.rows, strict=True):
        is_number = any(text[:1].isdigit() for text in column)
        drawn.add_column(title, justify="right" if is_number else "left", overflow="fold")
    for row in table.rows:
        drawn.add_row(*row)
    widest = console.measure(drawn, options=console.options.update(max_width=1000)).minimum
    if widest <= console.width:
        console.print(drawn)
        return
    lines = [table.title]
    for name, *cells in table.rows:
        lines += [
            name,
            *(f"  {title}: {cell}" for title, cell in zip(table.header[1:], cells, strict=True)),
        ]
    typer.echo("\n".join(line for line in [*lines, table.caption] if line.strip()))
