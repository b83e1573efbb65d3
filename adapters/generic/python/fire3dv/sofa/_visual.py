"""Visual models of SOFA as glTF: vertices, triangles, texture coordinates, materials and images. Needs NumPy."""
from __future__ import annotations

import json
import struct
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

from ..errors import ArgumentError, ErrorCode, warn

MESH = "mesh"  # node of an added asset, whose vertices are replaced
_DEFAULT_COLOR = (0.75, 0.75, 0.75, 1.0)  # of SOFA's materials
_IMAGES = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg"}


def value(item: Any, name: str) -> Any:
    """Value of a Data field; None where the object has none."""
    data = item.findData(name)
    return None if data is None else data.value


def rows_of(item: Any, name: str, kind: Any, width: int) -> Any:
    """(n, width); of no rows where the field is missing or empty."""
    held = value(item, name)
    rows = np.zeros((0, width), kind) if held is None or len(held) == 0 else np.array(held, kind)
    if rows.ndim != 2 or rows.shape[1] != width:
        raise ArgumentError(ErrorCode.ARGUMENT, f"{item.getPathName()}.{name} has the shape {rows.shape}; (n, {width}) is needed")
    return rows


def _linear(srgb: Sequence[float]) -> List[float]:
    return [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (min(max(float(c), 0.0), 1.0) for c in srgb)]


def _material(text: str) -> Dict[str, Any]:
    """glTF's material of the value of OglModel's "material", such as "Default Diffuse 1 0.8 0.1 0.1 1 ... Shininess 1 45".

    Colours are those of the screen in SOFA, so sRGB. The roughness has the highlight's width of Phong's exponent.
    """
    used: Dict[str, List[float]] = {}
    numbers: List[float] = []
    for word in text.split():
        if word.lower() in ("diffuse", "ambient", "specular", "emissive", "shininess"):
            numbers = used[word.lower()] = []
            continue
        try:
            numbers.append(float(word))
        except ValueError:
            numbers = []  # the material's name
    used = {name: numbers[1:] for name, numbers in used.items() if numbers and numbers[0] != 0}
    color = (used.get("diffuse", []) + list(_DEFAULT_COLOR)[len(used.get("diffuse", [])):])[:4]
    shiny = used["shininess"][0] if "specular" in used and used.get("shininess") else 10.0
    roughness = (2 / (2 + min(max(shiny, 0.0), 1e4))) ** 0.25
    material: Dict[str, Any] = {"doubleSided": True, "pbrMetallicRoughness": {
        "baseColorFactor": [*_linear(color[:3]), min(max(color[3], 0.0), 1.0)], "metallicFactor": 0.0, "roughnessFactor": roughness}}
    if color[3] < 1:
        material["alphaMode"] = "BLEND"
    if len(used.get("emissive", [])) >= 3:
        material["emissiveFactor"] = _linear(used["emissive"][:3])
    return material


def glb_file(document: Dict[str, Any], blobs: Sequence[bytes]) -> bytes:
    """A .glb file; blob i is buffer view i."""
    binary, views = b"", []
    for blob in blobs:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(blob)})
        binary += blob + b"\0" * (-len(blob) % 4)
    if views:
        document = {**document, "bufferViews": views, "buffers": [{"byteLength": len(binary)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if views:
        chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def is_visual(item: Any) -> bool:
    """OglModel, or another visual model with triangles, and not the topology or state that it follows."""
    return item.findData("material") is not None and item.findData("triangles") is not None and item.findData("position") is not None


class VisualModel:
    """A visual model as it was sent."""

    def __init__(self, model: Any, name: str) -> None:
        self.model, self.name = model, name
        self.shown = True
        self.faces: Any = None  # (n, 3) uint32; None: not added
        self.places: Any = None  # (n, 3) float32, of the last frame
        self._look: Any = None  # texture coordinates and material

    def places_now(self) -> Any:
        """(n, 3) float32: vertices, of which several may have one position, as at the border of a texture."""
        positions = rows_of(self.model, "position", np.float32, 3)
        split = value(self.model, "vertPosIdx")
        return positions if split is None or len(split) == 0 else positions[np.asarray(split, np.int64)]

    def faces_now(self, count: int) -> Any:
        quads = rows_of(self.model, "quads", np.int64, 4)
        faces = np.concatenate([rows_of(self.model, "triangles", np.int64, 3), quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        wrong = ((faces < 0) | (faces >= count)).any(axis=1)
        if wrong.any():
            raise ArgumentError(ErrorCode.ARGUMENT, f"{self.model.getPathName()} has the triangle {faces[np.argmax(wrong)].tolist()}, "
                                f"but {count} vertices")
        return faces.astype(np.uint32)

    def has_changed(self, faces: Any, places: Any) -> bool:
        """Whether the mesh has other triangles, texture coordinates or a material other than were added."""
        coordinates = rows_of(self.model, "texcoords", np.float32, 2)
        look = (coordinates.tobytes(), str(value(self.model, "material")), str(value(self.model, "texturename")))
        same = self.faces is not None and len(places) == len(self.places) and np.array_equal(faces, self.faces) and look == self._look
        self._look = look
        return not same

    def normals(self, faces: Any, places: Any) -> Any:
        """By SOFA's rule: sums over triangles by area, of vertices that share a normal."""
        shared = value(self.model, "vertNormIdx")
        groups = np.arange(len(places)) if shared is None or len(shared) != len(places) else np.asarray(shared, np.int64)
        corners = places.astype(np.float64)[faces]
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        sums = np.zeros((groups.max() + 1, 3))
        for k in range(3):
            np.add.at(sums, groups[faces[:, k]], areas)
        lengths = np.linalg.norm(sums, axis=1, keepdims=True)
        return np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1), (0, 0, 1))[groups].astype(np.float32)

    def glb(self, faces: Any, places: Any) -> bytes:
        blobs = [faces.tobytes(), places.tobytes(), self.normals(faces, places).tobytes()]
        attributes = {"POSITION": 1, "NORMAL": 2}
        accessors: List[Dict[str, Any]] = [
            {"bufferView": 0, "componentType": 5125, "count": faces.size, "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": len(places), "type": "VEC3",
             "min": places.min(0).tolist(), "max": places.max(0).tolist()},
            {"bufferView": 2, "componentType": 5126, "count": len(places), "type": "VEC3"}]
        material = _material(str(value(self.model, "material") or ""))
        document: Dict[str, Any] = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}]}
        coordinates = rows_of(self.model, "texcoords", np.float32, 2)
        if len(coordinates) == len(places):
            coordinates[:, 1] = 1 - coordinates[:, 1]  # OpenGL's images begin at the bottom, glTF's at the top
            accessors.append({"bufferView": len(blobs), "componentType": 5126, "count": len(places), "type": "VEC2"})
            blobs.append(coordinates.tobytes())
            attributes["TEXCOORD_0"] = 3
            image = self._image()
            if image is not None:
                document["images"] = [{"bufferView": len(blobs), "mimeType": image[0]}]
                document["textures"] = [{"source": 0}]
                material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
                blobs.append(image[1])
        document.update(nodes=[{"name": MESH, "mesh": 0}], materials=[material], accessors=accessors, meshes=[
            {"primitives": [{"attributes": attributes, "indices": 0, "material": 0}]}])
        return glb_file(document, blobs)

    def _image(self) -> Optional[Tuple[str, bytes]]:
        name = str(value(self.model, "texturename") or "")
        if not name:
            return None
        try:
            with open(name, "rb") as file:
                data = file.read()
        except OSError as fault:
            warn(f"the texture {name!r} of {self.model.getPathName()} is left out: {fault.strerror}")
            return None
        for start, kind in _IMAGES.items():
            if data.startswith(start):
                return kind, data
        warn(f"the texture {name!r} of {self.model.getPathName()} is left out: it is neither a PNG nor a JPEG file")
        return None
