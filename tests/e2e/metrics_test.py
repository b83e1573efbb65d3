#!/usr/bin/env python3
"""End-to-end test of --metrics: Prometheus can read the page, its numbers are right, and no client blocks the renderer."""
import random
import socket
import subprocess
import urllib.error
import urllib.request

from harness import HANG_S, main, shown, vulkan_environment, wait_until
from image_reader import check
from prometheus import Page, scrape, url_of

ODD_NAME = 'arm "left"\\'  # needs escaping


def wait_page(url, what, predicate):
    last = []

    def look():
        last[:] = [scrape(url)]
        return last[0] if predicate(last[0]) else None
    return wait_until(lambda: f"{what}; last: {last and last[0].samples}", look)


def numbers(test):
    shm, udp = test.fresh_uri("shm"), "udp://127.0.0.1:0"
    renderer = test.renderer("--metrics", "127.0.0.1:0", listen=[shm, udp])
    url = url_of(renderer)
    empty = wait_page(url, "an image", lambda p: p.total("fire3dv_images_total") > 0)
    check(not empty.all("fire3dv_stream_info"), "a stream before there is one")
    publisher = test.publisher(shm, name=ODD_NAME, nodes=["red", "nobody"])
    publisher.wait_welcome()
    for _ in range(40):
        published = publisher.do("publish 1")["sequence"]
    page = wait_page(url, "the newest frame", lambda p: p.total("fire3dv_stream_frames_shown_total") > 0)
    stream = dict(next(labels for name, labels in page.samples if name == "fire3dv_stream_info"))
    check(stream["name"] == ODD_NAME and stream["listener"] == shm and stream["clock"] == "same_clock", str(stream))
    of = {"stream": stream["stream"]}
    check(page.get("fire3dv_stream_nodes", kind="all", **of) == 2 and
          page.get("fire3dv_stream_nodes", kind="unmatched", **of) == 1, "the counts of nodes")
    check(page.get("fire3dv_listener_peers", listener=shm) == 1 and page.total("fire3dv_listener_peers") == 1, "peers")
    check(page.get("fire3dv_peer_limit", resource="names") == 1 << 20, "the limit of names")
    check(len(page.all("fire3dv_peer_use", resource="requests", **of)) == 1 and page.total("fire3dv_peers") == 1, "the peer's budget")
    check(page.total("fire3dv_peer_refusals_total") == 0, "refusals of a peer within its limits")
    check(page.get("process_resident_memory_bytes") > 1 << 20 and page.get("process_open_fds") > 3, "process")
    check(page.get("fire3dv_pass_gpu_seconds_count", **{"pass": "shade"}) > 0, "no times of passes")
    check(sum(page.all("fire3dv_stream_state", **of)) == 1, "not one state")
    # Each received frame was drawn, or a newer one arrived before the next image.
    last = wait_page(url, "silence", lambda p: p.get("fire3dv_stream_state", state="lost", **of) == 1)
    received = last.get("fire3dv_stream_frames_received_total", **of)
    drawn = last.get("fire3dv_stream_frames_shown_total", **of)
    passed_over = last.get("fire3dv_listener_poses_dropped_total", listener=shm)
    check(0 < drawn <= received and received + passed_over == published, f"{drawn} {received} {passed_over} {published}")
    check(last.get("fire3dv_stream_latency_seconds_count", **of) == drawn, "a latency for each frame shown")
    check(last.get("fire3dv_stream_age_seconds", **of) > 1, "the age of a frame that is held")
    publisher.do("hide red")
    publisher.do("hide nobody")
    edited = wait_page(url, "the edits", lambda p: p.get("fire3dv_stream_edits_total", outcome="taken", **of) == 2)
    wait_page(url, "one without effect", lambda p: p.get("fire3dv_edits_without_effect_total", cause="unmatched") == 1)
    check(edited.total("fire3dv_stream_edits_total") == 2, "edits that are stale or refused")
    before, after = page.counts(), last.counts()
    check(all(after[key] >= value for key, value in before.items()), "a counter fell")
    publisher.quit()
    wait_page(url, "the stream to go", lambda p: not p.all("fire3dv_stream_info") and p.total("fire3dv_listener_peers") == 0)
    renderer.stop()


def visitors(test):
    """Misbehaving clients of all kinds at the same time, while a stream is drawn."""
    shm = test.fresh_uri("shm")
    renderer = test.renderer("--metrics", "[::1]:0", listen=[shm])
    url = url_of(renderer)
    port = int(url.split("]:")[1].split("/")[0])
    publisher = test.publisher(shm, name="good")
    publisher.do("stream 100")
    noise = random.Random(6)
    silent = [socket.create_connection(("::1", port), HANG_S) for _ in range(100)]
    greedy = socket.create_connection(("::1", port), HANG_S)
    greedy.sendall(b"GET /metrics HTTP/1.1\r\n\r\n" * 100)  # and never reads
    for data in [b"\0", b"\xff" * 9000, b"GET /metrics HTTP/1.1\r\nX: " + b"a" * 100000] + [noise.randbytes(n) for n in (1, 99, 9999)]:
        with socket.create_connection(("::1", port), HANG_S) as visitor:
            try:
                visitor.sendall(data)
                visitor.shutdown(socket.SHUT_WR)
                while visitor.recv(4096):
                    pass
            except OSError:
                pass  # the server may close at any time
    for path, code in (("/", 404), ("/metrics/../../etc/passwd", 404), ("/" + "a" * 20000, 431)):
        try:
            urllib.request.urlopen(url.replace("/metrics", path), timeout=HANG_S).close()
            check(False, f"{path} was answered")
        except urllib.error.HTTPError as error:
            check(error.code == code, f"{path}: {error.code}, not {code}")
    page = scrape(url)
    check(page.total("fire3dv_metrics_sent_away_total", cause="full") > 0, "nobody had to make room")
    check(page.get("fire3dv_metrics_requests_total", code="431") >= 2, "answers are counted")
    check(page.get("process_open_fds") < 100, "connections pile up")
    published = publisher.do("status")["sequence"]
    publisher.do("stream 100")
    renderer.wait_frame("the stream to go on", lambda f: shown(f, "good") and shown(f, "good")["sequence"] > published)
    for connection in silent + [greedy]:
        connection.close()
    publisher.quit()
    renderer.stop()


def addresses(test):
    for words, at in ((["--metrics 0.0.0.0:0", "--insecure"], "0.0.0.0:0"), (["must be HOST:PORT"], "9464")):
        result = subprocess.run([test.programs_at["fire3dv"], test.scene, "--headless", "--cache", "off", "--metrics", at],
                                capture_output=True, text=True, timeout=HANG_S, env=vulkan_environment(), check=False)
        last = result.stderr.splitlines()[-1]
        check(result.returncode == 1 and all(word in last for word in words), f"{at}: {result.returncode} {last}")


def reader(test):
    """Negative control: the reader refuses input that Prometheus refuses."""
    for wrong in ("a 1", "# TYPE a gauge\na 1\n", "# HELP a b\n# TYPE a gauge\na 1\na 2\n", "# HELP a b\n# TYPE a gauge\na{x=y} 1\n",
                  "# HELP a b\n# TYPE a gauge\na 1,5\n", "# HELP a b\n# TYPE a counter\na 1\n", "# HELP a b\n# TYPE a gauge\nb 1\n",
                  '# HELP a b\n# TYPE a gauge\na{x="\n"} 1\n', '# HELP a b\n# TYPE a gauge\na{x="1",x="2"} 1\n'):
        try:
            Page(wrong)
        except Exception:  # pylint: disable=broad-except
            continue
        check(False, f"was taken: {wrong}")


CASES = {"numbers": numbers, "visitors": visitors, "addresses": addresses, "reader": reader}

if __name__ == "__main__":
    main(CASES, ["fire3dv", "publisher"])
