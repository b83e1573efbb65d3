#!/usr/bin/env python3
"""Makes the Cycles goldens of render_gallery_test: tools/lab/truth/cycles_goldens.py BIN FOLDER [--blender PROGRAM] [NAME...]

BIN is the folder of the built programs, FOLDER is tests/render/goldens/cycles. Needs Blender 3.4 and NumPy. The files
are OpenEXR images of halves with linear radiance: the mean of two renders with different seeds. For each the script
prints the standard error of a pixel and of the image's mean, both relative to that mean.
"""
import argparse
import os
import subprocess
import tempfile

import numpy as np

import half_exr

HERE = os.path.dirname(os.path.abspath(__file__))
# Name: size, samples a pixel of both renders together, bounces, further options.
SCENES = {
    "plane_point": ("64x48", 1024, 0),
    "plane_sun": ("64x48", 64, 0),
    "ball_point": ("64x48", 8192, 0),
    "metal_ball": ("64x48", 8192, 0, "--facets", "one-bounce"),
    "room": ("32x24", 32768, 64),
    "environment_balls": ("48x32", 16384, 8, "--environment"),
    "glass": ("48x36", 8192, 16, "--environment"),
}


def environment(width=64, height=32):
    """Sky, ground and a soft sun, in steps of 1/64 below 8, which halves and RGB9E5 hold exactly."""
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    theta, phi = np.pi * v, 2 * np.pi * u  # image centre: -Z; +X to its right
    direction = np.stack([-np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], axis=-1)
    up = direction[..., 1:2]
    sky = np.array([0.35, 0.5, 0.8]) * (1 - 0.5 * np.clip(up, 0, 1))
    ground = np.array([0.3, 0.25, 0.2]) * (1 + 0.4 * np.sin(3 * phi))[..., None]
    share = 1 / (1 + np.exp(-12 * up))
    sun = np.array([0.5, 0.7, 0.3])
    lobe = np.exp(40 * (direction @ (sun / np.linalg.norm(sun)) - 1))[..., None] * np.array([6.5, 6.0, 5.0])
    return np.round(np.clip(share * sky + (1 - share) * ground + lobe, 0, 7.9) * 64) / 64


def render(blender, scene, folder, options, seed):
    out = os.path.join(folder, f"{seed}.npy")
    subprocess.run([blender, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1", "-P",
                    os.path.join(HERE, "cycles_reference.py"), "--", scene, out, "--seed", str(seed), *options], check=True,
                   stdout=subprocess.DEVNULL)
    return np.load(out)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bin")
    parser.add_argument("folder")
    parser.add_argument("names", nargs="*")
    parser.add_argument("--blender", default="blender")
    options = parser.parse_intermixed_args()
    os.makedirs(options.folder, exist_ok=True)
    sky = os.path.abspath(os.path.join(options.folder, "environment.exr"))
    half_exr.write(sky, environment())
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([os.path.join(options.bin, "gallery_scenes"), folder], check=True, stdout=subprocess.DEVNULL)
        for name in options.names or SCENES:
            size, spp, bounces, *more = SCENES[name]
            if more == ["--environment"]:
                more.append(sky)
            settings = ["--size", size, "--spp", str(spp // 2), "--bounces", str(bounces), *more]
            first, second = (render(options.blender, os.path.join(folder, name + ".glb"), folder, settings, seed) for seed in (1, 2))
            mean = (first.astype(np.float64) + second) / 2
            half_exr.write(os.path.join(options.folder, name + ".exr"), mean)
            pixel = np.sqrt(np.mean((first - second).astype(np.float64) ** 2)) / 2 / mean.mean()
            print(f"{name}: mean {mean.mean():.5f}, standard error of a pixel {pixel:.2e}, of the mean {pixel / np.sqrt(mean.size / 3):.1e}")


if __name__ == "__main__":
    main()
