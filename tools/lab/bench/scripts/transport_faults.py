"""Cost of publish calls while the reader is stopped, killed, or out of disk space."""
import contextlib
import json
import os
import random
import shlex
import signal
import socket
import statistics
import subprocess
import threading
import time

HANG_S = 120
PERCENTILES = ("p50_ns", "p99_ns", "p999_ns")


class Trouble(Exception):
    pass


def fresh_uri(scheme):
    """An address that both sides can be given before either runs."""
    if scheme == "shm":
        return f"shm://bench-{os.getpid()}-{random.randrange(1 << 32)}"
    kind = socket.SOCK_DGRAM if scheme == "udp" else socket.SOCK_STREAM
    while True:
        # Below the ephemeral port range, so that no other process takes the port meanwhile.
        port = random.randrange(12000, 32000)
        with socket.socket(socket.AF_INET, kind) as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return f"{scheme}://127.0.0.1:{port}"


class Publisher:
    """fire3dv-bench publish."""

    def __init__(self, bench, uri, rate_hz, poses):
        self.process = subprocess.Popen([bench, "publish", uri, "--rate", str(rate_hz), "--poses", str(poses)],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self):
        """What its calls cost since it was last asked."""
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise Trouble("the publisher ended")
        return json.loads(line)

    def wait_for_reader(self):
        end = time.monotonic() + HANG_S
        while self.ask()["renderers"] == 0:
            if time.monotonic() > end:
                raise Trouble("the publisher finds no reader")
            time.sleep(0.02)

    def end(self):
        self.process.stdin.close()
        self.process.wait(HANG_S)


class Reader:
    def __init__(self, command):
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace")
        self.said = []
        self.listener = threading.Thread(target=self._read, daemon=True)
        self.listener.start()

    def _read(self):
        for line in self.process.stderr:
            self.said.append(line)

    def signal(self, number):
        self.process.send_signal(number)

    def end(self):
        self.process.kill()
        self.process.wait()
        self.listener.join(HANG_S)


def _private_mounts():
    return ["unshare", *([] if os.geteuid() == 0 else ["-Ur"]), "-m"]


def can_mount(folder):
    script = f"mount -t tmpfs -o size=256k tmpfs {shlex.quote(folder)}"
    return subprocess.run([*_private_mounts(), "sh", "-c", script], capture_output=True, check=False).returncode == 0


def full_disk(command, folder):
    """The command where `folder` is a disk of its own that has no room. Needs root, or a kernel that lets users mount."""
    script = f"mount -t tmpfs -o size=256k tmpfs {shlex.quote(folder)} && exec {shlex.join(command)}"
    return [*_private_mounts(), "sh", "-c", script]


# --- faults applied to the reader while the publisher publishes

def do_nothing(reader, _command, seconds):
    time.sleep(seconds)
    return reader


def do_stop(reader, _command, seconds):
    reader.signal(signal.SIGSTOP)
    time.sleep(seconds)
    reader.signal(signal.SIGCONT)
    return reader


def do_kill(reader, command, seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        reader.end()
        reader = Reader(command)
        time.sleep(0.1)
    return reader


def measure(publisher, act):
    publisher.ask()
    result = act()
    return publisher.ask(), result


def median_us(rows, key):
    return statistics.median(row[key] for row in rows) / 1000


def table_row(link, fault, before, during):
    ratios = [d["p999_ns"] / b["p999_ns"] for b, d in zip(before, during)]
    cells = [link, fault]
    for key in PERCENTILES:
        cells += [f"{median_us(before, key):.2f}", f"{median_us(during, key):.2f}"]
    cells += [f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})", str(sum(d["calls"] for d in during))]
    return "| " + " | ".join(cells) + " |"


def pairs(bench, links, reader_of, act, what, rounds, seconds, rate_hz, poses):
    """Rows of: a reader that is well, then what is done to it, in turns."""
    for link in links:
        uri = fresh_uri(link)
        command = reader_of(uri)
        publisher, reader = Publisher(bench, uri, rate_hz, poses), Reader(command)
        before, during = [], []
        try:
            for _ in range(rounds):
                publisher.wait_for_reader()
                before.append(measure(publisher, lambda: do_nothing(reader, command, seconds))[0])
                after, reader = measure(publisher, lambda: act(reader, command, seconds))
                during.append(after)
        finally:
            reader.end()
            publisher.end()
        yield table_row(f"{link}://", what, before, during)


def do_fill_disk(_reader, command, seconds):
    reader = Reader(command)
    end = time.monotonic() + seconds
    give_up = time.monotonic() + HANG_S
    while time.monotonic() < end or not any("No space left" in line for line in reader.said):
        if time.monotonic() > give_up:
            raise Trouble("the renderer does not say that its disk is full:\n" + "".join(reader.said))
        time.sleep(0.05)
    return reader


def disk_full(bench, links, renderer_of, folder, rounds, seconds, rate_hz, poses):
    """A renderer that writes its images, then one that finds no room for them, says so and ends."""
    for link in links:
        before, during = [], []
        for _ in range(rounds):
            uri = fresh_uri(link)
            publisher, reader = Publisher(bench, uri, rate_hz, poses), Reader(renderer_of(uri))
            try:
                publisher.wait_for_reader()
                before.append(measure(publisher, lambda: do_nothing(reader, None, seconds))[0])
                reader.end()
                without_room = full_disk(renderer_of(uri), folder)
                after, reader = measure(publisher, lambda: do_fill_disk(reader, without_room, seconds))
                during.append(after)
            finally:
                reader.end()
                publisher.end()
        yield table_row(f"{link}://", "out of disk", before, during)


def tables(programs, rounds, seconds, rate_hz, poses, renderer_command, folder, links, renderer_links):
    yield ("| link | reader is | p50 us before | during | p99 us before | during | p99.9 us before | during | p99.9, ratio of pairs (range) | "
           "calls |")
    yield "|---" * 10 + "|"

    def inspect(uri):
        return [programs["fire3dv-inspect"], uri, "--seconds", "86000"]
    common = {"rounds": rounds, "seconds": seconds, "rate_hz": rate_hz, "poses": poses}
    yield from pairs(programs["fire3dv-bench"], links, inspect, do_nothing, "well, and well again", **common)
    yield from pairs(programs["fire3dv-bench"], links, inspect, do_stop, "stopped, its sockets not read", **common)
    yield from pairs(programs["fire3dv-bench"], links, inspect, do_kill, "killed ten times a second", **common)
    if not can_mount(folder):
        yield "\nA full disk was not tried: this machine lets nobody mount one."
        return
    yield from disk_full(programs["fire3dv-bench"], renderer_links, renderer_command, folder, **common)
