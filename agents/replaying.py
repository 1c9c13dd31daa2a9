"""Show a recorded episode, or write it to files, as the options of a command ask for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import typer

from warehouse_core import Episode
from warehouse_core.atomic_file import check_target
from warehouse_core.export import check_format
from warehouse_core.replay import Replay
from warehouse_core.warehouse_viz import replay_animation

RECORD_SUFFIX = ".npz"


def check_targets(targets: Sequence[Path]) -> None:
    """Refuse files that cannot be written, before any work is done.

    Raises:
        FormatError: an unknown suffix.
        OSError: the folder does not exist.

    """
    for target in targets:
        check_format(target, also=[RECORD_SUFFIX])
        check_target(target)


def replay_or_save(
    episode: Episode,
    targets: Sequence[Path],
    show: bool | None,
    interval_ms: float = 150,
    speed: float = 1.0,
) -> None:
    """Write ``targets``, and open a window if asked for or if there is nothing to write.

    Where no window can be opened the replay goes to a file in the current folder instead.
    """
    for target in targets:
        save_episode(episode, target, interval_ms, speed)
    if not (show or (show is None and not targets)):
        return
    replay = replay_animation(episode, None, interval_ms, speed)
    if replay is not None and replay.window:
        typer.echo("space pauses, left and right step, q closes the window")
        replay.show()
        return
    instead = "" if targets else ", so the replay goes to a file"
    typer.echo(f"there is no display to open a window on{instead}")
    if not targets:
        target = Path(f"replay-{'unseeded' if episode.seed is None else episode.seed}.gif")
        save_episode(episode, target, interval_ms, speed)


def save_episode(
    episode: Episode, target: Path, interval_ms: float = 150, speed: float = 1.0
) -> None:
    """Write an episode in the format that the suffix of ``target`` names, and say so."""
    if target.suffix.lower() == RECORD_SUFFIX:
        episode.save(target)
    else:
        replay: Replay | None = replay_animation(episode, None, interval_ms, speed, window=False)
        assert replay is not None, "matplotlib is installed with this package"
        replay.save(target)
    typer.echo(f"saved {target}")
