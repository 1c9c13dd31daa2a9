"""Groups of commands: how their help lists them, and how a missing or unknown one is found."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import typer
from typer.core import TyperGroup

HELP = "-h", "--help"


class CommandGroup(TyperGroup):
    """A group whose help lists the commands under the title of each ``rich_help_panel``.

    Typer lists them so only by means of Rich, which takes long to import.

    Attributes:
        usual: Command that is run if none is named, or "" where the help is shown instead.
        renamed: Command to use instead of each one that no longer exists.
    """

    usual = ""
    renamed: ClassVar[Mapping[str, str]] = {}

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section for each title, with the names and summaries of its commands."""
        shown = {name: each for name, each in self.commands.items() if not each.hidden}
        longest = max(map(len, shown))
        sections: dict[str, list[tuple[str, str]]] = {}
        for name, each in shown.items():
            title = getattr(each, "rich_help_panel", None)
            summary = each.get_short_help_str(formatter.width - longest - len("      "))
            row = name.ljust(longest), summary
            sections.setdefault(title if isinstance(title, str) else "Commands", []).append(row)
        for title, rows in sections.items():
            with formatter.section(title):
                formatter.write_dl(rows)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put the usual command before options that are not the group's own."""
        if self.usual and (not args or (args[0].startswith("-") and args[0] not in HELP)):
            args = [self.usual, *args]
        return super().parse_args(ctx, args)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that the words begin with, and the other words."""
        if args[0] not in self.commands:
            if args[0] in self.renamed:
                raise typer.BadParameter(
                    f"the command {args[0]!r} no longer exists; use: {self.renamed[args[0]]}"
                )
            allowed = ", ".join(name for name, each in self.commands.items() if not each.hidden)
            raise typer.BadParameter(f"no command is called {args[0]!r}; allowed: {allowed}")
        return super().resolve_command(ctx, args)
