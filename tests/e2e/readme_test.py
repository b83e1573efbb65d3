#!/usr/bin/env python3
"""Runs the first examples of the README, character for character: the quick start, the C and the Python snippet.

readme_test.py FIRE3DV BULLET_ARM CLIENT_LIBRARY C_COMPILER [CASE...]; PYTHONPATH and FIRE3DV_CLIENT_LIBRARY lead to the
Python package. Changes: the address, so that tests run side by side, and size and number of the images that are written.
"""
import os
import signal
import subprocess
import sys

from harness import HANG_S, Program, main, vulkan_environment
from image_reader import check, read_png, write_scene
from readme_commands import code_blocks, section_of
from screen import on_a_screen

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../.."))
README = os.path.join(ROOT, "README.md")
PROGRAMS = ["fire3dv", "bullet_arm", "client_library", "c_compiler"]
SETUP = ["tools/setup.sh", "cmake --preset release && cmake --build --preset release", "cd build/release/bin"]
SCENE = """
typedef struct { int steps; } Simulation;
static Simulation simulation;
static int64_t sim_time_ns;
static void step(Simulation *simulation, float *poses) {
  ++simulation->steps;
  sim_time_ns += 20000000;
  for (int i = 0; i < 3; ++i) poses[12 * i] = poses[12 * i + 5] = poses[12 * i + 10] = 1;
  nanosleep(&(struct timespec){0, 20000000}, NULL);
}
"""


def quick_start():
    """Returns the section's command lines; a backslash at a line's end continues it."""
    text = section_of(README, "Quick start").replace("\\\n", " ")
    lines = [line.strip() for line in text.splitlines() if line.startswith("    ")]
    check(lines[:3] == SETUP, f"the quick start begins with {lines[:3]}")
    return lines[3:]


def shell(test, screen):
    uri = test.fresh_uri("shm")
    for name in ("fire3dv", "bullet_arm"):
        os.symlink(test.programs_at[name], test.path(name))

    def start(line):
        line = line.replace("shm://demo", uri).replace("1280x720", "320x180").replace("--frames 100", "--frames 10")
        return Program(test, line, ["bash", "-c", f"cd '{test.folder}' && exec {line}"], screen.env)

    def stop(*programs):
        for program in programs:
            program.signal(signal.SIGTERM)
            program.expect_exit(0)

    write, view, simulate, images = quick_start()
    start(write).expect_exit(0)
    viewer = start(view)
    screen.window(viewer)
    arm = start(simulate)
    viewer.wait_err("bullet_arm")
    stop(viewer)  # the simulator does not mind
    check(arm.alive(), arm.stderr_text())
    renderer = start(images)
    renderer.expect_exit(0)
    stop(arm)
    written = [name for name in os.listdir(test.path("images")) if name.endswith(".png")]
    check(len(written) == 10, f"{len(written)} images:\n{renderer.stderr_text()}")
    picture = read_png(os.path.join(test.path("images"), sorted(written)[-1]))
    check((picture.width, picture.height) == (320, 180) and int(picture.text.get("Sequence", 0)) > 0,
          f"{picture.text}\n{renderer.stderr_text()}\n{arm.stderr_text()}")


def c_snippet(test):
    with open(README, encoding="utf-8") as file:
        snippet = code_blocks(file.read(), "c")[0]
    include, body = snippet.split("\n\n", 1)
    check(include == "#include <fire3dv/client.h>\n#include <stdio.h>", f"the snippet begins with {include}")
    uri = test.fresh_uri("shm")
    source = "\n".join(["#define _POSIX_C_SOURCE 200809L", "#include <stdint.h>", "#include <time.h>", include, SCENE,
                        "int main(void) {", "#define running (simulation.steps < 3000)",
                        body.replace("shm://demo", uri), "return 0;", "}", ""])
    with open(test.path("snippet.c"), "w", encoding="utf-8") as file:
        file.write(source)
    library = test.programs_at["client_library"]
    built = subprocess.run([test.programs_at["c_compiler"], "-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic",
                            f"-I{os.path.join(ROOT, 'adapters/generic/include')}", test.path("snippet.c"), library,
                            f"-Wl,-rpath,{os.path.dirname(library)}", "-o", test.path("snippet")],
                           capture_output=True, text=True, timeout=HANG_S, check=False)
    check(built.returncode == 0, built.stderr)
    scene = test.path("arm.glb")
    write_scene(scene, squares={name: ((1, 0, 0), i) for i, name in enumerate(("base", "link_1", "gripper"))})
    renderer = test.renderer(scene=scene, listen=[uri])
    renderer.uris()
    snippet = Program(test, "snippet", [test.path("snippet")], dict(os.environ))
    renderer.wait_frame("a frame of the snippet", lambda frame: any(s["sequence"] > 1 for s in frame["streams"]))
    check(not renderer.find_err("no node"), renderer.stderr_text())
    snippet.kill()
    renderer.stop()


def python_snippet(test):
    with open(README, encoding="utf-8") as file:
        snippet = code_blocks(file.read(), "python")[0]
    subprocess.run([test.programs_at["bullet_arm"], "--write-scene", test.path("arm.glb")], timeout=HANG_S, check=True)
    env = {**vulkan_environment(), "FIRE3DV": test.programs_at["fire3dv"]}
    done = subprocess.run([sys.executable, "-W", "error", "-c", snippet], cwd=test.folder,
                          capture_output=True, text=True, timeout=HANG_S, check=False, env=env)
    check(done.returncode == 0, done.stderr)
    picture = read_png(test.path("arm.png"))
    check((picture.width, picture.height) == (640, 480) and picture.text["Sequence"] == "1", f"{picture.text}")


if __name__ == "__main__":
    main({"shell": on_a_screen(shell), "c": c_snippet, "python": python_snippet}, PROGRAMS)
