#!/usr/bin/env python3
"""Images of many copies of a robot, each with joint positions of its own: one request and one answer a step.

batch_worlds.py ROBOT [--worlds N] [--size WxH] [--steps N] [--out FILE]"""
import argparse
import os
import sys
import time

import numpy as np

import fire3dv

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_common import count, expect, run, size, write_png

SETTINGS = ["--samples", "1", "--shadows", "small-map", "--lod", "surface"]  # for many small images


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("robot", help="URDF, MJCF, SDF, or the .glb of fire3dv-convert")
    parser.add_argument("--worlds", type=count, default=64)
    parser.add_argument("--size", type=size, default="64x64")
    parser.add_argument("--steps", type=count, default=3)
    parser.add_argument("--out", help="PNG file with the images of all worlds")
    options = parser.parse_args()
    width, height = options.size

    robot = fire3dv.Robot(options.robot)
    random = np.random.default_rng(1)
    poses = np.empty((options.worlds, len(robot.node_names), 12), np.float32)  # stream_from_body of each world
    with fire3dv.Renderer(options.robot, arguments=SETTINGS) as renderer, renderer.stream("batch_worlds") as stream:
        robot.describe(stream)
        batch = stream.batch(options.worlds, (width, height), outputs=["color", "depth"], vertical_fov_rad=0.8,
                             camera_poses=[fire3dv.look_at((2, -2, 1.5), (0, 0, 0.5), up=(0, 0, 1))])
        for step in range(options.steps):
            for world in range(options.worlds):
                robot.set(random.normal(0, 0.5, len(robot.positions)), clamp=True)
                poses[world] = np.reshape(robot.poses(), (-1, 12))
            begin = time.monotonic()
            images = batch.render(poses)  # {"color": (worlds, height, width, 4), "depth": (worlds, height, width, 1)}
            s = time.monotonic() - begin
            seen = np.isfinite(images["depth"]).any(axis=(1, 2, 3))
            expect(seen.all(), f"the robot is out of view in {(~seen).sum()} worlds: it is not about a metre tall")
            print(f"step {step}: color {images['color'].shape}, {options.worlds / s:.0f} images/s")
    if options.out:
        columns = max(n for n in range(1, options.worlds + 1) if options.worlds % n == 0 and n * n <= options.worlds)
        tiles = images["color"][..., :3].reshape(options.worlds // columns, columns, height, width, 3)
        write_png(options.out, np.ascontiguousarray(tiles.swapaxes(1, 2).reshape(-1, columns * width, 3)))


if __name__ == "__main__":
    run(main)
