#!/usr/bin/env python3
"""End-to-end test of Vulkan errors in the viewer: a lost surface is recreated, a lost device ends the program with a
message, out of memory during a drop leaves the shown scene, and out of memory for paths is an error.
"""
import os

from harness import HANG_S, Program, main, wait_until
from image_reader import check, write_scene
from screen import SIZE, all_squares, on_a_screen


def environment(test, screen, what, at="4"):
    return {**screen.env, "LD_PRELOAD": os.path.abspath(test.programs_at["lose"]), "LOSE": what, "LOSE_AT": at}


def surface(test, screen):
    renderer = test.renderer(headless=False, size=SIZE, env=environment(test, screen, "surface"))
    window = screen.window(renderer)
    wait_until("images after that", lambda: renderer.alive() and len(renderer.frames()) > 8)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))
    renderer.stop()


def device(test, screen):
    renderer = test.renderer(headless=False, size=SIZE, env=environment(test, screen, "device"))
    check(renderer.wait() == 1, f"it ended with {renderer.process.returncode}:\n{renderer.stderr_text()}")
    check(renderer.find_err(r"device lost.*start it again"), renderer.stderr_text())


def memory(test, screen):
    other, full = test.path("other.glb"), test.path("full")
    # Many invisible squares make the vertex buffer larger than any other buffer.
    write_scene(other, {"red": ((1, 0, 0), 30), **{f"far {i}": ((0, 1, 0), 100_000 + 100 * i) for i in range(3000)}})
    corners = 12 * 4 * 3001

    def lose(times):
        with open(full + ".new", "w", encoding="ascii") as file:
            file.write(f"{corners} {corners + 64} {times}")
        os.rename(full + ".new", full)

    def shows_red_alone():
        picture = screen.picture(window)
        return picture.place_of_square("red") is not None and not all_squares(picture)

    renderer = test.viewer(test.scene, "--gui", "off", size=SIZE, env=environment(test, screen, "memory", full))
    window = screen.window(renderer)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))
    lose(0)
    screen.x11.drop(window, other, HANG_S)
    renderer.wait_err(r"other\.glb: the device has no memory for it; the previous scene is shown again")
    wait_until("all squares again", lambda: all_squares(screen.picture(window)))
    os.remove(full)
    # One failure: memory is available once the shown scene is released.
    lose(1)
    screen.x11.drop(window, other, HANG_S)
    wait_until("red alone", shows_red_alone)
    check(not os.path.exists(full), "nothing was lost")
    screen.x11.close(window)
    renderer.expect_exit(0)


def paths(test, screen):
    """Without memory for the sums of its paths a run ends with the reason."""
    full, (width, height) = test.path("full"), (61, 47)
    sums = 32 * width * height  # no other buffer has this size
    with open(full, "w", encoding="ascii") as file:
        file.write(f"{sums} {sums} 0")
    program = Program(test, "fire3dv", [test.programs_at["fire3dv"], test.scene, "--headless", "--frames", "1", "--cache", "off",
                                        "--size", f"{width}x{height}", "--render", "path", "--spp", "1", "--out", test.path("out")],
                      environment(test, screen, "memory", full))
    check(program.wait() == 1 and program.find_err("error: the device has no memory for images of 61x47"), program.stderr_text())
    os.remove(full)
    program = Program(test, "fire3dv", program.process.args, environment(test, screen, "memory", full))
    check(program.wait() == 0, program.stderr_text())


CASES = {f.__name__: on_a_screen(f) for f in (surface, device, memory, paths)}

if __name__ == "__main__":
    main(CASES, ["fire3dv", "lose"], plain_images=True)
