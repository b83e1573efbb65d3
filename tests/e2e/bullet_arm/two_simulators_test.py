#!/usr/bin/env python3
"""End-to-end test of examples/two_simulators: two simulators in one scene, and the claims of its README.

Runs the commands of the README with two changes: other addresses, and small images without a window, in folders of the
test, until the test ends the renderers.
"""
import json
import os
import re
import sys

from harness import Program, main, shown, vulkan_environment
from image_reader import check
from readme_commands import commands_of

README = os.path.join(os.path.dirname(__file__), "..", "..", "..", "examples", "two_simulators", "README.md")
BULLET, MUJOCO = "two_simulators_bullet", "two_simulators_mujoco"
PROGRAMS = ["fire3dv", "fire3dv-inspect", "two_simulators_scene", BULLET, MUJOCO]


def commands(section):
    """Returns the command lines of a section of the README, without their folder."""
    found = commands_of(README, section)
    check(all(line[0].startswith("build/release/bin/") for line in found), f"{section} runs other programs")
    return [[os.path.basename(line[0]), *line[1:]] for line in found]


class Stage:
    """Runs the README's commands with addresses of the test."""

    def __init__(self, test):
        self.test, self.scene, self.addresses = test, test.path("two.glb"), {}
        write = next(c for c in commands("Run it") if c[0] == "two_simulators_scene")
        self.start(write).expect_exit(0)

    def address(self, given):
        if given not in self.addresses:
            self.addresses[given] = self.test.fresh_uri(given.split("://")[0])
        return self.addresses[given]

    def arguments(self, command):
        return [self.scene if a == "two.glb" else self.address(a) if "://" in a else a for a in command[1:]]

    def start(self, command):
        program = self.test.programs_at[command[0]]
        return Program(self.test, command[0], [program, *self.arguments(command)], env=vulkan_environment())

    def renderer(self, command):
        check(command[:2] == ["fire3dv", "two.glb"], f"no renderer: {command}")
        own = {"--headless", "--out", "images", "two.glb",  # options that harness.py sets for every renderer
               "--exit-when-done"}  # would end before the second simulator connects
        given = self.arguments([a for a in command if a not in own])
        return self.test.renderer("--camera", "camera_front", *given, scene=self.scene)


def halves(picture):
    """Returns the left and the right half of the image; neither simulator has bodies in the other's half."""
    left, right = 3 * (picture.width * 40 // 100), 3 * (picture.width * 56 // 100)
    return [row[:left] for row in picture.rows], [row[right:] for row in picture.rows]


def different(a, b):
    """Returns the number of different pixels of two halves."""
    return sum(x[i:i + 3] != y[i:i + 3] for x, y in zip(a, b) for i in range(0, len(x), 3))


def moving(renderer, name, epoch=None, after=-1, beyond_s=0):
    """Waits for an image of this stream, later than `after`, in which the simulator is past this time."""
    def predicate(frame):
        tag = shown(frame, name)
        return tag and tag["sim_time_ns"] >= beyond_s * 1e9 and epoch in (None, tag["epoch"])
    return renderer.wait_frame(f"an image of {name}", predicate, after)


def either_may_die(test, scheme):
    stage = Stage(test)
    lines = [c for c in commands("Run it") if any(a.startswith(f"{scheme}://") for a in c)]
    start = {line[0]: line for line in lines}
    check(set(start) == {"fire3dv", BULLET, MUJOCO}, f"the README's commands for {scheme} are {lines}")
    renderer = stage.renderer(start["fire3dv"])
    at_rest = halves(renderer.picture(renderer.wait_frame("the scene at rest", lambda f: not f["streams"])))
    running = {name: stage.start(start[name]) for name in (BULLET, MUJOCO)}
    frame = moving(renderer, BULLET, beyond_s=2)
    frame = renderer.wait_frame("both", lambda f: shown(f, BULLET) and shown(f, MUJOCO)
                                and shown(f, MUJOCO)["sim_time_ns"] >= 3e9, frame["frame"])
    left, right = halves(renderer.picture(frame))
    check(different(left, at_rest[0]) > 100, "Bullet's half has not moved")
    check(different(right, at_rest[1]) > 100, "MuJoCo's half has not moved")

    for dies, lives, half in ((MUJOCO, BULLET, 1), (BULLET, MUJOCO, 0)):
        last = moving(renderer, dies, after=frame["frame"])
        running[dies].kill()
        renderer.wait_err(f'stream "{dies}" ended')
        frame = renderer.wait_frame(f"{lives} alone", lambda f: shown(f, lives) and not shown(f, dies), last["frame"])
        check(halves(renderer.picture(frame))[half] == at_rest[half], f"what {dies} moved is not at rest: {frame['file']}")
        later = renderer.wait_frame(f"{lives} to go on", lambda f: shown(f, lives) and not shown(f, dies) and
                                    shown(f, lives)["sequence"] > shown(frame, lives)["sequence"] + 30, frame["frame"])
        check(different(halves(renderer.picture(later))[1 - half], halves(renderer.picture(frame))[1 - half]) > 10,
              f"{lives} goes on, but its half of the picture does not")
        check(shown(later, lives)["epoch"] == shown(last, lives)["epoch"], f"{lives} was disturbed")
        running[dies] = stage.start(start[dies])
        frame = renderer.wait_frame(f"{dies} to be followed again", lambda f: shown(f, lives) and shown(f, dies) and
                                    shown(f, dies)["epoch"] != shown(last, dies)["epoch"] and
                                    shown(f, dies)["sim_time_ns"] > 15e8, later["frame"])
        check(different(halves(renderer.picture(frame))[half], at_rest[half]) > 10, f"{dies} is back, but moves nothing")
    for program in running.values():
        program.signal(15)
        program.expect_exit(0)
    renderer.stop()


def one_twice(test):
    stage = Stage(test)
    lines = [c for c in commands("Run it") if any(a.startswith("tcp://") for a in c)]
    renderer = stage.renderer(next(c for c in lines if c[0] == "fire3dv"))
    command = next(c for c in lines if c[0] == MUJOCO)
    older = stage.start(command)
    frame = moving(renderer, MUJOCO, beyond_s=1)
    epoch = shown(frame, MUJOCO)["epoch"]
    younger = stage.start(command)
    younger.wait_err("the renderer says: .*another stream drives carousel_rotor")
    older.wait_err("the renderer says: .*this stream drives, and another stream requests carousel_rotor")
    renderer.wait_err(f'stream "{MUJOCO}".*another stream drives "carousel_rotor"')
    check(not older.find_err("another stream drives") and not younger.find_err("this stream drives"), "told the wrong one")
    frame = renderer.wait_frame("the older to go on", lambda f: any(
        s["epoch"] == epoch and s["sequence"] > shown(frame, MUJOCO)["sequence"] + 30 for s in f["streams"]), frame["frame"])
    older.signal(15)
    older.expect_exit(0)
    younger.wait_err(r"the renderer says: accepted$")
    frame = renderer.wait_frame("the younger alone", lambda f: len(f["streams"]) == 1
                                and f["streams"][0]["epoch"] != epoch, frame["frame"])
    younger.signal(15)
    younger.expect_exit(0)
    renderer.stop()


def inspected(test):
    """fire3dv-inspect beside a renderer over shared memory, and instead of one over tcp."""
    stage = Stage(test)
    lines = commands("Run it")
    simulators = [stage.start(c) for c in lines if c[0] in (BULLET, MUJOCO) and c[-1].startswith("shm://")]
    renderer = stage.renderer(next(c for c in lines if c[0] == "fire3dv"))
    moving(renderer, BULLET)
    moving(renderer, MUJOCO)
    look = commands("Look at the streams")[0]
    text = stage.start(look)
    text.expect_exit(0)
    report = "\n".join(text.out)
    for name in (BULLET, MUJOCO):
        check(re.search(rf'"{name}": \d+ nodes, [\d.]+ Hz, \d+ frames, \d+ missing, \d+ bytes; nominal 240.0 Hz', report), report)
    check(report.count("half below") == 2 and "####" in report and report.count(": ") >= 4, f"no ages:\n{report}")
    program = stage.start([*look, "--json"])
    program.expect_exit(0)
    links = [json.loads(line) for line in program.out]
    check([link["uri"] for link in links] == [stage.address(a) for a in look[1:]], f"{links}")
    check_report(links, [[BULLET], [MUJOCO]])
    check(all(s.alive() for s in simulators) and renderer.alive(), "looking on has ended something")
    for program in simulators:
        program.signal(15)
        program.expect_exit(0)
    renderer.stop()

    program = stage.start(["fire3dv-inspect", "tcp://127.0.0.1:7345", "--seconds", "6", "--json"])
    for command in lines:
        if command[0] in (BULLET, MUJOCO) and command[-1].startswith("tcp://"):
            stage.start(command)
    program.expect_exit(0)
    check_report([json.loads(line) for line in program.out], [[BULLET, MUJOCO]])


def check_report(links, names):
    for link, expected in zip(links, names):
        streams = {s["name"]: s for s in link["streams"]}
        check(set(streams) == set(expected), f"streams are {list(streams)}, not {expected}")
        check(set(link["rejected"].values()) == {0} and link["not_understood"] == 0, f"something was refused: {link}")
        for stream in streams.values():
            check(stream["frames"] > 1 and stream["rate_hz"] > 0 and stream["nominal_rate_hz"] == 240, f"{stream}")
            check(stream["frames"] + stream["missing"] <= stream["sequence"] and not stream["ended"], f"{stream}")
            check(stream["ages_known"] and sum(stream["ages_below_power_of_two_us"]) == stream["frames"], f"{stream}")


def in_lockstep(test, scheme):
    """Each pose frame of both simulators gives one image, and each simulator waits for it."""
    stage = Stage(test)
    lines = commands("Make images of it")
    seconds = "0.15"  # instead of 10 in the README: images at 0, 4, 8, ... of 36 steps
    for line in lines:
        if "--seconds" in line:
            line[line.index("--seconds") + 1] = seconds
        if scheme != "shm":  # one address for both
            line[:] = [f"{scheme}://127.0.0.1:7345" if "://" in a else a for a in line]
    render = lines[0]
    if scheme != "shm":
        at = render.index("--listen")
        del render[at:at + 2]
    simulators = [stage.start(line) for line in lines[1:]]
    renderer = stage.renderer(render)
    for program in simulators:
        program.expect_exit(0)
        check(program.find_err("published 10, newest shown is frame 10, dropped 0"), f"not all were waited for:\n{program.stderr_text()}")
    renderer.stop()
    sequences, drawn = {BULLET: 0, MUJOCO: 0}, {BULLET: [], MUJOCO: []}
    for frame in renderer.frames():
        news = [s for s in frame["streams"] if s["sequence"] != sequences[s["stream"]]]
        check(len(news) == 1, f"an image shows {len(news)} new pose frames, not one: {frame}")
        sequences[news[0]["stream"]] = news[0]["sequence"]
        drawn[news[0]["stream"]].append(news[0]["sequence"])
    check(all(list(range(1, 11)) == d for d in drawn.values()), f"not each frame once and in order: {drawn}")


def usage(test):
    for name in (BULLET, MUJOCO):
        for arguments, code in (([], 2), (["--to"], 2), (["--to", "shm://x", "--publish-every", "0"], 2), (["--help"], 0),
                                (["--to", "carrier-pigeon://x"], 1)):
            program = Program(test, name, [test.programs_at[name], *arguments])
            program.expect_exit(code)
            check(code != 1 or len(program.err) == 1, f"not one sentence: {program.stderr_text()}")
    for arguments, code in (([], 2), (["/nowhere/at/all.glb"], 1)):
        Program(test, "scene", [test.programs_at["two_simulators_scene"], *arguments]).expect_exit(code)


if __name__ == "__main__":
    CASES = {"usage": usage, "one_twice": one_twice, "inspected": inspected}
    for transport in ("shm", "tcp"):
        CASES[f"{transport}_either_may_die"] = lambda test, t=transport: either_may_die(test, t)
    for transport in ("shm", "tcp", "udp"):
        CASES[f"{transport}_in_lockstep"] = lambda test, t=transport: in_lockstep(test, t)
    sys.exit(main(CASES, PROGRAMS))
