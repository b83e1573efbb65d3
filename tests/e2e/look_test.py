#!/usr/bin/env python3
"""End-to-end test of the default look: key light, ground, exposure, framing, exact unlit colours, and the warning for an
image that shows nothing."""
import base64
import json
import struct

from harness import Program, main, vulkan_environment
from image_reader import check, read_png

SIZE = (160, 120)
CUBE = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
FACES = [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3]


def write_cube(test, name, material=None, lights=None, cameras=()):
    """A cube of 2 m. cameras: (name, translation); they look along -Z."""
    data = b"".join(struct.pack("<3f", *p) for p in CUBE) + struct.pack(f"<{len(FACES)}H", *FACES)
    nodes = [{"name": "cube", "mesh": 0}]
    for i, (camera, translation) in enumerate(cameras):
        nodes.append({"name": camera, "camera": i, "translation": translation})
    document = {
        "asset": {"version": "2.0"}, "nodes": nodes,
        "buffers": [{"uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
                     "byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 2 * len(FACES)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [-1] * 3, "max": [1] * 3},
                      {"bufferView": 1, "componentType": 5123, "count": len(FACES), "type": "SCALAR"}],
        "materials": [material or {}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "extensionsUsed": ["KHR_materials_unlit", "KHR_lights_punctual"],
    }
    if cameras:
        document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.01}} for _ in cameras]
    if lights:
        document["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
        nodes.append({"name": "lamp", "rotation": [-0.6, 0.2, 0, 0.7746],
                      "extensions": {"KHR_lights_punctual": {"light": 0}}})
    path = test.path(name)
    with open(path, "w", encoding="utf-8") as file:
        json.dump(document, file)
    return path


def draw(test, scene, *arguments, cache="off"):
    """Returns the PNG and what was said."""
    out = test.path("out")
    run = Program(test, "fire3dv", [test.programs_at["fire3dv"], scene, "--validation", "--headless", "--frames", "1",
                                    "--size", "%dx%d" % SIZE, "--cache", cache, "--out", out, *arguments],
                  env=vulkan_environment())
    check(run.wait() == 0, run.stderr_text())
    return read_png(out + "/frame_000000.png"), run.stderr_text()


def at(picture, x, y):
    return tuple(picture.rows[y][3 * x:3 * x + 3])


def key_light_and_ground(test):
    cube = write_cube(test, "cube.gltf")
    lit, said = draw(test, cube)
    check("0 lights (a key light is added)" in said, said)
    dark, said = draw(test, cube, "--key-light", "off")
    check("0 lights," in said, said)
    plain, _ = draw(test, cube, "--ground", "off")
    centre = SIZE[0] // 2, SIZE[1] // 2 - 20
    check(at(lit, *centre)[0] > at(dark, *centre)[0] + 20, f"{at(lit, *centre)} and {at(dark, *centre)}")
    shadowed = sum(sum(a[3 * x:3 * x + 3]) < sum(b[3 * x:3 * x + 3]) - 30
                   for a, b in zip(lit.rows, plain.rows) for x in range(SIZE[0]))
    check(150 < shadowed < 6000, f"{shadowed} pixels in the shadow")
    own, said = draw(test, write_cube(test, "lamp.gltf", lights=[{"type": "directional", "intensity": 2}]))
    check("1 light," in said and "key light" not in said, said)
    # A cache written with a key light serves runs without one, and the other way round.
    cache = test.path("cache")
    for arguments, wanted in (((), lit), (("--key-light", "off"), dark), ((), lit)):
        again, _ = draw(test, cube, *arguments, cache=cache)
        check(again.rows == wanted.rows, f"from the cache, {arguments}")


def exposure(test):
    _, said = draw(test, write_cube(test, "day.gltf", lights=[{"type": "directional", "intensity": 100000}]))
    check("info: exposure 7.54e-05: lights give about 1e+05 lux" in said, said)
    _, said = draw(test, test.path("day.gltf"), "--exposure", "1")
    check("exposure" not in said, said)


def unlit_colours(test):
    orange = {"pbrMetallicRoughness": {"baseColorFactor": [1, 0.21223075, 0, 1]}, "extensions": {"KHR_materials_unlit": {}}}
    picture, _ = draw(test, write_cube(test, "unlit.gltf", orange), "--exposure", "3", "--background", "204080")
    check(at(picture, SIZE[0] // 2, SIZE[1] // 2) == (255, 127, 0), at(picture, SIZE[0] // 2, SIZE[1] // 2))
    check(at(picture, 2, 2) == (0x20, 0x40, 0x80), at(picture, 2, 2))


def covered(picture):
    """Rows and columns of the unlit white cube."""
    rows = [y for y, row in enumerate(picture.rows) if b"\xff\xff\xff" in bytes(row)]
    columns = [x for x in range(SIZE[0]) if any(bytes(row[3 * x:3 * x + 3]) == b"\xff\xff\xff" for row in picture.rows)]
    return rows[0], rows[-1], columns[0], columns[-1]


def framing(test):
    white = {"extensions": {"KHR_materials_unlit": {}}}
    cameras = [("away", [0, 0, -5]), ("inside", [0, 0, 1.5])]
    scene = write_cube(test, "framed.gltf", white, cameras=cameras)
    _, said = draw(test, scene, "--background", "000000")
    check('warning: nothing is visible: everything is behind camera "away"; --camera auto' in said, said)
    for arguments in (["--camera", "auto"], ["--camera", "inside", "--frame-all"]):
        picture, said = draw(test, scene, "--background", "000000", *arguments)
        check("nothing is visible" not in said, said)
        top, bottom, left, right = covered(picture)
        # Margins of 5 %: 6 of 120 rows.
        check(5 <= top <= 8 and 111 <= bottom <= 114, f"{arguments}: rows {top} to {bottom}")
        check(left > 8 and right < SIZE[0] - 8, f"{arguments}: columns {left} to {right}")


if __name__ == "__main__":
    main({"key_light_and_ground": key_light_and_ground, "exposure": exposure, "unlit_colours": unlit_colours,
          "framing": framing}, ["fire3dv"])
