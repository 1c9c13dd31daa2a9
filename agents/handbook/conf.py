"""The settings of the handbook's site; ``sphinx-build -W agents/handbook site`` builds it."""

from __future__ import annotations

import ast
import os
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import typer
from docutils import nodes
from sphinx.pycode import ModuleAnalyzer

from agents.lab.commands import cli

project = "warehouse-lab"
release = metadata.version(project)
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = f"{project} {release}"
html_show_copyright = False
html_show_sphinx = False
html_static_path = html_css_files = ["site.css"]
html_extra_path = ["llms.txt", "mini_lab.ipynb"]

# The cells are executed each time, in a folder that is removed. An error ends the build.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True
myst_heading_anchors = 3

napoleon_use_ivar = True
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
default_role = "code"

# Cells that begin with "!" have a terminal, in which Rich would write codes of colours.
os.environ["TTY_COMPATIBLE"] = "0"

# So that cells find the command "warehouse" of the environment that builds the site.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])


SCROLLING = 'tabindex="0" role="group" aria-label="Lines"'
"""Attributes of code, output and tables, which may scroll sideways, so that keys reach them."""

ACCESSIBLE = {
    "<pre>": f"<pre {SCROLLING}>",
    '<div class="table-wrapper': f'<div {SCROLLING} class="table-wrapper',
    # The text of a summary is its name.
    '<summary aria-label="Toggle hidden content">': "<summary>",
}
"""Better markup by the markup that it replaces."""


COMMANDS = "reference/command_line"
"""Page that ends with the help of each command."""

COLUMNS = 78
"""Width of the help."""


def setup(app: Any) -> None:
    """Call the functions below where Sphinx reads and writes pages."""
    app.connect("source-read", add_commands)
    app.connect("doctree-read", add_terms)
    app.connect("autodoc-skip-member", is_left_out)
    app.connect("autodoc-process-docstring", describe_constant)
    app.connect("html-page-context", make_accessible)


def add_commands(_app: Any, page: str, source: list[str]) -> None:
    """Add the help of each command to the page of the command line, as the program prints it."""
    if page == COMMANDS:
        program: Any = typer.main.get_command(cli.app)
        context = typer.Context(
            program, info_name="warehouse", terminal_width=COLUMNS, **program.context_settings
        )
        source[0] += f"\n{help_of(context)}"
        for title, commands in cli.GROUPS.items():
            source[0] += f"\n## {title}\n"
            for name in commands:
                source[0] += f"\n### {name}\n{help_below(program.commands[name], name, context)}"


def help_of(context: typer.Context) -> str:
    """Return the help of a command as a block of text."""
    return f"\n```text\n{context.get_help()}\n```\n"


def help_below(command: Any, name: str, above: typer.Context) -> str:
    """Return the help of a command and of the commands in it."""
    context = typer.Context(command, info_name=name, parent=above)
    inner = getattr(command, "commands", {}).items()
    return help_of(context) + "".join(help_below(each, word, context) for word, each in inner)


def add_terms(app: Any, tree: nodes.document) -> None:
    """Let links of Markdown, which notebooks show as links too, lead to terms."""
    slugs = app.env.metadata[app.env.docname].setdefault("myst_slugs", {})
    for term in tree.findall(nodes.term):
        slugs |= {each: (0, each, term.astext()) for each in term["ids"]}


def is_left_out(_app: Any, _what: str, _name: str, member: Any, skip: bool, _options: Any) -> bool:
    """Leave out fields of named tuples, which their classes describe."""
    return skip or str(member.__doc__).startswith("Alias for field number")


def describe_constant(
    _app: Any, what: str, name: str, _value: Any, _options: Any, lines: list[str]
) -> None:
    """Give a constant that a package imports the description where it is assigned."""
    package, _, word = name.rpartition(".")
    if what != "data" or any(lines):
        return
    for node in ast.parse(ModuleAnalyzer.for_module(package).code).body:
        if isinstance(node, ast.ImportFrom) and word in {each.name for each in node.names}:
            described = ModuleAnalyzer.for_module(str(node.module)).find_attr_docs()
            lines[:] = described.get(("", word), [])


def make_accessible(
    _app: Any, _page: str, _template: str, context: dict[str, Any], _tree: Any
) -> None:
    """Replace markup by better markup."""
    for start, better in ACCESSIBLE.items():
        context["body"] = context.get("body", "").replace(start, better)
