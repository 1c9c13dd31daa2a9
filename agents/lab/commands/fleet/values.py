"""The values of shifts as files of comma-separated values: orders and measures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from agents.lab.commands.fleet.report import LINES, ShiftResult, value_of
from agents.lab.console.csv_file import write_csv
from warehouse_core.orders.files import COLUMNS

SUFFIX = ".csv"


def write_shifts(path: Path, results: Sequence[ShiftResult]) -> Path:
    """Write the orders of shifts, one a line, and return the file of their measures beside it."""
    fates = ("taken_by", "taken", "delivered", "steps_late")
    lines = ([result.seed, *line] for result in results for line in _orders(result))
    write_csv(path, ["seed", "order", *COLUMNS, *fates], lines)
    beside = path.with_stem(f"{path.stem}-measures")
    titles = [f"{line.title} ({line.unit})" for line in LINES]
    measures = (
        [
            each.seed,
            *(value_of(each.measures, line) for line in LINES),
            each.diagnosis.mode,
            each.diagnosis.sentence,
        ]
        for each in results
    )
    write_csv(beside, ["seed", *titles, "diagnosis", "sentence"], measures)
    return beside


def _orders(result: ShiftResult) -> Iterator[list[object]]:
    for number, order in enumerate(result.orders):
        late = None if order.delivered is None else max(order.delivered - order.due, 0)
        cells = *order.pickup, *order.dropoff
        fate = order.taken_by, order.taken, order.delivered, late
        yield [number, order.released, order.due, *cells, order.robot, *fate]
