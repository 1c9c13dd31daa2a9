"""The command ``warehouse report``, which prints answers and writes a page and figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from agents.errors import StoreError
from agents.lab.console.options import SAVE, option
from agents.lab.console.terminal import say
from agents.lab.experiments.store import Store
from warehouse_core.files.atomic import atomic_path, check_suffix, check_target
from warehouse_core.wording import counted

PAGE_SUFFIX = ".html"


def report(
    results: Annotated[
        Path, typer.Argument(metavar="RESULTS", help="A file written by 'warehouse sweep'.")
    ],
    output: Annotated[
        Path | None,
        option("--save -o FILE", f"{SAVE} The page, .html. Default: RESULTS.html."),
    ] = None,
    figures: Annotated[
        Path | None, option("--figures FOLDER", "Also write each figure as .svg into this folder.")
    ] = None,
    replays: Annotated[
        bool | None,
        option(
            "--replays/--no-replays",
            "Run one episode with each outcome again and show its replay. Default: yes, except "
            "for agents from your own files; --replays runs their code too.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Report on a sweep.

    Prints the answers to the questions of the sweep, and writes a page with these answers, figures,
    replays and a table of all combinations. The page is a single file that loads nothing else.

    Example: warehouse report results.sqlite --figures figures
    """
    # Here, because importing SciPy and matplotlib takes longer than most commands.
    from agents.lab.reports.answers import Answer
    from agents.lab.reports.figures import Picture
    from agents.lab.reports.page import make_page, write_page

    target = output or results.with_suffix(PAGE_SUFFIX)
    check_suffix(target, [PAGE_SUFFIX])
    check_target(target)
    if target.resolve() == results.resolve():
        raise StoreError(f"{target}: this is the file of results; save the page under another name")
    with Store(results, read_only=True) as store:
        page = make_page(store, replays)
    # Files first, because the reader of standard output may leave, as ``head`` does.
    write_page(target, page)
    saved, parts = [f"saved {target}"], [each for one in page.sections for each in one.parts]
    if figures:
        figures.mkdir(parents=True, exist_ok=True)
        for picture in (pictures := [each for each in parts if isinstance(each, Picture)]):
            with atomic_path(figures / f"{picture.name}.svg") as part:
                part.write_bytes(picture.svg)
        saved.append(f"saved {counted(len(pictures), 'figure')} in {figures}")
    say("\n".join(page.intro))
    for answer in [each for each in parts if isinstance(each, Answer)]:
        say(f"\n{answer.question}", bold=True)
        say(answer.verdict, bold=True)
        for sentence in answer.sentences:
            say(sentence)
    say("\n" + "\n".join(saved))
