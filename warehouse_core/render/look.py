"""The look of everything that is on a floor: its geometry, its letters and its words.

All painters read ``tiles.json``: pixels, the window and the animated drawings in Python, and the
pages in JavaScript. Colours are in ``palette.json``. Lengths are shares of a cell, and these are
shares of the radius of a robot: the sizes of its letter, nose, order and battery, and how far the
corners of a person are from the middle. Sizes of letters are sizes of a font, whose capitals are
``capital`` times as high; ``outline`` is the width of the line around a letter, as a share of its
size. An ``item`` has a strip of ``tape`` down from its top edge, as a share of its side. Fleets of
more than ``few`` robots show only the batteries that are ``low``, as a share of a full one. Floors
of more than ``lined`` columns have no lines between cells.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

LOOK: Mapping[str, Any] = json.loads(
    Path(__file__).with_name("tiles.json").read_text(encoding="utf-8")
)
"""Contents of ``tiles.json``."""

WORDS: Mapping[str, Any] = LOOK["words"]
"""What a legend says of each sign, by name; ``orders`` are the ages of orders."""

LETTERS: Mapping[str, str] = LOOK["letters"]
"""Letters of stations and bodies, by name."""


def signed(name: str) -> str:
    """Return the words of a sign with its letter, if it has one.

    Example:
        >>> from warehouse_core.render.look import signed
        >>> signed("pickup"), signed("wall")
        ('P pickup', 'wall')
    """
    return f"{LETTERS[name]} {WORDS[name]}" if name in LETTERS else WORDS[name]
