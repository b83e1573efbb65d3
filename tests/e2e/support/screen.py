"""X display of the tests: a virtual X server, the windows on it, and screenshots.

FIRE3DV_KEEP_SCREENSHOTS=DIR stores the screenshots as PPM.
"""
import os
import subprocess
import time

from harness import vulkan_environment, wait_until
from image_reader import Picture, check, ranges_about
from x11 import X11

PRESS_PAUSE_S = 1  # longer than an image of a slow CPU device

SCREEN = (640, 480)
SIZE = (320, 180)


OUTLINE = bytes((255, 140, 13))  # colour of the outline of selected objects


class Screen:
    """Xvfb on the first free display number. dpi: of a desktop's settings; 192 makes a content scale of 2."""

    def __init__(self, test, size=SCREEN, dpi=96):
        read, write = os.pipe()
        os.set_inheritable(write, True)
        self.log = open(test.path("xvfb.log"), "wb")
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", f"{size[0]}x{size[1]}x24",
                                        "-nolisten", "tcp", "-noreset"], pass_fds=[write], stderr=self.log)
        os.close(write)
        with os.fdopen(read) as pipe:
            number = pipe.readline().strip()
        check(number.isdigit(), f"Xvfb does not start: {open(test.path('xvfb.log')).read()}")
        self.display = f":{number}"
        self.env = {**vulkan_environment(), "DISPLAY": self.display, "XDG_CONFIG_HOME": test.path("config"),
                    "XDG_STATE_HOME": test.path("state")}
        self.env.pop("WAYLAND_DISPLAY", None)
        self.x11 = X11(self.display)
        self.x11.set_dpi(dpi)

    def end(self):
        if self.server.poll() is None:  # libX11 ends a process whose server is gone
            self.x11.end()
        self.server.terminate()
        self.server.wait()
        self.log.close()

    def window(self, program, name="^FIRE-3DV"):
        def look():
            check(program.alive(), f"{program.name} ended:\n{program.stderr_text()}")
            found = self.windows(name)
            return found[0] if found else None
        return wait_until("a window", look)

    def windows(self, name="^FIRE-3DV"):
        return self.x11.windows(name)

    def size_of(self, window):
        return self.x11.area(window)[2:]

    def picture(self, window):
        """Returns a screenshot of the window's area."""
        x, y, width, height = self.x11.area(window)
        rows = self.x11.pixels(x, y, width, height)
        keep(width, height, rows)
        return Picture(width, height, rows)

    def wait_outline(self, window, columns):
        """Waits for the outline of a selection; returns the image of these columns (first, count), which rests. Panels beside
        it count frames: they change all the time."""
        def outlined():
            image = self.picture(window).columns(*columns)
            return any(OUTLINE in row for row in image.rows) and image

        image = wait_until("an outline", outlined)
        while True:
            time.sleep(0.4)  # several images
            following = self.picture(window).columns(*columns)
            if following.rows == image.rows:
                return image
            image = following

    def key(self, *chords):
        """Presses and releases each chord, such as "h" or "ctrl+shift+s"; the window under the pointer gets them."""
        for chord in chords:
            names = chord.split("+")
            for name in names:
                self.x11.key(name, True)
            for name in reversed(names):
                self.x11.key(name, False)

    def key_down(self, name):
        self.x11.key(name, True)

    def key_up(self, name):
        self.x11.key(name, False)

    def move(self, window, x, y):
        """Moves the pointer to this position in the window."""
        self.x11.move(window, x, y)

    def click(self, window, x, y, button=1):
        self.press(window, x, y, button)
        self.release(button)

    def click_here(self, button=1):
        self.x11.button(button, True)
        self.x11.button(button, False)

    def press(self, window, x, y, button=1):
        self.x11.move(window, x, y)
        self.x11.button(button, True)

    def press_here(self, button=1):
        """Presses a button before a drag. A hand is slower than an image: a panel or handle under the pointer gets the
        press only if it is drawn between the motion, the press and the drag."""
        time.sleep(PRESS_PAUSE_S)
        self.x11.button(button, True)
        time.sleep(PRESS_PAUSE_S)

    def release(self, button=1):
        self.x11.button(button, False)


def keep(width, height, rows, seen=[]):
    folder = os.environ.get("FIRE3DV_KEEP_SCREENSHOTS")
    if folder:
        seen.append(width)
        with open(os.path.join(folder, f"screen{len(seen):03}.ppm"), "wb") as file:
            file.write(b"P6 %d %d 255\n" % (width, height) + b"".join(rows))


def on_a_screen(body, **options):
    def run(test):
        screen = Screen(test, **options)
        try:
            body(test, screen)
            for program in test.programs:  # before the server ends: a lost display is an error
                if program.alive():
                    program.kill()
        finally:
            screen.end()
    return run


def all_squares(picture):
    return all(picture.place_of_square(name) is not None for name in ("red", "green", "blue"))


ACCENT = (0x4a, 0xa3, 0xdf)  # of the theme, in which grabs of sliders are drawn


def grabs(picture):
    """Centres of the slider grabs in the left column, from the top."""
    found = []
    for y, row in enumerate(picture.matches(ranges_about(ACCENT, 12), 100, 250)):
        if row.count(1) < 4:
            continue
        if found and y - found[-1][1] < 8:
            found[-1][1] = y
        else:
            found.append([100 + (row.find(1) + row.rfind(1)) // 2, y])
    return [(x, y - 5) for x, y in found]
