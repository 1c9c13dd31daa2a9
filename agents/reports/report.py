"""Say what the results of a sweep come to: on the terminal, as a page, and as figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agents.experiments.store import Store, StoreError
from warehouse_core.atomic_file import atomic_path, check_target


def report(
    results: Annotated[Path, typer.Argument(help="What warehouse sweep has written.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="The page.  [default: RESULTS.html]"),
    ] = None,
    figures: Annotated[
        Path | None,
        typer.Option("--figures", metavar="FOLDER", help="Write each figure as .svg, too."),
    ] = None,
    replays: Annotated[
        bool, typer.Option(help="Run one episode of each failure mode again, to be watched.")
    ] = True,
) -> None:
    """Write what a sweep has found as one page of HTML, and its answers here."""
    # Here, because SciPy and matplotlib take longer to import than most commands to run.
    from agents.reports.contents import make_page
    from agents.reports.examples import find_examples, replay
    from agents.reports.page import write_page

    target = output or results.with_suffix(".html")
    check_target(target)
    if target.resolve() == results.resolve():
        raise StoreError(f"{target}: these are the results; the page needs another name")
    with Store(results, read_only=True) as store:
        page = make_page(store, tuple(map(replay, find_examples(store))) if replays else ())
    typer.echo(page.summary)
    for answer in page.answers:
        typer.echo(f"\n{typer.style(answer.question, bold=True)}")
        for sentence in answer.sentences:
            typer.echo(sentence)
    typer.echo()
    write_page(target, page)
    typer.echo(f"saved {target}")
    if figures:
        figures.mkdir(parents=True, exist_ok=True)
        for picture in page.pictures:
            with atomic_path(figures / f"{picture.name}.svg") as part:
                part.write_bytes(picture.svg)
        typer.echo(f"saved {len(page.pictures)} figures in {figures}")
