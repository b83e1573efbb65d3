"""Poses from positions and quaternions, and of cameras. Needs NumPy."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Tuple

from ._types import Array, Float32Array
from .errors import ArgumentError, ErrorCode

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

_UNIT_TOLERANCE = 0.01


def _vectors(value: Any, name: str, size: int) -> npt.NDArray[np.float64]:
    import numpy
    try:
        vectors = numpy.asarray(value, dtype=numpy.float64)
    except (TypeError, ValueError) as fault:
        raise ArgumentError(ErrorCode.ARGUMENT, f"{name} must hold numbers: {fault}") from None
    if vectors.ndim not in (1, 2) or vectors.shape[-1] != size:
        raise ArgumentError(ErrorCode.ARGUMENT,
                            f"{name} has the shape {vectors.shape}; ({size},) or (n, {size}) is needed")
    if not numpy.isfinite(vectors).all():
        row = numpy.argwhere(~numpy.isfinite(vectors))[0]
        where = "".join(f"[{i}]" for i in row)
        raise ArgumentError(ErrorCode.ARGUMENT, f"{name}{where} is {vectors[tuple(row)]}; a finite number is needed")
    return vectors


def _rotations(quaternion: npt.NDArray[np.float64], name: str) -> npt.NDArray[np.float64]:
    """(..., 4) as x, y, z, w to (..., 3, 3)."""
    import numpy
    length = numpy.linalg.norm(quaternion, axis=-1, keepdims=True)
    wrong = numpy.abs(length - 1) > _UNIT_TOLERANCE
    if wrong.any():
        where = f"[{int(numpy.argwhere(wrong)[0][0])}]" if quaternion.ndim == 2 else ""
        raise ArgumentError(ErrorCode.ARGUMENT, f"{name}{where} has the length {length[wrong][0]:g}; a unit quaternion "
                            "is needed: divide it by its length")
    x, y, z, w = numpy.moveaxis(quaternion / length, -1, 0)
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    return numpy.moveaxis(numpy.array(rows), (0, 1), (-2, -1))


def pose(position: Array = (0, 0, 0), quaternion: Optional[Array] = None, *,
         wxyz: Optional[Array] = None) -> Float32Array:
    """Returns rigid poses, (3, 4) or (n, 3, 4) float32: `parent_from_body`, rotation and position of a body.

    position: (3,) or (n, 3), metres, in the parent's frame (for Stream.publish: the stream's).
    quaternion: (4,) or (n, 4) unit quaternions x, y, z, w, as of SciPy, ROS, glTF and Bullet. wxyz: instead of it, w
    first, as of MuJoCo. Without either there is no rotation. One position or rotation applies to all n of the other.
    """
    import numpy
    places = _vectors(position, "position", 3)
    if quaternion is not None and wxyz is not None:
        raise ArgumentError(ErrorCode.ARGUMENT, "quaternion and wxyz exclude each other")
    if wxyz is not None:
        turns = _rotations(numpy.roll(_vectors(wxyz, "wxyz", 4), -1, axis=-1), "wxyz")
    elif quaternion is not None:
        turns = _rotations(_vectors(quaternion, "quaternion", 4), "quaternion")
    else:
        turns = numpy.eye(3)
    if places.ndim == 2 and turns.ndim == 3 and len(places) != len(turns):
        raise ArgumentError(ErrorCode.ARGUMENT, f"{len(places)} positions for {len(turns)} quaternions")
    several: Tuple[int, ...] = places.shape[:-1] or turns.shape[:-2]
    result = numpy.empty((*several, 3, 4), numpy.float32)
    result[..., :3] = turns
    result[..., 3] = places
    return result


def look_at(eye: Array, target: Array, up: Array = (0, 1, 0)) -> Float32Array:
    """Returns the pose, (3, 4) float32, of a camera or light at eye: its -Z axis points to target, its +Y axis to up.

    eye, target: (3,), metres. up: (3,) direction. All in the parent's frame, which is also that of the result: for a
    stream with Z up, up is (0, 0, 1).
    """
    import numpy
    points = [_vectors(value, name, 3) for value, name in ((eye, "eye"), (target, "target"), (up, "up"))]
    for point, name in zip(points, ("eye", "target", "up")):
        if point.ndim != 1:
            raise ArgumentError(ErrorCode.ARGUMENT, f"{name} has the shape {point.shape}; (3,) is needed")
    origin, seen, above = points
    back = origin - seen
    distance = numpy.linalg.norm(back)
    if not distance > 0:
        raise ArgumentError(ErrorCode.ARGUMENT, f"eye and target are the same point, {tuple(origin.tolist())}")
    back /= distance
    right = numpy.cross(above, back)
    sine = numpy.linalg.norm(right)
    if not sine > 1e-6 * numpy.linalg.norm(above):
        raise ArgumentError(ErrorCode.ARGUMENT, f"up is {tuple(above.tolist())}, which is zero or along the view: "
                            "give another direction")
    right /= sine
    return numpy.column_stack([right, numpy.cross(back, right), back, origin]).astype(numpy.float32)
