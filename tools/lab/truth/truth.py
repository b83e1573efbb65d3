#!/usr/bin/env python3
"""Draws the reference scenes by raster, raster with ray effects and path tracing, and measures their errors.

    tools/lab/truth/truth.py BIN [SCENE...] [--docs DIR] [--folder DIR]
    tools/lab/truth/truth.py BIN SCENE... --cycles [--blender PROGRAM]

BIN is the folder of the built programs; without SCENE all scenes are drawn. Each file in scenes/ is a scene: a new one
is one file. Prints a table; --docs (docs/) also writes it into truth.md, and the contact sheet into images/truth.png.
The references are closed forms, the stored images of Blender's Cycles (tests/render/goldens/cycles) or, without either,
the path tracer. --cycles renders the stored images again, by Blender 3.4. Images in --folder are used again. Needs NumPy.
"""
import argparse
import importlib
import os
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
sys.path.insert(1, os.path.join(HERE, "scenes"))

import half_exr  # noqa: E402
import images  # noqa: E402

GOLDENS = os.path.join(HERE, "..", "..", "..", "tests", "render", "goldens", "cycles")
COLUMNS = {
    "raster": (),
    "ray effects": ("--ray-effects", "all"),
    "paths": ("--render", "path"),
}
BEGIN, END = "<!-- table of tools/lab/truth/truth.py -->", "<!-- end of the table -->"


def scene_names():
    return sorted(file[:-3] for file in os.listdir(os.path.join(HERE, "scenes")) if file.endswith(".py"))


def load(name):
    return importlib.import_module(name).SCENE


class Studio:
    """Writes scenes and draws them into a folder."""

    def __init__(self, bin_folder, folder):
        self.bin, self.folder = os.path.abspath(bin_folder), folder

    def scene(self, name, scene):
        path = os.path.join(self.folder, name + ".glb")
        scene.write(self.bin, path)
        return path

    def environment(self, scene):
        if scene.environment is None:
            return None
        path = os.path.join(self.folder, scene.environment.__name__ + ".exr")
        half_exr.write(path, scene.environment())
        return path

    def image(self, name, scene, how):
        stored = os.path.join(self.folder, f"{name}.{how.replace(' ', '_')}.npy")
        if not os.path.exists(stored):
            environment, out = self.environment(scene), os.path.join(self.folder, "out")
            light = ["--environment", environment] if environment else ["--environment-intensity", "0"]
            background = scene.background or ("environment" if environment else "000000")
            paths = ["--spp", str(scene.samples), "--bounces", str(scene.bounces)] if how == "paths" else []
            subprocess.run([os.path.join(self.bin, "fire3dv"), self.scene(name, scene), "--headless", "--frames", "1", "--size",
                            "{}x{}".format(*scene.size), "--outputs", "linear", "--fxaa", "off", "--ground", "off", "--key-light", "off",
                            "--cache", "off", "--out", out, "--background", background, *light, *COLUMNS[how], *paths, *scene.arguments],
                           check=True, stderr=subprocess.DEVNULL)
            os.replace(os.path.join(out, "frame_000000.linear.npy"), stored)
        return np.load(stored).astype(np.float64)[..., :3]

    def cycles(self, blender, name, scene, seed):
        out = os.path.join(self.folder, f"{name}.cycles{seed}.npy")
        environment = self.environment(scene)
        subprocess.run([blender, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1", "-P",
                        os.path.join(HERE, "cycles_reference.py"), "--", self.scene(name, scene), out, "--size",
                        "{}x{}".format(*scene.size), "--spp", str(scene.cycles_samples // 2), "--bounces", str(scene.bounces), "--seed",
                        str(seed), "--facets", scene.facets, *(["--environment", environment] if environment else []),
                        *(["--background", scene.background] if scene.background else [])],
                       check=True, stdout=subprocess.DEVNULL)
        return np.load(out).astype(np.float64)


def golden(name):
    return os.path.join(GOLDENS, name + ".exr")


def store_cycles(studio, blender, name, scene):
    """Stores the mean of two renders, whose difference states the noise."""
    first, second = (studio.cycles(blender, name, scene, seed) for seed in (1, 2))
    mean = (first + second) / 2
    half_exr.write(golden(name), mean)
    pixel = np.sqrt(np.mean((first - second) ** 2)) / 2 / mean.mean()
    print(f"{name}: mean {mean.mean():.5f}, standard error of a pixel {pixel:.2e}, of the mean {pixel / np.sqrt(mean.size / 3):.1e}")


def reference(name, scene, drawn):
    if scene.closed_form is not None:
        form = scene.closed_form() if callable(scene.closed_form) else scene.closed_form
        return "closed form", np.broadcast_to(form, drawn["paths"].shape)
    if scene.cycles_samples:
        if not os.path.exists(golden(name)):
            sys.exit(f"truth.py: {golden(name)} is missing; make it: truth.py BIN {name} --cycles")
        return "Cycles", half_exr.read(golden(name)).astype(np.float64)
    return "paths", drawn["paths"]


def compare(studio, name, scene):
    """Row of the table, and row of the sheet."""
    drawn = {how: studio.image(name, scene, how) for how in COLUMNS}
    kind, expected = reference(name, scene, drawn)
    mask = scene.mask() if scene.mask else np.any([image.any(axis=-1) for image in (*drawn.values(), expected)], axis=0)
    if not mask.any():
        mask[:] = True
    level = scene.level or expected[mask].mean()
    cells = []
    for how in COLUMNS:
        bias, error = images.errors(drawn[how][mask], expected[mask], level)
        cells.append("" if kind == how else f"{100 * bias:+.2f} %, {100 * error:.2f} %")
    exposure = 0.9 / max(np.percentile(expected.max(axis=-1), 98), level / 4)
    tiles = [images.shown(drawn[how], exposure) for how in COLUMNS]
    tiles.append(None if kind == "paths" else images.shown(expected, exposure))
    tiles += [None if kind == how else images.heat(drawn[how], expected, level) for how in COLUMNS]
    return f"| {scene.title} | {kind} | {' | '.join(cells)} |", tiles


def write_docs(docs, table, rows):
    path = os.path.join(docs, "truth.md")
    with open(path) as file:
        before, rest = file.read().split(BEGIN)
    after = rest.split(END)[1]
    with open(path, "w") as file:
        file.write(before + BEGIN + "\n" + table + "\n" + END + after)
    with open(os.path.join(docs, "images", "truth.png"), "wb") as file:
        file.write(images.sheet(rows))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bin")
    parser.add_argument("names", nargs="*", metavar="SCENE")
    parser.add_argument("--docs")
    parser.add_argument("--folder")
    parser.add_argument("--cycles", action="store_true")
    parser.add_argument("--blender", default="blender")
    options = parser.parse_intermixed_args()
    known = scene_names()
    unknown = set(options.names) - set(known)
    if unknown:
        parser.error(f"no scene is called {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    if options.cycles and not options.names:
        parser.error("--cycles needs the names of scenes")
    scenes = {name: load(name) for name in options.names or known}
    with tempfile.TemporaryDirectory() as scratch:
        folder = os.path.abspath(options.folder or scratch)
        os.makedirs(folder, exist_ok=True)
        studio = Studio(options.bin, folder)
        if options.cycles:
            for name, scene in scenes.items():
                store_cycles(studio, options.blender, name, scene)
            return
        table = ["| scene | reference | raster | ray effects | paths |", "|---|---|---|---|---|"]
        rows = []
        for name, scene in scenes.items():
            if not scene.in_page:
                continue
            line, tiles = compare(studio, name, scene)
            print(line, flush=True)
            table.append(line)
            rows.append(tiles)
        if options.docs:
            write_docs(options.docs, "\n".join(table), rows)


if __name__ == "__main__":
    main()
