"""``python -m agents`` is the command ``warehouse``."""

from agents.cli import main

main()
