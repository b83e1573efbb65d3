"""The scene of stereo_endoscope.py: an abdominal cavity of wet tissue with folds and vessels, an organ, a needle driver
and a curved needle. All shapes and colours are made here, none is of a patient. Metres; the endoscope enters along -Z."""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_mesh import Gltf, Mesh, grid_faces, joined, lathe, smooth_normals, tube

TISSUE, PALE, VESSEL, FAT = (np.array(c) for c in ((0.42, 0.085, 0.065), (0.60, 0.24, 0.18), (0.20, 0.012, 0.018), (0.84, 0.56, 0.32)))
TARGET = np.array([0, 0, -0.105])  # what the surgeon looks at, between instrument and needle


def noise(points, scale, seed, octaves=4):
    """Smooth noise of about -1 to 1 at points, (n, 3): sums of waves in random directions."""
    source = np.random.default_rng(seed)
    total, weight = np.zeros(len(points)), 0.0
    for octave in range(octaves):
        for _ in range(6):
            direction = source.normal(size=3)
            direction *= 2 * np.pi * 2 ** octave / scale / np.linalg.norm(direction)
            total += 0.55 ** octave * np.sin(points @ direction + source.uniform(0, 2 * np.pi))
        weight += 6 * 0.55 ** octave
    return 2.2 * total / weight


def fat_lobules(points, seed):
    """Fat: its share, with frayed edges, and how far a point is from the septa between the lobules; both 0 to 1."""
    share = np.clip((noise(points, 0.06, seed + 9, 3) - 0.45 + 0.30 * noise(points, 0.013, seed + 10, 2)) / 0.5, 0, 1)
    cells = np.abs(noise(points, 0.011, seed + 12, 1)) * np.abs(noise(points, 0.009, seed + 13, 1))
    return share * share * (3 - 2 * share), np.clip(cells / 0.12, 0, 1) ** 0.5


def tissue_colors(points, seed, fat=0.0):
    """Mottled red; lobules of fat; vessels along the zero lines of a noise, thinner where another one is high."""
    shade = np.clip(0.5 + 0.5 * noise(points, 0.05, seed), 0, 1)[:, None]
    colors = TISSUE * (1 - 0.55 * shade) + PALE * 0.55 * shade
    fatty, lobule = (value[:, None] for value in fat_lobules(points, seed))
    yellow = FAT * (0.80 + 0.25 * shade) * (0.55 + 0.45 * lobule) + PALE * 0.25 * (1 - lobule)
    colors = colors * (1 - fat * fatty) + yellow * fat * fatty
    width = 0.035 + 0.035 * noise(points, 0.04, seed + 1, 1)
    for scale, strength in ((0.07, 0.75), (0.028, 0.45)):
        line = np.abs(noise(points, scale, seed + 2 + int(1000 * scale), 2))
        share = strength * np.clip(1 - line / np.maximum(width, 0.008), 0, 1) ** 0.7 * (1 - 0.7 * fat * fatty[:, 0])
        colors = colors * (1 - share[:, None]) + VESSEL * share[:, None]
    return np.clip(colors, 0, 1)


def blob(rows, columns, place, seed, bumps, fat=0.0, inward=False):
    """A closed surface: place(directions) -> points, displaced along the directions by noise."""
    down, around = np.meshgrid(np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, columns + 1), indexing="ij")
    directions = np.column_stack([(np.sin(down) * np.sin(around)).ravel(), np.cos(down).ravel(), (np.sin(down) * np.cos(around)).ravel()])
    points = place(directions)
    for scale, depth in bumps:
        points = points + depth * noise(points, scale, seed + int(1e4 * scale))[:, None] * directions
    share, lobule = fat_lobules(points, seed)
    points = points + (fat * share * (0.0006 + 0.0012 * lobule))[:, None] * (-directions if inward else directions)
    faces = grid_faces(rows, columns)[:, ::1 if inward else -1]
    return Mesh(points, smooth_normals(points, faces), faces, tissue_colors(points, seed, fat))


def wall():
    """The cavity, seen from inside: 17 cm wide, with folds across the view."""
    def place(directions):
        points = directions * [0.085, 0.06, 0.12] + [0, 0, -0.075]
        folds = np.maximum(np.sin(points[:, 2] / 0.0075 + 2.2 * noise(points, 0.09, 5, 2)), 0) ** 3
        return points - 0.004 * folds[:, None] * directions
    return blob(220, 320, place, 11, ((0.06, 0.006), (0.014, 0.0008)), fat=0.9, inward=True)


def organ(center, radii, seed, fat):
    return blob(140, 220, lambda directions: directions * radii + center, seed, ((0.045, 0.004), (0.010, 0.0004)), fat)


def instrument():
    """A needle driver of 8 mm from the upper right: shaft, wrist and two jaws; its tip is at the target."""
    steel, dark = (0.50, 0.50, 0.52), (0.045, 0.045, 0.05)
    shaft = lathe([(0, 0.026), (0.0036, 0.026), (0.004, 0.0268), (0.004, 0.20)], dark, 40)
    wrist = lathe([(0, 0.0125), (0.0021, 0.0125), (0.0028, 0.0135), (0.0028, 0.0215), (0.0036, 0.0225), (0.0036, 0.0258), (0, 0.0258)], steel, 40)
    share = np.linspace(0, 1, 14)
    jaws = [tube(np.column_stack([sign * (0.0004 + 0.0022 * np.sin(np.pi * share) ** 2 + 0.0012 * (1 - share)), 0.0135 * share, 0 * share]),
                 np.where(share == 0, 0, 0.0008 + 0.0009 * share), steel, 16) for sign in (1, -1)]
    y = np.array([0.62, 0.36, 0.70]) / np.linalg.norm([0.62, 0.36, 0.70])  # from the tip along the shaft
    x = np.cross(y, [0, 1, 0])
    x /= np.linalg.norm(x)
    return joined(shaft, wrist, *jaws).moved(TARGET + [0.004, 0.002, 0.008], np.column_stack([x, y, np.cross(x, y)]))


def needle():
    """Half a circle of 20 mm, with its thread."""
    steel, thread = (0.62, 0.62, 0.64), (0.10, 0.04, 0.22)
    angles = np.radians(np.linspace(-20, 160, 40))
    curve = np.column_stack([0.0095 * np.cos(angles), 0.0095 * np.sin(angles), 0 * angles])
    radii = np.concatenate([np.full(32, 0.00042), np.linspace(0.0004, 0.00004, 8)])
    t = np.linspace(0, 1, 60)
    loose = np.column_stack([0.0089 + 0.012 * t, -0.0032 - 0.012 * np.sin(2.6 * t), 0.004 * np.sin(7 * t) - 0.004 * t])
    whole = joined(tube(curve, radii, steel, 12), tube(loose, 0.00013, thread, 8))
    c, s = np.cos(0.9), np.sin(0.9)
    return whole.moved(TARGET + [-0.006, -0.004, 0.006], [[c, 0, s], [0, 1, 0], [-s, 0, c]])


def write_scene(path):
    gltf = Gltf()
    wet, metal = gltf.material(0.42, clearcoat=0.6), gltf.material(0.28, metallic=0.85)
    gltf.node("wall", wall(), wet)
    gltf.node("organ", organ([-0.028, -0.036, -0.115], [0.042, 0.030, 0.048], 23, 0.2), wet)
    gltf.node("lobe", organ([0.040, -0.042, -0.095], [0.034, 0.022, 0.038], 31, 1.0), wet)
    gltf.node("needle driver", instrument(), metal)
    gltf.node("needle", needle(), metal)
    gltf.write(path)
