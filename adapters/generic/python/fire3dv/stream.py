"""One stream of a simulator: what it moves, where it moves to, and what it changes of the scene."""
from __future__ import annotations

import ctypes
from ctypes import byref, c_char_p, c_double, c_float, c_int64, c_uint32, c_uint64, c_void_p
from typing import TYPE_CHECKING, Any, Iterable, Optional, Sequence, Union

from . import _library as c
from ._library import check, encoded, library
from ._numbers import Numbers, real, whole
from .errors import ArgumentError, ErrorCode, StateError, error_of
from .images import AsksForImages
from .status import LightKind, Property, Status

if TYPE_CHECKING:
    import numpy.typing as npt
    Array = Union[npt.ArrayLike, Sequence[Any], memoryview]
else:
    Array = Any

FRAME_DISCONTINUITY = 1  #: flag: bodies or time jumped; renderers do not interpolate into this frame


def version() -> str:
    """Of the C library, such as "0.1.0"."""
    return library().fire3dv_version().decode()


class Stream(AsksForImages):
    """Publishes to one URI. Belongs to one thread at a time; different streams are independent.

    Ends in order with close(), or at the end of a with statement. A missing renderer is no error, and no call waits for
    one but wait_ack and those that wait for images, which say how long. All that is given is copied before a call returns.
    """

    def __init__(self, uri: str, adapter_name: Optional[str] = None, key_file: Optional[str] = None,
                 tls_ca_file: Optional[str] = None, tls_certificate_file: Optional[str] = None,
                 tls_key_file: Optional[str] = None, scene_budget_bytes: int = 0) -> None:
        """Opens a link.

        uri: "shm://NAME", "tcp://HOST:PORT", "tls://HOST:PORT" or "udp://HOST:PORT".
        adapter_name: for people. key_file: udp://; tls_*: tls://; names of files, never keys themselves.
        scene_budget_bytes: what all scene edits together may take; 0: 64 MiB.
        """
        self._stream = c_void_p(None)
        self._sequence = 0
        options = c.Options(ctypes.sizeof(c.Options), encoded(adapter_name, "adapter_name"),
                            encoded(key_file, "key_file"), encoded(tls_ca_file, "tls_ca_file"),
                            encoded(tls_certificate_file, "tls_certificate_file"),
                            encoded(tls_key_file, "tls_key_file"),
                            whole(scene_budget_bytes, ctypes.c_size_t, "scene_budget_bytes"))
        self._stream = c_void_p(library().fire3dv_open(encoded(uri, "uri"), byref(options)))
        if not self._stream:
            raise error_of(ErrorCode.ARGUMENT, library().fire3dv_last_error().decode("utf-8", "replace"))

    def close(self) -> None:
        """Says goodbye and ends the stream: its nodes rest again, its edits are undone. Twice is fine."""
        if self._stream:
            library().fire3dv_close(byref(self._stream))

    def __enter__(self) -> Stream:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_stream", None):
            self.close()

    @property
    def handle(self) -> c_void_p:
        """The C stream, for functions that this class lacks. Stays ours."""
        if not self._stream:
            raise StateError(ErrorCode.STATE, "the stream is closed")
        return self._stream

    @property
    def is_open(self) -> bool:
        return bool(self._stream)

    @property
    def sequence(self) -> int:
        """Of the last frame published under this description; 0: none."""
        return self._sequence

    def describe(self, node_names: Iterable[str], world_from_stream: Optional[Array] = None,
                 body_from_node: Optional[Array] = None, nominal_rate_hz: float = 0.0,
                 scene_uri: Optional[str] = None) -> None:
        """Says which nodes the poses move: pose i moves the scene's node of name i. May be called again.

        world_from_stream: (3, 4) float64, from the stream's frame to the renderer's world (glTF's: Y up, metres).
        body_from_node: (3, 4) float32 for all nodes, or (n, 3, 4). Both are the identity where left out.
        nominal_rate_hz: frames a second of simulated time, 0: unknown. scene_uri: a hint for people and recordings.
        """
        if isinstance(node_names, str):
            raise ArgumentError(ErrorCode.ARGUMENT, "node_names is one str; a list of names is needed")
        names = [encoded(name, f"node_names[{i}]") for i, name in enumerate(node_names)]
        world = Numbers(world_from_stream if world_from_stream is not None else [], (3, 4), "world_from_stream",
                        c_double, "float64")
        if world.rows > 1:
            raise ArgumentError(ErrorCode.ARGUMENT, "world_from_stream must hold 12 numbers")
        offsets = Numbers(body_from_node if body_from_node is not None else [], (3, 4), "body_from_node")
        description = c.Description(
            ctypes.sizeof(c.Description), (c_char_p * len(names))(*names), len(names),
            ctypes.cast(world.address, ctypes.POINTER(c_double)) if world.rows else None, offsets.address,
            offsets.rows, real(nominal_rate_hz, "nominal_rate_hz"), encoded(scene_uri, "scene_uri"))
        check(library().fire3dv_describe(self.handle, byref(description)))
        self._sequence = 0

    def publish(self, sim_time_ns: int, stream_from_body: Array, flags: int = 0) -> int:
        """Publishes one whole frame and returns its sequence. Waits for nobody.

        stream_from_body: (n, 3, 4) float32 (or (n, 12)), one for each described node: takes coordinates of the body to
        coordinates of the stream, row-major, metres unless world_from_stream scales. Contiguous float32 is not copied
        on its way into the library. flags: FRAME_DISCONTINUITY or 0.
        """
        poses = Numbers(stream_from_body, (3, 4), "stream_from_body")
        check(library().fire3dv_publish(self.handle, whole(sim_time_ns, c_int64, "sim_time_ns"), poses.address,
                                        poses.rows, whole(flags, c_uint32, "flags")))
        self._sequence += 1
        return self._sequence

    def publish_some(self, sim_time_ns: int, node_indices: Array, stream_from_body: Array, flags: int = 0) -> int:
        """Publishes a frame in which only some nodes have moved, and returns its sequence.

        node_indices: (k,) uint32 in rising order; stream_from_body: (k, 3, 4) float32. All other nodes are where they
        were; the first frame of a description that is published so names all nodes.
        """
        poses = Numbers(stream_from_body, (3, 4), "stream_from_body")
        indices = Numbers(node_indices, (1,), "node_indices", c_uint32, "uint32")
        if indices.rows != poses.rows:
            raise ArgumentError(ErrorCode.ARGUMENT, f"{indices.rows} node_indices for {poses.rows} poses")
        check(library().fire3dv_publish_some(self.handle, whole(sim_time_ns, c_int64, "sim_time_ns"), indices.address,
                                             poses.address, poses.rows, whole(flags, c_uint32, "flags")))
        self._sequence += 1
        return self._sequence

    def poll(self) -> Status:
        """Reads what renderers have answered; never waits. Call it now and then."""
        raw = c.RawStatus(ctypes.sizeof(c.RawStatus))
        check(library().fire3dv_poll(self.handle, byref(raw)))
        return Status(raw.renderers, raw.epoch, raw.sequence, raw.acked_sequence, raw.frames_published,
                      raw.frames_dropped, raw.welcome, raw.unmatched_names,
                      raw.welcome_message.decode("utf-8", "replace"), raw.conflicting_names, raw.contested_names)

    def wait_ack(self, sequence: int, timeout_ms: int) -> bool:
        """Lockstep: True when a renderer has shown this frame, False when timeout_ms is over."""
        code = library().fire3dv_wait_ack(self.handle, whole(sequence, c_uint64, "sequence"),
                                          whole(timeout_ms, c_uint32, "timeout_ms"))
        if code == ErrorCode.TIMEOUT:
            return False
        check(code)
        return True

    # Scene edits are keyed state: the newest value of each node and property counts. A frame is shown with all edits
    # set before it was published. Nodes are looked up by name or path, like nodes that poses move.

    def set_visible(self, node: str, visible: bool) -> None:
        """The node and all below it: drawn and casting shadows, or not."""
        check(library().fire3dv_set_visible(self.handle, encoded(node, "node"), bool(visible)))

    def set_base_color(self, node: str, rgba: Array) -> None:
        """rgba: 4 numbers from 0 to 1, linear; the base colour factor of the node's own mesh, for this node alone."""
        color = Numbers(rgba, (4,), "rgba")
        if color.rows != 1:
            raise ArgumentError(ErrorCode.ARGUMENT, f"rgba has {4 * color.rows} numbers; 4 are needed")
        check(library().fire3dv_set_base_color(self.handle, encoded(node, "node"), color.address))

    def set_light(self, node: str, kind: Union[LightKind, int], color_rgb: Array = (1, 1, 1),
                  intensity: float = 1.0, range_m: float = 0.0, inner_cone_rad: float = 0.0,
                  outer_cone_rad: float = 0.7853981634, casts_shadow: bool = True) -> None:
        """The light on the node, which shines along its -Z: new, or instead of the file's.

        color_rgb: linear. intensity: candela (POINT, SPOT) or lux (DIRECTIONAL). range_m: 0 for infinite.
        """
        color = Numbers(color_rgb, (3,), "color_rgb")
        if color.rows != 1:
            raise ArgumentError(ErrorCode.ARGUMENT, f"color_rgb has {3 * color.rows} numbers; 3 are needed")
        light = c.Light(ctypes.sizeof(c.Light), whole(kind, ctypes.c_int32, "kind"),
                        (c_float * 3).from_address(color.address), real(intensity, "intensity"),
                        real(range_m, "range_m"), real(inner_cone_rad, "inner_cone_rad"),
                        real(outer_cone_rad, "outer_cone_rad"), bool(casts_shadow))
        check(library().fire3dv_set_light(self.handle, encoded(node, "node"), byref(light)))

    def set_camera(self, node: str, vertical_fov_rad: float, near_m: float = 0.01, far_m: float = 0.0,
                   exposure: float = 0.0) -> None:
        """The camera on the node, which looks along its -Z.

        far_m: 0 for infinite. exposure: factor on linear colour; 0: as the renderer was told.
        """
        camera = c.Camera(ctypes.sizeof(c.Camera), real(vertical_fov_rad, "vertical_fov_rad"),
                          real(near_m, "near_m"), real(far_m, "far_m"), real(exposure, "exposure"))
        check(library().fire3dv_set_camera(self.handle, encoded(node, "node"), byref(camera)))

    def add_node(self, node: str, parent: Optional[str] = None, parent_from_node: Optional[Array] = None,
                 asset_uri: Optional[str] = None, asset_glb: Optional[bytes] = None) -> None:
        """A node that the scene does not have.

        parent: None for the scene's root. parent_from_node: (3, 4) float32, at rest. asset_uri: a glTF file below
        the folder that the renderer's user named for assets. asset_glb: the bytes of a whole .glb file. With neither
        the node is empty.
        """
        matrix = Numbers(parent_from_node if parent_from_node is not None else [], (3, 4), "parent_from_node")
        if matrix.rows > 1:
            raise ArgumentError(ErrorCode.ARGUMENT, "parent_from_node must hold 12 numbers")
        try:
            glb = bytes(memoryview(asset_glb)) if asset_glb is not None else b""
        except TypeError:
            raise ArgumentError(ErrorCode.ARGUMENT, f"asset_glb is of type {type(asset_glb).__name__}; bytes are "
                                "needed") from None
        added = c.Node(ctypes.sizeof(c.Node), encoded(parent, "parent"), matrix.address,
                       encoded(asset_uri, "asset_uri"),
                       ctypes.cast(c_char_p(glb), c_void_p) if glb else None, len(glb))
        check(library().fire3dv_add_node(self.handle, encoded(node, "node"), byref(added)))

    def remove_node(self, node: str) -> None:
        """The node, added or the file's, and all below it are not there."""
        check(library().fire3dv_remove_node(self.handle, encoded(node, "node")))

    def set_vertices(self, node: str, positions: Array, normals: Optional[Array] = None) -> None:
        """New places of the vertices of the node's own mesh: (v, 3) float32, metres, in the mesh's frame and order.

        normals: (v, 3) float32 of length 1; None: the renderer finds them.
        """
        places = Numbers(positions, (3,), "positions")
        directions = Numbers(normals if normals is not None else [], (3,), "normals")
        if directions.rows not in (0, places.rows):
            raise ArgumentError(ErrorCode.ARGUMENT, f"{directions.rows} normals for {places.rows} positions")
        vertices = c.Vertices(ctypes.sizeof(c.Vertices), places.address, directions.address, places.rows)
        check(library().fire3dv_set_vertices(self.handle, encoded(node, "node"), byref(vertices)))

    def clear(self, node: str, prop: Union[Property, int]) -> None:
        """Takes the edit of one property back: as the scene's file says."""
        check(library().fire3dv_clear(self.handle, encoded(node, "node"), whole(prop, ctypes.c_int32, "prop")))
