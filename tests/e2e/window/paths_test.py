#!/usr/bin/env python3
"""End-to-end test of --render path in a window: the image refines to that of a headless run and then idles, starts again
when something moves, and raster and paths are switched in the render panel."""
import glob
import os

from harness import Program, check, main, vulkan_environment, wait_until
from image_reader import read_png, write_scene
from prometheus import images_of, settled, url_of
from screen import SIZE, on_a_screen

SAMPLES = 24
PATHS = ("--render", "path", "--spp", SAMPLES, "--bounces", 1, "--environment-intensity", 0.3)


def arguments_of(values):
    return [str(value) for value in values]


def take_screenshot(test, screen, renderer, folder):
    """Presses P; returns the new file's picture."""
    before = set(glob.glob(os.path.join(folder, "*.png")))
    screen.key("p")

    def new():
        found = set(glob.glob(os.path.join(folder, "*.png"))) - before
        return found.pop() if found else None
    path = wait_until(lambda: f"a screenshot; it said:\n{renderer.stderr_text()}", new)
    wait_until("the whole screenshot", lambda: f"screenshot {path}" in renderer.stderr_text())
    return read_png(path)


def whole_screenshot(test, screen, renderer, folder):
    def look():
        picture = take_screenshot(test, screen, renderer, folder)
        return picture if picture.text["SamplesPerPixel"] == str(SAMPLES) else None
    return wait_until("a screenshot of all samples", look)


def refines(test, screen):
    """A screenshot of the whole image has the pixels of a headless run; then nothing is drawn until something moves."""
    scene, folder = test.path("sun.glb"), test.path("taken")
    write_scene(scene, sun=True)
    width, height = SIZE
    headless = Program(test, "fire3dv", [test.programs_at["fire3dv"], scene, "--validation", "--headless", "--frames", "1",
                                         "--tone-map", "none", "--ground", "off", "--cache", "off", "--size", f"{width}x{height}",
                                         "--out", test.path("headless"), *arguments_of(PATHS)], env=vulkan_environment())
    check(headless.wait() == 0, headless.stderr_text())
    wanted = read_png(os.path.join(test.path("headless"), "frame_000000.png"))

    uri = test.fresh_uri("shm")
    renderer = test.viewer(scene, "--gui", "off", "--screenshots", folder, "--listen", uri, "--metrics", "127.0.0.1:0",
                           *arguments_of(PATHS), env=screen.env, size=SIZE)
    window = screen.window(renderer)
    screen.move(window, 100, 80)
    url = url_of(renderer)
    picture = whole_screenshot(test, screen, renderer, folder)
    check(picture.rows == wanted.rows, "the refined image differs from the headless one")
    check(picture.text["Bounces"] == "1" and picture.text["Renderer"] == "path", f"{picture.text}")
    drawn = settled(url)

    publisher = test.publisher(uri)
    publisher.wait_welcome()
    publisher.do("publish 5")
    moved = wait_until("the moved squares", lambda: (lambda p: p.rows != wanted.rows and p)(
        whole_screenshot(test, screen, renderer, folder)))
    check(images_of(url) > drawn, "no image of the moved squares")
    publisher.quit()
    again = wait_until("the squares at rest", lambda: (lambda p: p.rows != moved.rows and p)(
        whole_screenshot(test, screen, renderer, folder)))
    check(again.rows == wanted.rows, "the image at rest is another one than before")
    settled(url)
    screen.key("ctrl+q")
    renderer.expect_exit(0)


# Positions in a window of this size, with only the render panel open.
PANELS_SIZE, RENDERER, RASTER, PATHS_ITEM, VIEW = (640, 400), (573, 154), (573, 178), (573, 195), (320, 300)


def switches(test, screen):
    """The render panel switches to the raster and back."""
    scene, folder, arrangement = test.path("sun.glb"), test.path("taken"), test.path("config/fire3dv/window.conf")
    write_scene(scene, sun=True, place=0)
    os.makedirs(os.path.dirname(arrangement))
    with open(arrangement, "w", encoding="ascii") as file:
        for panel in ("scene", "node", "cameras", "frame", "streams", "lights", "materials", "log"):
            file.write(f"{panel} = closed\n")
        file.write("render = open\n")
    renderer = test.viewer(scene, "--screenshots", folder, "--render", "path", "--spp", "3", "--bounces", "0", env=screen.env,
                           size=PANELS_SIZE)
    window = screen.window(renderer)

    def screenshot(samples):
        screen.move(window, *VIEW)

        def look():
            picture = take_screenshot(test, screen, renderer, folder)
            return picture if picture.text.get("SamplesPerPixel") == samples else None
        return wait_until(f"a screenshot of {samples} samples", look)

    def choose(item):
        screen.move(window, *RENDERER)
        closed = screen.picture(window).rows[RASTER[1]:PATHS_ITEM[1]]
        screen.click_here()
        wait_until("the choices", lambda: screen.picture(window).rows[RASTER[1]:PATHS_ITEM[1]] != closed)
        screen.click(window, *item)

    paths = screenshot("3")
    choose(RASTER)
    raster = screenshot(None)
    check(raster.rows != paths.rows, "the raster's image is the paths'")
    choose(PATHS_ITEM)
    check(screenshot("3").rows == paths.rows, "paths show another image after the raster")
    screen.x11.close(window)
    renderer.expect_exit(0)


CASES = {f.__name__: on_a_screen(f) for f in (refines, switches)}

if __name__ == "__main__":
    main(CASES, ["fire3dv", "publisher"])
