"""The page of ``warehouse pogema``: what planners reach, curves and tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from agents.lab.commands.pogema.benchmark import SITE, Kind
from agents.lab.commands.pogema.curves import is_published, pictures
from agents.lab.commands.pogema.published import REFERENCE
from agents.lab.commands.pogema.summary import CAPTION, COLUMNS, Group, measures, names_of
from agents.lab.reports.page import Table, write_template
from warehouse_core.wording import counted

TITLE = "Planners on POGEMA's benchmark"

SOURCE = (
    f"Published results: {SITE} (Skrynnik et al., ICLR 2025), on the same maps, starts and goals."
)


def write_pogema_page(
    path: Path, groups: Sequence[Group], settings: Sequence[tuple[str, str]]
) -> None:
    """Write the page, whole or not at all."""
    write_template(
        path,
        "pogema.html",
        TITLE,
        has_players=False,
        source=SOURCE,
        verdicts=list(verdicts(groups)),
        pictures=pictures(groups),
        tables=[(f"Results, {kind}", table) for kind, table in _tables(groups)],
        settings=settings,
    )


def verdicts(groups: Sequence[Group]) -> Iterator[str]:
    """Yield what each planner reaches in all episodes of a kind, beside the reference."""
    for kind in Kind:
        mine = [group for group in groups if group.kind is kind]
        for name in names_of(mine):
            if not is_published(mine, name):
                yield _verdict(kind, [group for group in mine if name in group.scores], name)


def _verdict(kind: Kind, groups: Sequence[Group], name: str) -> str:
    beside = REFERENCE[kind]
    pairs = [(each.scores[name], each.scores[beside]) for each in groups]
    total = counted(sum(mine.episodes for mine, _ in pairs), f"{kind} episode")
    if kind is Kind.LIFELONG:
        mine, other = (
            sum(float(np.nansum(each.values)) for each in column)
            for column in zip(*pairs, strict=True)
        )
        return f"In {total} {name} reaches {mine / other:.2f} times as many goals as {beside}"
    ratios = np.concatenate([mine.ratios(other.values) for mine, other in pairs])
    solved, others = (sum(each.solved for each in column) for column in zip(*pairs, strict=True))
    costs = f"; where both do, it has {ratios.mean():.3f} times the costs" if ratios.size else ""
    return f"{name} solves {solved:,} of {total}, {beside} {others:,}{costs}"


def _tables(groups: Sequence[Group]) -> Iterator[tuple[Kind, Table]]:
    """Yield a table for each kind, with a line for each algorithm."""
    for kind in Kind:
        rows = [
            (group.collection, str(group.robots), name, *measures(group, name))
            for group in groups
            if group.kind is kind
            for name in group.scores
        ]
        if rows:
            yield (
                kind,
                Table(("set", "robots", "planner", *COLUMNS[kind]), tuple(rows), CAPTION[kind]),
            )
