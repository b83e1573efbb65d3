"""Image that a renderer has returned: planes as NumPy arrays, names of instances, files."""
from __future__ import annotations

import ctypes
import os
from ctypes import byref
from typing import TYPE_CHECKING, Any, Dict, Optional, Tuple, Union

from ._files import png
from ._library import library
from ._scene_names import SceneNames
from .errors import ArgumentError, ErrorCode, StateError

if TYPE_CHECKING:
    import numpy as np

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
#: Short names of outputs, accepted everywhere, as by the option --outputs of fire3dv(1).
ALIASES: Dict[str, str] = {"color": "color_srgb8", "linear": "color_linear_f16", "depth": "depth_f32",
                           "instance": "instance_u32", "semantic": "semantic_u32"}
_BITS = {name: 1 << bit for bit, name in enumerate(OUTPUTS)}
_NAMES = {bit: name for name, bit in _BITS.items()}
BITS_OF_ANY_NAME = {**_BITS, **{alias: _BITS[name] for alias, name in ALIASES.items()}}
LENSES = {"none": 0, "plumb_bob": 1, "fisheye": 2}


class Handle:
    """Owner of the library's image. Arrays that view its pixels hold a reference to it."""

    def __init__(self, pointer: Any) -> None:
        self.pointer = pointer

    def __del__(self) -> None:
        library().fire3dv_release_image(byref(self.pointer))


def _plane_of(output: str, meaning: str) -> property:
    def plane(self: Image) -> "np.ndarray[Any, Any]":
        try:
            return self[output]
        except KeyError as fault:
            raise AttributeError(fault.args[0]) from None
    return property(plane, doc=meaning)


class Image:
    """One image, and the identity of the frame it shows.

    image.depth, or image["depth"], is a read-only NumPy array that views the received pixels without a copy, rows from
    the top: (height, width) or (height, width, channels), of the type in OUTPUTS; boxes are (count,) records. Over
    shm:// an image slot stays reserved until the image and all of its arrays are closed or deleted: copy pixels for
    long-term use.
    """

    color = _plane_of("color_srgb8", "(height, width, 4) uint8: sRGB red, green, blue after tone mapping; 255")
    linear = _plane_of("color_linear_f16", "(height, width, 4) float16: linear RGB before tone mapping; 1")
    depth = _plane_of("depth_f32", "(height, width) float32: metres along the camera's axis; infinity for background")
    instance = _plane_of("instance_u32", "(height, width) uint32: id of the scene node, see names(); 0: background")
    semantic = _plane_of("semantic_u32", "(height, width) uint32: semantic class of that node; 0: none")
    normal = _plane_of("normal", "(height, width, 4) float16: unit normal x, y, z in the world; 0")
    motion = _plane_of("motion", "(height, width, 2) float32: pixels right and down since the request's previous image")
    boxes2d = _plane_of("boxes2d", "(count,) records: pixel boxes of the visible instances")
    boxes3d = _plane_of("boxes3d", "(count,) records: boxes of the visible instances in the world")

    def __init__(self, handle: Handle, scene_names: Optional[SceneNames] = None) -> None:
        self._scene_names = scene_names
        raw = handle.pointer.contents
        self._handle: Optional[Handle] = handle
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
        self.lens: str = {number: name for name, number in LENSES.items()}[raw.lens]
        self.lens_coefficients: Tuple[float, ...] = tuple(raw.lens_coefficients)
        self.f_number: float = raw.f_number  #: thin lens of color and linear, as used; 0: a pinhole
        self.focus_distance_m: float = raw.focus_distance_m
        #: 12 numbers, row-major: rotation and translation. The camera looks along -Z, +Y is up
        self.world_from_camera: Tuple[float, ...] = tuple(raw.world_from_camera)

    @property
    def outputs(self) -> Tuple[str, ...]:
        return tuple(self._planes)

    def __getitem__(self, output: str) -> "np.ndarray[Any, Any]":
        import numpy
        handle = self._handle  # keeps the memory, where another thread closes the image meanwhile
        if handle is None:
            raise StateError(ErrorCode.STATE, "the image is closed")
        output = ALIASES.get(output, output)
        if output not in self._planes:
            wrong = "" if output in _BITS else f" ({', '.join(BITS_OF_ANY_NAME)} exist)"
            raise KeyError(f"the image has no {output}{wrong}; request_image(outputs=...) asked for: "
                           f"{', '.join(self._planes)}")
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
        memory.owner = handle  # type: ignore[attr-defined]
        array: "np.ndarray[Any, Any]" = numpy.ndarray(shape, dtype, memory, strides=strides)
        array.flags.writeable = False
        return array

    def __contains__(self, output: object) -> bool:
        return ALIASES.get(output, output) in self._planes  # type: ignore[call-overload]

    def names(self, scene: Optional[Union[str, "os.PathLike[str]"]] = None) -> Dict[int, str]:
        """Returns the node names of the instance ids that this image shows. Needs the output instance or boxes2d.

        scene: file that the renderer shows; None: that of the Renderer that opened the stream. Nodes that streams have
        added are not in the file, and left out. Nameless nodes are "".
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
        return {int(number): names[number - 1] for number in numbers if 0 < number <= len(names)}

    def save(self, path: Union[str, "os.PathLike[str]"], output: Optional[str] = None) -> None:
        """Writes one output: color to a .png file, any to a .npy file, which numpy.load reads.

        output: None: color for .png; for .npy the image's only output besides color.
        """
        import numpy
        name = os.fspath(path)
        extension = os.path.splitext(name)[1].lower()
        if extension == ".png":
            if output is not None and ALIASES.get(output, output) != "color_srgb8":
                raise ArgumentError(ErrorCode.ARGUMENT, f"{name}: a .png file holds color; write {output} to a .npy "
                                    "file")
            data = self._png()
            with open(name, "wb") as file:
                file.write(data)
        elif extension == ".npy":
            others = [plane for plane in self._planes if plane != "color_srgb8"] or list(self._planes)
            if output is None and len(others) > 1:
                raise ArgumentError(ErrorCode.ARGUMENT, f"{name}: the image has {', '.join(others)}; name one of them "
                                    "as output")
            plane = self[output if output is not None else others[0]]
            with open(name, "wb") as file:
                numpy.save(file, plane)
        else:
            raise ArgumentError(ErrorCode.ARGUMENT, f"{name} ends neither with .png nor with .npy")

    def _png(self) -> bytes:
        return png(self["color_srgb8"], {"Epoch": f"{self.epoch:016x}", "Sequence": str(self.sequence),
                                         "SimTimeNs": str(self.sim_time_ns)})

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
