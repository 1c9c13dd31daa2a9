"""The layout of a picture: one track with its charts next to it, or several tracks side by side.

All lengths are in inches, from the top left corner of the figure; font sizes are in points. The
functions at the end return the text around a map for a frame of its track, and its font size.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from warehouse_core.viz.axes import POINTS
from warehouse_core.viz.figure import DPI
from warehouse_core.viz.tracks.track import Track
from warehouse_core.wording import counted, seconds_of

MAX_CELL, SHARP = 1.05, 8
"""Largest side of a cell; side in pixels above which it is rounded to a whole number of pixels."""

BAR = 0.2
"""Height of a battery."""

GRID, FLEET_GRID = (6.4, 4.6), (9.0, 4.2)
"""Largest width and height of the map of a single track. The map of a fleet and its charts together
are as wide as ``WIDTH``, and the window fits on a screen with a height of 768 pixels."""

EDGE, HEAD, BAR_GAP, MIN_LEFT = 0.3, 1.0, 0.12, 4.8
"""Space around a single track, above its map and above its battery; least width of its text."""

CHARTS_LEFT, CHARTS_WIDTH, CHARTS_GAP, CHARTS_FOOT, LEGEND_WIDTH = 0.75, 3.3, 0.38, 0.5, 1.95
"""Space to the left of charts next to a map, their width, space between and below them, and the
width of the legend."""

MIN_CHART = 0.62
"""Least height of a chart next to a map."""

WIDTH, MARGIN, COLUMN_HEAD, GUTTER = 13.66, 0.4, 1.45, 0.5
"""Width of a figure of several tracks; space at its sides, above its maps and between columns."""

MAX_MAP, MAX_SMALL_MAP = 3.3, 2.3
"""Largest heights of maps in a single row, and in several rows."""

GAP, VERDICT, FOOT, LONG_FOOT = 0.1, 0.45, 0.6, 0.8
"""Space between a map and its battery; heights of the verdict below, of a legend, and of the longer
legend of fleets and bodies."""

BELOW = GAP + BAR + VERDICT

CHART, CHART_HEAD, CHART_FOOT, CHART_LEFT, CHART_RIGHT = 1.05, 0.3, 0.38, 0.4, 0.5
"""Height of a chart in a column, and the space around it."""

MAX_COLUMNS, ROW, CLOCK = 4, 3, 0.4
"""Most tracks in a single row; tracks per row if there are more; space for the clock at the top."""

LEGEND_COLUMNS = 7

MAX_TALLY, BOLD_WIDTH = 15.0, 0.55
"""Largest font size of a tally, in points, and mean width of its letters as a share of the size."""

LETTER_WIDTH = 0.65
"""Mean width of a letter of a caption, as a share of its size."""

DASH = "\N{EN DASH}"
"""Text of a number that a track does not have."""

BOLD = {"fontweight": "bold"}

Words = tuple[str, float]
"""A text and its font size."""

Box = tuple[float, float, float, float]
"""Left, top, width and height."""

SheetLine = tuple[float, float, Callable[[Track, int], Words], Mapping[str, Any]]
"""Left and top of a text, the function that returns it for a frame of a track, and its style."""


class TrackPlace(NamedTuple):
    """The position of a track on a sheet.

    Attributes:
        cell: side of a cell.
        map: box of the map.
        bar: box of the battery, if there is one.
        charts: boxes of the charts by title, from top to bottom.
        lines: lines of text around the map.
    """

    cell: float
    map: Box
    bar: Box | None
    charts: dict[str, Box]
    lines: list[SheetLine]


class Sheet(NamedTuple):
    """The layout of a picture, with the position of each track.

    Attributes:
        size: width and height of the figure.
        places: position of each track.
        legend_columns: columns of the legend along the bottom; 0 puts it along the right side.
        labels_last: true if only the last chart of a track has numbers on its time axis.
    """

    size: tuple[float, float]
    places: list[TrackPlace]
    legend_columns: int
    labels_last: bool


def sheet_of(
    tracks: Sequence[Track], titles: Sequence[Sequence[str]], steps: int, *, legend: bool
) -> Sheet:
    """Return the layout of a picture of tracks.

    More than ``MAX_COLUMNS`` tracks are arranged in several rows, without charts.

    Args:
        tracks: tracks to show.
        titles: titles of the charts of each track.
        steps: final number of steps of a single track.
        legend: leave space for the legend of a single track; several tracks always have one.
    """
    if len(tracks) == 1:
        return _single(tracks[0], titles[0], steps, legend=legend)
    in_rows = len(tracks) > MAX_COLUMNS
    count, most = (ROW, MAX_SMALL_MAP) if in_rows else (len(tracks), MAX_MAP)
    shown = [] if in_rows else [*max(titles, key=len)]
    if not any(track.counts_orders for track in tracks):
        shown = [*dict.fromkeys([*shown[:1], *shown[-1:]])]  # there is room for one row
    width = (WIDTH - (count - 1) * GUTTER - 2 * MARGIN) / count
    places: list[TrackPlace] = []
    top = bottom = 0.0
    for first in range(0, len(tracks), count):
        row = tracks[first : first + count]
        cell = min(_cell(track, width, most) for track in row)
        below = top + COLUMN_HEAD + cell * max(track.shown_size[1] for track in row)
        for number, track in enumerate(row):
            left = MARGIN + number * (width + GUTTER)
            charts = {
                title: _chart_box(left, below + BELOW, width, index)
                for index, title in enumerate(shown)
                if title in titles[first + number]
            }
            tally = partial(tally_of, width, any(each.is_measured for each in tracks))
            places.append(_column(track, cell, left, top, below, width, charts, tally))
        bottom, top = below + BELOW, below + BELOW - CLOCK
    for _, chart_top, _, height in (box for place in places for box in place.charts.values()):
        bottom = max(bottom, chart_top + height + CHART_FOOT)
    is_long = any(track.is_fleet or track.is_continuous for track in tracks)
    foot = LONG_FOOT if is_long else FOOT
    return Sheet((WIDTH, bottom + foot), places, LEGEND_COLUMNS, labels_last=False)


def _single(track: Track, titles: Sequence[str], steps: int, *, legend: bool) -> Sheet:
    """Return the layout of a map with its battery below, and its charts and legend next to it."""
    cell = _cell(track, *(FLEET_GRID if track.is_fleet else GRID))
    map_width, map_height = (cell * cells for cells in track.shown_size)
    least = len(titles) * (MIN_CHART + CHARTS_GAP) - CHARTS_GAP
    left_width, height = max(map_width, MIN_LEFT), max(map_height, least)
    map_box = (
        EDGE + (left_width - map_width) / 2, HEAD + (height - map_height) / 2, map_width, map_height
    )  # fmt: skip
    chart = (height + CHARTS_GAP) / max(len(titles), 1) - CHARTS_GAP
    charts_left = EDGE + left_width + CHARTS_LEFT
    charts = {
        title: (charts_left, HEAD + number * (chart + CHARTS_GAP), CHARTS_WIDTH, chart)
        for number, title in enumerate(titles)
    }
    has_battery = "battery" in track.metrics
    bar = (EDGE, map_box[1] + map_height + BAR_GAP, left_width, BAR) if has_battery else None
    # Without a battery, the labels of the charts are the lowest part.
    foot = EDGE if has_battery or not legend else CHARTS_FOOT
    # The legend of a fleet with charts is below the map, where there is space.
    is_below = legend and track.is_fleet and bool(titles)
    right = EDGE + left_width + (CHARTS_LEFT + CHARTS_WIDTH if titles else 0.0)
    width = right + EDGE + (LEGEND_WIDTH if legend and not is_below else 0.0)
    lines: list[SheetLine] = [
        (EDGE, 0.2, partial(title_of, 9), {}),
        (width - EDGE, 0.2, partial(counter_of, steps), {"ha": "right"}),
        (EDGE, 0.56, partial(caption_of, 16, width - 2 * EDGE), BOLD),
        (width / 2, 0.2, ending_of, BOLD | {"ha": "center"}),
    ]
    foot += LONG_FOOT if is_below else 0.0
    size = (width, HEAD + height + (BAR + BAR_GAP if has_battery else 0.0) + foot)
    columns = LEGEND_COLUMNS if is_below else 0
    place = TrackPlace(cell, map_box, bar, charts, lines)
    return Sheet(size, [place], columns, labels_last=True)


def _column(
    track: Track,
    cell: float,
    left: float,
    top: float,
    below: float,
    width: float,
    charts: dict[str, Box],
    tally: Callable[[Track, int], Words],
) -> TrackPlace:
    """Return the position of a track in a column; its map ends at the height ``below``."""
    columns, rows = track.shown_size
    map_box = (left, top + COLUMN_HEAD, cell * columns, cell * rows)
    bar = (left, below + GAP, map_box[2], BAR) if "battery" in track.metrics else None
    lines: list[SheetLine] = [
        (left, top + 0.62, partial(title_of, 11), {}),
        (left, top + 0.77, partial(caption_of, 13, width), BOLD | {"va": "top"}),
        (left, below + BELOW - VERDICT / 2, tally, BOLD),
    ]
    return TrackPlace(cell, map_box, bar, charts, lines)


def _chart_box(left: float, top: float, width: float, number: int) -> Box:
    """Return the box of a chart in a column, which has two charts next to each other."""
    left += number % 2 * width / 2 + CHART_LEFT
    top += CHART_HEAD + number // 2 * (CHART_HEAD + CHART + CHART_FOOT)
    return left, top, width / 2 - CHART_LEFT - CHART_RIGHT, CHART


def _cell(track: Track, width: float, height: float) -> float:
    """Return the largest side of a cell for which the map fits into a width and a height.

    Unless cells are tiny, the side is a whole number of pixels, which keeps tiles sharp.
    """
    columns, rows = track.shown_size
    cell = min(width / columns, height / rows, MAX_CELL)
    return math.floor(cell * DPI) / DPI if cell * DPI > SHARP else cell


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
