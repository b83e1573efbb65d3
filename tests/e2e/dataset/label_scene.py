"""Scene of the data set tests: bodies of known shape before two perspective cameras, as one glb file.

"red" and "blue" are cubes and "green" is a sphere, in the units of the recording that offline_recording makes; the slab has
odd characters in its name, and a scale.
"""
import json
import struct

import numpy as np

CUBE_HALF = 9.0
SPHERE_RADIUS = 3.0
#: Centre of the mesh in its node.
CENTRES = {"red": (0, 30, 0), "green": (0, 8, 0), "blue": (0, -16, 0)}
SLAB = "../../slab /ö\"<b>"
FOCAL_PX = {"front": 140.0, "side": 110.0}
SIZE = (160, 90)


def cube(centre, half):
    positions, normals, indices = [], [], []
    for axis in range(3):
        for sign in (-1, 1):
            normal, u, v = np.zeros(3), np.zeros(3), np.zeros(3)
            normal[axis], u[(axis + 1) % 3], v[(axis + 2) % 3] = sign, 1, 1
            first = len(positions)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                positions.append(np.add(centre, half * (normal + a * u + b * v)))
                normals.append(normal)
            order = (0, 1, 2, 0, 2, 3) if sign > 0 else (0, 2, 1, 0, 3, 2)
            indices += [first + i for i in order]
    return positions, normals, indices


def sphere(centre, radius, rings=24, sectors=48):
    positions, normals, indices = [], [], []
    for ring in range(rings + 1):
        for sector in range(sectors + 1):
            polar, around = np.pi * ring / rings, 2 * np.pi * sector / sectors
            normal = np.array([np.sin(polar) * np.sin(around), np.cos(polar), np.sin(polar) * np.cos(around)])
            normals.append(normal)
            positions.append(np.add(centre, radius * normal))
    for ring in range(rings):
        for sector in range(sectors):
            a = ring * (sectors + 1) + sector
            b = a + sectors + 1
            indices += [a, b, a + 1, a + 1, b, b + 1]
    return positions, normals, indices


def looking_down(eye, down):
    """Rotation (x, y, z, w) about X and the place of a camera that looks along -Z, then turned down."""
    return {"translation": list(eye), "rotation": [-np.sin(down / 2), 0, 0, np.cos(down / 2)]}


#: Cubes before the camera "front", by name: centre and half of the edge. "near" hides a part of "far" and all of "hidden",
#: "border" is cut by the image's right border, and "outside" is beyond it.
CUBES = {"far": ((0, 0, 0), 12), "near": ((8, 4, 30), 9), "hidden": ((8, 3, 15), 2), "border": ((85, 0, 0), 10), "outside": ((200, 0, 0), 5)}


def write_cubes(path, names):
    write_bodies(path, [(name, cube(*CUBES[name]), [0.7, 0.7, 0.7], 1 + list(CUBES).index(name), {}) for name in names])


def write_label_scene(path, keypoints=False, scale=1.0, scene_extras=None):
    """scale: of all lengths."""
    bodies = [("red", cube(CENTRES["red"], CUBE_HALF), [0.8, 0.1, 0.1], 1, {}),
              ("green", sphere(CENTRES["green"], SPHERE_RADIUS), [0.1, 0.7, 0.1], 2, {}),
              ("blue", cube(CENTRES["blue"], CUBE_HALF), [0.1, 0.2, 0.8], 1, {}),
              (SLAB, cube((0, 0, 0), 1), [0.6, 0.6, 0.6], 7,
               {"translation": [0, -30, -40], "scale": [90, 2, 30], "rotation": [0, np.sin(0.1), 0, np.cos(0.1)]})]
    write_bodies(path, bodies, keypoints, scale, scene_extras)


def write_bodies(path, bodies, keypoints=False, scale=1.0, scene_extras=None):
    """bodies: name, mesh (with texture coordinates behind its indices, or without), colour, class, more of the node. scale: of all lengths. keypoints: of "red" and "green", which come first."""
    binary, views, accessors, meshes, materials, nodes = b"", [], [], [], [], []

    def add(array, component, kind, **more):
        nonlocal binary
        data = array.tobytes()
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind, **more})
        binary += data + b"\0" * (-len(data) % 4)
        return len(accessors) - 1

    for name, (positions, normals, indices, *coordinates), colour, semantic, place in bodies:
        positions = np.array(positions, "<f4")
        if "scale" not in place:
            positions *= np.float32(scale)
        else:
            place = {**place, "scale": [scale * each for each in place["scale"]], "translation": [scale * each for each in place["translation"]]}
        attributes = {"POSITION": add(positions, 5126, "VEC3", min=positions.min(0).tolist(), max=positions.max(0).tolist()),
                      "NORMAL": add(np.array(normals, "<f4"), 5126, "VEC3")}
        for each in coordinates:
            attributes["TEXCOORD_0"] = add(np.array(each, "<f4"), 5126, "VEC2")
        materials.append({"name": name, "pbrMetallicRoughness": {"baseColorFactor": [*colour, 1], "metallicFactor": 0}})
        meshes.append({"name": name, "primitives": [{"attributes": attributes, "material": len(materials) - 1,
                                                     "indices": add(np.array(indices, "<u4"), 5125, "SCALAR")}]})
        nodes.append({"name": name, "mesh": len(meshes) - 1, "extras": {"semantic": semantic}, **place})
    if keypoints:
        corner = np.add(CENTRES["red"], CUBE_HALF).tolist()
        nodes[0]["extras"]["keypoints"] = {"front corner": corner, "back corner": [corner[0], corner[1], -CUBE_HALF]}
        nodes[1]["extras"]["keypoints"] = {"far away": [1e6, 0, 0]}
    cameras = [{"type": "perspective", "perspective": {"yfov": 2 * np.arctan(SIZE[1] / 2 / focal), "znear": scale}}
               for focal in FOCAL_PX.values()]
    nodes.append({"name": "front", "camera": 0, **looking_down(np.multiply((0, 10, 150), scale).tolist(), 0.05)})
    nodes.append({"name": "side", "camera": 1, **looking_down(np.multiply((40, 60, 110), scale).tolist(), 0.5)})
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes))), "extras": scene_extras or {}}], "nodes": nodes,
                "meshes": meshes, "materials": materials, "accessors": accessors, "bufferViews": views, "cameras": cameras,
                "buffers": [{"byteLength": len(binary)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)
