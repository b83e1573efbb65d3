#!/usr/bin/env python3
"""End-to-end test of output planes and boxes as files: they agree with the colour image and with the poses."""
import ast
import json
import os
import struct

from harness import main
from image_reader import HALF_SQUARE, PLACE_AT_REST, SIZE, SQUARES, check, write_scene

NAMES = ["linear", "depth", "instance", "semantic", "normal", "motion", "albedo", "roughness", "metallic", "position",
         "occlusion"]


def read_npy(path):
    """Returns the pixels by rows, each a tuple."""
    with open(path, "rb") as file:
        data = file.read()
    check(data[:8] == b"\x93NUMPY\x01\x00", f"{path} begins with {data[:8]}")
    begin = 10 + struct.unpack_from("<H", data, 8)[0]
    check(begin % 64 == 0, f"{path}: numbers begin at {begin}")
    head = ast.literal_eval(data[10:begin].decode().strip())
    kind = {"<f2": "e", "<f4": "f", "<u4": "I"}[head["descr"]]
    shape = head["shape"]
    channels = shape[2] if len(shape) == 3 else 1
    check(shape[:2] == (SIZE[1], SIZE[0]), f"{path} is of {shape}")
    row = struct.Struct(f"<{shape[1] * channels}{kind}")
    check(len(data) == begin + shape[0] * row.size, f"{path} has {len(data)} bytes")
    rows = [row.unpack_from(data, begin + y * row.size) for y in range(shape[0])]
    return [[values[x * channels:(x + 1) * channels] for x in range(shape[1])] for values in rows]


def read_masks(path, count):
    """Returns of each mask the set of its pixels (x, y)."""
    with open(path, "rb") as file:
        data = file.read()
    begin = 10 + struct.unpack_from("<H", data, 8)[0]
    head = ast.literal_eval(data[10:begin].decode().strip())
    row = (SIZE[0] + 7) // 8
    check(head["descr"] == "|u1" and head["shape"] == (count, SIZE[1], row), f"{path} is {head}")
    check(len(data) == begin + count * SIZE[1] * row, f"{path} has {len(data)} bytes")
    return [{(x, y) for y in range(SIZE[1]) for x in range(SIZE[0])
             if data[begin + (mask * SIZE[1] + y) * row + x // 8] >> (7 - x % 8) & 1} for mask in range(count)]


def instances(renderer):
    with open(os.path.join(renderer.folder, "instances.jsonl"), encoding="utf-8") as file:
        return {entry["name"]: entry for entry in map(json.loads, file)}


def write_classes(path):
    """Writes the squares' scene with a class for two of them."""
    with open(path, "rb") as file:
        data = file.read()
    length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20:20 + length])
    for node, semantic in ((0, 7), (1, 3_000_000_000)):
        document["nodes"][node]["extras"] = {"semantic": semantic, "other": {"is": "left alone"}}
    document["nodes"][2]["extras"] = {"semantic": "blue"}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length:]
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + rest)


def all_outputs(test):
    scene = test.path("classes.glb")
    write_scene(scene)
    write_classes(scene)
    renderer = test.renderer("--frames", "2", "--outputs", "color," + ",".join(NAMES) + ",boxes2d,boxes3d,amodal",
                             "--samples", "1", "--fxaa", "off", scene=scene)
    renderer.expect_exit(0)
    check(renderer.find_err(r"nodes\[2\].extras.semantic is not a whole number"), "a word passes for a class")
    frames = renderer.frames()
    check(len(frames) == 2, f"{len(frames)} frames")
    frame = frames[1]
    check(sorted(frame["planes"]) == sorted([*NAMES, "amodal"]), f"planes are {frame['planes']}")
    masks = read_masks(os.path.join(renderer.folder, frame["planes"].pop("amodal")), len(frame["amodal"]))
    planes = {name: read_npy(os.path.join(renderer.folder, file)) for name, file in frame["planes"].items()}
    picture = renderer.picture(frame)
    known = instances(renderer)
    classes = {"red": 7, "green": 3_000_000_000, "blue": 0}
    check({name: known[name]["semantic"] for name in SQUARES} == classes, f"classes are {known}")
    for name, (colour, row) in SQUARES.items():
        instance = known[name]["instance"]
        x0, y0 = int(SIZE[0] / 2 + PLACE_AT_REST - HALF_SQUARE), int(SIZE[1] / 2 - row - HALF_SQUARE)
        here = [(x, y) for y in range(SIZE[1]) for x in range(SIZE[0]) if planes["instance"][y][x] == (instance,)]
        side = 2 * HALF_SQUARE
        check(here == [(x, y) for y in range(y0, y0 + side) for x in range(x0, x0 + side)],
              f"{name} is labelled at {here[:3]}..., not from {x0}, {y0}")
        for x, y in here:
            check(planes["depth"][y][x] == (50,), f"{name} is {planes['depth'][y][x]} m away, not 50")
            check(planes["semantic"][y][x] == (classes[name],), f"{name} is of class {planes['semantic'][y][x]}")
            check(planes["normal"][y][x] == (0, 0, 1, 0), f"{name}'s normal is {planes['normal'][y][x]}")
            check(planes["motion"][y][x] == (0, 0), f"{name} moves by {planes['motion'][y][x]}")
            place = (x + 0.5 - SIZE[0] / 2, SIZE[1] / 2 - y - 0.5)
            check(max(abs(a - b) for a, b in zip(planes["position"][y][x], (*place, 0, 1))) < 1e-3,
                  f"{name} is at {planes['position'][y][x]}, not {place}")
            check(planes["occlusion"][y][x] == (0,), f"{name} was hidden")
            check(planes["linear"][y][x] == (*colour, 1), f"{name} shines with {planes['linear'][y][x]}")
            seen = picture.pixel(x, y)
            check([c > 100 for c in seen] == [bool(c) for c in colour], f"{name} is {seen} in the picture")
        box = next(b for b in frame["boxes2d"] if b["instance"] == instance)
        check(box == {"instance": instance, "semantic": classes[name], "box": [x0, y0, x0 + side, y0 + side],
                      "pixels": side * side}, f"{name}: {box}")
        number, entry = next((i, e) for i, e in enumerate(frame["amodal"]) if e["instance"] == instance)
        check(entry == {"instance": instance, "semantic": classes[name], "px_all": side * side, "px_visible": side * side,
                        "visibility": 1, "box_full": [x0, y0, x0 + side, y0 + side], "truncated": False}, f"{name}: {entry}")
        check(masks[number] == set(here), f"{name}'s mask is not what is seen of it")
        cube = next(b for b in frame["boxes3d"] if b["instance"] == instance)["world_from_box"]
        check(cube == [side, 0, 0, PLACE_AT_REST, 0, side, 0, row, 0, 0, 0, 0], f"{name}: {cube}")
    nothing = planes["depth"][0][0] == (float("inf"),) and planes["instance"][0][0] == (0,)
    check(nothing and planes["semantic"][0][0] == (0,), "the background is not told apart")


def planes_alone(test):
    """Without colour among the outputs no colour is written or listed; boxes alone are possible. A setting that the CPU
    driver ignores is reported."""
    renderer = test.renderer("--frames", "1", "--outputs", "boxes2d,depth", "--anisotropy", "4")
    renderer.expect_exit(0)
    check("llvmpipe" not in renderer.stderr_text() or renderer.find_err("--anisotropy: .*filters isotropically"),
          renderer.stderr_text())
    files = sorted(os.listdir(renderer.folder))
    check(files == ["frame_000000.depth.npy", "frames.jsonl", "instances.jsonl"], f"there are {files}")
    frame, = renderer.frames()
    check("file" not in frame and len(frame["boxes2d"]) == 3 and "boxes3d" not in frame, f"{frame}")


def views(test):
    """A view shows the scene that the planes describe, and requires its inputs."""
    renderer = test.renderer("--frames", "1", "--view", "normals", "--outputs", "color,instance", "--samples", "1")
    renderer.expect_exit(0)
    frame, = renderer.frames()
    picture = renderer.picture(frame)
    instance = read_npy(os.path.join(renderer.folder, frame["planes"]["instance"]))
    for y in range(SIZE[1]):
        for x in range(SIZE[0]):
            seen, wanted = picture.pixel(x, y), (15, 15, 15) if instance[y][x] == (0,) else (128, 128, 255)
            check(all(abs(a - b) <= 1 for a, b in zip(seen, wanted)), f"{x}, {y} is {seen}, not {wanted}")
    for arguments, code, says in ((["--view", "sideways"], 2, "--view: .*sideways"),
                                  (["--view", "depth", "--outputs", "depth"], 2, "--view .*needs color"),
                                  (["--view", "depth", "--raster", "forward"], 1, "--view: .*leave --raster forward out"),
                                  (["--view", "unresolved-shadows", "--shadows", "map"], 1, "--view: .*shadow technique is shadow maps")):
        renderer = test.renderer("--frames", "1", *arguments)
        renderer.expect_exit(code)
        check(renderer.find_err(says), renderer.stderr_text())


def refusals(test):
    for arguments, says in ((["--outputs", "color,linear", "--markers", "all"], "--markers all"),
                            (["--outputs", "depth,dept"], 'no output "dept"'),
                            (["--outputs", "depth,depth"], '"depth" is named twice')):
        renderer = test.renderer("--frames", "1", *arguments)
        renderer.expect_exit(2)
        check(renderer.find_err(f"--outputs: .*{says}"), renderer.stderr_text())
    renderer = test.renderer("--frames", "1", "--outputs", "depth", "--raster", "forward")
    renderer.expect_exit(1)
    check(renderer.find_err("--outputs: .*leave --raster forward out"), renderer.stderr_text())


if __name__ == "__main__":
    main({"all": all_outputs, "alone": planes_alone, "views": views, "refusals": refusals}, ["fire3dv"])
