"""Commands of the wheel: its programs by name, python -m fire3dv for the renderer, and fire3dv demo."""
import argparse
import glob
import os
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from typing import List, Sequence

from ._programs import environment, path_of
from .errors import Error

STEP_HZ = 240
IMAGES_HZ = 15
SHARED_MEMORY_BYTES = 4 << 20  # more than the arm's stream takes
DEFAULT_OUT = "fire3dv-demo"


def _has_shared_memory() -> bool:
    try:
        probe = os.open("/dev/shm", os.O_TMPFILE | os.O_RDWR, 0o600)
    except OSError:
        return False
    try:
        os.posix_fallocate(probe, 0, SHARED_MEMORY_BYTES)
        return True
    except OSError:
        return False
    finally:
        os.close(probe)


def _uri() -> str:
    """A stream over shared memory, or over a socket of this machine where /dev/shm is missing or full."""
    if _has_shared_memory():
        return f"shm://fire3dv-demo-{uuid.uuid4().hex[:12]}"
    print(f"fire3dv demo: /dev/shm is missing or has no room for {SHARED_MEMORY_BYTES >> 20} MiB (docker run --shm-size 64m): "
          "poses arrive over TCP instead", file=sys.stderr)
    import socket
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp://127.0.0.1:{probe.getsockname()[1]}"


def _run(renderer: List[str], simulator: List[str], folder: str) -> int:
    """Runs both to the renderer's end, or until the simulator fails. Returns the exit status."""
    variables, log_file = environment(), os.path.join(folder, "bullet_arm.log")
    running: List[subprocess.Popen] = []
    try:
        with open(log_file, "w", encoding="utf-8") as log:
            arm = subprocess.Popen([path_of("bullet_arm"), *simulator], env=variables, stdout=log, stderr=subprocess.STDOUT,
                                   stdin=subprocess.DEVNULL)
        running.append(arm)
        image = subprocess.Popen([path_of("fire3dv"), *renderer], env=variables)
        running.append(image)
        while image.poll() is None:
            if arm.poll():  # the renderer would wait for it
                with open(log_file, encoding="utf-8", errors="replace") as log:
                    print(f"fire3dv demo: error: the simulator failed:\n{log.read().strip()}", file=sys.stderr)
                return 1
            time.sleep(0.05)
        return image.returncode
    except KeyboardInterrupt:
        return 130
    finally:
        for process in running:
            process.terminate()
            process.wait()


def _window(scene: str, folder: str) -> int:
    uri = _uri()
    print(f"fire3dv demo: a window shows the arm, whose poses arrive over {uri}; close it to end", file=sys.stderr)
    return _run([scene, "--listen", uri, "--camera", "camera_front"], ["--to", uri, "--realtime", "--loop"], folder)


def _images(scene: str, folder: str, options: argparse.Namespace) -> int:
    uri, out, start = _uri(), os.path.abspath(options.out), time.time()
    every = str(STEP_HZ // IMAGES_HZ)
    status = _run([scene, "--listen", uri, "--headless", "--lockstep", "--exit-when-done", "--size", options.size, "--camera",
                   "camera_front", "--out", out],
                  ["--to", uri, "--seconds", str(options.seconds), "--rate", str(STEP_HZ), "--lockstep", "--lockstep-every", every,
                   "--publish-every", every], folder)
    if status == 0:
        count = sum(os.path.getmtime(path) >= start for path in glob.glob(os.path.join(glob.escape(out), "frame_*.png")))
        print(f"{count} images of the moving arm in {time.time() - start:.1f} s: {os.path.join(out, 'frame_000000.png')} and on\n"
              f"next: fire3dv FILE draws a robot of yours (glTF, URDF, MJCF, SDF, ...); fire3dv --help")
    return status


def demo(arguments: Sequence[str]) -> int:
    """A simulated robot arm in one process, drawn by another, in a window or as images. Returns the exit status."""
    parser = argparse.ArgumentParser(prog="fire3dv demo", description="A simulated robot arm in one process, drawn by another: "
                                     "in a window, or as images where there is no display.")
    parser.add_argument("--out", metavar="DIR", help="write images, to this folder (default without a display: fire3dv-demo, "
                        "of a temporary folder where this one cannot be written)")
    parser.add_argument("--seconds", type=int, default=1, metavar="N", help="simulated seconds of the images (default 1)")
    parser.add_argument("--size", default="640x360", metavar="WxH", help="of the images (default 640x360)")
    options = parser.parse_args(arguments)
    if not 1 <= options.seconds <= 9999:
        parser.error(f"--seconds is a whole number from 1 to 9999, not {options.seconds}")
    has_display = bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    try:
        tempfile.gettempdir()
    except FileNotFoundError:
        print("fire3dv demo: error: there is no folder for temporary files that can be written: let the environment variable TMPDIR "
              "name one", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory(prefix="fire3dv-demo-") as folder:
        scene = os.path.join(folder, "arm.glb")
        made = subprocess.run([path_of("bullet_arm"), "--write-scene", scene], env=environment(), stdout=subprocess.DEVNULL, check=False)
        if made.returncode:
            return made.returncode
        if has_display and not options.out:
            status = _window(scene, folder)
            if status in (0, 130):
                return status
            print("fire3dv demo: no window could be opened; writing images instead", file=sys.stderr)
        if not options.out:
            here = os.access(os.curdir, os.W_OK | os.X_OK)
            options.out = DEFAULT_OUT if here else tempfile.mkdtemp(prefix=DEFAULT_OUT + "-")
        return _images(scene, folder, options)


def _end(number: int, _frame: object) -> None:
    """Handler of SIGTERM: ends as an exception does, so that neither processes nor the temporary folder remain."""
    signal.signal(number, signal.SIG_IGN)  # a second one must not interrupt that
    raise SystemExit(128 + number)


def main() -> None:
    """Becomes the program that the script is named after."""
    name = os.path.basename(sys.argv[0])
    if name == "__main__.py":  # python -m fire3dv
        name = "fire3dv"
    program = name
    try:
        if name == "fire3dv" and sys.argv[1:2] == ["demo"]:
            signal.signal(signal.SIGTERM, _end)
            sys.exit(demo(sys.argv[2:]))
        program = path_of(name)
        os.execve(program, [program, *sys.argv[1:]], environment())
    except Error as error:
        sys.exit(f"{name}: error: {error}")
    except OSError as error:
        sys.exit(f"{name}: error: {program} cannot be started ({error.strerror}): install the package again")


if __name__ == "__main__":
    main()
