"""FIRE-3DV client for Python 3.9 and later: publishes the poses of a simulation, and edits of its scene, to renderers.

    import fire3dv
    with fire3dv.Stream("shm://demo", adapter_name="my simulator") as stream:
        stream.describe(["base", "arm"])
        while True:
            step()
            stream.publish(sim_time_ns, poses)      # 2 x 12 numbers, row-major, stream_from_body

A thin layer over the C library, whose headers fire3dv/client.h and fire3dv/scene.h say what each call means: units,
frames, threads, waiting. Numbers may come as nested sequences, or as anything with the buffer protocol that holds
contiguous float32 (a NumPy array, an array.array("f")), which is then not copied on its way into the library.
Everything that can fail raises fire3dv.Error; a missing renderer is not an error. The library is looked for as
FIRE3DV_CLIENT_LIBRARY in the environment says, else as the system finds libfire3dv-client.so.
"""
import ctypes
import os
from ctypes import (POINTER, Structure, byref, c_char, c_char_p, c_double, c_float, c_int, c_int32, c_int64, c_size_t,
                    c_uint32, c_uint64, c_void_p)

FRAME_DISCONTINUITY = 1
VISIBLE, BASE_COLOR, LIGHT, CAMERA, NODE, VERTICES = range(6)
DIRECTIONAL, POINT, SPOT = range(3)
ERROR_ARGUMENT, ERROR_STATE, ERROR_SYSTEM, ERROR_TIMEOUT, ERROR_BUDGET = -1, -2, -3, -4, -5


class Error(RuntimeError):
    """code is one of ERROR_*; the text is the library's sentence."""

    def __init__(self, code, sentence):
        super().__init__(sentence)
        self.code = code


class _Options(Structure):
    _fields_ = [("struct_size", c_size_t), ("adapter_name", c_char_p), ("key_file", c_char_p),
                ("tls_ca_file", c_char_p), ("tls_certificate_file", c_char_p), ("tls_key_file", c_char_p),
                ("scene_budget_bytes", c_size_t)]


class _Description(Structure):
    _fields_ = [("struct_size", c_size_t), ("node_names", POINTER(c_char_p)), ("node_count", c_size_t),
                ("world_from_stream", POINTER(c_double)), ("body_from_node", c_void_p),
                ("body_from_node_count", c_size_t), ("nominal_rate_hz", c_double), ("scene_uri", c_char_p)]


class Status(Structure):
    """What poll() returns; fire3dv_status in client.h."""
    _fields_ = [("struct_size", c_size_t), ("renderers", c_uint32), ("epoch", c_uint64), ("sequence", c_uint64),
                ("acked_sequence", c_uint64), ("frames_published", c_uint64), ("frames_dropped", c_uint64),
                ("welcome", c_int32), ("unmatched_names", c_uint32), ("_welcome_message", c_char * 512)]

    @property
    def welcome_message(self):
        return self._welcome_message.decode("utf-8", "replace")


class _Light(Structure):
    _fields_ = [("struct_size", c_size_t), ("kind", c_int32), ("color_rgb", c_float * 3), ("intensity", c_float),
                ("range_m", c_float), ("inner_cone_rad", c_float), ("outer_cone_rad", c_float),
                ("casts_shadow", c_int32)]


class _Camera(Structure):
    _fields_ = [("struct_size", c_size_t), ("vertical_fov_rad", c_float), ("near_m", c_float), ("far_m", c_float),
                ("exposure", c_float)]


class _Node(Structure):
    _fields_ = [("struct_size", c_size_t), ("parent", c_char_p), ("parent_from_node", c_void_p),
                ("asset_uri", c_char_p), ("asset_glb", c_void_p), ("asset_glb_bytes", c_size_t)]


class _Vertices(Structure):
    _fields_ = [("struct_size", c_size_t), ("positions", c_void_p), ("normals", c_void_p), ("vertex_count", c_size_t)]


def _load():
    library = ctypes.CDLL(os.environ.get("FIRE3DV_CLIENT_LIBRARY", "libfire3dv-client.so.0"))
    stream, text = c_void_p, c_char_p
    signatures = {
        "fire3dv_version": (text, []),
        "fire3dv_last_error": (text, []),
        "fire3dv_open": (stream, [text, POINTER(_Options)]),
        "fire3dv_close": (None, [POINTER(stream)]),
        "fire3dv_describe": (c_int, [stream, POINTER(_Description)]),
        "fire3dv_publish": (c_int, [stream, c_int64, c_void_p, c_size_t, c_uint32]),
        "fire3dv_publish_some": (c_int, [stream, c_int64, c_void_p, c_void_p, c_size_t, c_uint32]),
        "fire3dv_poll": (c_int, [stream, POINTER(Status)]),
        "fire3dv_wait_ack": (c_int, [stream, c_uint64, c_uint32]),
        "fire3dv_set_visible": (c_int, [stream, text, c_int]),
        "fire3dv_set_base_color": (c_int, [stream, text, c_void_p]),
        "fire3dv_set_light": (c_int, [stream, text, POINTER(_Light)]),
        "fire3dv_set_camera": (c_int, [stream, text, POINTER(_Camera)]),
        "fire3dv_add_node": (c_int, [stream, text, POINTER(_Node)]),
        "fire3dv_remove_node": (c_int, [stream, text]),
        "fire3dv_set_vertices": (c_int, [stream, text, POINTER(_Vertices)]),
        "fire3dv_clear": (c_int, [stream, text, c_int]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


_library = _load()


def version():
    return _library.fire3dv_version().decode()


def _flatten(numbers, into):
    for entry in numbers:
        if hasattr(entry, "__iter__"):
            _flatten(entry, into)
        else:
            into.append(entry)


class _Floats:
    """Contiguous float32 numbers: the caller's memory where it is that already, else a copy."""

    def __init__(self, numbers, per_row, name):
        try:
            view = memoryview(numbers)
        except TypeError:
            view = None
        if view is not None and view.format == "f" and view.contiguous and not view.readonly:
            count = view.nbytes // 4
            self._memory = (c_float * count).from_buffer(view.cast("B") if view.nbytes else bytearray())
        else:
            flat = []
            _flatten(numbers.tolist() if hasattr(numbers, "tolist") else numbers, flat)
            count = len(flat)
            self._memory = (c_float * count)(*flat)
        if count % per_row:
            raise Error(ERROR_ARGUMENT, f"{name} has {count} numbers; {per_row} for each are needed")
        self.rows = count // per_row
        self.address = ctypes.addressof(self._memory) if count else None


def _text(text, name):
    if text is None:
        return None
    encoded = text.encode("utf-8")
    if b"\0" in encoded:
        raise Error(ERROR_ARGUMENT, f"{name} holds a NUL")
    return encoded


def _check(code):
    if code != 0:
        raise Error(code, _library.fire3dv_last_error().decode("utf-8", "replace"))


class Stream:
    """One stream of a simulator. One thread at a time. Closed by close(), or at the end of a with statement."""

    def __init__(self, uri, adapter_name=None, key_file=None, tls_ca_file=None, tls_certificate_file=None,
                 tls_key_file=None, scene_budget_bytes=0):
        options = _Options(ctypes.sizeof(_Options), _text(adapter_name, "adapter_name"), _text(key_file, "key_file"),
                           _text(tls_ca_file, "tls_ca_file"), _text(tls_certificate_file, "tls_certificate_file"),
                           _text(tls_key_file, "tls_key_file"), scene_budget_bytes)
        self._stream = c_void_p(_library.fire3dv_open(_text(uri, "uri"), byref(options)))
        if not self._stream:
            _check(ERROR_ARGUMENT)

    def close(self):
        _library.fire3dv_close(byref(self._stream))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __del__(self):
        if getattr(self, "_stream", None):
            self.close()

    def describe(self, node_names, world_from_stream=None, body_from_node=None, nominal_rate_hz=0.0, scene_uri=None):
        """Says which nodes the poses move. world_from_stream: 12 numbers; body_from_node: 12 for all, or 12 per node."""
        names = [_text(name, f"node_names[{i}]") for i, name in enumerate(node_names)]
        matrix = []
        _flatten(world_from_stream if world_from_stream is not None else [], matrix)
        if len(matrix) not in (0, 12):
            raise Error(ERROR_ARGUMENT, "world_from_stream must hold 12 numbers")
        offsets = _Floats(body_from_node if body_from_node is not None else [], 12, "body_from_node")
        _check(_library.fire3dv_describe(self._stream, byref(_Description(
            ctypes.sizeof(_Description), (c_char_p * len(names))(*names), len(names),
            (c_double * 12)(*matrix) if matrix else None, offsets.address, offsets.rows, nominal_rate_hz,
            _text(scene_uri, "scene_uri")))))

    def publish(self, sim_time_ns, stream_from_body, flags=0):
        """One pose of 12 numbers for each described node."""
        poses = _Floats(stream_from_body, 12, "stream_from_body")
        _check(_library.fire3dv_publish(self._stream, sim_time_ns, poses.address, poses.rows, flags))

    def publish_some(self, sim_time_ns, node_indices, stream_from_body, flags=0):
        """Poses of these nodes, in rising order; all others are where they were. The first one names all nodes."""
        poses = _Floats(stream_from_body, 12, "stream_from_body")
        indices = (c_uint32 * len(node_indices))(*node_indices)
        if len(indices) != poses.rows:
            raise Error(ERROR_ARGUMENT, f"{len(indices)} node_indices for {poses.rows} poses")
        _check(_library.fire3dv_publish_some(self._stream, sim_time_ns, ctypes.addressof(indices), poses.address,
                                             poses.rows, flags))

    def poll(self):
        """Reads what renderers have answered; never waits. Call it now and then."""
        status = Status(ctypes.sizeof(Status))
        _check(_library.fire3dv_poll(self._stream, byref(status)))
        return status

    def wait_ack(self, sequence, timeout_ms):
        """Lockstep: True when a renderer has shown this frame, False when the time is over."""
        code = _library.fire3dv_wait_ack(self._stream, sequence, timeout_ms)
        if code == ERROR_TIMEOUT:
            return False
        _check(code)
        return True

    # Scene edits: fire3dv/scene.h says what they mean.

    def set_visible(self, node, visible):
        _check(_library.fire3dv_set_visible(self._stream, _text(node, "node"), bool(visible)))

    def set_base_color(self, node, rgba):
        color = _Floats(rgba, 4, "rgba")
        _check(_library.fire3dv_set_base_color(self._stream, _text(node, "node"), color.address))

    def set_light(self, node, kind, color_rgb=(1, 1, 1), intensity=1.0, range_m=0.0, inner_cone_rad=0.0,
                  outer_cone_rad=0.7853981634, casts_shadow=True):
        light = _Light(ctypes.sizeof(_Light), kind, (c_float * 3)(*color_rgb), intensity, range_m, inner_cone_rad,
                       outer_cone_rad, bool(casts_shadow))
        _check(_library.fire3dv_set_light(self._stream, _text(node, "node"), byref(light)))

    def set_camera(self, node, vertical_fov_rad, near_m=0.01, far_m=0.0, exposure=0.0):
        camera = _Camera(ctypes.sizeof(_Camera), vertical_fov_rad, near_m, far_m, exposure)
        _check(_library.fire3dv_set_camera(self._stream, _text(node, "node"), byref(camera)))

    def add_node(self, node, parent=None, parent_from_node=None, asset_uri=None, asset_glb=None):
        """asset_glb: the bytes of a whole .glb file."""
        matrix = _Floats(parent_from_node if parent_from_node is not None else [], 12, "parent_from_node")
        glb = bytes(asset_glb) if asset_glb is not None else b""
        _check(_library.fire3dv_add_node(self._stream, _text(node, "node"), byref(_Node(
            ctypes.sizeof(_Node), _text(parent, "parent"), matrix.address, _text(asset_uri, "asset_uri"),
            ctypes.cast(c_char_p(glb), c_void_p) if glb else None, len(glb)))))

    def remove_node(self, node):
        _check(_library.fire3dv_remove_node(self._stream, _text(node, "node")))

    def set_vertices(self, node, positions, normals=None):
        """positions, normals: three numbers for each vertex."""
        places = _Floats(positions, 3, "positions")
        directions = _Floats(normals if normals is not None else [], 3, "normals")
        if directions.rows not in (0, places.rows):
            raise Error(ERROR_ARGUMENT, f"{directions.rows} normals for {places.rows} positions")
        _check(_library.fire3dv_set_vertices(self._stream, _text(node, "node"), byref(_Vertices(
            ctypes.sizeof(_Vertices), places.address, directions.address, places.rows))))

    def clear(self, node, prop):
        """prop: VISIBLE, BASE_COLOR, LIGHT, CAMERA, NODE or VERTICES."""
        _check(_library.fire3dv_clear(self._stream, _text(node, "node"), prop))
