#!/usr/bin/env python3
"""End-to-end test of the check boxes of marker namespaces in the window: each hides and shows its markers."""
import os

import fire3dv
from harness import main, wait_until
from image_reader import write_scene
from screen import on_a_screen

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


if __name__ == "__main__":
    main({"check_boxes": on_a_screen(check_boxes)}, ["fire3dv"])
