#!/usr/bin/env python3
"""End-to-end test of --serve over time: memory stays flat, a page behind a slow network stays live, and path-traced images
refine."""
import ctypes
import json
import os
import re
import statistics
import struct
import subprocess
import sys
import time
import urllib.request

from chromium import WebSocketClient
from harness import Publisher, main
from hosts import SKIPPED, Host, cable, why_not
from image_reader import check
from jupyter_proxy import JupyterProxy
from live_session import LiveRenderer, Session

# Full numbers, by hand: FIRE3DV_LIVE_FRAMES=10000 FIRE3DV_LIVE_RECONNECTS=1000.
FRAMES = int(os.environ.get("FIRE3DV_LIVE_FRAMES", "600"))
RECONNECTS = int(os.environ.get("FIRE3DV_LIVE_RECONNECTS", "130"))
WIDTH, HEIGHT = 256, 192
MAX_GROWTH_BYTES = 12 << 20


def receive_image(viewer):
    """The number of the next image."""
    while True:
        kind, payload = viewer.receive()
        if kind == 2:
            return struct.unpack_from("<I", payload)[0]
        check(kind == 1, f"the renderer closed the connection: {payload}")


def resident_bytes(process):
    with open(f"/proc/{process.pid}/status", encoding="ascii") as status:
        return sum(1024 * int(line.split()[1]) for line in status if line.startswith(("RssAnon:", "RssShmem:")))


def memory(test):
    """Memory does not grow with images and viewers: one image kept for each viewer that left would exceed the bound."""
    check(RECONNECTS * WIDTH * HEIGHT * 4 > 2 * MAX_GROWTH_BYTES, "too few viewers for this bound")
    live = LiveRenderer(test)

    def images(count, h264):
        viewer = live.viewer(WIDTH, HEIGHT, h264)
        for _ in range(count):
            viewer.send(json.dumps({"type": "shown", "image": receive_image(viewer)}))
            viewer.send('{"type":"orbit","yaw":0.03,"pitch":0}')
        viewer.close()

    def reconnect(count):
        for i in range(count):
            viewer = live.viewer(WIDTH, HEIGHT, h264=i % 2 == 0)
            if i % 3 != 0:  # otherwise it leaves before its first image comes
                receive_image(viewer)
            viewer.close()
    images(100, False)
    images(100, True)
    reconnect(30)
    before = resident_bytes(live.renderer.process)
    for name, work in ((f"{FRAMES} images", lambda: (images(FRAMES // 2, False), images(FRAMES // 2, True))),
                       (f"{RECONNECTS} viewers", lambda: reconnect(RECONNECTS))):
        begun = time.monotonic()
        work()
        growth = resident_bytes(live.renderer.process) - before
        print(f"{name} in {time.monotonic() - begun:.0f} s: {before / 2**20:.0f} MiB before, growth {growth / 2**20:.1f} MiB", flush=True)
        check(growth < MAX_GROWTH_BYTES, f"memory has grown by {growth} bytes")
    live.renderer.signal(15)
    live.renderer.expect_exit(0)


SPP = 12


class PathViewer:
    """A viewer without a browser, and the messages that it has received."""

    def __init__(self, live, link=None):
        self.socket = live.viewer(48, 32, link=link)
        self.last, self.is_refined, self.samples, self.messages = 0, False, [], {}

    def send(self, **message):
        self.socket.send(json.dumps(message))

    def receive(self):
        """Returns the image's header, if it is one: whether it is refined."""
        kind, payload = self.socket.receive()
        check(kind in (1, 2), f"the renderer closed the connection: {payload}")
        if kind == 1:
            message = json.loads(payload)
            self.messages[message["type"]] = message
            if message["type"] == "paths":
                self.samples.append(message["samples"])
            return None
        number, flags = struct.unpack_from("<I", payload)[0], payload[9]
        check(number == self.last + 1, f"image {number} follows {self.last}")
        self.last = number
        self.send(type="shown", image=number)
        self.is_refined = bool(flags & 1)
        return self.is_refined

    def image(self):
        """Whether the next image is refined."""
        while (refined := self.receive()) is None:
            pass
        return refined

    def until(self, message, **fields):
        """Receives until the last message of this type has these fields."""
        while any(self.messages.get(message, {}).get(name) != value for name, value in fields.items()):
            self.receive()

    def refine(self):
        """Receives until the image is whole; returns the samples told since the last whole one."""
        while not self.image():
            pass
        self.until("paths", samples=SPP, samples_per_pixel=SPP)
        samples, self.samples = self.samples, []
        return samples


def paths(test):
    """Path-traced images refine up to --spp, then none is sent until something changes: camera, edit or renderer."""
    live = LiveRenderer(test, "--render", "path", "--spp", str(SPP), "--bounces", "1")
    first = PathViewer(live)
    samples = first.refine()
    check(samples[0] == 0, f"samples of the first image: {samples}")

    def expect_silence(viewer, change):
        """No image comes before the change: the next one is not refined, if the change moves something."""
        last = viewer.last
        time.sleep(0.3)  # images that come in vain have time to come
        change()
        refined = viewer.image()
        check(viewer.last == last + 1, f"{viewer.last - last - 1} images were sent in vain")
        return refined
    check(not expect_silence(first, lambda: first.send(type="orbit", yaw=0.5, pitch=0)), "a moved camera shows the old image")
    samples = first.refine()
    check(0 in samples, f"a moved camera goes on with the old samples: {samples}")
    # A second view refines beside the first one, which stays.
    second = PathViewer(live, live.view)
    second.send(type="orbit", yaw=-0.7, pitch=0.2)
    second.refine()
    for setting, control, value in (("tone-map", 0, "1000"), ("tone-map", 7, "none"), ("samples", 0, "1"), ("shadows", 0, "off"), ("x", 0, "")):
        first.send(type="setting", setting=setting, control=control, value=value)  # no such value or control, not for pages, raster: no effect
    # Tone mapping applies to the samples that are there.
    refined = expect_silence(first, lambda: first.send(type="setting", setting="tone-map", control=0, value="none"))
    check(refined and min(first.samples, default=SPP) == SPP, f"other tone mapping starts again: {refined}, {first.samples}")
    check(second.image(), "other tone mapping starts the other view again")
    second.samples.clear()
    # More views than refine at a time.
    others = [PathViewer(live, live.view) for _ in range(4)]
    for i, other in enumerate(others):
        other.send(type="orbit", yaw=0.3 * (i + 1), pitch=0.1)
    for other in others:
        other.refine()
    for other in others:
        other.socket.close()
    # A picked node needs no new image.
    first.send(type="pick", x=0.5, y=0.5)
    first.until("picked", type="picked")
    check(second.last and "picked" not in second.messages, "another viewer has picked")
    # A hidden node changes all views.
    scene = first.messages["scene"]["scene"]
    check(not expect_silence(first, lambda: first.send(type="hide", node=0, scene=scene, hidden=True)), "an edit shows the old image")
    for viewer in (first, second):
        samples = viewer.refine()
        check(0 in samples, f"an edit goes on with the old samples: {samples}")
    # Raster, and paths again.
    first.is_refined = second.is_refined = False
    first.send(type="setting", setting="render", control=0, value="raster")
    for viewer in (first, second):
        viewer.until("paths", samples_per_pixel=0)
        while not viewer.is_refined:
            viewer.receive()
    first.send(type="setting", setting="render", control=0, value="path")
    for viewer in (first, second):
        viewer.refine()
        viewer.socket.close()
    live.renderer.signal(15)
    live.renderer.expect_exit(0)


def late_shadows(test):
    """A viewer switches shadows on that were off at the start: another renderer draws them."""
    live = LiveRenderer(test, "--render", "raster", "--shadows", "off")
    viewer = PathViewer(live)

    def until(value):
        def found():
            controls = viewer.messages.get("settings", {}).get("controls", [])
            return next((control for control in controls if control["setting"] == "shadows"), {})
        while found().get("value") != value:
            viewer.receive()
        check(found()["enabled"] and not found()["missing"], f"the control of shadows: {found()}")
    until("off")
    viewer.image()
    viewer.send(type="setting", setting="shadows", control=0, value="map")
    until("map")
    viewer.image()
    viewer.socket.close()
    live.renderer.signal(15)
    live.renderer.expect_exit(0)


RATE = "1mbit"
SIM_STEP_S = 0.01  # of publisher.cpp
MAX_MEDIAN_LAG_S, MAX_LAG_S = 1.0, 3.0


def enter(host):
    """This process and its later children use the host's network."""
    libc = ctypes.CDLL(None, use_errno=True)
    with open(f"/proc/{host.pid}/ns/net", encoding="ascii") as namespace:
        check(libc.setns(namespace.fileno(), 0x40000000) == 0, f"setns: {os.strerror(ctypes.get_errno())}")


def slow(test):
    """Through 1 Mbit/s a page shows the present, with smaller images, as video and as JPEG."""
    missing = why_not()
    if missing:
        print(f"skipped: {missing}")
        sys.exit(SKIPPED)
    far, near = Host(test, "renderer"), Host(test, "browser")
    cable(far, near, "10.73.0")
    shaped = subprocess.run([*far.enter, "tc", "qdisc", "add", "dev", "cable0", "root", "tbf", "rate", RATE, "burst", "6kb", "latency", "300ms"],
                            capture_output=True, text=True, check=False)
    if shaped.returncode != 0:
        print(f"skipped: tc cannot shape here: {shaped.stderr}")
        sys.exit(SKIPPED)
    enter(near)
    uri = test.fresh_uri("shm")
    address = "http://10.73.0.1:8080"
    # WebCodecs need a secure context.
    session = Session(test, "--listen", uri, "--insecure", at="10.73.0.1:8080", host=far,
                      browser=(f"--unsafely-treat-insecure-origin-as-secure={address}",))
    begun = time.monotonic()
    files = sum(len(urllib.request.urlopen(f"{address}/{name}", timeout=60).read()) for name in ("style.css", "main.js", "input.js", "nodes.js"))
    check(time.monotonic() - begun > 0.4 * files * 8e-6, f"{files} bytes came faster than through {RATE}")
    publisher = Publisher(test, uri, nodes=["nothing"])
    publisher.do("stream 100")
    image = "JSON.parse(document.getElementById('canvas').dataset.image ?? '{}')"
    try:
        for codec, script in (("h264", ""), ("jpeg", "delete window.VideoDecoder")):
            page = session.browser.page()
            page.size(640, 480)
            page.call("Page.addScriptToEvaluateOnNewDocument", source=script)
            page.open(session.control.replace("/#", "/?embed=1#"))
            page.wait("an image", f"{image}.number > 0")
            page.call("Page.bringToFront")
            page.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowLeft", code="ArrowLeft")  # all pixels change
            time.sleep(4)
            first, lags, widths = page.evaluate(f"{image}.number"), [], []
            begun = time.monotonic()
            while time.monotonic() < begun + 5:
                shown = page.evaluate(image)
                check(shown["codec"] == codec, f"{shown['codec']}, not {codec}")
                lags.append(publisher.do("stream 100")["sequence"] * SIM_STEP_S - shown["simTimeS"])
                widths.append(shown["width"])
                time.sleep(0.1)
            rate = (page.evaluate(f"{image}.number") - first) / (time.monotonic() - begun)
            page.call("Input.dispatchKeyEvent", type="keyUp", key="ArrowLeft", code="ArrowLeft")
            print(f"{codec} through {RATE}: lag {statistics.median(lags):.2f} s, at most {max(lags):.2f} s; {rate:.1f} images/s, "
                  f"{statistics.mean(widths):.0f} pixels wide", flush=True)
            check(statistics.median(lags) < MAX_MEDIAN_LAG_S and max(lags) < MAX_LAG_S, "the page is behind")
            check(rate > 1, "the page stands still")
            page.call("Page.navigate", url="about:blank")
    finally:
        session.end()


def jupyter(test):
    """Through jupyter-server-proxy the page's files and images come, for the hub's origin alone."""
    hub = "hub.example"
    live = LiveRenderer(test, "--allow-origin", f"https://{hub}")
    proxy = JupyterProxy()
    path = f"/user/ann/proxy/{live.host.split(':')[1]}/"

    def viewer(origin):
        # As Chromium offers it.
        return WebSocketClient("127.0.0.1", proxy.port, path + "socket", origin=origin, host_header=hub,
                               more=["Sec-WebSocket-Extensions: permessage-deflate; client_max_window_bits", "Cookie: _xsrf=1"])
    page = urllib.request.urlopen(urllib.request.Request(f"http://127.0.0.1:{proxy.port}{path}", headers={"Host": hub}), timeout=60).read().decode()
    names = re.findall(r'(?:src|href)="([^"]+)"', page)
    check(names and not any(name.startswith("/") or "//" in name for name in names), f"not relative to the page: {names}")
    for name in names:
        request = urllib.request.Request(f"http://127.0.0.1:{proxy.port}{path}{name}", headers={"Host": hub})
        check(urllib.request.urlopen(request, timeout=60).read(), f"{name} is empty")
    client = viewer(f"https://{hub}")
    check(client.status == 101, f"no WebSocket: {client.status} {proxy.errors}")
    client.send('{"type":"hello","token":"%s"}' % live.control.split("#")[1])
    while b'"welcome"' not in client.receive()[1]:
        pass
    client.send('{"type":"size","width":%d,"height":%d}' % (WIDTH, HEIGHT))
    first = receive_image(client)
    client.send(json.dumps({"type": "shown", "image": first}))
    client.send('{"type":"orbit","yaw":0.3,"pitch":0}')
    check(receive_image(client) > first, "no second image")
    client.close()
    other = viewer("https://other.example")
    check(other.status == 500 and any("--allow-origin https://other.example" in error for error in proxy.errors), f"{other.status} {proxy.errors}")
    proxy.close()


if __name__ == "__main__":
    main({"memory": memory, "jupyter": jupyter, "paths": paths, "late_shadows": late_shadows, "slow": slow}, ["fire3dv", "bullet_arm", "publisher"])
