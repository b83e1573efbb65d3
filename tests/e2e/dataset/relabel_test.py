#!/usr/bin/env python3
"""End-to-end test of `fire3dv relabel`: transforms and joint states as ROS 2 and Foxglove record them. The oracle is NumPy; the
files are made in Python."""
import os
import random
import sqlite3
import struct

import numpy as np

from harness import Program, check, main, vulkan_environment
from dataset_runs import lines_of, names_of
from label_readers import read_json
from label_scene import cube, write_bodies
from mcap_file import McapFile, body_of
from mcap_writer import McapWriter
from state_messages import (cdr_joint_state, cdr_transforms, json_transforms, json_value, protobuf_transform, protobuf_transforms)

T0 = 1_700_000_000_000_000_000
MS = 1_000_000
TF = "tf2_msgs/msg/TFMessage"
Z_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])  # scene from fixed frame


def quaternion(axis, angle):
    axis = np.array(axis, float) / np.linalg.norm(axis)
    return [*(np.sin(angle / 2) * axis), np.cos(angle / 2)]


def matrix(translation, rotation):
    x, y, z, w = rotation
    out = np.eye(4)
    out[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                   [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                   [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    out[:3, 3] = translation
    return out


#: Movements: pose of each frame in its parent at a time in seconds. Rotations have one axis, so that the spherical way between two
#: samples has the angle between theirs.
def odom(_):
    return [1, 2, 0.5], quaternion((0, 0, 1), 0.3)


def red(t):
    return [np.sin(t), 0.2 * t, 0], quaternion((0, 0, 1), 0.7 * t)


def green(t):
    return [0, 0, 1 + 0.1 * t], quaternion((1, 0, 0), -0.4 * t)


def blue(_):
    return [-1, 0, 1], quaternion((0, 1, 0), 0.5)


def between(movement, period_s, t, last_s):
    """Linear and spherical between the samples at multiples of the period."""
    index = min(int(t / period_s + 1e-9), round(last_s / period_s))
    a, b = index * period_s, min((index + 1) * period_s, last_s)
    share = 0 if b <= a else (t - a) / (b - a)
    (p, q), (r, s) = movement(a), movement(b)
    angle = np.arccos(np.clip(np.dot(q, s), -1, 1))
    way = q if angle < 1e-9 else (np.sin((1 - share) * angle) * np.array(q) + np.sin(share * angle) * np.array(s)) / np.sin(angle)
    return matrix((1 - share) * np.array(p) + share * np.array(r), way / np.linalg.norm(way))


RED_S, GREEN_S, LAST_S = 0.02, 0.05, 2.0


def samples():
    """Messages: (log time, topic, transforms), in order of log times. Green's stamps come late, as those of a slow publisher."""
    messages = [(T0 - 5 * MS, "/tf_static", [(T0 - 100 * MS, "map", "odom", *odom(0)), (T0, "map", "robot/blue", *blue(0))])]
    for i in range(round(LAST_S / RED_S) + 1):
        messages.append((T0 + 20 * i * MS + MS, "/tf", [(T0 + 20 * i * MS, "odom", "robot/red", *red(i * RED_S))]))
    for i in range(round(LAST_S / GREEN_S) + 1):
        messages.append((T0 + 50 * i * MS + 35 * MS, "/tf",
                         [(T0 + 50 * i * MS, "robot/red", "robot/green", *green(i * GREEN_S)), (T0 + 50 * i * MS, "odom", "camera", *blue(0))]))
    return sorted(messages, key=lambda each: each[0])


def scene_of(test):
    path = test.path("scene.glb")
    if not os.path.exists(path):
        write_bodies(path, [("red", cube((0, 0, 0), 10), [0.8, 0.1, 0.1], 1, {}), ("green", cube((0, 0, 0), 5), [0.1, 0.7, 0.1], 2, {}),
                            ("blue", cube((0, 0, 0), 1), [0.1, 0.2, 0.8], 3, {"translation": [0, 0, 0], "scale": [5, 10, 15], "rotation": [0, 0.6, 0, 0.8]}),
                            ("table", cube((0, 0, 0), 1), [0.5, 0.5, 0.5], 4, {"translation": [0, -250, 0], "scale": [50, 1, 50]})], scale=0.02)
    return path


def relabel(test, *arguments, code=0):
    program = Program(test, "relabel", [test.programs_at["fire3dv"], "relabel", *map(str, arguments), "--cache", "off"], vulkan_environment())
    program.expect_exit(code)
    return program.stderr_text()


def bag(test, name, messages, encode=cdr_transforms, schema=TF, encoding="cdr", chunked=False):
    writer = McapWriter()
    for log_ns, topic, transforms in messages:
        writer.write(topic, schema, encoding, log_ns, encode(transforms))
    return writer.save(test.path(name), chunked)


def sqlite_bag(test, name, messages):
    """As rosbag2 writes it; rows are not in the order of times."""
    path = test.path(name)
    with sqlite3.connect(path) as bag_file:
        bag_file.executescript("""
            CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
            CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
            CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
                                offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
            CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
            CREATE INDEX timestamp_idx ON messages (timestamp ASC);""")
        for number, topic in ((3, "/tf"), (7, "/tf_static"), (8, "/image")):
            kind = TF if topic != "/image" else "sensor_msgs/msg/Image"
            bag_file.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '', '')", (number, topic, kind))
        bag_file.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (8, ?, x'00')", (T0,))
        for log_ns, topic, transforms in reversed(messages):
            bag_file.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
                             (3 if topic == "/tf" else 7, log_ns, cdr_transforms(transforms)))
    bag_file.close()
    return path


def poses_of(path):
    """Names, world_from_stream, and (time, stream_from_body of each node) of each frame. float32 matrices."""
    file = McapFile(path)
    kind, description = body_of(file.of("control")[0][1])
    check(kind == 1, f"the first message is of kind {kind}")
    frames = []
    for _, message in file.of("poses"):
        kind, frame = body_of(message)
        if kind != 2:
            continue
        at = frame.follow(8)
        count = struct.unpack_from("<I", message, at)[0]
        numbers = np.frombuffer(message, "<f4", 12 * count, at + 4).reshape(count, 3, 4).astype(float)
        frames.append((frame.number(2, "q"), numbers))
    return strings(description, 4), description, frames


def strings(table, number):
    at = table.follow(number)
    values = []
    for i in range(struct.unpack_from("<I", table.data, at)[0]):
        place = at + 4 + 4 * i
        place += struct.unpack_from("<I", table.data, place)[0]
        length = struct.unpack_from("<I", table.data, place)[0]
        values.append(table.data[place + 4:place + 4 + length].decode())
    return values


def expect_poses(path):
    names, _, frames = poses_of(path)
    check(sorted(names) == ["blue", "green", "red"], f"{names}")
    times = sorted({20 * i for i in range(101)} | {50 * i for i in range(41)})
    check([(t - T0) // MS for t, _ in frames] == times, f"times: {[(t - T0) / MS for t, _ in frames][:20]}")
    worst = 0
    for time_ns, poses in frames:
        t = (time_ns - T0) * 1e-9
        map_from_red = matrix(*odom(0)) @ between(red, RED_S, t, LAST_S)
        wanted = {"red": map_from_red, "green": map_from_red @ between(green, GREEN_S, t, LAST_S), "blue": matrix(*blue(0))}
        for name, pose in zip(names, poses):
            worst = max(worst, np.abs(pose - wanted[name][:3]).max())
    check(worst < 1e-6, f"poses differ by {worst}")
    print(f"{len(frames)} frames, poses within {worst:.1e}")


def world_of(path):
    _, description, _ = poses_of(path)
    return np.reshape(struct.unpack_from("<12d", description.data, description._field(5)), (3, 4))


def up_is_chosen(test):
    states = bag(test, "up.mcap", samples()[:5])
    for up, wanted in (("z", Z_UP), ("y", np.eye(4))):
        relabel(test, states, scene_of(test), "--up", up, "--out", test.path(f"{up}.mcap"))
        check(np.array_equal(world_of(test.path(f"{up}.mcap")), wanted[:3]), f"--up {up}")
    said = relabel(test, states, scene_of(test), "--up", "x", "--out", test.path("x.mcap"), code=2)
    check("--up" in said, said)
    said = relabel(test, states, scene_of(test), "--fixed-frame", "base", "--out", test.path("x.mcap"), code=1)
    check('has no frame "base"' in said, said)


def ros2_transforms(test):
    recording = test.path("ros2.mcap")
    said = relabel(test, bag(test, "bag.mcap", samples()), scene_of(test), "--prefix", "robot/", "--out", recording)
    expect_poses(recording)
    check("info: 121 frames of 3 nodes" in said and 'frame "map" is the scene\'s origin, Z up' in said, said)
    check('warning: bag.mcap: 2 frames are no nodes of the scene: "odom", "camera"' in said, said)
    check('1 node without states stays where the scene has it: "table"' in said or "stays where the scene has it: table" in said, said)
    # The last part of a frame's path is the node's name.
    whole = test.path("whole.mcap")
    relabel(test, test.path("bag.mcap"), scene_of(test), "--out", whole)
    check(open(whole, "rb").read() == open(recording, "rb").read(), "another recording without --prefix")
    said = relabel(test, test.path("bag.mcap"), scene_of(test), "--out", whole, code=1)
    check("exists: remove it" in said, said)


def encodings_agree(test):
    """Either byte order, both encodings of Foxglove, single messages, chunks, and parts in a folder: the same bytes."""
    relabel(test, bag(test, "little.mcap", samples()), scene_of(test), "--out", test.path("wanted.mcap"))
    wanted = open(test.path("wanted.mcap"), "rb").read()
    messages = samples()
    one_each = [(log_ns, topic, each) for log_ns, topic, transforms in messages for each in transforms]
    folder = test.path("bag")
    os.mkdir(folder)
    for part in range(12):
        bag(test, f"bag/bag_{part}.mcap", messages[part * len(messages) // 12:(part + 1) * len(messages) // 12])
    sqlite_folder = test.path("sqlite bag")
    os.mkdir(sqlite_folder)
    for part, some in enumerate((messages[:50], messages[50:])):
        sqlite_bag(test, f"sqlite bag/bag_{part}.db3", some)
    files = {
        "big": bag(test, "big.mcap", messages, lambda each: cdr_transforms(each, ">"), chunked=True),
        "protobuf": bag(test, "protobuf.mcap", messages, protobuf_transforms, "foxglove.FrameTransforms", "protobuf"),
        "json": bag(test, "json.mcap", messages, json_transforms, "foxglove.FrameTransforms", "json", chunked=True),
        "protobuf one": bag(test, "protobuf1.mcap", one_each, protobuf_transform, "foxglove.FrameTransform", "protobuf"),
        "json one": bag(test, "json1.mcap", one_each, lambda each: repr(json_value(each)).replace("'", '"').encode(),
                        "foxglove.FrameTransform", "json"),
        "folder": folder, "sqlite": sqlite_bag(test, "bag.db3", messages), "sqlite folder": sqlite_folder}
    for name, states in files.items():
        out = test.path(f"{name} out.mcap")
        relabel(test, states, scene_of(test), "--out", out)
        check(open(out, "rb").read() == wanted, f"{name} gives another recording")


URDF = """<robot name="arm">
  <link name="base"><visual><geometry><box size="0.2 0.2 0.1"/></geometry></visual></link>
  <link name="upper"><visual><origin xyz="0 0 0.25"/><geometry><box size="0.1 0.1 0.5"/></geometry></visual></link>
  <link name="finger"><visual><geometry><box size="0.05 0.05 0.1"/></geometry></visual></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1" rpy="0 0 0.5"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="upper"/><child link="finger"/><origin xyz="0 0 0.5"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <link name="tip"><visual><geometry><box size="0.02 0.02 0.02"/></geometry></visual></link>
  <joint name="mount" type="fixed"><parent link="finger"/><child link="tip"/><origin xyz="0 0 0.2"/></joint>
</robot>
"""


def joint_states(test):
    robot = test.path("arm.urdf")
    with open(robot, "w", encoding="utf-8") as file:
        file.write(URDF)
    def joints(i):
        return {"shoulder": 0.02 * i, "slide": 0.5 - 0.01 * i, "gripper": 1}
    # Alone, and on a base that /tf moves.
    for name, moves_base in (("fixed", False), ("mobile", True)):
        writer = McapWriter()
        # What robot_state_publisher says of fixed joints.
        writer.write("/tf_static", TF, "cdr", T0, cdr_transforms([(T0, "finger", "/tip", [0, 0, 0.2], [0, 0, 0, 1])]))
        for i in range(50):
            stamp = T0 + 10 * i * MS
            if moves_base:
                writer.write("/tf", TF, "cdr", stamp, cdr_transforms([(stamp, "odom", "base", *red(0.01 * i))]))
            writer.write("/joint_states", "sensor_msgs/msg/JointState", "cdr", stamp, cdr_joint_state(stamp, joints(i), "<" if i % 2 else ">"))
        out = test.path(f"{name}.mcap")
        said = relabel(test, writer.save(test.path(f"{name} bag.mcap")), robot, "--out", out)
        check('no such joint, or one that follows another: "gripper"' in said, said)
        names, _, frames = poses_of(out)
        check(sorted(names) == ["base", "finger", "tip", "upper"] and len(frames) == 50, f"{names}, {len(frames)} frames")
        worst = 0
        for i, (time_ns, poses) in enumerate(frames):
            check(time_ns == T0 + 10 * i * MS, f"{time_ns}")
            base = matrix(*red(0.01 * i)) if moves_base else np.eye(4)
            upper = base @ matrix([0, 0, 0.1], quaternion((0, 0, 1), 0.5)) @ matrix([0, 0, 0], quaternion((0, 1, 0), 0.02 * i))
            wanted = {"base": base, "upper": upper, "finger": upper @ matrix([0.5 - 0.01 * i, 0, 0.5], [0, 0, 0, 1])}
            wanted["tip"] = wanted["finger"] @ matrix([0, 0, 0.2], [0, 0, 0, 1])
            for node, pose in zip(names, poses):
                worst = max(worst, np.abs(pose - wanted[node][:3]).max())
        check(worst < 1e-6, f"{name}: poses differ by {worst}")
    # Degrees are suspected, and read by choice.
    with open(robot, "w", encoding="utf-8") as file:
        file.write(URDF.replace('"prismatic"', '"revolute"'))
    recorded = {}
    for unit, factor, extra in (("rad", 1, ()), ("deg", 180 / np.pi, ("--joint-unit", "deg")), ("wrong", 180 / np.pi, ())):
        writer = McapWriter()
        for i in range(50):
            states = {"shoulder": 0.02 * i * factor, "slide": (0.5 - 0.01 * i) * factor}
            writer.write("/joint_states", "sensor_msgs/msg/JointState", "cdr", T0 + i * MS, cdr_joint_state(T0 + i * MS, states, "<"))
        out = test.path(f"{unit}.mcap")
        said = relabel(test, writer.save(test.path(f"{unit} bag.mcap")), robot, "--out", out, *extra)
        check(("joint positions reach 56.15, " in said and "set --joint-unit deg" in said) == (unit == "wrong"), f"{unit}: {said}")
        recorded[unit] = poses_of(out)[2]
    worst = max(np.abs(a - b).max() for (_, left), (_, right) in zip(recorded["rad"], recorded["deg"]) for a, b in zip(left, right))
    check(worst < 1e-6, f"degrees: poses differ by {worst}")
    said = relabel(test, test.path("fixed bag.mcap"), scene_of(test), "--out", test.path("none.mcap"), code=1)
    check("name the robot's URDF file as the scene" in said and not os.path.exists(test.path("none.mcap")), said)


def labelled(label, kind):
    """Matrix of a label, in metres."""
    pose = np.eye(4)
    pose[:3, :3] = np.reshape(label[f"cam_R_{kind}"], (3, 3))
    pose[:3, 3] = np.array(label[f"cam_t_{kind}"]) / 1000
    return pose


def draws_a_data_set(test):
    """Poses in the labels are those of the transforms, the scale of a node stays, and a run continues."""
    states, out = bag(test, "drawn.mcap", samples()[:40]), test.path("set")
    arguments = (states, scene_of(test), "--format", "coco", "--out", out, "--camera", "front", "--size", "160x90", "--shadows", "off")
    relabel(test, *arguments)
    document = read_json(os.path.join(out, "dataset.json"))
    check(document["command"].startswith("fire3dv relabel drawn.mcap scene.glb --format coco"), document["command"])
    nodes, _, frames = poses_of(test.path("set.mcap"))
    lines, names = lines_of(out), names_of(out)
    check(len(lines) == len(frames) > 20, f"{len(lines)} images of {len(frames)} frames")
    seen, worst = set(), 0
    for line, (_, poses) in zip(lines, frames):
        wanted = {node: np.vstack((pose, [0, 0, 0, 1])) for node, pose in zip(nodes, poses)}
        camera_from_world = labelled(line, "w2c")
        for label in line["instances"]:
            name = names[label["instance"]]
            if name in wanted:
                seen.add(name)
                worst = max(worst, np.abs(labelled(label, "m2c") - camera_from_world @ Z_UP @ wanted[name]).max())
    check(seen == set(nodes) and worst < 2e-6, f"poses of {seen} differ by {worst}")
    first = read_json(os.path.join(out, "annotations.json"))
    said = relabel(test, *arguments)
    check("all images are there already" in said, said)
    bag(test, "drawn.mcap", samples()[:30])
    said = relabel(test, *arguments, code=1)
    check("is of other states" in said, said)
    # A run that continues leaves all other files alone.
    bag(test, "drawn.mcap", samples()[:40])
    with open(test.path("set.mcap.again"), "w", encoding="utf-8") as file:
        file.write("notes")
    before = sorted(os.listdir(test.path("")))
    relabel(test, *arguments)
    check(sorted(os.listdir(test.path(""))) == before, "other files than before")
    # The states never get the name of what is written.
    for name in ("drawn", "drawn.mcap"):
        said = relabel(test, states, scene_of(test), *(() if name == "drawn.mcap" else ("--format", "coco")), "--out", test.path(name), code=1)
        check("would write to it: choose another" in said and "remove" not in said and os.path.exists(states), said)
    # The camera that frames the scene frames its motion, and not its rest.
    framed, rest = test.path("framed"), test.path("framed at rest")
    short = ("--format", "coco", "--camera", "auto", "--rate", 10, *arguments[8:])
    relabel(test, *arguments[:2], "--out", framed, *short)
    cut = [line["frame"] for line in lines_of(framed) for each in line["instances"] if each["truncated"] and names[each["instance"]] in nodes]
    check(not cut and len(lines_of(framed)) > 3, f"bodies are cut in {cut}")
    program = Program(test, "dataset", [test.programs_at["fire3dv"], "dataset", framed + ".mcap", scene_of(test), "--out", rest, *map(str, short), "--cache", "off"],
                      vulkan_environment())
    program.expect_exit(0)
    check(lines_of(rest)[0]["cam_t_w2c"] != lines_of(framed)[0]["cam_t_w2c"], "the view of the scene at rest")
    # A mistyped name is found before the states are read, and leaves nothing in the way.
    bad = test.path("mistyped")
    for extra, reason in ((("--camera", "fornt"), 'did you mean "front"?'), (("--object", "rad"), 'did you mean "red"?')):
        said = relabel(test, states, scene_of(test), "--format", "coco", "--out", bad, *extra, code=1)
        check(reason in said and not os.path.exists(bad) and not os.path.exists(bad + ".mcap"), said)
    said = relabel(test, states, scene_of(test), "--format", "coco", "--out", test.path("x.mcap"), code=2)
    check("--format is for a data set" in said and "names a recording alone" in said, said)
    said = relabel(test, scene_of(test), states, "--format", "coco", "--out", bad, code=2)
    check(f"the recording comes first, then the scene: fire3dv relabel {states} {scene_of(test)}" in said, said)
    # Our own recordings need no import.
    again = test.path("again")
    relabel(test, test.path("set.mcap"), scene_of(test), "--format", "coco", "--out", again, *arguments[6:])
    check(read_json(os.path.join(again, "annotations.json"))["annotations"] == first["annotations"], "other labels")


def faults_are_named(test):
    good = [(T0 + i * 10 * MS, "/tf", [(T0 + i * 10 * MS, "map", "red", *red(0.01 * i))]) for i in range(20)]
    one = [0, 0, 0, 1]
    bad = {
        "NaN": ([(T0 + MS, "/tf", [(T0 + MS, "map", "green", [float("nan"), 0, 0], one)])], "a number is NaN, infinite or beyond 1e9"),
        "length": ([(T0 + MS, "/tf", [(T0 + MS, "map", "green", [0, 0, 0], [0, 0, 0, 2])])], "its quaternion has not length 1"),
        "own": ([(T0 + MS, "/tf", [(T0 + MS, "green", "green", [0, 0, 0], one)])], "the frame is its own parent"),
        "name": ([(T0 + MS, "/tf", [(T0 + MS, "map", "", [0, 0, 0], one)])], "a frame name is empty"),
        "back": ([(T0 + 500 * MS, "/tf", [(T0 - 20_000 * MS, "map", "red", [0, 0, 0], one)])], "more than 10 s older than the newest"),
        "old": ([(T0 + MS, "/tf", [(-5 * 10**9, "map", "green", [0, 0, 0], one)])], "before 1970"),
        "apart": ([(T0 + MS, "/tf", [(T0 + MS, "elsewhere", "green", [0, 0, 0], one)])], 'not connected to "map" are left out: "green"')}
    for name, (messages, reason) in bad.items():
        said = relabel(test, bag(test, f"{name}.mcap", sorted(good + messages, key=lambda each: each[0])), scene_of(test), "--out",
                       test.path(f"{name} out.mcap"))
        check(f"warning: {name}.mcap: " in said and reason in said, f"{name}: {said}")
        if name not in ("apart", "old"):
            check("of topic \"/tf\" is left out" in said and "(message " in said, said)
        check(len(poses_of(test.path(f"{name} out.mcap"))[2]) == 20, f"{name}: other frames")
    loop = good + [(T0 + MS, "/tf", [(T0 + MS, "blue", "green", [0, 0, 0], one), (T0 + MS, "green", "blue", [0, 0, 0], one)])]
    said = relabel(test, bag(test, "loop.mcap", loop), scene_of(test), "--out", test.path("no.mcap"), code=1)
    check("lead back to itself" in said and 'topic "/tf", message ' in said, said)
    for messages, reason in ([(T0, "/tf", [(T0, "map", "nobody", [0, 0, 0], one)])], "no frame has the name of a node of the scene: \"nobody\""), ([], "has no transforms and no joint states"):
        said = relabel(test, bag(test, "unused.mcap", messages), scene_of(test), "--out", test.path("no.mcap"), code=1)
        check(reason in said, said)
    said = relabel(test, bag(test, "ros1.mcap", good, encoding="ros1"), scene_of(test), "--out", test.path("no.mcap"), code=1)
    check('topic "/tf"' in said and "cannot be read" in said, said)
    with sqlite3.connect(test.path("other.db3")) as other:
        other.execute("CREATE TABLE topics(id INTEGER)")
        other.execute("CREATE VIEW messages AS SELECT * FROM topics")
    other.close()
    said = relabel(test, test.path("other.db3"), scene_of(test), "--out", test.path("no.mcap"), code=1)
    check("is no bag of ROS 2" in said, said)
    for name, columns, reason in (("computed", "data BLOB AS (x'00')", 'column "data" of table messages is computed'),
                                  ("huge", "data BLOB DEFAULT '" + "x" * (2 << 20) + "'", "too big")):
        with sqlite3.connect(test.path(f"{name}.db3")) as other:
            other.execute("CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, serialization_format TEXT)")
            other.execute(f"CREATE TABLE messages(id INTEGER, topic_id INTEGER, timestamp INTEGER, {columns})")
        other.close()
        said = relabel(test, test.path(f"{name}.db3"), scene_of(test), "--out", test.path("no.mcap"), code=1)
        check(reason in said, f"{name}: {said}")
    said = relabel(test, test.path("missing.mcap"), scene_of(test), "--out", test.path("no.mcap"), code=1)
    check("missing.mcap" in said, said)
    check(not os.path.exists(test.path("no.mcap")), "a file of a failed import")
    said = relabel(test, test.path("NaN.mcap"), "--out", test.path("no.mcap"), code=2)
    check("name the scene after the states" in said, said)


def hostile_files_end(test):
    """Flipped and missing bytes: a recording or a reason, never a crash."""
    sound = [open(file, "rb").read() for file in (bag(test, "sound.mcap", samples()[:60]), sqlite_bag(test, "sound.db3", samples()[:60]))]
    chance = random.Random(7)
    for i in range(24):
        data = sound[i % 2]
        damaged = bytearray(data[:chance.randrange(len(data))] if i % 3 == 0 else data)
        for _ in range(chance.randrange(1, 30)):
            damaged[chance.randrange(min(100, len(damaged) - 1), len(damaged))] = chance.randrange(256)
        with open(test.path("damaged.mcap"), "wb") as file:
            file.write(damaged)
        out = test.path(f"{i} out.mcap")
        program = Program(test, "relabel", [test.programs_at["fire3dv"], "relabel", test.path("damaged.mcap"), scene_of(test), "--out", out,
                                            "--cache", "off"], vulkan_environment())
        code = program.wait()
        check(code in (0, 1) and (code == 0) == os.path.exists(out), f"exit status {code}: {program.stderr_text()}")
        if code == 1:
            check("error: " in program.stderr_text(), program.stderr_text())


if __name__ == "__main__":
    main({"ros2": ros2_transforms, "up": up_is_chosen, "encodings": encodings_agree, "joints": joint_states, "dataset": draws_a_data_set,
          "faults": faults_are_named, "hostile": hostile_files_end}, ("fire3dv",))
