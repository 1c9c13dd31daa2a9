"""The messages of a recording: their topics and their JSON schemas.

Messages named ``foxglove.*`` have the fields that Foxglove publishes, which is how its 3D panel
knows them; lists that no message fills have items without fields here.

Source: https://github.com/foxglove/foxglove-sdk/tree/main/schemas/jsonschema
"""

from __future__ import annotations

from typing import Any

JsonSchema = dict[str, Any]


def _object(**properties: JsonSchema) -> JsonSchema:
    return {"type": "object", "properties": properties, "required": list(properties)}


def _numbers(*names: str) -> dict[str, JsonSchema]:
    return dict.fromkeys(names, _NUMBER)


def _list(items: JsonSchema) -> JsonSchema:
    return {"type": "array", "items": items}


_TEXT, _FLAG = {"type": "string"}, {"type": "boolean"}
_WHOLE, _NUMBER = {"type": "integer"}, {"type": "number"}
_TIME = {"title": "time", **_object(sec=_WHOLE, nsec=_WHOLE)}
_DURATION = {"title": "duration", **_object(sec=_WHOLE, nsec=_WHOLE)}
_VECTOR, _QUATERNION = _object(**_numbers(*"xyz")), _object(**_numbers(*"xyzw"))
_POSE = _object(position=_VECTOR, orientation=_QUATERNION)
_COLOR = _object(**_numbers(*"rgba"))
_LENGTHS = _numbers("shaft_length", "shaft_diameter", "head_length", "head_diameter")
_ARROW = _object(pose=_POSE, **_LENGTHS, color=_COLOR)
_CUBE = _object(pose=_POSE, size=_VECTOR, color=_COLOR)
_SCALES = _numbers("bottom_scale", "top_scale")
_CYLINDER = _object(pose=_POSE, size=_VECTOR, **_SCALES, color=_COLOR)
_NOTHING = _object()

_PRIMITIVES = {
    **{"arrows": _ARROW, "cubes": _CUBE, "spheres": _CUBE, "cylinders": _CYLINDER},
    **dict.fromkeys(("lines", "triangles", "texts", "models"), _NOTHING),
}
PRIMITIVES = tuple(_PRIMITIVES)
"""The lists of shapes in an entity of a scene."""

_ENTITY = _object(
    timestamp=_TIME,
    frame_id=_TEXT,
    id=_TEXT,
    lifetime=_DURATION,
    frame_locked=_FLAG,
    metadata=_list(_NOTHING),
    **{name: _list(shape) for name, shape in _PRIMITIVES.items()},
)
_SCENE = _object(deletions=_list(_NOTHING), entities=_list(_ENTITY))
_FRAMES = {"parent_frame_id": _TEXT, "child_frame_id": _TEXT}
_TRANSFORM = _object(timestamp=_TIME, **_FRAMES, translation=_VECTOR, rotation=_QUATERNION)
_METRES = {**_NUMBER, "description": "m, in the frame 'warehouse'"}
_IMPULSE = {**_NUMBER, "description": "N s"}
_CONTACT = _object(
    timestamp=_TIME, robot=_TEXT, counterpart=_TEXT, impulse=_IMPULSE, x=_METRES, y=_METRES
)
_ENERGY = _object(
    timestamp=_TIME,
    step=_WHOLE,
    joules={**_list(_NUMBER), "description": "used so far by each robot"},
    battery={**_list(_NUMBER), "description": "units left of each robot"},
)

SCHEMAS: dict[str, JsonSchema] = {
    "foxglove.FrameTransforms": _object(transforms=_list(_TRANSFORM)),
    "foxglove.SceneUpdate": _SCENE,
    "warehouse.Contact": _CONTACT,
    "warehouse.Energy": _ENERGY,
}
"""JSON schemas of messages, by name; each message is an object."""

LAYOUT, BODIES, POSES, HITS = "/layout", "/bodies", "/tf", "/hits"
CONTACTS, ENERGY = "/contacts", "/energy"

SCHEMA_OF = {
    **dict.fromkeys((LAYOUT, BODIES, HITS), "foxglove.SceneUpdate"),
    POSES: "foxglove.FrameTransforms",
    CONTACTS: "warehouse.Contact",
    ENERGY: "warehouse.Energy",
}
"""The schema of each topic."""
