#!/usr/bin/env python3
"""Makes docs/images/drake.png, objects on a table as a Drake simulation has them: colours, depths and labels.
tools/drake_image.py FIRE3DV_DRAKE FILE.png

FIRE3DV_DRAKE is the built program. Needs NumPy and ffmpeg.
"""
import colorsys
import math
import os
import subprocess
import sys

import numpy as np

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
sys.path[:0] = [os.path.join(ROOT, "tests/e2e/support"), os.path.join(ROOT, "examples/dataset")]
import scene as household  # noqa: E402
from drake_client import Camera, Scene, Server, look_at  # noqa: E402
from example_mesh import box  # noqa: E402
from harness import Test  # noqa: E402

CAMERA = Camera(320, 240, 380.0)
EYE, TARGET, RANGE_M = (0.55, -0.85, 0.62), (0.02, 0.0, 0.06), (0.1, 3.0)
TABLE = "table"
#: Shape, place on the table, turn about Z in radians, colour, label.
OBJECTS = [(TABLE, (0, 0), 0, (0.26, 0.16, 0.09), 1), ("mug", (0.16, -0.19), 2.4, (0.04, 0.10, 0.28), 300), ("mug", (-0.27, 0.02), -0.6, (0.45, 0.05, 0.04), 301),
           ("bottle", (0.0, 0.14), 0, (0.06, 0.28, 0.08), 2100), ("bottle", (-0.1, 0.21), 0, (0.03, 0.20, 0.42), 2101),
           ("bowl", (0.2, 0.06), 0, (0.70, 0.66, 0.58), 90), ("banana", (-0.06, -0.06), 0.5, (0.80, 0.55, 0.05), 4200),
           ("hammer", (-0.12, -0.24), 0.35, (0.45, 0.23, 0.09), 150)]


def pose(place, turn):
    """From the objects' axes, where Y is up, to Drake's world."""
    c, s = math.cos(turn), math.sin(turn)
    return [[c, 0, s, place[0]], [s, 0, -c, place[1]], [0, 1, 0, 0], [0, 0, 0, 1]]


def drake_scene(is_labels):
    meshes = {TABLE: box([1.1, 0.03, 0.8]).moved([0, -0.015, 0]), **{kind: getattr(household, kind)() for kind in household.CLASSES}}
    scene = Scene()
    for kind, place, turn, color, label in OBJECTS:
        mesh = meshes[kind]
        shown = [(label & 255) / 255, (label >> 8) / 255, 0] if is_labels else color
        scene.node(scene.mesh(mesh.positions.tolist(), mesh.faces.tolist(), shown), pose(place, turn))
    return scene


def main(program, path):
    test = Test({"fire3dv-drake": os.path.abspath(program)})
    try:
        server, view = Server(test), look_at(EYE, TARGET)
        color = server.render(drake_scene(False), view, "color", CAMERA)
        depths = np.array(server.render(drake_scene(False), view, "depth", CAMERA, depth_range=RANGE_M))
        labels = server.render(drake_scene(True), view, "label", CAMERA)
    finally:
        test.end()

    def tile(picture):
        return np.frombuffer(b"".join(picture.rows), np.uint8).reshape(CAMERA.height, CAMERA.width, 3)
    near, far = depths[np.isfinite(depths)].min(), depths[np.isfinite(depths)].max()
    grey = np.where(np.isfinite(depths), 230 * (far - depths) / (far - near) + 25, 0).astype(np.uint8)
    # The labels' own colours differ by few units, so each has a colour of a palette here.
    values = tile(labels).astype(int) @ [1, 256, 65536]
    found, numbers = np.unique(values, return_inverse=True)
    palette = np.rint(255 * np.array([colorsys.hsv_to_rgb(0.618 * i % 1, 0.65, 0.9) for i in range(len(found))])).astype(np.uint8)
    palette[-1] = 255  # the background: white
    sheet = np.concatenate([tile(color), np.repeat(grey[..., None], 3, axis=2), palette[numbers.reshape(values.shape)]], axis=1)
    subprocess.run(["ffmpeg", "-y", "-v", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{sheet.shape[1]}x{sheet.shape[0]}",
                    "-i", "-", "-frames:v", "1", "-compression_level", "9", path], input=sheet.tobytes(), check=True)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
