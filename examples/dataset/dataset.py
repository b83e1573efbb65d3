#!/usr/bin/env python3
"""A labelled data set of random table scenes: images, depth and COCO's instances.json.

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


#: Base colours that objects of a class have, linear; each is varied.
COLORS = {"mug": [(0.75, 0.73, 0.68), (0.04, 0.10, 0.28), (0.45, 0.05, 0.04), (0.05, 0.22, 0.18)],
          "bottle": [(0.03, 0.20, 0.42), (0.35, 0.04, 0.03), (0.06, 0.28, 0.08), (0.55, 0.30, 0.03)],
          "bowl": [(0.70, 0.66, 0.58), (0.10, 0.25, 0.35), (0.42, 0.16, 0.08)],
          "banana": [(0.80, 0.55, 0.05), (0.62, 0.55, 0.06)], "hammer": [(0.9, 0.9, 0.9), (0.6, 0.5, 0.45)],
          scene.TABLE: [(0.17, 0.08, 0.035), (0.26, 0.16, 0.09), (0.14, 0.145, 0.15), (0.36, 0.34, 0.31)],
          scene.FLOOR: [(0.22, 0.22, 0.23), (0.30, 0.24, 0.18), (0.12, 0.14, 0.17)]}


def turned(angle, lies_down=False):
    """Rotation about the vertical, (3, 3); of an object that lies down after a turn by 90 degrees about Z."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return turn @ [[0, -1, 0], [1, 0, 0], [0, 0, 1]] if lies_down else turn


def above(source, distance_m):
    """A random place that far from the middle, 20 to 60 degrees above the table."""
    around, up = source.uniform(0, 2 * np.pi), np.radians(source.uniform(20, 60))
    return distance_m * np.array([np.cos(up) * np.sin(around), np.sin(up), np.cos(up) * np.cos(around)])


def object_poses(source):
    """Each object stands or lies on the table, in a random cell of a grid: (n, 3, 4)."""
    cells = source.permutation(len(scene.NAMES))
    poses = []
    for name, cell in zip(scene.NAMES, cells):
        lies_down = name.startswith("bottle") and source.random() < 0.4
        place = np.array([(cell % 5 - 2) * 0.27, 0.0345 if lies_down else 0, (cell // 5 - 1) * 0.29])
        turn = turned(source.uniform(0, 2 * np.pi), lies_down)
        if lies_down:  # about its middle instead of its foot
            place -= turn @ [0, 0.12, 0] * [1, 0, 1]
        place[[0, 2]] += source.uniform(-0.02, 0.02, 2)
        poses.append(np.column_stack([turn, place]))
    return np.stack(poses)


def set_looks(stream, source):
    for name in scene.NAMES + [scene.TABLE, scene.FLOOR]:
        colors = COLORS[name.split()[0]]
        tint = source.uniform(0.7, 1.2) * source.uniform(0.93, 1.07, 3)
        color = np.clip(colors[source.integers(len(colors))] * tint, 0, 1)
        stream.set_base_color(name, [*color, 1])
    for name in scene.NAMES:
        stream.set_visible(name, source.random() < 0.8)
    stream.set_light(scene.SUN, fire3dv.LightKind.DIRECTIONAL, source.uniform(0.85, 1, 3), source.uniform(0.8, 2.2))
    stream.set_light(scene.LAMP, fire3dv.LightKind.POINT, source.uniform(0.7, 1, 3), source.uniform(0.2, 1.2))


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
            lights = [looking(above(source, distance), np.zeros(3)) for distance in (5, 1.2)]
            sequence = stream.publish(number * 1_000_000, np.concatenate([object_poses(source), lights]).astype(np.float32))
            request = stream.request_image(width, height, outputs=OUTPUTS, fx=source.uniform(0.8, 1.3) * width,
                                           parent_from_camera=looking(above(source, source.uniform(0.9, 1.5)), np.zeros(3)))
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
