"""A stream that claims to be a terminal."""

import io


class Terminal(io.StringIO):
    """Collects the text that a terminal would show."""

    def isatty(self) -> bool:
        return True
