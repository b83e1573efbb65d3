"""Meshes of the needle, the thread and the instruments. Metres; the axes of each are said at its function."""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_mesh import Mesh, grid_faces, joined, lathe, tube

#: A half-circle needle of 26 mm along its arc, as used for soft tissue, with a braided thread of size 3-0.
NEEDLE_RADIUS_M, WIRE_RADIUS_M, THREAD_RADIUS_M = 0.0083, 0.00034, 0.00014
#: In the needle's axes: the origin is the centre of its arc, which lies in the XY plane.
KEYPOINTS = {"tip": [NEEDLE_RADIUS_M, 0, 0], "middle": [0, -NEEDLE_RADIUS_M, 0], "tail": [-NEEDLE_RADIUS_M, 0, 0]}
THREAD_JOINTS, THREAD_SEGMENT_M = 40, 0.0025
JAW_M = 0.0105  # from the pivot to the end
PIVOT_M = 0.0085  # from the wrist to the pivot of the jaws
STEEL, GOLD, DARK = (0.70, 0.69, 0.67), (0.76, 0.58, 0.28), (0.035, 0.036, 0.040)
TO_Z = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # turns +Y to +Z
TO_X = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])  # turns +Y to +X


def arc(share):
    """Points of the needle's centre line, (n, 3): share 0 is the tail, 1 the tip."""
    angle = np.pi * (1 + np.asarray(share, float))
    return NEEDLE_RADIUS_M * np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1)


def needle():
    """Half a circle with a taper point, and a swage of 4 mm at its tail."""
    share = np.concatenate([[0, 0.0005], np.linspace(0.002, 0.15, 8), np.linspace(0.17, 0.72, 28), np.linspace(0.74, 1, 18)])
    radius = WIRE_RADIUS_M * np.interp(share, [0, 0.0005, 0.14, 0.17, 0.72, 0.90, 1], [0.0, 1.12, 1.12, 1.0, 1.0, 0.55, 0.02])
    return tube(arc(share), radius, STEEL, 16)


def thread():
    """A straight tube along +X, bound to THREAD_JOINTS joints at equal steps: joint i is at i * THREAD_SEGMENT_M."""
    steps = 3
    count = (THREAD_JOINTS - 1) * steps + 1
    path = np.column_stack([np.arange(count) * THREAD_SEGMENT_M / steps, np.zeros((count, 2))])
    shade = 1 + 0.25 * np.cos(np.arange(count) * np.pi)[:, None]  # of the braid
    sides = 8
    made = tube(path, np.where(np.arange(count) % (count - 1) == 0, 0.6, 1.0) * THREAD_RADIUS_M, shade * [0.085, 0.030, 0.19], sides)
    at = np.repeat(np.arange(count) / steps, sides + 1)
    first = np.minimum(at.astype(int), THREAD_JOINTS - 2)
    joints, weights = np.zeros((len(at), 4)), np.zeros((len(at), 4))
    joints[:, 0], joints[:, 1], weights[:, 0], weights[:, 1] = first, first + 1, 1 - (at - first), at - first
    made.attributes.update(JOINTS_0=(joints, "<u2", "VEC4"), WEIGHTS_0=(weights, "<f4", "VEC4"))
    return made


def with_edges(mesh, degrees=35):
    """Normals that are smooth over edges up to an angle: every face gets vertices of its own."""
    corners = mesh.positions[mesh.faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(area, axis=1)
    kept = size > 1e-14
    faces, area, unit = mesh.faces[kept], area[kept], area[kept] / size[kept, None]
    _, place = np.unique(np.round(mesh.positions, 8), axis=0, return_inverse=True)
    place = place.ravel()[faces]
    around = {}
    for face, row in enumerate(place):
        for each in row:
            around.setdefault(each, []).append(face)
    normals = np.zeros((len(faces), 3, 3))
    for face, row in enumerate(place):
        for k, each in enumerate(row):
            near = around[each]
            normals[face, k] = area[near][unit[near] @ unit[face] > np.cos(np.radians(degrees))].sum(0)
    normals = normals.reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Mesh(mesh.positions[faces].reshape(-1, 3), normals, np.arange(3 * len(faces)).reshape(-1, 3), mesh.colors[faces].reshape(-1, 3))


def loft(outlines, colors):
    """A closed body through outlines, (n, m, 3), each counter-clockwise seen from its end; colors: (n, m, 3)."""
    rows, columns = outlines.shape[:2]
    ends = [np.repeat(outlines[end].mean(0)[None], columns, 0) for end in (0, -1)]
    rings = np.concatenate([ends[:1], outlines, ends[1:]])
    rings = np.concatenate([rings, rings[:, :1]], 1)
    shades = np.concatenate([colors[:1], colors, colors[-1:]])
    shades = np.concatenate([shades, shades[:, :1]], 1)
    positions = rings.reshape(-1, 3)
    return with_edges(Mesh(positions, 0 * positions, grid_faces(rows + 1, columns), shades.reshape(-1, 3)))


def cylinder_x(radius, half_width, color, at=(0, 0, 0), sides=32):
    edge = 0.12 * half_width
    profile = [(0, -half_width), (radius - edge, -half_width), (radius, edge - half_width), (radius, half_width - edge),
               (radius - edge, half_width), (0, half_width)]
    return lathe(profile, color, sides).moved(at, TO_X)


def jaw(side, curve, insert):
    """One jaw: its pivot is the origin, +Z leads to its end, its inner face is the plane Y = 0 and its body on side * Y.
    curve: bend of the end towards +X in metres; insert: colour of the inner face."""
    z = np.concatenate([[0.0012, 0.0020], np.linspace(0.0030, JAW_M - 0.0006, 31), [JAW_M - 0.0002, JAW_M]])
    t = z / JAW_M
    half = np.interp(t, [0, 0.2, 0.35, 1], [0.0009, 0.0011, 0.0013, 0.00085]) * np.interp(z, [JAW_M - 0.0006, JAW_M], [1, 0.72])
    thick = np.interp(t, [0, 0.25, 0.5, 1], [0.0012, 0.0021, 0.0018, 0.0010]) * np.interp(z, [JAW_M - 0.0006, JAW_M], [1, 0.6])
    tooth = np.where((np.arange(len(z)) % 2 == 1) & (t > 0.32) & (t < 0.95), 0.00009, 0.0)
    bend = side * curve * np.clip(t - 0.3, 0, 1) ** 2 / 0.49
    outline, shade = [], []
    for k in range(len(z)):
        w, h, inner = half[k], thick[k], tooth[k]
        corner = 0.35 * min(w, h)
        x = np.array([w, w, w - corner, -(w - corner), -w, -w, -0.8 * w, 0.8 * w])
        y = np.array([0.0001, h - corner, h, h, h - corner, 0.0001, 0, 0]) + np.array([0, 0, 0, 0, 0, 0, inner, inner])
        outline.append(np.column_stack([x + bend[k], y, np.full(8, z[k])]))
        shade.append(np.array([STEEL] * 6 + [insert if t[k] > 0.3 else STEEL] * 2))
    outline, shade = np.array(outline), np.array(shade)
    blade = loft(outline, shade)
    hub = cylinder_x(0.0017, 0.0005, STEEL, (-0.00055, 0, 0))
    made = joined(blade, hub)
    return made if side > 0 else made.moved(rotation=np.diag([-1.0, -1.0, 1.0]))  # its hub lies beside the other one's


def wrist():
    """The origin is the joint with the shaft; the jaws' pivot is at +Z, PIVOT_M away; its pin lies along X."""
    neck = lathe([(0, 0.0010), (0.0019, 0.0010), (0.0021, 0.0030), (0.0022, 0.0050), (0.0018, 0.0056), (0, 0.0056)], STEEL, 32).moved(rotation=TO_Z)
    pulleys = [cylinder_x(radius, half, color, (x, 0, 0)) for radius, half, color, x in (
        (0.0027, 0.00035, STEEL, -0.0020), (0.0021, 0.0006, DARK, -0.0011), (0.0027, 0.0005, STEEL, 0), (0.0021, 0.0006, DARK, 0.0011),
        (0.0027, 0.00035, STEEL, 0.0020))]
    parts = [neck, *pulleys, cylinder_x(0.0009, 0.0023, DARK, (0, 0, PIVOT_M), 20)]
    for side in (-1, 1):
        around = np.linspace(0, np.pi, 13)
        y = np.concatenate([[0.0019, 0.0021], 0.0019 * np.cos(around), [-0.0021, -0.0019]])
        z = np.concatenate([[0.0036, 0.0055], PIVOT_M + 0.0019 * np.sin(around), [0.0055, 0.0036]])
        plate = np.array([np.column_stack([np.full(len(y), x), y, z]) for x in (side * 0.00155 - 0.0004, side * 0.00155 + 0.0004)])
        parts.append(loft(plate, np.broadcast_to(np.array(STEEL), plate.shape)))
    return joined(*parts)


def shaft():
    """Parts of dark composite and of steel. The origin is the joint with the wrist; the shaft leads to -Z."""
    sleeve = lathe([(0.0030, -0.170), (0.0041, -0.170), (0.0041, -0.0155), (0.0039, -0.0150)], DARK, 40).moved(rotation=TO_Z)
    collar = [lathe([(0, -0.0153), (0.0037, -0.0153), (0.0037, -0.0075), (0.0033, -0.0062), (0.0014, -0.0056), (0, -0.0056)], STEEL, 40).moved(rotation=TO_Z)]
    for side in (-1, 1):
        collar.append(cylinder_x(0.0031, 0.00035, STEEL, (side * 0.0031, 0, 0)))
        x, z = side * 0.0031 + np.array([-0.00035, 0.00035]), np.array([-0.0070, 0.0])
        corners = np.array([[(a, b, c) for a, b in ((x[0], -0.0029), (x[1], -0.0029), (x[1], 0.0029), (x[0], 0.0029))] for c in z])
        collar.append(loft(corners, np.broadcast_to(np.array(STEEL), corners.shape)))
    return sleeve, joined(*collar)
