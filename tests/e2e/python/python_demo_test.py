"""`fire3dv demo` on machines that lack something, its end by SIGTERM, and the variables of the wheel's programs.
Draws nothing."""
import contextlib
import errno
import io
import os
import signal
import subprocess
import sys
import tempfile
import time
from unittest import mock

from fire3dv import __main__ as commands
from fire3dv import _programs


def said_by(function, *arguments):
    """Returns the function's result, and what it printed."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        result = function(*arguments)
    return result, out.getvalue()


def streams():
    uri, said = said_by(commands._uri)
    assert uri.startswith("shm://") and not said, (uri, said)
    full = OSError(errno.ENOSPC, "full")
    with mock.patch("os.posix_fallocate", side_effect=full):
        uri, said = said_by(commands._uri)
    assert uri.startswith("tcp://127.0.0.1:") and "/dev/shm" in said and "TCP" in said, (uri, said)
    assert not [name for name in os.listdir("/dev/shm") if name.startswith("fire3dv-demo")], "the probe left a file"


def folders():
    with mock.patch("tempfile.gettempdir", side_effect=FileNotFoundError):
        status, said = said_by(commands.demo, [])
    assert status == 1 and "TMPDIR" in said, said
    drawn = []

    def run(renderer, simulator, folder):
        drawn.append(renderer[renderer.index("--out") + 1])
        return 0
    done = subprocess.CompletedProcess([], 0)
    with mock.patch.object(commands, "_run", run), mock.patch.object(commands, "path_of", str), \
            mock.patch("subprocess.run", return_value=done), mock.patch.dict(os.environ, DISPLAY="", WAYLAND_DISPLAY=""):
        said_by(commands.demo, [])
        with mock.patch("os.access", return_value=False):
            status, said = said_by(commands.demo, [])
    assert drawn[0] == os.path.abspath("fire3dv-demo"), drawn
    assert status == 0 and os.path.dirname(drawn[1]) == tempfile.gettempdir() and drawn[1] in said, (drawn, said)
    os.rmdir(drawn[1])


def drivers():
    before = dict(os.environ)
    with mock.patch.object(_programs, "software_driver", return_value="/cpu.json"):
        added = _programs.environment({"VK_ADD_DRIVER_FILES": "/own.json"})["VK_ADD_DRIVER_FILES"]
        assert added == "/own.json:/cpu.json", added
        assert "VK_ADD_DRIVER_FILES" not in _programs.environment({"VK_DRIVER_FILES": "/gpu.json"}), "a driver beside the chosen one"
    assert dict(os.environ) == before, "variables of this process, which other programs inherit"


def write_program(folder, name, text):
    with open(os.path.join(folder, name), "w", encoding="ascii", opener=lambda *words: os.open(*words, 0o755)) as file:
        file.write(f"#!/bin/sh\n{text}\n")


def has_ended(pid_file):
    with open(pid_file, encoding="ascii") as file:
        return not os.path.exists(f"/proc/{int(file.read())}")


def termination():
    """A service manager's SIGTERM ends both programs, and no temporary folder remains."""
    with tempfile.TemporaryDirectory() as programs, tempfile.TemporaryDirectory() as temporary:
        pids = [os.path.join(programs, name + ".pid") for name in ("bullet_arm", "fire3dv")]
        stay = 'echo $$ > {0}.new; mv {0}.new {0}; exec sleep 60'
        write_program(programs, "bullet_arm", f'[ "$1" != --write-scene ] || exit 0; {stay.format(pids[0])}')
        write_program(programs, "fire3dv", stay.format(pids[1]))
        demo = subprocess.Popen([sys.executable, "-m", "fire3dv", "demo", "--out", os.path.join(programs, "out")],
                                env={**os.environ, "FIRE3DV": os.path.join(programs, "fire3dv"), "TMPDIR": temporary})
        while not all(map(os.path.exists, pids)):
            assert demo.poll() is None, demo.returncode
            time.sleep(0.02)
        demo.send_signal(signal.SIGTERM)
        status = demo.wait()
        left = [pid for pid in pids if not has_ended(pid)]
        assert status == 143 and not left and not os.listdir(temporary), (status, left, os.listdir(temporary))


if __name__ == "__main__":
    for case in (streams, folders, drivers, termination):
        case()
    print("python_demo: passed", file=sys.stderr)
