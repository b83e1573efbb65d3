"""FIRE-3DV client for Python 3.9 and later: publishes the poses of a simulation, and edits of its scene, to renderers.

    import fire3dv
    with fire3dv.Stream("shm://demo", adapter_name="my simulator") as stream:
        stream.describe(["base", "arm"])
        while True:
            step()
            stream.publish(sim_time_ns, poses)      # (2, 3, 4) float32, stream_from_body

    camera = stream.request_image(640, 480, node="wrist_camera", when="every_nth")
    [image] = stream.step(sim_time_ns, poses, [camera])     # publishes, and waits for the image of that frame
    image.color                                             # (480, 640, 4) uint8

    with fire3dv.Renderer("scene.glb") as renderer, renderer.stream() as stream:    # starts the renderer, too
        ...

    with fire3dv.Robot("arm.urdf").publish("shm://demo") as robot:      # poses from joint positions
        robot.set(shoulder=0.3, elbow=-1.2)

A layer of ctypes over the C library, whose headers fire3dv/client.h, scene.h, markers.h, scalars.h, input.h, image.h, batch.h and joints.h say what
each call means: units, frames, threads, waiting. Contiguous float32 (a NumPy array, an array.array("f")) goes into the library without
a copy; other arrays and nested sequences are converted. Everything that can fail raises fire3dv.Error; a missing
renderer is not an error. Where the library is looked for stands in README.md, FIRE3DV_CLIENT_LIBRARY in the
environment first.
"""
from ._types import Lens, Output, When
from .batch import Batch, BatchRequest
from .calibration import CalibratedCamera, read_calibration
from .errors import (ArgumentError, BudgetError, Error, ErrorCode, LibraryNotFound, OperatingSystemError,
                     RefusedError, RendererError, RendererNotFound, SceneWarning, StateError, Timeout)
from .image import ALIASES, OUTPUTS, Image
from .images import ImageRequest
from .controls import Action, Control, Controls, Event, InputKind
from .live_view import LiveView, show
from .poses import look_at, pose
from .renderer import Renderer, find_program
from .robot import Joint, JointType, Robot, RobotPublisher
from .status import LightKind, MarkerKind, Property, Status, Welcome
from .stream import FRAME_DISCONTINUITY, Stream, version

#: Of this package; version() is that of the C library.
__version__ = "0.2.0"

VISIBLE, BASE_COLOR, LIGHT, CAMERA, NODE, VERTICES, MARKER = Property
DIRECTIONAL, POINT, SPOT = LightKind
ERROR_ARGUMENT, ERROR_STATE, ERROR_SYSTEM, ERROR_TIMEOUT, ERROR_BUDGET, ERROR_REFUSED = ErrorCode

__all__ = [
    "ArgumentError", "BudgetError", "Error", "ErrorCode", "LibraryNotFound", "OperatingSystemError",
    "RefusedError", "RendererError", "RendererNotFound", "SceneWarning", "StateError",
    "Timeout", "Lens", "Output", "When", "__version__", "ALIASES", "OUTPUTS", "Batch", "BatchRequest", "Image",
    "ImageRequest", "CalibratedCamera", "read_calibration",
    "Action", "Control", "Controls", "Event", "InputKind",
    "LiveView", "show", "Renderer", "find_program", "look_at", "pose", "Joint", "JointType", "Robot", "RobotPublisher",
    "LightKind", "MarkerKind", "Property", "Status", "Welcome", "FRAME_DISCONTINUITY", "Stream", "version",
    "VISIBLE", "BASE_COLOR", "LIGHT", "CAMERA", "NODE", "VERTICES", "MARKER", "DIRECTIONAL", "POINT", "SPOT",
    "ERROR_ARGUMENT", "ERROR_STATE", "ERROR_SYSTEM", "ERROR_TIMEOUT", "ERROR_BUDGET",
    "ERROR_REFUSED",
]
