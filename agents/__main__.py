"""The program ``warehouse``, which is also ``python -m agents``."""

from __future__ import annotations

import os
import signal
import sys
from functools import partial
from threading import Timer
from typing import Any

AGAIN_SECONDS = 0.05
"""Time after which an interrupt comes again that Python has ignored."""


def main() -> None:
    """Run the command line; an interrupt at any time is one line."""
    sys.unraisablehook = interrupt_again
    try:
        from agents.lab.commands import cli

        cli.main()
    except KeyboardInterrupt:  # during the imports
        print("warehouse: interrupted", file=sys.stderr)
        sys.exit(130)
    finally:
        # All is done and said; an interrupt while Python ends would be a traceback.
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def interrupt_again(ignored: Any) -> None:
    """Send an interrupt again that came in a destructor or a weakref callback.

    Python prints errors that are raised there, and ignores them: the program would go on.
    """
    if ignored.exc_type is KeyboardInterrupt:
        # To the process, as this thread may wait; Windows knows only signals to the caller.
        send = signal.raise_signal if os.name == "nt" else partial(os.kill, os.getpid())
        Timer(AGAIN_SECONDS, send, [signal.SIGINT]).start()
    else:
        sys.__unraisablehook__(ignored)


if __name__ == "__main__":
    main()
