"""X display of the tests: a virtual X server, the windows on it, and screenshots.

FIRE3DV_KEEP_SCREENSHOTS=DIR stores the screenshots as PPM.
"""
import os
import subprocess

from harness import HANG_S, vulkan_environment, wait_until
from image_reader import Picture, check
from x11 import X11

SCREEN = (640, 480)
SIZE = (320, 180)


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

    def xdotool(self, *arguments):
        result = subprocess.run(["xdotool", *map(str, arguments)], env=self.env, capture_output=True, text=True,
                                timeout=HANG_S, check=False)
        check(result.returncode == 0, f"xdotool {arguments}: {result.stderr}")
        return result.stdout.strip()

    def windows(self, name="^FIRE-3DV"):
        return subprocess.run(["xdotool", "search", "--onlyvisible", "--name", name], env=self.env,
                              capture_output=True, text=True, timeout=HANG_S, check=False).stdout.split()

    def window(self, program, name="^FIRE-3DV"):
        def look():
            check(program.alive(), f"{program.name} ended:\n{program.stderr_text()}")
            found = self.windows(name)
            return found[0] if found else None
        return wait_until("a window", look)

    def size_of(self, window):
        shell = dict(line.split("=") for line in self.xdotool("getwindowgeometry", "--shell", window).splitlines())
        return int(shell["WIDTH"]), int(shell["HEIGHT"])

    def picture(self, window):
        """Returns a screenshot of the window's area."""
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
