#!/usr/bin/env python3
"""End-to-end test of the promise that a recording holds what was sent, or says what it lacks: by name, number and exit status."""
import json
import os
import re
import signal
import subprocess

from harness import Program, check, main, vulkan_environment, wait_until
from mcap_file import McapFile, pose_frame

NODES = 20
FRAMES = 480


def fire3dv(test, uri, path, *arguments):
    program = Program(test, "fire3dv", [test.programs_at["fire3dv"], test.scene, "--headless", "--cache", "off", "--listen", uri, "--record",
                                        path, *arguments], vulkan_environment())
    program.uri = program.wait_err(r"listening on (\S+)").group(1)
    return program


def recorder(test, uri, path, *arguments):
    program = Program(test, "recorder", [test.programs_at["record"], "--from", uri, "--out", path, *arguments])
    program.uri = program.wait_err(r"listening on (\S+)").group(1)
    return program


def source(test, uri, frames, rate, *options):
    return Program(test, "source", [test.programs_at["source"], uri, "arm", str(frames), str(rate), str(NODES), *options])


def sequences_in(path):
    return [pose_frame(message)[1] for _, message in McapFile(path).of("poses")]


def whole(test, transport):
    """Images that take longer than the ring of a simulator lasts: every frame is in the file."""
    path = test.path("whole.mcap")
    renderer = fire3dv(test, test.fresh_uri(transport), path, "--size", "1280x960", "--exit-when-done")
    source(test, renderer.uri, FRAMES, 240, "wait").expect_exit()
    renderer.expect_exit()
    sequences = sequences_in(path)
    check(sequences == list(range(1, FRAMES + 1)), f"{len(sequences)} of {FRAMES} frames are in the file")
    check(renderer.find_err(rf"{FRAMES} frames of 1 stream recorded"), renderer.stderr_text())


def whole_shm(test):
    whole(test, "shm")


def whole_tcp(test):
    whole(test, "tcp")


def whole_udp(test):
    whole(test, "udp")


def gaps(test):
    """A program that was stopped lacks frames of a ring: its last words have stream and number, and its exit status is 1."""
    for start in (fire3dv, recorder):
        path = test.path(f"{start.__name__}.mcap")
        program = start(test, test.fresh_uri("shm"), path, *(("--size", "32x18") if start is fire3dv else ()))
        publisher = source(test, program.uri, 10**6, 500)
        wait_until("frames in the file", lambda: os.path.getsize(path) > 8 and McapFile(path, whole=False).of("poses"))
        program.signal(signal.SIGSTOP)
        read = McapFile(path, whole=False).of("poses")
        dump = subprocess.run([test.programs_at["inspect"], "--json", "--seconds", "1", program.uri], capture_output=True, text=True, timeout=240)
        check(len(read) and json.loads(dump.stdout), "the publisher does not go on")
        program.signal(signal.SIGCONT)
        wait_until("later frames", lambda: len(McapFile(path, whole=False).of("poses")) > len(read) + 100)
        program.signal(signal.SIGINT)
        program.expect_exit(1)
        publisher.kill()
        sequences = sequences_in(path)
        missing = sequences[-1] - sequences[0] + 1 - len(sequences)
        said = re.search(r'error: .*stream "arm" lacks (\d+) frames? of (\d+)', program.stderr_text())
        check(said and missing > 50 and [int(n) for n in said.groups()] == [missing, missing + len(sequences)],
              f"{missing} of {missing + len(sequences)} are missing:\n{program.stderr_text()}")


def lost_file(test):
    """A file that is removed or replaced while it is written is a warning at once, and an error at the end."""
    for start in (fire3dv, recorder):
        for replaces in (False, True):
            path = test.path(f"{start.__name__}{replaces}.mcap")
            program = start(test, test.fresh_uri("shm"), path, *(("--size", "32x18") if start is fire3dv else ()))
            publisher = source(test, program.uri, 10**6, 200)
            wait_until("frames in the file", lambda: os.path.getsize(path) > 8 and McapFile(path, whole=False).of("poses"))
            if replaces:
                with open(path + ".new", "wb") as other:
                    other.write(b"another file")
                os.replace(path + ".new", path)
            else:
                os.unlink(path)
            word = "replaced" if replaces else "removed"
            program.wait_err(rf"warning: .*\.mcap was {word} while it was written")
            program.signal(signal.SIGINT)
            program.expect_exit(1)
            publisher.kill()
            check(program.find_err(rf"error: .*\.mcap was {word} while it was written"), program.stderr_text())
            said = [line for line in program.err if "while it was written" in line]
            check(len(said) == 2, f"it was said {len(said)} times")


def no_listener(test):
    """A port in use: the recording that never began leaves no file."""
    taken = recorder(test, test.fresh_uri("tcp"), test.path("taken.mcap"))
    path = test.path("none.mcap")
    done = subprocess.run([test.programs_at["fire3dv"], test.scene, "--headless", "--size", "32x18", "--cache", "off", "--listen",
                           taken.uri, "--record", path], capture_output=True, text=True, timeout=240, env=vulkan_environment())
    check(done.returncode == 1 and taken.uri in done.stderr, done.stderr)
    check(not os.path.exists(path), "it left a file")


if __name__ == "__main__":
    main({f.__name__: f for f in (whole_shm, whole_tcp, whole_udp, gaps, lost_file, no_listener)},
         ("fire3dv", "record", "inspect", "source"))
