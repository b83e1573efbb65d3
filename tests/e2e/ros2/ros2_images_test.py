"""End-to-end test of images in the ROS 2 graph: fire3dv-ros2 and a renderer, read by Fast DDS (raw bytes, decoded here)
and by Cyclone DDS. A bar code in the scene proves that each image shows the frame of its stamp.

ros2_images_test.py FIRE3DV FIRE3DV_ROS2 PEER FASTDDS_READER [CASE...]; FIRE3DV_CLIENT_LIBRARY and PYTHONPATH lead to
the Python package. FASTDDS_READER may be "none".
"""
import json
import math
import os
import signal
import time

import numpy

import barcode
import cdr
import fire3dv
from harness import HANG_S, Program, main, vulkan_environment, wait_until
from image_reader import check

STEP_NS = 10_000_000
# The scene's world is Y up, ROS is Z up: ros = (x, -z, y). Bars keep their orientation in the world.
BAR_ROTATION = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
FX = 4 * barcode.DISTANCE  # a bar is four pixels wide
CAMERA = (f"front:=/cam/front,parent=map,xyz=0 {-barcode.DISTANCE} 0,rpy=0 0 {math.pi / 2},"
          f"size={barcode.SIZE[0]}x{barcode.SIZE[1]},fx={FX},near=1,far=100")
TYPES = {"image": ("sensor_msgs::msg::dds_::Image_", cdr.image),
         "compressed": ("sensor_msgs::msg::dds_::CompressedImage_", cdr.compressed_image),
         "info": ("sensor_msgs::msg::dds_::CameraInfo_", cdr.camera_info),
         "tf_static": ("tf2_msgs::msg::dds_::TFMessage_", cdr.tf_message)}
DOMAIN = 1 + os.getpid() % 100


def ros_environment():
    env = {name: value for name, value in os.environ.items() if not name.startswith(("ROS_", "CYCLONEDDS_", "FASTRTPS_"))}
    return {**env, "ROS_DOMAIN_ID": str(DOMAIN)}


class Reader(Program):
    """Reader of one topic; messages() decodes what has arrived."""

    count = 0

    def __init__(self, test, library, topic, kind, quality):
        Reader.count += 1
        self.kind, self.library = kind, library
        self.folder = test.path(f"reader{Reader.count}")
        os.mkdir(self.folder)
        if library == "fastdds":
            durability = "transient_local" if kind == "tf_static" else "volatile"
            command = [test.programs_at["fastdds_reader"], str(DOMAIN), "rt" + topic, TYPES[kind][0], quality, durability,
                       self.folder]
        else:
            command = [test.programs_at["peer"], "read", topic, kind, quality, self.folder]
        super().__init__(test, f"{library} reader of {topic}", command, ros_environment())

    def wait_matched(self):
        wait_until(f"{self.name} to find a writer", lambda: any("matched" in line for line in self.out))
        return self

    def messages(self):
        lines = [line for line in list(self.out) if "matched" not in line]
        if self.library == "cyclone":
            messages = [json.loads(line) for line in lines]
            for message in messages:
                if "data" in message:
                    with open(message["data"], "rb") as file:
                        message["data"] = file.read()
            return messages
        messages = []
        for line in lines:
            with open(os.path.join(self.folder, line.split()[0] + ".cdr"), "rb") as file:
                data = file.read()
            check(len(data) == int(line.split()[1]), f"{self.name}: {line}")
            decoded = TYPES[self.kind][1](data)
            messages += decoded if isinstance(decoded, list) else [decoded]
        return messages

    def wait_stamp(self, stamp_ns):
        """Waits for the message of this stamp and returns all messages."""
        def look():
            check(self.alive(), f"{self.name} ended:\n{self.stderr_text()}")
            messages = self.messages()
            return messages if messages and messages[-1].get("stamp_ns") == stamp_ns else None
        return wait_until(lambda: f"{self.name} to read {stamp_ns}; it read {len(self.out)} lines\n", look)


class System:
    """Renderer, fire3dv-ros2 and the publisher of transforms."""

    def __init__(self, test, *options, scene=None, arguments=()):
        self.uri, self.witness_uri = test.fresh_uri("shm"), test.fresh_uri("shm")
        if scene is None:
            scene = test.path("barcode.glb")
            barcode.write_scene(scene)
        self.test, self.command = test, [
            test.programs_at["fire3dv"], scene, "--validation", "--headless", "--tone-map", "none", "--cache", "off",
            "--ground", "off", "--background", "000000", "--size", "64x48", "--on-request", "--listen", self.uri, "--listen", self.witness_uri, *arguments]
        self.start_renderer()
        self.bridge = Program(test, "fire3dv-ros2", [test.programs_at["fire3dv-ros2"], "--to", self.uri, *options],
                              ros_environment())
        self.peer = Program(test, "publisher", [test.programs_at["peer"], "publish"], ros_environment())

    def start_renderer(self):
        self.renderer = Program(self.test, "fire3dv", self.command, vulkan_environment())
        self.renderer.wait_err("listening on")

    def say(self, *lines):
        check(self.peer.alive(), f"the publisher ended:\n{self.peer.stderr_text()}")
        self.peer.process.stdin.write("\n".join(lines) + "\n")
        self.peer.process.stdin.flush()

    def wait_readers(self):
        def look():
            check(self.bridge.alive(), f"fire3dv-ros2 ended:\n{self.bridge.stderr_text()}")
            self.say("readers")
            return any(line.startswith("readers ") and "0" not in line.split()[1:3] for line in list(self.peer.out))
        wait_until("fire3dv-ros2 to read /tf", look)

    def show(self, number):
        """Publishes the bars of this number, all at one stamp, which is returned."""
        stamp = number * STEP_NS
        bars = [f'tf {stamp} "map" "{name}" {pose[3]} {-pose[11]} {pose[7]} {" ".join(map(repr, BAR_ROTATION))}'
                for name, pose in zip(barcode.NAMES, barcode.poses_of(number))]
        self.say(*bars, "send")
        return stamp

    def show_until(self, reader, first):
        """Shows numbers until the reader gets images: discovery and the first description take time."""
        number = first
        while not reader.messages():
            check(number < first + 20 * HANG_S, f"{reader.name} reads nothing:\n{self.bridge.stderr_text()}")
            self.show(number)
            number += 1
            time.sleep(0.05)
        return number

    def end(self):
        self.peer.kill()
        self.bridge.signal(signal.SIGTERM)
        self.bridge.expect_exit(0)
        self.renderer.signal(signal.SIGTERM)
        self.renderer.expect_exit(0)


def pixels(message, channels, kind):
    check(message["step"] == message["width"] * channels * numpy.dtype(kind).itemsize, f"rows have gaps: {message['step']}")
    check(message["is_bigendian"] == 0, "big endian")
    array = numpy.frombuffer(message["data"], kind)
    shape = (message["height"], message["width"]) + ((channels,) if channels > 1 else ())
    check(array.size == math.prod(shape), f"{array.size} values are not {shape}")
    return array.reshape(shape)


def check_color(message):
    """The image shows the frame of its stamp."""
    check(message["encoding"] == "rgb8" and message["frame_id"] == "front_optical_frame", f"{message['encoding']}, "
          f"{message['frame_id']}")
    shown = barcode.number_of(pixels(message, 3, numpy.uint8))
    check(shown is not None and shown * STEP_NS == message["stamp_ns"],
          f"an image of stamp {message['stamp_ns']} shows {shown}")


def readers(test):
    return ["cyclone"] + ([] if test.programs_at["fastdds_reader"] == "none" else ["fastdds"])


def client_image(system, outputs):
    """The same view through the client library: the camera's pose in the world is that of the options."""
    with fire3dv.Stream(system.witness_uri, adapter_name="witness") as stream:
        stream.describe([])
        request = stream.request_image(*barcode.SIZE, fx=FX, near_m=1, far_m=100, outputs=outputs,
                                       parent_from_camera=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, barcode.DISTANCE])
        image = request.wait(HANG_S)
        return {output: numpy.array(image[output]) for output in outputs}


def stamps(test):
    """Each image shows the transforms of its stamp, for reliable and best-effort readers of both libraries."""
    system = System(test, "--no-description", "--camera", CAMERA)
    colors = [Reader(test, library, "/cam/front/image_raw", "image", quality).wait_matched()
              for library in readers(test) for quality in ("reliable", "best_effort")]
    infos = [Reader(test, library, "/cam/front/camera_info", "info", "best_effort").wait_matched() for library in readers(test)]
    frames = [Reader(test, library, "/tf_static", "tf_static", "reliable").wait_matched() for library in readers(test)]
    system.wait_readers()
    number = system.show_until(colors[0], 100)
    for number in range(number, number + 40):
        last = system.show(number)
        time.sleep(0.02)
    for reader in colors:
        messages = reader.wait_stamp(last)
        for message in messages:
            check_color(message)
        check(len(messages) >= 5, f"{reader.name} got {len(messages)} images")
        got = [message["stamp_ns"] for message in messages]
        # A frame that is sent again, for a renderer that has joined or with other nodes, is drawn again.
        check(got == sorted(got) and len(set(got)) > len(got) / 2, f"{reader.name}: stamps {got}")
    newest = pixels(colors[0].messages()[-1], 3, numpy.uint8)
    own = client_image(system, ["color_srgb8"])["color_srgb8"]
    check((newest == own[:, :, :3]).all(), "the image differs from that of the client library")
    for reader in infos:
        info = reader.wait_stamp(last)[-1]
        w, h = barcode.SIZE
        check(info["frame_id"] == "front_optical_frame" and (info["width"], info["height"]) == (w, h), f"{info}")
        cx, cy = (w - 1) / 2, (h - 1) / 2
        check(info["k"] == [FX, 0, cx, 0, FX, cy, 0, 0, 1] and info["r"] == [1, 0, 0, 0, 1, 0, 0, 0, 1], f"{info}")
        check(info["p"] == [FX, 0, cx, 0, 0, FX, cy, 0, 0, 0, 1, 0] and info["d"] == [0] * 5, f"{info}")
        check(info["distortion_model"] == "plumb_bob", f"{info}")
    for reader in frames:
        wait_until(f"{reader.name} to read the optical frame", reader.messages)
        [frame] = reader.messages()
        check((frame["frame_id"], frame["child_frame_id"]) == ("map", "front_optical_frame"), f"{frame}")
        # Looks along +Y of map: x of the optical frame is X, y is -Z, z is Y.
        expected = [0, -barcode.DISTANCE, 0, -math.sqrt(0.5), 0, 0, math.sqrt(0.5)]
        check(max(abs(a - b) for a, b in zip(frame["transform"], expected)) < 1e-9, f"{frame}")
    system.end()
    check(system.bridge.find_err(r'camera "front": \d+ images published'), "no counts at the end")


def planes(test):
    """Depth, labels and JPEG equal what the client library gets."""
    system = System(test, "--no-description", "--camera", CAMERA, "--depth", "--labels", "instance", "--compressed")
    library = readers(test)[-1]
    depth = Reader(test, library, "/cam/front/depth/image_raw", "image", "reliable").wait_matched()
    labels = Reader(test, library, "/cam/front/labels", "image", "reliable").wait_matched()
    jpeg = Reader(test, library, "/cam/front/image_raw/compressed", "compressed", "reliable").wait_matched()
    info = Reader(test, library, "/cam/front/depth/camera_info", "info", "best_effort").wait_matched()
    system.wait_readers()
    last = system.show(system.show_until(depth, 300))
    depth_image, label_image, file = (reader.wait_stamp(last)[-1] for reader in (depth, labels, jpeg))
    info.wait_stamp(last)
    own = client_image(system, ["color_srgb8", "depth_f32", "instance_u32"])
    check(depth_image["encoding"] == "32FC1" and label_image["encoding"] == "32SC1", "encodings")
    metres = pixels(depth_image, 1, numpy.float32)
    check((metres == own["depth_f32"].reshape(metres.shape)).all(), "depth differs from that of the client library")
    seen = metres[numpy.isfinite(metres)]
    check(seen.size > 0 and numpy.abs(seen - barcode.DISTANCE).max() < 1e-3 and seen.size < metres.size,
          f"bars at {seen.min()} to {seen.max()} m")
    ids = pixels(label_image, 1, numpy.int32)
    check((ids == own["instance_u32"].reshape(ids.shape)).all(), "labels differ from those of the client library")
    check(set(numpy.unique(ids)) > {0} and (ids > 0).tolist() == numpy.isfinite(metres).tolist(), "labels and depth disagree")
    check(file["format"] == "rgb8; jpeg compressed bgr8" and file["data"][:3] == b"\xff\xd8\xff", f"{file['format']}")
    system.end()


def demand(test):
    """Nobody reads: nothing is requested. Who reads camera_info only gets it. Readers may come and go."""
    system = System(test, "--no-description", "--camera", CAMERA, "--image-rate", "200")
    system.wait_readers()
    for number in range(1, 31):
        system.show(number)
        time.sleep(0.02)
    info = Reader(test, "cyclone", "/cam/front/camera_info", "info", "best_effort").wait_matched()
    number = system.show_until(info, 100)
    check(all(message["stamp_ns"] > 30 * STEP_NS for message in info.messages()[1:]), "old stamps")
    info.kill()
    color = Reader(test, "cyclone", "/cam/front/image_raw", "image", "reliable").wait_matched()
    number = system.show_until(color, number)
    for message in color.wait_stamp(system.show(number)):
        check_color(message)
    system.end()
    color.kill()
    quiet = System(test, "--no-description", "--camera", CAMERA)
    quiet.wait_readers()
    for number in range(1, 51):
        quiet.show(number)
        time.sleep(0.02)
    quiet.end()
    check(not quiet.bridge.find_err("images published"), "images were made for nobody")


def stopped(test):
    """A reader that stops holds neither other readers nor the poses up. A killed renderer's successor goes on."""
    system = System(test, "--no-description", "--camera", CAMERA)
    halted = Reader(test, readers(test)[-1], "/cam/front/image_raw", "image", "reliable").wait_matched()
    color = Reader(test, "cyclone", "/cam/front/image_raw", "image", "reliable").wait_matched()
    system.wait_readers()
    number = system.show_until(halted, 100)
    halted.signal(signal.SIGSTOP)
    for number in range(number, number + 100):
        last = system.show(number)
        time.sleep(0.01)
    for message in color.wait_stamp(last):
        check_color(message)
    halted.signal(signal.SIGCONT)
    halted.wait_stamp(last)
    system.renderer.kill()
    system.start_renderer()
    had = len(color.messages())

    def goes_on():
        nonlocal number
        number += 1
        system.show(number)
        time.sleep(0.02)
        return len(color.messages()) > had
    wait_until("images of the second renderer", goes_on)
    for message in color.wait_stamp(system.show(number + 1)):
        check_color(message)
    system.end()


ROBOT = """<robot name="r">
  <link name="map"/><link name="arm"><visual><origin xyz="2 0 0"/><geometry><box size="0.2 1 1"/></geometry>
    <material name="red"><color rgba="1 0 0 1"/></material></visual></link>
  <link name="eye"/>
  <joint name="turn" type="revolute"><parent link="map"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="mount" type="fixed"><parent link="arm"/><child link="eye"/><origin xyz="0 0 0"/></joint>
  <gazebo reference="eye"><sensor name="head" type="depth_camera"><topic>/head/image_raw</topic><camera>
    <horizontal_fov>1.2</horizontal_fov><image><width>64</width><height>48</height></image>
    <clip><near>0.1</near><far>10</far></clip></camera></sensor></gazebo>
</robot>
"""


def robot(test):
    """A camera of the robot description rides on its link, in a scene that is the robot."""
    ride(test, test.path("robot.urdf"))


def added_robot(test):
    """The same, in a scene to which the robot is added."""
    ride(test, None)


def ride(test, scene):
    with open(test.path("robot.urdf"), "w", encoding="utf-8") as file:
        file.write(ROBOT)
    system = System(test, "--sensors", scene=scene)
    system.wait_readers()
    system.say(f"description {test.path('robot.urdf')}")
    system.bridge.wait_err('camera "head" of "eye" on topic /head')
    depth = Reader(test, "cyclone", "/head/depth/image_raw", "image", "reliable").wait_matched()
    frames = Reader(test, readers(test)[-1], "/tf_static", "tf_static", "reliable").wait_matched()

    def at(angle, number):
        stamp = number * STEP_NS
        system.say(f"tf {stamp} map arm 0 0 0 0 0 {math.sin(angle / 2)} {math.cos(angle / 2)}", "send")
        return stamp
    system.say("tf 0 arm eye 0 0 0 0 0 0 1", "send_static")
    number = 100

    def front():
        """The box stands 2 m ahead of the camera wherever the arm points: 1.9 m to its face, in the middle."""
        nonlocal number
        number += 1
        last = at(0.01 * number, number)
        time.sleep(0.05)
        messages = [m for m in depth.messages() if m["stamp_ns"] <= last]
        if not messages:
            return False
        metres = pixels(messages[-1], 1, numpy.float32)
        return abs(metres[24, 32] - 1.9) < 1e-3 and not numpy.isfinite(metres[0, 0])
    wait_until(lambda: f"the box ahead; fire3dv-ros2 says\n{system.bridge.stderr_text()}", front)
    last = at(1.0, number + 1)
    message = depth.wait_stamp(last)[-1]
    metres = pixels(message, 1, numpy.float32)
    check(message["frame_id"] == "head_optical_frame" and abs(metres[24, 32] - 1.9) < 1e-3, "the box is not ahead")
    wait_until("the optical frame", lambda: [f for f in frames.messages() if f["child_frame_id"] == "head_optical_frame"])
    frame = next(f for f in frames.messages() if f["child_frame_id"] == "head_optical_frame")
    check(frame["frame_id"] == "eye" and numpy.allclose(frame["transform"], [0, 0, 0, -.5, .5, -.5, .5]), f"{frame}")
    system.end()


if __name__ == "__main__":
    main({"stamps": stamps, "planes": planes, "demand": demand, "stopped": stopped, "robot": robot,
          "added_robot": added_robot},
         ["fire3dv", "fire3dv-ros2", "peer", "fastdds_reader"])
