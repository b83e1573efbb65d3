"""End-to-end test of the Python examples by the commands of their READMEs: scene, images on request, correct results.

python_examples_test.py FIRE3DV BULLET_ARM [CASE...]; FIRE3DV_CLIENT_LIBRARY and PYTHONPATH lead to the Python package.
"""
import json
import os
import shlex
import signal
import sys

import numpy

from harness import HANG_S, Program, main, vulkan_environment
from image_reader import check, read_png

EXAMPLES = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../examples"))


def readme(example):
    """Returns the three commands as lists of words: write the scene, draw it, and request images."""
    with open(os.path.join(EXAMPLES, example, "README.md"), encoding="utf-8") as file:
        text = file.read().replace("\\\n", " ")
    lines = [shlex.split(line) for line in text.splitlines() if line.startswith("    ")]
    check(len(lines) == 3 and lines[1][0] == "./fire3dv", f"{example} has other commands: {lines}")
    script = f"../../../examples/{example}/{example}.py"
    check(lines[2][:2] == ["python3", script], f"{example} is run by {lines[2]}")
    return [line[2:] if line[:2] == ["python3", script] else line[1:] for line in lines]


def python(test, example, *arguments):
    script = os.path.join(EXAMPLES, example, f"{example}.py")
    program = Program(test, example, [sys.executable, script, *arguments], dict(os.environ))
    program.expect_exit(0)
    return program


def refuses(test, example, *arguments):
    """An error prints one sentence instead of a Python traceback."""
    script = os.path.join(EXAMPLES, example, f"{example}.py")
    program = Program(test, example, [sys.executable, script, *arguments], dict(os.environ))
    program.expect_exit(2)
    check(f"error: argument {arguments[0]}: '{arguments[1]}'" in program.stderr_text(), program.stderr_text())


def renderer_of(test, words, scene, uri):
    words = [{"shm://demo": uri}.get(word, word) for word in words[1:]]
    renderer = Program(test, "fire3dv", [test.programs_at["fire3dv"], scene, "--validation", "--cache", "off", *words],
                       vulkan_environment())
    renderer.wait_err("listening on")
    return renderer


def stop(renderer):
    renderer.signal(signal.SIGTERM)
    renderer.expect_exit(0)


def rows_of(folder, name):
    picture = read_png(os.path.join(folder, name))
    return numpy.frombuffer(b"".join(picture.rows), numpy.uint8).reshape(picture.height, picture.width, 3)


def mask_of(segmentation):
    """Decodes COCO's uncompressed run lengths: column by column, 0 first."""
    values = numpy.repeat(numpy.arange(len(segmentation["counts"])) % 2, segmentation["counts"])
    return values.reshape(segmentation["size"], order="F")


def dataset(test):
    write, draw, ask = readme("dataset")
    scene, uri = test.path(write[1]), test.fresh_uri("shm")
    refuses(test, "dataset", "--size", "abc")
    python(test, "dataset", write[0], scene)
    renderer = renderer_of(test, draw, scene, uri)
    size, count = (96, 72), 4
    found = []
    for folder in (test.path("first"), test.path("again")):
        words = [{"shm://demo": uri, "dataset": folder, "100": str(count)}.get(word, word) for word in ask]
        python(test, "dataset", *words, "--size", "%dx%d" % size, "--timeout", str(HANG_S))
        with open(os.path.join(folder, "instances.json"), encoding="utf-8") as file:
            found.append(json.load(file))
    check(found[0] == found[1], "the same seed gives other labels")
    first = found[0]
    check([c["name"] for c in first["categories"]] == ["mug", "bottle", "bowl", "banana", "hammer"], f"{first['categories']}")
    check(len(first["images"]) == count and len({a["category_id"] for a in first["annotations"]}) == 5, "labels are missing")
    pictures = []
    for image in first["images"]:
        pictures.append(rows_of(test.path("first"), image["file_name"]))
        check((pictures[-1] == rows_of(test.path("again"), image["file_name"])).all(), "the same seed gives another picture")
        depth = numpy.load(test.path(os.path.join("first", image["depth_file"])))
        check(pictures[-1].shape == (size[1], size[0], 3) and depth.shape == (size[1], size[0]), "images of another size")
        mine = [a for a in first["annotations"] if a["image_id"] == image["id"]]
        check(mine, f"{image['file_name']} shows nothing")
        together = numpy.zeros(depth.shape, int)
        for entry in mine:
            mask = mask_of(entry["segmentation"])
            y, x = numpy.nonzero(mask)
            box = [x.min(), y.min(), x.max() - x.min() + 1, y.max() - y.min() + 1]
            check(entry["bbox"] == box and entry["area"] == mask.sum(), f"{entry['bbox']} is not {box}")
            check(numpy.isfinite(depth[mask == 1]).all() and (depth[mask == 1] < 6).all(), "an object is infinitely far")
            together += mask
        check(together.max() == 1, "two objects share a pixel")
        # An object differs from the floor behind it in colour and in depth.
        edges = (together[:, 1:] != together[:, :-1])
        steps = numpy.abs(numpy.diff(pictures[-1].astype(int), axis=1)).max(axis=2)
        check(steps[edges].mean() > 3 * steps[~edges].mean(), "labels do not lie where colours change")
    check(any((pictures[0] != other).any() for other in pictures[1:]), "all pictures are the same")
    stop(renderer)


def stereo_endoscope(test):
    write, draw, ask = readme("stereo_endoscope")
    scene, uri, folder = test.path(write[1]), test.fresh_uri("tcp"), test.path("stereo")
    refuses(test, "stereo_endoscope", "--center", "1,2")
    python(test, "stereo_endoscope", write[0], scene)
    renderer = renderer_of(test, draw, scene, uri)
    words = [{"shm://demo": uri, "stereo": folder}.get(word, word) for word in ask]
    program = python(test, "stereo_endoscope", *words, "--frames", "3", "--size", "96x72", "--timeout", str(HANG_S))
    check(program.out[-1].endswith("3 pairs, each of one frame"), f"{program.out}")
    pairs = [[rows_of(folder, f"{side}_{frame:03}.png").astype(int) for side in ("left", "right")] for frame in range(3)]
    for left, right in pairs:
        check(left.std() > 5, "nothing is seen")
        corners, middle = left[:6, :6], left[30:42, 42:54]
        check(corners.max() == 0 and middle[..., 0].mean() > 1.3 * middle[..., 2].mean() > 0, "no round view of red tissue")
        check(0 < numpy.abs(left - right).mean() < 30, "left and right are the same, or of two scenes")
    check((pairs[0][0] != pairs[1][0]).any(), "the endoscope does not move")
    camchain = test.path("camchain.yaml")
    camera = "  camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: [-0.1, 0.01, 0.0, 0.0]\n  resolution: [192, 144]\n" \
             "  intrinsics: [150.0, 150.0, 95.5, 71.5]\n"
    with open(camchain, "w", encoding="utf-8") as file:
        file.write(f"cam0:\n{camera}cam1:\n{camera}  T_cn_cnm1:\n  - [1, 0, 0, -0.004]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n")
    own = test.path("own")
    python(test, "stereo_endoscope", *[own if word == folder else word for word in words], "--frames", "1", "--size", "96x72", "--timeout",
           str(HANG_S), "--calibration", camchain)
    check(rows_of(own, "left_000.png")[:6, :6].max() > 0, "a field stop on images of an own calibration")
    with open(os.path.join(folder, "calibration.json"), encoding="utf-8") as file:
        calibration = json.load(file)
    check(calibration["T"][0] < 0 and len(calibration["left"]["D"]) == 4, f"{calibration}")
    stop(renderer)


def environments(test):
    """One array of all environments, each with its own poses, and none that shows its neighbours."""
    os.environ.update(vulkan_environment())
    os.environ["FIRE3DV"] = test.programs_at["fire3dv"]
    refuses(test, "environments", "--size", "abc")
    with open(os.path.join(EXAMPLES, "environments", "README.md"), encoding="utf-8") as file:
        [command] = [shlex.split(line) for line in file.read().splitlines() if line.startswith("    ")]
    check(command[:2] == ["python3", "environments.py"], f"{command}")
    batches = []
    for fxaa in ("off", "on"):
        out = test.path(f"{fxaa}.npy")
        words = [{"64": "5", "100": "3", "batch.npy": out}.get(word, word) for word in command[2:]]
        program = python(test, "environments", *words, "--size", "48x40", "--fxaa", fxaa, "--timeout", str(HANG_S))
        check(program.out[-1].startswith("(5, 40, 48, 3) uint8, "), f"{program.out}")
        check("Warning" not in program.stderr_text(), program.stderr_text())
        batches.append(numpy.load(out))
    for batch in batches:
        blue = (batch[..., 2].astype(int) - batch[..., 0] > 60)
        columns = [numpy.nonzero(image)[1] for image in blue]
        check(all(len(found) > 8 for found in columns), "a cart is missing")
        check(all(found.max() - found.min() < 20 for found in columns), "an image shows the cart of a neighbour")
        check(len({round(found.mean()) for found in columns}) >= 4, "all carts are at one place")
    check((batches[0] != batches[1]).any() and abs(batches[0].astype(int) - batches[1]).mean() < 8, "FXAA changes nothing, or all")


if __name__ == "__main__":
    main({"dataset": dataset, "stereo_endoscope": stereo_endoscope, "environments": environments}, ["fire3dv", "bullet_arm"])
