"""Publisher of SOFA simulations: a controller for SofaPython3.

    import fire3dv.sofa

    def createScene(root):
        ...
        root.addObject(fire3dv.sofa.Fire3dvController(name="fire3dv", node=root, uri="shm://sofa"))

It publishes, after each step and at SOFA's time, what lies below a node:

- visual models (OglModel): vertices as they deform, and their triangles and quads again when these change, as by cutting;
- rigid frames (MechanicalObject of Rigid3), as nodes without a mesh;
- cameras (InteractiveCamera), and lights (DirectionalLight, PositionalLight, SpotLight).

fire3dv.sofa.write_scene(path) writes an empty scene for a renderer that shows nothing else. Needs NumPy. SOFA is needed by
scenes of SOFA alone: Publisher reads objects by the attributes that SofaPython3 gives them.
"""
from __future__ import annotations

import importlib
import math
import os
import re
from typing import Any, Dict, List, Optional, Sequence, Set, Union

import numpy as np

from .._types import Array, Float32Array
from ..errors import ArgumentError, ErrorCode
from ..image import Image
from ..images import WAIT_S, ImageRequest, images_of
from ..poses import look_at, pose
from ..robot import FrameSequence
from ..status import LightKind, Property
from ..stream import Stream
from ._visual import MESH, VisualModel, glb_file, is_visual, rows_of, value

try:
    _Controller: Any = importlib.import_module("Sofa.Core").Controller
except ImportError:
    _Controller = object

_LEAST_NEAR_M = 1e-4
_NAME, _OTHER = r"[\w .()-]+", r"[^\w .()-]"  # of nodes, so that paths have no escapes
_LIGHTS = {"DirectionalLight": LightKind.DIRECTIONAL, "PositionalLight": LightKind.POINT, "SpotLight": LightKind.SPOT}


def write_scene(path: Union[str, "os.PathLike[str]"]) -> None:
    """Writes a .glb scene with one node, "SOFA scene", and nothing to see, for a renderer that shows a simulation alone."""
    with open(path, "wb") as file:
        file.write(glb_file({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": "SOFA scene"}]}, ()))


class Publisher:
    """Publishes what lies below a SOFA node. One publisher for each stream. Fire3dvController has one.

    Its nodes in the renderer are called as the objects' paths in SOFA with points for slashes: "Liver.Visu.VisualModel";
    the mesh of a visual model is the node "mesh" below. All are below a node that is called as `root_name`, so the path of
    that mesh is "SOFA/Liver.Visu.VisualModel/mesh".
    """

    def __init__(self, stream: Stream, node: Any, *, metres_per_unit: float = 1.0, world_from_stream: Optional[Array] = None,
                 root_name: str = "SOFA", lights: bool = True, update_visual: bool = False, rate_hz: float = 0.0) -> None:
        """Reads objects with each frame: such that come and go meanwhile are followed.

        node: of SOFA, usually the root, whose "time" is the time of frames. metres_per_unit: of SOFA's lengths, 0.001 for
        millimetres. world_from_stream: (3, 4), rotation and position in metres; None: Y is up. lights: whether lights are
        published; their brightness at the middle of the visual models is that of SOFA. update_visual: calls
        Sofa.Simulation.updateVisual first, which visual models without a window need to follow the topology of another
        object. rate_hz: frames per second of simulated time, 0: unknown.
        """
        if not (math.isfinite(metres_per_unit) and metres_per_unit > 0):
            raise ArgumentError(ErrorCode.ARGUMENT, f"metres_per_unit is {metres_per_unit:g}; a number above 0 is needed")
        if not re.fullmatch(_NAME, root_name):
            raise ArgumentError(ErrorCode.ARGUMENT, f"root_name is {root_name!r}; letters, digits, blanks and _ . ( ) - are needed")
        self._stream, self._node, self._unit = stream, node, float(metres_per_unit)
        self._root_name, self._lights, self._rate_hz = root_name, lights, rate_hz
        world = np.eye(3, 4) if world_from_stream is None else np.array(world_from_stream, float)[:3]
        self._world_from_stream = np.column_stack([world[:, :3] * self._unit, world[:, 3]])
        self._update_visual = importlib.import_module("Sofa.Simulation").updateVisual if update_visual else None
        self._visuals: Dict[str, VisualModel] = {}
        self._settings: Dict[str, Any] = {}  # of cameras and lights, as they were sent
        self._added: Set[str] = set()
        self._described: List[str] = []
        self._frames = FrameSequence(stream)
        self._add(root_name)

    @property
    def names(self) -> List[str]:
        """Names of the nodes whose poses are published."""
        return list(self._described)

    def publish(self) -> int:
        """Publishes the present state at the time of the node, and returns the sequence. Does not block.

        A decrease of time, as by a reset, is a discontinuity.
        """
        if self._update_visual is not None:
            self._update_visual(self._node)
        objects = self._objects()
        self._publish_visuals({name: item for name, item in objects.items() if is_visual(item)})
        poses: Dict[str, Any] = {self._root_name: np.eye(3, 4, dtype=np.float32)}
        for name, item in objects.items():
            if item.getClassName() == "MechanicalObject" and item.getTemplateName().startswith("Rigid3"):
                frames = rows_of(item, "position", np.float64, 7)
                for i, frame in enumerate(frames):
                    poses[name if len(frames) == 1 else f"{name} {i}"] = pose(frame[:3], frame[3:])
            elif item.findData("fieldOfView") is not None:
                poses[name] = self._camera(name, item)
            elif self._lights and item.getClassName() in _LIGHTS:
                poses[name] = self._light(name, item)
        self._describe(list(poses))
        time_ns = round(1e9 * float(value(self._node, "time")))
        return self._frames.publish(time_ns, np.stack(list(poses.values())).astype(np.float32))

    def step(self, requests: Sequence[ImageRequest], timeout_s: float = WAIT_S) -> List[Image]:
        """Lockstep: publishes, as publish(), and waits for the frame's image from each request.

        requests: of Stream.request_image, with when="every_nth". Images of earlier frames are skipped.
        """
        return images_of(self.publish(), requests, timeout_s)

    def jump(self) -> None:
        """Makes the next frame a discontinuity: after a jump that the time does not show."""
        self._frames.jump()

    def __repr__(self) -> str:
        return f"<fire3dv.sofa.Publisher of {len(self._visuals)} visual models to {self._stream!r}>"

    def _objects(self) -> Dict[str, Any]:
        """Objects below the node by their names in the renderer, in the order of the graph."""
        named: Dict[str, Any] = {}
        seen: Set[str] = set()  # a node may have several parents

        def visit(node: Any, path: str) -> None:
            if str(node.getPathName()) in seen:
                return
            seen.add(str(node.getPathName()))
            for item in node.objects:
                name = re.sub(_OTHER, "_", path + str(item.getName()))
                while name in named or name == self._root_name:
                    name += "'"
                named[name] = item
            for child in node.children:
                visit(child, path + str(child.getName()) + ".")
        visit(self._node, "")
        return named

    def _add(self, name: str) -> None:
        if name not in self._added:
            self._stream.add_node(name, None if name == self._root_name else self._root_name)
            self._added.add(name)

    def _publish_visuals(self, models: Dict[str, Any]) -> None:
        for name in [name for name, sent in self._visuals.items() if models.get(name) is not sent.model]:
            self._stream.clear(self._mesh(name), Property.VERTICES)
            self._stream.clear(name, Property.VISIBLE)
            self._stream.clear(name, Property.NODE)
            del self._visuals[name]
        for name, model in models.items():
            visual = self._visuals.get(name) or VisualModel(model, name)
            places = visual.places_now()
            faces = visual.faces_now(len(places))
            if len(faces) == 0:
                continue
            if not np.isfinite(places).all():
                raise ArgumentError(ErrorCode.ARGUMENT, f"a vertex of {model.getPathName()} is not finite: the simulation is unstable")
            if visual.has_changed(faces, places):
                is_new = name not in self._visuals
                self._stream.add_node(name, self._root_name, asset_glb=visual.glb(faces, places))
                if not is_new:  # those before are of the other mesh, which is shown until this one is there
                    self._send(visual, places)
                self._visuals[name] = visual
            elif not np.array_equal(places, visual.places):
                self._send(visual, places)
            visual.faces, visual.places = faces, places
            shown = bool(True if value(model, "enable") is None else value(model, "enable"))
            if shown != visual.shown:
                self._stream.set_visible(name, shown)
                visual.shown = shown

    def _send(self, visual: VisualModel, places: Any) -> None:
        self._stream.set_vertices(self._mesh(visual.name), places)

    def _mesh(self, name: str) -> str:
        """Path of the node whose vertices are replaced."""
        return f"{self._root_name}/{name}/{MESH}"

    def _describe(self, names: List[str]) -> None:
        """Other names are another description, whose first frame is a discontinuity."""
        if names == self._described:
            return
        for name in set(self._described) - set(names):
            if self._settings.pop(name, None) is not None:
                self._stream.clear(name, Property.CAMERA)
                self._stream.clear(name, Property.LIGHT)
            self._stream.clear(name, Property.NODE)
            self._added.discard(name)
        for name in names:
            self._add(name)
        # Frames of SOFA's units have its scale, except cameras and lights, whose settings are in metres.
        unscaled = np.column_stack([np.eye(3) / self._unit, np.zeros(3)])
        offsets = [unscaled if name in self._settings else np.eye(3, 4) for name in names]
        self._stream.describe(names, world_from_stream=self._world_from_stream, body_from_node=np.array(offsets, np.float32),
                              nominal_rate_hz=self._rate_hz)
        self._described = names
        self._frames.jump()

    def _set(self, name: str, settings: Any) -> bool:
        """Whether the settings of a camera or light are other than were sent. Its node must be there first."""
        self._add(name)
        before, self._settings[name] = self._settings.get(name), settings
        return bool(before != settings)

    def _camera(self, name: str, item: Any) -> Float32Array:
        near = value(item, "zNear")
        near_m = self._unit * float(near) if near is not None and math.isfinite(near) else 0.0
        settings = (math.radians(float(value(item, "fieldOfView"))), max(near_m, _LEAST_NEAR_M))
        if self._set(name, settings):
            self._stream.set_camera(name, *settings)
        return pose(value(item, "position"), value(item, "orientation"))

    def _light(self, name: str, item: Any) -> Float32Array:
        """Brightness: OpenGL's light of colour c makes a white surface as bright as c, for which it needs pi * c lux."""
        color = tuple(float(c) for c in np.asarray(value(item, "color") if item.findData("color") else (1, 1, 1), float).ravel()[:3])
        shines = np.asarray(value(item, "direction") if item.findData("direction") else (0, 0, -1), float)
        kind, place, cone = _LIGHTS[item.getClassName()], np.zeros(3), math.pi / 4
        distance_m = 1.0
        if kind == LightKind.DIRECTIONAL:
            shines = -shines  # OpenGL's position of a light without one is the direction that it comes from
        else:
            place = np.asarray(value(item, "position"), float)
            distance_m = max(self._unit * float(np.linalg.norm(place - self._middle())), _LEAST_NEAR_M)
        if kind == LightKind.SPOT:
            cone = math.radians(min(max(float(value(item, "cutoff") or 30), 0.1), 90))
        if self._set(name, (color, cone)):  # its distance as it was when it was seen first
            self._stream.set_light(name, kind, color, math.pi * distance_m ** 2, inner_cone_rad=0.5 * cone, outer_cone_rad=cone)
        up = (0, 0, 1) if abs(shines[1]) > 0.9 * np.linalg.norm(shines) else (0, 1, 0)
        return look_at(place, place + shines, up) if shines.any() else pose(place)

    def _middle(self) -> Any:
        places = [visual.places for visual in self._visuals.values()]
        every = np.concatenate(places) if places else np.zeros((1, 3))
        return 0.5 * (every.min(0) + every.max(0))


class Fire3dvController(_Controller):  # type: ignore[misc]
    """Controller that publishes when SOFA has updated the mappings of a step: vertices and frames are of one step.

    A class of Sofa.Core.Controller where SOFA is importable. It holds its `publisher` once the simulation is initialised.
    """

    def __init__(self, *args: Any, node: Any, uri: Optional[str] = None, stream: Optional[Stream] = None,
                 **kwargs: Any) -> None:
        """node: of SOFA, usually the root. uri: of the renderer, as for Stream; or stream, which the caller closes.

        Further arguments are those of Publisher, and of Sofa.Core.Controller, such as name.
        """
        if (uri is None) == (stream is None):
            raise ArgumentError(ErrorCode.ARGUMENT, "Fire3dvController needs uri or stream, and not both")
        options = {key: kwargs.pop(key) for key in _OPTIONS if key in kwargs}
        if _Controller is not object:
            _Controller.__init__(self, *args, **kwargs)
        self._own = stream if stream is not None else Stream(str(uri), "SOFA")
        self._of_publisher = (node, options)
        self.publisher: Optional[Publisher] = None

    def onSimulationInitDoneEvent(self, event: Any) -> None:
        """Of SOFA: publishes the initial state."""
        self._publish()

    def onUpdateMappingEndEvent(self, event: Any) -> None:
        """Of SOFA, after AnimateEndEvent, when visual models have followed: publishes the step."""
        self._publish()

    def _publish(self) -> None:
        if self.publisher is None:
            node, options = self._of_publisher
            self.publisher = Publisher(self._own, node, **options)
        self.publisher.publish()


_OPTIONS = ("metres_per_unit", "world_from_stream", "root_name", "lights", "update_visual", "rate_hz")
