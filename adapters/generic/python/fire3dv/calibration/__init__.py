"""Calibrated cameras from files of ROS (camera_info), OpenCV (FileStorage, YAML or XML) and Kalibr (camchain). Needs neither
NumPy nor a YAML library."""
from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any, Dict, List, NoReturn, Optional, Sequence, Tuple, Union

from ._text import FileFault, parse_xml, parse_yaml
from .._types import Lens
from ..errors import ArgumentError, ErrorCode

_MAX_BYTES = 1 << 20
_MAX_SIDE_PX = 16384
Matrix = List[List[float]]


@dataclass(frozen=True)
class CalibratedCamera:
    """Camera matrix and lens of one camera, and its pose beside the first camera of the file.

    fx, fy, cx, cy: pixels of an image of width x height; the centre of the top left pixel is (0, 0).
    lens, lens_coefficients: as of Stream.request_image.
    first_from_camera: twelve numbers, rows of a (3, 4) matrix in metres; both cameras look along -Z with +Y up.
    """
    name: str
    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    lens: Lens = "none"
    lens_coefficients: Tuple[float, ...] = ()
    first_from_camera: Tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)

    def request(self, width: Optional[int] = None, height: Optional[int] = None) -> Dict[str, Any]:
        """Returns arguments of Stream.request_image for an image of this size (default: that of the calibration).

        The pixels of another size are wider or narrower: stream.request_image(node="scope", **camera.request(640, 480)).
        """
        wide, high = self.width if width is None else width, self.height if height is None else height
        across, down = wide / self.width, high / self.height
        return {"width": wide, "height": high, "fx": self.fx * across, "fy": self.fy * down,
                "cx": (self.cx + 0.5) * across - 0.5, "cy": (self.cy + 0.5) * down - 0.5, "lens": self.lens,
                "lens_coefficients": self.lens_coefficients, "parent_from_camera": self.first_from_camera}


class _File:
    """Content of a file, and errors that name it."""

    def __init__(self, path: Union[str, os.PathLike[str]]) -> None:
        self.path = os.fspath(path)
        try:
            with open(self.path, "rb") as file:
                data = file.read(_MAX_BYTES + 1)
        except OSError as fault:
            self.refuse(f"cannot be read: {fault.strerror}")
        if len(data) > _MAX_BYTES:
            self.refuse("has more than 1 MiB; a camera file has a few KiB")
        try:
            text = data.decode("utf-8")
            self.root = parse_xml(text) if text.lstrip().startswith("<") else parse_yaml(text)
        except (UnicodeDecodeError, FileFault) as fault:
            self.refuse(f"is no camera file: {fault}")
        if not isinstance(self.root, dict):
            self.refuse("is no camera file: it has no names with values")

    def refuse(self, why: str) -> NoReturn:
        raise ArgumentError(ErrorCode.ARGUMENT, f"{self.path}: {why}")

    def number(self, value: Any, where: str) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            self.refuse(f"{where} is {value!r}; a finite number is needed")
        return float(value)

    def numbers(self, value: Any, where: str, counts: Sequence[int]) -> List[float]:
        """Of a list, a list of rows, or a matrix with `data`."""
        if isinstance(value, dict):
            value = value.get("data")
        if not isinstance(value, list):
            self.refuse(f"{where} is no list of numbers")
        flat = [item for row in value for item in (row if isinstance(row, list) else [row])]
        if counts and len(flat) not in counts:
            self.refuse(f"{where} has {len(flat)} numbers; {' or '.join(map(str, counts))} are needed")
        return [self.number(item, where) for item in flat]

    def side(self, value: Any, where: str) -> int:
        side = self.number(value, where)
        if side != int(side) or not 1 <= side <= _MAX_SIDE_PX:
            self.refuse(f"{where} is {value!r}; a whole number of pixels up to {_MAX_SIDE_PX} is needed")
        return int(side)


def _lens(file: _File, model: str, numbers: List[float], where: str) -> Tuple[Lens, Tuple[float, ...]]:
    """Lens of OpenCV's names and of those of ROS and Kalibr."""
    name = model.lower()
    if not any(numbers) or name in ("", "none"):
        if any(numbers):
            file.refuse(f"{where}: coefficients without a distortion model")
        # An equidistant lens without coefficients is none without distortion.
        return ("fisheye", (0.0,) * 4) if name in ("equidistant", "fisheye") else ("none", ())
    if name in ("equidistant", "fisheye"):
        if len(numbers) != 4:
            file.refuse(f"{where} has {len(numbers)} coefficients; {model} has 4: k1, k2, k3, k4")
        return "fisheye", tuple(numbers)
    if name in ("plumb_bob", "radtan", "rational_polynomial"):
        if len(numbers) not in (4, 5, 8, 12, 14):
            file.refuse(f"{where} has {len(numbers)} coefficients; {model} has 4, 5, 8, 12 or 14")
        if any(numbers[5:]):
            file.refuse(f"{where}: k4 to k6, prisms and tilts are not supported; calibrate with k1, k2, p1, p2, k3 (no "
                        "CALIB_RATIONAL_MODEL), or with the fisheye model")
        return "plumb_bob", tuple((numbers + [0.0])[:5])
    file.refuse(f"{where} is {model!r}; plumb_bob (radtan), rational_polynomial without k4 to k6, and fisheye "
                "(equidistant) are supported")


def _transposed(m: Matrix) -> Matrix:
    return [list(row) for row in zip(*m)]


def _product(a: Matrix, b: Matrix) -> Matrix:
    return [[sum(a[i][k] * b[k][j] for k in range(len(b))) for j in range(len(b[0]))] for i in range(len(a))]


def _rotation(file: _File, numbers: List[float], where: str) -> Matrix:
    rows = [numbers[0:3], numbers[3:6], numbers[6:9]]
    square = _product(rows, _transposed(rows))
    if any(abs(square[i][j] - (i == j)) > 1e-3 for i in range(3) for j in range(3)):
        file.refuse(f"{where} is no rotation")
    return rows


def _affine(rotation: Matrix, place: Sequence[float]) -> Tuple[float, ...]:
    """OpenCV's axes (Y down, Z ahead) to those of glTF on both sides."""
    turn = (1.0, -1.0, -1.0)
    return tuple(turn[i] * value * (turn[j] if j < 3 else 1.0)
                 for i in range(3) for j, value in enumerate([*rotation[i], place[i]]))


def _inverse(rotation: Matrix, place: Sequence[float]) -> Tuple[Matrix, List[float]]:
    back = _transposed(rotation)
    return back, [-sum(back[i][k] * place[k] for k in range(3)) for i in range(3)]


def _camera(file: _File, name: str, size: Tuple[int, int], matrix: List[float], lens: Tuple[Lens, Tuple[float, ...]],
            where: str, pose: Optional[Tuple[float, ...]] = None) -> CalibratedCamera:
    fx, skew, cx, _, fy, cy = matrix[:6]
    if fx <= 0 or fy <= 0:
        file.refuse(f"{where}: the focal lengths {fx:g} and {fy:g} are not positive")
    if abs(skew) > 1e-6 * fx:
        file.refuse(f"{where} has a skew of {skew:g}; cameras with skew are not supported")
    camera = CalibratedCamera(name, *size, fx, fy, cx, cy, *lens)
    return camera if pose is None else CalibratedCamera(name, *size, fx, fy, cx, cy, *lens, pose)


def _first(values: Dict[str, Any], *names: str) -> Tuple[str, Any]:
    return next(((name, values[name]) for name in names if values.get(name) is not None), (names[0], None))


def _ros(files: List[_File]) -> List[CalibratedCamera]:
    cameras: List[CalibratedCamera] = []
    first: Tuple[Matrix, float] = ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], 0.0)
    for file in files:
        values = file.root
        where, matrix = _first(values, "camera_matrix", "K", "k")
        numbers = file.numbers(matrix, where, (9,))
        size = tuple(file.side(value, name) for name, value in
                     (_first(values, "image_width", "width"), _first(values, "image_height", "height")))
        where_d, coefficients = _first(values, "distortion_coefficients", "D", "d")
        distortion = file.numbers(coefficients, where_d, ()) if coefficients is not None else []
        lens = _lens(file, str(values.get("distortion_model", "")), distortion, "distortion_model")
        # Rectified axes: p_rectified = R p; the right camera is at -P[0][3] / P[0][0] on their X.
        where_r, rectification = _first(values, "rectification_matrix", "R", "r")
        rotation = first[0]
        if rectification is not None:
            rotation = _rotation(file, file.numbers(rectification, where_r, (9,)), where_r)
        where_p, projection = _first(values, "projection_matrix", "P", "p")
        baseline = 0.0
        if projection is not None:
            p = file.numbers(projection, where_p, (12,))
            baseline = -p[3] / p[0] if p[0] > 0 else 0.0
        if not cameras:
            first = (rotation, baseline)
        back = _transposed(first[0])
        place = [row[0] * (baseline - first[1]) for row in back]
        name = str(values.get("camera_name", os.path.splitext(os.path.basename(file.path))[0]))
        cameras.append(_camera(file, name, (size[0], size[1]), numbers, lens, where,
                               _affine(_product(back, rotation), place)))
    return cameras


def _kalibr(file: _File) -> List[CalibratedCamera]:
    cameras: List[CalibratedCamera] = []
    rotation: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]  # of the first camera from this one
    place = [0.0, 0.0, 0.0]
    while isinstance(file.root.get(f"cam{len(cameras)}"), dict):
        name = f"cam{len(cameras)}"
        values = file.root[name]
        if values.get("camera_model") != "pinhole":
            file.refuse(f"{name}.camera_model is {values.get('camera_model')!r}; pinhole is supported: calibrate with "
                        "pinhole-radtan or pinhole-equi")
        fx, fy, cx, cy = file.numbers(values.get("intrinsics"), f"{name}.intrinsics", (4,))
        size = file.numbers(values.get("resolution"), f"{name}.resolution", (2,))
        distortion = file.numbers(values.get("distortion_coeffs", []), f"{name}.distortion_coeffs", ())
        lens = _lens(file, str(values.get("distortion_model", "")), distortion, f"{name}.distortion_model")
        if cameras:
            where = f"{name}.T_cn_cnm1"
            if values.get("T_cn_cnm1") is None:
                file.refuse(f"{where} is missing: where the camera is beside the one before it")
            t = file.numbers(values["T_cn_cnm1"], where, (16,))
            back, origin = _inverse(_rotation(file, [*t[0:3], *t[4:7], *t[8:11]], where), [t[3], t[7], t[11]])
            place = [place[i] + sum(rotation[i][k] * origin[k] for k in range(3)) for i in range(3)]
            rotation = _product(rotation, back)
        sides = (file.side(size[0], f"{name}.resolution"), file.side(size[1], f"{name}.resolution"))
        cameras.append(_camera(file, name, sides, [fx, 0.0, cx, 0.0, fy, cy], lens, f"{name}.intrinsics",
                               _affine(rotation, place)))
    return cameras


_OPENCV_MATRIX = ("camera_matrix", "cameraMatrix", "Camera_Matrix", "K")
_OPENCV_DISTORTION = ("distortion_coefficients", "distCoeffs", "Distortion_Coefficients", "D")


def _opencv(files: List[_File], size: Optional[Tuple[int, int]], fisheye: Optional[bool]) -> List[CalibratedCamera]:
    cameras: List[CalibratedCamera] = []
    pose: Optional[Tuple[float, ...]] = None  # of the second camera
    for file in files:
        if file.root.get("R") is not None and file.root.get("T") is not None:
            rotation = _rotation(file, file.numbers(file.root["R"], "R", (9,)), "R")  # p_right = R p_left + T
            pose = _affine(*_inverse(rotation, file.numbers(file.root["T"], "T", (3,))))
    for file in files:
        values = file.root
        for side in ("", "1", "2"):
            names = _OPENCV_MATRIX if not side else (f"M{side}", f"K{side}", f"cameraMatrix{side}", f"camera_matrix{side}")
            where, matrix = _first(values, *names)
            if matrix is None:
                continue
            numbers = file.numbers(matrix, where, (9,))
            names = _OPENCV_DISTORTION if not side else (f"D{side}", f"distCoeffs{side}", f"distortion_coefficients{side}")
            where_d, coefficients = _first(values, *names)
            distortion = file.numbers(coefficients, where_d, ()) if coefficients is not None else []
            is_fisheye = bool(values.get("fisheye_model")) if fisheye is None else fisheye
            lens = _lens(file, "fisheye" if is_fisheye else "plumb_bob", distortion, where_d)
            (where_w, wide), (where_h, high) = _first(values, "image_width", "image_Width", "width"), _first(
                values, "image_height", "image_Height", "height")
            stored = _first(values, "image_size", "imageSize", "img_size")[1]
            if wide is None and stored is not None:
                wide, high = file.numbers(stored, "image_size", (2,))
            if wide is not None:
                shape = (file.side(wide, where_w), file.side(high, where_h))
            elif size is not None:
                shape = (int(size[0]), int(size[1]))
            else:
                file.refuse("has no image_width and image_height: give size=(width, height) of the calibration's images")
            name = os.path.splitext(os.path.basename(file.path))[0] + (f" {('left', 'right')[int(side) - 1]}" if side else "")
            cameras.append(_camera(file, name, shape, numbers, lens, where, pose if len(cameras) == 1 else None))
    return cameras


def read_calibration(*paths: Union[str, os.PathLike[str]], size: Optional[Tuple[int, int]] = None,
                     fisheye: Optional[bool] = None) -> List[CalibratedCamera]:
    """Reads the cameras of calibration files; of a stereo pair left, then right.

    paths: camera_info files of ROS, one a camera; a camchain of Kalibr; FileStorage files of OpenCV in YAML or XML, with
    camera_matrix and distortion_coefficients, or M1, D1, M2, D2, and R, T in one of them. size: (width, height) of the
    calibration's images, for files of OpenCV without it. fisheye: the model of files of OpenCV, which do not name it
    (default: fisheye_model of the file, else plumb_bob).

    Raises ArgumentError, which names file and field, for files that are none of these or have a camera that no lens
    model has.
    """
    files = [_File(path) for path in paths]
    if not files:
        raise ArgumentError(ErrorCode.ARGUMENT, "read_calibration needs a file")
    if "cam0" in files[0].root:
        if len(files) > 1:
            files[1].refuse("a camchain has all of its cameras in one file")
        return _kalibr(files[0])
    if all("distortion_model" in file.root for file in files):
        return _ros(files)
    cameras = _opencv(files, size, fisheye)
    if not cameras:
        files[0].refuse("has no camera: neither camera_matrix (ROS, OpenCV), M1 (OpenCV) nor cam0 (Kalibr) is there")
    return cameras
