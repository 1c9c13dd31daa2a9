"""Show a replay, or write it to files, as the options of a command ask for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import typer

from warehouse_core import Episode
from warehouse_core.files.atomic import check_target
from warehouse_core.viz.export import check_format
from warehouse_core.viz.replay import Replay
from warehouse_core.viz.track import INTERVAL_MS
from warehouse_core.warehouse_viz import replay_animation

RECORD_SUFFIX = ".npz"

MakeReplay = Callable[[bool | None], Replay | None]
"""Makes a replay with a window, without one, or with one wherever there is a display (None)."""


def check_targets(targets: Sequence[Path], also: Sequence[str] = (RECORD_SUFFIX,)) -> None:
    """Refuse files that cannot be written, before any work is done.

    Args:
        targets: files that are to be written.
        also: suffixes that are allowed beside those of pictures.

    Raises:
        FormatError: an unknown suffix.
        OSError: the folder does not exist.
    """
    for target in targets:
        check_format(target, also)
        check_target(target)


def replay_or_save(
    episode: Episode,
    targets: Sequence[Path],
    show: bool | None,
    interval_ms: float = INTERVAL_MS,
    speed: float = 1.0,
) -> None:
    """Do with an episode what ``show_or_save`` does; ``.npz`` is its record."""
    name = f"replay-{'unseeded' if episode.seed is None else episode.seed}.gif"
    show_or_save(_replay_of(episode, interval_ms, speed), targets, show, Path(name), episode)


def show_or_save(
    make_replay: MakeReplay,
    targets: Sequence[Path],
    show: bool | None,
    instead: Path,
    episode: Episode | None = None,
) -> None:
    """Write ``targets``, and open a window if asked for or if there is nothing to write.

    Where no window can be opened and nothing was written, the replay goes to ``instead``.
    """
    for target in targets:
        save(make_replay, target, episode)
    if not (show or (show is None and not targets)):
        return
    replay = make_replay(None)
    if replay is not None and replay.window:
        typer.echo("space pauses, left and right step, q closes the window")
        replay.show()
        return
    consequence = "" if targets else ", so the replay goes to a file"
    typer.echo(f"there is no display to open a window on{consequence}")
    if not targets:
        save(make_replay, instead, episode)


def save(make_replay: MakeReplay, target: Path, episode: Episode | None = None) -> None:
    """Write a replay in the format that the suffix of ``target`` names, and say so."""
    if episode is not None and target.suffix.lower() == RECORD_SUFFIX:
        episode.save(target)
    else:
        replay = make_replay(False)
        assert replay is not None, "matplotlib is installed with this package"
        replay.save(target)
    typer.echo(f"saved {target}")


def save_episode(
    episode: Episode, target: Path, interval_ms: float = INTERVAL_MS, speed: float = 1.0
) -> None:
    """Write an episode in the format that the suffix of ``target`` names, and say so."""
    save(_replay_of(episode, interval_ms, speed), target, episode)


def _replay_of(episode: Episode, interval_ms: float, speed: float) -> MakeReplay:
    return lambda window: replay_animation(episode, None, interval_ms, speed, window=window)
