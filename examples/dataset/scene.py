"""The scene that dataset.py draws: a floor and objects of three classes, as one binary glTF file."""
import json
import struct

import numpy as np

#: Semantic class by name; node extras hold it as "semantic", label images as pixel value.
CLASSES = {"box": 1, "ball": 2, "cylinder": 3}
PER_CLASS = 4
NAMES = [f"{kind} {i}" for kind in CLASSES for i in range(PER_CLASS)]
SUN, LAMP = "sun", "lamp"
SIZE_M = 0.3


def surface(corner, rows, columns):
    """A grid of corner(u, v) -> (position, normal), both from 0 to 1: positions, normals and triangles."""
    points = [corner(u / columns, v / rows) for v in range(rows + 1) for u in range(columns + 1)]
    faces = []
    for v in range(rows):
        for u in range(columns):
            a = v * (columns + 1) + u
            faces += [(a, a + 1, a + columns + 2), (a, a + columns + 2, a + columns + 1)]
    return np.array([p for p, _ in points]), np.array([n for _, n in points]), np.array(faces)


def joined(parts):
    """Several of those as one."""
    starts = np.cumsum([0] + [len(p) for p, _, _ in parts])
    return (np.concatenate([p for p, _, _ in parts]), np.concatenate([n for _, n, _ in parts]),
            np.concatenate([f + start for (_, _, f), start in zip(parts, starts)]))


def square(axes, center):
    """A side of 1 x 1; axes: its two directions, its normal is their cross product."""
    axes, center = np.array(axes, float), np.array(center, float)
    normal = np.cross(axes[0], axes[1])
    return surface(lambda u, v: (center + (u - 0.5) * axes[0] + (v - 0.5) * axes[1], normal), 1, 1)


def box():
    turns = [np.roll(np.eye(3), turn, axis=1) for turn in range(3)]
    return joined([square(sign * t[:2] if sign > 0 else t[[1, 0]], 0.5 * sign * t[2]) for t in turns for sign in (1, -1)])


def ball(rows=24):
    def corner(u, v):
        around, down = 2 * np.pi * u, np.pi * (1 - v)
        normal = np.array([np.sin(down) * np.sin(around), np.cos(down), np.sin(down) * np.cos(around)])
        return 0.5 * normal, normal
    return surface(corner, rows, 2 * rows)


def cylinder(sides=48):
    def wall(u, v):
        normal = np.array([np.sin(2 * np.pi * u), 0, np.cos(2 * np.pi * u)])
        return 0.5 * normal + [0, v - 0.5, 0], normal

    def lid(side):
        def corner(u, v):
            around = side * 2 * np.pi * u
            return (np.array([0.5 * (1 - v) * np.sin(around), 0.5 * side, 0.5 * (1 - v) * np.cos(around)]),
                    np.array([0, side, 0]))
        return surface(corner, 1, sides)
    return joined([surface(wall, 1, sides), lid(1), lid(-1)])


def write_scene(path):
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
                "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": r}} for r in (0.9, 0.4)],
                "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}]}
    binary = b""

    def accessor(array, dtype, kind):
        nonlocal binary
        data = np.ascontiguousarray(array, dtype).tobytes()
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        document["accessors"].append({
            "bufferView": len(document["bufferViews"]) - 1, "type": kind, "count": array.size // (3 if kind == "VEC3" else 1),
            "componentType": 5126 if dtype == "<f4" else 5125, **({"min": array.astype("<f4").min(0).tolist(),
                                                                 "max": array.astype("<f4").max(0).tolist()} if kind == "VEC3" else {})})
        binary += data
        return len(document["accessors"]) - 1

    def add(name, mesh, material, semantic=None, scale=1.0):
        positions, normals, faces = mesh
        document["meshes"].append({"primitives": [{"material": material, "indices": accessor(faces, "<u4", "SCALAR"), "attributes": {
            "POSITION": accessor(positions * scale, "<f4", "VEC3"), "NORMAL": accessor(normals, "<f4", "VEC3")}}]})
        document["nodes"].append({"name": name, "mesh": len(document["meshes"]) - 1,
                                  **({"extras": {"semantic": semantic}} if semantic else {})})

    add("floor", square([[0, 0, 1], [1, 0, 0]], [0, 0, 0]), 0, scale=8.0)
    shapes = {"box": box(), "ball": ball(), "cylinder": cylinder()}
    for name in NAMES:
        kind = name.split()[0]
        add(name, shapes[kind], 1, CLASSES[kind], SIZE_M)
    document["nodes"] += [{"name": SUN}, {"name": LAMP}]
    document["scenes"][0]["nodes"] = list(range(len(document["nodes"])))
    document["buffers"][0]["byteLength"] = len(binary)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)
