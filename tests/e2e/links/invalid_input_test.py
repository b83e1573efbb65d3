#!/usr/bin/env python3
"""End-to-end robustness test: invalid bytes on every link; the renderer goes on and draws a valid stream throughout."""
import os
import random
import re
import socket
import struct
import subprocess

from harness import HANG_S, main, shown
from image_reader import check, expect_square, place_of


def port_of(uri):
    return int(uri.rsplit(":", 1)[1])


def expect_good_stream_goes_on(renderer, publisher):
    published = publisher.do("status")["sequence"]
    publisher.do("stream 100")
    frame = renderer.wait_frame("the good stream to go on", lambda f: shown(f, "good") and
                                shown(f, "good")["sequence"] > published)
    expect_square(renderer.picture(frame), "red", place_of(shown(frame, "good")["sequence"]), "the good stream")


def beside_a_good_stream(attack):
    """attack(test, renderer, uris) gets uris of shm, tcp and udp without another publisher."""
    def run(test):
        good = test.fresh_uri("shm")
        renderer = test.renderer(listen=[good, test.fresh_uri("shm"), "tcp://127.0.0.1:0", "udp://127.0.0.1:0"])
        uris = dict(zip(("shm", "tcp", "udp"), renderer.uris(4)[1:]))
        publisher = test.publisher(good, name="good")
        publisher.do("stream 100")
        expect_good_stream_goes_on(renderer, publisher)
        attack(test, renderer, uris)
        expect_good_stream_goes_on(renderer, publisher)
        drawn = {s["stream"] for f in renderer.frames() for s in f["streams"]}
        check(drawn == {"good"}, f"garbage is drawn as a stream: {drawn}")
        # The log stays short, independent of the amount of input.
        check(len(renderer.err) < 40, f"{len(renderer.err)} lines on stderr:\n{renderer.stderr_text()}")
        check(all(re.match("fire3dv: (info|warning|error): ", line) for line in renderer.err), f"{renderer.stderr_text()}")
        publisher.quit()
        renderer.stop()
    return run


def random_tcp(test, renderer, uris):
    noise = random.Random(2)
    preface_of_others = b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"
    for data in [preface_of_others, b"", b"\0" * 4096, b"\xff" * 100000] + [noise.randbytes(n) for n in (1, 15, 16, 17, 70000)]:
        with socket.create_connection(("127.0.0.1", port_of(uris["tcp"])), HANG_S) as connection:
            try:
                connection.sendall(data)
                connection.shutdown(socket.SHUT_WR)
                while connection.recv(4096):
                    pass
            except OSError:
                pass  # the renderer may close at any time
    renderer.wait_err(r"a connection from .* was closed")


def preface_then_random_tcp(test, renderer, uris):
    """A valid greeting, copied from the renderer's own, followed by invalid frames."""
    with socket.create_connection(("127.0.0.1", port_of(uris["tcp"])), HANG_S) as victim:
        publisher = subprocess.Popen([test.programs_at["publisher"], f"tcp://127.0.0.1:{listen_once(test)}", "x", "red"],
                                     stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
        preface = test.greeting.accept()[0].recv(16, socket.MSG_WAITALL)
        publisher.kill()
        publisher.wait()
        test.greeting.close()
    check(len(preface) == 16, "no preface was caught")
    noise = random.Random(3)
    kinds = [struct.pack("<IBBH", length, kind, 0, 0) for kind in (0, 1, 2, 9) for length in (0, 5, 2**28, 2**32 - 1)]
    for lie in kinds + [noise.randbytes(5000) for _ in range(5)]:
        with socket.create_connection(("127.0.0.1", port_of(uris["tcp"])), HANG_S) as connection:
            try:
                connection.sendall(preface + lie + noise.randbytes(2000))
                connection.shutdown(socket.SHUT_WR)
                while connection.recv(4096):
                    pass
            except OSError:
                pass


def listen_once(test):
    test.greeting = socket.create_server(("127.0.0.1", 0))
    test.greeting.settimeout(HANG_S)
    return test.greeting.getsockname()[1]


def random_udp(test, renderer, uris):
    noise = random.Random(4)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(("127.0.0.1", port_of(uris["udp"])))
        for _ in range(3000):
            sender.send(noise.randbytes(noise.randrange(0, 1400)))
        # A valid header followed by random bytes.
        real = caught_datagram(test)
        for _ in range(3000):
            keep = noise.randrange(4, len(real) + 1)
            sender.send(real[:keep] + noise.randbytes(noise.randrange(0, 1200 - keep)))
    renderer.wait_err(r"datagrams came that are not FIRE-3DV's")


def caught_datagram(test):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(HANG_S)
        publisher = subprocess.Popen([test.programs_at["publisher"], f"udp://127.0.0.1:{listener.getsockname()[1]}", "x", "red"],
                                     stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
        data = listener.recv(2000)
        publisher.kill()
        publisher.wait()
    return data


def garbage_segment(test, renderer, uris):
    path = "/dev/shm/fire3dv." + uris["shm"].removeprefix("shm://")
    noise = random.Random(5)

    def put(data, mode=0o600):
        with open(path + ".new", "wb") as file:
            file.write(data)
            os.chmod(path + ".new", mode)
        os.rename(path + ".new", path)

    put(noise.randbytes(100000))
    renderer.wait_err(r"is not a FIRE-3DV segment")
    put(b"short")
    renderer.wait_err(r"is too short for a FIRE-3DV segment")
    put(struct.pack("<Q", 0x314d485356443346) + noise.randbytes(200000))
    renderer.wait_err(r"layout|damaged header|version")
    put(noise.randbytes(100000), 0o666)
    renderer.wait_err(r"may be written or read by other users")
    os.unlink(path)
    os.mkdir(path, 0o700)
    renderer.wait_err(r"fire3dv: .*shm://.*(not a regular file|cannot be opened)")
    os.rmdir(path)
    # Afterwards a valid publisher can use the name.
    second = test.publisher(uris["shm"], name="good", nodes=["green"])
    second.do("stream 100")
    second.wait_status("a welcome after the garbage", lambda s: s["welcome"] == 0)
    second.quit()


def rude(fault, answer, note, transports=("shm", "tcp", "udp")):
    """One fault of the program on each link: the renderer logs it, and answers if the fault has an answer."""
    def attack(test, renderer, uris):
        for transport in transports:
            before = len(renderer.err)
            result = subprocess.run([test.programs_at["rude_client"], uris[transport], fault], capture_output=True,
                                    text=True, timeout=HANG_S, check=False)
            check(result.returncode == 0 and all(word in result.stdout for word in answer),
                  f"{fault} over {transport} was answered: {result.stdout} {result.stderr}")
            renderer.wait_err(note)
            check(len(renderer.err) - before < 8, f"{fault} over {transport}:\n{renderer.stderr_text()}")
    return beside_a_good_stream(attack)


CASES = {
    "random_tcp": beside_a_good_stream(random_tcp),
    "preface_then_random_tcp": beside_a_good_stream(preface_then_random_tcp),
    "random_udp": beside_a_good_stream(random_udp),
    "garbage_segment": beside_a_good_stream(garbage_segment),
    "wrong_version": rude("wrong_version", ["status=1 ", "major=1 ", "epoch=1234", "1.10", "2.10", "update"],
                          "rude_client was refused: this renderer speaks protocol 1.10, the adapter 2.10"),
    "nan_description": rude("nan_description", ["status=2 ", "world_from_stream"], r"dropped a message from \S+ peer \d+: .*world_from_stream"),
    "not_a_message": rude("not_a_message", ["status=2 "], r"dropped a message from \S+ peer \d+: "),
    "pose_first": rude("pose_first", ["sent"], "pose frame before a description", ["tcp", "udp"]),
}

if __name__ == "__main__":
    main(CASES, ["fire3dv", "publisher", "rude_client"], plain_images=True)
