#!/usr/bin/env python3
"""End-to-end test of fire3dv-gazebo against Debian 12's Gazebo Transport: both type prefixes, entities that come and go,
resets, restarts in any order, other partitions, hostile messages, and camera images that go back.

Each test has a partition of its own and stays on the loopback interface, so that tests run side by side.
"""
import json
import math
import os
import re
import signal
import socket
import struct
import sys
import time

from harness import Program, main, vulkan_environment, wait_until
from hosts import SKIPPED, Host, cable, why_not
from image_reader import check

PROGRAMS = ["fire3dv", "fire3dv-gazebo", "e2e_gazebo_peer", "stream_dump"]
SECOND = 1_000_000_000


def environment(host=None):
    env = {key: value for key, value in vulkan_environment().items() if not key.startswith(("GZ_", "IGN_"))}
    return env if host else {**env, "GZ_IP": "127.0.0.1", "IGN_IP": "127.0.0.1"}


def partition(test):
    return os.path.basename(test.folder)


class Peer(Program):
    def __init__(self, test, prefix="gz", world="demo", of=None, host=None, more=None):
        super().__init__(test, f"gazebo_peer {world}",
                         [test.programs_at["e2e_gazebo_peer"], prefix, world, of or partition(test)],
                         env={**environment(host), **(more or {})}, host=host)
        self.answers = 0

    def do(self, *lines):
        for line in lines:
            self.process.stdin.write(line + "\n")
            self.process.stdin.flush()
            self.answers += 1
            wait_until(f"the peer to answer {line!r}", lambda: self.out.count("ok") >= self.answers)


def adapter(test, *arguments, of=None, host=None, more=None):
    return Program(test, "fire3dv-gazebo",
                   [test.programs_at["fire3dv-gazebo"], "--partition", of or partition(test), *arguments],
                   env={**environment(host), **(more or {})}, host=host)


class Dump(Program):
    """Messages of a stream as stream_dump prints them."""

    def __init__(self, test, host=None):
        super().__init__(test, "stream_dump", [test.programs_at["stream_dump"], "tcp://127.0.0.1:0", "240"], host=host)
        self.uri = wait_until("stream_dump to listen", lambda: self.out and self.out[0])

    def messages(self):
        return [json.loads(line) for line in list(self.out[1:])]

    def state(self):
        """Returns (names, frame) of the newest epoch; frame: its last PoseFrame or None."""
        names, frame = [], None
        for message in self.messages():
            if message["type"] == "StreamDescription":
                names, frame = message["node_names"], None
            elif message["type"] == "PoseFrame":
                frame = message
        return names, frame

    def wait_place(self, node, place, sim_time_ns=None):
        """Waits for a frame with this node at this place, and returns the frame."""
        def look():
            names, frame = self.state()
            if not frame or node not in names or (sim_time_ns is not None and frame["sim_time_ns"] != sim_time_ns):
                return None
            pose = frame["poses"][names.index(node)]
            return frame if all(abs(pose[4 * i + 3] - place[i]) < 1e-6 for i in range(3)) else None
        return wait_until(lambda: f"{node} at {place}; last: {self.state()}", look)


def world(test, prefix):
    peer = Peer(test, prefix)
    peer.do("model box 10 1 1", "nested arm 20 10 2")
    dump = Dump(test)
    program = adapter(test, "--to", dump.uri)
    program.wait_err(rf'world "demo" at tcp://127\.0\.0\.1:\d+ \({"gz" if prefix == "gz" else "ignition"}\.msgs\.Scene\)')
    dump.wait_place("box/link", (1, 0, 0.5))
    peer.do("wait")
    return peer, dump, program


def poses(test, prefix):
    """Poses relative to parents become global ones, under scoped names, with the simulated time."""
    peer, dump, program = world(test, prefix)
    peer.do("dynamic 1 500000000 10 2 0 0 11 0 0 0.25 20 0 3 0 21 0 0 1")
    frame = dump.wait_place("box/arm/link", (2, 3, 1), 1_500_000_000)
    check(frame["flags"] == 1, "the first frame of a server is no discontinuity")
    dump.wait_place("box/link", (2, 0, 0.25), 1_500_000_000)
    check(dump.state()[0] == ["box", "box/link", "box/arm", "box/arm/link"], f"nodes are {dump.state()[0]}")
    # The other topic says something about the same model, of another time: it is not mixed in.
    peer.do("dynamic 2 0 10 5 0 0", "pose 1 900000000 10 4 0 0", "dynamic 2 1 10 6 0 0")
    dump.wait_place("box", (6, 0, 0), 2 * SECOND + 1)
    check(not any(m["type"] == "PoseFrame" and m["sim_time_ns"] == 1_900_000_000 for m in dump.messages()), "stamps are mixed")
    # Values that no pose has are ignored; the others of the message are not.
    peer.do("dynamic 3 0 10 nan 0 0 11 0 0 9 4000000000 1 2 3")
    dump.wait_place("box/link", (6, 0, 9), 3 * SECOND)
    program.wait_err("not finite")
    program.signal(signal.SIGTERM)
    program.expect_exit(0)
    check(dump.wait() == 0, "the stream does not end in order")


def prefix_gz(test):
    poses(test, "gz")


def prefix_ignition(test):
    poses(test, "ignition")


def entities(test):
    """Models come and go while the world runs; a reset starts a new epoch; unknown ids are looked up."""
    peer, dump, program = world(test, "gz")
    peer.do("dynamic 5 0 10 2 0 0", "model ball 30 5 1")
    ball = "added 1: ball/gazebo/ball"
    dump.wait_place(ball + "/link", (5, 0, 0.5))
    peer.do("dynamic 5 1 10 2 0 0 30 7 0 0")
    dump.wait_place(ball, (7, 0, 0), 5 * SECOND + 1)
    edits = [m for m in dump.messages() if m["type"] == "SceneEdit"]
    check(edits[0]["node"] == "added 1: ball" and bytes(edits[0]["value"]["asset_glb"])[:4] == b"glTF", "no asset is added")
    frame = dump.state()[1]
    peer.do("delete 30")
    wait_until("the ball to go", lambda: dump.state()[0] == ["box", "box/link", "box/arm", "box/arm/link"])
    check(any(m["type"] == "SceneEdit" and m["value"]["type"] == "Cleared" for m in dump.messages()), "the asset stays")
    # A model of the renderer's file: hidden, and the same again when it comes back under another id.
    peer.do("delete 10")
    wait_until("the box to go", lambda: any(m["type"] == "SceneEdit" and m["node"] == "box" and
                                            m["value"]["type"] == "NodeRemoved" for m in dump.messages()))
    peer.do("model box 50 1 1", "nested arm 60 50 2")
    program.wait_err('added again: "box"')
    # Not announced: an unknown id in the poses is enough.
    peer.do("forget 50", "model cone 80 3 2", "dynamic 6 0 80 4 0 0")
    cone = "added 2: cone/gazebo/cone"
    dump.wait_place(cone, (3, 0, 0))
    peer.do("dynamic 6 1 80 4 0 0")
    dump.wait_place(cone, (4, 0, 0), 6 * SECOND + 1)
    epoch = dump.state()[1]["epoch"]
    check(epoch != frame["epoch"], "another set of nodes has the same epoch")
    peer.do("dynamic 0 100 80 0 0 0")
    program.wait_err("simulated time went back")
    frame = dump.wait_place(cone, (0, 0, 0), 100)
    check(frame["epoch"] != epoch and frame["flags"] == 1, "a reset is no discontinuity of a new epoch")
    peer.do("dynamic 0 200 80 1 0 0")
    check(dump.wait_place(cone, (1, 0, 0), 200)["flags"] == 0, "every frame after a reset is a discontinuity")


def restart(test):
    """The adapter starts before the server; the server is killed and comes back with other ids."""
    dump = Dump(test)
    program = adapter(test, "--to", dump.uri)
    program.wait_err("no Gazebo world in partition .*--peer|other partitions seen")
    peer = Peer(test)
    peer.do("model box 10 1 1")
    dump.wait_place("box/link", (1, 0, 0.5))
    peer.do("wait", "dynamic 9 0 10 2 0 0")
    dump.wait_place("box", (2, 0, 0), 9 * SECOND)
    peer.kill()
    program.wait_err('world "demo" has ended')
    peer = Peer(test, "ignition")
    peer.do("model box 70 4 1")
    program.wait_err(r"\(ignition.msgs.Scene\)")
    dump.wait_place("box", (4, 0, 0))
    peer.do("wait", "dynamic 1 0 70 3 0 0")
    check(dump.wait_place("box", (3, 0, 0), SECOND)["flags"] == 1, "another server is no discontinuity")
    check(not any(m["type"] == "SceneEdit" for m in dump.messages()), "an equal model is added again")


def choice(test):
    """Other partitions and several worlds are named."""
    name = partition(test)
    peer = Peer(test, "gz", "first", of=name + "b")
    peer.do("model box 10 1 1")
    lost = adapter(test, "--to", "tcp://127.0.0.1:9")
    lost.wait_err(rf'no Gazebo world in partition "{name}" yet; looked on 127\.0\.0\.1 .*other partitions seen: .*"{name}b".*GZ_PARTITION')
    lost.kill()
    other = Peer(test, "gz", "second", of=name + "b")
    other.do("model box 10 1 1")
    both = adapter(test, "--to", "tcp://127.0.0.1:9", of=name + "b")
    both.expect_exit(1)
    check(both.find_err('there are 2 worlds: choose one with --world: "first", "second"'), both.stderr_text())
    scene = test.path("second.glb")
    adapter(test, "--write-scene", scene, "--world", "second", of=name + "b").expect_exit(0)
    with open(scene, "rb") as file:
        check(file.read(4) == b"glTF", "no scene is written")


def hostile(test):
    """Messages that lie about everything cost nothing but themselves."""
    peer, dump, program = world(test, "gz")
    peer.do(*(f"raw /world/demo/{topic} {kind} {data}" for topic in ("dynamic_pose/info", "pose/info", "scene/info", "scene/deletion")
              for kind in ("gz.msgs.Pose_V", "x") for data in ("", "ff" * 40, "0a" * 2000, "12ffffffff0f", "0a0408ffffffff0f")))
    group = ("239.255.0.7", 10317)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))

        def field(number, data):
            return bytes([number << 3 | 2]) + (struct.pack("B", len(data)) if len(data) < 128 else
                                               bytes([len(data) & 127 | 128, len(data) >> 7])) + data

        def advertise(address, topic="/world/demo/pose/info", uuid=b"evil"):
            name = f"@/{partition(test)}@{topic}".encode()
            pub = field(1, name) + field(2, address) + field(3, uuid) + field(4, b"n") + b"\x28\x02" + field(6, field(2, b"gz.msgs.Pose_V"))
            body = b"\x10\x0a" + field(3, uuid) + b"\x20\x01" + field(7, pub)
            return struct.pack("<H", len(body)) + body
        for datagram in (b"", b"\x00", b"\xff\xff", b"\x02\x00\x08", os.urandom(1400), advertise(b"ipc:///etc/passwd"),
                         advertise(b"tcp://127.0.0.1:99999"), advertise(b"tcp://x" * 500), advertise(b"tcp://127.0.0.1:1"),
                         advertise(b"tcp://127.0.0.1:1", "/world/demo/scene/info")):
            sender.sendto(datagram, group)
        for i in range(3000):
            sender.sendto(advertise(b"tcp://127.0.0.1:1", uuid=b"u%d" % i), group)
    peer.do("dynamic 3 0 10 8 0 0")
    dump.wait_place("box", (8, 0, 0), 3 * SECOND)
    check(program.alive(), program.stderr_text())


def hosts(test):
    """A router that forwards no multicast lies between server and adapter, which has another interface, too."""
    if why_not():
        print(f"skipped: {why_not()}", flush=True)
        sys.exit(SKIPPED)
    near, router, far = (Host(test, name) for name in ("near", "router", "far"))
    cable(near, router, "10.81.0")
    cable(router, far, "10.82.0")
    router.run("sysctl", "-qw", "net.ipv4.ip_forward=1")
    near.run("ip", "route", "add", "default", "via", "10.81.0.2")
    far.run("ip", "route", "add", "default", "via", "10.82.0.1")
    near.run("ip", "address", "add", "10.80.0.1/24", "dev", "lo")
    peer = Peer(test, host=far)
    peer.do("model box 10 1 1")
    dump = Dump(test, host=near)
    alone = adapter(test, "--to", "tcp://127.0.0.1:9", host=near)
    alone.wait_err("no Gazebo world in partition .*no process of Gazebo Transport was seen")
    alone.kill()
    program = adapter(test, "--to", dump.uri, "--peer", "10.82.0.2", host=near)
    program.wait_err(r'world "demo" at tcp://10\.82\.0\.2')
    dump.wait_place("box/link", (1, 0, 0.5))
    peer.do("wait", "dynamic 1 0 10 2 0 0")
    dump.wait_place("box", (2, 0, 0), SECOND)


def password(test):
    """A world with a password: poses come with the right one, and a wrong or missing one is said."""
    secret = {"IGN_TRANSPORT_USERNAME": "u", "IGN_TRANSPORT_PASSWORD": "secret"}
    peer = Peer(test, "ignition", more=secret)
    peer.do("model box 10 1 1")
    for more in ({}, {**secret, "IGN_TRANSPORT_PASSWORD": "guess"}):
        refused = adapter(test, "--to", "tcp://127.0.0.1:9", more=more)
        refused.wait_err("refuses this connection.*GZ_TRANSPORT_PASSWORD")
        refused.kill()
    dump = Dump(test)
    program = adapter(test, "--to", dump.uri, more=secret)
    dump.wait_place("box", (1, 0, 0))
    peer.do("wait", "dynamic 1 0 10 2 0 0")
    dump.wait_place("box", (2, 0, 0), SECOND)
    check(not program.find_err("refuses"), program.stderr_text())


def added(test):
    """A renderer with another scene draws the whole world, which comes over the stream."""
    peer = Peer(test, "ignition")
    peer.do("model box 10 0 1")
    uri = test.fresh_uri("shm")
    program = adapter(test, "--to", uri, "--add-scene", "--camera", "box/link/camera")
    renderer = Program(test, "fire3dv", [test.programs_at["fire3dv"], test.scene, "--validation", "--headless", "--on-request",
                                         "--cache", "off", "--ground", "off", "--listen", uri], env=environment())
    program.wait_err("added the scene")
    peer.do("wait", "images /box/image")
    stamp = 0

    def step():
        nonlocal stamp
        stamp += 50_000_000
        peer.do(f"dynamic {stamp // SECOND} {stamp % SECOND} 10 0 0 0")
        time.sleep(0.02)
        return sum(1 for line in list(peer.out) if re.match(r"image 32x24 .* (1[5-9]|2\d)\d \d\d? \d\d?$", line)) >= 2
    wait_until(lambda: f"red images; {peer.out[-3:]} {program.stderr_text()} renderer: {renderer.stderr_text()}", step)
    for ended in (program, renderer):
        ended.signal(signal.SIGTERM)
        ended.expect_exit(0)


def drawn(test):
    """Two commands: the world is drawn, a model that comes later is, too, and the camera's images go back."""
    peer = Peer(test)
    peer.do("model box 10 0 1")
    scene, uri = test.path("world.glb"), test.fresh_uri("shm")
    program = adapter(test, "--to", uri, "--write-scene", scene, "--camera", "camera", "--camera", "box/link/depth")
    program.wait_err("scene written")
    renderer = Program(test, "fire3dv", [test.programs_at["fire3dv"], scene, "--validation", "--headless", "--on-request",
                                         "--cache", "off", "--ground", "off", "--listen", uri], env=environment())
    renderer.wait_err("listening on")
    peer.do("wait", "images /box/image", "images /world/demo/model/box/link/link/sensor/depth/depth_image",
            "infos /box/camera_info", "infos /world/demo/model/box/link/link/sensor/depth/camera_info")
    stamp = 0

    def images():
        return [re.match(r"image (\d+)x(\d+) (\d+) (\d+) (\d+) (\d+) (\d+) (\d+) (\d+)$", line).groups()
                for line in list(peer.out) if line.startswith("image ")]

    # k1 k2 p1 p2 k3 of plumb_bob, which is OpenCV's order.
    lenses = {"box/link/camera": [0] * 5, "box/link/depth": [0.125, 0, 0, -0.0625, 0]}

    def infos():
        return [json.loads(line[5:]) for line in list(peer.out) if line.startswith("info ")]

    def depths():
        return [re.match(r"depth (\S+) \d+ \d+ (\d+) (\d+) (\S+) (\S+)$", line).groups()
                for line in list(peer.out) if line.startswith("depth ")]

    def step():
        nonlocal stamp
        stamp += 20_000_000
        peer.do(f"dynamic {stamp // SECOND} {stamp % SECOND} 10 {stamp / SECOND} 0 0")
        time.sleep(0.01)
        return len(images()) >= 5 and len(depths()) >= 2 and {i["frame_id"] for i in infos()} == set(lenses)
    wait_until(lambda: f"images; adapter: {program.stderr_text()} renderer: {renderer.stderr_text()}", step)
    stamps = [int(i[2]) * SECOND + int(i[3]) for i in images()]
    # An image that was late does not move the next one.
    check(all(stamp - stamps[0] >= 100_000_000 * i for i, stamp in enumerate(stamps)), f"more than 10 images a second: {stamps}")
    for width, height, _, _, pixel_format, size, red, green, blue in images():
        check((width, height, pixel_format, int(size)) == ("32", "24", "3", 32 * 24 * 3), f"{width}x{height} {pixel_format} {size}")
        check(int(red) > 150 and int(green) < 100 and int(blue) < 100, f"the middle is {red} {green} {blue}, not the box")
    # The camera is 3 m from the middle of a box of 1 m, which does not reach the corners of the image.
    for size, pixel_format, length, middle, corner in depths():
        check((size, pixel_format, length, corner) == ("32x24", "13", "3072", "inf") and abs(float(middle) - 2.5) < 1e-3,
              f"depth is {size} {pixel_format} {length} {middle} {corner}")
    # The centre of the first pixel is (0, 0): 32 pixels have their middle at 15.5 and see 1 rad.
    f = 16 / math.tan(0.5)
    for info in infos():
        check((info["width"], info["height"], info["model"]) == (32, 24, "PLUMB_BOB"), f"{info}")
        matrices = {"d": lenses[info["frame_id"]], "k": [f, 0, 15.5, 0, f, 11.5, 0, 0, 1],
                    "p": [f, 0, 15.5, 0, 0, f, 11.5, 0, 0, 0, 1, 0], "r": [1, 0, 0, 0, 1, 0, 0, 0, 1]}
        check(all(len(info[key]) == len(want) and all(abs(a - b) < 1e-5 for a, b in zip(info[key], want))
                  for key, want in matrices.items()), f"{info}")
    stamps_of_infos = [i["sec"] * SECOND + i["nsec"] for i in infos() if i["frame_id"] == "box/link/camera"]
    check(stamps_of_infos[:5] == stamps[:5], f"images at {stamps}, their infos at {stamps_of_infos}")
    # A model that comes later brings a camera, which sees the model itself.
    check(not program.find_err("not in the scene|unmatched"), program.stderr_text())
    peer.do("model wall 40 30 1")
    program.wait_err('added "wall"')
    peer.do("delete 10")  # and with it the other camera
    program.wait_err('removed "box"')
    before = len(images())
    peer.do("images /wall/image")

    def step_both():
        nonlocal stamp
        stamp += 20_000_000
        peer.do(f"dynamic {stamp // SECOND} {stamp % SECOND} 40 30 0 0")
        time.sleep(0.01)
        return len(images()) >= before + 5
    wait_until(lambda: f"images of the added camera; {program.stderr_text()}", step_both)
    check(all(int(i[6]) > 150 and int(i[7]) < 100 for i in images()), f"not the boxes: {images()[-12:]}")
    for ended in (program, renderer):
        ended.signal(signal.SIGTERM)
        ended.expect_exit(0)


CASES = {"prefix_gz": prefix_gz, "prefix_ignition": prefix_ignition, "entities": entities, "restart": restart,
         "choice": choice, "hostile": hostile, "hosts": hosts, "password": password,
         "added": added, "drawn": drawn}

if __name__ == "__main__":
    main(CASES, PROGRAMS)
