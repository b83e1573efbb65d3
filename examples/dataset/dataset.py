#!/usr/bin/env python3
"""A labelled data set of random scenes: images, depth and COCO's instances.json.

dataset.py --write-scene SCENE.glb
dataset.py [--to URI] [--out FOLDER] [--images N] [--size WxH] [--seed N]"""
import argparse
import os
import sys

import numpy as np

import fire3dv
import labels
import scene

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_common import count, expect, looking, positive, run, size, whole, write_png

OUTPUTS = ("color_srgb8", "depth_f32", "instance_u32", "boxes2d")


def turned(source):
    """A random rotation, (3, 3): that of a random unit quaternion."""
    w, x, y, z = (q := source.normal(size=4)) / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def above(source, distance_m):
    """A random place that far from the middle, 25 to 65 degrees above the floor."""
    around, up = source.uniform(0, 2 * np.pi), np.radians(source.uniform(25, 65))
    return distance_m * np.array([np.cos(up) * np.sin(around), np.sin(up), np.cos(up) * np.cos(around)])


def object_poses(source):
    """A place of its own in a grid for each object, (n, 3, 4)."""
    count = len(scene.NAMES)
    cells = source.permutation(count)
    places = np.column_stack([cells % 4 - 1.5, np.full(count, 0.6), cells // 4 - 1.0]) * 0.6
    places += source.uniform(-0.1, 0.1, places.shape)
    return np.stack([np.column_stack([turned(source), place]) for place in places])


def set_looks(stream, source):
    for name in scene.NAMES + ["floor"]:
        stream.set_base_color(name, [*source.uniform(0.05, 0.95, 3), 1])
    for name in scene.NAMES:
        stream.set_visible(name, source.random() < 0.8)
    stream.set_light(scene.SUN, fire3dv.LightKind.DIRECTIONAL, source.uniform(0.7, 1, 3), source.uniform(1, 4))
    stream.set_light(scene.LAMP, fire3dv.LightKind.POINT, source.uniform(0.5, 1, 3), source.uniform(2, 12))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write-scene", metavar="SCENE.glb", help="write the scene for fire3dv, and nothing else")
    parser.add_argument("--to", default="shm://demo", help="where fire3dv listens (default: %(default)s)")
    parser.add_argument("--out", default="dataset", help="folder of the data set (default: %(default)s)")
    parser.add_argument("--images", type=count, default=100)
    parser.add_argument("--size", type=size, default="320x240")
    parser.add_argument("--seed", type=whole, default=1, help="the same number gives the same data set")
    parser.add_argument("--timeout", type=positive, default=60.0, help="seconds to wait for an image")
    options = parser.parse_args()
    if options.write_scene:
        scene.write_scene(options.write_scene)
        return
    width, height = options.size
    for folder in ("images", "depth"):
        os.makedirs(os.path.join(options.out, folder), exist_ok=True)
    source = np.random.default_rng(options.seed)
    coco = labels.Coco(scene.CLASSES)

    with fire3dv.Stream(options.to, adapter_name="dataset") as stream:
        stream.describe([*scene.NAMES, scene.SUN, scene.LAMP])
        for number in range(options.images):
            set_looks(stream, source)  # shown together with the next published frame, never without it
            lights = [looking(above(source, distance), np.zeros(3)) for distance in (5, 2)]
            sequence = stream.publish(number * 1_000_000, np.concatenate([object_poses(source), lights]).astype(np.float32))
            request = stream.request_image(width, height, outputs=OUTPUTS, fx=source.uniform(0.8, 1.3) * width,
                                           parent_from_camera=looking(above(source, source.uniform(2, 3.5)), np.zeros(3)))
            with request.wait(options.timeout) as image:
                expect(image.sequence == sequence, f"the image shows frame {image.sequence}, not {sequence}")
                files = f"images/{number:06}.png", f"depth/{number:06}.npy"
                write_png(os.path.join(options.out, files[0]), image["color_srgb8"][..., :3])
                np.save(os.path.join(options.out, files[1]), image["depth_f32"])
                coco.add(image, *files)
    coco.write(os.path.join(options.out, "instances.json"))
    print(f"{options.out}: {len(coco.images)} images, {len(coco.annotations)} instances")


if __name__ == "__main__":
    run(main)
