"""Integration test of the AMBF plugin inside the real AMBF simulator: stream contents and stream end.

AMBF is not part of this project. The test runs on a machine that has it: -DAMBF_DIR=... builds the plugins, then

    tests/ambf/against_ambf.py --simulator PATH_TO/ambf_simulator --launch PATH_TO/launch.yaml --models 0,1 BUILD

The script starts AMBF without a window, moves all joints of models whose namespace begins with /psm, and compares the
received poses with AMBF's own. With --gui (and a display) it also compares AMBF's cameras with the cameras that the
plugin reads without a window.
"""
import argparse
import json
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time

HANG_S = 120
started = []  # every started process; the test ends all of them on exit


def wait_until(what, predicate):
    end = time.monotonic() + HANG_S
    while not predicate():
        if time.monotonic() > end:
            sys.exit(f"waited {HANG_S} s in vain for: {what}")
        time.sleep(0.05)


def end_what_is_left():
    for process in started:
        if process.poll() is None:
            process.kill()
            process.wait()


class Renderer:
    """Receiver of a link; records its messages to a file."""

    def __init__(self, args, uri, folder):
        self.path = os.path.join(folder, f"stream{time.monotonic_ns()}")
        with open(self.path, "wb") as out:
            self.process = subprocess.Popen([os.path.join(args.build, "tests/stream_dump"), uri, str(HANG_S)], stdout=out)
        started.append(self.process)

    def count(self):
        with open(self.path, "rb") as lines:
            return sum(1 for line in lines if b'"poses"' in line)

    def messages(self):
        with open(self.path, encoding="utf-8") as lines:
            next(lines)
            return [json.loads(line) for line in lines if line.endswith("\n")]


class Ambf:
    def __init__(self, args, uri, record, gui=False, rate=100):
        command = [args.simulator, "--launch_file", args.launch, "-l", args.models, "-g", "1" if gui else "0",
                   "-p", str(args.physics_hz), "--plugins",
                   f"{args.build}/bin/libfire3dv_ambf.so, {args.build}/tests/libambf_driver.so",
                   f"--fire3dv-uri={uri}", "--fire3dv-rate", str(rate)]
        self.log = open(record + ".log", "w")
        self.process = subprocess.Popen(command, stdout=self.log, stderr=self.log,
                                        env={**os.environ, "FIRE3DV_AMBF_RECORD": record})
        started.append(self.process)

    def end(self, number):
        self.process.send_signal(number)
        return self.process.wait(HANG_S)


def recorded(path):
    """Returns the keys, and the bytes of all poses for each time in ns."""
    with open(path, "rb") as file:
        keys = json.loads(file.readline())
        size = 8 + 48 * len(keys)
        steps = {}
        while len(step := file.read(size)) == size:
            steps[struct.unpack("<q", step[:8])[0]] = step[8:]
    return keys, steps


def compare(messages, record):
    """Returns the number of compared poses, the largest difference, and the names without an AMBF object."""
    keys, steps = recorded(record)
    names, compared, worst, strangers = [], 0, 0.0, set()
    for message in messages:
        if "node_names" in message:
            names = message["node_names"]
        if "poses" not in message or message["sim_time_ns"] not in steps:
            continue
        own = steps[message["sim_time_ns"]]
        index = {key: i for i, key in enumerate(keys)}
        for name, pose in zip(names, message["poses"]):
            if name not in index:
                strangers.add(name)
                continue
            expected = struct.unpack_from("<12f", own, 48 * index[name])
            worst = max(worst, *(abs(a - b) for a, b in zip(expected, pose)))
            compared += 1
    return compared, worst, sorted(strangers)


def check(good, sentence):
    print(("ok   " if good else "FAIL ") + sentence, flush=True)
    check.failed = check.failed or not good


check.failed = False


def frames(messages):
    return [m for m in messages if "poses" in m]


def shm_file(uri):
    return "/dev/shm/fire3dv." + uri[len("shm://"):]


def one_run(args, folder, name, order, end, uri=None):
    """Starts both programs in the given order, waits for 300 frames, ends AMBF and compares."""
    uri = uri or f"shm://against-ambf-{os.getpid()}-{name}"
    record = os.path.join(folder, name)
    if order == "renderer first":
        renderer, ambf = Renderer(args, uri, folder), Ambf(args, uri, record)
    else:
        ambf = Ambf(args, uri, record)
        wait_until("AMBF's stream", lambda: os.path.exists(shm_file(uri)))
        time.sleep(1)
        renderer = Renderer(args, uri, folder)
    wait_until("frames", lambda: renderer.count() > 300)
    code = ambf.end(end)
    renderer.process.wait(HANG_S)
    if end == signal.SIGKILL:
        check(os.path.exists(shm_file(uri)), f"{name}: who is killed leaves its shared memory")
        return one_run(args, folder, "again-after-" + name, order, signal.SIGTERM, uri)
    messages = renderer.messages()
    compared, worst, strangers = compare(messages, record)
    moved = {json.dumps(m["poses"]) for m in frames(messages)}
    check(compared > 5000 and worst == 0, f"{name}: {compared} poses, largest difference {worst}")
    check(len(moved) > 100, f"{name}: {len(moved)} different frames of {len(frames(messages))}")
    check(all("camera" in s for s in strangers), f"{name}: only the stream has {strangers}")
    check(code == (-signal.SIGTERM if end == signal.SIGTERM else 0), f"{name}: AMBF ended with {code}")
    check(not os.path.exists(shm_file(uri)), f"{name}: no shared memory is left")


def cameras(args, folder):
    """Returns the world poses of cameras in the first frame: those read from files and AMBF's own."""
    found = {}
    for gui in (False, True):
        uri = f"shm://against-ambf-{os.getpid()}-cameras-{gui}"
        renderer = Renderer(args, uri, folder)
        record = os.path.join(folder, f"cameras-{gui}")
        ambf = Ambf(args, uri, record, gui)
        wait_until("frames", lambda: renderer.count() > 100)
        ambf.end(signal.SIGTERM)
        renderer.process.wait(HANG_S)
        messages = renderer.messages()
        names = [m["node_names"] for m in messages if "node_names" in m][0]
        edits = {m["node"]: m["value"] for m in messages if m.get("property") in ("camera", 3)}
        compared, worst, _ = compare(messages, record)
        check(worst == 0, f"cameras, window {gui}: {compared} poses, largest difference {worst}")
        last = frames(messages)[-1]["poses"]
        found[gui] = {n: (last[i], edits[n + "#view"]) for i, n in enumerate(names) if n + "#view" in edits}
    check(found[True].keys() == found[False].keys() and found[True], f"cameras: the same ones, {sorted(found[True])}")
    for name in found[True].keys() & found[False].keys():
        (with_window, lens), (without, file_lens) = found[True][name], found[False][name]
        worst = max(abs(a - b) for a, b in zip(with_window, without))
        check(worst < 2e-6, f"cameras: {name} differs by {worst:.2e} m, with and without a window")
        check(lens is not None and str(lens) == str(file_lens), f"cameras: {name} has the lens {lens}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--simulator", required=True, help="the program ambf_simulator")
    parser.add_argument("--launch", required=True, help="a launch file")
    parser.add_argument("--models", required=True, help="as AMBF's -l takes them")
    parser.add_argument("--physics-hz", type=int, default=1000)
    parser.add_argument("--gui", action="store_true", help="compare with AMBF's own cameras, too; needs a display")
    parser.add_argument("build", help="build folder of this project, made with AMBF_DIR")
    args = parser.parse_args()
    args.build = os.path.abspath(args.build)
    with tempfile.TemporaryDirectory() as folder:
        try:
            one_run(args, folder, "renderer-first", "renderer first", signal.SIGTERM)
            one_run(args, folder, "ambf-first", "AMBF first", signal.SIGINT)
            one_run(args, folder, "killed", "renderer first", signal.SIGKILL)
            if args.gui:
                cameras(args, folder)
        finally:
            end_what_is_left()
    sys.exit(1 if check.failed else 0)


if __name__ == "__main__":
    main()
