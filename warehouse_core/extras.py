"""Commands that install the requirements of an optional part.

The commands name the requirements and not this distribution. It is on no package index, so anybody
could register its name there.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

DISTRIBUTION = "warehouse-lab"


def install_command(extra: str) -> str:
    """Return the command that installs the requirements of an extra."""
    from importlib.metadata import requires

    return pip_install(requirements_of(extra, requires(DISTRIBUTION) or []))


def not_installed(needing: str, error: ImportError, extra: str) -> str:
    """Return the sentence that a part needs a library of an extra."""
    return f"{needing} {error.name}, which is not installed: {install_command(extra)}"


def pip_install(requirements: Iterable[str]) -> str:
    """Return the command that installs some requirements."""
    return "pip install " + " ".join(f"'{each}'" for each in requirements)


def requirements_of(extra: str, requires: Iterable[str]) -> list[str]:
    """Return the requirements of an extra.

    Args:
        extra: name of the extra.
        requires: requirements in the form of package metadata: ``name>=1; extra == 'video'``.
    """
    parts = (each.partition(";") for each in requires)
    marker = re.compile(rf"""extra == ['"]{re.escape(extra)}['"]""")
    return [name.strip() for name, _, condition in parts if marker.search(condition)]
