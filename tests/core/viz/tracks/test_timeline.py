"""The common moments of several tracks."""

import pytest

from warehouse_core.viz.tracks.timeline import ghost_of
from warehouse_core.viz.tracks.track import Frame, Pose, Track


def track_with(*frames: tuple[float, float, float], is_continuous: bool = False) -> Track:
    """Return a track of frames, given as progress, clock and column."""
    return Track(
        [
            Frame(("....",), (Pose((column, 0.5), None, loaded=False),), progress, clock=clock)
            for progress, clock, column in frames
        ],
        {},
        is_continuous,
    )


@pytest.mark.parametrize(
    ("seconds", "expected"),
    [
        (2.0, [0.5, 0.5, 1.5, 2.5, 2.5]),
        (0.0, [0.5, 0.5, 1.5, 1.5, 2.5]),
        (4.0, [0.5] * 3 + [1.5] * 2),
    ],
)
def test_a_ghost_is_where_the_other_robot_is_on_the_common_clock(seconds, expected) -> None:
    body = track_with(
        (0, 0, 0.5), (0.5, 1, 1), (1, 2, 1.5), (1.5, 4, 2), (2, 5, 2.5), is_continuous=True
    )
    grid = track_with(*((step, seconds * step, step + 0.5) for step in range(3)))
    assert [x for x, _ in ghost_of(body, grid)] == expected
