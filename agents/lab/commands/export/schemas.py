"""The messages of a recording: their topics and their JSON schemas.

Messages named ``foxglove.*`` have the fields that Foxglove publishes, which is how its 3D panel
knows them; lists that no message fills have items without fields here.

Source: https://github.com/foxglove/foxglove-sdk/tree/main/schemas/jsonschema
"""

from __future__ import annotations

from typing import Any

Schema = dict[str, Any]


def _object(**properties: Schema) -> Schema:
    return {"type": "object", "properties": properties, "required": list(properties)}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


_TEXT, _FLAG = {"type": "string"}, {"type": "boolean"}
_WHOLE, _NUMBER = {"type": "integer"}, {"type": "number"}
_TIME = {"title": "time", **_object(sec=_WHOLE, nsec=_WHOLE)}
_DURATION = {"title": "duration", **_object(sec=_WHOLE, nsec=_WHOLE)}
_VECTOR = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER)
_QUATERNION = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER)
_POSE = _object(position=_VECTOR, orientation=_QUATERNION)
_COLOR = _object(r=_NUMBER, g=_NUMBER, b=_NUMBER, a=_NUMBER)
_ARROW = _object(
    pose=_POSE,
    shaft_length=_NUMBER,
    shaft_diameter=_NUMBER,
    head_length=_NUMBER,
    head_diameter=_NUMBER,
    color=_COLOR,
)
_CUBE = _object(pose=_POSE, size=_VECTOR, color=_COLOR)
_CYLINDER = _object(pose=_POSE, size=_VECTOR, bottom_scale=_NUMBER, top_scale=_NUMBER, color=_COLOR)
_NOTHING = _object()

_PRIMITIVES = {
    "arrows": _ARROW,
    "cubes": _CUBE,
    "spheres": _CUBE,
    "cylinders": _CYLINDER,
    "lines": _NOTHING,
    "triangles": _NOTHING,
    "texts": _NOTHING,
    "models": _NOTHING,
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
_TRANSFORM = _object(
    timestamp=_TIME,
    parent_frame_id=_TEXT,
    child_frame_id=_TEXT,
    translation=_VECTOR,
    rotation=_QUATERNION,
)
_CONTACT = _object(
    timestamp=_TIME,
    robot=_TEXT,
    counterpart=_TEXT,
    impulse={**_NUMBER, "description": "N s"},
    x={**_NUMBER, "description": "m, in the frame 'warehouse'"},
    y={**_NUMBER, "description": "m, in the frame 'warehouse'"},
)
_ENERGY = _object(
    timestamp=_TIME,
    step=_WHOLE,
    joules={**_list(_NUMBER), "description": "used so far by each robot"},
    battery={**_list(_NUMBER), "description": "units left of each robot"},
)

SCHEMAS: dict[str, Schema] = {
    "foxglove.FrameTransforms": _object(transforms=_list(_TRANSFORM)),
    "foxglove.SceneUpdate": _SCENE,
    "warehouse.Contact": _CONTACT,
    "warehouse.Energy": _ENERGY,
}
"""JSON schemas of messages, by name; each message is an object."""

LAYOUT, BODIES, POSES, HITS = "/layout", "/bodies", "/tf", "/hits"
CONTACTS, ENERGY = "/contacts", "/energy"

SCHEMA_OF = {
    LAYOUT: "foxglove.SceneUpdate",
    BODIES: "foxglove.SceneUpdate",
    POSES: "foxglove.FrameTransforms",
    HITS: "foxglove.SceneUpdate",
    CONTACTS: "warehouse.Contact",
    ENERGY: "warehouse.Energy",
}
"""The schema of each topic."""
