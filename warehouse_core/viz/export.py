"""The file formats of replays, and MP4 files."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen

from warehouse_core.errors import FormatError
from warehouse_core.extras import install_command

FORMATS = (".gif", ".mp4", ".html", ".svg", ".png")
"""Suffixes of the files that a replay can be saved as."""


def ffmpeg() -> str:
    """Return the path of the ffmpeg program, which writes MP4 files.

    Raises:
        FormatError: imageio-ffmpeg is not installed.
    """
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError as error:
        raise FormatError(
            f"saving as .mp4 needs imageio-ffmpeg: {install_command('video')}"
        ) from error
    return str(get_ffmpeg_exe())


@contextmanager
def mp4_frames(path: Path, fps: float, width: int, height: int) -> Iterator[Callable[[bytes], int]]:
    """Yield a function that adds a frame to an MP4 file, which ffmpeg reads from a pipe.

    A frame is given as the bytes of an array ``[height, width, 4]``. Width and height must be even,
    because the format requires it. If the block raises an error, ffmpeg is stopped before the error
    propagates.

    Raises:
        FormatError: imageio-ffmpeg is not installed.
        OSError: ffmpeg cannot write the file.
    """
    raw = ["-f", "rawvideo", "-vcodec", "rawvideo", "-s", f"{width}x{height}", "-pix_fmt", "rgba"]
    read = [*raw, "-framerate", str(fps), "-loglevel", "error", "-i", "pipe:"]
    command = [ffmpeg(), *read, "-vcodec", "h264", "-pix_fmt", "yuv420p", "-y", str(path)]
    # Ctrl-C interrupts all processes of a session, so ffmpeg gets a session of its own.
    with Popen(command, stdin=PIPE, stdout=DEVNULL, stderr=PIPE, start_new_session=True) as process:
        assert process.stdin is not None, "it is a pipe"
        try:
            with suppress(BrokenPipeError):  # ffmpeg has ended, and says why
                yield process.stdin.write
            said = process.communicate()[1].decode(errors="replace")
        except BaseException:
            process.kill()
            process.communicate()  # merely closing the pipe would raise another error
            raise
    if process.returncode:
        full = os.strerror(errno.ENOSPC)
        if full in said:
            raise OSError(errno.ENOSPC, full, str(path))
        reason = f"ffmpeg ended with exit code {process.returncode}: {said}"
        raise OSError(errno.EIO, reason, str(path))
