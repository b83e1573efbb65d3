"""Robots by joint positions: forward kinematics of the C library (fire3dv/joints.h), published to renderers."""
from __future__ import annotations

import array
import ctypes
import os
import time
import weakref
from ctypes import byref, c_double, c_float, c_int64, c_void_p
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

from . import _library as c
from ._library import check, encoded, library
from ._numbers import Numbers, real, whole
from ._scene_names import converted, is_gltf
from ._types import Array, Float64Array
from .errors import ArgumentError, BudgetError, ErrorCode, StateError, error_of
from .stream import FRAME_DISCONTINUITY, Stream

if TYPE_CHECKING:
    from .renderer import Path, Renderer

_NO_MIMIC = 1  # FIRE3DV_ROBOT_NO_MIMIC
_CLAMP, _WXYZ = 1, 2  # FIRE3DV_POSITIONS_*


class JointType(IntEnum):
    """FIRE3DV_JOINT_* of joints.h."""
    FIXED = 0
    REVOLUTE = 1  #: radians; without limits: continuous
    PRISMATIC = 2  #: metres
    PLANAR = 3  #: x, y in the plane normal to the axis, angle about it
    BALL = 4  #: unit quaternion x, y, z, w
    FLOATING = 5  #: x, y, z, unit quaternion x, y, z, w


@dataclass(frozen=True)
class Joint:
    """A joint of a robot. Lengths in metres, angles in radians, vectors in the frame of the node."""
    name: str
    node: str  #: scene node that it moves
    type: JointType
    position_index: int  #: of its first number in Robot.positions
    position_count: int  #: 0: fixed, or follows another joint
    limits: Optional[Tuple[float, float]]
    axis: Tuple[float, float, float]
    anchor: Tuple[float, float, float]  #: point that it turns about
    mimic: Optional[str]  #: joint that it follows: position = multiplier * position of that + offset
    multiplier: float
    offset: float


def _close(handle: int) -> None:
    library().fire3dv_close_robot(byref(c_void_p(handle)))


class Robot:
    """Kinematics of a robot, from a URDF, xacro, SDF, MJCF or AMBF file, or from a .glb of fire3dv-convert.

        robot = fire3dv.Robot("arm.urdf")
        robot.set(shoulder=0.3, elbow=-1.2)
        robot.node_pose("gripper")      # (3, 4) float64

    Any thread may use a robot: calls exclude each other.
    """

    def __init__(self, file: Path, *, mimic: bool = True, arguments: Sequence[Path] = (),
                 program: Optional[Path] = None) -> None:
        """Reads the joints. Other files than .glb and .gltf are converted by fire3dv-convert first.

        mimic: False makes joints that mimic others independent. arguments: options of fire3dv(1) that select the
        contents, such as ["--package-path", "ws/src"]. program: the renderer, beside which fire3dv-convert is; None: as
        fire3dv.Renderer finds it.
        """
        self.file = os.fspath(file)  #: as given
        flags = 0 if mimic else _NO_MIMIC
        if is_gltf(self.file):
            handle = library().fire3dv_open_robot(encoded(self.file, "file"), flags)
        else:
            from .renderer import find_program
            data = converted(self.file, find_program(program), [os.fspath(a) for a in arguments], "joints")
            handle = library().fire3dv_read_robot(data, len(data), flags)
        if not handle:
            sentence = library().fire3dv_last_error().decode("utf-8", "replace")
            if self.file not in sentence:
                sentence = f"{self.file}: {sentence}"
            raise error_of(ErrorCode.ARGUMENT, sentence)
        self._handle = c_void_p(handle)
        self._closed = weakref.finalize(self, _close, handle)
        self.joints: List[Joint] = self._read_joints()  #: all, in the order of the file
        #: Names of the joints that have a position: those that neither are fixed nor follow others.
        self.joint_names: List[str] = [joint.name for joint in self.joints if joint.position_count]
        self._index: Dict[str, int] = {joint.name: i for i, joint in enumerate(self.joints)}
        description = c.Description(ctypes.sizeof(c.Description))
        check(library().fire3dv_get_robot_description(self._handle, byref(description)))
        count = description.node_count
        #: Scene nodes that publish() moves.
        self.node_names: List[str] = [description.node_names[i].decode() for i in range(count)]
        self._world_from_stream = [description.world_from_stream[i] for i in range(12)]
        scales = description.body_from_node_count
        self._body_from_node = None
        if scales:
            self._body_from_node = list((c_float * (12 * scales)).from_address(description.body_from_node))
        self._poses = array.array("f", bytes(48 * count))

    def _read_joints(self) -> List[Joint]:
        found = []
        for i in range(library().fire3dv_joint_count(self._handle)):
            raw = c.Joint(ctypes.sizeof(c.Joint))
            check(library().fire3dv_get_joint(self._handle, i, byref(raw)))
            found.append(raw)
        names = [raw.name.decode() for raw in found]
        return [Joint(name, raw.node.decode(), JointType(raw.type), raw.position_index, raw.position_count,
                      (raw.lower, raw.upper) if raw.has_limits else None, tuple(raw.axis), tuple(raw.anchor),
                      names[raw.followed_joint] if raw.followed_joint >= 0 else None, raw.multiplier, raw.offset)
                for name, raw in zip(names, found)]

    def joint(self, name: str) -> Joint:
        """Returns the joint of this name."""
        return self.joints[self._index_of(name)]

    def _index_of(self, name: str) -> int:
        try:
            return self._index[name]
        except (KeyError, TypeError):
            known = ", ".join(map(repr, self.joint_names[:8])) + (" ..." if len(self.joint_names) > 8 else "")
            raise ArgumentError(ErrorCode.ARGUMENT, f"{self.file} has no joint {name!r}; it has {known}") from None

    @property
    def positions(self) -> List[float]:
        """Positions of all joints, in the order of joint_names; joints with several numbers take several places."""
        count = library().fire3dv_position_count(self._handle)
        numbers = (c_double * count)()
        check(library().fire3dv_get_positions(self._handle, numbers, count))
        return list(numbers)

    def set(self, positions: Union[Mapping[str, Union[float, Array]], Array, None] = None, *, clamp: bool = False, wxyz: bool = False,
            **joints: Union[float, Array]) -> None:
        """Sets joint positions, in radians and metres. Joints that are not named keep theirs.

        positions: dict of joint names, or numbers for all joints, in the order of joint_names. joints: the same by
        keywords. A planar joint takes 3 numbers, a ball joint 4, a floating joint 7. clamp: to the limits, which do not
        count otherwise. wxyz: quaternions are w, x, y, z, as in MuJoCo's qpos. If a position is refused, none changes.
        """
        flags = (_CLAMP if clamp else 0) | (_WXYZ if wxyz else 0)
        named: Dict[str, Any] = dict(joints)
        if isinstance(positions, Mapping):
            named = {**positions, **joints}
        elif positions is not None:
            numbers = Numbers(positions, (1,), "positions", c_double, "float64")
            self._set_all(numbers, flags)
        before = self.positions
        try:
            for name, value in named.items():
                self._set_joint(name, value, flags)
        except BaseException:
            self._set_all(Numbers(before, (1,), "positions", c_double, "float64"), 0)
            raise

    def _set_all(self, numbers: Numbers, flags: int) -> None:
        check(library().fire3dv_set_positions(self._handle, numbers.address, numbers.rows, flags))

    def _set_joint(self, name: str, value: Any, flags: int) -> None:
        index = self._index_of(name)
        if hasattr(value, "__iter__"):
            numbers = Numbers(value, (1,), name, c_double, "float64")
        else:
            numbers = Numbers([real(value, name)], (1,), name, c_double, "float64")
        check(library().fire3dv_set_joint(self._handle, index, numbers.address, numbers.rows, flags))

    def set_base(self, stream_from_model: Optional[Array]) -> None:
        """Places the robot: pose of its description's frame in the stream, (3, 4) or (4, 4); None: the identity."""
        given = stream_from_model if stream_from_model is not None else []
        base = Numbers(given, (3, 4), "stream_from_model", c_double, "float64")
        if base.rows > 1:
            raise ArgumentError(ErrorCode.ARGUMENT, f"stream_from_model has {base.rows} poses; one is needed")
        check(library().fire3dv_set_base(self._handle, base.address))

    def node_pose(self, node: str) -> Float64Array:
        """Returns the pose of a link or body, (3, 4) float64, stream_from_node. Needs NumPy."""
        import numpy
        pose = (c_double * 12)()
        check(library().fire3dv_get_node_pose(self._handle, encoded(node, "node"), pose))
        return numpy.array(pose).reshape(3, 4)

    def poses(self) -> "array.array[float]":
        """Returns stream_from_node of node_names, 12 floats each; the next call overwrites them."""
        check(library().fire3dv_get_poses(self._handle, self._poses.buffer_info()[0], len(self.node_names)))
        return self._poses

    def describe(self, stream: Stream, nominal_rate_hz: float = 0.0) -> None:
        """Describes the robot's nodes to a stream, whose frames are then poses()."""
        stream.describe(self.node_names, self._world_from_stream, self._body_from_node, nominal_rate_hz)

    def publish(self, to: Union[str, Stream, Renderer], adapter_name: Optional[str] = None, *,
                nominal_rate_hz: float = 0.0, scalars: Optional[str] = "joint_positions") -> RobotPublisher:
        """Publishes the robot to a URI, such as "shm://demo", to a Renderer, or over an open stream.

        Use it in a with statement. scalars: group of scalars that has the joint positions, in rad and m, for plots and
        recordings; two robots of a stream need two. None: there are none.
        """
        return RobotPublisher(self, to, adapter_name, nominal_rate_hz, scalars)

    def __repr__(self) -> str:
        return f"<fire3dv.Robot {self.file!r}, {len(self.joint_names)} joints>"


class FrameSequence:
    """Publishes frames of a simulator whose time may jump back.

    The first one, and one whose time is before that of the last, is a discontinuity.
    """

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self._last_ns: Optional[int] = None

    def publish(self, sim_time_ns: int, poses: Array) -> int:
        """Returns the sequence. Does not block."""
        jumped = self._last_ns is None or sim_time_ns < self._last_ns
        sequence = self._stream.publish(sim_time_ns, poses, FRAME_DISCONTINUITY if jumped else 0)
        self._last_ns = sim_time_ns
        return sequence

    def jump(self) -> None:
        """Makes the next frame a discontinuity."""
        self._last_ns = None


class RobotPublisher:
    """Publishes a robot. close(), or the end of a with statement, closes the stream that publish() has opened."""

    def __init__(self, robot: Robot, to: Union[str, Stream, Renderer], adapter_name: Optional[str],
                 nominal_rate_hz: float, scalars: Optional[str] = "joint_positions") -> None:
        self.robot = robot
        self._scalars = encoded(scalars, "scalars")
        self._owns_stream = not isinstance(to, Stream)
        if isinstance(to, Stream):
            self.stream = to
        else:
            self.stream = Stream(to, adapter_name) if isinstance(to, str) else to.stream(adapter_name)
        self._start_ns: Optional[int] = None
        self._frames = FrameSequence(self.stream)
        try:
            robot.describe(self.stream, nominal_rate_hz)
        except BaseException:
            self.close()
            raise

    def set(self, positions: Union[Mapping[str, Union[float, Array]], Array, None] = None, *, sim_time_ns: Optional[int] = None,
            clamp: bool = False, wxyz: bool = False, **joints: Union[float, Array]) -> int:
        """Robot.set, then send."""
        if not self.stream.is_open:
            raise StateError(ErrorCode.STATE, "the stream is closed")
        self.robot.set(positions, clamp=clamp, wxyz=wxyz, **joints)
        return self.send(sim_time_ns)

    def send(self, sim_time_ns: Optional[int] = None) -> int:
        """Publishes the robot's pose, and returns the sequence. Does not block.

        sim_time_ns: None: the time since the first frame, by this machine's clock. A time that decreases is a
        discontinuity: renderers do not interpolate into the frame.
        """
        if sim_time_ns is None:
            now_ns = time.monotonic_ns()
            self._start_ns = now_ns if self._start_ns is None else self._start_ns
            sim_time_ns = now_ns - self._start_ns
        if self._scalars is not None:
            try:
                self.stream._call(library().fire3dv_set_joint_scalars, self.robot._handle, self._scalars,
                                  whole(sim_time_ns, c_int64, "sim_time_ns"))
            except BudgetError:  # the stream has others, or the robot too many: its poses do not depend on them
                self._scalars = None
        return self._frames.publish(sim_time_ns, self.robot.poses())

    def close(self) -> None:
        """Closes the stream, unless publish() was given one. May be called repeatedly."""
        if self._owns_stream:
            self.stream.close()

    def __enter__(self) -> RobotPublisher:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<fire3dv.RobotPublisher of {self.robot!r} to {self.stream!r}>"
