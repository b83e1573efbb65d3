"""End-to-end test of fire3dv.Renderer: the process starts, listens, draws and ends, however Python ends.

python_renderer_test.py FIRE3DV [CASE...]. Cases of the process alone use a shell script in the renderer's place.
"""
import io
import os
import signal
import subprocess
import sys
import threading
import time
import urllib.request

import numpy

import fire3dv
import fire3dv._process
from harness import HANG_S, main, vulkan_environment, wait_until
from image_reader import SIZE, check, read_png, write_scene

CAMERA = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 50]  # with fx 50 a unit of the scene is a pixel
LISTENING = "echo 'fire3dv: info: listening on shm://script'; "


def script(test, name, text):
    path = test.path(name)
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"#!/bin/sh\n{text}\n")
    os.chmod(path, 0o755)
    return path


def lives(pid):
    """A zombie, which waits for its parent, has ended."""
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def wait_end(pid):
    wait_until(f"process {pid} to end", lambda: not lives(pid))


def raised(kind, text, call):
    try:
        call()
    except kind as error:
        check(text in str(error), f"{text!r} is not in: {error}")
        return error
    raise AssertionError(f"no {kind.__name__} was raised")


def draws(test):
    """A scene, its frame and an image, over a fresh name and over a free port."""
    os.environ.update(vulkan_environment())
    options = {"program": test.programs_at["fire3dv"], "arguments": ["--validation", "--cache", "off", "--tone-map", "none"],
               "start_timeout_s": HANG_S}
    with fire3dv.Renderer(test.scene, **options) as first, \
            fire3dv.Renderer(test.scene, uri="tcp://127.0.0.1:0", log=sys.stderr, **options) as second:
        check(first.uri.startswith("shm://") and second.uri.startswith("tcp://127.0.0.1:"), f"{first} {second}")
        check(not second.uri.endswith(":0"), second.uri)
        for renderer in (first, second):
            stream = renderer.stream("python")
            stream.describe(["red"])
            stream.publish(5, [[1, 0, 0, -20, 0, 1, 0, 0, 0, 0, 1, 0]])
            with stream.request_image(*SIZE, parent_from_camera=CAMERA, fx=50).wait(HANG_S) as image:
                color = numpy.array(image["color_srgb8"]).astype(int)
                check(image.sim_time_ns == 5, f"frame of {image.sim_time_ns} ns")
            reds = numpy.argwhere((color[..., 0] > 200) & (color[..., 1] < 60) & (color[..., 2] < 60))
            centre = reds.mean(axis=0) + 0.5 - numpy.array([SIZE[1], SIZE[0]]) / 2
            check(numpy.abs(centre - [-30, -20]).max() < 1, f"the square is at {centre}, not at row -30, column -20")
            check(renderer.is_running and any("listening on" in line for line in renderer.log), f"{renderer.log}")
            check(f"pid {renderer.pid}, running" in repr(renderer), repr(renderer))
        wait_for_it = first.stream  # of a renderer that is closed below
        third = second.stream("second")
        os.kill(second.pid, signal.SIGKILL)
        third.describe([])
        ask = third.request_image(8, 8, fx=8)
        began = time.monotonic()
        raised(fire3dv.RendererError, "was ended by signal 9. Its last lines:\n", lambda: ask.wait(10 * HANG_S))
        check(time.monotonic() - began < 5 * HANG_S, "the wait went on after the renderer's end")
        check(not second.is_running and "ended>" in repr(second), repr(second))
    check(not lives(first.pid) and not third.is_open and "closed>" in repr(first), repr(first))
    raised(fire3dv.RendererError, "is closed", wait_for_it)
    first.close()  # may be called again


def readme(test):
    """The first example of the package's README, with a scene of ours."""
    os.environ.update(vulkan_environment())
    os.environ["FIRE3DV"] = test.programs_at["fire3dv"]
    path = os.path.join(os.path.dirname(os.path.dirname(fire3dv.__file__)), "README.md")
    with open(path, encoding="utf-8") as file:
        example = file.read().split("```python\n")[1].split("```")[0]
    check("Renderer(" in example and len(example.splitlines()) <= 15, example)
    write_scene(test.path("scene.glb"), squares={"arm": ((1, 0, 0), 0)})
    done = subprocess.run([sys.executable, "-W", "error", "-c", example], cwd=test.folder, capture_output=True, text=True,
                          check=False)
    check(done.returncode == 0, done.stderr)
    check(done.stdout.endswith("{1: 'arm'}\n"), done.stdout)
    picture = read_png(test.path("arm.png"))
    check((picture.width, picture.height) == (640, 480) and picture.text["Sequence"] == "10", f"{picture.text}")


def faults(test):
    """Errors have the renderer's own lines, or name what to correct."""
    program = test.programs_at["fire3dv"]
    os.environ.update(vulkan_environment())
    error = raised(fire3dv.RendererError, "ended with exit status 1 before it listened. Its last lines:\n    fire3dv: error: ",
                   lambda: fire3dv.Renderer(test.path("none.glb"), program=program))
    check("none.glb" in str(error) and error.code == fire3dv.ERROR_SYSTEM, str(error))
    raised(fire3dv.RendererError, "--nonsense",
           lambda: fire3dv.Renderer(test.scene, program=program, arguments=["--nonsense"]))
    raised(fire3dv.RendererError, "cannot open \"./-x.glb\"", lambda: fire3dv.Renderer("-x.glb", program=program))
    raised(fire3dv.RendererError, "ended with exit status 3", lambda: fire3dv.Renderer(test.scene, program=program, require_gpu=True))
    raised(fire3dv.ArgumentError, "size", lambda: fire3dv.Renderer(test.scene, size=640, program=program))
    raised(fire3dv.ArgumentError, "NUL", lambda: fire3dv.Renderer("a\0b", program=program))
    raised(fire3dv.RendererNotFound, "program is '/nowhere/fire3dv'",
           lambda: fire3dv.Renderer(test.scene, program="/nowhere/fire3dv"))
    silent = script(test, "silent", "sleep 1000")
    raised(fire3dv.RendererError, "does not listen after 0.5 s (start_timeout_s); it wrote nothing",
           lambda: fire3dv.Renderer(test.scene, program=silent, start_timeout_s=0.5))


def served(test):
    """The link of the live view is there when the constructor returns, however late the renderer prints it."""
    token = "0123456789abcdef" * 2
    links = "sleep 0.3; " + "".join(f"echo '  {kind}  http://127.0.0.1:8080/#{token}{number}'; "
                                    for kind, number in (("control", ""), ("view   ", "&node=x")))
    late = script(test, "late", 'echo "$@"; ' + LISTENING + links + "exec sleep 1000")
    for options, words in (({"serve": True}, "--serve 127.0.0.1:0"), ({"serve": "[::1]:9"}, "--serve [::1]:9"),
                           ({"arguments": ["--serve", "127.0.0.1:0"]}, "--serve 127.0.0.1:0")):
        with fire3dv.Renderer(test.scene, program=late, **options) as renderer:
            check(words in renderer.log[0], renderer.log[0])
            check(os.path.isdir(os.path.dirname(renderer.instances.path)), "no folder for the list of instances")
            check(renderer.control_link == f"http://127.0.0.1:8080/#{token}", renderer.control_link)
            check(renderer.view_link == f"http://127.0.0.1:8080/#{token}&node=x", renderer.view_link)
            check(fire3dv.show(renderer) == fire3dv.show(renderer.view_link), "show() shows another link")
        check(not os.path.exists(os.path.dirname(renderer.instances.path)), "the folder of the list stays")
    silent = script(test, "silent", LISTENING + "exec sleep 1000")
    raised(fire3dv.RendererError, "prints no link of its live view after 0.5 s",
           lambda: fire3dv.Renderer(test.scene, program=silent, serve=True, start_timeout_s=0.5))
    with fire3dv.Renderer(test.scene, program=silent) as renderer:
        raised(fire3dv.StateError, "fire3dv.Renderer(..., serve=True)", lambda: renderer.view_link)
        raised(fire3dv.StateError, "fire3dv.Renderer(..., serve=True)", lambda: fire3dv.show(renderer))
    raised(fire3dv.ArgumentError, "serve is 8080", lambda: fire3dv.Renderer(test.scene, program=silent, serve=8080))
    raised(fire3dv.ArgumentError, "arguments is one str; a list is needed",
           lambda: fire3dv.Renderer(test.scene, program=silent, arguments="--samples 1"))
    windowless = script(test, "windowless", "echo 'fire3dv: error: no display; use --headless --frames 1 --out DIR'; exit 1")
    raised(fire3dv.RendererError, "no display; use headless=True",
           lambda: fire3dv.Renderer(test.scene, program=windowless, headless=False))
    # The program itself.
    os.environ.update(vulkan_environment())
    with fire3dv.Renderer(test.scene, program=test.programs_at["fire3dv"], serve=True, start_timeout_s=HANG_S,
                          arguments=["--cache", "off"]) as renderer:
        with urllib.request.urlopen(renderer.view_link.split("#")[0], timeout=HANG_S) as page:
            check(page.status == 200 and b"<html" in page.read().lower(), "the link leads nowhere")
        check(renderer.view_link != renderer.control_link, renderer.view_link)


def programs(test):
    """Order in which the program is looked for."""
    mine = script(test, "fire3dv", LISTENING + "exec sleep 1000")
    os.environ["FIRE3DV"] = "/nowhere/fire3dv"
    raised(fire3dv.RendererNotFound, "the environment variable FIRE3DV is '/nowhere/fire3dv'", fire3dv.find_program)
    check(fire3dv.find_program(mine) == mine, "the argument does not come first")
    os.environ["FIRE3DV"] = mine
    check(fire3dv.find_program() == mine, "FIRE3DV was not taken")
    del os.environ["FIRE3DV"]
    # The build's own, beside the library that FIRE3DV_CLIENT_LIBRARY names.
    check(os.path.samefile(fire3dv.find_program(), test.programs_at["fire3dv"]), fire3dv.find_program())
    find = "import fire3dv; print(fire3dv.find_program())"
    environment = {**os.environ, "PATH": test.folder, "FIRE3DV_CLIENT_LIBRARY": "/nowhere.so"}
    found = subprocess.run([sys.executable, "-c", find], env=environment, capture_output=True, text=True, check=True)
    check(found.stdout.strip() == mine, f"PATH was not searched: {found.stdout}")
    environment["PATH"] = "/nowhere"
    lost = subprocess.run([sys.executable, "-c", find], env=environment, capture_output=True, text=True, check=False)
    check("set the environment variable FIRE3DV to its file" in lost.stderr, lost.stderr)


def ends(test):
    """The process ends with the object, with an exception, and by force if it must. It outlives the thread that made it."""
    program = script(test, "renderer", LISTENING + "exec sleep 1000")

    def one(**options):
        return fire3dv.Renderer("scene.glb", program=program, **options)
    log = io.StringIO()
    try:
        with one(log=log) as renderer:
            raise KeyboardInterrupt
    except KeyboardInterrupt:
        check(not lives(renderer.pid), "it outlives an exception")
    check(log.getvalue() == "fire3dv: info: listening on shm://script\n", log.getvalue())
    renderer = one()
    pid = renderer.pid
    del renderer
    check(not lives(pid), "it outlives its object")

    made = []
    thread = threading.Thread(target=lambda: made.append(one()))
    thread.start()
    thread.join()
    time.sleep(0.2)  # long enough for a signal that comes with the end of the thread
    check(made[0].is_running, "it ends with the thread that made it")
    child = os.fork()
    if child == 0:
        made[0].close()
        made.clear()
        os._exit(0)
    os.waitpid(child, 0)
    check(made[0].is_running, "a forked child ended it")
    made[0].close()

    fire3dv._process.STOP_S = 0.5
    deaf = script(test, "deaf", "trap '' TERM; " + LISTENING + "exec sleep 1000")
    with fire3dv.Renderer("scene.glb", program=deaf) as renderer:
        pass
    check(not lives(renderer.pid), "it outlives close() by ignoring SIGTERM")
    with fire3dv.Renderer("scene.glb", program=script(test, "mother", "sleep 1000 & echo $!; " + LISTENING + "wait")) as renderer:
        child = int(renderer.log[0])
    wait_end(child)


OWNER = """
import sys, time, fire3dv
renderer = fire3dv.Renderer("scene.glb", program=sys.argv[1])
print(renderer.pid, renderer.instances.path, flush=True)
if sys.argv[2] == "exit": sys.exit(0)
with renderer: time.sleep(1000)
"""


def parent_ends(test):
    """The process ends with its parent: at its exit, by Ctrl-C and by any signal."""
    program = script(test, "renderer", LISTENING + "exec sleep 1000")
    deaf = script(test, "deaf", "trap '' TERM INT HUP; " + LISTENING + "exec sleep 1000")
    cases = [(program, name) for name in ("exit", "SIGINT", "SIGTERM", "SIGHUP", "SIGKILL")] + [(deaf, "SIGKILL")]
    for renderer, name in cases:
        owner = subprocess.Popen([sys.executable, "-c", OWNER, renderer, name], stdout=subprocess.PIPE, text=True,
                                 stderr=subprocess.PIPE, start_new_session=True)
        pid, instances = owner.stdout.readline().split()
        pid, folder = int(pid), os.path.dirname(instances)
        if name != "exit":
            check(lives(pid), f"{name}: it does not run")
            os.killpg(owner.pid, getattr(signal, name))  # as a terminal does
        owner.communicate(timeout=HANG_S)
        wait_end(pid)
        wait_until(f"{folder} to go", lambda: not os.path.exists(folder))


if __name__ == "__main__":
    main({"draws": draws, "readme": readme, "faults": faults, "served": served, "programs": programs, "ends": ends, "parent_ends": parent_ends}, ["fire3dv"])
