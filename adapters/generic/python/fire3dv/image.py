"""Image that a renderer has returned: planes as NumPy arrays, names of instances, files."""
from __future__ import annotations

import ctypes
import os
from ctypes import byref
from typing import TYPE_CHECKING, Any, Dict, Optional, Sequence, Tuple, Union

from ._files import gray_png, png
from ._library import library
from ._scene_names import InstanceNames, SceneNames, agreed_paths
from ._types import Float64Array, Lens, Output
from .errors import ArgumentError, ErrorCode, StateError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

#: Outputs by name: NumPy type of an element, elements per pixel.
OUTPUTS: Dict[str, Tuple[Any, int]] = {
    "color_srgb8": ("u1", 4),        # sRGB red, green, blue after tone mapping; 255
    "color_linear_f16": ("<f2", 4),  # linear RGB before tone mapping; 1
    "depth_f32": ("<f4", 1),         # metres along the camera axis (planar depth); infinity for background
    "instance_u32": ("<u4", 1),      # 1 + index of the scene node; 0 for background
    "semantic_u32": ("<u4", 1),      # semantic class of that node; 0: none
    "normal": ("<f2", 4),            # unit normal x, y, z in the world; 0
    "motion": ("<f4", 2),            # motion vector in pixels since the previous image of this request
    "boxes2d": ([("instance", "<u4"), ("semantic", "<u4"), ("min_x", "<u4"), ("min_y", "<u4"), ("max_x", "<u4"),
                 ("max_y", "<u4"), ("pixels", "<u4"), ("reserved", "<u4")], 1),
    "boxes3d": ([("instance", "<u4"), ("semantic", "<u4"), ("world_from_box", "<f4", (3, 4)),
                 ("reserved", "<u4", (2,))], 1),
    "albedo_f16": ("<f2", 4),        # linear base colour; 1; all 0 for background
    "roughness_f32": ("<f4", 1),     # perceptual roughness, 0 to 1; 0 for background
    "metallic_f32": ("<f4", 1),      # 0 to 1; 0 for background
    "position_f32": ("<f4", 4),      # x, y, z in the world, in metres; 1; all 0 for background
    "occlusion_u32": ("<u4", 1),     # in this request's previous image the point was 0 seen, 1 hidden, 2 outside
}
#: Short names of outputs, accepted everywhere, as by the option --outputs of fire3dv(1).
ALIASES: Dict[str, str] = {"color": "color_srgb8", "linear": "color_linear_f16", "depth": "depth_f32",
                           "instance": "instance_u32", "semantic": "semantic_u32", "albedo": "albedo_f16",
                           "roughness": "roughness_f32", "metallic": "metallic_f32", "position": "position_f32",
                           "occlusion": "occlusion_u32"}
_BITS = {name: 1 << bit for bit, name in enumerate(OUTPUTS)}
_NAMES = {bit: name for name, bit in _BITS.items()}
BITS_OF_ANY_NAME = {**_BITS, **{alias: _BITS[name] for alias, name in ALIASES.items()}}
LENSES: Dict[Lens, int] = {"none": 0, "plumb_bob": 1, "fisheye": 2}
_LENS_NAMES: Dict[int, Lens] = {number: name for name, number in LENSES.items()}
#: world_from_stream where describe() has none.
IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
_MAX_16 = 0xffff
_GRAY_OUTPUTS = ("depth_f32", "instance_u32", "semantic_u32")  # that fit into PNG files of 16 bits


def _opencv(frame_from_camera: Float64Array) -> Float64Array:
    """Inverts a rigid pose of a camera that looks along -Z, and turns it about X: OpenCV's looks along +Z, +Y is down."""
    import numpy
    turn = (frame_from_camera[:, :3] * (1, -1, -1)).T
    result = numpy.eye(4)
    result[:3, :3] = turn
    result[:3, 3] = -turn @ frame_from_camera[:, 3]
    return result


class Handle:
    """Owner of the library's image. Arrays that view its pixels hold a reference to it."""

    def __init__(self, pointer: Any) -> None:
        self.pointer = pointer

    def __del__(self) -> None:
        library().fire3dv_release_image(byref(self.pointer))


class Image:
    """One image, and the identity of the frame it shows.

    Planes, such as image.depth or image["depth"], are read-only NumPy arrays that view the received pixels without a
    copy, rows from the top: (height, width) or (height, width, channels). Over shm:// they are the memory that the
    renderer wrote; it is used again when the image and all of its arrays are closed or deleted.

    Fields:
        request: ImageRequest.id. number: index among the images of this request, from 1
        epoch, sequence: pose frame shown, as Stream.publish returned it; sequence 0: none was published yet
        sim_time_ns: of that frame. lost: images lost between the previously taken one and this one
        width, height: pixels
        fx, fy, cx, cy: pixels; the centre of the top left pixel is (0, 0), as in OpenCV; see camera_matrix
        near_m, far_m: metres along the camera's axis; far_m 0: infinite
        lens: "none", "plumb_bob" or "fisheye", with lens_coefficients, as of OpenCV: k1 k2 p1 p2 k3, or k1 k2 k3 k4
        f_number, focus_distance_m: thin lens of color and linear, as used; 0: a pinhole
        hidden_streams: number of streams whose content the image lacks, since it takes too much drawing time
        world_from_camera: 12 numbers, (3, 4) row by row: rotation and position in metres. The camera looks along -Z, +Y
            is up

    Frames: the world is glTF's, with Y up and metres, whatever the axes of the stream are. world_from_camera, normal,
    position and boxes3d are in the world. Of a stream with Z up, stream_from_camera is the camera in the stream's own frame, and
    world_from_stream transforms the rest: a normal n of the world is world_from_stream[:, :3].T @ n in the stream,
    where that does not scale. depth, motion and boxes2d need no frame.
    """

    def __init__(self, handle: Handle, scene_names: Optional[SceneNames] = None,
                 world_from_stream: Sequence[float] = IDENTITY, instances: Sequence[InstanceNames] = ()) -> None:
        self._scene_names, self._instances = scene_names, instances
        self._world_from_stream = tuple(world_from_stream)
        raw = handle.pointer.contents
        self._handle: Optional[Handle] = handle
        planes = raw.planes[:raw.plane_count] if raw.plane_count > 0 else []
        self._planes = {_NAMES[plane.output]: plane for plane in planes if plane.output in _NAMES}
        self.request: int = raw.request
        self.epoch: int = raw.epoch
        self.sequence: int = raw.sequence
        self.sim_time_ns: int = raw.sim_time_ns
        self.number: int = raw.number
        self.lost: int = raw.lost
        self.width: int = raw.width
        self.height: int = raw.height
        self.fx: float = raw.fx
        self.fy: float = raw.fy
        self.cx: float = raw.cx
        self.cy: float = raw.cy
        self.near_m: float = raw.near_m
        self.far_m: float = raw.far_m
        if raw.lens not in _LENS_NAMES:
            raise StateError(ErrorCode.STATE, f"the image has lens {raw.lens}, which this module does not know; use the "
                             "module and the library of one version")
        self.lens: Lens = _LENS_NAMES[raw.lens]
        self.lens_coefficients: Tuple[float, ...] = tuple(raw.lens_coefficients)
        self.f_number: float = raw.f_number
        self.focus_distance_m: float = raw.focus_distance_m
        self.hidden_streams: int = raw.hidden_streams
        self.world_from_camera: Tuple[float, ...] = tuple(raw.world_from_camera)

    def _plane(self, output: str) -> Any:
        try:
            return self._array(output)
        except KeyError as fault:
            raise AttributeError(fault.args[0]) from None

    @property
    def color(self) -> npt.NDArray[np.uint8]:
        """(height, width, 4) uint8: sRGB red, green, blue after tone mapping; 255."""
        return self._plane("color_srgb8")

    @property
    def linear(self) -> npt.NDArray[np.float16]:
        """(height, width, 4) float16: linear red, green, blue before tone mapping; 1."""
        return self._plane("color_linear_f16")

    @property
    def depth(self) -> npt.NDArray[np.float32]:
        """(height, width) float32: metres along the camera's axis, not along the ray; infinity for the background."""
        return self._plane("depth_f32")

    @property
    def instance(self) -> npt.NDArray[np.uint32]:
        """(height, width) uint32: id of the scene node, see names(); 0: background."""
        return self._plane("instance_u32")

    @property
    def semantic(self) -> npt.NDArray[np.uint32]:
        """(height, width) uint32: semantic class of that node; 0: none."""
        return self._plane("semantic_u32")

    @property
    def normal(self) -> npt.NDArray[np.float16]:
        """(height, width, 4) float16: unit normal x, y, z of the surface in the world (glTF's, Y up); 0."""
        return self._plane("normal")

    @property
    def motion(self) -> npt.NDArray[np.float32]:
        """(height, width, 2) float32: pixels right and down since the request's previous image; NaN: was behind it."""
        return self._plane("motion")

    @property
    def albedo(self) -> npt.NDArray[np.float16]:
        """(height, width, 4) float16: linear base colour of the surface, and 1; 0, 0, 0, 0 for the background."""
        return self._plane("albedo_f16")

    @property
    def roughness(self) -> npt.NDArray[np.float32]:
        """(height, width) float32: perceptual roughness of the surface, 0 to 1; 0 for the background."""
        return self._plane("roughness_f32")

    @property
    def metallic(self) -> npt.NDArray[np.float32]:
        """(height, width) float32: metallic share of the surface, 0 to 1; 0 for the background."""
        return self._plane("metallic_f32")

    @property
    def position(self) -> npt.NDArray[np.float32]:
        """(height, width, 4) float32: x, y, z of the surface in the world (glTF's, Y up) in metres, and 1; 0, 0, 0, 0 for

        the background.
        """
        return self._plane("position_f32")

    @property
    def occlusion(self) -> npt.NDArray[np.uint32]:
        """(height, width) uint32: how the request's previous image showed the visible point: 0 seen, 1 hidden, 2 outside.

        0 for the background, and in the first image.
        """
        return self._plane("occlusion_u32")

    @property
    def boxes2d(self) -> npt.NDArray[np.void]:
        """(count,) records of the visible instances, fields uint32:

        instance, semantic: as in those planes. min_x, min_y, max_x, max_y: pixels around those that show the instance,
        max exclusive. pixels: how many show it. reserved: 0.
        """
        return self._plane("boxes2d")

    @property
    def boxes3d(self) -> npt.NDArray[np.void]:
        """(count,) records of the visible instances:

        instance, semantic: uint32. world_from_box: (3, 4) float32, transforms the cube from -0.5 to 0.5 to the box around
        the whole mesh: its columns are the box's edges and its centre, in metres, in the world (glTF's, Y up).
        """
        return self._plane("boxes3d")

    @property
    def world_from_stream(self) -> Float64Array:
        """(3, 4) float64: the stream's frame to the world (glTF's, Y up, metres), as describe() set it."""
        import numpy
        return numpy.array(self._world_from_stream, numpy.float64).reshape(3, 4)

    @property
    def stream_from_camera(self) -> Float64Array:
        """(3, 4) float64: pose of the camera in the stream's own frame, in its axes and its unit, without scale.

        The camera looks along -Z, +Y is up, as for request_image(parent_from_camera=...).
        """
        import numpy
        world, camera = self.world_from_stream, numpy.array(self.world_from_camera, numpy.float64).reshape(3, 4)
        turned = numpy.linalg.inv(world[:, :3])
        result = turned @ camera
        result[:, 3] = turned @ (camera[:, 3] - world[:, 3])
        result[:, :3] /= numpy.linalg.norm(result[:, :3], axis=0)
        return result

    @property
    def opencv_camera_from_world(self) -> Float64Array:
        """(4, 4) float64: points of the world (glTF's, Y up, metres) to those of OpenCV's camera: x right, y down, z forward.

        For cv2.projectPoints: cv2.Rodrigues(m[:3, :3])[0], m[:3, 3], image.camera_matrix and lens_coefficients.
        """
        import numpy
        return _opencv(numpy.array(self.world_from_camera, numpy.float64).reshape(3, 4))

    @property
    def opencv_camera_from_stream(self) -> Float64Array:
        """(4, 4) float64: points of the stream, in its axes and its unit, to those of OpenCV's camera: x right, y down, z
        forward, as opencv_camera_from_world."""
        return _opencv(self.stream_from_camera)

    @property
    def camera_matrix(self) -> Float64Array:
        """(3, 3) float64: fx 0 cx, 0 fy cy, 0 0 1, as of OpenCV."""
        import numpy
        return numpy.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]], numpy.float64)

    @property
    def outputs(self) -> Tuple[str, ...]:
        """Names of the planes, by the protocol."""
        return tuple(self._planes)

    def __getitem__(self, output: Output) -> npt.NDArray[Any]:
        """The plane of an output, by any of its names."""
        return self._array(output)

    def _array(self, output: str) -> Any:
        import numpy
        handle = self._handle  # keeps the memory, where another thread closes the image meanwhile
        if handle is None:
            raise StateError(ErrorCode.STATE, "the image is closed")
        name = ALIASES.get(output, output)
        if name not in self._planes:
            wrong = "" if name in _BITS else f" ({', '.join(BITS_OF_ANY_NAME)} exist)"
            raise KeyError(f"the image has no {name}{wrong}; request_image(outputs=...) asked for: "
                           f"{', '.join(self._planes)}")
        plane = self._planes[name]
        dtype, channels = numpy.dtype(OUTPUTS[name][0]), OUTPUTS[name][1]
        shape: Tuple[int, ...] = (plane.height, plane.width)
        strides: Tuple[int, ...] = (plane.row_stride, dtype.itemsize * channels)
        if name.startswith("boxes"):
            shape, strides = shape[1:], strides[1:]
        elif channels > 1:
            shape, strides = (*shape, channels), (*strides, dtype.itemsize)
        if plane.width == 0:
            return numpy.empty(shape, dtype)
        memory = (ctypes.c_ubyte * (plane.row_stride * plane.height)).from_address(plane.data)
        memory.owner = handle  # type: ignore[attr-defined]
        array = numpy.ndarray(shape, dtype, memory, strides=strides)
        array.flags.writeable = False
        return array

    def __contains__(self, output: object) -> bool:
        return ALIASES.get(output, output) in self._planes  # type: ignore[call-overload]

    def names(self, scene: Optional[Union[str, "os.PathLike[str]"]] = None) -> Dict[int, str]:
        """Returns the node names of the instance ids that this image shows. Needs the output instance or boxes2d.

        scene: file that the renderer shows; None: that of the Renderer that opened the stream. Nodes that streams have
        added are named by their paths, such as "env0/cart"; without such a Renderer they are left out, and those whose
        number changes while the image is on its way, since others are removed. Nameless nodes are "".
        """
        import numpy
        if scene is not None:
            source = SceneNames(os.fspath(scene))
        elif self._scene_names is not None:
            source = self._scene_names
        else:
            raise StateError(ErrorCode.STATE, "the scene of this renderer is unknown: use names(scene=\"FILE\")")
        if "instance" in self:
            numbers = numpy.unique(self.instance)
        elif "boxes2d" in self:
            numbers = self.boxes2d["instance"]
        else:
            raise StateError(ErrorCode.STATE, "the image has no instance ids: add \"instance\" to the outputs of its "
                             "request")
        names = source.names()
        shown = {int(number): names[number - 1] for number in numbers if 0 < number <= len(names)}
        added = [int(number) for number in numbers if number > len(names)]
        if added and scene is None:
            shown.update(agreed_paths(self._instances, added))
        return shown

    def save(self, path: Union[str, "os.PathLike[str]"], output: Optional[Output] = None) -> None:
        """Writes one output: color, depth, instance and semantic to a .png file, any to a .npy file, which numpy.load reads.

        output: None: color for .png; for .npy the image's only output besides color.
        color is 8-bit RGB. depth is 16-bit grey, in millimetres, rounded: 0 for the background and for what is farther
        than 65.535 m; at least 1 elsewhere. instance and semantic are 16-bit grey: the ids themselves, all of which must
        be below 65536.
        """
        import numpy
        name = os.fspath(path)
        extension = os.path.splitext(name)[1].lower()
        if extension == ".png":
            full = ALIASES.get(output, output) if output is not None else "color_srgb8"
            if full not in ("color_srgb8", *_GRAY_OUTPUTS):
                raise ArgumentError(ErrorCode.ARGUMENT, f"{name}: a .png file holds color, depth, instance or semantic; "
                                    f"write {output} to a .npy file")
            data = self._png() if full == "color_srgb8" else self._gray_png(name, full)
            with open(name, "wb") as file:
                file.write(data)
        elif extension == ".npy":
            others = [plane for plane in self._planes if plane != "color_srgb8"] or list(self._planes)
            if output is None and len(others) > 1:
                raise ArgumentError(ErrorCode.ARGUMENT, f"{name}: the image has {', '.join(others)}; name one of them "
                                    "as output")
            plane = self._array(output if output is not None else others[0])
            with open(name, "wb") as file:
                numpy.save(file, plane)
        else:
            raise ArgumentError(ErrorCode.ARGUMENT, f"{name} ends neither with .png nor with .npy")

    def _texts(self) -> Dict[str, str]:
        return {"Epoch": f"{self.epoch:016x}", "Sequence": str(self.sequence), "SimTimeNs": str(self.sim_time_ns)}

    def _png(self) -> bytes:
        return png(self["color_srgb8"], self._texts())

    def _gray_png(self, name: str, output: str) -> bytes:
        import numpy
        plane = self._array(output)
        if output == "depth_f32":
            with numpy.errstate(invalid="ignore", over="ignore"):
                millimetres = numpy.rint(plane.astype(numpy.float64) * 1000)
            is_there = millimetres <= _MAX_16  # neither infinite nor NaN
            values = numpy.where(is_there, numpy.maximum(millimetres, 1), 0)
            return gray_png(values.astype(numpy.uint16), {**self._texts(), "Unit": "millimetre"})
        largest = int(plane.max(initial=0))
        if largest > _MAX_16:
            raise ArgumentError(ErrorCode.ARGUMENT, f"{name}: the {output[:-4]} {largest} does not fit into 16 bits; write "
                                "it to a .npy file")
        return gray_png(plane.astype(numpy.uint16), self._texts())

    def _repr_png_(self) -> Optional[bytes]:
        """Jupyter shows the colours."""
        return self._png() if self._handle is not None and "color" in self else None

    def close(self) -> None:
        """Releases the memory once no array views it. May be called repeatedly."""
        self._handle = None

    release = close

    def __enter__(self) -> Image:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = ", closed" if self._handle is None else ""
        return (f"<fire3dv.Image {self.width}x{self.height} of {', '.join(self._planes)}, frame {self.sequence} at "
                f"{self.sim_time_ns / 1e9:g} s{state}>")
