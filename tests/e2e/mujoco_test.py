#!/usr/bin/env python3
"""End-to-end test of fire3dv-mujoco: typed commands, the commands of its README, images, and error messages."""
import json
import math
import os
import signal
import struct

from harness import Program, main, shown, vulkan_environment, wait_until
from image_reader import check, read_png
from live_session import LiveRenderer
from readme_commands import commands_of

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
CRANE = os.path.join(ROOT, "tests", "assets", "robots", "crane.xml")
PROGRAMS = ["fire3dv", "fire3dv-mujoco", "stream_dump"]


def readme(section):
    """Returns the command lines of a section of the README, without their folder."""
    found = commands_of(os.path.join(ROOT, "adapters", "mujoco", "README.md"), section)
    check(all(line[0].startswith("build/release/bin/") for line in found), f"{section} runs other programs")
    return [[os.path.basename(line[0]), *line[1:]] for line in found]


def simulator(test, *arguments):
    return Program(test, "fire3dv-mujoco", [test.programs_at["fire3dv-mujoco"], *arguments], env=vulkan_environment())


def commands(test):
    """The stream shows the effect of each command: time, flags, sequence."""
    dump = Program(test, "stream_dump", [test.programs_at["stream_dump"], "tcp://127.0.0.1:0", "240"])
    uri = wait_until("stream_dump to listen", lambda: dump.out and dump.out[0])
    program = simulator(test, CRANE, "--to", uri, "--paused", "--rate", "0", "--speed", "4", "--ctrl", "sin")

    def frames():
        messages = [json.loads(line) for line in dump.out[1:]]
        return [m for m in messages if m["type"] == "PoseFrame"]

    def tell(line):
        program.process.stdin.write(line + "\n")
        program.process.stdin.flush()

    def frame(what, wanted):
        return wait_until(what, lambda: next((f for f in frames() if wanted(f)), None))
    first = frame("a frame while paused", lambda f: f["sequence"] == 1)
    check(first["sim_time_ns"] == 0 and first["flags"] == 1, f"{first}")
    tell("step")
    second = frame("a step", lambda f: f["sequence"] == 2)
    check(second["sim_time_ns"] == 2_000_000, f"a step of the model is 2 ms: {second}")
    tell("dance")
    program.wait_err('"dance" is not one of pause, go, step, reset, quit')
    tell("reset")
    third = frame("a reset", lambda f: f["sequence"] == 3)
    check(third["sim_time_ns"] == 0 and third["flags"] == 1 and third["poses"] == first["poses"], "it was not reset")
    tell("go")
    later = frame("it to go on", lambda f: f["sequence"] > 30)
    check(later["sim_time_ns"] == (later["sequence"] - 3) * 2_000_000, f"steps are left out: {later}")
    check(later["flags"] == 0 and later["poses"] != first["poses"], "nothing moves")
    tell("pause\nquit")
    program.expect_exit(0)
    dump.expect_exit(0)
    check(json.loads(dump.out[-1])["type"] == "Goodbye", f"it ends without goodbye: {dump.out[-1]}")
    program.wait_err(r": \d+ frames published")


def drawn(test):
    """The README's commands draw an image of each frame; a scene of geoms looks like one of bodies."""
    pictures = []
    render, simulate = readme("Run a model")[-2:]
    write, show = readme("One node per geom")
    check(render[0] == show[0] == "fire3dv" and simulate[0] == write[0] == "fire3dv-mujoco", "the README has changed")
    program = simulator(test, CRANE, "--scene", test.path("crane.glb"))
    program.expect_exit(0)
    check(write[1:3] == [os.path.relpath(CRANE, ROOT), "--scene"] and not program.err, f"{program.err}")
    for scene in (CRANE, test.path("crane.glb")):
        uri = test.fresh_uri("shm")
        given = [a for a in render[2:] if a not in ("--listen", "shm://mujoco", "--headless", "--out", "images")]
        renderer = test.renderer(*given, listen=[uri], scene=scene, size=(240, 180))
        line = [CRANE, *simulate[2:]]
        line[line.index("--to") + 1] = uri
        line[line.index("--rate") + 1], line[line.index("--duration") + 1] = "5", "0.4"
        program = simulator(test, *line)
        program.expect_exit(0)
        renderer.expect_exit(0)
        check([m for m in program.err if "accepted" in m] and not any("no node" in m or "unmatched" in m for m in program.err),
              f"names are not found: {program.err}")
        frames = [f for f in renderer.frames() if shown(f, "mujoco")]
        times = sorted({shown(f, "mujoco")["sim_time_ns"] for f in frames})
        check(times == [0, 200_000_000, 400_000_000], f"images show {times}")
        pictures.append([renderer.picture(f) for f in frames])
    bodies, geoms = pictures
    check(len(bodies) == len(geoms) == 3, "there is an image for each frame")
    for a, b in zip(bodies, geoms):
        far = sum(abs(x - y) > 24 for row, other in zip(a.rows, b.rows) for x, y in zip(row, other))
        check(far < 0.002 * 240 * 180 * 3, f"{far} values differ between a scene of bodies and one of geoms")
    moved = sum(x != y for row, other in zip(bodies[0].rows, bodies[2].rows) for x, y in zip(row, other))
    check(moved > 500, f"nothing moves in the images: {moved} values differ")


def lines_of(path):
    with open(path, encoding="utf-8") as file:
        return [json.loads(line) for line in file]


def plane(folder, frame, name, kind):
    """Returns the numbers of a .npy file with a header of 128 bytes."""
    with open(os.path.join(folder, frame["planes"][name]), "rb") as file:
        return [number for (number,) in struct.iter_unpack("<" + kind, file.read()[128:])]


def images(test):
    """The README's commands return each camera's image of each frame, equal to the files of the renderer."""
    render, simulate = readme("Images")
    check(simulate[4:6] == ["--images", "chaser:320x240"] and simulate[8:10] == ["--out", "images"], "the README has changed")
    planes = ["--outputs", "color,depth,instance,boxes2d"]
    size = (96, 72)
    uri = test.fresh_uri("shm")
    renderer = test.renderer("--lockstep", "--camera", "chaser", "--exit-when-done", *planes, listen=[uri], scene=CRANE, size=size)
    line = [CRANE, "--to", uri, *simulate[4:], *planes]
    line[line.index("chaser:320x240")], line[line.index("free camera")] = "chaser:%dx%d" % size, "free camera:64x48"
    line[line.index("images")] = folder = test.path("asked")
    line[line.index("--rate") + 1], line[line.index("--duration") + 1] = "10", "0.3"
    program = simulator(test, *line)
    program.expect_exit(0)
    renderer.expect_exit(0)
    program.wait_err(": 8 images, 0 lost")
    own = [f for f in renderer.frames() if shown(f, "mujoco")]
    asked = lines_of(os.path.join(folder, "frames.jsonl"))
    chased = [f for f in asked if f["camera"] == "chaser"]
    check([f["frame"] for f in chased] == [1, 2, 3, 4] == [f["frame"] for f in asked if f["camera"] == "free camera"],
          f"images of frames {asked}")
    check(len(own) == len(chased), f"{len(own)} images of the renderer's own, {len(chased)} that were asked for")
    for mine, frame in zip(chased, own):
        tag, truth = shown(mine, "mujoco"), shown(frame, "mujoco")
        check([tag[k] for k in ("epoch", "sequence", "sim_time_ns")] == [truth[k] for k in ("epoch", "sequence", "sim_time_ns")],
              f"{tag} is not {truth}")
        check(mine["file"] == f"chaser/frame_{tag['sequence']:06d}.png" and mine["boxes2d"] == frame["boxes2d"], f"{mine}")
        picture = read_png(os.path.join(folder, mine["file"]))
        check(picture.text["SimTimeNs"] == str(tag["sim_time_ns"]) and picture.rows == renderer.picture(frame).rows,
              f"{mine['file']} is another picture")
        labels, depths, true_depths = (plane(where, which, name, kind) for where, which, name, kind in (
            (folder, mine, "instance", "I"), (folder, mine, "depth", "f"), (renderer.folder, frame, "depth", "f")))
        check(len(labels) == len(depths) == len(true_depths) == size[0] * size[1], f"{mine} lacks pixels")
        check(labels == plane(renderer.folder, frame, "instance", "I"), f"{mine} has other labels")
        # Tolerance: the lens is converted to pixels and back.
        check(all(math.isclose(a, b, rel_tol=1e-6) for a, b in zip(depths, true_depths)), f"{mine} has other depths")
    cameras = lines_of(os.path.join(folder, "cameras.jsonl"))
    check(len(cameras) == 8 and [c["world_from_camera"] for c in cameras if c["camera"] == "free camera"][0][7] > 0.1,
          f"{cameras}")
    fovy = math.radians(50)  # of the model
    check(all(abs(c["fy"] - size[1] / 2 / math.tan(fovy / 2)) < 1e-3 and c["cx"] == (size[0] - 1) / 2
              for c in cameras if c["camera"] == "chaser"), f"{cameras[0]}")
    # Without lockstep images are written as they arrive, also while the simulation is paused.
    uri = test.fresh_uri("tcp")
    renderer = Program(test, "fire3dv", [test.programs_at["fire3dv"], CRANE, "--validation", "--cache", "off", "--listen", uri,
                                         *render[4:]], vulkan_environment())
    renderer.wait_err("listening on")
    program = simulator(test, CRANE, "--to", uri, "--paused", "--images", "chaser:48x36", "--out", test.path("loose"))
    listed = test.path("loose/frames.jsonl")
    wait_until("an image", lambda: os.path.exists(listed) and lines_of(listed))
    check(lines_of(listed)[0]["frame"] == 1, "an image shows no frame of the simulation")
    program.signal(signal.SIGINT)
    program.expect_exit(0)
    # In lockstep the program waits for each renderer, also for one that sends no images.
    program = simulator(test, CRANE, "--to", uri, "--to", test.fresh_uri("shm"), "--images", "chaser:48x36", "--out", test.path("two"),
                        "--lockstep", "--ack-timeout", "2", "--duration", "0.1")
    program.expect_exit(1)
    program.wait_err("has shown frame 1")
    renderer.signal(signal.SIGTERM)
    renderer.expect_exit(0)


class Hands:
    """A viewer of the live view, without a browser, that uses the controls of a stream."""

    def __init__(self, live):
        self.client, self.inputs, self.list = live.viewer(64, 48), {}, 0

    def receive(self):
        kind, payload = self.client.receive()
        message = json.loads(payload) if kind == 1 else {"type": "image"}
        if message["type"] == "inputs":
            self.list = message["list"]
            self.inputs = {entry["name"]: {"index": index, **entry} for index, entry in enumerate(message["inputs"])}
        return message

    def until(self, what, condition):
        def look():
            message = self.receive()
            return condition(message)
        return wait_until(what, look)

    def time_s(self, what, wanted):
        """Waits for a status whose stream has such a simulation time."""
        return self.until(what, lambda message: message["type"] == "status" and message["streams"]
                          and wanted(message["streams"][0]["sim_time_s"]))

    def act(self, name, action, value=0):
        self.client.send(json.dumps({"type": "input", "list": self.list, "index": self.inputs[name]["index"], "action": action,
                                     "value": value, "text": ""}))


def hands(test):
    """A page with control steps, runs, pauses and resets the simulation, and moves an actuator; all viewers see it."""
    uri = test.fresh_uri("shm")
    live = LiveRenderer(test, "--listen", uri, scene=CRANE)
    viewer = Hands(live)
    program = simulator(test, CRANE, "--to", uri, "--controls", "--paused", "--rate", "0")
    viewer.until("the controls", lambda _: {"run", "drag", "actuators/winch", "actuators/turn"} <= set(viewer.inputs))
    check(viewer.inputs["run"]["value"] == 0 and viewer.inputs["actuators/winch"]["range"] == [-4, 4], f"{viewer.inputs}")
    viewer.time_s("no step while it is paused", lambda now: now == 0)
    viewer.act("run", "step", 3)
    viewer.time_s("three steps of 2 ms", lambda now: abs(now - 0.006) < 1e-9)
    viewer.act("actuators/winch", "set", 2.5)
    viewer.until("the value of the slider", lambda _: viewer.inputs["actuators/winch"]["value"] == 2.5)
    viewer.act("run", "run")
    viewer.time_s("it to run", lambda now: now > 0.05)
    viewer.until("a bar that says so", lambda _: viewer.inputs["run"]["value"] == 1)
    program.process.stdin.write("pause\n")
    program.process.stdin.flush()
    viewer.until("a pause of the program for all viewers", lambda _: viewer.inputs["run"]["value"] == 0)
    check(viewer.inputs["actuators/winch"]["value"] == 2.5, "the slider has lost its value")
    viewer.act("run", "reset")
    viewer.time_s("its beginning", lambda now: now == 0)
    viewer.until("sliders as in the beginning", lambda _: viewer.inputs["actuators/winch"]["value"] == 0)
    program.signal(signal.SIGTERM)
    program.expect_exit(0)
    viewer.until("no controls without a simulator", lambda _: not viewer.inputs)
    viewer.client.close()


def refused(test):
    for arguments, code, text in (
            ([CRANE], 2, "name where to publish"),
            (["--to", "shm://x"], 2, "model is required"),
            ([CRANE, "--to", "shm://x", "--rate", "nan"], 2, "--rate"),
            ([CRANE, "--to", "shm://x", "--ctrl", "dance"], 2, "--ctrl"),
            ([CRANE, "--to", "shm://x", "--show", "contacts,force"], 2, '"force" is none of contacts, forces'),
            ([CRANE, "--to", "shm://x", "--show", ""], 2, "is none of contacts"),
            ([CRANE, "--scene", test.path("x.glb"), "--show", "com"], 2, "--to URI"),
            ([CRANE, "--scene", test.path("x.glb"), "--controls"], 2, "--to URI"),
            ([CRANE, "--to", "shm://a/b"], 1, "shm://a/b"),
            ([CRANE, "--to", "shm://x", "--key", "none such"], 1, "no keyframe"),
            ([test.path("none.xml"), "--to", "shm://x"], 1, "none.xml"),
            ([test.folder, "--to", "shm://x"], 1, test.folder),
            ([test.scene, "--to", "shm://x"], 1, "squares.glb"),
            ([CRANE, "--scene", test.path("no/folder/out.glb")], 1, "out.glb"),
            ([CRANE, "--to", "shm://x", "--images", "chaser"], 2, "--out DIR"),
            ([CRANE, "--scene", test.path("x.glb"), "--images", "chaser", "--out", test.path("o")], 2, "--to URI"),
            ([CRANE, "--to", "shm://x", "--images", "chaser", "--out", "o", "--outputs", "color,colour"], 2, '"colour" is none of'),
            ([CRANE, "--to", "shm://x", "--images", "chaser:0x9", "--out", "o"], 2, "1 to 8192"),
            ([CRANE, "--to", "shm://x", "--images", "chaser", "--images", "chaser:8x8", "--out", "o"], 2, '"chaser" is given twice'),
            ([CRANE, "--to", test.fresh_uri("shm"), "--images", "nobody", "--out", test.path("o")], 1,
             'no camera "nobody"; it has "free camera", "chaser", "rider"'),
            ([CRANE, "--to", test.fresh_uri("shm"), "--images", "0:8x8", "--out", test.path("o"), "--lockstep",
              "--ack-timeout", "0.1"], 1, "has sent an image of frame 1"),
            ([CRANE, "--to", test.fresh_uri("shm"), "--images", "chaser", "--out", CRANE], 1, "crane.xml"),
            ([CRANE, "--to", test.fresh_uri("udp"), "--images", "chaser", "--out", test.path("o")], 1, "udp://"),
            ([CRANE, "--to", test.fresh_uri("shm"), "--lockstep", "--ack-timeout", "0.1"], 1, "has shown frame 1")):
        program = simulator(test, *arguments)
        program.expect_exit(code)
        check(text in program.stderr_text() and len(program.err) <= 3, f"{arguments}: {program.stderr_text()}")
    uri = test.fresh_uri("shm")
    waits = simulator(test, CRANE, "--to", uri, "--lockstep", "--ack-timeout", "5")
    waits.wait_err(f"waiting for a renderer at {uri} to show frame 1$")
    waits.expect_exit(1)
    check(sum("waiting" in line for line in waits.err) == 1, waits.stderr_text())


main({"commands": commands, "drawn": drawn, "images": images, "hands": hands, "refused": refused}, PROGRAMS)
