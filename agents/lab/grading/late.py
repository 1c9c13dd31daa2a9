"""Late submissions: the points that a rubric takes for each day, and the days of each."""

from __future__ import annotations

import csv
from io import StringIO
from pathlib import Path
from typing import NamedTuple

from agents.errors import GradeError
from warehouse_core.files.reading import read_file

MAX_BYTES, MAX_DAYS = 1_000_000, 3_650

COLUMNS = "submission", "days"


class LateRule(NamedTuple):
    """The points that each day takes, and the last day on which there are any."""

    points: float = 0.0
    days: int = MAX_DAYS

    def taken(self, days: int, points: float) -> float:
        """Return how many of an agent's points are taken for some days."""
        return points if days > self.days else min(days * self.points, points)


def load_days(path: Path) -> dict[str, int]:
    """Return the days that submissions are late, by their names.

    Raises:
        GradeError: the file is no CSV with the columns ``submission`` and ``days``, or has a row
            without a whole number of days.
        OSError: it is longer than ``MAX_BYTES``, or cannot be read.
    """
    data = read_file(path, MAX_BYTES)
    found = {}
    try:
        with StringIO(data.decode("utf-8-sig"), newline="") as file:
            reader = csv.DictReader(file, strict=True)
            missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
            if missing:
                raise ValueError(f"the column {missing[0]!r} is missing")
            for row in reader:
                days = row["days"] or ""
                if not (days.isdecimal() and len(days) < 5 and int(days) <= MAX_DAYS):
                    raise ValueError(
                        f"line {reader.line_num}: days is {days[:20]!r}; allowed: a whole number "
                        f"from 0 to {MAX_DAYS}"
                    )
                found[row["submission"]] = int(days)
    except (ValueError, csv.Error) as error:
        raise GradeError(f"{path}: it is no table of late submissions: {error}") from None
    return found
