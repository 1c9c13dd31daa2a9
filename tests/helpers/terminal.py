"""A stream that says it is a terminal."""

import io


class Terminal(io.StringIO):
    """Takes what would be seen on a terminal."""

    def isatty(self) -> bool:
        return True
