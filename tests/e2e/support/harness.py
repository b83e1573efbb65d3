"""Harness of the end-to-end tests: the programs as objects, and a test object that ends them in every case.

No helper asserts a time. HANG_S limits the wait for an event that must come; it is far above the usual time.
"""
import contextlib
import glob
import json
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

from image_reader import SIZE, Failure, check, read_png, write_scene

HANG_S = 240
PLAIN_IMAGES = ("--shadows", "off", "--samples", "1")  # a third less work, where shadows and edges do not count
TRANSPORTS = ("shm", "tcp", "udp")


def wait_until(what, predicate, hang_s=HANG_S):
    """Polls until predicate() is true and returns its value."""
    end = time.monotonic() + hang_s
    while True:
        value = predicate()
        if value:
            return value
        check(time.monotonic() < end, f"waited {hang_s} s in vain for: {what() if callable(what) else what}")
        time.sleep(0.02)


def vulkan_environment():
    env = dict(os.environ)
    if "VK_DRIVER_FILES" not in env:
        drivers = ":".join(glob.glob("/usr/share/vulkan/icd.d/lvp_icd*.json"))
        check(drivers, "lavapipe is not installed: run tools/setup.sh")
        env["VK_DRIVER_FILES"] = env["VK_ICD_FILENAMES"] = drivers
    return env


class Program:
    """Child process whose output is read by threads, so that it never blocks on a full pipe."""

    def __init__(self, test, name, command, env=None, host=None, cwd=None):
        """host: network namespace to run in (hosts.py); None: this one. cwd: its working folder; None: this one's."""
        self.name, self.err, self.out = name, [], []
        self.command = command = [*(host.enter if host else []), *command]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        text=True, errors="replace", env=env, cwd=cwd)
        self.readers = [threading.Thread(target=self._read, args=pair, daemon=True)
                        for pair in ((self.process.stdout, self.out), (self.process.stderr, self.err))]
        for reader in self.readers:
            reader.start()
        test.programs.append(self)

    @staticmethod
    def _read(pipe, lines):
        for line in pipe:
            lines.append(line.rstrip("\n"))

    def alive(self):
        return self.process.poll() is None

    def signal(self, number):
        self.process.send_signal(number)

    def kill(self):
        self.process.kill()
        self.process.wait()

    def stderr_text(self):
        return "\n".join(self.err)

    def find_err(self, pattern):
        return next((m for m in (re.search(pattern, line) for line in list(self.err)) if m), None)

    def wait_err(self, pattern):
        """Returns the first line of stderr that matches the pattern; fails if none comes."""
        def look():
            found = self.find_err(pattern)
            if not found and not self.alive():
                self._drained()
                found = self.find_err(pattern)
                check(found, f"{self.name} ended with {self.process.returncode} before it said /{pattern}/:\n"
                      f"{self.stderr_text()}")
            return found
        return wait_until(lambda: f"{self.name} to say /{pattern}/; it said:\n{self.stderr_text()}", look)

    def _drained(self):
        for reader in self.readers:
            reader.join(HANG_S)
        return True

    def wait(self):
        """Returns the exit code after reading all output."""
        try:
            self.process.wait(HANG_S)
        except subprocess.TimeoutExpired:
            raise Failure(f"{self.name} does not end:\n{self.stderr_text()}") from None
        self._drained()
        return self.process.returncode

    def expect_exit(self, code=0):
        got = self.wait()
        check(got == code, f"{self.name} ended with {got}, not {code}:\n{' '.join(self.command)}\n{self.stderr_text()}")
        check(not self.find_err("validation"), f"validation is not silent:\n{self.stderr_text()}")


class Renderer(Program):
    """fire3dv with --validation; its images are in self.folder."""

    def __init__(self, test, *arguments, listen=(), scene=None, size=SIZE, headless=True, env=None,
                 host=None):
        test.counter += 1
        self.folder = os.path.join(test.folder, f"images{test.counter}")
        self._frames, self._log_at = [], 0
        command = [test.programs_at["fire3dv"], scene or test.scene, "--validation", "--tone-map", "none", "--ground", "off",
                   "--size", f"{size[0]}x{size[1]}", "--out", self.folder]
        command += ["--headless"] if headless else ["--gui", "off"]
        command += PLAIN_IMAGES if test.plain_images else ()
        command += [] if "--cache" in arguments else ["--cache", "off"]  # tests leave no cache entries behind
        for uri in listen:
            command += ["--listen", uri]
        super().__init__(test, f"fire3dv {test.counter}", command + list(arguments), env or vulkan_environment(), host)

    def uris(self, count=1):
        """Returns the bound addresses in the order of --listen."""
        def look():
            found = [m.group(1) for m in (re.match(r"fire3dv: info: listening on (\S+)$", line) for line in list(self.err)) if m]
            check(len(found) >= count or self.alive(), f"{self.name} ended early:\n{self.stderr_text()}")
            return found if len(found) >= count else None
        return wait_until(lambda: f"{self.name} to listen; it said:\n{self.stderr_text()}", look)

    def frames(self):
        """Returns all complete lines of frames.jsonl so far."""
        path = os.path.join(self.folder, "frames.jsonl")
        if os.path.exists(path):
            with open(path, encoding="utf-8") as log:
                log.seek(self._log_at)
                text = log.read()
            whole = text.rfind("\n") + 1
            self._log_at += len(text[:whole].encode())
            self._frames += [json.loads(line) for line in text[:whole].splitlines()]
        return self._frames

    def wait_frame(self, what, predicate, after=-1):
        """Returns the first image later than `after` with predicate(its line of frames.jsonl)."""
        def look():
            alive = self.alive()  # read before the lines: output from before its end counts
            found = next((f for f in self.frames()[after + 1:] if predicate(f)), None)
            check(found or alive, f"{self.name} ended before {what}:\n{self.stderr_text()}")
            return found
        return wait_until(lambda: f"{what}; last: {self.frames()[-1:]}\n{self.stderr_text()}", look)

    def picture(self, frame):
        picture = read_png(os.path.join(self.folder, frame["file"]))
        check_tags(picture.text, frame)
        return picture

    def stop(self):
        """Ends the program as a user would, and expects success."""
        self.signal(signal.SIGTERM)
        self.expect_exit(0)


def check_tags(text, frame):
    """The PNG text chunks equal the line of frames.jsonl."""
    streams = frame["streams"]
    check(text.get("Streams") == str(len(streams)) and text.get("Frame") == str(frame["frame"]),
          f"{frame['file']} says {text}, frames.jsonl says {frame}")
    for i, stream in enumerate(streams):
        suffix = "" if len(streams) == 1 else f".{i}"
        for keyword, key in (("Stream", "stream"), ("Epoch", "epoch"), ("Sequence", "sequence"),
                             ("SimTimeNs", "sim_time_ns"), ("PublishTimeNs", "publish_time_ns"),
                             ("State", "state")):
            check(text.get(keyword + suffix) == str(stream[key]), f"{frame['file']}: {keyword}{suffix} is "
                  f"{text.get(keyword + suffix)}, frames.jsonl says {stream[key]}")


class Publisher(Program):
    """publisher.cpp, controlled by lines on its standard input."""

    def __init__(self, test, uri, nodes=("red",), name="arm", host=None):
        super().__init__(test, f"publisher {name}", [test.programs_at["publisher"], uri, name, *nodes], host=host)
        self.answers = 0

    def do(self, line):
        """Sends a line and returns the fields of the answer."""
        self.send(line)
        return self.answer(line)

    def send(self, line):
        try:
            self.process.stdin.write(line + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            raise Failure(f"{self.name} ended:\n{self.stderr_text()}") from None

    def answer(self, line):
        wanted = self.answers + 1

        def look():
            check(self.alive() or self._drained() and len(self.out) >= wanted,
                  f"{self.name} ended:\n{self.stderr_text()}")
            return len(self.out) >= wanted
        wait_until(f"{self.name} to answer {line!r}", look)
        self.answers = wanted
        answer = self.out[wanted - 1]
        check(answer.startswith("ok "), f"{self.name}: {line!r} gave: {answer}")
        fields, message = answer[3:].split(" message=", 1)
        result = dict(field.split("=", 1) for field in fields.split())
        result = {key: value if key == "epoch" else int(value) for key, value in result.items()}
        return {**result, "message": message}

    def wait_status(self, what, predicate):
        last = {}

        def look():
            last.update(self.do("status"))
            return predicate(last)
        wait_until(lambda: f"{what}; last: {last}", look)
        return last

    def wait_welcome(self):
        return self.wait_status("a welcome", lambda s: s["welcome"] >= 0)

    def quit(self):
        self.do("quit")
        self.expect_exit(0)


# --- a test ----------------------------------------------------------------------------------------------------------

class Test:
    """Temporary folder with the scene, and the programs, which end with the test in every case."""

    def __init__(self, programs_at, plain_images=False):
        self.programs_at, self.plain_images = programs_at, plain_images
        self.programs, self.hosts, self.counter, self._names = [], [], 0, []
        self.folder = tempfile.mkdtemp(prefix="fire3dv-e2e-")
        self.scene = os.path.join(self.folder, "squares.glb")
        write_scene(self.scene)

    def path(self, name):
        return os.path.join(self.folder, name)

    def fresh_uri(self, transport):
        """Returns an unused address that both sides can get before either runs."""
        if transport == "shm":
            name = f"fire3dv-e2e-{os.getpid()}-{len(self._names)}"
            self._names.append(name)
            return f"shm://{name}"
        # Below the range of ephemeral ports, so that no other process gets the port between restarts.
        kind = socket.SOCK_STREAM if transport == "tcp" else socket.SOCK_DGRAM
        for _ in range(200):
            port = random.randrange(12000, 32000)
            with socket.socket(socket.AF_INET, kind) as probe:
                try:
                    probe.bind(("127.0.0.1", port))
                except OSError:
                    continue
            return f"{transport}://127.0.0.1:{port}"
        raise Failure("no free port")

    def renderer(self, *arguments, **options):
        return Renderer(self, *arguments, **options)

    def viewer(self, scene, *arguments, size=SIZE, env=None):
        """fire3dv in a window, with a user's options: without the image options of a test."""
        command = [self.programs_at["fire3dv"], scene, "--validation", "--tone-map", "none", "--ground", "off", "--cache", "off",
                   "--size", f"{size[0]}x{size[1]}", *(PLAIN_IMAGES if self.plain_images else ()), *arguments]
        return Program(self, "fire3dv in a window", command, env or vulkan_environment())

    def publisher(self, uri, **options):
        return Publisher(self, uri, **options)

    def end(self):
        for program in self.programs:
            if program.alive():
                program.signal(signal.SIGCONT)
                program.kill()
        for host in self.hosts:
            host.end()
        for name in self._names:
            for path in glob.glob(f"/dev/shm/*fire3dv.{name}*"):
                with contextlib.suppress(FileNotFoundError):  # a program that ends removes its own
                    os.unlink(path)
        shutil.rmtree(self.folder, ignore_errors=True)


def shown(frame, name):
    """Returns the tag of this stream in a line of frames.jsonl, or None."""
    return next((s for s in frame["streams"] if s["stream"] == name), None)


def main(cases, programs, plain_images=False):
    """Runs the cases that the command line names after the programs, or all: PROGRAM... [CASE...]. plain_images: renderers
    draw one sample and no shadows, a third less work where the test is not about images.
    """
    paths = dict(zip(programs, sys.argv[1:]))
    check(len(paths) == len(programs), f"give the programs: {' '.join(programs)}")
    wanted = sys.argv[1 + len(programs):]
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # a terminated test terminates its programs
    for name, run in cases.items():
        if wanted and not any(name == w or name.startswith(w + "_") for w in wanted):
            continue
        begin = time.monotonic()
        test = Test(paths, plain_images)
        try:
            run(test)
            print(f"passed {name} ({time.monotonic() - begin:.1f} s)", flush=True)
        except Failure as failure:
            print(f"FAILED {name}: {failure}", flush=True)
            for program in test.programs:
                print(f"--- {program.name}\n{program.stderr_text()[-3000:]}", flush=True)
            sys.exit(1)  # otherwise the fault of one case makes each other case run into the hang limit
        finally:
            test.end()
