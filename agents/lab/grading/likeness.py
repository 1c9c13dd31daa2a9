"""The shape of sources: what stays if names, values and comments are changed.

This module imports nothing but the standard library, and is loaded by a path: sources of strangers
are parsed in a process with limits, in which none of them is run.

Source: Schleimer, Wilkerson and Aiken, "Winnowing: local algorithms for document fingerprinting",
SIGMOD 2003; of all fingerprints the smallest are kept here, as in Broder, "On the resemblance and
containment of documents", 1997.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable, Iterator

LENGTH = 12
"""Nodes of a syntax tree, one after the other, that have a fingerprint together."""

MAX_PRINTS = 1_000
"""Most fingerprints of a submission; the smallest are kept."""


def shape_of(trees: Iterable[ast.AST]) -> list[int]:
    """Return the fingerprints of syntax trees."""
    found = set[int]()
    for tree in trees:
        words = list(_words(tree))
        for place in range(len(words) - LENGTH + 1):
            text = " ".join(words[place : place + LENGTH])
            found.add(int.from_bytes(hashlib.blake2b(text.encode(), digest_size=4).digest()))
    return sorted(found)[:MAX_PRINTS]


def _words(tree: ast.AST) -> Iterator[str]:
    """Yield the kinds of nodes of a tree, depth first."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if not is_text and not isinstance(node, ast.expr_context):
            yield type(node).__name__
            waiting.extend(reversed(list(ast.iter_child_nodes(node))))
