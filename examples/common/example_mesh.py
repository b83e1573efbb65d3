"""Meshes and glTF files of the Python examples: surfaces of revolution, tubes, boxes, and a writer of binary glTF."""
import json
import struct

import numpy as np

WHITE = (1.0, 1.0, 1.0)


class Mesh:
    """positions, normals, colors: (n, 3), metres and linear RGB; faces: (m, 3), counter-clockwise from outside."""

    def __init__(self, positions, normals, faces, color=WHITE):
        self.positions, self.normals, self.faces = (np.asarray(a) for a in (positions, normals, faces))
        color = np.asarray(color, float)
        self.colors = color if color.ndim == 2 else np.tile(color, (len(self.positions), 1))
        #: Further attributes of vertices by glTF's name, such as TEXCOORD_0: (array, dtype, glTF type). moved and joined drop them.
        self.attributes = {}

    def moved(self, translation=(0, 0, 0), rotation=np.eye(3)):
        rotation = np.asarray(rotation)
        return Mesh(self.positions @ rotation.T + translation, self.normals @ rotation.T, self.faces, self.colors)


def joined(*meshes):
    starts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes])
    return Mesh(*(np.concatenate([getattr(mesh, field) for mesh in meshes]) for field in ("positions", "normals")),
                np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts)]),
                np.concatenate([mesh.colors for mesh in meshes]))


def grid_faces(rows, columns):
    """Triangles between the vertices of a grid with (rows + 1) * (columns + 1) vertices, row by row."""
    a = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    return np.concatenate([np.column_stack([a, a + 1, a + columns + 2]), np.column_stack([a, a + columns + 2, a + columns + 1])])


def smooth_normals(positions, faces):
    """Mean of the faces' normals by area; vertices at one place, as at a seam, share theirs."""
    corners = positions[faces]
    normals = np.zeros_like(positions)
    of_face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for k in range(3):
        np.add.at(normals, faces[:, k], of_face)
    _, same = np.unique(np.round(positions, 7), axis=0, return_inverse=True)
    same = same.ravel()
    sums = np.zeros((same.max() + 1, 3))
    np.add.at(sums, same, normals)
    normals = sums[same]
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def lathe(profile, color=WHITE, sides=48):
    """Turns a profile of (radius, height) about the Y axis, from its lower to its upper end with the outside to the
    right. Corners of more than 40 degrees stay sharp. color: one, or one for each point of the profile."""
    profile = np.asarray(profile, float)
    colors = np.broadcast_to(np.asarray(color, float), (len(profile), 3))
    steps = np.diff(profile, axis=0)
    outward = np.column_stack([steps[:, 1], -steps[:, 0]]) / np.linalg.norm(steps, axis=1, keepdims=True)
    around = np.linspace(0, 2 * np.pi, sides + 1)
    circle = np.column_stack([np.sin(around), np.cos(around)])
    parts = []
    for i, normal in enumerate(outward):
        ends = []
        for end, neighbour in ((i, i - 1), (i + 1, i + 1)):
            shared = 0 <= neighbour < len(outward) and outward[neighbour] @ normal > np.cos(np.radians(40))
            at = normal + outward[neighbour] if shared else normal
            at = at / np.linalg.norm(at)
            radius, height = profile[end]
            ends.append((np.column_stack([radius * circle[:, 0], np.full(sides + 1, height), radius * circle[:, 1]]),
                         np.column_stack([at[0] * circle[:, 0], np.full(sides + 1, at[1]), at[0] * circle[:, 1]]),
                         np.tile(colors[end], (sides + 1, 1))))
        positions, normals, of_vertex = (np.concatenate([end[k] for end in ends]) for k in range(3))
        parts.append(Mesh(positions, normals, grid_faces(1, sides), of_vertex))
    return joined(*parts)


def tube(path, radii, color=WHITE, sides=24):
    """A tube along a path of points, (n, 3), with a radius at each of them; a radius of 0 closes an end."""
    path = np.asarray(path, float)
    radii = np.broadcast_to(np.asarray(radii, float), len(path))
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along[0], [0.3, 0.8, 0.5])
    rings = []
    around = np.linspace(0, 2 * np.pi, sides + 1)
    for point, direction, radius in zip(path, along, radii):
        side = side - direction * (side @ direction)  # carried along without twist
        side /= np.linalg.norm(side)
        up = np.cross(direction, side)
        rings.append(point + radius * (np.outer(np.cos(around), side) + np.outer(np.sin(around), up)))
    positions, faces = np.concatenate(rings), grid_faces(len(path) - 1, sides)
    colors = np.asarray(color, float)
    if colors.ndim == 2:  # one for each point of the path
        colors = np.repeat(colors, sides + 1, axis=0)
    return Mesh(positions, smooth_normals(positions, faces), faces, colors)


def box(size, color=WHITE):
    """Centred at the origin."""
    sides = []
    for turn in range(3):
        axes = np.roll(np.eye(3), turn, axis=1)
        for sign in (1, -1):
            u, v = (axes[0], axes[1]) if sign > 0 else (axes[1], axes[0])
            corners = [sign * 0.5 * axes[2] + (a - 0.5) * u + (b - 0.5) * v for b in (0, 1) for a in (0, 1)]
            sides.append(Mesh(np.array(corners) * size, np.tile(sign * axes[2], (4, 1)), grid_faces(1, 1), color))
    return joined(*sides)


class Gltf:
    """A binary glTF file in the making: root nodes, each with one mesh."""

    _COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
    _TYPES = {"<f4": 5126, "<u4": 5125, "<u2": 5123}

    def __init__(self):
        self.document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
                         "materials": [], "accessors": [], "bufferViews": [], "buffers": [{}]}
        self.binary = b""

    def _view(self, data):
        self.document["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data + b"\0" * (-len(data) % 4)
        return len(self.document["bufferViews"]) - 1

    def accessor(self, array, dtype, kind):
        """kind: glTF's type, such as VEC3. Returns its index."""
        document, view = self.document, self._view(np.ascontiguousarray(array, dtype).tobytes())
        bounds = {"min": array.astype("<f4").min(0).tolist(), "max": array.astype("<f4").max(0).tolist()} if kind == "VEC3" else {}
        document["accessors"].append({"bufferView": view, "type": kind, "count": array.size // self._COMPONENTS[kind],
                                      "componentType": self._TYPES[dtype], **bounds})
        return len(document["accessors"]) - 1

    def texture(self, png):
        """png: contents of a file. Returns glTF's reference to the texture."""
        for kind in ("images", "textures"):
            self.document.setdefault(kind, [])
        self.document["images"].append({"bufferView": self._view(png), "mimeType": "image/png"})
        self.document["textures"].append({"source": len(self.document["images"]) - 1})
        return {"index": len(self.document["textures"]) - 1}

    def material(self, roughness, metallic=0.0, clearcoat=0.0, **more):
        if clearcoat > 0:
            self.document["extensionsUsed"] = ["KHR_materials_clearcoat"]
            more["extensions"] = {"KHR_materials_clearcoat": {"clearcoatFactor": clearcoat, "clearcoatRoughnessFactor": 0.1}}
        textures = {name: more.pop(name) for name in ("baseColorTexture", "metallicRoughnessTexture") if name in more}
        self.document["materials"].append({"pbrMetallicRoughness": {"metallicFactor": metallic, "roughnessFactor": roughness, **textures}, **more})
        return len(self.document["materials"]) - 1

    def _primitive(self, mesh, material):
        indices = self.accessor(mesh.faces.ravel(), "<u4", "SCALAR")
        attributes = {"POSITION": self.accessor(mesh.positions, "<f4", "VEC3"), "NORMAL": self.accessor(mesh.normals, "<f4", "VEC3"),
                      "COLOR_0": self.accessor(mesh.colors, "<f4", "VEC3"),
                      **{name: self.accessor(*values) for name, values in mesh.attributes.items()}}
        return {"material": material, "indices": indices, "attributes": attributes}

    def node(self, name, mesh=None, material=None, semantic=None, **more):
        """mesh: a Mesh of one material, or a list of (Mesh, material). more: further members of glTF's node."""
        extras = {**({"semantic": semantic} if semantic else {}), **more.pop("extras", {})}
        node = {"name": name, **({"extras": extras} if extras else {}), **more}
        parts = [(mesh, material)] if isinstance(mesh, Mesh) else mesh
        if parts:
            self.document["meshes"].append({"primitives": [self._primitive(*part) for part in parts]})
            node["mesh"] = len(self.document["meshes"]) - 1
        self.document["scenes"][0]["nodes"].append(len(self.document["nodes"]))
        self.document["nodes"].append(node)

    def write(self, path):
        self.document["buffers"][0]["byteLength"] = len(self.binary)
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(self.binary)))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(self.binary), b"BIN\0") + self.binary)
