"""The clock of an animated drawing, and elements that move, turn, grow or appear.

Animations are written in SMIL, which needs no script. Elements that never change have none. A
*span* is a range of frames: the first frame, and the frame after the last one.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple, TypeVar

Numbers = Sequence[tuple[int, ...]]
Span = tuple[int, int]
Key = TypeVar("Key", bound=Hashable)


class Beat(NamedTuple):
    """The clock of an animation that is repeated.

    Values glide from frame to frame for bodies, and jump for robots on the grid.

    Attributes:
        frames: number of frames.
        rest: number of frames for which the last one stays before the animation starts again.
        seconds: seconds of each frame.
        glides: true if values glide from frame to frame, false if they jump.
    """

    frames: int
    rest: int
    seconds: float
    glides: bool = True

    def moving(self, inner: str, places: Numbers) -> str:
        """Return a group with a position in each frame."""
        return self._transformed("translate", inner, places)

    def turning(self, inner: str, degrees: Sequence[int]) -> str:
        """Return a group with an angle in each frame."""
        return self._transformed("rotate", inner, [(angle,) for angle in degrees])

    def growing(self, name: str, values: Sequence[int]) -> tuple[str, str]:
        """Return an attribute with its first value, and the element that animates it."""
        numbers = [(value,) for value in values]
        return f'{name}="{values[0]}"', self._animation("animate", name, numbers)

    def shown(self, inner: str, spans: Sequence[Span]) -> str:
        """Return an element that is shown in some spans, given in order, and hidden otherwise."""
        if [*spans] == [(0, self.frames)]:
            return inner
        changes = [change for span in spans for change in zip(span, (1, 0), strict=True)]
        changes = [(frame, value) for frame, value in changes if frame < self.frames]
        if not changes:
            return ""
        if changes[0][0] > 0:
            changes.insert(0, (0, 0))
        values = ";".join(str(value) for _, value in changes)
        times = self._times(frame for frame, _ in changes)
        return (
            f'<g opacity="{changes[0][1]}"><animate attributeName="opacity" calcMode="discrete" '
            f'values="{values}" keyTimes="{times}" {self._timing}/>{inner}</g>'
        )

    def shown_from(self, inner: str, first: int) -> str:
        """Return an element that is shown from a frame on."""
        return self.shown(inner, [(first, self.frames)])

    def each(self, keys: Iterable[Key], draw: Callable[[Key], str]) -> Iterator[str]:
        """Yield the drawing of each key, shown in the frames that have this key."""
        for key, spans in spans_of(keys).items():
            if drawn := draw(key):
                yield self.shown(drawn, spans)

    def all_of(self, drawings: Iterable[Iterable[str]], around: str = "{}") -> Iterator[str]:
        """Yield the parts that are drawn in each frame, grouped by the spans that show them.

        The parts of a group are one text, for which ``around`` has a place.
        """
        found: dict[str, list[Span]] = {}
        for number, parts in enumerate(drawings):
            for part in dict.fromkeys(parts):
                extend(found.setdefault(part, []), number, number + 1)
        groups: dict[tuple[Span, ...], list[str]] = {}
        for part, spans in found.items():
            groups.setdefault(tuple(spans), []).append(part)
        for shown, parts in groups.items():
            yield self.shown(around.format("".join(parts)), shown)

    @property
    def _timing(self) -> str:
        """Attributes of every animation: the duration of a round, and the repetition."""
        seconds = (self.frames + self.rest) * self.seconds
        return f'dur="{seconds:.5g}s" repeatCount="indefinite"'

    def _times(self, frames: Iterable[int]) -> str:
        """Return the start of each frame, as a share of a round."""
        whole = self.frames + self.rest
        digits = len(str(whole)) + 2
        return ";".join(
            f"{frame / whole:.{digits}f}".strip("0").rstrip(".") or "0" for frame in frames
        )

    def _transformed(self, kind: str, inner: str, numbers: Numbers) -> str:
        start = " ".join(map(str, numbers[0]))
        extra = f'type="{kind}" '
        animation = self._animation("animateTransform", "transform", numbers, extra)
        return f'<g transform="{kind}({start})">{animation}{inner}</g>'

    def _animation(self, element: str, name: str, numbers: Numbers, extra: str = "") -> str:
        """Return the element that animates an attribute, without the frames that are redundant."""
        if all(each == numbers[0] for each in numbers):
            return ""
        kept = [*(_corners(numbers) if self.glides else _changes(numbers))]
        values = [",".join(map(str, numbers[frame])) for frame in kept]
        if self.glides:  # such animations must have a value at the end of the round
            kept, values = [*kept, self.frames + self.rest], [*values, values[-1]]
        mode = "" if self.glides else 'calcMode="discrete" '
        return (
            f'<{element} attributeName="{name}" {extra}{mode}values="{";".join(values)}" '
            f'keyTimes="{self._times(kept)}" {self._timing}/>'
        )


def spans_of(keys: Iterable[Key]) -> dict[Key, list[Span]]:
    """Return the spans in which each key occurs; ``keys`` has one key for each frame."""
    found: dict[Key, list[Span]] = {}
    first = 0
    for key, same in groupby(keys):
        end = first + sum(1 for _ in same)
        found.setdefault(key, []).append((first, end))
        first = end
    return found


def extend(spans: list[Span], first: int, end: int) -> None:
    """Add a span to earlier ones, and merge it with the last one if they touch."""
    if spans and spans[-1][1] == first:
        first, _ = spans.pop()
    spans.append((first, end))


def _changes(numbers: Numbers) -> Iterator[int]:
    """Yield the first frame, and each frame whose numbers differ from the previous frame."""
    return (frame for frame, each in enumerate(numbers) if frame == 0 or each != numbers[frame - 1])


def _corners(numbers: Numbers) -> Iterator[int]:
    """Yield the first and last frame, and each frame that interpolation would not reproduce."""
    last = len(numbers) - 1
    yield 0
    for frame in range(1, last):
        around = zip(numbers[frame - 1], numbers[frame], numbers[frame + 1], strict=True)
        if any(after - now != now - before for before, now, after in around):
            yield frame
    yield last
