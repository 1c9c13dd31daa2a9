"""What has to be compiled before a solver of whole problems begins.

Compiling takes some seconds once on a machine, which must not count against a limit of time.
"""

from __future__ import annotations

from agents.mapf.kernels.buffers import prepare
from agents.mapf.kernels.lacam import add, explore, fill_table
from agents.mapf.kernels.lns import improve
from agents.mapf.kernels.places import measure


def prepare_solvers() -> None:
    """Compile the kernels of LaCAM, LaCAM* and refinement; what is compiled is kept."""
    prepare(measure, add, explore, fill_table, improve)
