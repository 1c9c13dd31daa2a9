"""Say what the results of a sweep come to: on the terminal, as a page, and as figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agents.errors import StoreError
from agents.evaluation.wording import counted
from agents.experiments.store import Store
from warehouse_core.files.atomic import atomic_path, check_suffix, check_target

PAGE_SUFFIX = ".html"


def report(
    results: Annotated[Path, typer.Argument(help="What warehouse sweep has written.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="FILE", help="The page.", show_default="RESULTS.html"
        ),
    ] = None,
    figures: Annotated[
        Path | None,
        typer.Option("--figures", metavar="FOLDER", help="Write each figure as .svg, too."),
    ] = None,
    replays: Annotated[
        bool | None,
        typer.Option(
            "--replays/--no-replays",
            help="Run one episode of each failure mode again, to be watched; with --replays also "
            "those of agents that are no part of this program.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Write what a sweep has found as one page of HTML, and its answers here."""
    # Here, because SciPy and matplotlib take longer to import than most commands to run.
    from agents.reports.contents import make_page
    from agents.reports.examples import find_examples, replay
    from agents.reports.page import write_page

    target = output or results.with_suffix(PAGE_SUFFIX)
    check_suffix(target, [PAGE_SUFFIX])
    check_target(target)
    if target.resolve() == results.resolve():
        raise StoreError(f"{target}: these are the results; the page needs another name")
    with Store(results, read_only=True) as store:
        wanted = [] if replays is False else find_examples(store)
        page = make_page(
            store, tuple(replay(found, run_own_code=bool(replays)) for found in wanted)
        )
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
        typer.echo(f"saved {counted(len(page.pictures), 'figure')} in {figures}")
