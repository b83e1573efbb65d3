#!/usr/bin/env python3
"""Images of many copies of one environment in one array, as reinforcement learning needs them: carts with poles.

environments.py [--environments N] [--steps N] [--size WxH] [--out FILE.npy] [--fxaa on|off] [--samples N]
"""
import argparse
import math
import os
import sys
import tempfile
import time

import numpy as np

import fire3dv

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_common import count, positive, run, size
from example_mesh import Gltf, box, lathe

SPACING_M = 10.0  # wider than the cameras see
FAR_M = 8.0
STEP_NS = 20_000_000


def write_scenes(folder):
    """Returns a file with what all environments share, and the bytes of one environment."""
    shared = Gltf()
    shared.node("floor", box([4000, 0.02, 4000], (0.5, 0.55, 0.6)).moved([0, -0.01, 0]), shared.material(0.8))
    shared.node("sun")
    shared.write(os.path.join(folder, "shared.glb"))
    one = Gltf()
    paint = one.material(0.5)
    one.node("rail", box([3, 0.04, 0.04], (0.2, 0.2, 0.2)).moved([0, 0.1, 0]), paint)
    one.node("cart", box([0.4, 0.2, 0.25], (0.1, 0.3, 0.8)), paint)
    one.node("pole", lathe([(0, 0), (0.03, 0.01), (0.03, 1.0), (0, 1.01)], (0.8, 0.3, 0.1), sides=24), paint)
    one.write(os.path.join(folder, "environment.glb"))
    with open(os.path.join(folder, "environment.glb"), "rb") as file:
        return os.path.join(folder, "shared.glb"), file.read()


class Carts:
    """A stand-in of your simulation: n carts that swing their poles."""

    def __init__(self, n):
        self.phase = np.linspace(0, 2 * math.pi, n, endpoint=False)

    def step(self, seconds):
        """Returns positions of the carts along X, and angles of the poles."""
        return 0.5 * np.sin(self.phase + seconds), 0.6 * np.sin(1.7 * (self.phase + seconds))


def poses_of(origins, x, angle):
    """(2 n, 3, 4): cart and pole of each environment."""
    carts = fire3dv.pose(origins + np.column_stack([x, np.full(len(x), 0.2), np.zeros(len(x))]))
    turns = np.column_stack([np.zeros((len(x), 2)), np.sin(angle / 2), np.cos(angle / 2)])
    poles = fire3dv.pose(carts[:, :, 3] + [0, 0.1, 0], turns)
    return np.stack([carts, poles], axis=1).reshape(-1, 3, 4)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--environments", type=count, default=64)
    parser.add_argument("--steps", type=count, default=100)
    parser.add_argument("--size", type=size, default="64x64")
    parser.add_argument("--out", help="file for the images of the last step")
    parser.add_argument("--fxaa", choices=("on", "off"), default="off", help="antialiasing (default: %(default)s)")
    parser.add_argument("--samples", choices=("1", "4"), default="1", help="a pixel (default: %(default)s)")
    parser.add_argument("--timeout", type=positive, default=60.0, help="seconds to wait for images")
    options = parser.parse_args()
    n, (width, height) = options.environments, options.size
    side = math.ceil(math.sqrt(n))
    origins = SPACING_M * np.array([[i % side, 0, i // side] for i in range(n)], float)
    carts = Carts(n)
    fast = ["--samples", options.samples, "--fxaa", options.fxaa, "--shadows", "map"]

    with tempfile.TemporaryDirectory() as folder:
        shared, environment = write_scenes(folder)
        with fire3dv.Renderer(shared, arguments=fast) as renderer, renderer.stream("environments") as stream:
            for i, origin in enumerate(origins):  # one asset, n copies
                stream.add_node(f"env{i}", parent_from_node=fire3dv.pose(origin), asset_glb=environment)
            stream.set_light("sun", fire3dv.LightKind.DIRECTIONAL, intensity=3)
            stream.describe([f"env{i}/{part}" for i in range(n) for part in ("cart", "pole")] + ["sun"])
            sun = fire3dv.look_at(eye=(2, 5, 3), target=(0, 0, 0))[None]
            cameras = [stream.request_image(width, height, fx=0.9 * width, far_m=FAR_M, when="every_nth",
                                            parent_from_camera=fire3dv.look_at(origin + [0, 1.2, 2.8], origin + [0, 0.6, 0]))
                       for origin in origins]
            seconds = []
            for step in range(options.steps):
                begun = time.perf_counter()
                poses = poses_of(origins, *carts.step(0.02 * step))
                images = stream.step(step * STEP_NS, np.concatenate([poses, sun]), cameras, timeout_s=options.timeout)
                batch = np.stack([image.color[..., :3] for image in images])  # (n, height, width, 3) uint8, a copy
                seconds.append(time.perf_counter() - begun)
    warm = seconds[len(seconds) // 2:]  # the first ones compile shaders
    print(f"{batch.shape} {batch.dtype}, {n * len(warm) / sum(warm):.0f} images/s")
    if options.out:
        np.save(options.out, batch)


if __name__ == "__main__":
    run(main)
