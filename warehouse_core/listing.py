"""What subclasses of ``WarehouseEnv`` may override of the book's listing, and who refuses it."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Never

from warehouse_core.copies import CopiedWhole

MOVES = ("_is_wall", "_move")
"""Methods that only the grid can call: a body collides with the walls of the layout."""

STEPS = (*MOVES, "_normalize_action", "_pick", "_drop")
DRAWS = ("_random_empty_cell", "_randomize_pickup_dropoff")
LISTED = (*STEPS, *DRAWS, "_find_tile", "_observe")


class Unlisted(CopiedWhole):
    """A base class of environments that call no method of the listing, so none is overridden."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        for name in LISTED:
            if name in vars(cls):
                raise TypeError(
                    f"{cls.__name__} defines {name}, which {cls.__mro__[1].__name__} never calls; "
                    "define it in a subclass of WarehouseEnv, or change task/rules.py, which holds "
                    "the rules of all environments"
                )


class Grid(list[str]):
    """The rows of an environment's layout. Assigning a row changes the environment."""

    def __init__(self, rows: Sequence[str], change: Callable[[list[str]], None]) -> None:
        super().__init__(rows)
        self._change = change

    def __setitem__(self, index: Any, row: Any) -> None:
        rows = list(self)
        rows[index] = row
        self._change(rows)
        super().__setitem__(index, row)

    def __reduce__(self) -> tuple[type[list[str]], tuple[list[str]]]:
        return list, (list(self),)  # a copy belongs to no environment

    def _refuse(self, *arguments: Any, **options: Any) -> Never:
        raise TypeError("env.grid takes a row by assignment, env.grid[row] = ..., or all its rows")

    append = extend = insert = pop = remove = clear = sort = reverse = _refuse
    __delitem__ = __iadd__ = __imul__ = _refuse


@contextmanager
def seeded(seed: int | None) -> Iterator[None]:
    """Let Python's global ``random`` follow a seed for a while; ``None`` changes nothing."""
    if seed is None:
        yield
        return
    before = random.getstate()
    random.seed(seed)
    try:
        yield
    finally:
        random.setstate(before)
