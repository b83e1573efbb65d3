"""The scene that dataset.py draws: a table with household objects of five classes, as one binary glTF file."""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_mesh import Gltf, box, joined, lathe, tube

#: Semantic class by name; node extras hold it as "semantic", label images as pixel value.
CLASSES = {"mug": 1, "bottle": 2, "bowl": 3, "banana": 4, "hammer": 5}
PER_CLASS = 3
NAMES = [f"{kind} {i}" for kind in CLASSES for i in range(PER_CLASS)]
TABLE, FLOOR, SUN, LAMP = "table", "floor", "sun", "lamp"
#: Classes that lie on the table; the others stand. A bottle does either.
LYING = {"banana", "hammer"}


def arc(center, radius, start, end, points=24):
    """Points of an arc in the XY plane; angles in degrees from +X."""
    angles = np.radians(np.linspace(start, end, points))
    return np.asarray(center) + radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(points)])


def mug():
    """Height 95 mm. Its foot is at the origin, as with everything that stands."""
    wall = [(0, 0.004), (0.026, 0.004), (0.028, 0), (0.036, 0), (0.040, 0.006), (0.041, 0.093), (0.0405, 0.095), (0.0385, 0.095),
            (0.038, 0.093), (0.037, 0.010), (0.032, 0.006), (0, 0.006)]
    return joined(lathe(wall), tube(arc([0.039, 0.048, 0], 0.027, -90, 90), 0.0055, sides=16))


def bottle():
    """Height 240 mm, with a white cap."""
    body = [(0, 0), (0.028, 0), (0.033, 0.004), (0.034, 0.012), (0.034, 0.060), (0.0325, 0.064), (0.0325, 0.126), (0.034, 0.130),
            (0.034, 0.150), (0.031, 0.172), (0.022, 0.196), (0.0145, 0.212), (0.0135, 0.222)]
    cap = [(0.0135, 0.219), (0.0155, 0.219), (0.0155, 0.239), (0.0145, 0.240), (0, 0.240)]
    label = [(0.0327, 0.066), (0.0327, 0.124)]
    return joined(lathe(body, (0.55, 0.55, 0.55)), lathe(cap), lathe(label))


def bowl():
    """Diameter 160 mm."""
    outside = [(0, 0.005), (0.030, 0.005), (0.032, 0), (0.038, 0), (0.040, 0.006)]
    outside += [(0.040 + 0.040 * np.sin(a), 0.006 + 0.058 * (1 - np.cos(a))) for a in np.linspace(0.15, np.pi / 2, 10)]
    inside = [(r - 0.0035, max(h + 0.001, 0.009)) for r, h in outside[:3:-1]]
    return lathe(outside + inside + [(0, 0.009)])


def banana():
    """Length 190 mm; it lies on its side."""
    path = arc([0, 0, 0], 0.11, 20, 125, 32) - [0.03, 0.085, 0]
    share = np.linspace(0, 1, 32)
    radii = 0.0175 * np.clip(np.sin(np.pi * (0.03 + 0.94 * share)), 0, 1) ** 0.45
    radii[:4] = [0, 0.004, 0.0042, 0.006]  # stalk
    radii[-2:] = [0.006, 0]
    ends = np.clip(np.minimum(share, 1 - share) / 0.07, 0, 1)[:, None]
    colors = ends * np.array([1.0, 1.0, 1.0]) + (1 - ends) * np.array([0.18, 0.16, 0.10])
    turn = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    return tube(path, radii, colors, sides=10).moved(rotation=turn).moved([0, 0.0175, 0])


def hammer():
    """Length 300 mm: a wooden handle along X, a steel head with a claw."""
    wood, steel = (0.45, 0.23, 0.09), (0.42, 0.43, 0.45)
    turn = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])  # Y to X
    grip = lathe([(0, 0), (0.013, 0.002), (0.016, 0.02), (0.0145, 0.09), (0.0115, 0.16), (0.0105, 0.27), (0.011, 0.285)], wood)
    face = [(0, -0.055), (0.0125, -0.055), (0.0138, -0.052), (0.0138, -0.038), (0.010, -0.032), (0.010, -0.018), (0.014, -0.013),
            (0.014, 0.014), (0.011, 0.02)]
    claw = arc([0, 0, 0], 0.055, 90, 25, 16)
    claws = [tube(np.column_stack([0.285 + claw[:, 1] - 0.055, sign * np.linspace(0.002, 0.008, 16), claw[:, 0] + 0.012]),
                  np.linspace(0.0085, 0.002, 16), steel, sides=12) for sign in (1, -1)]
    head = lathe(face, steel).moved(rotation=[[1, 0, 0], [0, 0, 1], [0, 1, 0]])
    head.faces = head.faces[:, ::-1]  # Y and Z are exchanged, which mirrors
    return joined(grip.moved(rotation=turn), head.moved([0.285, 0, 0]), *claws).moved([-0.15, 0.0155, 0])


def write_scene(path):
    gltf = Gltf()
    ceramic, plastic, matte = gltf.material(0.18), gltf.material(0.3), gltf.material(0.55)
    materials = {"mug": ceramic, "bowl": ceramic, "bottle": plastic, "banana": matte, "hammer": plastic}
    meshes = {"mug": mug(), "bottle": bottle(), "bowl": bowl(), "banana": banana(), "hammer": hammer()}
    legs = [box([0.06, 0.72, 0.06]).moved([x, -0.39, z]) for x in (-0.6, 0.6) for z in (-0.35, 0.35)]
    gltf.node(FLOOR, box([8, 0.02, 8]).moved([0, -0.76, 0]), matte)
    gltf.node(TABLE, joined(box([1.4, 0.03, 0.9]).moved([0, -0.015, 0]), *legs), plastic)
    for name in NAMES:
        kind = name.split()[0]
        gltf.node(name, meshes[kind], materials[kind], CLASSES[kind])
    for name in (SUN, LAMP):
        gltf.node(name)
    gltf.write(path)
