#!/usr/bin/env python3
"""Makes the images of docs/ that show the live view in a browser: tools/browser_images.py BIN FOLDER

BIN is the folder of the built programs. Needs Chromium and ffmpeg; the images have a palette of 256 colours.
"""
import os
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "tests", "e2e", "support"))
from chromium import Chromium  # noqa: E402
from harness import Program, Test, vulkan_environment  # noqa: E402

SHOTS = (("browser.png", (1120, 630), 1, False, "dark"), ("browser_phone.png", (390, 780), 1, True, "light"))


def write_small(source, path):
    subprocess.run(["ffmpeg", "-y", "-v", "error", "-i", source, "-filter_complex",
                    "split[a][b];[a]palettegen=reserve_transparent=0[p];[b][p]paletteuse=dither=none", "-frames:v", "1",
                    "-compression_level", "9", path], check=True)


def main(programs, folder):
    test = Test({})
    browser = Chromium(test.folder)
    try:
        arm, uri = test.path("arm.glb"), test.fresh_uri("shm")
        subprocess.run([f"{programs}/bullet_arm", "--write-scene", arm], check=True, stdout=subprocess.DEVNULL)
        renderer = Program(test, "fire3dv", [f"{programs}/fire3dv", arm, "--headless", "--listen", uri, "--serve", "127.0.0.1:0", "--size", "32x32",
                                             "--shadows", "map", "--cache", "off"], vulkan_environment())
        link = renderer.wait_err(r"^  control  (http://\S+)$").group(1)
        simulator = Program(test, "bullet_arm", [f"{programs}/bullet_arm", "--to", uri])
        renderer.wait_err("accepted")
        time.sleep(4)  # the arm has begun to work
        simulator.signal(19)  # stands still, so that images of full quality come
        for name, size, ratio, touch, scheme in SHOTS:
            page = browser.page()
            page.size(*size, ratio=ratio, touch=touch, scheme=scheme)
            page.open(link)
            image = "JSON.parse(document.getElementById('canvas').dataset.image ?? '{}')"
            page.wait("an image", f"{image}.number > 0")
            if touch:
                page.evaluate("document.getElementById('toggle-panel').click()")
            page.evaluate("[...document.querySelectorAll('#tree .label')].slice(0, 4).forEach((label) => label.previousSibling.click())")
            x, y = page.evaluate("(() => { const c = document.getElementById('canvas'); return [c.clientWidth * 0.5, c.clientHeight * 0.55]; })()")
            page.click(x, y)
            number = page.evaluate(f"{image}.number")
            time.sleep(2)
            page.wait("a refined image", f"{image}.refined && {image}.number >= {number} && {image}.width > {size[0] // 2}")
            simulator.signal(18)
            page.wait("the stream", "document.querySelector('.dot.live') !== null")
            page.screenshot(test.path(name))
            simulator.signal(19)
            write_small(test.path(name), os.path.join(folder, name))
    finally:
        browser.end()
        test.end()


main(*sys.argv[1:])
