"""Rows of continuous control on a large empty floor, for tests of drives."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from warehouse_core import Layout
from warehouse_physics import Disturbances, RobotSpec
from warehouse_physics.drive.rows import DriveRows, settings_of

WIDE = Layout(["#" * 60, *["#" + "." * 58 + "#"] * 58, "#" * 60])
"""A floor on which a robot in the middle meets no wall for half a minute."""


def rows_on(
    layout: Layout = WIDE,
    spec: RobotSpec | None = None,
    control: str = "velocity",
    rows: int = 1,
    *,
    disturbances: Disturbances | None = None,
    finer: int = 1,
    start: tuple[int, int] = (30, 30),
    **others: Any,
) -> DriveRows:
    """Return rows that have begun in ``start``, with substeps that are ``finer`` times as short."""
    given = {"rays": 0, "randomize": False, "max_seconds": 1e6, "battery": 1e9} | others
    settings = settings_of(
        layout, control, spec or RobotSpec(), disturbances or Disturbances(), 10.0,
        start_pos=start, **given,
    )  # fmt: skip
    spec = replace(settings.spec, time_step=settings.spec.time_step / finer)
    settings = replace(settings, spec=spec, substeps=settings.substeps * finer)
    made = DriveRows(settings, rows)
    made.begin(range(rows), range(rows))
    return made
