"""The text around maps: each function returns the text for a frame of a track and its font size."""

from __future__ import annotations

import math
import textwrap

from warehouse_core.viz.axes import POINTS
from warehouse_core.viz.tracks.track import Track
from warehouse_core.wording import counted, seconds_of

MAX_TALLY, BOLD_WIDTH = 15.0, 0.55
"""Largest font size of a tally, in points, and mean width of its letters as a share of the size."""

LETTER_WIDTH = 0.65
"""Mean width of a letter of a caption, as a share of its size."""

DASH = "\N{EN DASH}"
"""Text of a number that a track does not have."""

Words = tuple[str, float]


def title_of(size: float, track: Track, _frame: int) -> Words:
    """Return the title of a track."""
    return track.title, size


def counter_of(steps: int, track: Track, frame: int) -> Words:
    """Return the number of steps taken, out of ``steps``, and the clock of a continuous motion."""
    now = track.frames[frame]
    if track.marks is not None:
        return "", 9  # the captions of a search have its counts
    clock = f"   {seconds_of(now.clock, track.clock_digits)} s" if track.is_continuous else ""
    return f"step {math.ceil(now.progress)} of {steps}{clock}", 9


def ending_of(track: Track, frame: int) -> Words:
    """Return the ending of a track in its last frame, and no text in the others."""
    return track.ending.upper() if frame == len(track) - 1 else "", 11


def caption_of(size: float, width: float, track: Track, frame: int) -> Words:
    """Return the caption of a frame, wrapped to at most two lines of ``width`` inches."""
    letters = int(POINTS * width / (LETTER_WIDTH * size))
    words = track.frames[frame].caption
    return textwrap.fill(words, letters, max_lines=2, placeholder=" …"), size


def tally_of(width: float, has_bodies: bool, track: Track, frame: int) -> Words:
    """Return the deliveries, steps, seconds and joules so far; in the last frame also the ending.

    The grid has no seconds and joules of its own. It has dashes if other tracks have bodies.

    The font is as large as ``width``, in inches, allows, but at most ``MAX_TALLY``.
    """
    if track.marks is not None:
        return "", MAX_TALLY
    now, step = track.frames[frame], track.step_at(frame)
    numbers = [counted(math.ceil(now.progress), "step")]
    if track.counts_orders:
        numbers.insert(0, f"{track.metrics['delivered'][step]} delivered")
    if track.is_measured:
        numbers += [f"{seconds_of(now.clock)} s", f"{now.energy:,.0f} J"]
    elif has_bodies:
        numbers += [f"{DASH} s", f"{DASH} J"]
    words = ", ".join(numbers)
    is_over = frame == len(track) - 1
    if is_over and track.ending:
        words = f"{track.ending.capitalize()}: {words}"
    return words, min(MAX_TALLY, POINTS * width / (BOLD_WIDTH * len(words)))
