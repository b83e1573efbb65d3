#!/usr/bin/env python3
"""Makes the images of docs/ that show the live view in a browser: tools/browser_images.py BUILD FOLDER [--all]

BUILD is the build folder. Needs Chromium and ffmpeg; the images have a palette of 256 colours. --all: each page in both
sizes and both colour schemes, to look at.
"""
import math
import os
import subprocess
import sys
import threading
import time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
BUILD, FOLDER = sys.argv[1:3]
os.environ.setdefault("FIRE3DV_CLIENT_LIBRARY", os.path.abspath(f"{BUILD}/lib/libfire3dv-client.so"))
sys.path[:0] = [os.path.join(ROOT, "tests", "e2e", "support"), os.path.join(ROOT, "adapters", "generic", "python")]
import fire3dv  # noqa: E402
from chromium import Chromium  # noqa: E402
from harness import Program, Test, vulkan_environment  # noqa: E402

DESKTOP, PHONE = ((1280, 720), False), ((390, 844), True)
IMAGE = "JSON.parse(document.getElementById('canvas').dataset.image ?? '{}')"
SMALL_ARM = os.path.join(ROOT, "tests", "assets", "robots", "arm_description", "urdf", "arm.urdf")


def write_small(source, path):
    subprocess.run(["ffmpeg", "-y", "-v", "error", "-i", source, "-filter_complex",
                    "split[a][b];[a]palettegen=reserve_transparent=0[p];[b][p]paletteuse=dither=none", "-frames:v", "1",
                    "-compression_level", "9", path], check=True)


def start(test, scene, *arguments):
    """A renderer; returns its control link."""
    renderer = Program(test, "fire3dv", [f"{BUILD}/bin/fire3dv", scene, "--headless", "--serve", "127.0.0.1:0", "--size", "32x32", "--shadows", "map",
                                         "--cache", "off", *arguments], vulkan_environment())
    return renderer.wait_err(r"^  control  (http://\S+)$").group(1)


def publish_pendulum(stream):
    """Scalars of a pendulum that swings; returns the time of the last one."""
    stream.describe([])
    for step in range(1500):
        t = step * 0.004
        angle, rate = 0.9 * math.exp(-0.15 * t) * math.cos(3.1 * t), -2.8 * math.exp(-0.15 * t) * math.sin(3.1 * t)
        stream.scalars("joints", round(t * 1e9), {"hinge": angle, "rate": rate}, units={"hinge": "rad", "rate": "rad/s"})
        stream.scalars("energy", round(t * 1e9), {"kinetic": 0.05 * rate**2, "potential": 0.48 * angle**2}, units={"kinetic": "J", "potential": "J"})
        time.sleep(0.001)  # the link keeps all of them
    stream.publish(round(t * 1e9), [])
    return round(t * 1e9)


def shoot(test, browser, resume, pause, link, name, size, touch, scheme, prepare):
    page = browser.page()
    page.size(*size, ratio=1, touch=touch, scheme=scheme)
    page.open(link)
    page.wait("an image", f"{IMAGE}.number > 0")
    if touch:
        page.evaluate("document.getElementById('toggle-panel').click()")
    prepare(page, size)
    number = page.evaluate(f"{IMAGE}.number")
    time.sleep(2)
    page.wait("a refined image", f"{IMAGE}.refined && {IMAGE}.number >= {number} && {IMAGE}.width > {size[0] // 2}")
    resume()
    page.wait("the streams", "[...document.querySelectorAll('.dot')].every((dot) => dot.matches('.live'))")
    page.screenshot(test.path(name))
    pause()
    write_small(test.path(name), os.path.join(FOLDER, name))
    page.call("Page.navigate", url="about:blank")


def show_plots(page, _):
    page.wait("the plots", "!document.getElementById('plots').hidden")
    page.evaluate("document.getElementById('plots').open = true")
    page.wait("the scalars", "document.querySelectorAll('#scalars input').length > 3")
    for i in (2, 3):
        page.evaluate(f"document.querySelectorAll('#scalars input')[{i}].click()")
    page.wait("values", "/rad/.test(document.querySelectorAll('#scalars output')[2].textContent)")
    x, y = page.evaluate("(() => { const c = document.getElementById('canvas'); return [c.clientWidth * 0.5, c.clientHeight * 0.55]; })()")
    page.click(x, y)
    page.wait("the picked node", "!document.getElementById('selection').hidden")


def show_joints(page, size):
    page.wait("the joints", "!document.getElementById('joints').hidden")
    page.evaluate("document.getElementById('joints').open = true")
    for i, share in enumerate((0.62, 0.4, 0.8)):
        page.evaluate(f"(() => {{ const s = document.querySelectorAll('#joint-list input')[{i}]; if (!s) return; "
                      f"s.value = Number(s.min) + {share} * (Number(s.max) - Number(s.min)); s.dispatchEvent(new Event('input')); }})()")
    page.mouse("mouseWheel", size[0] * 0.45, size[1] * 0.3, deltaX=0, deltaY=-250)


def main():
    test = Test({})
    browser = Chromium(test.folder)
    try:
        arm, uri, other_uri = test.path("arm.glb"), test.fresh_uri("shm"), test.fresh_uri("shm")
        subprocess.run([f"{BUILD}/bin/bullet_arm", "--write-scene", arm], check=True, stdout=subprocess.DEVNULL)
        link = start(test, arm, "--listen", uri, "--listen", other_uri)
        simulator = Program(test, "bullet_arm", [f"{BUILD}/bin/bullet_arm", "--to", uri])
        time.sleep(4)  # the arm has begun to work
        simulator.signal(19)  # stands still, so that images of full quality come
        joints_link = start(test, SMALL_ARM)
        shots = [("browser.png", link, *DESKTOP, "dark", show_plots), ("browser_phone.png", joints_link, *PHONE, "light", show_joints)]
        if "--all" in sys.argv:
            shots += [("desktop_light.png", link, *DESKTOP, "light", show_plots), ("phone_dark.png", link, *PHONE, "dark", show_plots),
                      ("joints_dark.png", joints_link, *DESKTOP, "dark", show_joints)]
        with fire3dv.Stream(other_uri, adapter_name="pendulum") as stream:
            end_ns = publish_pendulum(stream)
            is_live = threading.Event()  # streams stand still, so that images of full quality come

            def keep_live():
                while not has_ended.is_set():
                    if is_live.is_set():
                        stream.publish(end_ns, [])
                    time.sleep(0.05)

            def resume():
                simulator.signal(18)
                is_live.set()

            def pause():
                simulator.signal(19)
                is_live.clear()
            has_ended = threading.Event()
            keeper = threading.Thread(target=keep_live)
            keeper.start()
            try:
                for name, *shot in shots:
                    shoot(test, browser, resume, pause, shot[0], name, *shot[1:])
            finally:
                has_ended.set()
                keeper.join()
    finally:
        browser.end()
        test.end()


main()
