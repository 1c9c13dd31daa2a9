"""Groups of commands: the lists in their help, and errors for unknown commands."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, ClassVar

import typer
from typer.core import TyperCommand, TyperGroup

HELP = "-h", "--help"

SHOWN = "kinds"
"""Key under which the context of a command line keeps the kinds that the user typed."""


class CommandOfKinds(TyperCommand):
    """A command with a kind as argument, whose help after a kind lists only its options.

    Attributes:
        argument: name of the argument.
        names: names of the options of each kind, except for the file that is saved.
    """

    argument = ""
    names: ClassVar[Mapping[str, Collection[str]]] = {}

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Remember the kind for the help, which is printed before arguments are parsed."""
        ctx.meta[SHOWN] = [word for word in args if word in self.names]
        return super().parse_args(ctx, args)

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the options of the kind, or all options if no kind is given."""
        kinds = ctx.meta.get(SHOWN)  # None if help is made without a command line
        shown = {*self.names[kinds[0]], self.argument, "save"} if kinds else None
        hidden: list[Any] = [
            each for each in self.params if shown is not None and each.name not in shown
        ]
        for each in hidden:
            each.hidden = True
        super().format_options(ctx, formatter)
        for each in hidden:
            each.hidden = False


class CommandGroup(TyperGroup):
    """A group whose help lists commands under the titles given as ``rich_help_panel``.

    Typer does this only with Rich, which takes long to import.

    Attributes:
        renamed: replacement for each former command.
    """

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

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command named by the first word, and the remaining words."""
        if args[0] not in self.commands:
            if args[0] in self.renamed:
                raise typer.BadParameter(
                    f"the command {args[0]!r} no longer exists; use: {self.renamed[args[0]]}"
                )
            allowed = ", ".join(name for name, each in self.commands.items() if not each.hidden)
            raise typer.BadParameter(f"no command is called {args[0]!r}; allowed: {allowed}")
        return super().resolve_command(ctx, args)
