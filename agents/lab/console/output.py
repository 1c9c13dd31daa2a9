"""Show a replay in a window, or write it to files."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from agents.lab.console.options import RECORD_SUFFIX
from agents.lab.console.terminal import say
from warehouse_core import Episode
from warehouse_core.files.atomic import atomic_path
from warehouse_core.records.plans import StepPlans
from warehouse_core.render.window import has_display
from warehouse_core.viz.player import save_page
from warehouse_core.viz.svg import animated_svg
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import Track

if TYPE_CHECKING:
    from warehouse_core.viz.figure import SceneFigure
    from warehouse_core.viz.replay import Replay

PAGE_SUFFIX, DRAWING_SUFFIX = ".html", ".svg"


@dataclass(frozen=True, slots=True)
class Film:
    """Replay that a command shows or saves.

    Windows, GIFs, videos and PNGs need Matplotlib; pages and SVG animations do not.

    Attributes:
        tracks: function that makes the tracks when they are needed.
        title: title of a page; "" makes one of the titles of the tracks.
        record: record that is saved as ``.npz``, or ``None``.
        speed: multiple of the default speed.
    """

    tracks: Callable[[], Sequence[Track]]
    title: str = ""
    record: Episode | None = None
    speed: float = 1.0

    def replay(self, window: bool) -> Replay:
        """Return the replay, with a window or without one."""
        from warehouse_core.viz.replay import replay_of_tracks

        return replay_of_tracks(*self.tracks(), speed=self.speed, window=window)

    def save(self, target: Path) -> None:
        """Write the record, a page or a picture, depending on the suffix.

        After an error there is no incomplete file.
        """
        suffix = target.suffix.lower()
        if suffix == RECORD_SUFFIX and self.record is not None:
            self.record.save(target)
        elif suffix == PAGE_SUFFIX:
            save_page(target, self.tracks(), title=self.title, speed=self.speed)
        elif suffix == DRAWING_SUFFIX:
            drawing = animated_svg(self.tracks(), title=self.title, speed=self.speed)
            with atomic_path(target) as part:
                part.write_text(drawing, encoding="utf-8")
        else:
            self.replay(window=False).save(target)
        say(f"saved {target}")


def replay_or_save(
    episode: Episode,
    targets: Sequence[Path],
    show: bool | None,
    speed: float = 1.0,
    plans: Sequence[StepPlans] = (),
    make_tracks: Callable[[], Sequence[Track]] | None = None,
) -> None:
    """Show an episode or save it, as ``show_or_save`` does; a ``.npz`` file has its record.

    Args:
        episode: record of the episode.
        targets: files to write.
        show: true to open a window; ``None`` opens one if there are no ``targets``.
        speed: multiple of the default speed.
        plans: plans of a fleet to draw.
        make_tracks: function that returns the tracks; by default the track of the record.
    """
    seed = "unseeded" if episode.seed is None else episode.seed
    name = re.sub(r"[^\w-]+", "_", f"replay-{episode.agent}-{episode.backend}-{seed}")
    # It takes minutes to draw each frame of a whole shift as a GIF, but not to write a page.
    suffix = PAGE_SUFFIX if episode.is_fleet else ".gif"
    film = Film(
        make_tracks or (lambda: [track_of_record(episode, plans=plans)]),
        record=episode,
        speed=speed,
    )
    show_or_save(film, targets, show, name + suffix)


def show_or_save(film: Film, targets: Sequence[Path], show: bool | None, fallback: str) -> None:
    """Write ``targets``, then open a window if ``show`` is true.

    If ``show`` is ``None``, a window opens if there are no targets. If there is neither a display
    nor a target, the replay is written to ``fallback``; if this file exists, its name gets a
    number.
    """
    for target in targets:
        film.save(target)
    if not (show or (show is None and not targets)):
        return
    if has_display():
        replay = film.replay(window=True)
        say("Space pauses, the left and right arrow keys step, and Q closes the window")
        replay.show()
        return
    consequence = "" if targets else ", so the replay is saved to a file"
    say(f"there is no display for a window{consequence}")
    if not targets:
        film.save(unused(Path(fallback)))


def save_picture(figure: SceneFigure, path: Path) -> None:
    """Write a figure as ``.svg`` or ``.png``; after an error there is no incomplete file."""
    from warehouse_core.viz.figure import save_svg

    with atomic_path(path) as part:
        if path.suffix.lower() == ".svg":
            save_svg(figure, part)
        else:
            figure.pixels().save(part, format="PNG")


def unused(path: Path) -> Path:
    """Return a path at which no file exists: ``path``, or ``path`` with a number."""
    number, first = 1, path
    while path.exists():
        number += 1
        path = first.with_stem(f"{first.stem}-{number}")
    return path
