#!/usr/bin/env python3
"""End-to-end test of --serve over time: memory stays flat, and a page behind a slow network stays live."""
import ctypes
import json
import os
import statistics
import struct
import subprocess
import sys
import time
import urllib.request

from harness import Publisher, main
from hosts import SKIPPED, Host, cable, why_not
from image_reader import check
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
            while time.monotonic() < begun + 10:
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


if __name__ == "__main__":
    main({"memory": memory, "slow": slow}, ["fire3dv", "bullet_arm", "publisher"])
