"""A ROS 2 system for tests: publishers, the adapter, and what the adapter sends."""
import math
import os
import signal

from harness import Program, wait_until
from hosts import Host
from image_reader import check
from stream_lines import StreamLines

SECOND = 1_000_000_000


class Side(Program):
    """One process with publishers, driven by lines (programs/ros2/commands.h)."""

    def __init__(self, ros, name="publisher", opens=("tf", "tf_static"), wait=True):
        super().__init__(ros.test, name, [ros.test.programs_at["publisher"]], ros.env, ros.host)
        self.answers, self.ros = 0, ros
        self.answer()  # "ready"
        for words in opens:
            self.do("open " + words)
        if wait:
            self.wait_readers(*opens)

    def wait_readers(self, *opens):
        """Waits until both sides have found each other: what moves is not repeated for late readers."""
        for words in opens:
            kind, topic = (words.split() + ["/" + words])[:2]
            wait_until(f"a reader of {kind}", lambda k=kind: self.do(f"readers {k}") != "ok 0")
            self.ros.current.wait_err(rf"{topic} is published by .*process {self.process.pid} ")

    def do(self, *lines):
        """Returns the last answer."""
        self.process.stdin.write("\n".join(lines) + "\n")
        self.process.stdin.flush()
        answer = self.answer(len(lines))
        check(answer.startswith("ok"), f"{self.name}: {lines[-1]!r} gave {answer!r}")
        return answer

    def answer(self, lines=1):
        self.answers += lines
        wait_until(f"{self.name} to answer", lambda: len(self.out) >= self.answers or not self.alive())
        check(len(self.out) >= self.answers, f"{self.name} ended:\n{self.stderr_text()}")
        return self.out[self.answers - 1]

    def send(self, kind, *transforms):
        """Publishes one message of transforms: (parent, child, seconds, x, y, z, qx, qy, qz, qw), from x on optional."""
        self.do(*(f"transform {parent} {child} {round(seconds * SECOND)} {' '.join(map(str, numbers))}"
                  for parent, child, seconds, *numbers in transforms), "send " + kind)


class Ros:
    """A ROS 2 system of its own: network namespace, domain, stream."""

    count = 0

    def __init__(self, test, dumps=True):
        """dumps: print the stream's messages; otherwise a renderer listens."""
        Ros.count += 1
        self.test, self.host = test, Host(test, "ros")
        self.env = {key: value for key, value in os.environ.items() if not key.startswith(("ROS_", "CYCLONEDDS_"))}
        # Fast DDS has shared memory of one name for each domain, which network namespaces do not separate.
        self.env["ROS_DOMAIN_ID"] = str(1 + (os.getpid() * 16 + Ros.count) % 230)
        self.uri = test.fresh_uri("shm")
        self.lines = StreamLines(test.programs_at["stream_dump"], self.uri) if dumps else None

    def adapter(self, *arguments, env=None):
        self.current = Program(self.test, "fire3dv-ros2",
                               [self.test.programs_at["fire3dv-ros2"], "--to", self.uri, *arguments],
                               {**self.env, **(env or {})}, self.host)
        return self.current

    def side(self, *arguments, **options):
        return Side(self, *arguments, **options)

    def named_frames(self):
        """Returns [(flags, time_ns, {name: pose}), ...] of all frames so far whose description has come, too."""
        messages = list(self.lines.messages)
        names = {m["epoch"]: m["node_names"] for m in messages if m["type"] == "StreamDescription"}
        return [(m["flags"], m["sim_time_ns"], dict(zip(names[m["epoch"]], m["poses"])))
                for m in messages if m["type"] == "PoseFrame" and m["epoch"] in names]

    def descriptions(self):
        return [m["node_names"] for m in list(self.lines.messages) if m["type"] == "StreamDescription"]

    def wait_frame(self, what, wanted):
        return wait_until(lambda: f"{what}; last: {self.named_frames()[-1:]}; described: {self.descriptions()}",
                          lambda: next((f for f in self.named_frames() if wanted(f)), None))


def end(adapter):
    adapter.signal(signal.SIGTERM)
    adapter.expect_exit(0)


def at(pose, x=None, y=None, z=None):
    return all(want is None or math.isclose(pose[i], want, abs_tol=1e-5) for i, want in ((3, x), (7, y), (11, z)))


def write(test, name, text):
    path = test.path(name)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path
