#!/usr/bin/env python3
"""Latency of the live view, from publishing a pose to the pixel on the page's canvas, as rows of a Markdown table.

    live_latency.py --programs build/lab/bin --client build/lab/lib/libfire3dv-client.so [--seconds 20] [--size 640x480]
                    [-- OPTIONS OF FIRE3DV]

A bright green box moves between two places in the robot arm's scene. Headless Chromium shows the page on loopback. The script searches
a pixel that is green in one place only; the page reads this pixel from its canvas after each image, with the time. An image counts if its
pixel agrees with the pose that was published with the image's simulation time. Rows:

  one frame   a frame every half a second, from rest
  30 Hz       a stream; images of frames that a newer one replaced do not exist and do not count

Images of full size alone count; "full size" is their share. A machine that draws more slowly gets smaller images. Encoding is the
median time of the encoder for them, and its share of the median latency. Needs Chromium.
"""
import argparse
import base64
import os
import random
import statistics
import struct
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..", "..", "..")
sys.path[:0] = [os.path.join(ROOT, "tests", "e2e", "support"), os.path.join(ROOT, "adapters", "generic", "python")]
from chromium import Chromium  # noqa: E402
from glb_edit import edit_glb  # noqa: E402
from harness import Program, Test, vulkan_environment  # noqa: E402

PLACES_M = ((-0.25, 1.0, 0.3), (0.25, 1.0, 0.3))  # glTF axes, Y up
HALF_SIDE_M = 0.1
IMAGE = "JSON.parse(document.getElementById('canvas').dataset.image ?? '{}')"
PIXELS = """(() => {
  const canvas = document.getElementById("canvas");
  const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let text = "";
  for (let i = 0; i < data.length; i += 4) text += String.fromCharCode(data[i], data[i + 1], data[i + 2]);
  return [canvas.width, btoa(text)];
})()"""
OBSERVE = """(() => {
  const canvas = document.getElementById("canvas"), context = canvas.getContext("2d");
  window.seen = [];
  new MutationObserver(() => {
    const image = JSON.parse(canvas.dataset.image), pixel = context.getImageData(%d, %d, 1, 1).data;
    window.seen.push([(performance.timeOrigin + performance.now()) / 1000, Math.round(image.simTimeS * 1000), pixel[0], pixel[1], pixel[2], image.width,
                      image.encodeMs]);
  }).observe(canvas, {attributes: true, attributeFilter: ["data-image"]});
})()"""


def add_box(document, binary):
    """Adds the node "probe": a box of an unlit green material."""
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    triangles = [i for a, b, c, d in sides for i in (a, b, c, a, c, d)]
    for data, kind, target, count, extent in (
            (struct.pack("<24f", *(HALF_SIDE_M * v for corner in corners for v in corner)), "VEC3", 5126, 8, {"min": [-HALF_SIDE_M] * 3, "max": [HALF_SIDE_M] * 3}),
            (struct.pack("<36I", *triangles), "SCALAR", 5125, 36, {})):
        binary += bytes(-len(binary) % 4)
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": target, "count": count, "type": kind, **extent})
        binary += data
    accessors, materials = len(document["accessors"]), document["materials"]
    materials.append({"pbrMetallicRoughness": {"baseColorFactor": [0, 1, 0, 1]}, "doubleSided": True, "extensions": {"KHR_materials_unlit": {}}})
    document.setdefault("extensionsUsed", []).append("KHR_materials_unlit")
    document["meshes"].append({"primitives": [{"attributes": {"POSITION": accessors - 2}, "indices": accessors - 1, "material": len(materials) - 1}]})
    document["nodes"].append({"name": "probe", "mesh": len(document["meshes"]) - 1, "translation": list(PLACES_M[0])})
    document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
    return binary


class Simulator:
    """Publishes the box; frame n is in place n % 2, at n milliseconds of simulation time."""

    def __init__(self, uri):
        import fire3dv  # after FIRE3DV_CLIENT_LIBRARY is set
        self.stream = fire3dv.Stream(uri, "probe")
        self.stream.describe(["probe"])
        self.published_s = {}

    def publish(self):
        number = len(self.published_s) + 1
        x, y, z = PLACES_M[number % 2]
        self.published_s[number] = time.time()
        self.stream.publish(number * 1_000_000, [[1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z]])
        return number


def is_green(r, g, b):
    return g > 150 and r < 100 and b < 100


def probe_pixel(page, simulator):
    """A pixel in the middle of the box in place 1, and its background in place 0."""
    shots = {}
    for _ in range(2):
        number = simulator.publish()
        page.wait("a refined image of the frame", f"{IMAGE}.refined && Math.round({IMAGE}.simTimeS * 1000) === {number}")
        width, text = page.evaluate(PIXELS)
        data = base64.b64decode(text)
        shots[number % 2] = {i for i in range(len(data) // 3) if is_green(*data[3 * i:3 * i + 3])}
    only = sorted(shots[1] - shots[0])
    if not only:
        sys.exit("live_latency.py: the box is not in the image")
    return (round(statistics.mean(i % width for i in only)), round(statistics.mean(i // width for i in only)))


def measure(page, simulator, publish, full_width):
    """Latencies and times of encoding of the images of full size, in milliseconds, and the number of all images."""
    page.evaluate("window.seen = []")
    publish()
    time.sleep(1)
    latencies, encoding, known, count = [], [], 0, 0
    for at_s, number, r, g, b, width, encode_ms in page.evaluate("window.seen"):
        if number <= known:
            continue  # the refined image of a frame that was shown
        known, count = number, count + 1
        if is_green(r, g, b) != (number % 2 == 1):
            sys.exit(f"live_latency.py: frame {number} has the pixel {r}, {g}, {b}")
        if width == full_width:
            latencies.append(1000 * (at_s - simulator.published_s[number]))
            encoding.append(encode_ms)
    return sorted(latencies), encoding, count


def run(test, arguments):
    programs, size = os.path.abspath(arguments.programs), tuple(int(side) for side in arguments.size.split("x"))
    scene, uri = test.path("arm.glb"), test.fresh_uri("shm")
    subprocess.run([f"{programs}/bullet_arm", "--write-scene", scene], check=True, stdout=subprocess.DEVNULL)
    edit_glb(scene, scene, add_box)
    renderer = Program(test, "fire3dv", [f"{programs}/fire3dv", scene, "--headless", "--listen", uri, "--serve", "127.0.0.1:0",
                                         "--cache", "off", *arguments.options], vulkan_environment())
    link = renderer.wait_err(r"^  control  (http://\S+)$").group(1)
    print(f"{renderer.wait_err('device 0: (.*?);').group(1)}; {os.cpu_count()} CPU cores; {arguments.size}\n")
    print("| codec | frames | images | full size | median | 95 % | encoding | share |\n|---|---|---|---|---|---|---|---|")
    simulator = Simulator(uri)

    def one_frame():
        for _ in range(int(2 * arguments.seconds)):
            simulator.publish()
            time.sleep(0.4 + 0.2 * random.random())

    def stream():
        end, due = time.monotonic() + arguments.seconds, time.monotonic()
        while time.monotonic() < end:
            simulator.publish()
            due += 1 / 30
            time.sleep(max(0, due - time.monotonic()))

    browser = Chromium(test.folder)
    try:
        for codec, script in (("jpeg", "delete window.VideoDecoder"), ("h264", "")):
            page = browser.page()
            page.size(*size)
            page.call("Page.addScriptToEvaluateOnNewDocument", source=script)
            page.open(link.replace("/#", "/?embed=1#"))
            page.evaluate(OBSERVE % probe_pixel(page, simulator))
            for name, publish in (("one frame", one_frame), ("30 Hz", stream)):
                latencies, encoding, count = measure(page, simulator, publish, size[0])
                if not latencies:
                    print(f"| {codec} | {name} | {count} | 0 % | | | | |", flush=True)
                    continue
                median, late, encode_ms = statistics.median(latencies), latencies[int(0.95 * len(latencies))], statistics.median(encoding)
                print(f"| {codec} | {name} | {count} | {100 * len(latencies) / count:.0f} % | {median:.0f} ms | {late:.0f} ms | {encode_ms:.1f} ms | "
                      f"{100 * encode_ms / median:.0f} % |", flush=True)
            page.call("Page.navigate", url="about:blank")
    finally:
        browser.end()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", required=True, help="folder of fire3dv and bullet_arm")
    parser.add_argument("--client", required=True, help="client library of the same build")
    parser.add_argument("--seconds", type=float, default=20, help="of each row")
    parser.add_argument("--size", default="640x480", help="of the canvas")
    parser.add_argument("options", nargs="*", help="of fire3dv, after --")
    arguments = parser.parse_args()
    os.environ["FIRE3DV_CLIENT_LIBRARY"] = os.path.abspath(arguments.client)
    test = Test({})
    try:
        run(test, arguments)
    finally:
        test.end()


if __name__ == "__main__":
    main()
