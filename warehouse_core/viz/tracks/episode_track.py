"""What a replay of one robot draws, read from an ``Episode``."""

from __future__ import annotations

from warehouse_core.records.episode import UNFINISHED, Episode
from warehouse_core.records.failure_modes import diagnose
from warehouse_core.viz.tracks.motion_frames import (
    FRAME_SECONDS,
    check_frame_seconds,
    frames_along,
    hit_of,
)
from warehouse_core.viz.tracks.track import Frame, Pose, Track, middle
from warehouse_core.wording import printable


def track_of_episode(episode: Episode, frame_seconds: float | None = FRAME_SECONDS) -> Track:
    """Return the track of a record.

    Args:
        episode: the record.
        frame_seconds: simulated time between two frames of continuous motions; ``None`` gives
            one frame a step, as for motions that are not continuous.

    Raises:
        ValueError: ``frame_seconds`` is not a positive finite number.
        RecordError: continuous motions take more than ``MAX_FRAMES`` frames.
    """
    captions = step_captions(episode)
    start = Pose(middle(episode.cells[0]), None, episode.loaded[0])
    frames = [Frame(episode.layout.rows, (start,), 0.0)]
    size = episode.settings.cell_size
    is_continuous = any(len(motion.path) > 2 for motion in episode.motions)
    check_frame_seconds(frame_seconds, episode.seconds if is_continuous else 0.0)
    if is_continuous and frame_seconds is not None:
        for motion, loaded, caption in zip(
            episode.motions, episode.loaded[1:], captions, strict=True
        ):
            frames += frames_along(frames[-1], [motion], [loaded], size, frame_seconds, caption)
    else:
        is_continuous = False
        for step, motion in enumerate(episode.motions, start=1):
            heading = float(motion.path[-1, 3])
            pose = Pose(middle(episode.cells[step]), heading, episode.loaded[step])
            hits = tuple(hit_of(contact, size, "") for contact in motion.contacts)
            before, caption = frames[-1], captions[step - 1]
            frames.append(
                Frame(
                    episode.layout.rows, (pose,), float(step), caption, hits,
                    before.clock + motion.seconds, energy=before.energy + motion.joules,
                )
            )  # fmt: skip
    seed = "" if episode.seed is None else f", seed {episode.seed}"
    title = f"{episode.agent or 'Warehouse'} on the {episode.settings.backend} backend{seed}"
    track = Track(
        frames,
        episode.metrics,
        is_continuous,
        episode.settings.battery,
        printable(title),
        view_radius=episode.settings.view_radius,
        slippery=episode.settings.slippery,
        motor_strength=episode.settings.motor_strength,
    )
    if episode.outcome != UNFINISHED:
        diagnosis = diagnose(episode)
        track.ending, frames[-1].caption = diagnosis.mode, printable(diagnosis.sentence)
    return track


def step_captions(episode: Episode) -> list[str]:
    """Return for each step the action and its reason."""
    return [
        printable(f"{action} ({reason})" if reason else str(action))
        for action, reason in zip(episode.actions, episode.reasons, strict=True)
    ]
