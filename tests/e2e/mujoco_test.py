#!/usr/bin/env python3
"""fire3dv-mujoco: obeys what is typed, is drawn as its README says, and says what is wrong."""
import json
import os
import re
import shlex

from harness import Program, main, shown, vulkan_environment, wait_until
from pictures import check

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
CRANE = os.path.join(ROOT, "tests", "assets", "robots", "crane.xml")
PROGRAMS = ["fire3dv", "fire3dv-mujoco", "stream_dump"]


def readme(section):
    """The command lines of a section of the README, without their folder."""
    with open(os.path.join(ROOT, "adapters", "mujoco", "README.md"), encoding="utf-8") as file:
        text = file.read().split(f"\n## {section}\n", 1)[1].split("\n## ", 1)[0]
    found = [shlex.split(line) for block in re.findall(r"```sh\n(.*?)```", text, re.S) for line in block.splitlines()]
    check(found and all(line[0].startswith("build/release/bin/") for line in found), f"{section} has no commands")
    return [[os.path.basename(line[0]), *line[1:]] for line in found]


def simulator(test, *arguments):
    return Program(test, "fire3dv-mujoco", [test.programs_at["fire3dv-mujoco"], *arguments], env=vulkan_environment())


def commands(test):
    """Each line does what it says, and the stream shows it: time, flags, sequence."""
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
    """The README's commands give an image for each frame, and a scene of geoms looks as one of bodies."""
    pictures = []
    render, simulate = readme("Run a model")[-2:]
    write, show = readme("Tell geoms apart")
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


def refused(test):
    for arguments, code, text in (
            ([CRANE], 2, "name where to publish"),
            (["--to", "shm://x"], 2, "model is required"),
            ([CRANE, "--to", "shm://x", "--rate", "nan"], 2, "--rate"),
            ([CRANE, "--to", "shm://x", "--ctrl", "dance"], 2, "--ctrl"),
            ([CRANE, "--to", "shm://a/b"], 1, "shm://a/b"),
            ([CRANE, "--to", "shm://x", "--key", "none such"], 1, "no keyframe"),
            ([test.path("none.xml"), "--to", "shm://x"], 1, "none.xml"),
            ([test.folder, "--to", "shm://x"], 1, test.folder),
            ([test.scene, "--to", "shm://x"], 1, "squares.glb"),
            ([CRANE, "--scene", test.path("no/folder/out.glb")], 1, "out.glb"),
            ([CRANE, "--to", test.fresh_uri("shm"), "--lockstep", "--ack-timeout", "0.1"], 1, "has shown frame 1")):
        program = simulator(test, *arguments)
        program.expect_exit(code)
        check(text in program.stderr_text() and len(program.err) <= 3, f"{arguments}: {program.stderr_text()}")


main({"commands": commands, "drawn": drawn, "refused": refused}, PROGRAMS)
