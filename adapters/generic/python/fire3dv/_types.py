"""Types of arguments and results, for type checkers, completion and help(). Imports no NumPy."""
from typing import TYPE_CHECKING, Any, Literal, Sequence, Union

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Array = Union[npt.ArrayLike, Sequence[Any], memoryview]
    Float32Array = npt.NDArray[np.float32]
    Float64Array = npt.NDArray[np.float64]
    Pixels = Union[npt.NDArray[np.uint8], memoryview, Sequence[Any]]
else:
    Array = Float32Array = Float64Array = Pixels = Any

#: Names of image outputs: short ones, and those of the protocol.
Output = Literal["color", "linear", "depth", "instance", "semantic", "normal", "motion", "boxes2d", "boxes3d",
                 "albedo", "roughness", "metallic", "position", "occlusion",
                 "color_srgb8", "color_linear_f16", "depth_f32", "instance_u32", "semantic_u32", "albedo_f16",
                 "roughness_f32", "metallic_f32", "position_f32", "occlusion_u32"]
#: Which frames an image request shows.
When = Literal["once", "every_nth", "rate", "exactly"]
#: Lens distortion of an image request, as in OpenCV.
Lens = Literal["none", "plumb_bob", "fisheye"]
#: What fire3dv.mujoco.Publisher shows besides bodies.
Shown = Literal["contacts", "forces"]
