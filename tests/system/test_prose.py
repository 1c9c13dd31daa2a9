"""The check of descriptions, ``.ci/prose``."""

import subprocess
import sys
from pathlib import Path

CHECK = Path(__file__).parents[2] / ".ci" / "prose"

SOURCE = '''
COST = 2
"""Of a cell that somebody is in."""
WEIGHT = 3
"""Weight of the way; those of
others count too."""
NAMED = "no description"
print(NAMED)
"""Of a text that describes nothing."""


class Robot:
    """A robot.

    Attributes:
        cell: where it is.
        mass (float): Kilograms,
            of which the load is no part.
    """

    load: float
    """What it carries."""

    def go(self, way, *cells):
        """Go for a while.

        Args:
            way: Cells to enter.
            *cells: to avoid.

        To stop is not possible.

        Returns:
            In which cell it is,
            of those beside it, and
            whether it rests.
        """
'''


def test_descriptions_that_lean_on_a_name_are_listed(tmp_path: Path) -> None:
    file = tmp_path / "robots.py"
    file.write_text(SOURCE)
    command = [sys.executable, CHECK, tmp_path]
    *listed, _ = subprocess.run(command, capture_output=True, text=True).stdout.splitlines()
    assert listed == [
        f"{file}:3: Of a cell that somebody is in.",
        f"{file}:5: Weight of the way; those of",
        f"{file}:16: where it is.",
        f"{file}:22: What it carries.",
        f"{file}:29: to avoid.",
        f"{file}:34: In which cell it is,",
    ]
