"""Publisher stream: node names, poses and scene edits."""
from __future__ import annotations

import ctypes
import re
import time
from ctypes import byref, c_char_p, c_double, c_float, c_int64, c_uint32, c_uint64, c_void_p
from typing import Any, Dict, Iterable, List, Optional, Sequence, Set, Union

from . import _library as c
from ._handle import StreamHandle
from ._library import check, encoded, library
from ._numbers import Numbers, enumerated, real, whole
from ._types import Array
from .errors import ArgumentError, ErrorCode, StateError, Timeout, error_of, warn
from .image import IDENTITY
from .images import ImageRequests
from .controls import Controls, Inputs
from .markers import Markers
from .scalars import Scalars
from .status import LightKind, Property, Status

_ADVICE_S = 10.0  # after describe() and edits: the renderer comments on the first frame that it shows, and on edits
_ADVICE = re.compile(r"(?:^|; )this stream (?=has |moves )")
_NEXT_ADVICE = re.compile(r"; it (?=has |moves )")
_ANSWER_INTERVAL_S = 0.1
_MESSAGE_BYTES = 500  # a longer welcome_message may be truncated
FRAME_DISCONTINUITY = 1  #: flag: bodies or time jumped; renderers do not interpolate into this frame


def _listed(names: Sequence[str]) -> str:
    """At most 8 quoted names."""
    shown = ", ".join(repr(name) for name in names[:8])
    return shown + (f" and {len(names) - 8} more" if len(names) > 8 else "")


def version() -> str:
    """Returns the version of the C library, "MAJOR.MINOR.PATCH"."""
    return library().fire3dv_version().decode()


class Stream(ImageRequests, Markers, Scalars, Inputs):
    """Publisher of one URI. Any thread may use a stream; different streams are independent.

    Calls of several threads exclude each other, and waits let others in: one thread may wait for images while others
    publish and edit. close() ends their waits with StateError. A forked child opens a stream of its own.

    close() or the end of a with statement ends the stream. A missing renderer is no error. Only wait_ack and functions
    that wait for images block, up to their timeout. Arguments are copied before a call returns.
    """

    def __init__(self, uri: str, adapter_name: Optional[str] = None, key_file: Optional[str] = None,
                 tls_ca_file: Optional[str] = None, tls_certificate_file: Optional[str] = None,
                 tls_key_file: Optional[str] = None, scene_budget_bytes: int = 0) -> None:
        """Opens a link.

        uri: "shm://NAME", "tcp://HOST:PORT", "tls://HOST:PORT" or "udp://HOST:PORT".
        adapter_name: shown to users. key_file: udp://; tls_*: tls://; paths of files, never keys themselves.
        scene_budget_bytes: memory limit of all scene edits; 0: 64 MiB.
        """
        self._handle: Optional[StreamHandle] = None
        self._sequence = 0
        self._node_names: Optional[List[str]] = None
        self._first_poses = False
        self._answered = True  # nothing to wait for before describe()
        self._has_late_names = False
        self._advice_until_s = 0.0
        self._advice: Set[str] = set()  # that was given
        self._asked_at_s = 0.0
        self._no_glb: Set[str] = set()  # nodes that were reported when they were added
        self._added: Set[str] = set()  # by add_node: in the scene with a frame, after the first answer
        self._scalar_units: Dict[str, Dict[str, str]] = {}  # of declared scalars, by group and name
        self._controls: Optional[Controls] = None
        self._uri = uri
        options = c.Options(ctypes.sizeof(c.Options), encoded(adapter_name, "adapter_name"),
                            encoded(key_file, "key_file"), encoded(tls_ca_file, "tls_ca_file"),
                            encoded(tls_certificate_file, "tls_certificate_file"),
                            encoded(tls_key_file, "tls_key_file"),
                            whole(scene_budget_bytes, ctypes.c_size_t, "scene_budget_bytes"))
        stream = c_void_p(library().fire3dv_open(encoded(uri, "uri"), byref(options)))
        if not stream:
            raise error_of(ErrorCode.ARGUMENT, library().fire3dv_last_error().decode("utf-8", "replace"))
        self._handle = StreamHandle(stream)

    def close(self) -> None:
        """Ends the stream: renderers reset its nodes and edits. May be called repeatedly, and from any thread.

        Waits of other threads end with StateError. In a forked child it leaves the parent's stream alone.
        """
        if self._handle is None:
            return
        try:
            if self._handle.is_open and not self._handle.is_inherited:
                self._look_for_answer(0)
        except StateError:  # another thread has closed it meanwhile
            pass
        finally:  # also where warnings are errors
            self._handle.close()

    def _call(self, function: Any, *arguments: Any) -> None:
        """Calls a function of the library that takes the stream first. Raises the exception of its code."""
        check(self._open_handle().call(function, *arguments))

    def _open_handle(self) -> StreamHandle:
        if self._handle is None:
            raise StateError(ErrorCode.STATE, "the stream is closed")
        return self._handle

    def __enter__(self) -> Stream:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_handle", None) is not None:
            self._handle.close()  # type: ignore[union-attr]

    def __repr__(self) -> str:
        if not self.is_open:
            return f"<fire3dv.Stream to {self._uri}, closed>"
        nodes = "not described" if self._node_names is None else f"{len(self._node_names)} nodes"
        return f"<fire3dv.Stream to {self._uri}, {nodes}, frame {self._sequence}>"

    @property
    def handle(self) -> c_void_p:
        """The C stream, for functions that this class lacks. Owned by this object: no other thread may close it."""
        return self._open_handle().stream

    @property
    def is_open(self) -> bool:
        """Whether neither close() nor the end of a with statement has ended the stream."""
        return self._handle is not None and self._handle.is_open

    @property
    def sequence(self) -> int:
        """Sequence of the last frame published since describe(); 0: none."""
        return self._sequence

    def describe(self, node_names: Iterable[str], world_from_stream: Optional[Array] = None,
                 body_from_node: Optional[Array] = None, nominal_rate_hz: float = 0.0,
                 scene_uri: Optional[str] = None) -> None:
        """Sets the nodes of the stream: pose i moves the scene node of name i. May be called again.

        world_from_stream: (3, 4) or (4, 4) float64, from the stream's frame to the renderer's world (glTF's: Y up,
        metres).
        body_from_node: (3, 4) float32 for all nodes, or (n, 3, 4). Both are the identity where left out.
        nominal_rate_hz: frames per second of simulated time, 0: unknown. scene_uri: informative, for users and recordings.
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
        with self._open_handle().lock:
            self._call(library().fire3dv_describe, byref(description))
            self._sequence = 0
            self._world_from_stream = IDENTITY if not world.rows else tuple((c_double * 12).from_address(world.address or 0))
            self._node_names = [name.decode() for name in names if name is not None]
            self._first_poses = True
            self._answered = False
            self._has_late_names = any(map(self._is_added, self._node_names))
            self._advice = {text for text in self._advice if "edit" in text}  # edits outlive the description
            self._expect_advice()

    def publish(self, sim_time_ns: int, stream_from_body: Array, flags: int = 0) -> int:
        """Publishes one whole frame and returns its sequence. Does not block.

        stream_from_body: (n, 3, 4), (n, 4, 4) or (n, 12), one pose per described node: transforms body coordinates to
        stream coordinates, row-major, metres unless world_from_stream scales; fire3dv.pose makes them. Contiguous
        float32 arrays, but for (n, 4, 4), are passed to the library without a copy. flags: FRAME_DISCONTINUITY or 0.
        """
        poses = Numbers(stream_from_body, (3, 4), "stream_from_body")
        names = self._described()
        if poses.rows != len(names):
            raise ArgumentError(ErrorCode.ARGUMENT, f"stream_from_body has {poses.rows} poses; describe() named "
                                f"{len(names)} nodes")
        self._check_first_poses(poses, names)
        return self._publish(library().fire3dv_publish, whole(sim_time_ns, c_int64, "sim_time_ns"), poses.address,
                             poses.rows, whole(flags, c_uint32, "flags"))

    def _publish(self, function: Any, *arguments: Any) -> int:
        with self._open_handle().lock:  # the library counts frames in the order of its calls
            self._call(function, *arguments)
            self._sequence += 1
            sequence = self._sequence
        self._look_for_answer(_ANSWER_INTERVAL_S)
        return sequence

    def _described(self) -> List[str]:
        self.handle  # raises if the stream is closed
        if self._node_names is None:
            raise StateError(ErrorCode.STATE, "the stream has no nodes yet: call describe() before publish()")
        return self._node_names

    def _check_first_poses(self, poses: Numbers, names: List[str]) -> None:
        """Warns of poses without a rotation, which shrink a node to a point, in the first frame only: arrays that were
        not filled, or with positions alone."""
        if not self._first_poses or not poses.address:
            return
        self._first_poses = False
        memory = memoryview((c_float * (12 * poses.rows)).from_address(poses.address)).cast("B")
        zero = bytes(12)
        nothing = [name for i, name in enumerate(names)
                   if all(memory[row:row + 12] == zero for row in range(48 * i, 48 * i + 48, 16))]
        if nothing:
            warn(f"all numbers of the rotation are 0 for {_listed(nothing)}: such a node is a point, and invisible; the "
                 "first 3 columns of a pose are the identity for an upright body")

    def publish_some(self, sim_time_ns: int, node_indices: Array, stream_from_body: Array, flags: int = 0) -> int:
        """Publishes a frame with the poses of the moved nodes only, and returns its sequence.

        node_indices: (k,) uint32, increasing; stream_from_body: (k, 3, 4), as in publish. The other nodes keep their
        poses. The first such frame after describe() must contain all nodes.
        """
        poses = Numbers(stream_from_body, (3, 4), "stream_from_body")
        names = self._described()
        indices = Numbers(node_indices, (1,), "node_indices", c_uint32, "uint32")
        if indices.rows != poses.rows:
            raise ArgumentError(ErrorCode.ARGUMENT, f"{indices.rows} node_indices for {poses.rows} poses")
        if poses.rows == len(names):
            self._check_first_poses(poses, names)
        return self._publish(library().fire3dv_publish_some, whole(sim_time_ns, c_int64, "sim_time_ns"),
                             indices.address, poses.address, poses.rows, whole(flags, c_uint32, "flags"))

    def poll(self) -> Status:
        """Processes replies of renderers and returns their status. Does not block. Call it regularly."""
        raw = c.RawStatus(ctypes.sizeof(c.RawStatus))
        self._call(library().fire3dv_poll, byref(raw))
        self._report_answer(raw)
        return Status(raw.renderers, raw.epoch, raw.sequence, raw.acked_sequence, raw.frames_published,
                      raw.frames_dropped, raw.welcome, raw.unmatched_names,
                      raw.welcome_message.decode("utf-8", "replace"), raw.conflicting_names, raw.contested_names,
                      raw.images_dropped)

    def _look_for_answer(self, interval_s: float) -> None:
        """Warns if the renderer's answers name faults, each once, also where poll() is never called."""
        now_s = time.monotonic()
        is_done = self._answered and not self._has_late_names and now_s > self._advice_until_s
        if is_done or now_s - self._asked_at_s < interval_s:
            return
        self._asked_at_s = now_s
        raw = c.RawStatus(ctypes.sizeof(c.RawStatus))
        if self._open_handle().call(library().fire3dv_poll, byref(raw)) == 0:
            self._report_answer(raw)

    def _report_answer(self, raw: c.RawStatus) -> None:
        if raw.welcome < 0:
            return
        message = raw.welcome_message.decode("utf-8", "replace")
        begin = _ADVICE.search(message)
        for text in _NEXT_ADVICE.split(message[begin.end():]) if begin else []:
            if text not in self._advice and not any(f"the node \"{name}\" is not added" in text for name in self._no_glb):
                self._advice.add(text)
                warn("the renderer says: this stream " + text)
        if not self._answered:
            self._answered = True
            self._warn_of_names(raw, message, is_late=False)
            if raw.welcome > 0:
                warn(f"the renderer does not accept this stream: {message}")
        if self._has_late_names and raw.acked_sequence > 0:  # with a frame, its nodes have been added
            self._has_late_names = False
            self._warn_of_names(raw, message, is_late=True)

    def _is_added(self, name: str) -> bool:
        """Whether add_node has added the node, or one above it."""
        parts = name.split("/")
        return any("/".join(parts[:count]) in self._added for count in range(1, len(parts) + 1))

    def _warn_of_names(self, raw: c.RawStatus, message: str, is_late: bool) -> None:
        """Warns of names that the answer has: of nodes that the stream adds (is_late), or of the others."""
        dots = " ..." if len(raw.welcome_message) >= _MESSAGE_BYTES else ""
        absent = "the scene has no node, or several, for"
        for count, start, fault in ((raw.unmatched_names, "no scene node is called ", absent),
                                    (raw.conflicting_names, "another stream drives ", "another stream drives")):
            listed = message.partition(start)[2].partition("; another stream drives ")[0].partition("; this stream ")[0]
            names = listed.split(", ")
            chosen = [name for name in names if self._is_added(name) == is_late]
            count -= len(names) - len(chosen)
            if count > 0 and chosen:
                warn(f"{fault} {count} of the {len(self._node_names or [])} nodes of describe(): "
                     f"{', '.join(chosen)}{dots}")

    def _expect_advice(self) -> None:
        self._advice_until_s = time.monotonic() + _ADVICE_S

    def _edit(self, function: Any, *arguments: Any) -> None:
        """Calls a function of the library that edits the scene: the renderer comments on an edit without effect."""
        self._call(function, *arguments)
        self._expect_advice()

    def wait_ack(self, sequence: int, timeout_ms: int) -> bool:
        """Lockstep: waits until a renderer has shown this frame. Returns False on timeout."""
        number = whole(sequence, c_uint64, "sequence")
        try:
            self._wait(whole(timeout_ms, c_uint32, "timeout_ms") / 1000,
                       lambda wait_ms: self._open_handle().call(library().fire3dv_wait_ack, number, wait_ms))
        except Timeout:
            return False
        self._look_for_answer(0)
        return True

    # Scene edits are keyed state: the newest value of each node and property is valid. A frame is shown with all edits
    # set before it was published. Nodes are found by name or path, like nodes of poses. What a renderer cannot do is a
    # SceneWarning, soon after.

    def set_visible(self, node: str, visible: bool) -> None:
        """Shows or hides the node and its descendants, including their shadows."""
        self._edit(library().fire3dv_set_visible, encoded(node, "node"), bool(visible))

    def set_base_color(self, node: str, rgba: Array) -> None:
        """Sets the base colour factor of the mesh of this node only. rgba: 4 numbers from 0 to 1, linear."""
        color = Numbers(rgba, (4,), "rgba")
        if color.rows != 1:
            raise ArgumentError(ErrorCode.ARGUMENT, f"rgba has {4 * color.rows} numbers; 4 are needed")
        self._edit(library().fire3dv_set_base_color, encoded(node, "node"), color.address)

    def set_light(self, node: str, kind: Union[LightKind, int], color_rgb: Array = (1, 1, 1),
                  intensity: float = 1.0, range_m: float = 0.0, inner_cone_rad: float = 0.0,
                  outer_cone_rad: float = 0.7853981634, casts_shadow: bool = True) -> None:
        """Adds a light to the node, or replaces the file's. It shines along -Z.

        color_rgb: linear. intensity: candela (POINT, SPOT) or lux (DIRECTIONAL). range_m: 0 for infinite.
        """
        color = Numbers(color_rgb, (3,), "color_rgb")
        if color.rows != 1:
            raise ArgumentError(ErrorCode.ARGUMENT, f"color_rgb has {3 * color.rows} numbers; 3 are needed")
        light = c.Light(ctypes.sizeof(c.Light), enumerated(kind, LightKind, "kind"),
                        (c_float * 3).from_address(color.address), real(intensity, "intensity"),
                        real(range_m, "range_m"), real(inner_cone_rad, "inner_cone_rad"),
                        real(outer_cone_rad, "outer_cone_rad"), bool(casts_shadow))
        self._edit(library().fire3dv_set_light, encoded(node, "node"), byref(light))

    def set_camera(self, node: str, vertical_fov_rad: float, near_m: float = 0.01, far_m: float = 0.0,
                   exposure: float = 0.0, f_number: float = 0.0, focus_distance_m: float = 0.0) -> None:
        """Adds a camera to the node, or replaces the file's. It looks along -Z.

        far_m: 0 for infinite. exposure: factor on linear colour; 0: the renderer's setting.
        f_number, focus_distance_m: thin lens for depth of field, aperture (0.1 to 1000) and metres along the view
        direction to the plane in focus; both 0: as the file or the renderer's settings have it. To move the focus,
        set the camera again before each frame.
        """
        camera = c.Camera(ctypes.sizeof(c.Camera), real(vertical_fov_rad, "vertical_fov_rad"),
                          real(near_m, "near_m"), real(far_m, "far_m"), real(exposure, "exposure"),
                          real(f_number, "f_number"), real(focus_distance_m, "focus_distance_m"))
        self._edit(library().fire3dv_set_camera, encoded(node, "node"), byref(camera))

    def add_node(self, node: str, parent: Optional[str] = None, parent_from_node: Optional[Array] = None,
                 asset_uri: Optional[str] = None, asset_glb: Optional[bytes] = None,
                 variant: Optional[str] = None) -> None:
        """Adds a node to the scene.

        parent: None for the scene's root. parent_from_node: (3, 4) or (4, 4), rest pose, metres. asset_uri: a glTF file
        below the renderer's asset folder. asset_glb: contents of a .glb file. Without either the node is empty.
        variant: a material variant of the asset (KHR_materials_variants); None: its default materials.
        """
        matrix = Numbers(parent_from_node if parent_from_node is not None else [], (3, 4), "parent_from_node")
        if matrix.rows > 1:
            raise ArgumentError(ErrorCode.ARGUMENT, "parent_from_node must hold 12 numbers")
        try:
            glb = bytes(memoryview(asset_glb)) if asset_glb is not None else b""
        except TypeError:
            raise ArgumentError(ErrorCode.ARGUMENT, f"asset_glb is of type {type(asset_glb).__name__}; bytes are "
                                "needed") from None
        if glb and not glb.startswith(b"glTF"):
            self._no_glb.add(node)
            warn(f"asset_glb of the node {node!r} is no .glb file, since it begins with {glb[:4]!r} and not with b'glTF': "
                 "renderers do not add the node; a file is read by open(path, 'rb').read()")
        added = c.Node(ctypes.sizeof(c.Node), encoded(parent, "parent"), matrix.address,
                       encoded(asset_uri, "asset_uri"),
                       ctypes.cast(c_char_p(glb), c_void_p) if glb else None, len(glb),
                       encoded(variant, "variant"))
        self._edit(library().fire3dv_add_node, encoded(node, "node"), byref(added))
        self._added.add(node)

    def remove_node(self, node: str) -> None:
        """Removes the node, added or from the file, and its descendants."""
        self._edit(library().fire3dv_remove_node, encoded(node, "node"))

    def set_vertices(self, node: str, positions: Array, normals: Optional[Array] = None) -> None:
        """Replaces the vertex positions of the node's mesh: (v, 3) float32, metres, in the mesh's frame and order.

        normals: (v, 3) float32 of unit length; None: computed by the renderer.
        """
        vertex_rows = Numbers(positions, (3,), "positions")
        directions = Numbers(normals if normals is not None else [], (3,), "normals")
        if directions.rows not in (0, vertex_rows.rows):
            raise ArgumentError(ErrorCode.ARGUMENT, f"{directions.rows} normals for {vertex_rows.rows} positions")
        vertices = c.Vertices(ctypes.sizeof(c.Vertices), vertex_rows.address, directions.address, vertex_rows.rows)
        self._edit(library().fire3dv_set_vertices, encoded(node, "node"), byref(vertices))

    def clear(self, node: str, prop: Union[Property, int]) -> None:
        """Clears the edit of one property: the value of the scene file applies again."""
        self._edit(library().fire3dv_clear, encoded(node, "node"), enumerated(prop, Property, "prop"))
