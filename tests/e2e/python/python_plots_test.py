"""End-to-end test of the Plots panel in a window with real X input: a scalar of a stream is chosen, its curve is drawn
where its values are, and the exported file holds them.

python_plots_test.py FIRE3DV [CASE...]
"""
import math
import os

import fire3dv
from harness import main, wait_until
from image_reader import check, ranges_about, write_scene
from screen import on_a_screen

SIZE = (900, 600)
STEPS = 200
ACCENT = (0x4a, 0xa3, 0xdf)  # colour of the first chosen scalar
# Positions in a window of this size in which only the Plots panel is open.
PLOT = ((647, 188), (890, 358))
FIRST_ROW, EXPORT = (680, 409), (735, 372)


def plots(test, screen):
    scene, arrangement, folder = test.path("red.glb"), test.path("config/fire3dv/window.conf"), test.path("taken")
    write_scene(scene, {"red": ((1, 0, 0), 30)}, place=0)
    os.makedirs(os.path.dirname(arrangement))
    with open(arrangement, "w", encoding="ascii") as file:
        for panel in ("scene", "node", "cameras", "frame", "streams", "lights", "materials", "render", "log"):
            file.write(f"{panel} = closed\n")
        file.write("plots = open\n")
    uri = test.fresh_uri("shm")
    renderer = test.viewer(scene, "--listen", uri, "--screenshots", folder, env=screen.env, size=SIZE)
    window = screen.window(renderer)
    times = [step * 10_000_000 for step in range(STEPS + 1)]
    values = [math.sin(2 * math.pi * step / STEPS) for step in range(STEPS + 1)]
    with fire3dv.Stream(uri, adapter_name="pendulum") as stream:
        stream.describe(["red"])
        for time_ns, value in zip(times, values):
            stream.scalars("joints", time_ns, {"hinge": value, "speed": 0.1 * value}, units={"hinge": "rad"})
        stream.publish(times[-1], [fire3dv.pose((0, 0, 0))])

        (left, top), (right, bottom) = PLOT

        def curve():
            """x -> y of the curve's pixels."""
            near = {}
            for y, row in enumerate(screen.picture(window).matches(ranges_about(ACCENT, 24), left, right)[top:bottom], top):
                for x, is_near in enumerate(row, left):
                    if is_near:
                        near.setdefault(x, []).append(y)
            return {x: sum(ys) / len(ys) for x, ys in near.items()}

        def choose():
            screen.click(window, *FIRST_ROW)
            return wait_until("the curve", lambda: (lambda found: len(found) > 100 and found)(curve()))

        wait_until("the stream", lambda: renderer.find_err("pendulum"))
        found = choose()
        height = bottom - top
        for x, y in found.items():
            phase = (x - left) / (right - left)
            expected = top + height * (0.5 - 0.5 / 1.1 * math.sin(2 * math.pi * phase))
            check(abs(y - expected) < 6, f"the curve is at ({x}, {y}), not at {expected:.1f}")
        screen.click(window, *EXPORT)
        path = renderer.wait_err(r"scalars (\S+\.csv)").group(1)
        with open(path, encoding="utf-8", newline="") as file:
            lines = file.read().split("\r\n")
        check(os.path.dirname(path) == folder and lines[0] == 'sim_time_s,"joints/hinge [rad]"', f"{path}: {lines[0]}")
        rows = [tuple(map(float, line.split(","))) for line in lines[1:-1]]
        check(rows == [(time_ns / 1e9, value) for time_ns, value in zip(times, values)], f"{path} has {rows}")
    screen.x11.close(window)
    renderer.expect_exit(0)


if __name__ == "__main__":
    main({"plots": on_a_screen(plots, size=SIZE)}, ["fire3dv"])
