"""The settings of an environment, which a record stores in order to be replayed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from warehouse_core.world.tiles import Cell


@dataclass(frozen=True, slots=True)
class Settings:
    """The arguments of ``WarehouseEnv`` that are not its layout.

    ``backend`` is the name of the backend, or of its class if it was given as a class or instance.
    ``cell_size`` is in metres, ``battery`` in units of one step.
    """

    backend: str
    cell_size: float
    start_pos: Cell
    max_steps: int
    battery: int
    view_radius: int

    @classmethod
    def from_json(cls, values: Any) -> Settings:
        """Return the settings in a JSON object.

        Raises:
            ValueError: a key is missing or unknown, or a value is of the wrong type or size.
        """
        if not isinstance(values, dict) or values.keys() != set(cls.__slots__):
            raise ValueError(f"settings must have the keys {', '.join(cls.__slots__)}")
        minima = {"max_steps": 1, "battery": 1, "view_radius": 0}
        for name, minimum in minima.items():
            if type(values[name]) is not int or values[name] < minimum:
                raise ValueError(f"{name} is {values[name]!r}; it must be an integer >= {minimum}")
        if not isinstance(values["backend"], str):
            raise ValueError(f"backend is {values['backend']!r}; it must be a name")
        size, start = values["cell_size"], values["start_pos"]
        if type(size) is not float or not 0 < size < float("inf"):
            raise ValueError(f"cell_size is {size!r}; it must be positive and finite")
        if not isinstance(start, list) or [type(part) for part in start] != [int, int]:
            raise ValueError(f"start_pos is {start!r}; it must be a row and a column")
        return cls(**values | {"start_pos": (start[0], start[1])})
