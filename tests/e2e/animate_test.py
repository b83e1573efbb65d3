#!/usr/bin/env python3
"""End-to-end test of --animate: time advances per image without a stream, follows simulated time with one, and never goes
back.
"""
import json
import struct

from harness import main, shown
from image_reader import check, expect_square, place_of

IMAGES_PER_SECOND = 30
FIRST_PLACE, LAST_PLACE, DURATION_S = -60.0, 60.0, 1.0
SIM_STEP_S = 0.01


def place_at(time_s):
    return FIRST_PLACE + (LAST_PLACE - FIRST_PLACE) * (time_s % DURATION_S) / DURATION_S


def sliding_scene(test):
    """Writes the tests' scene with an animation "slide" of the red and the blue square."""
    with open(test.scene, "rb") as file:
        data = file.read()
    length, = struct.unpack_from("<I", data, 12)
    document, binary = json.loads(data[20:20 + length]), data[28 + length:]
    for values, kind in (((0, DURATION_S), "SCALAR"), ((FIRST_PLACE, 0, 0, LAST_PLACE, 0, 0), "VEC3")):
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": 4 * len(values)})
        document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": 5126, "count": 2,
                                      "type": kind})
        binary += struct.pack(f"<{len(values)}f", *values)
    names = [node["name"] for node in document["nodes"]]
    output = len(document["accessors"]) - 1
    document["animations"] = [{"name": "slide", "samplers": [{"input": output - 1, "output": output}],
                               "channels": [{"sampler": 0, "target": {"node": names.index(name), "path": "translation"}}
                                            for name in ("red", "blue")]}]
    document["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    path = test.path("sliding.glb")
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)
    return path


def by_images(test):
    scene = sliding_scene(test)
    rows = []
    for arguments in (["--animate", "slide"], ["--animate"]):
        renderer = test.renderer("--frames", "32", *arguments, scene=scene)
        renderer.wait_err(r"^fire3dv: info: playing animation \"slide\", of 1$")
        renderer.expect_exit(0)
        pictures = [renderer.picture(frame) for frame in renderer.frames()]
        check(len(pictures) == 32, f"{len(pictures)} images")
        for i in (1, 10, 29, 31):  # the last one is in the second loop
            for square in ("red", "blue"):
                expect_square(pictures[i], square, place_at(i / IMAGES_PER_SECOND), f"image {i}")
        expect_square(pictures[10], "green", 66.0, "what is not animated")
        rows.append([picture.rows for picture in pictures])
    check(rows[0] == rows[1], "two runs differ")


def by_simulated_time(test):
    uri = test.fresh_uri("shm")
    renderer = test.renderer("--animate", "0", "--lockstep", "--exit-when-done", listen=[uri], scene=sliding_scene(test))
    publisher = test.publisher(uri)
    publisher.do("lockstep 12")
    publisher.quit()
    renderer.expect_exit(0)
    drawn = [frame for frame in renderer.frames() if frame["streams"]]
    check(len(drawn) == 12, f"{len(drawn)} images")
    for frame in drawn:
        sequence = shown(frame, "arm")["sequence"]
        picture = renderer.picture(frame)
        expect_square(picture, "red", place_of(sequence), f"what the stream drives, in {frame['file']}")
        expect_square(picture, "blue", place_at(sequence * SIM_STEP_S), f"what it does not drive, in {frame['file']}")


if __name__ == "__main__":
    main({"by_images": by_images, "by_simulated_time": by_simulated_time}, ["fire3dv", "publisher"])
