"""Animated drawings of tracks, for pages that allow no scripts, such as a README.

A drawing looks like the player and follows the reader's colour scheme. For readers who prefer
reduced motion, it shows a still picture.
"""

from __future__ import annotations

import html
import re
import textwrap
from collections.abc import Iterator, Sequence
from string import Template

from warehouse_core.arguments import instance_of, real_number
from warehouse_core.errors import FormatError
from warehouse_core.render.palette import LOOK, PALETTE
from warehouse_core.viz.svg.beat import Beat, spans_of
from warehouse_core.viz.svg.bodies import arrow_heads, bodies_of
from warehouse_core.viz.svg.floor import UNIT, ends_of, floor_of, textures
from warehouse_core.viz.tracks.timeline import Timeline
from warehouse_core.viz.tracks.track import (
    CONTINUOUS_FRAMES,
    INTERVAL_MS,
    MAX_PACE,
    MIN_PACE,
    Track,
)
from warehouse_core.wording import printable, seconds_of

MAX_SVG_BYTES = 2_000_000
"""Size of the largest drawing. A page can play longer replays, and can jump to any moment."""

REST_SECONDS = 2.0
"""Seconds for which the end is shown before the drawing starts again."""

MAX_WIDTH, MAX_HEIGHT, MAX_CELL, MIN_WIDTH = 960, 640, 48, 420
"""Largest width and height of a floor, largest side of a cell, and least width of the text around a
floor, in pixels."""

EDGE, HEAD, FOOT, GAP, MAX_ROW = 16, 76, 34, 28, 1100
"""Space around the floors, above them for text, below them for batteries, and between them; largest
width of a row of floors."""

MANY, MANY_ROW = 5, 3 * MIN_WIDTH + 2 * GAP
"""Number of floors from which on each is only as wide as its text; largest width of three such."""

LETTER, BOLD_LETTER = 0.54, 0.6
"""Mean width of a letter in small text and in captions, as a share of the font size."""

CAPTION, SMALL = 17, 13
"""Font sizes in pixels."""

BAR = 130
"""Width of the bar of a full battery, in pixels."""

LOW_BATTERY = 0.2
"""Share of a full battery below which its bar has the colour of a warning."""

SHAPES = Template("""
text{font-family:system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans",sans-serif;font-weight:700}
text{text-anchor:middle}.words{text-anchor:start}.count{text-anchor:end}.small{font-weight:400}
text.of-dark{paint-order:stroke;stroke-width:${letter}em;stroke-linejoin:round}.of-rim{stroke-width:4}.shadow{fill-rule:evenodd}.wall,.shelf{shape-rendering:crispEdges}.visited{opacity:.12}
.trail,.plan{fill:none;stroke-width:$trail;stroke-linecap:round;stroke-linejoin:round;opacity:.55}
.ghost{fill:none;stroke-width:4;stroke-dasharray:12 8}
.plan{opacity:1;stroke-width:$plan}.skid{opacity:.5}
.dots{stroke-width:$wish;stroke-dasharray:1 33}
[class^=of-]{fill:none}
.rests{display:none}
@media (prefers-reduced-motion:reduce){.moves{display:none}.rests{display:inline}}
""").substitute(
    {name: f"{UNIT * width:g}" for name, width in LOOK["lines"].items()}
    | {"letter": 2 * LOOK["lines"]["letter"]}
)


def animated_svg(tracks: Sequence[Track], *, title: str = "", speed: float = 1.0) -> str:
    """Return an animated drawing that plays one or more tracks, side by side, in an endless loop.

    Args:
        tracks: tracks, at least one; see ``Timeline``.
        title: title of the drawing; by default the titles of the tracks.
        speed: factor on the playing speed.

    Raises:
        FormatError: the drawing would have more than ``MAX_SVG_BYTES``.
        ValueError: ``speed`` is not within ``MIN_PACE`` and ``MAX_PACE``.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> from warehouse_core.viz.svg import MAX_SVG_BYTES, animated_svg
        >>> from warehouse_core.viz.tracks import track_of_record
        >>> episode = record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)
        >>> len(animated_svg([track_of_record(episode)])) < MAX_SVG_BYTES
        True
    """
    speed = real_number("speed", speed, MIN_PACE, MAX_PACE)
    timeline = Timeline(tracks)
    is_continuous = any(track.is_continuous for track in tracks)
    seconds = INTERVAL_MS / 1000 / speed / (CONTINUOUS_FRAMES if is_continuous else 1)
    moments, still = range(len(timeline.moments)), timeline.still
    most, row = (MIN_WIDTH, MANY_ROW) if len(tracks) >= MANY else (MAX_WIDTH, MAX_ROW)
    sizes = [_size_of(track, most) for track in tracks]
    across, down = (max(size[axis] for size in sizes) for axis in (0, 1))
    columns = max(min(len(tracks), int((row + GAP) / (across + GAP))), 1)
    steps = across + GAP, HEAD + down + FOOT
    corners = [
        (EDGE + steps[0] * (place % columns), steps[1] * (place // columns))
        for place in range(len(tracks))
    ]
    width, height = corners[columns - 1][0] + across + EDGE, corners[-1][1] + steps[1] + EDGE
    title = printable(
        instance_of("title", title, str)
        or " / ".join(filter(None, (t.title for t in tracks)))
        or "Replay"
    )
    parts: list[str] = []
    room = MAX_SVG_BYTES
    for look, shown_moments in (("moves", moments), ("rests", range(still, still + 1))):
        beat = Beat(len(shown_moments), round(REST_SECONDS / seconds), seconds)
        parts.append(f'<g class="{look}">')
        for part in _panels(tracks, timeline, shown_moments, beat, corners, most):
            parts.append(part)
            room -= len(part)
            if room < 0:
                raise FormatError(
                    f"the animation has more than MAX_SVG_BYTES = {MAX_SVG_BYTES:,} bytes: it has "
                    f"{len(moments):,} frames; save the replay as .html, or as one picture"
                )
        parts.append("</g>")
    body = "".join(parts)
    heads = arrow_heads() if "marker-end" in body else ""
    body, box = heads + textures(body) + body, f'width="{width:g}" height="{height:g}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" {box} '
        f'font-size="{SMALL}" role="img"><title>{html.escape(title)}</title>'
        f'<style>{_style_of(body)}</style><rect {box} class="paper"/>{body}</svg>\n'
    )


def _size_of(track: Track, most: float) -> tuple[float, float, float]:
    """Return the width and height of a floor, and the side of a cell, in pixels.

    The floor is at most ``most`` wide; the width includes the text around it.
    """
    columns, rows = track.shown_size
    cell = min(MAX_CELL, most / columns, MAX_HEIGHT / rows)
    return max(round(cell * columns), MIN_WIDTH), round(cell * rows), cell


def _panels(
    tracks: Sequence[Track],
    timeline: Timeline,
    moments: Sequence[int],
    beat: Beat,
    corners: Sequence[tuple[float, float]],
    most: float,
) -> Iterator[str]:
    """Yield each track with its text; ``corners`` has top left corners, ``most`` is a width."""
    frames_of = zip(*map(timeline.frames_at, moments), strict=True)
    for place, (track, numbers) in enumerate(zip(tracks, frames_of, strict=True)):
        wide, high, cell = _size_of(track, most)
        (left, top), frames = corners[place], [track.frames[number] for number in numbers]
        columns, rows = track.shown_size
        outer, scale = UNIT * track.outer, cell / UNIT
        name = f"floor-{beat.frames}-{place}"
        shape = f'x="{outer:g}" y="{outer:g}" width="{UNIT * columns:g}" height="{UNIT * rows:g}"'
        yield f'<clipPath id="{name}"><rect {shape}/></clipPath>'
        move = f"translate({-scale * outer:g} {HEAD - scale * outer:g}) scale({scale:.5g})"
        # A nested drawing would have a clock of its own.
        yield f'<g transform="translate({left:g} {top:g})"><g transform="{move}" '
        yield f'clip-path="url(#{name})">'
        beat = beat._replace(glides=track.is_continuous)
        yield from floor_of(track, frames, beat, cell)
        yield from bodies_of(track, numbers, beat, cell)
        yield from ends_of(track)
        yield "</g>"
        yield from _words(track, numbers, beat, wide, HEAD + high + 19)
        if "battery" in track.metrics:
            yield from _battery(track, numbers, beat, HEAD + high + 8)
        yield "</g>"


def _words(
    track: Track, numbers: Sequence[int], beat: Beat, width: float, foot: float
) -> Iterator[str]:
    """Yield the title of a track, its counter and captions, and below the floor its ending."""
    frames = [track.frames[number] for number in numbers]
    steps = track.steps
    counter = [f"step {frame.progress:.0f} of {steps}" for frame in frames]
    if track.is_continuous:
        counter = [f"{seconds_of(frame.clock, track.clock_digits)} s" for frame in frames]
    room = width - LETTER * SMALL * (max(map(len, counter)) + 2)
    title = textwrap.shorten(track.title, max(int(room / LETTER / SMALL), 8), placeholder="…")
    yield f'<text x="0" y="22" class="words small quiet">{html.escape(printable(title))}</text>'
    at = f'x="{width:g}" y="22" class="count small quiet"'
    yield from beat.each(counter, lambda words: f"<text {at}>{words}</text>")
    letters = int(width / BOLD_LETTER / CAPTION)

    def draw_caption(caption: str) -> str:
        lines = textwrap.wrap(printable(caption), letters, max_lines=2, placeholder=" …")
        rows = "".join(
            f'<tspan x="0" dy="{19 * bool(number)}">{html.escape(line)}</tspan>'
            for number, line in enumerate(lines)
        )
        return rows and f'<text y="46" font-size="{CAPTION}" class="words ink">{rows}</text>'

    yield from beat.each((frame.caption for frame in frames), draw_caption)
    ended = spans_of(number == len(track) - 1 for number in numbers).get(True, [])
    if track.ending and ended:
        place = f'x="{width:g}" y="{foot:g}" class="count ink"'
        yield beat.shown(f"<text {place}>{html.escape(track.ending.upper())}</text>", ended)


def _battery(track: Track, numbers: Sequence[int], beat: Beat, top: float) -> Iterator[str]:
    """Yield the bar of a battery, and its level as text."""
    levels = [track.metrics["battery"][track.step_at(number)] for number in numbers]
    levels = [0.0 if level != level else level for level in levels]  # NaN means unknown
    full = track.full_battery
    lengths = [round(BAR * min(level / full, 1)) for level in levels]
    width, animation = beat.growing("width", lengths)
    bar = f'<rect x="0" y="{top:g}" height="12" {width} class="{{look}}">{animation}</rect>'
    yield f'<rect x="0" y="{top:g}" width="{BAR}" height="12" class="shade of-ink"/>'
    for is_low, spans in spans_of(level < LOW_BATTERY * full for level in levels).items():
        yield beat.shown(bar.format(look="warning" if is_low else "battery"), spans)
    text = f'<text x="{BAR + 10}" y="{top + 11:g}" class="words small ink">battery '
    yield from beat.each(levels, lambda level: f"{text}{level:.10g} of {full:.10g}</text>")


def _style_of(body: str) -> str:
    """Return the style rules of the classes in a drawing, without custom properties.

    The class ``ink`` fills a shape with the colour of this name; ``of-ink`` draws its lines in it.
    """
    classes = {name for names in re.findall(r'class="([^"]*)"', body) for name in names.split()}
    classes.add("paper")

    def rules(colors: dict[str, str]) -> str:
        fills = [f".{name}{{fill:{color}}}" for name, color in colors.items() if name in classes]
        lines = {f"of-{name}": color for name, color in colors.items()}
        strokes = [f".{name}{{stroke:{color}}}" for name, color in lines.items() if name in classes]
        return "".join(fills + strokes)

    light, dark = PALETTE["light"] | PALETTE["both"], PALETTE["dark"]
    colors = f"{rules(light)}@media (prefers-color-scheme:dark){{{rules(dark)}}}"
    return f"{colors}{SHAPES.strip()}"
