#!/usr/bin/env python3
"""End-to-end test of SIGTERM while an image takes minutes: each program that draws ends, and its files are whole."""
import os
import signal
import struct
import subprocess
import time

from greedy_scene import write_glb
from harness import HANG_S, Program, check, main, vulkan_environment, wait_until
from live_session import LiveRenderer
from screen import on_a_screen

# The programs promise 2 s. The test machine may be loaded, so that processes wait for a processor.
STOP_S = 5
# Each image of the layers takes more than a minute on any CPU that runs this test.
LAYERS, SIZE = 20_000, "1024x1024"


def write_layers(path, layers=LAYERS):
    """Blended triangles that all cover the whole view, one behind the other, in front of a camera."""
    points = bytearray()
    for layer in range(layers):
        z = -1 - layer * 1e-5
        points += struct.pack("<9f", -50, -50, z, 50, -50, z, 0, 50, z)
    write_glb(path, {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"name": "layers", "mesh": 0}, {"name": "camera", "camera": 0, "translation": [0, 0, 3]}, {"name": "red"}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "zfar": 100}}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]}, "alphaMode": "BLEND", "doubleSided": True}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3 * layers, "type": "VEC3",
                       "min": [-50, -50, -1 - layers * 1e-5], "max": [50, 50, -1]}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(points)}], "buffers": [{"byteLength": len(points)}]},
        bytes(points))
    return path


def start(test, name, *arguments, program="fire3dv"):
    command = [test.programs_at[program], *map(str, arguments), "--validation", "--cache", "off", "--size", SIZE]
    return Program(test, name, command, vulkan_environment())


def stop_in_time(program, code):
    """Sends SIGTERM while the program draws, and returns once it has ended with this exit code."""
    time.sleep(1)  # the image is being drawn; before that the program ends at once
    check(program.alive(), f"{program.name} has ended by itself:\n{program.stderr_text()}")
    begun = time.monotonic()
    program.signal(signal.SIGTERM)
    # The last words count, not the end of the process: the kernel ends it once Mesa's thread of the disk cache, which has the
    # lowest priority (nice 19), has had a processor; on a loaded machine that takes seconds.
    wait_until("the last words", lambda: not program.alive() or "stopped without waiting" in program.stderr_text())
    took = time.monotonic() - begun
    check(took < STOP_S, f"{program.name} took {took:.1f} s to end after SIGTERM:\n{program.stderr_text()}")
    program.expect_exit(code)


def headless(test):
    """The recording and the list of images are whole."""
    scene, recording, uri, out = write_layers(test.path("layers.glb")), test.path("made.mcap"), test.fresh_uri("shm"), test.path("images")
    renderer = start(test, "fire3dv", scene, "--headless", "--out", out, "--listen", uri, "--wait-for-stream", "--record", recording)
    renderer.wait_err("listening on")
    publisher = test.publisher(uri)
    publisher.do("publish 1")
    publisher.wait_welcome()
    stop_in_time(renderer, 0)
    publisher.kill()
    check(os.path.getsize(os.path.join(out, "frames.jsonl")) == 0, "an image that was never finished is listed")
    shown = subprocess.run([test.programs_at["inspect"], recording], capture_output=True, text=True, timeout=HANG_S)
    check(shown.returncode == 0 and "arm" in shown.stdout and "incomplete" not in shown.stdout + shown.stderr,
          f"the recording is not whole: {shown.stdout}{shown.stderr}")


def window(test, screen):
    scene = write_layers(test.path("layers.glb"))
    viewer = Program(test, "fire3dv", [test.programs_at["fire3dv"], scene, "--cache", "off", "--gui", "off", "--size", SIZE],
                     screen.env)
    viewer.wait_err("drawn ")
    stop_in_time(viewer, 0)


def render(test):
    """`fire3dv render`: a folder can be gone on with, of a video nothing is left."""
    scene, recording = write_layers(test.path("layers.glb")), test.path("made.mcap")
    made = subprocess.run([test.programs_at["make"], recording, test.scene], capture_output=True, text=True, timeout=HANG_S)
    check(made.returncode == 0, made.stderr)
    for out in ("frames", "film.mkv"):
        program = start(test, "render", "render", recording, scene, "--out", test.path(out))
        program.wait_err("frames, ")
        if out == "frames":
            wait_until("the folder", lambda: os.path.exists(test.path("frames/manifest.json")))
        stop_in_time(program, 1)
    check(os.path.getsize(test.path("frames/frames.jsonl")) == 0, "frames that were never finished are listed")
    left = [name for name in os.listdir(test.folder) if name.startswith("film")]
    check(not left, f"left of the video: {left}")


def serve(test):
    """While the image of a browser is drawn."""
    live = LiveRenderer(test, scene=write_layers(test.path("layers.glb")))
    viewer = live.viewer(*map(int, SIZE.split("x")))
    stop_in_time(live.renderer, 0)
    check("stopped without waiting" in live.renderer.stderr_text(), "no image was being drawn")
    viewer.close()


def on_request(test):
    """While the image of a simulator is drawn."""
    import fire3dv  # of the tree: PYTHONPATH and FIRE3DV_CLIENT_LIBRARY
    uri = test.fresh_uri("shm")
    renderer = start(test, "fire3dv", write_layers(test.path("layers.glb")), "--headless", "--on-request", "--listen", uri)
    renderer.wait_err("listening on")
    with fire3dv.Stream(uri) as stream:
        stream.describe(["red"])
        sequence = stream.publish(0, [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]])
        request = stream.request_image(*map(int, SIZE.split("x")), node="camera", sequence=sequence)
        renderer.wait_err("accepted")
        stop_in_time(renderer, 0)
        check("stopped without waiting" in renderer.stderr_text(), "no image was being drawn")
        del request


def second_signal(test):
    """A second Ctrl-C does not wait for the deadline."""
    scene = write_layers(test.path("layers.glb"))
    renderer = start(test, "fire3dv", scene, "--headless", "--out", test.path("images"), "--frames", "1000")
    renderer.wait_err("drawn ")
    time.sleep(0.5)
    renderer.signal(signal.SIGINT)
    time.sleep(0.2)  # two signals of one kind at the same time are one
    renderer.signal(signal.SIGINT)
    check(renderer.wait() == -signal.SIGINT, f"it ended with {renderer.process.returncode}")


if __name__ == "__main__":
    main({"headless": headless, "window": on_a_screen(window), "render": render, "serve": serve, "on_request": on_request,
          "second_signal": second_signal},
         ("fire3dv", "publisher", "inspect", "make"))
