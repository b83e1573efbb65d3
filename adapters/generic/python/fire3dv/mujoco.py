"""Publisher of MuJoCo simulations: models and data of Python's package mujoco, by its documented attributes.

    import mujoco, fire3dv, fire3dv.mujoco
    model = mujoco.MjModel.from_xml_path("scene.xml")
    data = mujoco.MjData(model)
    with fire3dv.Renderer("scene.xml") as renderer, renderer.stream("MuJoCo") as stream:
        publisher = fire3dv.mujoco.Publisher(stream, model)
        while data.time < 10:
            mujoco.mj_step(model, data)
            publisher.publish(data)

With images of cameras, in lockstep:

        camera = stream.request_image(640, 480, node="wrist", when="every_nth", outputs=["color", "depth"])
        while data.time < 10:
            mujoco.mj_step(model, data)
            [image] = publisher.step(data, [camera])

Names are those that fire3dv and fire3dv-convert give the nodes of the same MJCF file. Needs NumPy, and not mujoco.
"""
from __future__ import annotations

from typing import Any, Iterable, List, Sequence, Set, Tuple, Union

import numpy as np

from ._types import Float32Array, Shown
from .errors import ArgumentError, ErrorCode
from .image import Image
from .images import WAIT_S, ImageRequest, images_of
from .robot import FrameSequence
from .stream import Stream

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


_SHOWN = ("contacts", "forces")
_MIN_LENGTH = 1e-15  # mjMINVAL
_LARGEST_M = 1e9  # of a marker's positions, as in fire3dv-mujoco
_PYRAMIDAL = 0  # mjCONE_PYRAMIDAL


def _shown_of(show: Union[str, Iterable[str]]) -> List[str]:
    names = [name for name in show.split(",") if show] if isinstance(show, str) else list(show)
    for name in names:
        if name not in _SHOWN:
            raise ArgumentError(ErrorCode.ARGUMENT, f"show has {name!r}; use \"contacts\", \"forces\" or "
                                "\"contacts,forces\"")
    return names


def _bytes_of(rgba: Any) -> "np.ndarray[Any, Any]":
    return np.rint(255 * np.clip(np.nan_to_num(np.asarray(rgba, float)), 0, 1)).astype(np.uint8).reshape(1, 4)


class _Contacts:
    """Contacts and their forces as markers, in the sizes and colours that MuJoCo's viewer has, as fire3dv-mujoco --show."""

    def __init__(self, stream: Stream, model: Any, shown: Sequence[str]) -> None:
        self._stream, self._model, self._shown = stream, model, shown
        self._empty = {"contacts": True, "forces": True}

    def publish(self, data: Any) -> None:
        model, visual, size = self._model, self._model.vis, float(self._model.stat.meansize)
        contacts = [data.contact[i] for i in range(int(data.ncon))]
        places = np.array([contact.pos for contact in contacts], float).reshape(-1, 3)
        is_near = (np.abs(places) <= _LARGEST_M).all(axis=1)  # false for NaN, of a simulation that has diverged
        if "contacts" in self._shown:
            is_active = np.array([int(contact.efc_address) >= 0 for contact in contacts], bool)
            colors = np.where(is_active[:, None], _bytes_of(visual.rgba.contactpoint), _bytes_of(visual.rgba.contactgap))
            if self._has_any("contacts", int(is_near.sum())):  # MuJoCo's width is a radius
                self._stream.points("contacts/points", places[is_near].astype(np.float32), colors[is_near],
                                    size_m=2 * float(visual.scale.contactwidth) * size, overlaid=True)
        if "forces" in self._shown:
            metres_per_newton = float(visual.map.force) / max(float(model.stat.meanmass), _MIN_LENGTH)
            arrows = np.array([metres_per_newton * _force_on_later_body(model, data, contact) for contact in contacts],
                              float).reshape(-1, 3)
            is_shown = is_near & (np.linalg.norm(arrows, axis=1) > _MIN_LENGTH)
            is_shown &= (np.abs(places + arrows) <= _LARGEST_M).all(axis=1)
            if self._has_any("forces", int(is_shown.sum())):
                self._stream.arrows("contacts/forces", places[is_shown].astype(np.float32),
                                    arrows[is_shown].astype(np.float32), _bytes_of(visual.rgba.contactforce),
                                    width_m=2 * float(visual.scale.forcewidth) * size, overlaid=True)

    def _has_any(self, name: str, count: int) -> bool:
        """Clears a marker that has become empty."""
        was_empty, self._empty[name] = self._empty[name], count == 0
        if count == 0 and not was_empty:
            self._stream.clear_marker({"contacts": "contacts/points", "forces": "contacts/forces"}[name])
        return count > 0


def _force_on_later_body(model: Any, data: Any, contact: Any) -> "np.ndarray[Any, Any]":
    """The force of a contact on the body with the higher id, in the world, in newton; as mj_contactForce."""
    address, dimensions = int(contact.efc_address), int(contact.dim)
    if address < 0:
        return np.zeros(3)
    force = np.zeros(3)  # along the normal, which points from the first geom to the second, and both tangents
    if dimensions == 1 or int(model.opt.cone) != _PYRAMIDAL:
        used = min(dimensions, 3)
        force[:used] = data.efc_force[address:address + used]
    else:
        edges = np.asarray(data.efc_force[address:address + 2 * (dimensions - 1)], float)
        force[0] = edges.sum()
        for axis in range(min(dimensions - 1, 2)):
            force[1 + axis] = (edges[2 * axis] - edges[2 * axis + 1]) * float(contact.friction[axis])
    in_world = np.asarray(contact.frame, float).reshape(3, 3).T @ force
    geoms = (int(contact.geom1), int(contact.geom2))  # -1: of a flexible body
    bodies = [int(model.geom_bodyid[geom]) if geom >= 0 else -1 for geom in geoms]
    return -in_world if bodies[0] > bodies[1] else in_world


class Publisher:
    """Publishes the bodies and cameras of an mjModel, and geoms on request. One publisher for each stream."""

    def __init__(self, stream: Stream, model: Any, *, cameras: bool = True, geoms: bool = False,
                 rate_hz: float = 0.0, show: Union[Shown, str, Iterable[Shown]] = ()) -> None:
        """Describes the nodes to the stream: all bodies but the world.

        cameras: also cameras, whose modes MuJoCo computes. geoms: also geoms, for scenes of fire3dv-convert --geoms
        whose program changes geom_pos or geom_quat; without it they move with their bodies. rate_hz: frames per second
        of simulated time, 0: unknown; it selects none. show: "contacts", "forces" or "contacts,forces": with each frame,
        they are markers besides the bodies, in the sizes and colours of MuJoCo's viewer; images have them by
        request_image(markers=True).
        """
        shown = _shown_of(show)
        self._contacts = _Contacts(stream, model, shown) if shown else None
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
        self._frames = FrameSequence(stream)
        stream.describe(self.names, world_from_stream=WORLD_FROM_STREAM, nominal_rate_hz=rate_hz)

    def poses(self, data: Any) -> Float32Array:
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
        if self._contacts is not None:
            self._contacts.publish(data)  # before the frame, which is shown with them
        return self._frames.publish(round(1e9 * float(data.time)), poses)

    def step(self, data: Any, requests: Sequence[ImageRequest], timeout_s: float = WAIT_S) -> List[Image]:
        """Lockstep: publishes an mjData, as publish(), and waits for the frame's image from each request.

        requests: of Stream.request_image, with when="every_nth". Images of earlier frames are skipped.
        """
        return images_of(self.publish(data), requests, timeout_s)

    def jump(self) -> None:
        """Makes the next frame a discontinuity: after a jump that the time does not show."""
        self._frames.jump()

    def __repr__(self) -> str:
        return f"<fire3dv.mujoco.Publisher of {len(self.names)} nodes to {self._stream!r}>"
