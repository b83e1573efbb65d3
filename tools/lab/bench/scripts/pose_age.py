"""Pose age at frame submission, from the renderer's --stats."""
import csv
import json
import os
import signal
import statistics
import struct
import time

from transport_faults import HANG_S, Publisher, Reader, Trouble, fresh_uri

BINS_MS = (0.25, 0.5, 1, 2, 4, 8, 16, 33)


def write_scene(path, bodies):
    """A glb of small triangles, one a body, by the names that fire3dv-bench publishes."""
    binary = struct.pack("<9f", -0.1, -0.1, 0, 0.1, -0.1, 0, 0, 0.1, 0)
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(bodies + 1))}],
        "nodes": [{"name": f"body {i}", "mesh": 0} for i in range(bodies)] + [{"camera": 0, "translation": [0, 0, 5]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-0.1, -0.1, 0],
                       "max": [0.1, 0.1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": len(binary)}], "buffers": [{"byteLength": len(binary)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def ages_ms(programs, link, rate_hz, poses, scene, seconds, folder, options):
    uri, stats = fresh_uri(link), os.path.join(folder, "stats.csv")
    publisher = Publisher(programs["fire3dv-bench"], uri, rate_hz, poses)
    reader = Reader([programs["fire3dv"], scene, "--headless", "--listen", uri, "--stats", stats, "--play", "latest",
                     "--cache", "off", *options])
    try:
        publisher.wait_for_reader()
        time.sleep(seconds)
        reader.signal(signal.SIGTERM)
        reader.process.wait(HANG_S)
    finally:
        reader.end()
        publisher.end()
    with open(stats, encoding="utf-8", newline="") as file:
        ages = [float(row["pose_age_ms"]) for row in csv.DictReader(file) if row["pose_age_ms"]]
    if not ages:
        raise Trouble("no frame shows a pose:\n" + "".join(reader.said))
    return ages


def tables(programs, scene, seconds, poses, folder, options, links, rates=(60, 1000)):
    edges = [f"to {edge:g}" for edge in BINS_MS] + [f"over {BINS_MS[-1]:g}"]
    yield "| link | Hz | frames | median ms | p99 | " + " | ".join(edges) + " |"
    yield "|---" * (5 + len(edges)) + "|"
    for rate_hz in rates:
        for link in links:
            ages = ages_ms(programs, link, rate_hz, poses, scene, seconds, folder, options)
            counts = [0] * (len(BINS_MS) + 1)
            for age in ages:
                counts[sum(age > edge for edge in BINS_MS)] += 1
            p99 = sorted(ages)[int(0.99 * (len(ages) - 1))]
            cells = [f"{link}://", f"{rate_hz:g}", str(len(ages)), f"{statistics.median(ages):.2f}", f"{p99:.2f}"]
            cells += [f"{100 * count / len(ages):.0f} %" for count in counts]
            yield "| " + " | ".join(cells) + " |"
