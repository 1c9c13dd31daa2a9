"""The program ``warehouse``, which is also ``python -m agents``."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line; an interrupt while it is being imported is one line too."""
    try:
        from agents.lab.commands import cli
    except KeyboardInterrupt:
        print("warehouse: interrupted", file=sys.stderr)
        sys.exit(130)
    cli.main()


if __name__ == "__main__":
    main()
