#!/usr/bin/env python3
"""End-to-end test of the window on a virtual display: screenshots, keys and mouse, as the README describes them."""
import os
import time

from harness import main, shown, wait_until
from image_reader import check, place_of
from screen import SIZE, all_squares, on_a_screen

def streams(test, screen):
    """Poses move the shown bodies, through resizes, until Ctrl+Q ends the program normally."""
    uri = test.fresh_uri("shm")
    renderer = test.renderer(headless=False, listen=[uri], size=SIZE, env=screen.env)
    window = screen.window(renderer)
    check(screen.size_of(window) == SIZE, f"the window is {screen.size_of(window)}")
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))
    publisher = test.publisher(uri)
    places = set()
    for step in (1, 7, 5):
        sequence = publisher.do(f"publish {step}")["sequence"]
        place = place_of(sequence)

        def at_place():
            seen = screen.picture(window).place_of_square("red")
            return seen is not None and abs(seen - place) < 0.6
        wait_until(f"red at {place} on the screen", at_place)
        places.add(place)
    check(len(places) == 3, f"{places}")

    publisher.do("stream 60")
    for step in range(50):  # a dragged window border; no wait for an image of each size
        screen.x11.resize(window, 300 + step % 10 * 10, 200 + step * 2)
    for size in ((400, 220), (200, 300), (64, 64), (360, 200)):
        screen.x11.resize(window, *size)
        wait_until(f"a window of {size}", lambda s=size: screen.size_of(window) == s)
        frame = renderer.wait_frame(f"an image of {size}", lambda f, s=size: (f["width"], f["height"]) == s,
                                    len(renderer.frames()) - 1)
        check(shown(frame, "arm"), "the stream was lost")
    wait_until("a picture in the last size", lambda: screen.picture(window).place_of_square("green") is not None)
    screen.move(window, 20, 20)
    screen.key("ctrl+q")
    renderer.expect_exit(0)
    check(publisher.do("status")["calls"] > 13 and publisher.alive(), "the adapter ended with the window")
    publisher.quit()


def mouse(test, screen):
    """Left drag orbits, the wheel zooms, F frames all, 1 returns to the scene's camera."""
    renderer = test.renderer(headless=False, size=SIZE, env=screen.env)
    window = screen.window(renderer)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))

    at_rest = screen.picture(window).rows

    def drag(button):
        screen.press(window, 160, 90, button=button)
        for x in range(165, 185, 5):
            screen.move(window, x, 95)
        screen.release(button)

    def back_at_rest():
        screen.key("1")
        return screen.picture(window).rows == at_rest

    def changes(what, act):
        wait_until(f"the scene's camera again before {what}", back_at_rest)
        act()
        wait_until(f"{what} to change the picture", lambda: screen.picture(window).rows != at_rest)

    changes("a left drag", lambda: drag(1))
    changes("a right drag", lambda: drag(3))
    changes("the wheel", lambda: screen.click(window, 100, 80, button=4))
    screen.key_down("shift")
    changes("a drag with Shift", lambda: drag(1))
    screen.key_up("shift")
    for key in "wasdqe":
        changes(f"the key {key}", lambda k=key: screen.key_down(k))
        screen.key_up(key)
    changes("the key F", lambda: screen.key("f"))
    wait_until("the scene's camera at last", back_at_rest)
    screen.key("ctrl+q")
    renderer.expect_exit(0)


def minimized(test, screen):
    """An invisible window draws nothing, uses no CPU time, and comes back."""
    renderer = test.renderer(headless=False, size=SIZE, env=screen.env)
    window = screen.window(renderer)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))
    screen.x11.set_minimized(window, True)

    def images():
        count = len(renderer.frames())
        time.sleep(0.5)
        return count == len(renderer.frames())
    wait_until("no more images", images)

    def core_seconds():
        with open(f"/proc/{renderer.process.pid}/stat", encoding="ascii") as file:
            user, system = file.read().rsplit(")", 1)[1].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")
    before, seconds = core_seconds(), 2
    time.sleep(seconds)
    used = core_seconds() - before
    check(used < 0.5 * seconds, f"{used} s of a core in {seconds} s while minimised")
    screen.x11.set_minimized(window, False)
    wait_until("all squares again", lambda: all_squares(screen.picture(window)))
    renderer.stop()


def motion_quality(test, screen):
    """On a CPU device images in motion have one sample; images at rest are those of --motion-quality full, byte for byte."""
    size, poses = (311, 173), 4  # edges of squares are between pixels

    def colours(rows):
        return len({bytes(pixel) for row in rows for pixel in zip(*[iter(row)] * 3)})

    def images_of_poses(notes, *options):
        """All images of each pose in turn, the last of which is at rest."""
        uri = test.fresh_uri("shm")
        renderer = test.viewer(test.scene, "--gui", "off", "--fxaa", "off", "--background", "000000", "--listen", uri, *options, env=screen.env, size=size)
        window = screen.window(renderer)
        wait_until("an image", lambda: colours(screen.picture(window).rows) > 1)
        publisher = test.publisher(uri)
        publisher.wait_welcome()
        of_poses = []
        for _ in range(poses):
            sequence, images = publisher.do("publish 1")["sequence"], []
            publisher.wait_status("the pose", lambda s, n=sequence: s["acked"] == n)

            def rests():
                rows = screen.picture(window).rows
                if not images or images[-1] != rows:
                    images.append(rows)
                return colours(rows) > 4  # of background, squares and mixtures at their edges
            wait_until("an image of all samples", rests)
            of_poses.append(images)
        screen.key("ctrl+q")
        renderer.expect_exit(0)
        publisher.quit()
        said = renderer.stderr_text().count("images in motion have 1 sample per pixel and shadows by maps alone")
        check(said == notes, f"it is said {said} times:\n{renderer.stderr_text()}")
        return of_poses
    full, reduced = images_of_poses(0, "--motion-quality", "full"), images_of_poses(1)
    for in_full, in_motion in zip(full, reduced):
        check(in_full[-1] == in_motion[-1], "an image at rest is another one than in full")
    check(any(colours(rows) <= 4 for images in reduced for rows in images), "no image in motion has one sample")


def number_of_images(test, screen):
    renderer = test.renderer("--frames", "5", headless=False, size=SIZE, env=screen.env)
    renderer.expect_exit(0)
    check(len(renderer.frames()) == 5, f"{renderer.frames()}")


def display_gone(test, screen):
    """When the X server dies, the program ends and does not hang."""
    renderer = test.renderer(headless=False, size=SIZE, env=screen.env)
    screen.window(renderer)
    renderer.wait_frame("an image", lambda f: True)
    screen.server.kill()
    check(renderer.wait() != 0, "losing the display is no success")


CASES = {f.__name__: on_a_screen(f) for f in (streams, mouse, minimized, motion_quality, number_of_images, display_gone)}

if __name__ == "__main__":
    main(CASES, ["fire3dv", "publisher"])
