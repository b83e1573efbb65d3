#!/usr/bin/env python3
"""A large glTF file that is hard to load: unique meshes with texture coordinates, materials with normal maps, no tangents.

    textured_scene.py --triangles 7000000 --output 7M-textured.glb

Bumpy balls on a grid under a directional light, before a camera that sees them all. Each ball has a mesh of its own; eight
materials with a base colour, a normal map and a metallic-roughness map of 1024 pixels a side each, as PNGs in the file.
The same arguments give the same bytes. Nothing but Python's own library is needed.
"""
import argparse
import array
import json
import math
import random
import struct
import zlib

SIDE = 1024
MATERIALS = 8


def png(pixel_rows):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + row for row in pixel_rows)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", SIDE, SIDE, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows, 6)) + chunk(b"IEND", b""))


def textures(rng):
    """Base colour, normal, metallic-roughness: stripes and grain, so that they do not compress to nothing."""
    base = [rng.randrange(60, 220) for _ in range(3)]
    grain = [bytes(rng.randrange(24) for _ in range(SIDE)) for _ in range(64)]
    colour, normal, rough = [], [], []
    for y in range(SIDE):
        noise = grain[rng.randrange(64)]
        stripe = 30 if y // 64 % 2 else 0
        colour.append(bytes(min(255, c + stripe + n) for n in noise for c in base))
        tilt = int(127 + 40 * math.sin(y * 2 * math.pi / 64))
        normal.append(bytes(v for n in noise for v in (116 + n, tilt, 250)))
        rough.append(bytes(v for n in noise for v in (0, 90 + 2 * n, 40)))
    return [png(rows) for rows in (colour, normal, rough)]


def ball(triangles):
    """Positions, normals and texture coordinates of a bumpy ball with a seam, and its indices."""
    rings = max(4, round(math.sqrt(triangles / 4)))
    segments = 2 * rings
    positions, normals, uvs = array.array("f"), array.array("f"), array.array("f")
    for r in range(rings + 1):
        theta = math.pi * r / rings
        for s in range(segments + 1):
            phi = 2 * math.pi * (s % segments) / segments  # bit-identical positions at the seam
            n = (math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi))
            bump = 1 + 0.04 * math.sin(5 * theta) * math.sin(7 * phi)
            positions.extend(bump * c for c in n)
            normals.extend(n)
            uvs.extend((4 * s / segments, 2 * r / rings))
    indices = array.array("I")
    for r in range(rings):
        for s in range(segments):
            a = r * (segments + 1) + s
            b = a + segments + 1
            if r > 0:
                indices.extend((a, a + 1, b))
            if r + 1 < rings:
                indices.extend((a + 1, b + 1, b))
    return positions, normals, uvs, indices


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", type=int, default=7_000_000)
    parser.add_argument("--meshes", type=int, default=400)
    parser.add_argument("--output", required=True)
    arguments = parser.parse_args()
    if not (1 <= arguments.meshes <= 100_000 and arguments.triangles >= 100 * arguments.meshes):
        parser.error("at least one mesh, and 100 triangles for each")
    rng = random.Random(1)

    views, accessors, pieces, size = [], [], [], 0

    def add(data, **accessor):
        nonlocal size
        data += b"\0" * (-len(data) % 4)
        views.append({"buffer": 0, "byteOffset": size, "byteLength": len(data)})
        pieces.append(data)
        size += len(data)
        if accessor:
            accessors.append({"bufferView": len(views) - 1, **accessor})
        return len(accessors) - 1 if accessor else len(views) - 1

    images, gltf_textures, materials = [], [], []
    for _ in range(MATERIALS):
        first = len(images)
        for image in textures(rng):
            images.append({"bufferView": add(image), "mimeType": "image/png"})
            gltf_textures.append({"source": len(images) - 1})
        materials.append({"pbrMetallicRoughness": {"baseColorTexture": {"index": first},
                                                   "metallicRoughnessTexture": {"index": first + 2}},
                          "normalTexture": {"index": first + 1}})

    positions, normals, uvs, indices = ball(arguments.triangles // arguments.meshes)
    vertex_count = len(positions) // 3
    columns = math.ceil(math.sqrt(arguments.meshes))
    meshes, nodes = [], []
    for i in range(arguments.meshes):
        size_m = 0.8 + 0.4 * rng.random()
        scaled = array.array("f", (size_m * p for p in positions))
        low = [min(scaled[c::3]) for c in range(3)]
        high = [max(scaled[c::3]) for c in range(3)]
        position = add(scaled.tobytes(), componentType=5126, count=vertex_count, type="VEC3", min=low, max=high)
        normal = add(normals.tobytes(), componentType=5126, count=vertex_count, type="VEC3")
        uv = add(uvs.tobytes(), componentType=5126, count=vertex_count, type="VEC2")
        index = add(indices.tobytes(), componentType=5125, count=len(indices), type="SCALAR")
        meshes.append({"primitives": [{"attributes": {"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv},
                                       "indices": index, "material": i % MATERIALS}]})
        nodes.append({"name": f"object_{i:04}", "mesh": i,
                      "translation": [2.6 * (i % columns - columns / 2), 1, 2.6 * (i // columns - columns / 2)]})
    reach = 2.6 * columns
    nodes += [{"name": "sun", "rotation": [-0.5, 0.2, 0, 0.84], "extensions": {"KHR_lights_punctual": {"light": 0}}},
              {"name": "camera", "camera": 0, "translation": [0, 0.75 * reach, 0.95 * reach],
               "rotation": [-math.sin(0.33), 0, 0, math.cos(0.33)]}]
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}],
                "extensionsUsed": ["KHR_lights_punctual"],
                "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3}]}},
                "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
                "nodes": nodes, "meshes": meshes, "materials": materials, "textures": gltf_textures, "images": images,
                "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": size}]}
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    with open(arguments.output, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + size))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", size, b"BIN\0"))
        for piece in pieces:
            file.write(piece)


if __name__ == "__main__":
    main()
