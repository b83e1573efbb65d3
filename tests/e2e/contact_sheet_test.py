#!/usr/bin/env python3
"""End-to-end test of fire3dv-contact-sheet: images, listings and refusals."""
import base64
import json
import os
import shutil
import struct
import subprocess
import zlib

from harness import HANG_S, main, vulkan_environment
from image_reader import check, read_png

PAPER = (24, 24, 24)


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


PNG_OF_A_PIXEL = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)) +
                  chunk(b"IDAT", zlib.compress(b"\0\xff\0\0")) + chunk(b"IEND", b""))


def sheet(test, *arguments):
    return subprocess.run([test.programs_at["fire3dv-contact-sheet"], *arguments], capture_output=True, text=True,
                          timeout=HANG_S, env=vulkan_environment(), check=False)


def collection(test):
    """Writes three scenes, one in a subfolder, an invalid file, and a link out of the folder."""
    folder = test.path("collection")
    os.makedirs(os.path.join(folder, "below"))
    for name in ("a.glb", "b.GLB", os.path.join("below", "c.glb")):
        shutil.copy(test.scene, os.path.join(folder, name))
    with open(os.path.join(folder, "broken.gltf"), "w", encoding="utf-8") as file:
        file.write("{}")
    outside = test.path("outside")
    os.makedirs(outside)
    shutil.copy(test.scene, os.path.join(outside, "not_named.glb"))
    os.symlink(outside, os.path.join(folder, "way_out"))
    return folder


def pages(test):
    out = test.path("pages")
    result = sheet(test, collection(test), "--out", out, "--columns", "2", "--rows", "1", "--width", "80", "--height", "60",
                   "--validation")
    check(result.returncode == 0 and result.stderr == "", f"{result}")
    check(result.stdout.splitlines()[-1] == f"3 drawn, 1 refused; 2 pages and index.txt in {out}", result.stdout)
    check(sorted(os.listdir(out)) == ["index.txt", "page_001.png", "page_002.png"], f"wrote {os.listdir(out)}")
    with open(os.path.join(out, "index.txt"), encoding="utf-8") as file:
        index = file.read().splitlines()
    check(index[:3] == ["page_001.png row 1 column 1: a.glb: 6 triangles", "page_001.png row 1 column 2: b.GLB: 6 triangles",
                        "page_002.png row 1 column 1: below/c.glb: 6 triangles"], f"{index}")
    check(len(index) == 4 and index[3].startswith("refused: broken.gltf: ") and "asset" in index[3], f"{index}")
    first, second = (read_png(os.path.join(out, name)) for name in ("page_001.png", "page_002.png"))
    check((first.width, first.height) == (6 + 2 * 86, 6 + 60 + 32 + 6), f"{first.width} x {first.height}")
    for page, left, there in ((first, 6, True), (first, 92, True), (second, 6, True), (second, 92, False)):
        inside = [page.pixel(x, y) for y in range(6, 66) for x in range(left, left + 80)]
        for channel in range(3):
            seen = any(p[channel] > 150 and all(p[c] < 60 for c in range(3) if c != channel) for p in inside)
            check(seen == there, f"the square of channel {channel} at {left}: {seen}")
        check(there or set(inside) == {PAPER}, "something is drawn where there is no asset")
        label = {page.pixel(x, y) for y in range(68, 78) for x in range(left, left + 80)}
        check((len(label) > 1) == there, f"the label at {left}: {label}")


def too_many_textures(test):
    """A scene with more textures than the renderer holds is refused without further effect."""
    folder = test.path("many")
    os.makedirs(folder)
    with open(test.scene, "rb") as file:
        data = file.read()
    length, = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20:20 + length])
    document["images"] = [{"uri": "data:image/png;base64," + base64.b64encode(PNG_OF_A_PIXEL).decode()}]
    document["textures"] = [{"source": 0}] * 70000
    document["materials"] += [{"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}} for i in range(70000)]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    path = os.path.join(folder, "many.glb")
    with open(path, "wb") as file:
        file.write(struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(data) - 20 - length, len(text), b"JSON"))
        file.write(text + data[20 + length:])
    result = sheet(test, folder, "--out", test.path("pages"))
    check(result.returncode == 0 and result.stdout.startswith(f"refused: {path} has 70000 textures"), f"{result}")


def refusals(test):
    empty = test.path("empty")
    os.makedirs(empty)
    taken = test.path("taken")
    with open(taken, "w", encoding="utf-8") as file:
        file.write("a file")
    assets = collection(test)
    for arguments, code, said in (
            ((test.path("nowhere"),), 1, test.path("nowhere")), ((empty,), 1, "holds no .gltf or .glb files"),
            ((assets, "--out", taken), 1, "--out"), ((assets, "--out", empty, "--device", "none such"), 1, "none such"),
            ((assets, "--out", empty, "--require-gpu"), 3, "--require-gpu"),
            ((), 2, "folder"), ((empty, "--columns", "0"), 2, "--columns"), ((empty, "--width", "9999999"), 2, "--width")):
        result = sheet(test, *arguments)
        check(result.returncode == code and said in result.stdout + result.stderr, f"{arguments}: {result}")


CASES = {"pages": pages, "too_many_textures": too_many_textures, "refusals": refusals}

if __name__ == "__main__":
    main(CASES, ["fire3dv-contact-sheet"])
