#!/usr/bin/env python3
"""Draws five scenes by raster, raster with ray effects, path tracing and Cycles, and measures how they differ.

    tools/lab/truth/gallery_truth.py BIN OUT.png [--blender PROGRAM] [--folder DIR] [--size 176x132] [--spp 128]

BIN is the folder of the built programs, OUT is docs/images/gallery_truth.png. Prints the table of docs/gallery.md.
Columns: raster, with ray effects if this build has them, paths, Cycles if Blender 3.4 is given, then the difference of
the raster from the paths, and of the paths from Cycles; with Blender only scenes that Cycles draws. Renders in DIR are used again. Needs NumPy and ffmpeg.
"""
import argparse
import os
import subprocess
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
ENVIRONMENT = os.path.join(HERE, "..", "..", "..", "tests", "render", "goldens", "cycles", "environment.exr")
GAP = 4
# Name: lit by the environment, has Cycles (it has no glTF spot lights), factor on the samples, bounces.
SCENES = {
    "spheres": (True, True, 1, 8),
    "two_lights": (False, False, 1, 8),
    "arm": (True, False, 1, 8),
    "glass": (True, True, 2, 16),
    "room": (False, True, 2, 32),
}


class Renderers:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.fire3dv = os.path.join(options.bin, "fire3dv")
        help_text = subprocess.run([self.fire3dv, "--help"], check=True, capture_output=True, text=True).stdout
        self.has_ray_effects = "--ray-effects" in help_text
        subprocess.run([os.path.join(options.bin, "gallery_scenes"), folder], check=True, stdout=subprocess.DEVNULL)
        subprocess.run([os.path.join(options.bin, "bullet_arm"), "--write-scene", os.path.join(folder, "arm.glb")], check=True,
                       stdout=subprocess.DEVNULL)

    def stored(self, scene, how, make):
        path = os.path.join(self.folder, f"{scene}.{how}.npy")
        if not os.path.exists(path):
            make(path)
        return np.load(path).astype(np.float64)[..., :3]

    def ours(self, scene, how, more):
        def make(path):
            out = os.path.join(self.folder, f"{scene}.{how}")
            light = ["--environment", ENVIRONMENT, "--background", "environment"] if SCENES[scene][0] else \
                ["--environment-intensity", "0", "--background", "000000"]
            subprocess.run([self.fire3dv, os.path.join(self.folder, scene + ".glb"), "--headless", "--frames", "1", "--size",
                            self.options.size, "--outputs", "linear", "--fxaa", "off", "--ground", "off", "--key-light", "off", "--cache",
                            "off", "--out", out, *light, *more], check=True, stderr=subprocess.DEVNULL)
            os.replace(os.path.join(out, "frame_000000.linear.npy"), path)
        return self.stored(scene, how, make)

    def cycles(self, scene, spp, bounces):
        def make(path):
            light = ["--environment", os.path.abspath(ENVIRONMENT)] if SCENES[scene][0] else []
            subprocess.run([self.options.blender, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1", "-P",
                            os.path.join(HERE, "cycles_reference.py"), "--", os.path.join(self.folder, scene + ".glb"), path, "--size",
                            self.options.size, "--spp", str(spp), "--bounces", str(bounces), *light], check=True,
                           stdout=subprocess.DEVNULL)
        return self.stored(scene, "cycles", make)


def shown(linear, exposure):
    clipped = np.clip(linear * exposure, 0, 1)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)


def errors(image, reference, exposure):
    """Difference of the means and mean absolute difference, relative to the mean radiance; PSNR of the sRGB images in dB."""
    bias = (image - reference).sum() / reference.sum()
    relative = np.abs(image - reference).sum() / reference.sum()
    square = np.mean((shown(image, exposure) - shown(reference, exposure)) ** 2)
    return bias, relative, 10 * np.log10(1 / square)


def heat(image, reference):
    """Black: equal; red, yellow, white: a third, two thirds and all of the reference's mean, in steps of a 24th."""
    share = np.floor(24 * np.abs(image - reference).mean(axis=-1) / reference.mean()) / 24
    return np.clip(3 * share[..., None] - np.array([0, 1, 2]), 0, 1)


def write_sheet(path, rows):
    height, width = rows[0][0].shape[:2]
    columns = max(map(len, rows))
    sheet = np.ones((len(rows) * (height + GAP) - GAP, columns * (width + GAP) - GAP, 3))
    for r, row in enumerate(rows):
        for c, tile in enumerate(row):
            sheet[r * (height + GAP):][:height, c * (width + GAP):][:, :width] = tile
    subprocess.run(["ffmpeg", "-y", "-v", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{sheet.shape[1]}x{sheet.shape[0]}",
                    "-i", "-", "-frames:v", "1", "-compression_level", "9", "-pred", "mixed", path],
                   input=(4 * np.rint(63.75 * sheet)).clip(0, 255).astype(np.uint8).tobytes(), check=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bin")
    parser.add_argument("out")
    parser.add_argument("--blender")
    parser.add_argument("--folder")
    parser.add_argument("--size", default="176x132")
    parser.add_argument("--spp", type=int, default=128)
    options = parser.parse_args()
    folder = options.folder or tempfile.mkdtemp()
    os.makedirs(folder, exist_ok=True)
    renderers = Renderers(options, folder)
    rows = []
    print("| scene | compared | means | mean relative error | PSNR |\n|---|---|---|---|---|")
    for scene, (_, has_cycles, factor, bounces) in SCENES.items():
        images = {"raster": renderers.ours(scene, "raster", [])}
        if renderers.has_ray_effects:
            images["raster, ray effects"] = renderers.ours(scene, "effects", ["--ray-effects", "all"])
        paths = renderers.ours(scene, "paths", ["--render", "path", "--spp", str(factor * options.spp), "--bounces", str(bounces)])
        cycles = renderers.cycles(scene, 2 * factor * options.spp, bounces) if options.blender and has_cycles else None
        exposure = 0.9 / np.percentile(paths.max(axis=-1), 98)
        comparisons = [(name, "paths", image, paths) for name, image in images.items()]
        if cycles is not None:
            comparisons.append(("paths", "Cycles", paths, cycles))
        for name, other, image, reference in comparisons:
            bias, relative, psnr = errors(image, reference, exposure)
            print(f"| {scene} | {name}, {other} | {100 * bias:+.1f} % | {100 * relative:.1f} % | {psnr:.1f} dB |")
        tiles = [*images.values(), paths] + ([cycles] if cycles is not None else [])
        row = [shown(tile, exposure) for tile in tiles]
        row.append(heat(images["raster"], paths))
        if cycles is not None:
            row.append(heat(paths, cycles))
        if cycles is not None or not options.blender:
            rows.append(row)
    write_sheet(options.out, rows)


if __name__ == "__main__":
    main()
