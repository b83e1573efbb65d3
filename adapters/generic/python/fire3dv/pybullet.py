"""Publisher of PyBullet simulations: bodies of a physics client, by the functions of the package pybullet.

    import pybullet, pybullet_data, fire3dv, fire3dv.pybullet
    pybullet.connect(pybullet.DIRECT)
    pybullet.setAdditionalSearchPath(pybullet_data.getDataPath())
    pybullet.setGravity(0, 0, -9.81)
    pybullet.loadURDF("plane.urdf")
    pybullet.loadURDF("r2d2.urdf", [0, 0, 1])
    fire3dv.pybullet.write_scene("world.urdf")              # the visual shapes of all bodies
    with fire3dv.Renderer("world.urdf") as renderer, renderer.stream("PyBullet") as stream:
        publisher = fire3dv.pybullet.Publisher(stream)
        for step in range(240):
            pybullet.stepSimulation()
            publisher.publish(step * 1_000_000_000 // 240)  # simulated time, nanoseconds

The scene may also be the URDF file that was loaded, with its own materials and textures: names of links are names of its
nodes. Needs NumPy, and pybullet where no other client is given.
"""
from __future__ import annotations

import importlib
import math
import os
from typing import Any, Callable, Dict, Iterable, List, NamedTuple, Optional, Sequence, Set, Tuple, Union
from xml.sax.saxutils import quoteattr

import numpy as np

from ._types import Float32Array
from .errors import ArgumentError, ErrorCode, warn
from .image import Image
from .images import WAIT_S, ImageRequest, images_of
from .poses import pose
from .robot import FrameSequence
from .stream import Stream

#: world_from_stream, (3, 4): PyBullet's Z up to glTF's Y up. Metres.
WORLD_FROM_STREAM = ((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0))

_ROOT = "PyBullet world"  # link of written scenes that has all others
_BASE = -1  # number of a base
_SPHERE, _BOX, _CYLINDER, _MESH, _PLANE, _CAPSULE = 2, 3, 4, 5, 6, 7  # pybullet.GEOM_*
_PLANE_SIZE_M, _PLANE_DEPTH_M = 200.0, 0.02
_WHITE = (1.0, 1.0, 1.0, 1.0)  # of links without a material: that of the mesh file is used


class Link(NamedTuple):
    """A link of a body, and the node that it moves."""
    name: str  #: of the node
    body: int  #: body's unique id
    number: int  #: of the link in its body; -1: the base


class _Client:
    """Functions of pybullet, or of a BulletClient, for one physics client."""

    def __init__(self, client: Optional[Any], physics_client: Optional[int]) -> None:
        if client is None:
            try:
                client = importlib.import_module("pybullet")
            except ImportError as fault:
                raise ArgumentError(ErrorCode.ARGUMENT, f"pybullet cannot be imported ({fault}): install it, or give a "
                                    "client with its functions") from None
        self._client = client
        self._options: Dict[str, Any] = {} if physics_client is None else {"physicsClientId": physics_client}

    def call(self, name: str, *arguments: Any, **options: Any) -> Any:
        function: Callable[..., Any] = getattr(self._client, name)
        return function(*arguments, **options, **self._options)


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _links(client: _Client, bodies: Optional[Iterable[int]]) -> List[Link]:
    every = [int(client.call("getBodyUniqueId", i)) for i in range(int(client.call("getNumBodies")))]
    chosen = every if bodies is None else [int(body) for body in bodies]
    for body in chosen:
        if body not in every:
            raise ArgumentError(ErrorCode.ARGUMENT, f"bodies has {body}; the simulation has {every}")
    own: List[Tuple[str, int, int]] = []
    for body in chosen:
        base = _text(client.call("getBodyInfo", body)[0]) or f"body_{body}"
        own.append((base, body, _BASE))
        for joint in range(int(client.call("getNumJoints", body))):
            own.append((_text(client.call("getJointInfo", body, joint)[12]) or f"link_{joint}", body, joint))
    names = [name for name, _, _ in own]
    taken: Set[str] = {name for name in names if names.count(name) == 1} | {_ROOT}
    links = []
    for name, body, index in own:
        if names.count(name) > 1 or name == _ROOT:
            wanted, number = f"{name} {body}", 1
            while wanted in taken:
                wanted, number = f"{name} {body} {number}", number + 1
            name = wanted
        taken.add(name)
        links.append(Link(name, body, index))
    return links


def _inverse_of_inertial_frame(client: _Client, body: int) -> Any:
    """(3, 4): inertial frame of a base to its link frame, since PyBullet's position of a base is of its centre of mass."""
    info = client.call("getDynamicsInfo", body, _BASE)
    inertial = pose(info[3], info[4]).astype(float)
    inverse = np.empty((3, 4))
    inverse[:, :3] = inertial[:, :3].T
    inverse[:, 3] = -inertial[:, :3].T @ inertial[:, 3]
    return inverse


def _chained(outer: Any, inner: Any) -> Any:
    result = np.empty((3, 4))
    result[:, :3] = outer[:, :3] @ inner[:, :3]
    result[:, 3] = outer[:, :3] @ inner[:, 3] + outer[:, 3]
    return result


class _Poses:
    """World poses of link frames."""

    def __init__(self, client: _Client, links: Sequence[Link]) -> None:
        self._client, self._links = client, links
        self._inverses = {link.body: _inverse_of_inertial_frame(client, link.body) for link in links if link.number == _BASE}

    def of(self, link: Link) -> Any:
        if link.number == _BASE:
            place, turn = self._client.call("getBasePositionAndOrientation", link.body)
            return _chained(pose(place, turn).astype(float), self._inverses[link.body])
        state = self._client.call("getLinkState", link.body, link.number, computeForwardKinematics=True)
        return pose(state[4], state[5])


class Publisher:
    """Publishes the links of PyBullet bodies. One publisher for each stream."""

    def __init__(self, stream: Stream, client: Optional[Any] = None, *, bodies: Optional[Iterable[int]] = None,
                 physics_client: Optional[int] = None, rate_hz: float = 0.0) -> None:
        """Describes the nodes to the stream: the base and all links of the bodies that are loaded now.

        client: the module pybullet, or a BulletClient; None imports pybullet. bodies: their unique ids; None: all.
        physics_client: as pybullet.connect returned it; None: pybullet's default. rate_hz: frames per second of
        simulated time, 0: unknown. Links are named as in their URDF file; a name that several links have is followed by
        the id of the body, such as "baseLink 2".
        """
        self._client = _Client(client, physics_client)
        self._stream = stream
        self.links = _links(self._client, bodies)  #: published links
        self._states = _Poses(self._client, self.links)
        self._poses = np.empty((len(self.links), 3, 4), np.float32)
        self._frames = FrameSequence(stream)
        stream.describe([link.name for link in self.links], world_from_stream=WORLD_FROM_STREAM, nominal_rate_hz=rate_hz)

    def poses(self) -> Float32Array:
        """Returns stream_from_body of the links, (n, 3, 4) float32, metres, Z up; the next call overwrites it."""
        for i, link in enumerate(self.links):
            self._poses[i] = self._states.of(link)
        return self._poses

    def publish(self, sim_time_ns: int) -> int:
        """Publishes the current poses at a simulated time, and returns the sequence. Does not block.

        A decrease of time, as after resetSimulation, is a discontinuity. Bodies that were loaded or removed since need
        another publisher.
        """
        return self._frames.publish(sim_time_ns, self.poses())

    def step(self, sim_time_ns: int, requests: Sequence[ImageRequest], timeout_s: float = WAIT_S) -> List[Image]:
        """Lockstep: publishes, as publish(), and waits for the frame's image from each request.

        requests: of Stream.request_image, with when="every_nth". Images of earlier frames are skipped.
        """
        return images_of(self.publish(sim_time_ns), requests, timeout_s)

    def jump(self) -> None:
        """Makes the next frame a discontinuity: after a jump that the time does not show."""
        self._frames.jump()

    def __repr__(self) -> str:
        return f"<fire3dv.pybullet.Publisher of {len(self.links)} links to {self._stream!r}>"


def write_scene(path: Union[str, "os.PathLike[str]"], client: Optional[Any] = None, *,
                bodies: Optional[Iterable[int]] = None, physics_client: Optional[int] = None,
                search_paths: Sequence[str] = ()) -> List[Link]:
    """Writes the visual shapes of the loaded bodies as one URDF file, and returns its links. Renderer reads it.

    path: of the .urdf file. Meshes are named by absolute paths, and read from there; search_paths: folders of those that
    PyBullet names relative to its own search path. client, bodies, physics_client: as for Publisher, which gives links the
    same names. Colours are those of the bodies; white is that of the mesh file. Planes are 200 m wide. Shapes that have
    no file, as of vertices and height fields, are left out with a SceneWarning.
    """
    used = _Client(client, physics_client)
    links = _links(used, bodies)
    states = _Poses(used, links)
    visuals: Dict[Tuple[int, int], List[str]] = {}
    for body in dict.fromkeys(link.body for link in links):
        for shape in used.call("getVisualShapeData", body):
            visuals.setdefault((body, int(shape[1])), []).extend(_visual(shape, search_paths))
    lines = ['<?xml version="1.0"?>', '<robot name="PyBullet world">', f"  <link name={quoteattr(_ROOT)}/>"]
    for i, link in enumerate(links):
        lines += [f"  <link name={quoteattr(link.name)}>", *visuals.get((link.body, link.number), []), "  </link>",
                  f'  <joint name="joint {i}" type="fixed">',
                  f"    <parent link={quoteattr(_ROOT)}/><child link={quoteattr(link.name)}/>",
                  f"    {_origin(states.of(link))}", "  </joint>"]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join([*lines, "</robot>", ""]))
    return links


def _origin(parent_from_child: Any) -> str:
    """Roll, pitch and yaw of a pose, about fixed axes x, y, z."""
    turn = np.asarray(parent_from_child, float)
    pitch = math.asin(max(-1.0, min(1.0, -turn[2, 0])))
    if abs(turn[2, 0]) < 1 - 1e-6:
        roll, yaw = math.atan2(turn[2, 1], turn[2, 2]), math.atan2(turn[1, 0], turn[0, 0])
    else:  # roll and yaw turn about the same axis
        roll, yaw = 0.0, math.atan2(-turn[0, 1], turn[1, 1])
    place = " ".join(f"{number:.9g}" for number in turn[:, 3])
    return f'<origin xyz="{place}" rpy="{roll:.9g} {pitch:.9g} {yaw:.9g}"/>'


def _visual(shape: Sequence[Any], search_paths: Sequence[str]) -> List[str]:
    """Lines of a row of getVisualShapeData."""
    body, _, kind, sizes, file, place, turn, rgba = shape[:8]
    frame = pose(place, turn).astype(float)
    parts: List[Tuple[float, str]] = [(0.0, "")]  # offset along z, geometry
    if kind == _SPHERE:
        parts = [(0.0, f'<sphere radius="{sizes[0]:.9g}"/>')]
    elif kind == _BOX:
        parts = [(0.0, f'<box size="{sizes[0]:.9g} {sizes[1]:.9g} {sizes[2]:.9g}"/>')]
    elif kind in (_CYLINDER, _CAPSULE):
        length, radius = sizes[0], sizes[1]
        parts = [(0.0, f'<cylinder length="{length:.9g}" radius="{radius:.9g}"/>')]
        if kind == _CAPSULE:
            parts += [(end * length / 2, f'<sphere radius="{radius:.9g}"/>') for end in (-1, 1)]
    elif kind == _PLANE:
        parts = [(-_PLANE_DEPTH_M / 2, f'<box size="{_PLANE_SIZE_M:g} {_PLANE_SIZE_M:g} {_PLANE_DEPTH_M:g}"/>')]
    elif kind == _MESH and _text(file):
        scale = " ".join(f"{number:.9g}" for number in sizes[:3])
        parts = [(0.0, f"<mesh filename={quoteattr(_found(_text(file), search_paths))} scale=\"{scale}\"/>")]
    else:
        what = "a mesh without a file" if kind == _MESH else f"a visual shape of the type {kind}"
        warn(f"{what} of body {body} is left out: only spheres, boxes, cylinders, capsules, planes and mesh files are "
             "written")
        return []
    color = " ".join(f"{number:.9g}" for number in rgba)
    material = "" if kind == _MESH and tuple(rgba) == _WHITE else f'<material name="{color}"><color rgba="{color}"/></material>'
    lines = []
    for along, geometry in parts:
        offset = np.column_stack([np.eye(3), (0.0, 0.0, along)])
        lines.append(f"    <visual>{_origin(_chained(frame, offset))}<geometry>{geometry}</geometry>{material}</visual>")
    return lines


def _found(file: str, search_paths: Sequence[str]) -> str:
    for folder in ("", *search_paths):
        path = os.path.join(folder, file)
        if os.path.exists(path):
            return os.path.abspath(path)
    warn(f"the mesh {file} is not found: add its folder to search_paths")
    return os.path.abspath(file)
