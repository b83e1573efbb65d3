"""End-to-end test of markers: the example of docs/markers.md is shown, recorded and replayed, and requested images have
those that they ask for.

python_markers_test.py FIRE3DV [CASE...]
"""
import os
import subprocess
import sys

import numpy

import fire3dv
from harness import HANG_S, main, shown
from image_reader import SIZE, check, write_scene
from readme_commands import code_blocks

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../.."))
CAMERA = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 50]  # of the test scene: a unit at z = 0 is a pixel
MAGENTA = (255, 0, 255)


def at(picture, x, y):
    """Colour at a place of the scene's plane z = 0, which has its origin at the corner of four pixels."""
    row, column = SIZE[1] // 2 - 1 - y, SIZE[0] // 2 + x
    return tuple(picture.rows[row][3 * column:3 * column + 3])


def raised(text, call):
    try:
        call()
    except fire3dv.ArgumentError as error:
        check(text in str(error), f"{text!r} is not in: {error}")
        return
    raise AssertionError(f"nothing was raised, expected: {text}")


def shows(test):
    """Shown in the program's own images, not in requested ones; recorded, counted and replayed."""
    uri, path = test.fresh_uri("tcp"), test.path("markers.mcap")
    renderer = test.renderer("--lockstep", "--exit-when-done", "--record", path, "--fxaa", "off", listen=[uri])
    with fire3dv.Stream(renderer.uris()[0], adapter_name="arm") as stream:
        stream.describe(["red"])
        stream.points("a/point", [[-30.5, -20.5, 0]], colors=(1, 0, 1), size_px=9)
        stream.boxes("a/box", [[0, 0, 0]], sizes=10, colors=(1, 1, 0), parent="red")
        quarters = numpy.array([[[200, 40, 40], [40, 200, 40]], [[40, 40, 200], [90, 90, 90]]], numpy.uint8)
        stream.image("a/image", quarters, size_m=(8, 6), position=(30, 25, 0))  # 4 x 3 pixels for each of its own

        def publish(sim_time_ns, x):
            sequence = stream.publish(sim_time_ns, [fire3dv.pose((x, 0, 0))])
            check(stream.wait_ack(sequence, int(1000 * HANG_S)), f"frame {sequence} was not shown")
            return renderer.wait_frame(f"frame {sequence}", lambda f: shown(f, "arm") and shown(f, "arm")["sequence"] == sequence)

        first = renderer.picture(publish(0, 10))
        check(at(first, -31, -21) == MAGENTA and at(first, -28, -21) == MAGENTA, f"no point: {at(first, -31, -21)}")
        check(at(first, -37, -21) != MAGENTA, "the point is larger than 9 pixels")
        corners = [at(first, x, y) for y in (26, 23) for x in (27, 32)]
        check(corners == [tuple(color) for color in quarters.reshape(-1, 3).tolist()], f"the image shows {corners}")
        yellow = at(first, 10, -2)
        check(yellow[0] > 240 and yellow[1] > 240 and yellow[2] < 10, f"no box at its parent: {yellow}")
        with stream.request_image(*SIZE, parent_from_camera=CAMERA, fx=50).wait(HANG_S) as image:
            check(not (image.color[..., :3] == MAGENTA).all(axis=-1).any(), "a requested image has markers")
        request = {"parent_from_camera": CAMERA, "fx": 50, "outputs": ("color", "depth", "instance")}
        plain = stream.request_image(*SIZE, **request).wait(HANG_S)
        marked = stream.request_image(*SIZE, markers=True, **request).wait(HANG_S)
        check((marked.color[..., :3] == MAGENTA).all(axis=-1).sum() > 40, "an image that asks for markers has none")
        check((marked.depth == plain.depth).all() and (marked.instance == plain.instance).all(), "depth has markers")
        check(not (plain.color == marked.color).all(), "an image that does not ask has markers")
        plain.close()
        marked.close()
        stream.clear_marker("a/point")
        stream.lines("a/line", [[-40, 20.5, 0], [-20, 20.5, 0]], colors=(1, 0, 1), width_px=3, lifetime_s=1)
        second = renderer.picture(publish(500_000_000, 20))
        check(at(second, -31, -21) != MAGENTA, "a cleared marker is shown")
        check(at(second, -30, 20) == MAGENTA, "no line")
        check(at(second, 20, -2) == yellow and at(second, 10, -2) != yellow, "the box does not follow its parent")
        third = renderer.picture(publish(1_500_000_000, 20))
        check(at(third, -30, 20) != MAGENTA, "the line has outlived its lifetime")
    renderer.expect_exit()
    check(not [line for line in renderer.err if "warning" in line and "marker" in line], renderer.stderr_text())

    again = test.renderer("--step", "--exit-when-done", "--fxaa", "off", "--replay", path)
    again.expect_exit()
    replayed = {shown(f, "arm")["sequence"]: again.picture(f).rows for f in again.frames() if shown(f, "arm")}
    check([replayed[s] == p.rows for s, p in enumerate((first, second, third), 1)] == [True] * 3, "the replay differs")
    hidden = test.renderer("--step", "--exit-when-done", "--fxaa", "off", "--markers", "off", "--replay", path)
    hidden.expect_exit()
    check(all(at(hidden.picture(f), -31, -21) != MAGENTA for f in hidden.frames()), "--markers off shows them")
    for mode in ("on", "all"):
        data = test.renderer("--step", "--exit-when-done", "--fxaa", "off", "--markers", mode, "--outputs", "color,depth",
                             "--replay", path)
        data.expect_exit()
        picture = data.picture(next(f for f in data.frames() if shown(f, "arm") and shown(f, "arm")["sequence"] == 1))
        check((at(picture, -31, -21) == MAGENTA) == (mode == "all"), f"a data set with --markers {mode}")


def example(test):
    """The example of docs/markers.md."""
    with open(os.path.join(ROOT, "docs/markers.md"), encoding="utf-8") as file:
        snippet = code_blocks(file.read(), "python")[0]
    uri = test.fresh_uri("shm")
    check(snippet.count("shm://demo") == 1, snippet)
    write_scene(test.path("foot.glb"), squares={"foot": ((1, 0, 0), 30)}, place=0)
    renderer = test.renderer("--fxaa", "off", scene=test.path("foot.glb"), listen=[uri])
    renderer.uris()
    process = subprocess.Popen([sys.executable, "-W", "error", "-c", snippet.replace("shm://demo", uri)],
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        frame = renderer.wait_frame("the example's frame", lambda f: shown(f, "walker"))
        rows = b"".join(renderer.picture(frame).rows)
        colours = {rows[i:i + 3] for i in range(0, len(rows), 3)}
        check(len(colours) > 15, f"only {len(colours)} colours: the cloud, a few pixels here, is missing")
        text, _ = process.communicate("\n", timeout=HANG_S)
    finally:
        process.kill()
    check(process.returncode == 0, text)
    check(not renderer.find_err("is not shown"), renderer.stderr_text())
    renderer.stop()


def arguments(test):
    """Colours and arrays in their forms; errors that name the argument."""
    with fire3dv.Stream(test.fresh_uri("shm")) as stream:
        cloud = numpy.zeros((3, 3), numpy.float32)
        stream.points("a", cloud, numpy.zeros((3, 4), numpy.uint8))
        stream.points("a", cloud, numpy.zeros((3, 3)), size_m=0.1)
        stream.points("a", [[0, 0, 0]], [(1, 0, 0)])
        stream.points("a", cloud, (1, 0, 0, 0.5), parent="x", lifetime_s=0.5, overlaid=True)
        stream.arrows("a", cloud, cloud + 1, colors=numpy.zeros((3, 3)))
        stream.arrows("a", [[0, 0, 0]], [[0, 0, 1]], colors=[(0, 0, 1)])
        stream.arrows("a", cloud, cloud + 1, colors=(1, 0, 0))
        stream.arrows("a", [[0, 0, 0]] * 2, [[0, 0, 1]] * 2, colors=[(0, 0, 1), (1, 0, 0)])
        stream.lines("a", numpy.zeros((4, 2, 3), numpy.float32), width_m=0.1)
        stream.axes("a", cloud, sizes=numpy.ones((3, 3), numpy.float32))
        stream.spheres("a", cloud, 0.5)
        stream.cylinders("a", cloud, [1, 1, 2], rotations=[0, 0, 0, 1])
        stream.capsules("a", cloud, [1, 1, 2])
        stream.triangles("a", cloud, parent_from_marker=numpy.eye(4))
        stream.text("a", "one", [[0, 0, 0]], (1, 0, 0), size_m=0.1)
        stream.text("a", ["one", "K\u00f6rper\n2", ""], cloud, numpy.zeros((3, 4), numpy.uint8), overlaid=True)
        stream.text("a", [], [])
        stream.image("a", numpy.zeros((4, 6), numpy.uint8))
        stream.image("a", numpy.zeros((4, 6, 1), numpy.uint8), 0.5, rotation=(0, 0, 0, 1), parent="x", overlaid=True)
        stream.image("a", numpy.zeros((8, 12, 4), numpy.uint8)[::2, ::2], size_m=(1, 2), position=numpy.zeros(3))
        stream.image("a", memoryview(bytes(24)).cast("B", (2, 4, 3)), lifetime_s=1)
        stream.image("a", numpy.zeros((1024, 1024, 4), numpy.uint8))
        stream.clear_marker("a")
        stream.clear_marker("never set")
        raised("size_px and size_m", lambda: stream.points("a", cloud, size_px=1, size_m=1))
        raised("colors has the shape (3, 2)", lambda: stream.points("a", cloud, numpy.zeros((3, 2))))
        raised("between 0 and 1", lambda: stream.points("a", cloud, numpy.full((3, 3), 255.0)))
        raised("3 or 4 numbers from 0 to 1", lambda: stream.points("a", cloud, (255, 0, 0)))
        raised("2 vectors for 3 starts", lambda: stream.arrows("a", cloud, cloud[:2]))
        raised("positions has the shape (3, 2)", lambda: stream.points("a", cloud[:, :2]))
        raised("lifetime_s", lambda: stream.points("a", cloud, lifetime_s=-1))
        raised("control character", lambda: stream.points("a\nb", cloud))
        raised("2000 x 4 pixels; 1 to 1024", lambda: stream.image("a", numpy.zeros((4, 2000), numpy.uint8)))
        raised("0 x 4 pixels", lambda: stream.image("a", numpy.zeros((4, 0, 3), numpy.uint8)))
        raised("the shape (4, 6, 2)", lambda: stream.image("a", numpy.zeros((4, 6, 2), numpy.uint8)))
        raised("the format 'd'", lambda: stream.image("a", numpy.zeros((4, 6))))
        raised("pixels must be an array of uint8", lambda: stream.image("a", [[1, 2], [3, 4]]))
        raised("the shape (24,)", lambda: stream.image("a", bytes(24)))
        raised("size_m has 3 numbers", lambda: stream.image("a", numpy.zeros((4, 6), numpy.uint8), (1, 1, 1)))
        raised("sizes[0][0] is nan", lambda: stream.image("a", numpy.zeros((4, 6), numpy.uint8), float("nan")))
        raised("sizes[0][1] is -1", lambda: stream.image("a", numpy.zeros((4, 6), numpy.uint8), (1, -1)))
        raised("points have no image", lambda: stream.set_marker("a", 0, cloud, pixels=numpy.zeros((4, 6), numpy.uint8)))
        raised("image has 0 x 0 pixels", lambda: stream.set_marker("a", 11, cloud, sizes=1.0))
        stream.describe([])
        raised("markers", lambda: stream.request_image(4, 4, fx=1, outputs=("depth",), markers=True))
        raised("markers", lambda: stream.request_image(4, 4, fx=1, outputs=("color", "linear"), markers=True))
        raised("texts has 2 elements for 3 positions", lambda: stream.text("a", ["x", "y"], cloud))
        raised("texts[1] has a control character at byte 1", lambda: stream.text("a", ["x", "y\t", "z"], cloud))
        raised("texts[0] has 1025 bytes", lambda: stream.text("a", "x" * 1025, [[0, 0, 0]]))
        raised("texts[0] is not Unicode text", lambda: stream.text("a", "\ud800", [[0, 0, 0]]))
        raised("texts[1] is of type int", lambda: stream.text("a", ["x", 1], cloud[:2]))
        raised("texts[0] holds a NUL", lambda: stream.text("a", "a\0b", [[0, 0, 0]]))


if __name__ == "__main__":
    main({"shows": shows, "example": example, "arguments": arguments}, ["fire3dv"])
