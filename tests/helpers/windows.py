"""Programs with real windows on a virtual display, and keys sent to them."""

import ctypes
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import ImageGrab

TIMEOUT = 60
"""Seconds to wait for a program."""

MAX_STEPS = 400
"""Steps of the watched episode, enough not to end during a test."""


class Picture(NamedTuple):
    """Line that the watched program prints for each picture that it draws."""

    step: int
    checksum: int
    height: int
    width: int
    channels: int


class Program:
    """A Python program on the display, its window and its output."""

    def __init__(self, display: str, folder: Path, *words: object) -> None:
        names = ("WAYLAND_DISPLAY", "MPLBACKEND")
        environment = {name: value for name, value in os.environ.items() if name not in names}
        self._environment = environment | {"DISPLAY": display}
        self._process = subprocess.Popen(
            [sys.executable, "-u", "-c", *map(str, words)],
            cwd=folder,
            env=self._environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.printed: list[str] = []
        self._lines: queue.Queue[str | None] = queue.Queue()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def close(self) -> None:
        stop(self._process)
        self._reader.join()
        assert self._process.stdout is not None
        self._process.stdout.close()

    def line(self) -> str | None:
        """Return the next line of output, ``None`` after the last one."""
        try:
            line = self._lines.get(timeout=TIMEOUT)
        except queue.Empty:
            pytest.fail(f"no output for {TIMEOUT} seconds after {self.printed[-5:]}")
        if line is not None:
            self.printed.append(line)
        return line

    def picture(self) -> Picture:
        """Return the next picture that the program draws."""
        line = self.line()
        assert line is not None, f"it ended: {self.printed[-20:]}"
        assert line.replace(" ", "").isdigit(), f"not a picture: {line}, {self.rest()}"
        return Picture(*map(int, line.split()))

    def pictures_until(self, done: Callable[[Picture], bool]) -> list[Picture]:
        """Return the pictures up to the first for which ``done`` is true."""
        pictures = [self.picture()]
        while not done(pictures[-1]):
            assert len(pictures) < 20 * MAX_STEPS, "no such picture came"
            pictures.append(self.picture())
        return pictures

    def rest(self) -> list[str]:
        """Return the remaining lines, after the program has ended."""
        return list(iter(self.line, None))  # type: ignore[arg-type]

    def code(self) -> int:
        """Wait for the program to end and return its exit code."""
        return self._process.wait(TIMEOUT)

    def focus(self) -> str:
        """Wait for the window, give it the keyboard focus and return its number."""
        found = self._xdotool("search", "--sync", "--onlyvisible", "--name", "^Warehouse").split()
        self._xdotool("windowfocus", "--sync", found[-1])
        # These keys do nothing. On a busy machine the toolkit loses the first keys after a change.
        self._xdotool("key", "--delay", "150", *["F9"] * 4)
        return found[-1]

    def press(self, *keys: str) -> None:
        """Press and release keys on the keyboard of the display."""
        self._xdotool("key", "--delay", "30", *keys)

    def resize(self, window: str, width: int, height: int) -> None:
        self._xdotool("windowsize", window, str(width), str(height))

    def _xdotool(self, *words: str) -> str:
        done = subprocess.run(
            ["xdotool", *words],
            env=self._environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=TIMEOUT,
        )
        assert done.returncode == 0, f"xdotool {words}: {done.stderr}; {self.printed}"
        return done.stdout

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.put(line.rstrip("\n"))
        self._lines.put(None)


def stop(process: "subprocess.Popen[str] | subprocess.Popen[bytes]") -> None:
    """Terminate a process, or kill it if that does not work."""
    process.terminate()
    try:
        process.wait(10)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


MAX_LINES = 200
"""Largest number of lines to read while waiting for one."""


class ClientMessage(ctypes.Structure):
    """``XClientMessageEvent`` of Xlib, with the size of its largest event."""

    _fields_ = (
        ("type", ctypes.c_int),
        ("serial", ctypes.c_ulong),
        ("send_event", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("window", ctypes.c_ulong),
        ("message_type", ctypes.c_ulong),
        ("format", ctypes.c_int),
        ("data", ctypes.c_long * 24),
    )


class Shower(Program):
    """A program that shows pictures on the display and prints a line after each."""

    def wait_for(self, line: str, times: int = 1) -> None:
        """Read the output until it has contained ``line`` ``times`` times."""
        for _ in range(MAX_LINES):
            line_read = self.line()
            assert line_read is not None, f"it ended: {self.printed[-20:]}"
            times -= line_read == line
            if not times:
                return
        pytest.fail(f"it never printed {line!r}: {self.printed[:3]} ... {self.printed[-3:]}")

    def shot(self, window: str) -> NDArray[np.uint8]:
        """Return the pixels of the display at the window."""
        output = self._xdotool("getwindowgeometry", "--shell", window)
        place = {name: int(value) for name, value in (line.split("=") for line in output.split())}
        box = (place["X"], place["Y"], place["X"] + place["WIDTH"], place["Y"] + place["HEIGHT"])
        screen = ImageGrab.grab(xdisplay=self._environment["DISPLAY"]).convert("RGB")
        return np.asarray(screen.crop(box))

    def shows(self, window: str, picture: NDArray[np.uint8]) -> bool:
        """Return whether the window shows exactly this picture within a few seconds."""
        for _ in range(50):
            shot = self.shot(window)
            if np.array_equal(shot, picture):
                return True
            time.sleep(0.05)
        return False

    def windows(self) -> list[str]:
        """Return the windows with the program's title, visible or not."""
        words = ["xdotool", "search", "--name", "^Warehouse"]
        done = subprocess.run(
            words, env=self._environment, capture_output=True, text=True, check=False
        )
        return done.stdout.split()

    def ask_to_close(self, window: str) -> None:
        """Close a window as its close button would; there is no window manager to draw one."""
        x11 = ctypes.CDLL("libX11.so.6")
        x11.XOpenDisplay.restype = ctypes.c_void_p
        x11.XInternAtom.restype = ctypes.c_ulong
        connection = ctypes.c_void_p(x11.XOpenDisplay(self._environment["DISPLAY"].encode()))
        protocols, delete = (
            x11.XInternAtom(connection, name, 0) for name in (b"WM_PROTOCOLS", b"WM_DELETE_WINDOW")
        )
        message = ClientMessage(33, window=int(window), message_type=protocols, format=32)
        message.data[0] = delete
        target = ctypes.c_ulong(int(window))
        x11.XSendEvent(connection, target, 0, ctypes.c_long(0), ctypes.byref(message))
        x11.XCloseDisplay(connection)
