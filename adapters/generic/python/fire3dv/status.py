"""Status of renderers, and names of scene properties."""
from dataclasses import dataclass
from enum import IntEnum


class Welcome(IntEnum):
    """A renderer's last answer to the description."""
    NONE_YET = -1
    ACCEPTED = 0
    VERSION_MISMATCH = 1
    BAD_DESCRIPTION = 2
    REFUSED = 3
    BAD_KEY = 4


class Property(IntEnum):
    """Editable properties of a node, for Stream.clear."""
    VISIBLE = 0
    BASE_COLOR = 1
    LIGHT = 2
    CAMERA = 3
    NODE = 4  #: existence of the node: added and removed nodes
    VERTICES = 5
    MARKER = 6  #: the name is the marker's; Stream.clear_marker


class MarkerKind(IntEnum):
    """Shapes of markers, for Stream.set_marker; each has a method of its own, such as Stream.points."""
    POINTS = 0
    LINES = 1
    LINE_STRIP = 2
    ARROWS = 3
    AXES = 4
    BOXES = 5
    SPHERES = 6
    CYLINDERS = 7
    CAPSULES = 8
    TRIANGLES = 9
    TEXTS = 10
    IMAGES = 11


class LightKind(IntEnum):
    """Kinds of lights, for Stream.set_light."""
    DIRECTIONAL = 0
    POINT = 1
    SPOT = 2


@dataclass(frozen=True)
class Status:
    """Result of Stream.poll; fire3dv_status in client.h."""
    renderers: int  #: connected or attached renderers
    epoch: int  #: random id of the current description
    sequence: int  #: last published frame, 0: none
    acked_sequence: int  #: newest frame that a renderer has shown, 0: none
    frames_published: int
    frames_dropped: int  #: superseded by a newer frame before they were sent completely
    welcome: int  #: one of Welcome, or a value of a later protocol version
    unmatched_names: int  #: names without a scene node, from the last answer
    welcome_message: str  #: one line for users; the cause while no renderer is reached
    conflicting_names: int  #: nodes that another stream drives already
    contested_names: int  #: nodes that this stream drives and another stream requests
    images_dropped: int = 0  #: malformed, or no answer to their request
