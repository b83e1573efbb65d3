"""Runs a tutorial: its commands and files as the Markdown file shows them, then compares its picture with the committed one.

tutorials_test.py [--own-network] TUTORIAL.md BUILD_FOLDER [STAND_IN...]

Every sh block is run, in order, in one folder. A comment before a block, which readers do not see, says otherwise:

    <!-- file: NAME -->              the block is the contents of a file
    <!-- terminal: NAME -->          runs in the background until the tutorial ends, as in a further terminal
    <!-- terminal: NAME, ends -->    the same; it ends by itself, before a picture is compared
    <!-- terminal: NAME, instead: COMMAND -->   COMMAND runs there; STAND_IN are programs that it finds on the PATH
    <!-- prints: TEXT -->            the commands print TEXT
    <!-- not run: REASON -->         is left out
    <!-- picture: FILE -->           the image below shows FILE, which the commands have made

Streams get names of their own, so that tests run side by side. The client library is installed into a folder, where pkg-config
finds it. --own-network: in a network namespace of its own; exit status 77 where that is not permitted. Needs NumPy.
"""
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile

import numpy as np

from harness import HANG_S, vulkan_environment, wait_until
from hosts import SKIPPED, why_not
from image_reader import Failure, check, read_png

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../.."))
BLOCK = re.compile(r"(?:^<!-- ([a-z ]+): (.*?) -->\n+)?^(?:```(\w*)\n(.*?)^```$|!\[[^\]]*\]\(([^)]+)\)$)", re.S | re.M)
MAX_DIFFERENCE = 0.3  # mean of 8-bit values; drivers round differently. A contact arrow that is missing makes 0.53


class Terminal:
    """A shell in a folder. Its output goes to a file."""

    def __init__(self, run, name, commands, ends):
        self.name, self.ends = name, ends
        self.log = os.path.join(run.logs, f"{name}.log")
        with open(self.log, "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(["bash", "-ec", commands], cwd=run.folder, env=run.env, stdin=subprocess.DEVNULL, stdout=log,
                                            stderr=subprocess.STDOUT, start_new_session=True)

    def text(self):
        with open(self.log, encoding="utf-8", errors="replace") as log:
            return log.read()

    def has_ended(self):
        return self.process.poll() is not None

    def has_failed(self):
        return self.process.poll() not in (None, 0)

    def finish(self):
        """Waits for the end, or ends it as Ctrl-C does."""
        if not self.ends and self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGINT)
        try:
            code = self.process.wait(HANG_S)
        except subprocess.TimeoutExpired:
            raise Failure(f"terminal {self.name} does not end:\n{self.text()}") from None
        allowed = (0,) if self.ends else (0, 130, -signal.SIGINT)
        check(code in allowed, f"terminal {self.name} ended with {code}:\n{self.text()}")

    def kill(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()


class Run:
    """A tutorial in a folder of its own."""

    def __init__(self, tutorial, build, stand_ins, folder):
        self.tutorial = tutorial
        self.folder, self.logs, self.client = (os.path.join(folder, name) for name in ("work", "logs", "client"))
        for each in (self.folder, self.logs):
            os.makedirs(each)
        self.stream = f"shm://tutorial-{os.getpid()}-{random.randrange(1 << 32):08x}"
        bin_folder = os.path.join(build, "bin")
        self.env = {**vulkan_environment(), "HOME": folder, "FIRE3DV": os.path.join(bin_folder, "fire3dv"),
                    "PATH": ":".join([bin_folder, *map(os.path.dirname, stand_ins), os.path.dirname(sys.executable), os.environ["PATH"]]),
                    "ROS_DOMAIN_ID": str(1 + os.getpid() % 230), "PKG_CONFIG_PATH": os.path.join(self.client, "lib/pkgconfig")}
        self.build, self.terminals, self.pictures, self.ran = build, [], 0, 0

    def install_client(self):
        subprocess.run(["cmake", "--install", self.build, "--component", "client", "--prefix", self.client], stdout=subprocess.DEVNULL,
                       timeout=HANG_S, check=True)

    def everything(self):
        with open(self.tutorial, encoding="utf-8") as file:
            text = file.read()
        if "pkg-config" in text:
            self.install_client()
        for key, value, language, code, image in BLOCK.findall(text):
            code = code.replace("shm://demo", self.stream)
            if key == "file":
                with open(os.path.join(self.folder, value), "w", encoding="utf-8") as file:
                    file.write(code)
            elif key == "picture":
                self.compare(value, image)
            elif language == "sh" and key in ("", "terminal", "prints"):
                self.shell(code, key, value)
            else:
                check(language != "sh" or key == "not run", f"{self.tutorial}: {key!r} before a block is not known")
        check(self.ran and self.pictures, f"{self.tutorial}: {self.ran} commands, {self.pictures} pictures")
        for terminal in self.terminals:
            terminal.finish()

    def shell(self, commands, key, value):
        self.ran += 1
        if key == "terminal":
            name, _, rest = value.partition(", ")
            instead = rest.partition("instead: ")[2]
            self.terminals.append(Terminal(self, name, instead or commands, rest == "ends"))
            return
        front = Terminal(self, f"front{self.ran}", commands, True)
        self.terminals.append(front)
        wait_until(lambda: f"{commands}to end:\n{self.output()}", lambda: front.has_ended() or any(map(Terminal.has_failed, self.terminals)))
        check(not any(map(Terminal.has_failed, self.terminals)), f"{commands}failed, or a terminal did:\n{self.output()}")
        check(key != "prints" or value in front.text(), f"{commands}did not print {value!r}, but:\n{front.text()}")

    def output(self):
        return "\n".join(f"--- {each.name}, {each.process.poll()}:\n{each.text()}" for each in self.terminals)

    def compare(self, made, committed):
        for terminal in self.terminals:
            if terminal.ends:
                terminal.finish()
        self.pictures += 1
        path = os.path.join(self.folder, made)
        check(os.path.exists(path), f"the commands did not make {made}; there are: {sorted(os.listdir(self.folder))}")
        stored = os.path.normpath(os.path.join(os.path.dirname(self.tutorial), committed))
        kept = os.environ.get("FIRE3DV_KEEP_SCREENSHOTS")
        if kept:
            shutil.copy(path, os.path.join(kept, os.path.basename(stored)))
        check(os.path.exists(stored), f"{stored} is not there: look at {made}, which FIRE3DV_KEEP_SCREENSHOTS=DIR stores, and commit it")
        new, old = pixels(path), pixels(stored)
        check(new.shape == old.shape, f"{made} is {new.shape}, {committed} {old.shape}")
        difference = float(np.abs(new - old).mean())
        check(difference <= MAX_DIFFERENCE, f"{made} differs from {committed} by {difference:.2f} on average")


def pixels(path):
    picture = read_png(path)
    return np.frombuffer(b"".join(bytes(row) for row in picture.rows), np.uint8).reshape(picture.height, picture.width, 3).astype(float)


def main():
    arguments = sys.argv[1:]
    if arguments[0] == "--own-network":
        reason = why_not()
        if reason:
            print(f"skipped: {reason}")
            return SKIPPED
        os.execvp("unshare", ["unshare", "--net", "sh", "-c", 'ip link set lo up && exec "$@"', "sh", sys.executable, __file__,
                              *arguments[1:]])
    tutorial, build, *stand_ins = map(os.path.abspath, arguments)
    with tempfile.TemporaryDirectory(prefix="fire3dv-tutorial-") as folder:
        run = Run(tutorial, build, stand_ins, folder)
        try:
            run.everything()
        except Failure as failure:
            print(f"{os.path.relpath(tutorial, ROOT)}: {failure}", file=sys.stderr)
            return 1
        finally:
            for terminal in run.terminals:
                terminal.kill()
    print(f"{run.ran} commands, {run.pictures} pictures: passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
