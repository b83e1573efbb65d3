"""C library: found, loaded and declared on first use. Structures are those of fire3dv/client.h,
fire3dv/scene.h, fire3dv/markers.h, fire3dv/scalars.h, fire3dv/input.h, fire3dv/image.h, fire3dv/batch.h and fire3dv/joints.h, field by field."""
import ctypes
import os
import re
import threading
from ctypes import (POINTER, Structure, c_char, c_char_p, c_double, c_float, c_int, c_int32, c_int64, c_size_t,
                    c_uint32, c_uint64, c_void_p)
from typing import Any, Dict, List, Optional, Tuple

from . import _places
from .errors import ArgumentError, ErrorCode, LibraryNotFound, error_of


class Options(Structure):
    _fields_ = [("struct_size", c_size_t), ("adapter_name", c_char_p), ("key_file", c_char_p),
                ("tls_ca_file", c_char_p), ("tls_certificate_file", c_char_p), ("tls_key_file", c_char_p),
                ("scene_budget_bytes", c_size_t)]


class Description(Structure):
    _fields_ = [("struct_size", c_size_t), ("node_names", POINTER(c_char_p)), ("node_count", c_size_t),
                ("world_from_stream", POINTER(c_double)), ("body_from_node", c_void_p),
                ("body_from_node_count", c_size_t), ("nominal_rate_hz", c_double), ("scene_uri", c_char_p)]


class RawStatus(Structure):
    _fields_ = [("struct_size", c_size_t), ("renderers", c_uint32), ("epoch", c_uint64), ("sequence", c_uint64),
                ("acked_sequence", c_uint64), ("frames_published", c_uint64), ("frames_dropped", c_uint64),
                ("welcome", c_int32), ("unmatched_names", c_uint32), ("welcome_message", c_char * 512),
                ("conflicting_names", c_uint32), ("contested_names", c_uint32), ("images_dropped", c_uint64)]


class Light(Structure):
    _fields_ = [("struct_size", c_size_t), ("kind", c_int32), ("color_rgb", c_float * 3), ("intensity", c_float),
                ("range_m", c_float), ("inner_cone_rad", c_float), ("outer_cone_rad", c_float),
                ("casts_shadow", c_int32)]


class Camera(Structure):
    _fields_ = [("struct_size", c_size_t), ("vertical_fov_rad", c_float), ("near_m", c_float), ("far_m", c_float),
                ("exposure", c_float), ("f_number", c_float), ("focus_distance_m", c_float)]


class Node(Structure):
    _fields_ = [("struct_size", c_size_t), ("parent", c_char_p), ("parent_from_node", c_void_p),
                ("asset_uri", c_char_p), ("asset_glb", c_void_p), ("asset_glb_bytes", c_size_t),
                ("variant", c_char_p)]


class Vertices(Structure):
    _fields_ = [("struct_size", c_size_t), ("positions", c_void_p), ("normals", c_void_p), ("vertex_count", c_size_t)]


class Marker(Structure):
    _fields_ = [("struct_size", c_size_t), ("kind", c_int32), ("width_unit", c_int32), ("width", c_float),
                ("flags", c_uint32), ("lifetime_ns", c_uint64), ("parent", c_char_p), ("parent_from_marker", c_void_p),
                ("positions", c_void_p), ("position_count", c_size_t), ("rotations", c_void_p),
                ("rotation_count", c_size_t), ("sizes", c_void_p), ("size_count", c_size_t), ("colors", c_void_p),
                ("color_count", c_size_t), ("texts", c_void_p), ("text_count", c_size_t), ("image_pixels", c_void_p),
                ("image_width", c_uint32), ("image_height", c_uint32), ("image_channels", c_uint32)]


class Scalars(Structure):
    _fields_ = [("struct_size", c_size_t), ("names", POINTER(c_char_p)), ("units", POINTER(c_char_p)),
                ("count", c_size_t)]


class Input(Structure):
    _fields_ = [("struct_size", c_size_t), ("kind", c_int32), ("flags", c_uint32), ("minimum", c_double),
                ("maximum", c_double), ("step", c_double), ("value", c_double), ("speed", c_double), ("unit", c_char_p),
                ("text", c_char_p), ("choices", POINTER(c_char_p)), ("choice_count", c_size_t)]


class Event(Structure):
    _fields_ = [("struct_size", c_size_t), ("kind", c_int32), ("action", c_int32), ("source", c_uint64),
                ("viewer", c_uint32), ("node", c_uint32), ("time_ns", c_uint64), ("sim_time_ns", c_int64),
                ("lost", c_uint64), ("value", c_double), ("node_point", c_double * 3), ("target", c_double * 3),
                ("input", c_char * 128), ("text", c_char * 1024)]


class ImageRequest(Structure):
    _fields_ = [("struct_size", c_size_t), ("node", c_char_p), ("parent_from_camera", c_void_p), ("width", c_uint32),
                ("height", c_uint32), ("fx", c_float), ("fy", c_float), ("cx", c_float), ("cy", c_float),
                ("near_m", c_float), ("far_m", c_float), ("lens", c_int32), ("lens_coefficients", c_float * 5),
                ("outputs", c_uint32), ("when", c_int32), ("every", c_uint32), ("rate_hz", c_double),
                ("sequence", c_uint64), ("markers", c_int32), ("f_number", c_float), ("focus_distance_m", c_float),
                ("reserved", c_uint32), ("complete", c_int32)]


class ImagePlane(Structure):
    _fields_ = [("output", c_uint32), ("width", c_uint32), ("height", c_uint32), ("row_stride", c_uint32),
                ("data", c_void_p)]


class Image(Structure):
    _fields_ = [("request", c_uint64), ("epoch", c_uint64), ("sequence", c_uint64), ("sim_time_ns", c_int64),
                ("number", c_uint64), ("lost", c_uint64), ("world_from_camera", c_float * 12), ("width", c_uint32),
                ("height", c_uint32), ("fx", c_float), ("fy", c_float), ("cx", c_float), ("cy", c_float),
                ("near_m", c_float), ("far_m", c_float), ("lens", c_int32), ("lens_coefficients", c_float * 5),
                ("plane_count", c_size_t), ("planes", POINTER(ImagePlane)), ("f_number", c_float),
                ("focus_distance_m", c_float), ("hidden_streams", c_uint32), ("views", c_uint32)]


class BatchRequest(Structure):
    _fields_ = [("struct_size", c_size_t), ("worlds", c_uint32), ("node_indices", c_void_p), ("node_count", c_uint32),
                ("pose_worlds", c_uint32), ("poses", c_void_p), ("world_of_view", c_void_p), ("views", c_uint32),
                ("pose_views", c_uint32), ("parent_from_camera", c_void_p), ("node", c_char_p), ("width", c_uint32),
                ("height", c_uint32), ("fx", c_float), ("fy", c_float), ("cx", c_float), ("cy", c_float),
                ("projections", c_void_p), ("near_m", c_float), ("far_m", c_float), ("active", c_void_p),
                ("outputs", c_uint32)]


class Joint(Structure):
    _fields_ = [("struct_size", c_size_t), ("name", c_char_p), ("node", c_char_p), ("type", c_int32),
                ("followed_joint", c_int32), ("multiplier", c_double), ("offset", c_double),
                ("position_index", c_size_t), ("position_count", c_size_t), ("axis", c_double * 3),
                ("anchor", c_double * 3), ("has_limits", c_int32), ("lower", c_double), ("upper", c_double)]


_SIGNATURES: Dict[str, Tuple[Any, List[Any]]] = {
    "fire3dv_version": (c_char_p, []),
    "fire3dv_last_error": (c_char_p, []),
    "fire3dv_open": (c_void_p, [c_char_p, POINTER(Options)]),
    "fire3dv_close": (None, [POINTER(c_void_p)]),
    "fire3dv_describe": (c_int, [c_void_p, POINTER(Description)]),
    "fire3dv_publish": (c_int, [c_void_p, c_int64, c_void_p, c_size_t, c_uint32]),
    "fire3dv_publish_some": (c_int, [c_void_p, c_int64, c_void_p, c_void_p, c_size_t, c_uint32]),
    "fire3dv_poll": (c_int, [c_void_p, POINTER(RawStatus)]),
    "fire3dv_wait_ack": (c_int, [c_void_p, c_uint64, c_uint32]),
    "fire3dv_set_visible": (c_int, [c_void_p, c_char_p, c_int]),
    "fire3dv_set_base_color": (c_int, [c_void_p, c_char_p, c_void_p]),
    "fire3dv_set_light": (c_int, [c_void_p, c_char_p, POINTER(Light)]),
    "fire3dv_set_camera": (c_int, [c_void_p, c_char_p, POINTER(Camera)]),
    "fire3dv_add_node": (c_int, [c_void_p, c_char_p, POINTER(Node)]),
    "fire3dv_remove_node": (c_int, [c_void_p, c_char_p]),
    "fire3dv_set_vertices": (c_int, [c_void_p, c_char_p, POINTER(Vertices)]),
    "fire3dv_clear": (c_int, [c_void_p, c_char_p, c_int]),
    "fire3dv_set_marker": (c_int, [c_void_p, c_char_p, POINTER(Marker)]),
    "fire3dv_clear_marker": (c_int, [c_void_p, c_char_p]),
    "fire3dv_declare_scalars": (c_int, [c_void_p, c_char_p, POINTER(Scalars)]),
    "fire3dv_set_scalars": (c_int, [c_void_p, c_char_p, c_int64, c_void_p, c_size_t]),
    "fire3dv_clear_scalars": (c_int, [c_void_p, c_char_p]),
    "fire3dv_declare_input": (c_int, [c_void_p, c_char_p, POINTER(Input)]),
    "fire3dv_clear_input": (c_int, [c_void_p, c_char_p]),
    "fire3dv_poll_events": (c_int, [c_void_p, POINTER(Event), c_size_t]),
    "fire3dv_request_image": (c_int, [c_void_p, POINTER(ImageRequest), POINTER(c_uint64)]),
    "fire3dv_request_batch": (c_int, [c_void_p, POINTER(BatchRequest), POINTER(c_uint64)]),
    "fire3dv_cancel_image": (c_int, [c_void_p, c_uint64]),
    "fire3dv_wait_image": (c_int, [c_void_p, c_uint64, c_uint32, POINTER(POINTER(Image))]),
    "fire3dv_release_image": (None, [POINTER(POINTER(Image))]),
    "fire3dv_open_robot": (c_void_p, [c_char_p, c_uint32]),
    "fire3dv_read_robot": (c_void_p, [c_char_p, c_size_t, c_uint32]),
    "fire3dv_close_robot": (None, [POINTER(c_void_p)]),
    "fire3dv_joint_count": (c_size_t, [c_void_p]),
    "fire3dv_position_count": (c_size_t, [c_void_p]),
    "fire3dv_get_joint": (c_int, [c_void_p, c_size_t, POINTER(Joint)]),
    "fire3dv_set_positions": (c_int, [c_void_p, c_void_p, c_size_t, c_uint32]),
    "fire3dv_set_joint": (c_int, [c_void_p, c_size_t, c_void_p, c_size_t, c_uint32]),
    "fire3dv_get_positions": (c_int, [c_void_p, c_void_p, c_size_t]),
    "fire3dv_set_joint_scalars": (c_int, [c_void_p, c_void_p, c_char_p, c_int64]),
    "fire3dv_set_base": (c_int, [c_void_p, c_void_p]),
    "fire3dv_get_robot_description": (c_int, [c_void_p, POINTER(Description)]),
    "fire3dv_get_poses": (c_int, [c_void_p, c_void_p, c_size_t]),
    "fire3dv_get_node_pose": (c_int, [c_void_p, c_char_p, c_void_p]),
}

_lock = threading.Lock()
_loaded: Optional[ctypes.CDLL] = None


def declare(loaded: ctypes.CDLL, signatures: Dict[str, Tuple[Any, List[Any]]]) -> None:
    """Declares the signatures of the library's functions to ctypes."""
    for name, (result, arguments) in signatures.items():
        try:
            function = getattr(loaded, name)
        except AttributeError:
            raise LibraryNotFound(
                ErrorCode.SYSTEM, f"{loaded._name} has no {name}: it is not the FIRE-3DV client, or of an older version "
                "than this package; set FIRE3DV_CLIENT_LIBRARY to its file") from None
        function.restype, function.argtypes = result, arguments


def _open() -> ctypes.CDLL:
    named = os.environ.get("FIRE3DV_CLIENT_LIBRARY")
    places = [named] if named else [*_places.all_places(os.path.dirname(os.path.abspath(__file__))),
                                    _places.FILE_NAME]
    faults = []
    for place in places:
        try:
            return ctypes.CDLL(place)
        except OSError as fault:
            faults.append(str(fault))
    remedy = "correct FIRE3DV_CLIENT_LIBRARY" if named else "set FIRE3DV_CLIENT_LIBRARY to its file, or install it"
    raise LibraryNotFound(ErrorCode.SYSTEM,
                          f"the FIRE-3DV client library cannot be loaded ({'; '.join(faults)}): {remedy}")


def library() -> ctypes.CDLL:
    """Returns the library; loads it on first use."""
    global _loaded
    if _loaded is None:
        with _lock:
            if _loaded is None:
                loaded = _open()
                declare(loaded, _SIGNATURES)
                _loaded = loaded
    return _loaded


class _Symbol(Structure):  # Dl_info of dlfcn.h
    _fields_ = [("file", c_char_p), ("base", c_void_p), ("name", c_char_p), ("address", c_void_p)]


def library_file() -> str:
    """Returns the path that the dynamic linker has loaded the library from, also where it was named without a folder."""
    dladdr = ctypes.CDLL(None).dladdr
    dladdr.restype, dladdr.argtypes = c_int, [c_void_p, POINTER(_Symbol)]
    symbol = _Symbol()
    if not dladdr(ctypes.cast(library().fire3dv_version, c_void_p), ctypes.byref(symbol)) or not symbol.file:
        raise LibraryNotFound(ErrorCode.SYSTEM, "the file of the FIRE-3DV client library is unknown (dladdr failed)")
    return os.path.realpath(os.fsdecode(symbol.file))


def check(code: int) -> None:
    """Raises the exception for an error code of the library."""
    if code != 0:
        raise error_of(code, in_python_names(library().fire3dv_last_error().decode("utf-8", "replace")))


_WHEN = re.compile(r"\bFIRE3DV_IMAGE_(ONCE|EVERY_NTH|RATE|EXACTLY)\b")
_FUNCTION = re.compile(r"\bfire3dv_([a-z_]+)\b")
_MESSAGE = re.compile(r"\b(StreamDescription|PoseFrame|SceneEdit|ImageRequest)\.(?=[a-z])")


def in_python_names(sentence: str) -> str:
    """Replaces names of C in an error message by those of this package."""
    sentence = _WHEN.sub(lambda match: f"when=\"{match.group(1).lower()}\"", sentence)
    return _MESSAGE.sub("", _FUNCTION.sub(r"\1()", sentence))


def encoded(text: Optional[str], name: str) -> Optional[bytes]:
    """Encodes text for the library; None stays None."""
    if text is None:
        return None
    if not isinstance(text, str):
        raise ArgumentError(ErrorCode.ARGUMENT, f"{name} is of type {type(text).__name__}; a str is needed")
    try:
        result = text.encode("utf-8")
    except UnicodeEncodeError as fault:
        raise ArgumentError(ErrorCode.ARGUMENT, f"{name} is not Unicode text: {fault.reason}") from None
    if b"\0" in result:
        raise ArgumentError(ErrorCode.ARGUMENT, f"{name} holds a NUL")
    return result
