"""Batches of worlds: images of many copies of the scene by one request and one answer. Needs NumPy."""
from __future__ import annotations

import ctypes
import math
from ctypes import POINTER, byref, c_uint32, c_uint64
from typing import TYPE_CHECKING, Any, Dict, Iterable, Literal, Optional, Sequence, Tuple

from . import _library as c
from ._library import encoded, library
from ._numbers import real, seconds, whole
from ._types import Array, Output
from .errors import ArgumentError, ErrorCode, StateError
from .image import ALIASES, BITS_OF_ANY_NAME, OUTPUTS, Handle

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from .stream import Stream

_UNIT_TOLERANCE = 0.01
_MAX_WORLDS = 65_535
_MAX_VIEWS = 65_536
_WAIT_S = 60.0


def _refuse(sentence: str) -> ArgumentError:
    return ArgumentError(ErrorCode.ARGUMENT, sentence)


def _numbers(value: Any, name: str, dtype: Any) -> Any:
    import numpy
    try:
        return numpy.asarray(value, dtype=dtype)
    except (TypeError, ValueError, OverflowError) as fault:
        raise _refuse(f"{name} must hold numbers: {fault}") from None


def _of_quaternions(rows: Any, name: str, is_wxyz: bool) -> Any:
    """(..., 7), position and unit quaternion, to (..., 12)."""
    import numpy
    quaternion = rows[..., 3:]
    length = numpy.linalg.norm(quaternion, axis=-1, keepdims=True)
    wrong = ~(numpy.abs(length - 1) <= _UNIT_TOLERANCE)
    if wrong.any():
        place = "".join(f"[{i}]" for i in numpy.argwhere(wrong)[0][:-1])
        raise _refuse(f"{name}{place} has a quaternion of the length {length[wrong][0]:g}; a unit quaternion is needed")
    parts = numpy.moveaxis(quaternion / length, -1, 0)
    w, x, y, z = parts if is_wxyz else parts[[3, 0, 1, 2]]
    result = numpy.empty((*rows.shape[:-1], 3, 4), numpy.float32)
    result[..., 3] = rows[..., :3]
    for row, turned in enumerate(((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
                                  (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
                                  (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))):
        for column, numbers in enumerate(turned):
            result[..., row, column] = numbers
    return result.reshape(*rows.shape[:-1], 12)


def _poses(value: Any, leading: Tuple[str, ...], name: str, is_wxyz: bool) -> Any:
    """Contiguous float32, (*leading, 12), from (*leading, 12), (*leading, 3, 4), (*leading, 4, 4) or (*leading, 7)."""
    import numpy
    given = _numbers(value, name, numpy.float32)
    shape, count = given.shape, len(leading)
    if given.ndim == count + 2 and shape[-2:] == (4, 4):
        wrong = (given[..., 3, :] != (0, 0, 0, 1)).any(axis=-1)
        if wrong.any():
            place = "".join(f"[{i}]" for i in numpy.argwhere(wrong)[0])
            raise _refuse(f"{name}{place}: the last row of the 4x4 matrix is not [0, 0, 0, 1]: is it transposed?")
        given = given[..., :3, :]
    if given.ndim == count + 2 and given.shape[-2:] == (3, 4):
        given = given.reshape(*shape[:count], 12)
    elif given.ndim == count + 1 and shape[-1] == 7:
        given = _of_quaternions(given, name, is_wxyz)
    elif given.ndim != count + 1 or shape[-1] != 12:
        dimensions = ", ".join(leading)
        raise _refuse(f"{name} has the shape {shape}; ({dimensions}, 12), ({dimensions}, 3, 4), ({dimensions}, 4, 4) or "
                      f"({dimensions}, 7) is needed")
    return numpy.ascontiguousarray(given)


def _check_leading(name: str, shape: Tuple[int, ...], count: int, what: str) -> None:
    if shape[0] not in (1, count):
        raise _refuse(f"{name} has the shape {shape}; its leading dimension is 1 (shared) or {count}, the number of {what}")


class BatchRequest:
    """A batch that was requested and not yet taken. The poses were copied: the next batch may be requested before."""

    def __init__(self, batch: Batch, number: int) -> None:
        self._batch = batch
        self.id = number

    def wait(self, timeout_s: float = _WAIT_S) -> Dict[str, npt.NDArray[Any]]:
        """Waits for the images, see Batch.render. Raises Timeout, or RefusedError with the renderer's reason."""
        return self._batch._wait(self.id, timeout_s)

    def close(self) -> None:
        """Takes the request back. May be called repeatedly, and after the stream is closed."""
        try:
            self._batch._stream._call(library().fire3dv_cancel_image, self.id)
        except StateError:
            pass


class Batch:
    """Views of several worlds: copies of the renderer's scene that differ in the poses of some nodes.

    Made by Stream.batch. W worlds, B nodes with poses, V views. Arrays with a leading dimension of 1 are shared by all
    worlds or views. Several batches may be in use, with other numbers of worlds, views and sizes. Thread-safety: as of
    Stream; a batch has no state of its own but its settings.

    Fields:
        worlds: W. views: (V,) uint32, the world that each view shows. width, height: pixels of a view
        nodes: names of the B nodes. outputs: names of the outputs, as they were given
    """

    def __init__(self, stream: Stream, worlds: int, size: Sequence[int], nodes: Optional[Iterable[str]] = None,
                 views: Optional[Array] = None, outputs: Iterable[Output] = ("color", "depth"), *,
                 node: Optional[str] = None, camera_poses: Optional[Array] = None,
                 camera_matrices: Optional[Array] = None, vertical_fov_rad: float = 0.0, near_m: float = 0.0,
                 far_m: float = 0.0, quaternions: Literal["wxyz", "xyzw"] = "wxyz") -> None:
        """See Stream.batch."""
        import numpy
        self._stream = stream
        self.worlds = whole(worlds, c_uint32, "worlds")
        if not 1 <= self.worlds <= _MAX_WORLDS:
            raise _refuse(f"worlds is {self.worlds}; 1 to {_MAX_WORLDS} are allowed")
        try:
            width, height = size
        except (TypeError, ValueError):
            raise _refuse(f"size is {size!r}; (width, height) in pixels is needed") from None
        self.width, self.height = whole(width, c_uint32, "width"), whole(height, c_uint32, "height")
        if isinstance(outputs, str):
            raise _refuse("outputs is one str; a list of names is needed")
        self.outputs: Tuple[str, ...] = tuple(outputs)
        for output in self.outputs:
            if output not in BITS_OF_ANY_NAME:
                raise _refuse(f"outputs is {output!r}; use one of {', '.join(BITS_OF_ANY_NAME)}")
        if quaternions not in ("wxyz", "xyzw"):
            raise _refuse(f"quaternions is {quaternions!r}; use \"wxyz\" or \"xyzw\"")
        self._is_wxyz = quaternions == "wxyz"
        self.nodes, self._indices = self._find_nodes(nodes)
        self.views: npt.NDArray[np.uint32] = self._read_views(views)
        self._node = encoded(node, "node")
        self._near_m, self._far_m = real(near_m, "near_m"), real(far_m, "far_m")
        fov = real(vertical_fov_rad, "vertical_fov_rad")
        if fov and camera_matrices is not None:
            raise _refuse("vertical_fov_rad and camera_matrices exclude each other")
        if fov and not 0 < fov < math.pi:
            raise _refuse(f"vertical_fov_rad is {fov:g}; more than 0 and less than pi is needed")
        if fov:
            focal = self.height / 2 / math.tan(fov / 2)
            camera_matrices = [[focal, 0, (self.width - 1) / 2], [0, focal, (self.height - 1) / 2], [0, 0, 1]]
        poses = self._read_camera_poses(camera_poses)
        self._camera_poses = None if poses is None else poses.copy()  # the caller may change the array
        self._projections = self._read_matrices(camera_matrices)
        if self._projections is None and node is None:
            raise _refuse("camera_matrices, vertical_fov_rad, or a node with a camera is needed for the projection")

    def _find_nodes(self, nodes: Optional[Iterable[str]]) -> Tuple[Tuple[str, ...], Any]:
        import numpy
        if isinstance(nodes, str):
            raise _refuse("nodes is one str; a list of names is needed")
        described = self._stream._node_names
        if described is None:
            if nodes is None:
                raise StateError(ErrorCode.STATE, "the stream has no nodes yet: give nodes, or call describe()")
            names = list(nodes)
            self._stream.describe(names)
            described = names
        else:
            names = described if nodes is None else list(nodes)
        index_of = {name: index for index, name in enumerate(described)}
        for i, name in enumerate(names):
            if name not in index_of:
                raise _refuse(f"nodes[{i}] is {name!r}, which is none of the stream's nodes: {', '.join(described[:8])}"
                              f"{' ...' if len(described) > 8 else ''}")
        self._described = self._stream._node_names
        return tuple(names), numpy.array([index_of[name] for name in names], numpy.uint32)

    def _read_views(self, views: Optional[Array]) -> Any:
        import numpy
        if views is None:
            return numpy.arange(self.worlds, dtype=numpy.uint32)
        given = numpy.asarray(views)
        if given.ndim != 1 or given.dtype.kind not in "iu" or not 1 <= len(given) <= _MAX_VIEWS:
            raise _refuse(f"views has the shape {given.shape} and the type {given.dtype}; (V,) whole numbers are needed, the "
                          f"world of each view, with V from 1 to {_MAX_VIEWS}")
        wrong = (given < 0) | (given >= self.worlds)
        if wrong.any():
            index = int(numpy.argmax(wrong))
            raise _refuse(f"views[{index}] is {given[index]}; there are worlds 0 to {self.worlds - 1}")
        return numpy.array(given, numpy.uint32)

    def _read_camera_poses(self, value: Optional[Array]) -> Any:
        if value is None:
            return None
        poses = _poses(value, ("V",), "camera_poses", self._is_wxyz)
        _check_leading("camera_poses", poses.shape, len(self.views), "views")
        return poses

    def _read_matrices(self, value: Optional[Array]) -> Any:
        """(1 or V, 4): fx, fy, cx, cy."""
        import numpy
        if value is None:
            return None
        given = _numbers(value, "camera_matrices", numpy.float32)
        if given.shape == (3, 3):
            given = given[None]
        if given.ndim != 3 or given.shape[1:] != (3, 3):
            raise _refuse(f"camera_matrices has the shape {given.shape}; (3, 3) or (V, 3, 3) is needed")
        _check_leading("camera_matrices", given.shape, len(self.views), "views")
        rest = given.copy()
        for row, column in ((0, 0), (1, 1), (0, 2), (1, 2)):
            rest[:, row, column] = 0
        if (rest != (((0, 0, 0), (0, 0, 0), (0, 0, 1)))).any():
            raise _refuse("camera_matrices must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], without skew")
        return numpy.ascontiguousarray(given[:, (0, 1, 0, 1), (0, 1, 2, 2)])

    def request(self, poses: Array, *, camera_poses: Optional[Array] = None, camera_matrices: Optional[Array] = None,
                active: Optional[Array] = None) -> BatchRequest:
        """Requests the images, without waiting. Arguments as of render."""
        import numpy
        described = self._stream._node_names
        if described is not self._described and described != self._described:
            raise StateError(ErrorCode.STATE, "describe() has given the stream other nodes since the batch was made: make it again "
                             "with Stream.batch")
        of_worlds = _poses(poses, ("W", "B"), "poses", self._is_wxyz)
        if of_worlds.shape[1] != len(self.nodes):
            raise _refuse(f"poses has the shape {numpy.shape(poses)}; it has {of_worlds.shape[1]} nodes, the batch {len(self.nodes)}")
        _check_leading("poses", of_worlds.shape, self.worlds, "worlds")
        cameras = self._camera_poses if camera_poses is None else self._read_camera_poses(camera_poses)
        projections = self._projections if camera_matrices is None else self._read_matrices(camera_matrices)
        mask = None
        if active is not None:
            mask = numpy.ascontiguousarray(numpy.asarray(active).astype(bool), numpy.uint8)
            if mask.shape != (self.worlds,):
                raise _refuse(f"active has the shape {mask.shape}; ({self.worlds},) is needed")
        request = c.BatchRequest(struct_size=ctypes.sizeof(c.BatchRequest), worlds=self.worlds,
                                 node_indices=self._indices.ctypes.data, node_count=len(self._indices),
                                 pose_worlds=len(of_worlds), poses=of_worlds.ctypes.data,
                                 world_of_view=self.views.ctypes.data, views=len(self.views), node=self._node,
                                 width=self.width, height=self.height, near_m=self._near_m, far_m=self._far_m)
        if cameras is not None:
            request.parent_from_camera, request.pose_views = cameras.ctypes.data, len(cameras)
        if projections is not None:
            request.fx, request.fy, request.cx, request.cy = projections[0].tolist()
            if len(projections) > 1:
                request.projections = projections.ctypes.data
        if mask is not None:
            request.active = mask.ctypes.data
        for output in self.outputs:
            request.outputs |= BITS_OF_ANY_NAME[output]
        number = c_uint64()
        self._stream._call(library().fire3dv_request_batch, byref(request), byref(number))
        return BatchRequest(self, number.value)

    def render(self, poses: Array, *, camera_poses: Optional[Array] = None, camera_matrices: Optional[Array] = None,
               active: Optional[Array] = None, timeout_s: float = _WAIT_S) -> Dict[str, npt.NDArray[Any]]:
        """Draws all views and returns their images: for each output, by its given name, an array (V, height, width, C).

        poses: (W, B, 12), (W, B, 3, 4) or (W, B, 4, 4), stream_from_body, row-major; or (W, B, 7), position and unit
        quaternion (`quaternions` of Stream.batch has its order). Metres, unless world_from_stream scales. Contiguous
        float32 arrays of 12 numbers are copied once. Leading dimension 1: the same in all worlds.
        camera_poses: (V, 12), ... or (V, 7), as poses, of cameras that look along -Z with +Y up, in the batch's node or the
        stream; instead of those of Stream.batch. camera_matrices: (3, 3) or (V, 3, 3), instead of those of Stream.batch.
        active: (W,) booleans; views of other worlds are not drawn, and all of their numbers are 0.

        The arrays are read-only and view the received memory without a copy, "color" (V, H, W, 4) uint8, "depth"
        (V, H, W, 1) float32 in metres along the camera's axis, infinity for the background; others as fire3dv.Image has
        them. View v shows world views[v] exactly as a batch of this world alone shows it, byte for byte (but for shadow maps of
        very many worlds: docs/batches.md).

        Raises Timeout, RefusedError (the renderer's reason; where the worlds do not fit, with the number that does),
        ArgumentError, and StateError after a describe() with other nodes. After any exception the request is taken back.
        """
        request = self.request(poses, camera_poses=camera_poses, camera_matrices=camera_matrices, active=active)
        try:
            return request.wait(timeout_s)
        except BaseException:  # Ctrl-C, too: nobody else has the request
            request.close()
            raise

    def _wait(self, number: int, timeout_s: float) -> Dict[str, npt.NDArray[Any]]:
        import numpy
        pointer = POINTER(c.Image)()
        stream = self._stream
        stream._wait(seconds(timeout_s, "timeout_s"),
                     lambda wait_ms: stream._open_handle().call(library().fire3dv_wait_image, number, wait_ms, byref(pointer)))
        handle = Handle(pointer)
        raw = pointer.contents
        stream._look_for_answer(0)
        planes = {raw.planes[i].output: raw.planes[i] for i in range(raw.plane_count)}
        images = {}
        for output in self.outputs:
            plane = planes[BITS_OF_ANY_NAME[output]]
            dtype, channels = OUTPUTS[ALIASES.get(output, output)]
            memory = (ctypes.c_ubyte * (plane.row_stride * plane.height)).from_address(plane.data)
            memory.owner = handle  # type: ignore[attr-defined]
            images[output] = numpy.ndarray((raw.views, self.height, self.width, channels), dtype, memory)
            images[output].flags.writeable = False
        return images

    def __repr__(self) -> str:
        return (f"<fire3dv.Batch of {self._stream!r}: {self.worlds} worlds, {len(self.views)} views of "
                f"{self.width}x{self.height}>")
