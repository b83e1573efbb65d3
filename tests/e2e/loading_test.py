#!/usr/bin/env python3
"""End-to-end test of the scene cache: a cached scene gives the same image, and no fault of the cache ends a run."""
import glob
import json
import math
import os
import struct
import zlib

from harness import main, vulkan_environment
from image_reader import check


def png(colour):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(colour) * 8 for _ in range(8))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 8, 8, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_hill(folder, colour=(200, 40, 40)):
    """Writes a textured hill of 24 000 triangles: a .gltf, its .bin and its texture."""
    side = 110
    binary = bytearray()
    for y in range(side):
        for x in range(side):
            u, v = x / (side - 1), y / (side - 1)
            binary += struct.pack("<5f", 4 * u - 2, 4 * v - 2, math.exp(-8 * ((u - .5) ** 2 + (v - .5) ** 2)), u, v)
    vertices = len(binary)
    for y in range(side - 1):
        for x in range(side - 1):
            a = y * side + x
            binary += struct.pack("<6I", a, a + 1, a + side, a + side, a + 1, a + side + 1)
    count = side * side
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 5]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}],
        "textures": [{"source": 0}], "images": [{"uri": "colour.png"}],
        "buffers": [{"uri": "hill.bin", "byteLength": len(binary)}],
        "bufferViews": [{"buffer": 0, "byteLength": vertices, "byteStride": 20},
                        {"buffer": 0, "byteOffset": vertices, "byteLength": len(binary) - vertices}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3",
                       "min": [-2, -2, 0], "max": [2, 2, 1]},
                      {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": count, "type": "VEC2"},
                      {"bufferView": 1, "componentType": 5125, "count": 6 * (side - 1) ** 2, "type": "SCALAR"}]}
    os.makedirs(folder, exist_ok=True)
    for name, data in (("hill.bin", bytes(binary)), ("colour.png", png(colour)),
                       ("hill.gltf", json.dumps(document).encode())):
        with open(os.path.join(folder, name), "wb") as file:
            file.write(data)
    return os.path.join(folder, "hill.gltf")


def start(test, scene, *arguments, env=None):
    """Draws one image; returns its bytes and the text on stderr."""
    renderer = test.renderer("--frames", "1", *arguments, scene=scene, env=env)
    renderer.expect_exit(0)
    with open(os.path.join(renderer.folder, "frame_000000.png"), "rb") as file:
        return file.read(), renderer.stderr_text()


def came_from_cache(said):
    return "scene from the cache" in said


def kept(folder):
    return sorted(glob.glob(os.path.join(folder, "scenes", "*.scene")))


def second_start(test):
    scene, cache = write_hill(test.path("hill")), test.path("cache")
    first, said = start(test, scene, "--cache", cache)
    check(not came_from_cache(said) and len(kept(cache)) == 1, f"the first start keeps the scene:\n{said}")
    second, said = start(test, scene, "--cache", cache)
    check(came_from_cache(said), f"the second start loads it again:\n{said}")
    check(first == second, "the picture from the cache is another one")
    write_hill(test.path("hill"), (40, 200, 40))
    third, said = start(test, scene, "--cache", cache)
    check(not came_from_cache(said) and "is rebuilt" in said, f"a changed texture is not seen:\n{said}")
    check(third != first, "the picture does not show the changed texture")
    fourth, said = start(test, scene, "--cache", cache)
    check(came_from_cache(said) and fourth == third, f"the changed scene was not kept:\n{said}")


def damaged(test):
    scene, cache = write_hill(test.path("hill")), test.path("cache")
    first, _ = start(test, scene, "--cache", cache)
    file = kept(cache)[0]
    with open(file, "rb") as whole:
        good = whole.read()
    middle = len(good) // 2
    for what, bad in (("rubbish", b"rubbish"), ("a cut file", good[:middle]),
                      ("a turned bit", good[:middle] + bytes([good[middle] ^ 1]) + good[middle + 1:])):
        with open(file, "wb") as broken:
            broken.write(bad)
        again, said = start(test, scene, "--cache", cache)
        check("is rebuilt" in said and not came_from_cache(said), f"{what} was believed:\n{said}")
        check(again == first, f"{what} changes the picture")


def nowhere_to_keep(test):
    scene = write_hill(test.path("hill"))
    first, said = start(test, scene, "--cache", "off")
    check("cache" not in said, f"--cache off speaks of a cache:\n{said}")
    env = vulkan_environment()
    for name in ("HOME", "XDG_CACHE_HOME"):
        env.pop(name, None)
    image, said = start(test, scene, "--cache", "auto", env=env)
    check(image == first and not came_from_cache(said), f"without a home:\n{said}")
    image, said = start(test, scene, "--cache", test.path("hill/hill.bin"))  # a file instead of the cache folder
    check(image == first and "cache: cannot make the folder" in said and "hill.bin" in said,
          f"a folder that cannot be made:\n{said}")
    env = dict(vulkan_environment(), XDG_CACHE_HOME=test.path("user"))
    start(test, scene, "--cache", "auto", env=env)
    check(len(kept(test.path("user/fire3dv"))) == 1, "nothing in the user's cache folder")
    check(sorted(os.listdir(test.path("hill"))) == ["colour.png", "hill.bin", "hill.gltf"],
          "something was written beside the scene, unasked")
    start(test, scene, "--cache", "beside", env=env)
    image, said = start(test, scene, "--cache", "beside", env=env)
    check(os.path.exists(scene + ".fire3dv-cache") and came_from_cache(said) and image == first,
          f"not kept beside the scene:\n{said}")


if __name__ == "__main__":
    main({"second_start": second_start, "damaged": damaged, "nowhere_to_keep": nowhere_to_keep}, ["fire3dv"], plain_images=True)
