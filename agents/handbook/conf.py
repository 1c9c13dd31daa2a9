"""The settings of the handbook's site; ``sphinx-build -W agents/handbook site`` builds it."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from docutils import nodes

project = "warehouse-lab"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = project
html_show_copyright = False
html_show_sphinx = False
html_static_path = html_css_files = ["site.css"]

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


def setup(app: Any) -> None:
    """Leave the fields of named tuples to the docstrings of their classes, and help readers."""

    def add_terms(app: Any, tree: nodes.document) -> None:
        """Let links of Markdown, which notebooks show as links too, lead to terms."""
        slugs = app.env.metadata[app.env.docname].setdefault("myst_slugs", {})
        for term in tree.findall(nodes.term):
            slugs |= {each: (0, each, term.astext()) for each in term["ids"]}

    def is_field(_app: Any, _what: str, _name: str, member: Any, skip: bool, _options: Any) -> bool:
        return skip or str(member.__doc__).startswith("Alias for field number")

    def make_accessible(
        _app: Any, _page: str, _template: str, context: dict[str, Any], _tree: Any
    ) -> None:
        for start, better in ACCESSIBLE.items():
            context["body"] = context.get("body", "").replace(start, better)

    app.connect("doctree-read", add_terms)
    app.connect("autodoc-skip-member", is_field)
    app.connect("html-page-context", make_accessible)
