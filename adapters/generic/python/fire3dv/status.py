"""What renderers have answered, and what edits are called."""
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
    """Of a node: what can be edited and taken back (Stream.clear)."""
    VISIBLE = 0
    BASE_COLOR = 1
    LIGHT = 2
    CAMERA = 3
    NODE = 4  #: that the node is there: added and removed nodes
    VERTICES = 5


class LightKind(IntEnum):
    DIRECTIONAL = 0
    POINT = 1
    SPOT = 2


@dataclass(frozen=True)
class Status:
    """What Stream.poll returns; fire3dv_status in client.h."""
    renderers: int  #: connected or attached now
    epoch: int  #: random id of this stream's description
    sequence: int  #: of the last published frame, 0: none
    acked_sequence: int  #: newest frame that a renderer has shown, 0: none
    frames_published: int
    frames_dropped: int  #: overtaken by a newer frame before all of them had left
    welcome: int  #: one of Welcome, or what a later renderer says
    unmatched_names: int  #: of the last answer: names that no scene node has
    welcome_message: str  #: one line for people; while no renderer is reached: why
    conflicting_names: int  #: nodes that another stream drives already
    contested_names: int  #: nodes that this stream drives and another one asks for
