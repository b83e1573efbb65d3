#!/usr/bin/env python3
"""End-to-end test of --render path: the PNG names its settings, the same seed gives the same bytes, the image resembles
the raster's, a killed run goes on to the same bytes, and combinations that make no sense are refused with the remedy."""
import base64
import json
import os
import shutil
import signal
import struct

from harness import Program, main, vulkan_environment, wait_until
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


def draw(test, scene, out, *arguments, validation=True):
    """Returns the bytes of the PNG, the image and what was said. validation=False saves a third of a start's work, where the
    same commands were validated before."""
    folder = test.path(out)
    status, said = run(test, scene, *(["--validation"] if validation else []), "--headless", "--frames", "1", "--size", "32x24", "--cache", "off",
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


HEAD = struct.Struct("<8sIIIIQ32sQ")  # of paths.checkpoint: magic, version, width, height, samples, frame, digests
ENDLESS = 1 << 20


def interrupt(test, scene, folder, number, *arguments):
    """Starts an image that takes too long, and ends it after its first checkpoint; returns its samples."""
    file = os.path.join(folder, "paths.checkpoint")
    program = Program(test, "fire3dv", [test.programs_at["fire3dv"], scene, "--validation", "--headless", "--frames", "1",
                                        "--size", "32x24", "--cache", "off", "--environment-intensity", "0.2", "--out", folder,
                                        *map(str, arguments), "--spp", str(ENDLESS), "--checkpoint", "0.05"],
                      env=vulkan_environment())
    wait_until(lambda: f"a checkpoint; it said:\n{program.stderr_text()}", lambda: os.path.exists(file))
    program.signal(number)
    program.wait()
    with open(file, "rb") as read:
        head = HEAD.unpack(read.read(HEAD.size))
    return head[4], program.stderr_text()


def goes_on(test):
    """A killed or stopped run continues from its checkpoint to the bytes of an uninterrupted one."""
    scene, path = write_scene(test), ("--render", "path", "--bounces", "2", "--seed", "5")
    for number in (signal.SIGKILL, signal.SIGTERM):
        folder = test.path(f"interrupted {number}")
        samples, said = interrupt(test, scene, folder, number, *path)
        check(samples > 0 and not os.path.exists(os.path.join(folder, "frame_000000.png")), f"{samples}, {said}")
        if number == signal.SIGTERM:
            check(f"stopped after {samples} samples per pixel" in said, said)
        wanted = (*path, "--spp", str(samples + 5))
        data, _, said = draw(test, scene, f"interrupted {number}", *wanted)
        check(f"going on after {samples} of {samples + 5} samples per pixel" in said, said)
        whole, _, said = draw(test, scene, f"whole {number}", *wanted, "--checkpoint", "0")
        check("going on" not in said and data == whole, "what was gone on with is other bytes than a single run")
        check(os.listdir(folder) == os.listdir(test.path(f"whole {number}")), f"left: {os.listdir(folder)}")


def strange_checkpoints(test):
    """A checkpoint of something else or a damaged one is reported, and the image starts again."""
    scene, path = write_scene(test), ("--render", "path", "--bounces", "2")
    folder = test.path("kept")
    samples, _ = interrupt(test, scene, folder, signal.SIGKILL, *path)
    with open(os.path.join(folder, "paths.checkpoint"), "rb") as file:
        good = file.read()
    whole, _, _ = draw(test, scene, "whole", *path, "--spp", str(samples + 1), validation=False)
    flipped = good[:-9] + bytes([good[-9] ^ 1]) + good[-8:]
    too_many = HEAD.pack(*HEAD.unpack(good[:HEAD.size])[:4], samples + 2, *HEAD.unpack(good[:HEAD.size])[5:])
    for content, arguments, reason in (
            (good, ("--seed", "1"), "is of another scene, camera, size, setting, seed or device"),
            (good, ("--environment-rotation", "90"), "is of another scene, camera, size, setting, seed or device"),
            (flipped, (), "is damaged"),
            (good[:-16], (), "is damaged"),
            (good[:40], (), "is no checkpoint"),
            (good + b"more", (), "is no checkpoint of this image"),
            (b"x" * 4096, (), "is no checkpoint of this version"),
            (too_many + good[HEAD.size:], (), f"--spp wants {samples + 1}"),
            (None, (), "is no checkpoint of this image")):
        shutil.rmtree(folder)
        os.makedirs(folder)
        file = os.path.join(folder, "paths.checkpoint")
        if content is None:
            os.mkfifo(file)
        else:
            with open(file, "wb") as out:
                out.write(content)
        data, _, said = draw(test, scene, "kept", *path, "--spp", str(samples + 1), *arguments, validation=False)
        check(f"warning: {file} " in said and reason in said and "the image starts again" in said, f"{reason}: {said}")
        check(data == whole or arguments, f"another image: {reason}")
    # A checkpoint of another image of the run says nothing about this one.
    with open(os.path.join(folder, "paths.checkpoint"), "wb") as file:
        head = HEAD.unpack(good[:HEAD.size])
        file.write(HEAD.pack(*head[:5], 7, *head[6:]) + good[HEAD.size:])
    data, _, said = draw(test, scene, "kept", *path, "--spp", str(samples + 1), validation=False)
    check("paths.checkpoint" not in said and data == whole, said)


def refusals(test):
    scene = write_scene(test)
    headless = ("--headless", "--out", test.path("none"))
    for arguments, remedy in (
            (("--spp", "4"), "--spp needs --render path"),
            (("--seed", "4", "--headless", "--frames", "1"), "--seed needs --render path"),
            (("--render", "path", "--out", test.path("none")), "take screenshots"),
            (("--render", "path", "--lockstep", "--listen", "shm://path_test"), "--lockstep awaits"),
            (("--render", "path", "--window", "eye", "--window", "auto"), "one view"),
            (("--render", "path", "--stereo", "eye,auto"), "one view"),
            (("--render", "path", "--devices", "0,0", "--listen", "shm://path_test"), "--device instead"),
            (("--render", "path", "--serve", "127.0.0.1:0"), "add --headless"),
            (("--render", "path", "--headless", "--stats", test.path("none.csv")), "add --frames 1"),
            (("--render", "path", *headless, "--frames", "1", "--shadows", "map"), "leave --shadows"),
            (("--render", "path", *headless, "--frames", "1", "--view", "depth"), "exclude each other"),
            (("--render", "path", "--headless", "--frames", "1", "--listen", "shm://path_test"), "add --on-request"),
            (("--render", "path", *headless, "--frames", "1", "--serve", "127.0.0.1:0"), "for viewers alone"),
            (("--render", "path", *headless, "--frames", "1", "--spp", "0"), "--spp"),
            (("--render", "paths"), "--render")):
        status, said = run(test, scene, *arguments)
        check(status == 2 and remedy in said, f"{arguments}: {status}, {said}")


if __name__ == "__main__":
    main({"images": images, "goes_on": goes_on, "strange_checkpoints": strange_checkpoints, "refusals": refusals}, ["fire3dv"])
