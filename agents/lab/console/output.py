"""Show a replay or write it to files."""

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
    """What a command shows. A window or a picture needs Matplotlib, a page or an animation not.

    ``tracks`` makes the tracks when they are needed; their titles are the default of a page's.
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
        """Write the record, a page or a picture, by the suffix, whole or not at all."""
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
    """Show or save an episode as ``show_or_save`` does; ``.npz`` is its record.

    ``make_tracks`` returns the tracks to show, by default the one of the record with ``plans``.
    """
    seed = "unseeded" if episode.seed is None else episode.seed
    name = re.sub(r"[^\w-]+", "_", f"replay-{episode.agent}-{episode.backend}-{seed}")
    # Drawing each frame of a whole shift takes minutes; a page does not.
    suffix = PAGE_SUFFIX if episode.is_fleet else ".gif"
    film = Film(
        make_tracks or (lambda: [track_of_record(episode, plans=plans)]),
        record=episode,
        speed=speed,
    )
    show_or_save(film, targets, show, name + suffix)


def show_or_save(film: Film, targets: Sequence[Path], show: bool | None, fallback: str) -> None:
    """Write ``targets``, then open a window if ``show``, or if it is None and there are none.

    If no window can be opened and nothing was written, write the replay to ``fallback``, with a
    number if there is such a file.
    """
    for target in targets:
        film.save(target)
    if not (show or (show is None and not targets)):
        return
    if has_display():
        replay = film.replay(window=True)
        say("space pauses, left and right step, q closes the window")
        replay.show()
        return
    consequence = "" if targets else ", so the replay goes to a file"
    say(f"there is no display to open a window on{consequence}")
    if not targets:
        film.save(unused(Path(fallback)))


def save_picture(figure: SceneFigure, path: Path) -> None:
    """Write a figure as ``.svg`` or ``.png``, whole or not at all."""
    from warehouse_core.viz.figure import save_svg

    with atomic_path(path) as part:
        if path.suffix.lower() == ".svg":
            save_svg(figure, part)
        else:
            figure.pixels().save(part, format="PNG")


def unused(path: Path) -> Path:
    """Return a path to which nothing has been written: ``path``, or that with a number."""
    number, first = 1, path
    while path.exists():
        number += 1
        path = first.with_stem(f"{first.stem}-{number}")
    return path
