#!/usr/bin/env python3
"""End-to-end test of the drawing time of peers: expensive content of one does not slow down the images of another. A bar
code in the scene proves what an image shows. Counts images and states, not times.

draw_time_test.py FIRE3DV [CASE...]; FIRE3DV_CLIENT_LIBRARY and PYTHONPATH lead to the Python package.
"""
import json
import os
import signal
import struct
import sys

import numpy

import barcode
import fire3dv
from harness import HANG_S, Program, main, vulkan_environment, wait_until
from image_reader import check
from prometheus import scrape, url_of

RED = (1.0, 0.0, 0.0)
FRONT = barcode.DISTANCE / 2  # between the bars and the camera


def renderer_of(test, uri, *arguments, is_on_request=True):
    scene = test.path("barcode.glb")
    barcode.write_scene(scene)
    command = [test.programs_at["fire3dv"], scene, "--validation", "--headless", "--tone-map", "none", "--cache", "off",
               "--background", "000000", "--size", f"{barcode.SIZE[0]}x{barcode.SIZE[1]}", "--camera", barcode.CAMERA,
               "--listen", uri, "--metrics", "127.0.0.1:0", *(["--on-request"] if is_on_request else []), *arguments]
    renderer = Program(test, "fire3dv", command, vulkan_environment())
    renderer.wait_err("listening on")
    return renderer


def uri_of(renderer):
    return renderer.wait_err(r"listening on (tcp://\S+)").group(1)


def stop(renderer):
    renderer.signal(signal.SIGTERM)
    renderer.expect_exit(0)


def open_stream(uri, name, nodes=()):
    stream = fire3dv.Stream(uri, adapter_name=name)
    stream.describe(list(nodes))
    return stream


class Honest:
    """Simulator that waits for the image of each frame."""

    def __init__(self, uri):
        self.stream = open_stream(uri, "honest", barcode.NAMES)
        self.number = self.hidden_streams = 0

    def image(self, **options):
        self.number += 1
        sequence = self.stream.publish(1000 * self.number, barcode.poses_of(self.number))
        request = self.stream.request_image(*barcode.SIZE, node=barcode.CAMERA, markers=True, sequence=sequence, **options)
        with request.wait(HANG_S) as image:
            self.hidden_streams = image.hidden_streams
            return image["color_srgb8"].copy(), image.sequence

    def shows_bars(self):
        color, sequence = self.image()
        return barcode.number_of(color) == sequence

    def shows_red(self):
        color, _ = self.image()
        return bool(((color[..., 0] > 200) & (color[..., 1] < 50)).any())


def large_triangles(count):
    """A glb of translucent triangles that cover the view."""
    data = numpy.tile(numpy.float32([(-99, -99, 0), (99, -99, 0), (0, 199, 0)]), (count, 1)).tobytes()
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": "cover", "mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"alphaMode": "BLEND", "doubleSided": True, "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 0.5]}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3 * count, "type": "VEC3",
                       "min": [-99, -99, 0], "max": [99, 199, 0]}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(data)}], "buffers": [{"byteLength": len(data)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)) + struct.pack("<I4s", len(text), b"JSON") + text +
            struct.pack("<I4s", len(data), b"BIN\0") + data)


AT = numpy.tile(numpy.float32([0, 0, FRONT]), (20_000, 1))


def points(stream, is_large):
    stream.points("load", AT if is_large else AT[:1], colors=RED, size_px=1000 if is_large else 3)


def triangles(stream, is_large):
    corners = numpy.float32([(-99, -99, FRONT), (99, -99, FRONT), (0, 199, FRONT)])
    stream.triangles("load", numpy.tile(corners, (50_000, 1)) if is_large else 0.005 * corners + AT[:1], colors=RED)


def texts(stream, is_large):
    count = 1000 if is_large else 1
    stream.text("load", ["W" * (1000 if is_large else 1)] * count, AT[:count], colors=RED, size_px=200 if is_large else 6)


def asset(stream, is_large):
    if is_large:
        stream.add_node("load", parent_from_node=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, FRONT], asset_glb=large_triangles(100_000))
    else:
        stream.remove_node("load")
        stream.points("small", AT[:1], colors=RED, size_px=3)


LOADS = {"points": points, "triangles": triangles, "texts": texts, "asset": asset}


def compile_pipelines(honest, load):
    """The driver compiles what draws small content with its first image. That may take longer than an image of another peer may."""
    (points if load is asset else load)(honest.stream, False)
    wait_until(lambda: "the small content of its requester", honest.shows_red)
    honest.stream.clear_marker("load")
    wait_until(lambda: "an image without it", honest.shows_bars)


def is_hidden(renderer, name):
    page = scrape(url_of(renderer))
    streams = [dict(labels) for family, labels in page.samples if family == "fire3dv_stream_info"]
    return any(page.get("fire3dv_stream_content_hidden", stream=of["stream"]) == 1 for of in streams if of["name"] == name)


def hides(test, load):
    """Expensive content is never drawn beside another peer; it returns once it is small, and when its peer is alone."""
    renderer = renderer_of(test, "tcp://127.0.0.1:0")
    uri = uri_of(renderer)
    honest = Honest(uri)
    compile_pipelines(honest, load)
    for _ in range(20):
        check(honest.shows_bars(), "the bars are not shown at first")
    with open_stream(uri, "greedy") as greedy:
        load(greedy, True)

        def warned():
            check(honest.shows_bars(), "an image shows the expensive content")
            return any('"greedy"' in line and "it is hidden while" in line for line in renderer.err)
        wait_until(lambda: f"the warning; last: {renderer.err[-3:]}", warned)
        for _ in range(20):
            check(honest.shows_bars(), "an image shows hidden content")
            check(honest.hidden_streams == 1, f"the image says {honest.hidden_streams} hidden streams")
        try:
            honest.image(complete=True)
            check(False, "an image without hidden content comes for a complete one")
        except fire3dv.RefusedError as refused:
            check('stream "greedy" is hidden' in str(refused), f"refused for another reason: {refused}")
        wait_until(lambda: "hidden content in the metrics", lambda: is_hidden(renderer, "greedy"))
        check(not is_hidden(renderer, "honest"), "the other peer is hidden")
        load(greedy, False)
        wait_until(lambda: "the small content", honest.shows_red)
        check(honest.hidden_streams == 0, "an image with all content says that some is hidden")
        honest.image(complete=True)
        wait_until(lambda: "the return in the metrics", lambda: not is_hidden(renderer, "greedy"))
        check(any("shown again" in line for line in renderer.err), "the return is not logged")
    honest.stream.close()
    check(sum("it is hidden while" in line for line in renderer.err) == 1, "the warning is repeated")
    stop(renderer)


KILLED = """
import sys, time, numpy, fire3dv
with fire3dv.Stream(sys.argv[1], adapter_name="greedy") as stream:
    stream.describe([])
    stream.points("load", numpy.tile(numpy.float32([0, 0, float(sys.argv[2])]), (20_000, 1)), colors=(1.0, 0.0, 0.0), size_px=1000)
    time.sleep(600)
"""


def killed(test):
    """Content of a peer that was killed stays for a grace time, and hidden."""
    renderer = renderer_of(test, "tcp://127.0.0.1:0")
    uri = uri_of(renderer)
    honest = Honest(uri)
    check(honest.shows_bars(), "the bars are not shown at first")
    greedy = Program(test, "greedy", [sys.executable, "-c", KILLED, uri, str(FRONT)], dict(os.environ))

    def warned():
        check(honest.shows_bars(), "an image shows the expensive content")
        return any('"greedy"' in line and "--peer-limit draw-time=off" in line for line in renderer.err)
    wait_until(lambda: f"the warning; last: {renderer.err[-3:]}", warned)
    greedy.kill()
    wait_until("the end of its connection", lambda: honest.shows_bars() and renderer.find_err('"greedy" ended'))
    for _ in range(20):
        check(honest.shows_bars(), "an image shows the content of a peer that is gone")
    honest.stream.close()
    stop(renderer)


def alone(test):
    """One peer alone sees all of its content, and so it does after others have left."""
    renderer = renderer_of(test, "tcp://127.0.0.1:0")
    uri = uri_of(renderer)
    honest = Honest(uri)
    small = AT[:2000]
    honest.stream.points("load", small, colors=RED, size_px=1000)
    wait_until(lambda: "the content of one peer", lambda: not honest.shows_bars())
    with open_stream(uri, "other") as other:
        other.publish(1, numpy.zeros((0, 12), numpy.float32))
        for _ in range(20):
            check(not honest.shows_bars(), "the requester's own content is hidden from it")
        check(not is_hidden(renderer, "honest"), "content is hidden from nobody")
    honest.stream.close()
    check(not any("draw-time" in line for line in renderer.err), "a warning without a reason")
    stop(renderer)


def off(test):
    renderer = renderer_of(test, "tcp://127.0.0.1:0", "--peer-limit", "draw-time=off")
    uri = uri_of(renderer)
    honest = Honest(uri)
    with open_stream(uri, "greedy") as greedy:
        greedy.points("load", AT[:1000], colors=RED, size_px=1000)
        wait_until(lambda: "the content", lambda: not honest.shows_bars())
        for _ in range(20):
            check(not honest.shows_bars(), "content is hidden")
        page = scrape(url_of(renderer))
        check(page.total("fire3dv_stream_drawing_seconds_total") > 0, "no cost is measured")
    honest.stream.close()
    stop(renderer)


def files(test):
    """Images in files name the streams whose content they lack."""
    folder = test.path("images")
    renderer = renderer_of(test, "tcp://127.0.0.1:0", "--out", folder, is_on_request=False)
    uri = uri_of(renderer)
    with open_stream(uri, "honest", barcode.NAMES) as honest, open_stream(uri, "greedy") as greedy:
        honest.publish(1000, barcode.poses_of(1))

        def lines():
            path = os.path.join(folder, "frames.jsonl")
            if not os.path.exists(path):
                return []
            with open(path, encoding="utf-8") as file:
                return [json.loads(line) for line in file if line.endswith("\n")]
        wait_until(lambda: "an image", lines)
        points(greedy, True)
        line = wait_until(lambda: "a line of hidden content",
                          lambda: next((one for one in lines() if one.get("hidden_streams") == ["greedy"]), None))
        check("hidden_streams" not in lines()[0], "the first image lacks nothing")
    stop(renderer)
    with open(os.path.join(folder, line["file"]), "rb") as file:
        check(b"HiddenStream\0greedy" in file.read(), "the PNG file does not name the hidden stream")


WIDE, NARROW = 0.1, 1000  # f-numbers: the widest circles of confusion, and none


def blurred(test):
    """Depth of field of a large image takes a minute. Beside another peer it is refused; for one peer alone it counts no memory."""
    renderer = renderer_of(test, "tcp://127.0.0.1:0", "--peer-limit", "gpu-bytes=40MiB")
    uri = uri_of(renderer)
    with open_stream(uri, "greedy") as greedy:
        def request(side, f_number):
            sequence = greedy.publish(0, numpy.zeros((0, 12), numpy.float32))
            return greedy.request_image(side, side, node=barcode.CAMERA, f_number=f_number, focus_distance_m=0.5, sequence=sequence)

        def expect_refusal(side, f_number, reason):
            try:
                request(side, f_number).wait(HANG_S).close()
                check(False, f"an image of {side} pixels is drawn beside another peer")
            except fire3dv.RefusedError as refused:
                check(reason in str(refused), f"refused for another reason: {refused}")
        request(1024, NARROW).wait(HANG_S).close()  # 80 MiB
        honest = Honest(uri)
        check(honest.shows_bars(), "the bars are not shown")
        expect_refusal(1024, NARROW, "device memory would use 80 MiB")
        expect_refusal(700, WIDE, "with depth of field was given up after")
        check(honest.shows_bars(), "the bars are not shown after the refusal")
        request(16, WIDE).wait(HANG_S).close()
        honest.stream.close()
    stop(renderer)


CASES = {f"hides_{name}": lambda test, load=load: hides(test, load) for name, load in LOADS.items()}
CASES.update({"killed": killed, "alone": alone, "off": off, "files": files, "blurred": blurred})

if __name__ == "__main__":
    main(CASES, ["fire3dv"])
