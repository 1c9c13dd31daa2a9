"""The settings of an environment, which records store for replays."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from warehouse_core.arguments import MAX_BUDGET, MAX_VIEW_RADIUS, whole_number
from warehouse_core.wording import brief
from warehouse_core.world.tiles import Cell


@dataclass(frozen=True, slots=True)
class Settings:
    """The arguments of ``WarehouseEnv``, except its layout.

    ``backend`` is the name of the backend, or of its class if it was given as a class or instance.
    ``cell_size`` is in metres. ``battery`` is in units, of which a step costs one. ``slippery`` has
    the open cells with slippery floor, ``motor_strength`` is the actual share of the motor force,
    and ``drive`` is the drive of the robot, if they are known.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> settings = WarehouseEnv(battery=50).settings
        >>> settings.battery, settings.max_steps, settings.backend
        (50, 200, 'grid')
    """

    backend: str
    cell_size: float
    start_pos: Cell
    max_steps: int
    battery: int
    view_radius: int
    slippery: tuple[Cell, ...] = ()
    motor_strength: float = 1.0
    drive: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return the settings as a JSON object. An unknown drive is left out, as in older files."""
        values = asdict(self)
        if not self.drive:
            del values["drive"]
        return values

    @classmethod
    def from_json(cls, values: Any) -> Settings:
        """Return the settings in a JSON object.

        Raises:
            ValueError: a key is missing or unknown, or a value has the wrong type or size.
        """
        if isinstance(values, dict):
            older = {"slippery": [], "motor_strength": 1.0, "drive": ""}  # which records may lack
            values = older | values
        if not isinstance(values, dict) or values.keys() != set(cls.__slots__):
            raise ValueError(f"settings must have the keys {', '.join(cls.__slots__)}")
        limits = {
            "max_steps": (1, MAX_BUDGET),
            "battery": (1, MAX_BUDGET),
            "view_radius": (0, MAX_VIEW_RADIUS),
        }
        try:
            for name, (minimum, maximum) in limits.items():
                whole_number(name, values[name], minimum, maximum)
        except TypeError as error:
            raise ValueError(str(error)) from None
        if not isinstance(values["backend"], str):
            raise ValueError(f"backend is {brief(values['backend'])}; it must be a name")
        size = values["cell_size"]
        if type(size) is not float or not 0 < size < float("inf"):
            raise ValueError(f"cell_size is {brief(size)}; it must be positive and finite")
        start = _cell("start_pos", values["start_pos"])
        return cls(**values | {"start_pos": start} | conditions_in(values))


def conditions_in(values: dict[str, Any]) -> dict[str, Any]:
    """Return ``Conditions`` by name from a JSON object; the defaults are nominal.

    Raises:
        ValueError: one of them has the wrong type or size.
    """
    cells, strength = values.get("slippery", []), values.get("motor_strength", 1.0)
    drive = values.get("drive", "")
    if type(drive) is not str:
        raise ValueError(f"drive is {brief(drive)}; it must be a word")
    if type(strength) is not float or not 0 <= strength <= 1:
        raise ValueError(f"motor_strength is {brief(strength)}; it must be a share from 0 to 1")
    if not isinstance(cells, list):
        raise ValueError(f"slippery is {brief(cells)}; it must be a list of cells")
    slippery = tuple(_cell("slippery", cell) for cell in cells)
    return {"slippery": slippery, "motor_strength": strength, "drive": drive}


def _cell(name: str, value: Any) -> Cell:
    if not isinstance(value, list) or [type(part) for part in value] != [int, int]:
        raise ValueError(f"{name} is {brief(value)}; it must be a row and a column")
    return value[0], value[1]
