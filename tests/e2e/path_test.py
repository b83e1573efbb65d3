#!/usr/bin/env python3
"""End-to-end test of --render path: the PNG names its settings, the same seed gives the same bytes, the image resembles
the raster's, and combinations that make no sense are refused with the remedy."""
import base64
import json
import os
import struct

from harness import Program, main, vulkan_environment
from image_reader import check, read_png

CORNERS = [(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)]


def write_scene(test):
    data = b"".join(struct.pack("<3f", *p) for p in CORNERS) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    document = {
        "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"],
        "nodes": [{"name": "floor", "mesh": 0},
                  {"name": "lines", "mesh": 1, "translation": [0, -1, 0]},
                  {"name": "eye", "camera": 0, "translation": [0, 2, 0], "rotation": [-0.70710678, 0, 0, 0.70710678]},
                  {"name": "lamp", "translation": [0, 1, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "scenes": [{"nodes": [0, 1, 2, 3]}], "scene": 0,
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 3}]}},
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.01}}],
        "buffers": [{"uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
                     "byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, -1],
                       "max": [1, 0, 1]},
                      {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1], "metallicFactor": 0}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]},
                   {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 1}]}],
    }
    path = test.path("scene.gltf")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(document, file)
    return path


def run(test, *arguments):
    program = Program(test, "fire3dv", [test.programs_at["fire3dv"], *arguments], env=vulkan_environment())
    return program.wait(), program.stderr_text()


def draw(test, scene, out, *arguments):
    """Returns the bytes of the PNG, the image and what was said."""
    folder = test.path(out)
    status, said = run(test, scene, "--validation", "--headless", "--frames", "1", "--size", "32x24", "--cache", "off",
                       "--environment-intensity", "0.2", "--out", folder, *arguments)
    check(status == 0, said)
    with open(os.path.join(folder, "frame_000000.png"), "rb") as file:
        data = file.read()
    return data, read_png(os.path.join(folder, "frame_000000.png")), said


def images(test):
    scene = write_scene(test)
    path = ("--render", "path", "--spp", "32", "--bounces", "2", "--seed", "5")
    data, image, said = draw(test, scene, "path", *path)
    check("path-traced by ray query, 32 samples per pixel, 2 bounces, seed 5" in said, said)
    check("warning: paths: 1 primitive of lines or points left out" in said, said)
    for chunk in (b"Renderer\0path", b"SamplesPerPixel\x0032", b"Bounces\x002", b"Seed\x005"):
        check(chunk in data, f"the PNG lacks {chunk}")
    with open(os.path.join(test.path("path"), "frames.jsonl"), encoding="utf-8") as file:
        entry = json.loads(file.read())
    check((entry["renderer"], entry["samples_per_pixel"], entry["bounces"], entry["seed"]) == ("path", 32, 2, 5), entry)
    again, _, _ = draw(test, scene, "again", *path)
    check(again == data, "the same seed gives other bytes")
    other, _, _ = draw(test, scene, "other", *path[:-1], "6")
    check(other != data, "another seed gives the same bytes")
    plain, raster, _ = draw(test, scene, "raster")
    check(b"Renderer" not in plain, "the raster's PNG names a renderer")
    differences = [image.rows[y][x] - raster.rows[y][x] for y in range(4, 20) for x in range(3 * 8, 3 * 24)]
    check(abs(sum(differences) / len(differences)) < 1, f"the mean differs by {sum(differences) / len(differences)}")
    check(max(map(abs, differences)) <= 16, f"a byte differs by {max(map(abs, differences))}")


def refusals(test):
    scene = write_scene(test)
    headless = ("--headless", "--out", test.path("none"))
    for arguments, remedy in (
            (("--spp", "4"), "--spp needs --render path"),
            (("--seed", "4", "--headless", "--frames", "1"), "--seed needs --render path"),
            (("--render", "path"), "add --headless --frames 1 --out DIR"),
            (("--render", "path", *headless), "add --frames 1"),
            (("--render", "path", *headless, "--frames", "1", "--shadows", "map"), "leave --shadows"),
            (("--render", "path", *headless, "--frames", "1", "--view", "depth"), "exclude each other"),
            (("--render", "path", "--headless", "--frames", "1", "--listen", "shm://path_test"), "record the stream"),
            (("--render", "path", *headless, "--frames", "1", "--serve", "127.0.0.1:0"), "record the stream"),
            (("--render", "path", *headless, "--frames", "1", "--spp", "0"), "--spp"),
            (("--render", "paths"), "--render")):
        status, said = run(test, scene, *arguments)
        check(status == 2 and remedy in said, f"{arguments}: {status}, {said}")


if __name__ == "__main__":
    main({"images": images, "refusals": refusals}, ["fire3dv"])
