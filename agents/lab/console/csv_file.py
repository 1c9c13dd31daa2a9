"""Files of comma-separated values."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

from warehouse_core.files.atomic import atomic_path
from warehouse_core.wording import printable, spreadsheet_text


def write_csv(path: Path, header: Sequence[str], lines: Iterable[Sequence[object]]) -> None:
    """Write lines below a header; after an error there is no incomplete file.

    ``None`` and NaN become empty fields. Texts are escaped so that no spreadsheet runs one as a
    formula.
    """
    with atomic_path(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(map(_field, line) for line in lines)


def _field(value: object) -> object:
    if isinstance(value, str):
        return spreadsheet_text(printable(value))
    return None if isinstance(value, float) and math.isnan(value) else value
