"""Scenes of the tests with more in them: the JSON and the binary of a glb file, changed and written again."""
import json
import struct


def edit_glb(source, path, change):
    """change(document, binary) edits the document and returns the binary."""
    with open(source, "rb") as file:
        data = file.read()
    length, = struct.unpack_from("<I", data, 12)
    document, binary = json.loads(data[20:20 + length]), data[28 + length:]
    binary = change(document, binary)
    document["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)
    return path


def add_slide(source, path, first_place, last_place, duration_s, names=("red", "blue")):
    """Adds an animation "slide" that moves these nodes along x."""
    def change(document, binary):
        for values, kind in (((0, duration_s), "SCALAR"), ((first_place, 0, 0, last_place, 0, 0), "VEC3")):
            document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": 4 * len(values)})
            document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": 5126, "count": 2,
                                          "type": kind})
            binary += struct.pack(f"<{len(values)}f", *values)
        nodes = [node["name"] for node in document["nodes"]]
        output = len(document["accessors"]) - 1
        document["animations"] = [{"name": "slide", "samplers": [{"input": output - 1, "output": output}],
                                   "channels": [{"sampler": 0, "target": {"node": nodes.index(name), "path": "translation"}}
                                                for name in names]}]
        return binary
    return edit_glb(source, path, change)


def add_variants(source, path, variants):
    """Adds KHR_materials_variants. variants: by name, the name of the material that red has in it."""
    def change(document, binary):
        materials = [material["name"] for material in document["materials"]]
        red = next(mesh for mesh in document["meshes"] if mesh["name"] == "red")["primitives"][0]
        red["extensions"] = {"KHR_materials_variants": {"mappings": [
            {"material": materials.index(material), "variants": [i]} for i, material in enumerate(variants.values())]}}
        document["extensions"] = {**document.get("extensions", {}),
                                  "KHR_materials_variants": {"variants": [{"name": name} for name in variants]}}
        document["extensionsUsed"].append("KHR_materials_variants")
        return binary
    return edit_glb(source, path, change)
