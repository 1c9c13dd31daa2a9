"""The program ``warehouse``, which is also ``python -m agents``."""

from __future__ import annotations

import os
import signal
import sys
from functools import partial
from importlib.machinery import ExtensionFileLoader
from pathlib import Path
from threading import Timer
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

PACKAGES = ("warehouse_core", "warehouse_physics", "agents")

AGAIN_SECONDS = 0.05
"""Time after which an interrupt is sent again if it came while it could not be handled."""

INITIALISING = {
    ExtensionFileLoader.create_module.__code__,
    ExtensionFileLoader.exec_module.__code__,
}
"""Code of the functions that initialise compiled modules."""


def main() -> None:
    """Run the command line; an interrupt at any time prints one line."""
    sys.unraisablehook = interrupt_again_if_ignored
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, interrupt)
    try:
        if not Path(__file__).exists():
            sys.exit(run_unpacked())
        from agents.lab.commands import cli

        cli.main()
    except KeyboardInterrupt:  # during the imports
        print("warehouse: interrupted", file=sys.stderr)
        sys.exit(130)
    finally:
        if signal.getsignal(signal.SIGINT) is interrupt:
            # The command is done: an interrupt while Python ends would print a traceback.
            signal.signal(signal.SIGINT, signal.SIG_DFL)


def run_unpacked() -> int:
    """Run the command with an unpacked copy of the packages in a ZIP file; return its exit code.

    Grading starts scripts of this program, and sweeps read its sources: both need files.
    """
    import subprocess
    from importlib.resources import files
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        for package in PACKAGES:
            copy(files(package), Path(folder, package))
        path = os.pathsep.join(filter(None, [folder, os.environ.get("PYTHONPATH")]))
        command = [sys.executable, "-P", "-m", "agents", *sys.argv[1:]]
        return subprocess.run(
            command, env=os.environ | {"PYTHONPATH": path}, check=False
        ).returncode


def copy(source: Traversable, target: Path) -> None:
    """Copy a file or a folder of a package, which may be in a ZIP file."""
    if source.is_file():
        target.write_bytes(source.read_bytes())
        return
    target.mkdir()
    for each in source.iterdir():
        copy(each, target / each.name)


def interrupt(number: int, frame: FrameType | None) -> None:
    """Raise ``KeyboardInterrupt`` as Python does, except while a compiled module is initialised.

    The module would turn the interrupt into another error, and Python might crash later.
    """
    while frame is not None:
        if frame.f_code in INITIALISING:
            interrupt_again()
            return
        frame = frame.f_back
    raise KeyboardInterrupt


def interrupt_again_if_ignored(ignored: Any) -> None:
    """Send an interrupt again if it came in a destructor or a weakref callback.

    Python prints errors that are raised there and ignores them, so the program would continue.
    """
    if ignored.exc_type is KeyboardInterrupt:
        interrupt_again()
    else:
        sys.__unraisablehook__(ignored)


def interrupt_again() -> None:
    """Interrupt this process after ``AGAIN_SECONDS``."""
    # To the process, because this thread may be blocked. Windows can only signal the caller.
    send = signal.raise_signal if os.name == "nt" else partial(os.kill, os.getpid())
    Timer(AGAIN_SECONDS, send, [signal.SIGINT]).start()


if __name__ == "__main__":
    main()
