#!/usr/bin/env python3
"""End-to-end security test: attackers at every port of a running renderer. After each attack the link serves an honest
publisher, the neighbouring stream was drawn throughout, rejections were counted under their cause, and memory and file
descriptors are back at their level.
"""
import random
import re
import resource
import select
import socket
import struct
import subprocess
import threading
import time

from harness import HANG_S, main, shown, wait_until
from image_reader import check
from prometheus import scrape, url_of

HALF_OPEN = 10000
MOST_GROWTH_BYTES = 96 << 20  # limit of memory growth by one attack: allocators cache some freed memory


class Victim:
    """Renderer under attack that draws an honest stream, with its counters from before the attack."""

    def __init__(self, test, listen, *options):
        self.test = test
        good = test.fresh_uri("shm")
        self.renderer = test.renderer("--metrics", "127.0.0.1:0", *options, listen=[good, *listen])
        self.uris = self.renderer.uris(1 + len(listen))[1:]
        self.publisher = test.publisher(good, name="good")
        self.publisher.do("stream 100")
        self.url = url_of(self.renderer)
        self.expect_stream()
        self.before = self.page()

    def page(self):
        return scrape(self.url, HANG_S)

    def expect_stream(self):
        published = self.publisher.do("status")["sequence"]
        self.publisher.do("stream 100")
        self.renderer.wait_frame("the good stream to go on", lambda f: shown(f, "good") and
                                 shown(f, "good")["sequence"] > published)

    def counted(self, page, uri, cause):
        """Returns the increase of this refusal counter since the attack began."""
        return (page.get("fire3dv_listener_rejected_total", listener=uri, cause=cause) -
                self.before.get("fire3dv_listener_rejected_total", listener=uri, cause=cause))

    def refused(self, page, cause):
        return (page.get("fire3dv_messages_refused_total", cause=cause) -
                self.before.get("fire3dv_messages_refused_total", cause=cause))

    def wait_counted(self, uri, cause, least):
        last = []

        def look():
            last[:] = [self.counted(self.page(), uri, cause)]
            return last[0] >= least
        wait_until(lambda: f"{least} counted as {cause} at {uri}; there are {last}", look)

    def expect_served(self, uri, name, *credentials):
        """Checks that an honest publisher is accepted and its stream drawn."""
        honest = subprocess.Popen([self.test.programs_at["attacker"], "good", uri, name, *credentials],
                                  stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        try:
            check(honest.stdout.readline() == "welcome\n", f"{name} is not served at {uri}")
            self.renderer.wait_frame(f"{name} to be drawn", lambda f: shown(f, name))
        finally:
            honest.stdin.close()
            check(honest.wait(HANG_S) == 0, f"{name} failed")

    def expect_unharmed(self):
        self.expect_stream()
        page = self.page()
        grown = page.get("process_resident_memory_bytes") - self.before.get("process_resident_memory_bytes")
        check(grown < MOST_GROWTH_BYTES, f"memory grew by {grown / 2**20:.0f} MiB")
        wait_until("descriptors to be given back", lambda: self.page().get("process_open_fds") <
                   self.before.get("process_open_fds") + 100)
        check(len(self.renderer.err) < 100, f"{len(self.renderer.err)} lines on stderr:\n{self.renderer.stderr_text()}")
        check(all(re.match("fire3dv: (info|warning|error): ", line) and line.isprintable() for line in self.renderer.err),
              self.renderer.stderr_text())

    def end(self):
        self.publisher.quit()
        self.renderer.stop()


def place_of(uri):
    return "127.0.0.1", int(uri.rsplit(":", 1)[1])


def closed(connection):
    """Reads until the peer closes the connection."""
    try:
        while connection.recv(65536):
            pass
    except ConnectionError:
        pass
    connection.close()


def credentials(test):
    keeper = subprocess.Popen([test.programs_at["attacker"], "credentials"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              text=True)
    files = dict(pair.split("=", 1) for pair in keeper.stdout.readline().split())
    return keeper, files


def secure_victim(test):
    keeper, files = credentials(test)
    victim = Victim(test, ["tls://127.0.0.1:0", "udp://127.0.0.1:0"], "--key-file", files["key"], "--tls-cert", files["cert"],
                    "--tls-key", files["certkey"])
    return victim, keeper, files


def half_open(test):
    """Opens idle connections: ten thousand over TCP, two thousand over TLS."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    at_once = min(HALF_OPEN, hard - 500)
    victim, keeper, files = secure_victim(test)
    plain = Victim(test, ["tcp://127.0.0.1:0"])
    for who, uri, count, name in ((plain, plain.uris[0], HALF_OPEN, ()), (victim, victim.uris[0], 2000, ("ca", files["ca"]))):
        silent = []
        for i in range(count):
            silent.append(socket.create_connection(place_of(uri), HANG_S))
            if len(silent) > at_once:
                silent.pop(0).close()
            if i == count // 2:
                who.expect_served(uri, "meanwhile", *name)
        who.wait_counted(uri, "silent", count - 200)  # the others are still within their time-out
        who.expect_served(uri, "afterwards", *name)
        who.expect_unharmed()
        for connection in silent:
            connection.close()
        who.end()
    keeper.communicate()


def slow_loris(test):
    """Sends a greeting, or a message, byte by byte (slow loris)."""
    victim = Victim(test, ["tcp://127.0.0.1:0"])
    uri = victim.uris[0]
    preface = b"F3DV" + struct.pack("<HHQ", 1, 0, 0)
    length, kind = 1 << 20, 1
    header = struct.pack("<IBBH", length, kind, 0, (length & 0xffff) ^ (length >> 16) ^ (kind << 8) ^ 0x3d5f)
    slow = [(socket.create_connection(place_of(uri), HANG_S), preface, 0) for _ in range(20)]
    slow += [(socket.create_connection(place_of(uri), HANG_S), preface + header + bytes(length), 24) for _ in range(20)]
    for connection, words, at_once in slow:
        connection.setblocking(False)
        connection.sendall(words[:at_once])

    def drip(step=[0]):  # one byte every half second until the peer closes
        step[0] += 1
        for entry in list(slow):
            connection, words, at_once = entry
            try:
                at = at_once + step[0]
                if at < (15 if at_once == 0 else len(words)):
                    connection.send(words[at:at + 1])
                while True:
                    if not connection.recv(4096):
                        raise ConnectionError
            except BlockingIOError:
                pass
            except ConnectionError:
                connection.close()
                slow.remove(entry)
        time.sleep(0.5)
        return not slow
    wait_until(lambda: f"{len(slow)} slow connections to be closed", drip)
    victim.wait_counted(uri, "silent", 40)
    victim.expect_served(uri, "afterwards")
    victim.expect_unharmed()
    victim.end()


def messages(test):
    """Sends names with terminal control sequences, invalid numbers, and valid messages out of order, on each link."""
    victim = Victim(test, [test.fresh_uri("shm"), "tcp://127.0.0.1:0", "udp://127.0.0.1:0"])
    for uri in victim.uris:
        victim.before = victim.page()
        result = subprocess.run([test.programs_at["attacker"], "messages", uri], capture_output=True, text=True,
                                timeout=HANG_S, check=False)
        check(result.returncode == 0 and result.stdout == "refused=15\n", f"{uri}: {result.stdout} {result.stderr}")
        # Of poses in quick succession the renderer reads only the newest: the control messages are what
        # counts exactly.
        for cause, least in (("unreadable", 15), ("before_description", 1), ("wrong_way", 70)):
            wait_until(lambda: f"{least} {cause} at {uri}; there are {victim.refused(victim.page(), cause)}",
                       lambda: victim.refused(victim.page(), cause) >= least)
        victim.expect_served(uri, "afterwards")
    victim.expect_unharmed()
    drawn = {s["stream"] for f in victim.renderer.frames() for s in f["streams"]}
    check(drawn <= {"good", "afterwards", "attacker"}, f"drawn: {drawn}")
    victim.end()


def many_nodes(test):
    """Describes ten million nodes, and over shared memory more nodes than allowed."""
    victim = Victim(test, ["tcp://127.0.0.1:0", test.fresh_uri("shm")])
    for uri, count in zip(victim.uris, (10_000_000, 1_100_000)):
        result = subprocess.run([test.programs_at["attacker"], "nodes", uri, str(count)], capture_output=True, text=True,
                                timeout=HANG_S, check=False)
        check("status=2" in result.stdout and f"holds {count} names; at most 1048576" in result.stdout,
              f"{uri}: {result.stdout} {result.stderr}")
        victim.expect_served(uri, "afterwards")
    wait_until("two refusals", lambda: victim.refused(victim.page(), "unreadable") == 2)
    victim.expect_unharmed()
    victim.end()


class Middle(threading.Thread):
    """Man in the middle of successive TCP connections. spoil(data, bytes passed before) returns the bytes to forward, or
    None to cut the connection.
    """

    def __init__(self, target, spoil):
        super().__init__(daemon=True)
        self.target, self.spoil, self.spoiled = target, spoil, 0
        self.server = socket.create_server(("127.0.0.1", 0))
        self.uri_place = self.server.getsockname()
        self.start()

    def run(self):
        while True:
            try:
                client, _ = self.server.accept()
            except OSError:
                return
            with client, socket.create_connection(self.target, HANG_S) as server:
                passed = 0
                try:
                    while True:
                        for ready in select.select([client, server], [], [])[0]:
                            data = ready.recv(65536)
                            if not data:
                                raise ConnectionError
                            if ready is client:
                                sound, data = data, self.spoil(data, passed)
                                passed += len(sound)
                                self.spoiled += data != sound
                                if data is None:
                                    raise ConnectionError
                            (server if ready is client else client).sendall(data)
                except OSError:
                    pass


def tls_on_the_way(test):
    """Flips bits and cuts connections inside TLS: no result is accepted as a message."""
    victim, keeper, files = secure_victim(test)
    uri = victim.uris[0]
    noise = random.Random(8)
    state = {"mode": None}

    def spoil(data, passed):
        if state["mode"] == "cut" and passed + len(data) > 2500:
            return None
        if state["mode"] == "flip" and passed > 1500:  # usually after the handshake
            at = noise.randrange(len(data))
            return data[:at] + bytes([data[at] ^ 1 << noise.randrange(8)]) + data[at + 1:]
        return data
    middle = Middle(place_of(uri), spoil)
    through = f"tls://127.0.0.1:{middle.uri_place[1]}"
    for mode in ("flip", "cut"):
        state["mode"] = mode
        start = middle.spoiled
        publisher = subprocess.Popen([test.programs_at["attacker"], "good", through, "spoiled", "ca", files["ca"]],
                                     stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        wait_until(f"{mode}", lambda: middle.spoiled > start + 20)
        state["mode"] = None  # without interference the same publisher connects
        check(publisher.stdout.readline() == "welcome\n", f"after {mode}")
        publisher.communicate()
    victim.wait_counted(uri, "bad_key", 5)  # some flips hit bytes outside of sealed records
    with socket.create_connection(place_of(uri), HANG_S) as plain:  # tcp:// at a tls:// port
        plain.sendall(b"F3DV" + struct.pack("<HHQ", 1, 0, 0))
        closed(plain)
    victim.expect_served(uri, "afterwards", "ca", files["ca"])
    victim.expect_unharmed()
    victim.end()
    keeper.communicate()


def udp_recorded(test):
    """Records a sealed session and replays it: to the listener from the same and from another address, and the listener's
    own datagrams back to it.
    """
    victim, keeper, files = secure_victim(test)
    uri = victim.uris[1]
    to_target, to_client, last = [], [], [None]
    relay = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    relay.bind(("127.0.0.1", 0))
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    out.connect(place_of(uri))

    def carry():
        while True:
            for ready in select.select([relay, out], [], [])[0]:
                try:
                    if ready is relay:
                        data, last[0] = relay.recvfrom(2000)
                        if data == b"stop":
                            return
                        to_target.append(data)
                        out.send(data)
                    else:
                        data = out.recv(2000)
                        to_client.append(data)
                        relay.sendto(data, last[0])
                except OSError:
                    pass
    carrier = threading.Thread(target=carry, daemon=True)
    carrier.start()
    publisher = subprocess.Popen([test.programs_at["attacker"], "good", f"udp://127.0.0.1:{relay.getsockname()[1]}", "recorded",
                                  "key", files["key"]], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    check(publisher.stdout.readline() == "welcome\n", "the recorded publisher is not served")
    wait_until("a recording", lambda: len(to_target) > 100)
    elsewhere = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    elsewhere.connect(place_of(uri))
    seen = list(to_target)[:100]
    for data in seen:
        out.send(data)  # from the same address, in a live session, including hellos
        elsewhere.send(data)
    for data in list(to_client)[:100]:
        out.send(data)  # the listener's own datagrams
        elsewhere.send(data)
    victim.wait_counted(uri, "replayed", 90)
    victim.wait_counted(uri, "unknown_session", 90)
    check(victim.page().get("fire3dv_listener_peers", listener=uri) == 1, "the session outlives its recording")
    frame = victim.renderer.frames()[-1]["frame"]
    victim.renderer.wait_frame("the recorded stream to go on", lambda f: shown(f, "recorded"), after=frame)
    publisher.communicate()
    wait_until("its end", lambda: victim.page().get("fire3dv_listener_peers", listener=uri) == 0)
    for data in list(to_target):
        out.send(data)  # and after the session has ended
    wait_until("the answers", lambda: victim.counted(victim.page(), uri, "unknown_session") >= 180)
    check(victim.page().get("fire3dv_listener_peers", listener=uri) == 0, "a recording was let in")
    relay.sendto(b"stop", relay.getsockname())
    carrier.join(HANG_S)
    # A peer with another key, or without one, gets an answer and no access.
    for wrong in (["key", files["other"]], []):
        counted = victim.counted(victim.page(), uri, "bad_key")
        stranger = subprocess.Popen([test.programs_at["attacker"], "good", uri, "stranger", *wrong], stdin=subprocess.PIPE,
                                    stdout=subprocess.DEVNULL)
        victim.wait_counted(uri, "bad_key", counted + 1)
        stranger.kill()
        stranger.wait()
    for size in (9001, 20000, 40000, 65000):  # longer than any valid datagram
        elsewhere.send(b"F3DU" + bytes(size - 4))
    victim.wait_counted(uri, "malformed", 4)
    victim.expect_served(uri, "afterwards", "key", files["key"])
    victim.expect_unharmed()
    drawn = {s["stream"] for f in victim.renderer.frames() for s in f["streams"]}
    check(drawn <= {"good", "recorded", "afterwards"}, f"drawn: {drawn}")
    victim.end()
    keeper.communicate()


CASES = {
    "half_open": half_open,
    "slow_loris": slow_loris,
    "messages": messages,
    "many_nodes": many_nodes,
    "tls_on_the_way": tls_on_the_way,
    "udp_recorded": udp_recorded,
}

if __name__ == "__main__":
    main(CASES, ["fire3dv", "publisher", "attacker"], plain_images=True)
