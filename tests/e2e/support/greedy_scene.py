"""Scenes of greedy_peers_test: what the honest peer moves, and assets that are short as files and long as pixels."""
import json
import struct
import zlib


def write_glb(path, document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


class Binary:
    """The buffer of a glTF document, with its views and accessors."""

    def __init__(self):
        self.bytes, self.views, self.accessors = b"", [], []

    def view(self, data):
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data
        return len(self.views) - 1

    def accessor(self, data, component_type, count, kind, **limits):
        self.accessors.append({"bufferView": self.view(data), "componentType": component_type, "count": count, "type": kind,
                               **limits})
        return len(self.accessors) - 1

    def quad(self, half_m):
        """Attributes and indices of a square in the XY plane."""
        corners = [(-half_m, -half_m, 0), (half_m, -half_m, 0), (half_m, half_m, 0), (-half_m, half_m, 0)]
        attributes = {
            "POSITION": self.accessor(b"".join(struct.pack("<3f", *c) for c in corners), 5126, 4, "VEC3",
                                      min=list(corners[0]), max=list(corners[2])),
            "NORMAL": self.accessor(struct.pack("<3f", 0, 0, 1) * 4, 5126, 4, "VEC3"),
            "TEXCOORD_0": self.accessor(struct.pack("<8f", 0, 0, 1, 0, 1, 1, 0, 1), 5126, 4, "VEC2")}
        return {"attributes": attributes,
                "indices": self.accessor(struct.pack("<6I", 0, 1, 2, 0, 2, 3), 5125, 6, "SCALAR")}

    def document(self, **more):
        return {"asset": {"version": "2.0"}, "scene": 0, "accessors": self.accessors, "bufferViews": self.views,
                "buffers": [{"byteLength": len(self.bytes)}], **more}


def write_scene(path):
    """Below "root": a square "body" and two nodes called "twin", all lit by a sun; and a camera."""
    binary = Binary()
    meshes = [{"primitives": [{**binary.quad(half), "material": i}]} for i, half in enumerate((0.5, 0.3))]
    nodes = [{"name": "root", "children": [1, 2, 3]}, {"name": "body", "mesh": 0},
             {"name": "left", "translation": [0, 1, 0.2], "children": [4]},
             {"name": "right", "translation": [0, -1, 0.2], "children": [5]},
             {"name": "twin", "mesh": 1}, {"name": "twin", "mesh": 1},
             {"name": "camera", "camera": 0, "translation": [0.5, 0, 5]},
             {"name": "sun", "rotation": [-0.38, 0, 0, 0.92], "extensions": {"KHR_lights_punctual": {"light": 0}}}]
    write_glb(path, binary.document(
        scenes=[{"nodes": [0, 6, 7]}], nodes=nodes, meshes=meshes,
        materials=[{"pbrMetallicRoughness": {"baseColorFactor": [*c, 1]}} for c in ((0.8, 0.2, 0.1), (0.1, 0.3, 0.8))],
        cameras=[{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "zfar": 50}}],
        extensionsUsed=["KHR_lights_punctual"],
        extensions={"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3}]}}), binary.bytes)


def black_png(side):
    """One bit a pixel; zeros deflate to a thousandth."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    rows = zlib.compress(bytes(side * (1 + side // 8)), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 1, 0, 0, 0, 0)) + \
        chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def write_asset(path, images, side):
    """Squares with one texture each, of side * side black pixels."""
    binary = Binary()
    quad = binary.quad(0.5)
    png = black_png(side)
    count = range(images)
    write_glb(path, binary.document(
        scenes=[{"nodes": [0]}], nodes=[{"name": "picture", "mesh": 0}],
        images=[{"bufferView": binary.view(png), "mimeType": "image/png"} for _ in count],
        textures=[{"source": i} for i in count],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}} for i in count],
        meshes=[{"primitives": [{**quad, "material": i} for i in count]}]), binary.bytes)
