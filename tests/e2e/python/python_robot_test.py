"""Test of fire3dv.Robot: five lines publish a URDF's poses from joint positions, and the picture moves with them.

python_robot_test.py FIRE3DV STREAM_DUMP [CASE...]; fire3dv-convert is beside FIRE3DV.
"""
import math
import os
import subprocess
import sys

import numpy as np

import fire3dv
from harness import HANG_S, main, vulkan_environment
from image_reader import check
from stream_lines import StreamLines

BOX = "<visual><origin xyz='0.5 0 0'/><geometry><box size='1 0.2 0.2'/></geometry></visual>"
URDF = f"""<robot name="arm"><link name="base"/><link name="upper">{BOX}</link><link name="fore">{BOX}</link>
  <link name="tip"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="fore"/><origin xyz="1 0 0"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="finger" type="prismatic"><parent link="fore"/><child link="tip"/><origin xyz="1 0 0"/><axis xyz="1 0 0"/>
    <mimic joint="shoulder" multiplier="0.5"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>
"""
SCRIPT = """import fire3dv
robot = fire3dv.Robot("robot.urdf")
with robot.publish({uri!r}) as r:
    {wait}
    r.set(shoulder=0.3, elbow=-1.2)
"""


def write(test):
    path = test.path("robot.urdf")
    with open(path, "w", encoding="utf-8") as file:
        file.write(URDF)
    return path


def five_lines(test):
    path = write(test)
    stream = StreamLines(test.programs_at["stream_dump"], f"shm://test-robot-{os.getpid()}")
    script = SCRIPT.format(uri=stream.uri, wait="while not r.stream.poll().renderers: pass")
    subprocess.run([sys.executable, "-c", script], cwd=os.path.dirname(path), check=True, timeout=HANG_S,
                   env={**os.environ, "FIRE3DV": test.programs_at["fire3dv"]})
    messages = stream.end()
    description = next(m for m in messages if m["type"] == "StreamDescription")
    check(description["node_names"] == ["base", "upper", "fore", "tip"], description)
    check(np.allclose(description["world_from_stream"], [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0]), description)
    edits = [m["value"] for m in messages if m["type"] == "SceneEdit" and m["node"] == "joint_positions"]
    check({"type": "Scalars", "names": ["shoulder", "elbow"], "units": ["rad", "rad"]} in edits, edits)
    values = [v["values"] for v in edits if v["type"] == "ScalarValues"]  # sent again until the renderer has answered
    check(values and all(v == [0.3, -1.2] for v in values), edits)
    frame = [m for m in messages if m["type"] == "PoseFrame"][-1]
    shoulder, both = 0.3, 0.3 - 1.2
    elbow = [math.cos(shoulder), math.sin(shoulder), 0]
    reach = 1 + 0.5 * shoulder
    tip = [elbow[0] + reach * math.cos(both), elbow[1] + reach * math.sin(both), 0]
    poses = np.array(frame["poses"]).reshape(4, 3, 4)
    for node, place, angle in ((0, [0, 0, 0], 0), (1, [0, 0, 0], shoulder), (2, elbow, both), (3, tip, both)):
        turn = [[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]]
        check(np.allclose(poses[node], np.column_stack([turn, place]), atol=1e-6), f"{node}: {poses[node]}")


def raises(kind, text, call):
    try:
        call()
    except kind as error:
        check(text in str(error), f"{error}, instead of {text}")
    else:
        check(False, f"nothing was raised: {text}")


def positions(test):
    path, program = write(test), test.programs_at["fire3dv"]
    robot = fire3dv.Robot(path, program=program)
    check(robot.joint_names == ["shoulder", "elbow"], robot.joint_names)
    finger = robot.joint("finger")
    check((finger.mimic, finger.multiplier, finger.position_count) == ("shoulder", 0.5, 0), finger)
    check(robot.joint("shoulder").limits == (-1, 1) and robot.joint("elbow").limits is None, robot.joints)
    check(robot.joint("elbow").type is fire3dv.JointType.REVOLUTE, robot.joints)
    robot.set([2, 3])
    check(robot.positions == [2, 3], robot.positions)
    robot.set(np.array([2, 3.5]), clamp=True)
    check(robot.positions == [1, 3.5], robot.positions)
    robot.set({"elbow": 0}, shoulder=[0.25])
    check(robot.positions == [0.25, 0], robot.positions)
    robot.set_base(fire3dv.pose((5, 0, 0)))
    check(np.allclose(robot.node_pose("fore")[:, 3], [5 + math.cos(0.25), math.sin(0.25), 0]), robot.node_pose("fore"))
    raises(fire3dv.ArgumentError, "has no joint 'wrist'; it has 'shoulder', 'elbow'", lambda: robot.set(wrist=0))
    raises(fire3dv.ArgumentError, 'joint "finger" follows "shoulder"', lambda: robot.set(finger=0))
    raises(fire3dv.ArgumentError, "there are 3 positions; the robot has 2", lambda: robot.set([1, 2, 3]))
    raises(fire3dv.ArgumentError, '"elbow" is not finite', lambda: robot.set(shoulder=1, elbow=math.nan))
    check(robot.positions == [0.25, 0], "a refused position changed others")
    independent = fire3dv.Robot(path, mimic=False, program=program)
    check(independent.joint_names == ["shoulder", "elbow", "finger"], independent.joint_names)
    # The file of the converter is the same robot.
    converter = os.path.join(os.path.dirname(program), "fire3dv-convert")
    subprocess.run([converter, path, "-o", test.path("robot.glb")], check=True, capture_output=True)
    check(fire3dv.Robot(test.path("robot.glb")).joints == robot.joints, "other joints in the .glb")
    listed = subprocess.run([converter, path, "--joints"], check=True, capture_output=True, text=True).stdout
    check(listed.splitlines() == ["shoulder\trevolute\tupper\tfrom -1 to 1 rad", "elbow\trevolute\tfore",
                                  "finger\tprismatic\ttip\tfrom 0 to 1 m\tfollows shoulder times 0.5 plus 0"], listed)
    with open(test.path("rigid.urdf"), "w", encoding="utf-8") as file:
        file.write("<robot name='r'><link name='base'/></robot>")
    raises(fire3dv.ArgumentError, "rigid.urdf: it holds no joints",
           lambda: fire3dv.Robot(test.path("rigid.urdf"), program=program))
    raises(fire3dv.ArgumentError, "none.glb", lambda: fire3dv.Robot(test.path("none.glb")))
    # A renderer without a converter beside it.
    alone = test.path("fire3dv")
    os.symlink(program, alone)
    raises(fire3dv.RendererNotFound, "fire3dv-convert, which is not there", lambda: fire3dv.Robot(path, program=alone))


def picture(test):
    os.environ.update(vulkan_environment())
    path, program = write(test), test.programs_at["fire3dv"]
    with fire3dv.Renderer(path, program=program, start_timeout_s=HANG_S,
                          arguments=["--validation", "--cache", "off"]) as renderer:
        robot = fire3dv.Robot(path, program=program)
        # In the stream's frame, as the poses: Z up.
        above = fire3dv.look_at((0, 0, 6), (0, 0, 0), up=(0, 1, 0))
        with robot.publish(renderer) as r:
            def seen(**joints):
                """Middle of the forearm's pixels."""
                sequence = r.set(**joints)
                with r.stream.request_image(96, 96, fx=96, parent_from_camera=above, outputs=["instance"],
                                          sequence=sequence).wait(HANG_S) as image:
                    number = {name: number for number, name in image.names().items()}["fore"]
                    y, x = np.nonzero(image.instance == number)
                    return x.mean(), y.mean()
            for shoulder, elbow in ((0, 0), (math.pi / 2, 0), (0.5, -1.2)):
                both = shoulder + elbow
                at = np.array([math.cos(shoulder) + 0.5 * math.cos(both), math.sin(shoulder) + 0.5 * math.sin(both)])
                expected = 47.5 + 96 * at[0] / 5.9, 47.5 - 96 * at[1] / 5.9
                found = seen(shoulder=shoulder, elbow=elbow)
                check(np.abs(np.subtract(found, expected)).max() < 2, f"forearm at {found} instead of {expected}")
        check(not r.stream.is_open, "the stream is open after its with statement")
        with renderer.stream() as stream:
            with robot.publish(stream) as r:
                r.set([0, 0], sim_time_ns=7)
            check(stream.is_open, "the caller's stream was closed")


if __name__ == "__main__":
    main({"five_lines": five_lines, "positions": positions, "picture": picture}, ["fire3dv", "stream_dump"])
