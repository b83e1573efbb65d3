#!/usr/bin/env python3
"""The window, on a display of our own: what it shows is seen by a screenshot, and keys and mouse do what README says.

FIRE3DV_KEEP_SCREENSHOTS=DIR keeps what was seen there, as PPM.
"""
import os
import subprocess

from harness import HANG_S, main, shown, vulkan_environment, wait_until
from pictures import Picture, check, place_of

SCREEN = (640, 480)
SIZE = (320, 180)


class Screen:
    """An X server without a screen. It takes the first display number that is free."""

    def __init__(self, test):
        read, write = os.pipe()
        os.set_inheritable(write, True)
        self.log = open(test.path("xvfb.log"), "wb")
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", f"{SCREEN[0]}x{SCREEN[1]}x24",
                                        "-nolisten", "tcp", "-noreset"], pass_fds=[write], stderr=self.log)
        os.close(write)
        with os.fdopen(read) as pipe:
            number = pipe.readline().strip()
        check(number.isdigit(), f"Xvfb does not start: {open(test.path('xvfb.log')).read()}")
        self.display = f":{number}"
        self.env = {**vulkan_environment(), "DISPLAY": self.display}
        self.env.pop("WAYLAND_DISPLAY", None)

    def end(self):
        self.server.terminate()
        self.server.wait()
        self.log.close()

    def xdotool(self, *arguments):
        result = subprocess.run(["xdotool", *map(str, arguments)], env=self.env, capture_output=True, text=True,
                                timeout=HANG_S, check=False)
        check(result.returncode == 0, f"xdotool {arguments}: {result.stderr}")
        return result.stdout.strip()

    def window(self, program):
        def look():
            check(program.alive(), f"{program.name} ended:\n{program.stderr_text()}")
            found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", "^FIRE-3DV"], env=self.env,
                                   capture_output=True, text=True, timeout=HANG_S, check=False).stdout.split()
            return found[0] if found else None
        return wait_until("a window", look)

    def size_of(self, window):
        shell = dict(line.split("=") for line in self.xdotool("getwindowgeometry", "--shell", window).splitlines())
        return int(shell["WIDTH"]), int(shell["HEIGHT"])

    def picture(self, window):
        """What the screen shows where the window is."""
        shell = dict(line.split("=") for line in self.xdotool("getwindowgeometry", "--shell", window).splitlines())
        x, y, width, height = (int(shell[key]) for key in ("X", "Y", "WIDTH", "HEIGHT"))
        grab = subprocess.run(["ffmpeg", "-nostdin", "-v", "error", "-f", "x11grab", "-draw_mouse", "0", "-video_size",
                               f"{width}x{height}", "-i", f"{self.display}+{x},{y}", "-frames:v", "1", "-f", "rawvideo",
                               "-pix_fmt", "rgb24", "-"], capture_output=True, timeout=HANG_S, check=False, env=self.env)
        check(len(grab.stdout) == 3 * width * height, f"no screenshot: {grab.stderr.decode()}")
        keep(width, height, grab.stdout)
        return Picture(width, height, [grab.stdout[3 * width * y:3 * width * (y + 1)] for y in range(height)])


def keep(width, height, data, seen=[]):
    folder = os.environ.get("FIRE3DV_KEEP_SCREENSHOTS")
    if folder:
        seen.append(width)
        with open(os.path.join(folder, f"screen{len(seen):03}.ppm"), "wb") as file:
            file.write(b"P6 %d %d 255\n" % (width, height) + data)


def on_a_screen(body):
    def run(test):
        screen = Screen(test)
        try:
            body(test, screen)
            for program in test.programs:  # before the screen goes: losing it is an error of its own
                if program.alive():
                    program.kill()
        finally:
            screen.end()
    return run


def all_squares(picture):
    return all(picture.place_of_square(name) is not None for name in ("red", "green", "blue"))


def streams(test, screen):
    """Poses move what the window shows, through resizes, until Escape ends it in order."""
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
    for size in ((400, 220), (200, 300), (64, 64), (360, 200)):
        screen.xdotool("windowsize", window, *size)
        wait_until(f"a window of {size}", lambda s=size: screen.size_of(window) == s)
        frame = renderer.wait_frame(f"an image of {size}", lambda f, s=size: (f["width"], f["height"]) == s,
                                    len(renderer.frames()) - 1)
        check(shown(frame, "arm"), "the stream was lost")
    wait_until("a picture in the last size", lambda: screen.picture(window).place_of_square("green") is not None)
    screen.xdotool("key", "--window", window, "Escape")
    renderer.expect_exit(0)
    check(publisher.do("status")["calls"] > 13 and publisher.alive(), "the adapter ended with the window")
    publisher.quit()


def mouse(test, screen):
    """Left drag orbits, the wheel zooms, F frames all, 1 goes back to the scene's camera."""
    renderer = test.renderer(headless=False, size=SIZE, env=screen.env)
    window = screen.window(renderer)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))

    at_rest = screen.picture(window).rows

    def drag(button):
        screen.xdotool("mousemove", "--window", window, 160, 90, "mousedown", button)
        for x in range(165, 185, 5):
            screen.xdotool("mousemove", "--window", window, x, 95)
        screen.xdotool("mouseup", button)

    def back_at_rest():
        screen.xdotool("key", "1")
        return screen.picture(window).rows == at_rest

    def changes(what, act):
        wait_until(f"the scene's camera again before {what}", back_at_rest)
        act()
        wait_until(f"{what} to change the picture", lambda: screen.picture(window).rows != at_rest)

    changes("a left drag", lambda: drag(1))
    changes("a right drag", lambda: drag(3))
    changes("the wheel", lambda: screen.xdotool("mousemove", "--window", window, 100, 80, "click", 4))
    screen.xdotool("keydown", "shift")
    changes("a drag with Shift", lambda: drag(1))
    screen.xdotool("keyup", "shift")
    for key in "wasdqe":
        changes(f"the key {key}", lambda k=key: screen.xdotool("keydown", k))
        screen.xdotool("keyup", key)
    changes("the key F", lambda: screen.xdotool("key", "f"))
    wait_until("the scene's camera at last", back_at_rest)
    screen.xdotool("key", "Escape")
    renderer.expect_exit(0)


def number_of_images(test, screen):
    renderer = test.renderer("--frames", "5", headless=False, size=SIZE, env=screen.env)
    renderer.expect_exit(0)
    check(len(renderer.frames()) == 5, f"{renderer.frames()}")


def display_gone(test, screen):
    """The X server dies: the program ends, it does not hang."""
    renderer = test.renderer(headless=False, size=SIZE, env=screen.env)
    screen.window(renderer)
    renderer.wait_frame("an image", lambda f: True)
    screen.server.kill()
    check(renderer.wait() != 0, "losing the display is no success")


CASES = {f.__name__: on_a_screen(f) for f in (streams, mouse, number_of_images, display_gone)}

if __name__ == "__main__":
    main(CASES, ["fire3dv", "publisher"])
