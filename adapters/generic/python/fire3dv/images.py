"""Images that renderers return: views of a stream's frames by cameras of the scene."""
from __future__ import annotations

import ctypes
import math
import time
from ctypes import POINTER, byref, c_float, c_uint32, c_uint64
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple

from . import _library as c
from ._library import check, encoded, library
from ._numbers import real, rigid, seconds, whole
from .errors import ArgumentError, ErrorCode, StateError, Timeout

if TYPE_CHECKING:
    import numpy as np

    from .renderer import Renderer
    from .stream import Array, Stream

#: Outputs by name: NumPy type of an element, elements per pixel.
OUTPUTS: Dict[str, Tuple[Any, int]] = {
    "color_srgb8": ("u1", 4),        # sRGB red, green, blue after tone mapping; 255
    "color_linear_f16": ("<f2", 4),  # linear RGB before tone mapping; 1
    "depth_f32": ("<f4", 1),         # metres along the camera axis (planar depth); infinity for background
    "instance_u32": ("<u4", 1),      # 1 + index of the scene node; 0 for background
    "semantic_u32": ("<u4", 1),      # semantic class of that node; 0: none
    "normal": ("<f2", 4),            # world-space unit normal x, y, z; 0
    "motion": ("<f4", 2),            # motion vector in pixels since the previous image of this request
    "boxes2d": ([("instance", "<u4"), ("semantic", "<u4"), ("min_x", "<u4"), ("min_y", "<u4"), ("max_x", "<u4"),
                 ("max_y", "<u4"), ("pixels", "<u4"), ("reserved", "<u4")], 1),
    "boxes3d": ([("instance", "<u4"), ("semantic", "<u4"), ("world_from_box", "<f4", (3, 4)),
                 ("reserved", "<u4", (2,))], 1),
}
_BITS = {name: 1 << bit for bit, name in enumerate(OUTPUTS)}
_NAMES = {bit: name for name, bit in _BITS.items()}
_WHEN = {"once": 1, "every_nth": 2, "rate": 3, "exactly": 4}
_LENSES = {"none": 0, "plumb_bob": 1, "fisheye": 2}
_SLICE_S = 0.2


class _Handle:
    """Owner of the library's image. Arrays that view its pixels hold a reference to it."""

    def __init__(self, pointer: Any) -> None:
        self.pointer = pointer

    def __del__(self) -> None:
        library().fire3dv_release_image(byref(self.pointer))


class Image:
    """One image, and the identity of the frame it shows.

    image["depth_f32"] is a read-only NumPy array that views the received pixels without a copy, rows from the top:
    (height, width) or (height, width, channels), of the type in OUTPUTS; boxes are (count,) records. Over shm:// an
    image slot stays reserved until the image and all of its arrays are deleted: copy pixels for long-term use.
    """

    def __init__(self, handle: _Handle) -> None:
        raw = handle.pointer.contents
        self._handle: Optional[_Handle] = handle
        self._planes = {_NAMES[plane.output]: plane for plane in raw.planes[:raw.plane_count]}
        self.request: int = raw.request  #: ImageRequest.id
        self.epoch: int = raw.epoch
        self.sequence: int = raw.sequence  #: pose frame shown; 0: none was published yet
        self.sim_time_ns: int = raw.sim_time_ns
        self.number: int = raw.number  #: index among the images of this request, from 1
        self.lost: int = raw.lost  #: images lost between the previously taken one and this one
        self.width: int = raw.width
        self.height: int = raw.height
        self.fx: float = raw.fx  #: pixels; the centre of the top left pixel is (0, 0), as in OpenCV
        self.fy: float = raw.fy
        self.cx: float = raw.cx
        self.cy: float = raw.cy
        self.near_m: float = raw.near_m
        self.far_m: float = raw.far_m  #: 0: infinite
        self.lens: str = {number: name for name, number in _LENSES.items()}[raw.lens]
        self.lens_coefficients: Tuple[float, ...] = tuple(raw.lens_coefficients)
        #: 12 numbers, row-major: rotation and translation. The camera looks along -Z, +Y is up
        self.world_from_camera: Tuple[float, ...] = tuple(raw.world_from_camera)

    @property
    def outputs(self) -> Tuple[str, ...]:
        return tuple(self._planes)

    def __getitem__(self, output: str) -> "np.ndarray[Any, Any]":
        import numpy
        if self._handle is None:
            raise StateError(ErrorCode.STATE, "the image was released")
        if output not in self._planes:
            raise KeyError(f"the image has no {output}; it has: {', '.join(self._planes)}")
        plane = self._planes[output]
        dtype, channels = numpy.dtype(OUTPUTS[output][0]), OUTPUTS[output][1]
        shape: Tuple[int, ...] = (plane.height, plane.width)
        strides: Tuple[int, ...] = (plane.row_stride, dtype.itemsize * channels)
        if output.startswith("boxes"):
            shape, strides = shape[1:], strides[1:]
        elif channels > 1:
            shape, strides = (*shape, channels), (*strides, dtype.itemsize)
        if plane.width == 0:
            return numpy.empty(shape, dtype)
        memory = (ctypes.c_ubyte * (plane.row_stride * plane.height)).from_address(plane.data)
        memory.owner = self._handle  # type: ignore[attr-defined]
        array: "np.ndarray[Any, Any]" = numpy.ndarray(shape, dtype, memory, strides=strides)
        array.flags.writeable = False
        return array

    def release(self) -> None:
        """Releases the memory once no array views it. May be called repeatedly."""
        self._handle = None

    def __enter__(self) -> Image:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


class ImageRequest:
    """An open image request of a stream. cancel() or the end of a with statement ends it."""

    def __init__(self, stream: Stream, number: int) -> None:
        self._stream = stream
        self.id = number

    def wait(self, timeout_s: float = 10.0) -> Image:
        """Waits for the next image. Raises Timeout, or RefusedError if there will be none."""
        return self._stream.wait_image(timeout_s, self)

    def poll(self) -> Optional[Image]:
        """Returns the next image if it has arrived, else None. Does not block. Raises RefusedError."""
        try:
            return self._stream.wait_image(0, self)
        except Timeout:
            return None

    def cancel(self) -> None:
        """Ends the request. May be called repeatedly, and after the stream is closed."""
        if self._stream.is_open:
            check(library().fire3dv_cancel_image(self._stream.handle, self.id))

    def __enter__(self) -> ImageRequest:
        return self

    def __exit__(self, *_: object) -> None:
        self.cancel()


def _number_of(names: Dict[str, int], name: Any, what: str) -> int:
    if name not in names:
        raise ArgumentError(ErrorCode.ARGUMENT, f"{what} is {name!r}; use one of {', '.join(names)}")
    return names[name]


class ImageRequests:
    """Image functions of a Stream."""

    handle: Any
    renderer: Optional[Renderer] = None  #: set by Renderer.stream

    def request_image(self, width: int, height: int, *, node: Optional[str] = None,
                      parent_from_camera: Optional[Array] = None, fx: float = 0.0, fy: Optional[float] = None,
                      cx: Optional[float] = None, cy: Optional[float] = None, near_m: float = 0.0,
                      far_m: float = 0.0, lens: str = "none", lens_coefficients: Sequence[float] = (),
                      outputs: Iterable[str] = ("color_srgb8",), when: str = "once", every: int = 1,
                      rate_hz: float = 0.0, sequence: int = 0) -> ImageRequest:
        """Requests images of a camera. Does not block.

        node: parent of the camera; None: the stream's frame. parent_from_camera: (3, 4) or (4, 4), rotation and position
        in metres; the camera looks along -Z, +Y is up: fire3dv.look_at. None: the identity.
        fx, fy, cx, cy: pixels; (0, 0) is the centre of the top left pixel. fx 0: projection of the node's camera.
        Defaults: fy = fx, and cx, cy at the image centre. near_m 0: 0.01; far_m 0: infinite.
        lens: "none", "plumb_bob" (k1 k2 p1 p2 k3) or "fisheye" (k1 k2 k3 k4). outputs: names of OUTPUTS.
        when: "once", "every_nth" (shown frame), "rate" (rate_hz per second) or "exactly" (the frame `sequence`).
        sequence: first frame that may be shown; 0: the newest published one.
        """
        pose = rigid(parent_from_camera, "parent_from_camera")
        if isinstance(outputs, str):
            raise ArgumentError(ErrorCode.ARGUMENT, "outputs is one str; a list of names is needed")
        bits = 0
        for output in outputs:
            bits |= _number_of(_BITS, output, "outputs")
        if len(lens_coefficients) > 5:
            raise ArgumentError(ErrorCode.ARGUMENT, f"{len(lens_coefficients)} lens_coefficients; there are 5 at most")
        width, height = whole(width, c_uint32, "width"), whole(height, c_uint32, "height")
        request = c.ImageRequest(
            ctypes.sizeof(c.ImageRequest), encoded(node, "node"), pose.address, width, height, real(fx, "fx"),
            real(fx if fy is None else fy, "fy"), real((width - 1) / 2 if cx is None else cx, "cx"),
            real((height - 1) / 2 if cy is None else cy, "cy"), real(near_m, "near_m"), real(far_m, "far_m"),
            _number_of(_LENSES, lens, "lens"),
            (c_float * 5)(*[real(k, "lens_coefficients") for k in lens_coefficients]), bits,
            _number_of(_WHEN, when, "when"), whole(every, c_uint32, "every"), real(rate_hz, "rate_hz"),
            whole(sequence, c_uint64, "sequence"))
        number = c_uint64()
        check(library().fire3dv_request_image(self.handle, byref(request), byref(number)))
        return ImageRequest(self, number.value)  # type: ignore[arg-type]

    def wait_image(self, timeout_s: float = 10.0, request: Optional[ImageRequest] = None) -> Image:
        """Waits for the next image of `request`, or of any request. Raises Timeout, or RefusedError."""
        pointer = POINTER(c.Image)()
        number = request.id if request else 0
        self._wait(seconds(timeout_s, "timeout_s"),
                   lambda wait_ms: library().fire3dv_wait_image(self.handle, number, wait_ms, byref(pointer)))
        return Image(_Handle(pointer))

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
                return check(code)

    def images(self, timeout_s: float = 10.0) -> Iterator[Image]:
        """Yields images of all requests in order of arrival, until none arrives for timeout_s."""
        while True:
            try:
                yield self.wait_image(timeout_s)
            except Timeout:
                return

    def step(self, sim_time_ns: int, stream_from_body: Array, requests: Sequence[ImageRequest],
             timeout_s: float = 10.0, flags: int = 0) -> List[Image]:
        """Lockstep: publishes a frame and waits for its image from each request.

        requests: with when="every_nth" and every=1. Images of earlier frames are skipped.
        """
        sequence = self.publish(sim_time_ns, stream_from_body, flags)  # type: ignore[attr-defined]
        images = []
        for request in requests:
            image = request.wait(timeout_s)
            while image.sequence < sequence:
                image = request.wait(timeout_s)
            images.append(image)
        return images
