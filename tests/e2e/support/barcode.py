"""Bar code scene that encodes a frame number: a row of white bars before black, one node for each bit and its complement."""
import json
import math
import struct

BITS = 16
BARS = 2 * BITS
SIZE = (4 * BARS, 8)  # pixels
NAMES = [f"bar {i}" for i in range(BARS)]
CAMERA = "front"
OBLIQUE = "oblique"  # sees all bars; none of the numbers of its projection is round
DISTANCE = 40.0


def write_scene(path):
    """Writes a glb of the bars with a camera that maps a bar to 4 pixels, and an oblique one; the unit is one bar."""
    half_height = BARS * SIZE[1] / SIZE[0] / 2
    corners = [(-0.5, -half_height, 0), (0.5, -half_height, 0), (0.5, half_height, 0), (-0.5, half_height, 0)]
    data = [b"".join(struct.pack("<3f", *c) for c in corners), struct.pack("<3f", 0, 0, 1) * 4,
            struct.pack("<6I", 0, 1, 2, 0, 2, 3)]
    offsets = [sum(len(d) for d in data[:i]) for i in range(len(data))]
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(BARS + 2))}],
        "nodes": [{"name": name, "mesh": 0} for name in NAMES] +
                 [{"name": CAMERA, "camera": 0, "translation": [0, 0, DISTANCE]},
                  {"name": OBLIQUE, "camera": 1, "translation": [3.1, 2.3, DISTANCE], "scale": [1.3] * 3,
                   "rotation": [-0.0275, 0.0371, 0.0113, 0.99887]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"extensions": {"KHR_materials_unlit": {}}, "pbrMetallicRoughness": {"baseColorFactor": [1] * 4}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                       "min": list(corners[0]), "max": list(corners[2])},
                      {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 2, "componentType": 5125, "count": 6, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": o, "byteLength": len(d)} for o, d in zip(offsets, data)],
        "buffers": [{"byteLength": sum(len(d) for d in data)}], "extensionsUsed": ["KHR_materials_unlit"],
        "cameras": [{"type": "perspective", "perspective": {
            "yfov": 2 * math.atan(half_height / DISTANCE), "aspectRatio": SIZE[0] / SIZE[1], "znear": 1, "zfar": 100}},
            {"type": "perspective", "perspective": {"yfov": 0.137, "znear": 0.7}}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(data)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def poses_of(number):
    """Returns 12 numbers for each bar; bars that are off stand behind the camera."""
    poses = []
    for bar in range(BARS):
        on = (number >> (bar // 2) & 1) ^ (bar % 2)
        poses.append([1, 0, 0, bar - (BARS - 1) / 2, 0, 1, 0, 0, 0, 0, 1, 0 if on else 2 * DISTANCE])
    return poses


def number_of(color):
    """Returns the number in an image (height, width, 4) of uint8; None if invalid, as a mixture of two frames is."""
    line = color[SIZE[1] // 2, 2::4, 0] > 127
    number = 0
    for bit in range(BITS):
        if line[2 * bit] == line[2 * bit + 1]:
            return None
        number |= int(line[2 * bit]) << bit
    return number
