"""Publisher of MuJoCo simulations: models and data of Python's package mujoco, by its documented attributes.

    import mujoco, fire3dv, fire3dv.mujoco
    model = mujoco.MjModel.from_xml_path("scene.xml")
    data = mujoco.MjData(model)
    with fire3dv.Renderer("scene.xml") as renderer, renderer.stream("MuJoCo") as stream:
        publisher = fire3dv.mujoco.Publisher(stream, model)
        while data.time < 10:
            mujoco.mj_step(model, data)
            publisher.publish(data)

Names are those that fire3dv and fire3dv-convert give the nodes of the same MJCF file. Needs NumPy, and not mujoco.
"""
from __future__ import annotations

from typing import Any, List, Set, Tuple

import numpy as np

from .errors import ArgumentError, ErrorCode
from .stream import FRAME_DISCONTINUITY, Stream

#: world_from_stream, (3, 4): MuJoCo's Z up to glTF's Y up. Metres.
WORLD_FROM_STREAM = ((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0))

_SHOWN_GROUPS = 3  # geoms of the groups 3 and above are collision shapes, by convention, and not converted
_DEFAULT_RGBA = (0.5, 0.5, 0.5, 1)
_CONTROL = {code: " " for code in (*range(0x20), 0x7f)}


def _own_names(model: Any, kind: str, count: int) -> List[str]:
    """Names in the model, "" for nameless objects."""
    addresses = getattr(model, f"name_{kind}adr", None)
    if addresses is not None:
        table = bytes(model.names)
        return [table[a:table.index(b"\0", a)].decode("utf-8", "replace") for a in map(int, addresses[:count])]
    accessor = getattr(model, {"cam": "camera"}.get(kind, kind))
    return [accessor(i).name for i in range(count)]


class _Names:
    """Unique names, by the rules of convert/mjcf/mjcf_nodes.cpp."""

    def __init__(self) -> None:
        self._taken: Set[str] = set()

    def free(self, name: str, kind: str) -> str:
        other, number = name, 0
        while other in self._taken:
            other = f"{name} {kind}" + (f" {number}" if number else "")
            number += 1
        self._taken.add(other)
        return other

    def all(self, own: List[str], kind: str) -> List[str]:
        return [self.free(name.translate(_CONTROL) or f"{kind}_{i}", kind) for i, name in enumerate(own)]


def node_names(model: Any) -> Tuple[List[str], List[str], List[str]]:
    """Returns the node names of all bodies, cameras and geoms of an mjModel, by index.

    Body 0 is the world. A body without a name is "body_N". Geoms are nodes in scenes of fire3dv-convert --geoms only.
    """
    names = _Names()
    own = _own_names(model, "body", model.nbody)
    bodies = [""] * len(own)
    for named in (True, False):  # so that no generated name takes that of a body
        for i, name in enumerate(own):
            if bool(name) == named:
                bodies[i] = names.free(name.translate(_CONTROL) or f"body_{i}", "body")
    names.free("free camera", "camera")
    cameras = names.all(_own_names(model, "cam", model.ncam), "camera")
    names.all(_own_names(model, "light", model.nlight), "light")
    return bodies, cameras, names.all(_own_names(model, "geom", model.ngeom), "geom")


def _is_shown(model: Any, geom: int) -> bool:
    rgba = model.geom_rgba[geom]
    material = int(model.geom_matid[geom])
    if material >= 0 and tuple(rgba) == _DEFAULT_RGBA:
        rgba = model.mat_rgba[material]
    return int(model.geom_group[geom]) < _SHOWN_GROUPS and rgba[3] > 0


class Publisher:
    """Publishes the bodies and cameras of an mjModel, and geoms on request. One publisher for each stream."""

    def __init__(self, stream: Stream, model: Any, *, cameras: bool = True, geoms: bool = False,
                 rate_hz: float = 0.0) -> None:
        """Describes the nodes to the stream: all bodies but the world.

        cameras: also cameras, whose modes MuJoCo computes. geoms: also geoms, for scenes of fire3dv-convert --geoms
        whose program changes geom_pos or geom_quat; without it they move with their bodies. rate_hz: frames per second
        of simulated time, 0: unknown.
        """
        self._stream = stream
        bodies, camera_names, geom_names = node_names(model)
        #: Attributes of mjData, and the rows of them that are published.
        self._parts: List[Tuple[str, str, int, Any]] = [("xpos", "xmat", model.nbody, np.arange(1, model.nbody))]
        self.names = bodies[1:]  #: of the described nodes
        if cameras and model.ncam:
            self._parts.append(("cam_xpos", "cam_xmat", model.ncam, np.arange(model.ncam)))
            self.names += camera_names
        if geoms:
            shown = [i for i in range(model.ngeom) if _is_shown(model, i)]
            self._parts.append(("geom_xpos", "geom_xmat", model.ngeom, np.array(shown, int)))
            self.names += [geom_names[i] for i in shown]
        self._poses = np.empty((len(self.names), 3, 4), np.float32)
        self._time_ns = 0
        self._jumped = True
        stream.describe(self.names, world_from_stream=WORLD_FROM_STREAM, nominal_rate_hz=rate_hz)

    def poses(self, data: Any) -> "np.ndarray[Any, Any]":
        """Returns stream_from_body of the described nodes, (n, 3, 4) float32, metres, Z up; the next call overwrites it."""
        begin = 0
        for places, turns, count, rows in self._parts:
            place, turn = np.asarray(getattr(data, places)), np.asarray(getattr(data, turns))
            if place.shape != (count, 3) or turn.size != 9 * count:
                raise ArgumentError(ErrorCode.ARGUMENT, f"data.{places} has the shape {place.shape}, but the model "
                                    f"needs ({count}, 3): publish data of the model of this publisher")
            part = self._poses[begin:begin + len(rows)]
            part[:, :, :3] = turn.reshape(count, 3, 3)[rows]
            part[:, :, 3] = place[rows]
            begin += len(rows)
        finite = np.isfinite(self._poses).all(axis=(1, 2))
        if not finite.all():
            raise ArgumentError(ErrorCode.ARGUMENT, f"the pose of {self.names[int(np.argmin(finite))]!r} is not "
                                f"finite at {data.time:g} s: the simulation is unstable")
        return self._poses

    def publish(self, data: Any) -> int:
        """Publishes poses and time of an mjData, and returns the sequence. Does not block.

        A decrease of time, as by mj_resetData, is a discontinuity. mj_step leaves poses of the step's beginning in data;
        call mujoco.mj_kinematics and mujoco.mj_camlight before, where they must be of data.time.
        """
        poses = self.poses(data)
        time_ns = round(1e9 * float(data.time))
        jumped = self._jumped or time_ns < self._time_ns
        sequence = self._stream.publish(time_ns, poses, FRAME_DISCONTINUITY if jumped else 0)
        self._time_ns, self._jumped = time_ns, False
        return sequence

    def jump(self) -> None:
        """Makes the next frame a discontinuity: after a jump that the time does not show."""
        self._jumped = True

    def __repr__(self) -> str:
        return f"<fire3dv.mujoco.Publisher of {len(self.names)} nodes to {self._stream!r}>"
