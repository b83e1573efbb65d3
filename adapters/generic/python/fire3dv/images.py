"""Image requests of a stream: views of its frames by cameras of the scene."""
from __future__ import annotations

import ctypes
import math
import re
import time
from ctypes import POINTER, byref, c_float, c_uint32, c_uint64
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, Iterator, List, Literal, Mapping, Optional, Sequence, Tuple

from . import _library as c
from ._handle import StreamHandle
from ._library import check, encoded, library
from ._numbers import real, rigid, seconds, whole
from ._types import Array, Lens, Output, When
from .errors import ArgumentError, ErrorCode, StateError, Timeout
from .image import BITS_OF_ANY_NAME, IDENTITY, LENSES, Handle, Image

if TYPE_CHECKING:
    from .batch import Batch
    from .renderer import Renderer
    from .stream import Stream

WHEN: Dict[When, int] = {"once": 1, "every_nth": 2, "rate": 3, "exactly": 4}
# Default limit of one wait. The first image on a software driver with an empty shader cache takes 6 to 35 s.
WAIT_S = 60.0
_SLICE_S = 0.05  # a stream is freed after the slices of waits in other threads


class ImageRequest:
    """An open image request of a stream. close() or the end of a with statement ends it."""

    def __init__(self, stream: Stream, number: int) -> None:
        self._stream = stream
        self.id = number

    def wait(self, timeout_s: float = WAIT_S) -> Image:
        """Waits for the next image. Raises Timeout, or RefusedError if there will be none."""
        return self._stream.wait_image(timeout_s, self)

    def poll(self) -> Optional[Image]:
        """Returns the next image if it has arrived, else None. Does not block. Raises RefusedError."""
        try:
            return self._stream.wait_image(0, self)
        except Timeout:
            return None

    def close(self) -> None:
        """Ends the request. May be called repeatedly, and after the stream is closed."""
        try:
            self._stream._call(library().fire3dv_cancel_image, self.id)
        except StateError:  # the stream, and with it the request, has ended
            pass

    cancel = close

    def __enter__(self) -> ImageRequest:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<fire3dv.ImageRequest {self.id} of {self._stream!r}>"


def _number_of(names: Mapping[Any, int], name: Any, what: str) -> int:
    if name not in names:
        raise ArgumentError(ErrorCode.ARGUMENT, f"{what} is {name!r}; use one of {', '.join(names)}")
    return names[name]


class ImageRequests:
    """Image functions of a Stream."""

    _call: Callable[..., None]
    _open_handle: Callable[[], StreamHandle]
    renderer: Optional[Renderer] = None  #: set by Renderer.stream
    _look_for_answer: Callable[[float], None]
    _sequence: int
    _world_from_stream: Tuple[float, ...] = IDENTITY  # of describe()

    def request_image(self, width: int, height: int, *, node: Optional[str] = None,
                      parent_from_camera: Optional[Array] = None, fx: float = 0.0, fy: Optional[float] = None,
                      cx: Optional[float] = None, cy: Optional[float] = None, near_m: float = 0.0,
                      far_m: float = 0.0, lens: Lens = "none", lens_coefficients: Sequence[float] = (),
                      outputs: Iterable[Output] = ("color",), when: When = "once", every: int = 1,
                      rate_hz: float = 0.0, sequence: int = 0, markers: bool = False, f_number: float = 0.0,
                      focus_distance_m: float = 0.0, complete: bool = False) -> ImageRequest:
        """Requests images of a camera. Does not block.

        node: parent of the camera; None: the stream's frame. parent_from_camera: (3, 4) or (4, 4), rotation and
        position in metres; the camera looks along -Z, +Y is up: fire3dv.look_at. None: the identity.
        fx, fy, cx, cy: pixels; (0, 0) is the centre of the top left pixel. fx 0: projection of the node's camera.
        Defaults: fy = fx, and cx, cy at the image centre. near_m 0: 0.01; far_m 0: infinite.
        lens: "none", "plumb_bob" (k1 k2 p1 p2 k3) or "fisheye" (k1 k2 k3 k4). outputs: names of OUTPUTS or
        ALIASES, such as "depth".
        when: "once", "every_nth" (shown frame), "rate" (rate_hz per second) or "exactly" (the frame `sequence`).
        sequence: first frame that may be shown; 0: the newest published one.
        f_number, focus_distance_m: thin lens for depth of field of "color" and "linear", aperture (0.1 to 1000) and
        metres along the view direction to the plane in focus; both 0: the lens of the node's camera, or of the
        renderer's settings. The image says which lens was used.
        markers: True: "color" shows the markers of streams; other outputs never do. Not together with "linear".
        complete: True: refused while the renderer hides the content of a stream that takes too much drawing time;
        False: images come without it, and Image.hidden_streams is not 0.
        """
        pose = rigid(parent_from_camera, "parent_from_camera")
        if isinstance(outputs, str):
            raise ArgumentError(ErrorCode.ARGUMENT, "outputs is one str; a list of names is needed")
        bits = 0
        for output in outputs:
            bits |= _number_of(BITS_OF_ANY_NAME, output, "outputs")
        if len(lens_coefficients) > 5:
            raise ArgumentError(ErrorCode.ARGUMENT, f"{len(lens_coefficients)} lens_coefficients; there are 5 at most")
        width, height = whole(width, c_uint32, "width"), whole(height, c_uint32, "height")
        request = c.ImageRequest(
            ctypes.sizeof(c.ImageRequest), encoded(node, "node"), pose.address, width, height, real(fx, "fx"),
            real(fx if fy is None else fy, "fy"), real((width - 1) / 2 if cx is None else cx, "cx"),
            real((height - 1) / 2 if cy is None else cy, "cy"), real(near_m, "near_m"), real(far_m, "far_m"),
            _number_of(LENSES, lens, "lens"),
            (c_float * 5)(*[real(k, "lens_coefficients") for k in lens_coefficients]), bits,
            _number_of(WHEN, when, "when"), whole(every, c_uint32, "every"), real(rate_hz, "rate_hz"),
            whole(sequence, c_uint64, "sequence"), int(bool(markers)), real(f_number, "f_number"),
            real(focus_distance_m, "focus_distance_m"), 0, int(bool(complete)))
        number = c_uint64()
        self._call(library().fire3dv_request_image, byref(request), byref(number))
        return ImageRequest(self, number.value)  # type: ignore[arg-type]

    def batch(self, worlds: int, size: Sequence[int], nodes: Optional[Iterable[str]] = None,
              views: Optional[Array] = None, outputs: Iterable[Output] = ("color", "depth"), *, node: Optional[str] = None,
              camera_poses: Optional[Array] = None, camera_matrices: Optional[Array] = None, vertical_fov_rad: float = 0.0,
              near_m: float = 0.0, far_m: float = 0.0, quaternions: Literal["wxyz", "xyzw"] = "wxyz") -> Batch:
        """Returns a Batch, whose render(poses) draws many small images of many worlds at once. Needs NumPy.

        worlds: W, copies of the renderer's scene that differ in their poses. size: (width, height) of a view, in pixels.
        nodes: names of the nodes that have poses, of those of describe(); None: all. Where describe() was not called, the
        batch calls it with these names. Other nodes rest. views: (V,), the world that each view shows; None: one view of
        each world. outputs: names of OUTPUTS or ALIASES, but for linear, motion, occlusion and boxes.
        node: parent of the cameras, in each world; None: the stream's frame. camera_poses: (V, 12), (V, 3, 4), (V, 4, 4) or
        (V, 7), leading dimension 1: of all views; None: the identity.
        camera_matrices: (3, 3) or (V, 3, 3), [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels as of OpenCV; or
        vertical_fov_rad; or neither: the projection of the node's own camera. near_m 0: 0.01; far_m 0: infinite.
        quaternions: order of the numbers of quaternions, "wxyz" (MuJoCo, MJX) or "xyzw" (Warp, Isaac, SciPy).
        """
        from .batch import Batch
        return Batch(self, worlds, size, nodes, views, outputs, node=node,  # type: ignore[arg-type]
                     camera_poses=camera_poses, camera_matrices=camera_matrices, vertical_fov_rad=vertical_fov_rad,
                     near_m=near_m, far_m=far_m, quaternions=quaternions)

    def wait_image(self, timeout_s: float = WAIT_S, request: Optional[ImageRequest] = None) -> Image:
        """Waits for the next image of `request`, or of any request but batches. Raises Timeout, or RefusedError."""
        pointer = POINTER(c.Image)()
        number = request.id if request else 0
        self._wait(seconds(timeout_s, "timeout_s"),
                   lambda wait_ms: self._open_handle().call(library().fire3dv_wait_image, number, wait_ms, byref(pointer)))
        renderer = self.renderer
        if renderer is None:
            image = Image(Handle(pointer), None, self._world_from_stream)
        else:
            states = renderer.instances.current(pointer.contents.sequence >= self._sequence)
            image = Image(Handle(pointer), renderer.scene_names, self._world_from_stream, states)
        self._look_for_answer(0)
        return image

    def _wait(self, timeout_s: float, call: Callable[[int], int]) -> None:
        """Calls call(milliseconds) until it returns no timeout, or timeout_s is over. Raises the exception of its code.

        In slices, so that Ctrl-C and the end of a Renderer interrupt the wait.
        """
        end = time.monotonic() + timeout_s
        while True:
            left_s = max(0.0, end - time.monotonic())
            code = call(math.ceil(1000 * min(left_s, _SLICE_S)))
            if code != ErrorCode.TIMEOUT:
                return check(code)
            if self.renderer is not None and timeout_s > 0:
                self.renderer.check()
            if left_s <= _SLICE_S:
                try:
                    return check(code)
                except Timeout as last:  # its text has the time of the last slice
                    text = re.sub(r"within \d+ ms", f"within {timeout_s:g} s", str(last))
                    raise Timeout(ErrorCode.TIMEOUT, text) from None

    def images(self, timeout_s: float = 10.0) -> Iterator[Image]:
        """Yields images of all requests but batches in order of arrival, until none arrives for timeout_s."""
        while True:
            try:
                yield self.wait_image(timeout_s)
            except Timeout:
                return

    def step(self, sim_time_ns: int, stream_from_body: Array, requests: Sequence[ImageRequest],
             timeout_s: float = WAIT_S, flags: int = 0) -> List[Image]:
        """Lockstep: publishes a frame and waits for its image from each request.

        requests: with when="every_nth" and every=1. Images of earlier frames are skipped.
        """
        return images_of(self.publish(sim_time_ns, stream_from_body, flags), requests, timeout_s)  # type: ignore


def images_of(sequence: int, requests: Sequence[ImageRequest], timeout_s: float) -> List[Image]:
    """Waits for the image of this frame, or of a later one, from each request."""
    images = []
    for request in requests:
        image = request.wait(timeout_s)
        while image.sequence < sequence:
            image = request.wait(timeout_s)
        images.append(image)
    return images
