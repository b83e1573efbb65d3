"""Writer of small glTF scenes (.glb) and shapes for the reference scenes. Lengths in metres, Y up."""
import json
import struct

import numpy as np

from images import png

COMPONENT_TYPES = {np.dtype("float32"): 5126, np.dtype("uint32"): 5125}


def look_at(eye, target):
    """Rotation quaternion (x, y, z, w) of a node at `eye` whose -Z axis points at `target`."""
    back = np.subtract(eye, target, dtype=float)
    back /= np.linalg.norm(back)
    up = np.array([0, 0, -1.0]) if abs(back[1]) > 0.9999 else np.array([0, 1.0, 0])
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    m = np.stack([right, np.cross(back, right), back], axis=1)
    # Shepperd's method: the largest of the four components first.
    squares = np.array([1 + m[0, 0] - m[1, 1] - m[2, 2], 1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2],
                        1 + m[0, 0] + m[1, 1] + m[2, 2]])
    i = int(np.argmax(squares))
    pairs = np.array([[squares[0], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
                      [m[0, 1] + m[1, 0], squares[1], m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]],
                      [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], squares[2], m[1, 0] - m[0, 1]],
                      [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3]]])
    return (pairs[i] / (2 * np.sqrt(squares[i]))).tolist()


class Gltf:
    def __init__(self):
        self.bytes = bytearray()
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [],
                     "accessors": [], "bufferViews": [], "cameras": [], "textures": [], "images": []}
        self.lights = []

    def _add(self, group, value):
        self.json[group].append(value)
        return len(self.json[group]) - 1

    def _view(self, data):
        self.bytes += bytes(-len(self.bytes) % 4)
        self.bytes += data
        return self._add("bufferViews", {"buffer": 0, "byteOffset": len(self.bytes) - len(data), "byteLength": len(data)})

    def _accessor(self, values, kind, dtype=np.float32):
        values = np.ascontiguousarray(values, dtype)
        accessor = {"bufferView": self._view(values.tobytes()), "componentType": COMPONENT_TYPES[values.dtype], "count": len(values),
                    "type": kind}
        if kind == "VEC3":
            accessor.update(min=values.min(0).tolist(), max=values.max(0).tolist())
        return self._add("accessors", accessor)

    def node(self, **properties):
        node = self._add("nodes", {"name": f"node {len(self.json['nodes'])}", **properties})
        self.json["scenes"][0]["nodes"].append(node)
        return node

    def texture(self, pixels):
        """Index of a texture of 8-bit RGB pixels."""
        image = self._add("images", {"bufferView": self._view(png(pixels)), "mimeType": "image/png"})
        return self._add("textures", {"source": image})

    def material(self, color=(0.8, 0.8, 0.8), metallic=0.0, roughness=1.0, alpha=1.0, extensions=None, **properties):
        """extensions: dictionary of KHR_materials_ extensions without that prefix."""
        base = {"baseColorFactor": [*color, alpha], "metallicFactor": metallic, "roughnessFactor": roughness}
        if alpha < 1:
            properties["alphaMode"] = "BLEND"
        material = {"name": f"material {len(self.json['materials'])}", "pbrMetallicRoughness": base, **properties}
        if extensions:
            material["extensions"] = {"KHR_materials_" + name: value for name, value in extensions.items()}
        return self._add("materials", material)

    def matte(self, color=(0.8, 0.8, 0.8), alpha=1.0, **properties):
        """Lambert's material: a dielectric without specular reflection."""
        return self.material(color, alpha=alpha, extensions={"specular": {"specularFactor": 0}}, **properties)

    def mesh(self, shape, material, **node):
        """Node of a shape: dictionary of position, normal, index and, optionally, uv and tangent."""
        attributes = {"POSITION": self._accessor(shape["position"], "VEC3"), "NORMAL": self._accessor(shape["normal"], "VEC3")}
        if "uv" in shape:
            attributes["TEXCOORD_0"] = self._accessor(shape["uv"], "VEC2")
        if "tangent" in shape:
            attributes["TANGENT"] = self._accessor(shape["tangent"], "VEC4")
        primitive = {"attributes": attributes, "indices": self._accessor(np.ravel(shape["index"]), "SCALAR", np.uint32),
                     "material": material}
        return self.node(mesh=self._add("meshes", {"primitives": [primitive]}), **node)

    def light(self, kind, intensity, position=(0, 0, 0), target=(0, 0, 0), color=(1, 1, 1)):
        """kind: point (candela) or directional (lux; from `position` towards `target`)."""
        self.lights.append({"type": kind, "intensity": intensity, "color": list(color)})
        rotation = look_at(position, target) if kind == "directional" else [0, 0, 0, 1]
        self.node(translation=list(map(float, position)), rotation=rotation,
                  extensions={"KHR_lights_punctual": {"light": len(self.lights) - 1}})

    def camera(self, eye, target, vertical_fov_deg, aspect=4 / 3):
        camera = {"type": "perspective", "perspective": {"yfov": float(np.radians(vertical_fov_deg)), "aspectRatio": aspect,
                                                         "znear": 0.01, "zfar": 1000.0}}
        self.node(name="camera", camera=self._add("cameras", camera), translation=list(map(float, eye)), rotation=look_at(eye, target))

    def write(self, path):
        document = {name: value for name, value in self.json.items() if value != []}
        used = {name for material in self.json["materials"] for name in material.get("extensions", {})}
        if self.lights:
            document["extensions"] = {"KHR_lights_punctual": {"lights": self.lights}}
            used.add("KHR_lights_punctual")
        if used:
            document["extensionsUsed"] = sorted(used)
        self.bytes += bytes(-len(self.bytes) % 4)
        document["buffers"] = [{"byteLength": len(self.bytes)}]
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(self.bytes)))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(self.bytes), b"BIN\0") + self.bytes)


def sheet(half_x=1.0, half_z=1.0):
    """Horizontal rectangle around the origin, facing up."""
    return {"position": [[-half_x, 0, half_z], [half_x, 0, half_z], [half_x, 0, -half_z], [-half_x, 0, -half_z]], "normal": [[0, 1, 0]] * 4,
            "uv": [[0, 1], [1, 1], [1, 0], [0, 0]], "tangent": [[1, 0, 0, 1]] * 4, "index": [0, 1, 2, 0, 2, 3]}


def ball(radius_m=1.0, segments=64, rings=32):
    """Smooth-shaded sphere of quadrilaterals; its poles are on the Y axis."""
    phi, theta = np.meshgrid(np.linspace(0, 2 * np.pi, segments + 1), np.linspace(0, np.pi, rings + 1))
    normal = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], axis=-1).reshape(-1, 3)
    index = []
    for ring in range(rings):
        for segment in range(segments):
            first = ring * (segments + 1) + segment
            below = first + segments + 1
            if ring > 0:
                index += [first, below, first + 1]
            if ring < rings - 1:
                index += [first + 1, below, below + 1]
    return {"position": radius_m * normal, "normal": normal, "index": index}


def box(x, y, z):
    """Box with flat faces around the origin; x, y, z: whole lengths."""
    position, normal, index = [], [], []
    for axis in range(3):
        for sign in (1, -1):
            n, u = np.zeros(3), np.zeros(3)
            n[axis], u[(axis + 1) % 3] = sign, 1
            v = np.cross(n, u)
            first = len(position)
            position += [(n + a * u + b * v) / 2 for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            normal += [n] * 4
            index += [first, first + 1, first + 2, first, first + 2, first + 3]
    return {"position": np.array(position) * [x, y, z], "normal": normal, "index": index}


def rod(start, end, radius_m, sides=8):
    """Open, smooth-shaded cylinder."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    axis = (end - start) / np.linalg.norm(end - start)
    u = np.cross(axis, [0, 0, 1.0] if abs(axis[2]) < 0.9 else [1.0, 0, 0])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    angle = 2 * np.pi * np.arange(sides) / sides
    normal = np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * v
    index = []
    for i in range(sides):
        j = (i + 1) % sides
        index += [i, j, sides + j, i, sides + j, sides + i]
    return {"position": np.concatenate([start + radius_m * normal, end + radius_m * normal]), "normal": np.concatenate([normal, normal]),
            "index": index}
