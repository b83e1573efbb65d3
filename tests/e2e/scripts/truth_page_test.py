#!/usr/bin/env python3
"""End-to-end test of tools/lab/truth/truth.py: docs/truth.md shows every reference scene, and errors are measured."""
import os
import subprocess
import sys

import numpy

from image_reader import check

SOURCE, FIRE3DV = sys.argv[1:]
TOOL = os.path.join(SOURCE, "tools", "lab", "truth")
sys.path.insert(0, TOOL)

import half_exr  # noqa: E402
import images  # noqa: E402
import truth  # noqa: E402


def run(*arguments):
    return subprocess.run([sys.executable, os.path.join(TOOL, "truth.py"), os.path.dirname(FIRE3DV), *arguments], capture_output=True,
                          text=True)


def scenes():
    return {name: truth.load(name) for name in truth.scene_names()}


def test_page():
    with open(os.path.join(SOURCE, "docs", "truth.md")) as file:
        table = file.read().split(truth.BEGIN)[1].split(truth.END)[0]
    shown = [scene for scene in scenes().values() if scene.in_page]
    for scene in shown:
        check(f"| {scene.title} |" in table, f"docs/truth.md has no row of the scene {scene.title!r}: truth.py BIN --docs docs")
    check(table.count("\n|") == len(shown) + 2, "docs/truth.md has a row of a scene that is not in scenes/")
    for name, scene in scenes().items():
        check(not scene.cycles_samples or half_exr.read(truth.golden(name)).shape == (scene.size[1], scene.size[0], 3),
              f"the Cycles image of {name} has another size: truth.py BIN {name} --cycles")


def test_errors():
    reference = numpy.full((6, 8, 3), 0.5)
    image = reference.copy()
    image[:3] *= 1.1
    image[3:] *= 0.9
    bias, error = images.errors(image, reference, 0.5)
    check(abs(bias) < 1e-12 and abs(error - 0.1) < 1e-12, f"errors of 10 % both ways: {bias}, {error}")
    check(images.heat(reference, reference, 0.5).max() == 0 and images.heat(2 * reference, reference, 0.5).min() == 1, "heat")


def test_scenes():
    result = run("plane_sun", "plane_point")
    check(result.returncode == 0, result.stderr)
    rows = [line for line in result.stdout.splitlines() if "| Cycles |" in line]
    check(len(rows) == 2, result.stdout)
    for row in rows:
        for cell in row.strip("| ").split(" | ")[2:]:
            bias, error = (float(number.strip(" %")) for number in cell.split(","))
            check(abs(bias) <= 0.1 and error <= 0.3, f"a plane is within 0.1 % of Cycles: {row}")
    result = run("no_such_scene")
    check(result.returncode == 2 and "no_such_scene" in result.stderr and "plane_sun" in result.stderr, result.stderr)


test_page()
test_errors()
test_scenes()
