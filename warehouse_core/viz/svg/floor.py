"""The floor of an animated drawing: tiles, cells not seen yet, and the marks of a search.

All lengths are in hundredths of a cell.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from itertools import pairwise

from warehouse_core.render.atlas import STATIONS, UNSEEN
from warehouse_core.render.palette import LOOK, hex_color
from warehouse_core.viz.svg.beat import Beat, Span
from warehouse_core.viz.tracks.track import Frame, TileRows, Track, cells_of
from warehouse_core.world.tiles import WALL, Cell, runs_of

UNIT = 100
"""Length of the side of a cell."""

MAX_LINED_COLUMNS = 40
"""Columns of the widest floor with lines between its cells."""

MIN_LETTER = 16
"""Least side of a cell, in pixels, for letters and for the boards of shelves."""

MIN_TEXT = 12
"""Least size of a letter in pixels, because pictures are often shown a little smaller."""


def box(left: float, top: float, wide: float, high: float, look: str) -> str:
    """Return a rectangle with the style class ``look``, in hundredths of a cell."""
    place = f'x="{left:g}" y="{top:g}" width="{wide:g}" height="{high:g}"'
    return f'<rect {place} class="{look}"/>'


def shape(name: str, look: str, others: str = "") -> str:
    """Return a shape of ``tiles.json`` around the origin, with the style classes ``look``."""
    return polygon(LOOK["shapes"][name], look, others)


def polygon(corners: Sequence[Sequence[float]], look: str, others: str = "") -> str:
    """Return a polygon whose corners are in cells, with the style classes ``look``."""
    points = " ".join(f"{UNIT * x:g},{UNIT * y:g}" for x, y in corners)
    return f'<polygon points="{points}" class="{look}"{f" {others}" if others else ""}/>'


def floor_of(track: Track, frames: Sequence[Frame], beat: Beat, pixels: float) -> Iterator[str]:
    """Yield the floor in some frames of a track; ``pixels`` is the side of a cell."""
    rows, height, width = frames[0].tiles, len(frames[0].tiles), len(frames[0].tiles[0])
    yield box(0, 0, UNIT * width, UNIT * height, "floor")
    if width <= MAX_LINED_COLUMNS:
        lines = [f"M{UNIT * x} 0V{UNIT * height}" for x in range(1, width)]
        lines += [f"M0 {UNIT * y}H{UNIT * width}" for y in range(1, height)]
        yield f'<path d="{"".join(lines)}" class="of-line" stroke-width="2"/>'
    wet = [(row, col) for row, col in track.slippery if rows[row][col] != WALL]
    yield from (box(UNIT * col, UNIT * row, UNIT, UNIT, "ice") for row, col in wet)
    yield from _texture("ice", wet)
    all_tiles = [frame.tiles for frame in frames]
    yield from beat.each(_known(all_tiles), lambda tiles: "".join(_tiles(tiles, pixels)))
    hidden = {tiles: cells_of(UNSEEN, tiles) for tiles in dict.fromkeys(all_tiles)}
    unseen = ([square(cell, 0) for cell in hidden[tiles]] for tiles in all_tiles)
    yield from beat.all_of(unseen, '<path d="{}" class="unseen"/>')
    yield from _marks(track, frames, beat)
    if track.outer:
        edge, right, bottom = UNIT * track.outer, UNIT * width, UNIT * height
        yield box(0, 0, right, edge, "paper") + box(0, bottom - edge, right, edge, "paper")
        yield box(0, 0, edge, bottom, "paper") + box(right - edge, 0, edge, bottom, "paper")


def textures(drawn: str) -> str:
    """Return the definitions of the textures to which a drawing refers."""
    groups = ""
    for name, looks in LOOK["textures"].items():
        if f'"#{name}"' in drawn:
            parts = (polygon(each, look) for look, polygons in looks.items() for each in polygons)
            groups += f'<g id="{name}">{"".join(parts)}</g>'
    return f"<defs>{groups}</defs>" if groups else ""


def _texture(name: str, cells: Sequence[Cell]) -> Iterator[str]:
    """Yield references to a texture, one for each cell."""
    for row, col in cells:
        yield f'<use href="#{name}" x="{UNIT * col}" y="{UNIT * row}"/>'


def _tiles(rows: TileRows, pixels: float) -> Iterator[str]:
    """Yield walls, shelves and stations."""
    width = len(rows[0])
    for row, line in enumerate(rows):
        for left, right in runs_of(WALL, line):
            yield box(UNIT * left, UNIT * row, UNIT * (right - left), UNIT, "wall")
    shelves: list[Cell] = []
    for row, line in enumerate(rows[1:-1], start=1):
        for left, right in runs_of(WALL, line):
            left, right = max(left, 1), min(right, width - 1)
            if left < right:
                yield box(UNIT * left, UNIT * row, UNIT * (right - left), UNIT, "shelf")
                shelves += [(row, col) for col in range(left, right)]
    if pixels >= MIN_LETTER:
        yield from _texture("shelf", shelves)
    station = LOOK["station"]
    inset, side = UNIT * station["inset"], UNIT * (1 - 2 * station["inset"])
    size = UNIT * max(station["letter"], MIN_TEXT / pixels)
    for row, line in enumerate(rows):
        for col, tile in enumerate(line):
            if tile in STATIONS:
                name = LOOK["words"][tile]
                yield box(UNIT * col + inset, UNIT * row + inset, side, side, name)
                if pixels >= MIN_LETTER:
                    x = UNIT * (col + station["corner"]) + 0.36 * size
                    y = UNIT * (row + station["corner"]) + 0.8 * size
                    text = f'<text x="{x:.0f}" y="{y:.0f}" font-size="{size:.0f}"'
                    yield f'{text} class="light of-dark">{tile}</text>'


def _known(tiles: Sequence[TileRows]) -> list[TileRows]:
    """Return the tiles of each frame, filling cells not seen yet with their later tiles."""
    known: list[TileRows] = []
    later = before = tiles[-1]
    for rows in reversed(tiles):
        if rows is not before:
            before = rows
            later = tuple(map(_filled, rows, later))
        known.append(later)
    return known[::-1]


def _filled(line: str, later: str) -> str:
    """Return a row of tiles, with the tiles of ``later`` in cells that were not seen."""
    return "".join(map(lambda now, then: then if now == UNSEEN else now, line, later))


def square(cell: Cell, inset: float) -> str:
    """Return the outline of a cell without a margin on all sides, as part of a path."""
    (row, col), side = cell, UNIT * (1 - 2 * inset)
    start = f"M{UNIT * (col + inset):g} {UNIT * (row + inset):g}"
    return f"{start}h{side:g}v{side:g}h-{side:g}z"


def _marks(track: Track, frames: Sequence[Frame], beat: Beat) -> Iterator[str]:
    """Yield the cells that a search marks, each shown in its colours at the right times."""
    marks = track.marks
    if marks is None:
        return
    clocks, inset = [frame.clock for frame in frames], LOOK["mark"]["inset"]
    changes: dict[Cell, list[tuple[int, int]]] = {}
    for time, cell, value in zip(marks.times, marks.cells, marks.values, strict=True):
        changes.setdefault(cell, []).append((bisect_left(clocks, time), value))
    squares: dict[tuple[int, Span], list[str]] = {}
    for cell, changed in changes.items():
        for (first, value), (end, _) in pairwise([*changed, (beat.frames, 0)]):
            if first < end:
                squares.setdefault((value, (first, end)), []).append(square(cell, inset))
    for (value, span), parts in squares.items():
        look = f'fill="{hex_color(marks.colors[value])}"'
        yield beat.shown(f'<path d="{"".join(parts)}" {look}/>', [span])


def ends_of(track: Track) -> Iterator[str]:
    """Yield the start and the goal of a search, as letters on discs."""
    if track.marks is not None:
        for letter, (row, col) in zip("SG", track.marks.ends, strict=True):
            x, y = UNIT * col + UNIT // 2, UNIT * row + UNIT // 2
            radius, size = (UNIT * LOOK["end"][name] for name in ("radius", "letter"))
            yield f'<circle cx="{x}" cy="{y}" r="{radius:g}" class="light of-rim"/>'
            text = f'<text x="{x}" y="{y + 0.35 * size:.0f}" font-size="{size:g}"'
            yield f'{text} class="dark">{letter}</text>'
