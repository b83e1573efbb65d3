#!/usr/bin/env python3
"""End-to-end test of the ends that a run may have: a closed terminal, nohup, and output that nobody reads any more. Files are
finished in every case.
"""
import os
import signal
import subprocess

from harness import HANG_S, Program, check, main, vulkan_environment, wait_until
from mcap_file import McapFile

READY = r"listening on (\S+)"


def recorder_command(test, uri, path):
    return [test.programs_at["record"], "--from", uri, "--out", path]


def renderer_command(test, uri, path):
    return [test.programs_at["fire3dv"], test.scene, "--headless", "--size", "32x18", "--shadows", "off", "--samples", "1", "--cache",
            "off", "--listen", uri, "--record", path, "--stats", path + ".csv"]


def frames_in(path):
    return os.path.exists(path) and os.path.getsize(path) > 8 and len(McapFile(path, whole=False).of("poses"))


def check_finished(path):
    file = McapFile(path)  # fails without a summary
    check(file.of("poses"), "no frame is in the file")
    if os.path.exists(path + ".csv"):
        with open(path + ".csv", encoding="utf-8") as stats:
            text = stats.read()
        check(not text or text.endswith("\n"), f"the statistics are cut: {text[-100:]!r}")


def hangup(test):
    """SIGHUP, twice as from a closed terminal, ends a run in order."""
    for name, command in (("recorder", recorder_command), ("fire3dv", renderer_command)):
        uri, path = test.fresh_uri("shm"), test.path(f"{name}.mcap")
        program = Program(test, name, command(test, uri, path), vulkan_environment())
        publisher = test.publisher(uri)
        program.wait_err(READY)
        publisher.do("stream 100")
        wait_until("frames in the file", lambda: frames_in(path))
        program.signal(signal.SIGHUP)
        program.signal(signal.SIGHUP)
        program.expect_exit(0)
        check_finished(path)


def nohup(test):
    """Under nohup SIGHUP changes nothing."""
    for name, command in (("recorder", recorder_command), ("fire3dv", renderer_command)):
        uri, path = test.fresh_uri("shm"), test.path(f"{name}.mcap")
        program = Program(test, name, ["nohup", *command(test, uri, path)], vulkan_environment())
        publisher = test.publisher(uri)
        program.wait_err(READY)
        publisher.do("stream 100")
        wait_until("frames in the file", lambda: frames_in(path))
        program.signal(signal.SIGHUP)
        before = frames_in(path)
        wait_until("more frames in the file", lambda: not program.alive() or frames_in(path) > before)
        check(program.alive(), f"it ended:\n{program.stderr_text()}")
        program.signal(signal.SIGTERM)
        program.expect_exit(0)
        check_finished(path)


def unread_output(test):
    """The reader of the output ends, as in `fire3dv ... 2>&1 | head -1`: messages are lost, files are not."""
    for name, command in (("recorder", recorder_command), ("fire3dv", renderer_command)):
        uri, path = test.fresh_uri("shm"), test.path(f"{name}.mcap")
        program = subprocess.Popen(command(test, uri, path), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=vulkan_environment())
        try:
            program.stdout.readline()
            program.stdout.close()
            publisher = test.publisher(uri)
            publisher.do("stream 100")
            wait_until("frames in the file", lambda: program.poll() is not None or frames_in(path))
            check(program.poll() is None, f"{name} ended with {program.returncode}")
            program.send_signal(signal.SIGINT)
            check(program.wait(HANG_S) == 0, f"{name} ended with {program.returncode}")
        finally:
            program.kill()
            program.wait()
        check_finished(path)


if __name__ == "__main__":
    main({f.__name__: f for f in (hangup, nohup, unread_output)}, ("fire3dv", "record", "publisher"))
