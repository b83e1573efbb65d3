#!/usr/bin/env python3
"""End-to-end test of markers in the window: check boxes of namespaces hide and show them, clicks go through them."""
import os

import fire3dv
from glb_edit import edit_glb
from harness import main, wait_until
from image_reader import HALF_SQUARE, SQUARES, check, ranges_of, write_scene
from screen import OUTLINE, on_a_screen

SIZE = (640, 480)
# Check boxes of the namespaces in a window of this size with only the streams panel open, in order of their names.
CHECKS = {"left": (611, 214), "right": (611, 237)}
COLOURS = {"left": (255, 0, 255), "right": (0, 255, 255)}


def shown_in(picture):
    """Names of the markers whose colour the picture has; colours of markers are shown as they are."""
    return {name for name, colour in COLOURS.items()
            if any(bytes(colour) in row and colour in zip(*[iter(row)] * 3) for row in picture.rows)}


def check_boxes(test, screen):
    scene, arrangement, uri = test.path("squares.glb"), test.path("config/fire3dv/window.conf"), test.fresh_uri("shm")
    write_scene(scene)
    os.makedirs(os.path.dirname(arrangement))
    with open(arrangement, "w", encoding="ascii") as file:
        for panel in ("scene", "node", "cameras", "frame", "materials", "lights", "render", "log"):
            file.write(f"{panel} = closed\n")
        file.write("streams = open\n")
    renderer = test.viewer(scene, "--listen", uri, "--camera", "front", env=screen.env, size=SIZE)
    window = screen.window(renderer)
    with fire3dv.Stream(uri, adapter_name="simulator") as stream:
        stream.describe([])
        for name, x in (("left", -15), ("right", 15)):
            stream.points(f"{name}/point", [[x, 0, 0]], colors=tuple(c / 255 for c in COLOURS[name]), size_px=16, overlaid=True)
        stream.publish(0, [])
        wait_until("both markers", lambda: stream.poll() and shown_in(screen.picture(window)) == {"left", "right"})
        for name, others in (("left", {"right"}), ("right", set()), ("left", {"left"}), ("right", {"left", "right"})):
            screen.click(window, *CHECKS[name])
            wait_until(f"markers {others} after a click at {name}", lambda o=others: shown_in(screen.picture(window)) == o)
    screen.x11.close(window)
    renderer.expect_exit(0)


def clicks(test, screen):
    """Clicks on markers and on points of a file select the body behind them, or nothing, and never end the program."""
    scene, uri, columns = test.path("points.glb"), test.fresh_uri("shm"), (200, 220)

    def as_points(document, binary):
        green = next(node for node in document["nodes"] if node["name"] == "green")
        document["meshes"][green["mesh"]]["primitives"][0]["mode"] = 0
        return binary
    write_scene(test.path("plain.glb"), place=0)
    edit_glb(test.path("plain.glb"), scene, as_points)
    renderer = test.viewer(scene, "--listen", uri, "--samples", "1", "--fxaa", "off", "--camera", "front", env=screen.env, size=SIZE)
    window = screen.window(renderer)

    def is_outlined():
        check(renderer.alive(), f"a click ended the program:\n{renderer.stderr_text()}")
        return any(OUTLINE in row for row in screen.picture(window).columns(*columns).rows)
    red = wait_until("the red square", lambda: screen.picture(window).box_of(ranges_of("red"), columns[0], sum(columns)))
    pixels = (red[2] - red[0] + 1) / (2 * HALF_SQUARE)  # of a metre
    at, row = ((red[0] + red[2]) // 2, (red[1] + red[3]) // 2), SQUARES["red"][1]
    away = 1.6 * HALF_SQUARE
    beside = round(at[0] + away * pixels), at[1]
    with fire3dv.Stream(uri, adapter_name="simulator") as stream:
        stream.describe([])
        stream.points("points", [[0, row, 1], [away, row, 1]], colors=(1, 0, 1), size_px=10, overlaid=True)
        stream.publish(0, [])
        for place in (at, beside):
            wait_until(f"a marker at {place}", lambda p=place: stream.poll() and screen.picture(window).pixel(*p) == (255, 0, 255))
        screen.click(window, *at)
        wait_until("an outline of the square behind the marker", is_outlined)
        screen.click(window, *beside)
        wait_until("no outline: nothing is behind the marker", lambda: not is_outlined())
        low = at[1] + round((row - SQUARES["green"][1]) * pixels)
        for x in (-1, 1):
            for y in (-1, 1):  # on the points of the file: corners of the square
                screen.click(window, round(at[0] + x * HALF_SQUARE * pixels), round(low + y * HALF_SQUARE * pixels))
        screen.click(window, *at)
        wait_until("the outline again", is_outlined)
    screen.key("ctrl+q")
    renderer.expect_exit(0)


if __name__ == "__main__":
    main({"check_boxes": on_a_screen(check_boxes), "clicks": on_a_screen(clicks)}, ["fire3dv"])
