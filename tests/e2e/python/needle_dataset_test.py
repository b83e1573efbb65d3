"""End-to-end test of examples/needle_dataset by the command of its README: labels against closed forms, and errors of poses.

needle_dataset_test.py FIRE3DV; FIRE3DV_CLIENT_LIBRARY and PYTHONPATH lead to the Python package.
"""
import os
import shlex
import sys

import numpy as np

from harness import Program, check, main, vulkan_environment
from image_reader import read_png

TESTS = os.path.dirname(os.path.abspath(__file__))
EXAMPLE = os.path.normpath(os.path.join(TESTS, "../../../examples/needle_dataset"))
sys.path[:0] = [EXAMPLE, os.path.join(TESTS, "../dataset")]
import bop
import motion
import poses
import train
from label_readers import BopImage, check_bop, pixels_of, read_json
from dataset_runs import lines_of, names_of, tree

SIZE, FRAMES, VIEWS, TISSUES = (160, 120), 2, 3, 3
SMALL = ("--sequences", "1", "--test-sequences", "1", "--frames", FRAMES, "--views", VIEWS, "--tissues", TISSUES, "--size", "%dx%d" % SIZE,
         "--texels", "128", "--cells", "48")
TIP_M = np.array([0.0083, 0, 0])


def make_command():
    """Words of the README's command that makes the data set, without Python and script."""
    with open(os.path.join(EXAMPLE, "README.md"), encoding="utf-8") as file:
        lines = [shlex.split(line) for line in file if line.startswith("    python3 ")]
    check(lines and lines[0][1] == "../../../examples/needle_dataset/make.py", f"the README begins with {lines[:1]}")
    return lines[0][2:]


def script(test, name, *words, code=0):
    program = Program(test, name, [sys.executable, os.path.join(EXAMPLE, name), *map(str, words)], vulkan_environment())
    program.expect_exit(code)
    return program.stderr_text()


def made(test, name, *more):
    folder = test.path(name)
    script(test, "make.py", *[{"needle": folder}.get(word, word) for word in make_command()], "--bin", os.path.dirname(test.programs_at["fire3dv"]),
           *SMALL, *more, "--", "--cache", "off")
    return folder


def expect_tip(folder, sequence):
    """The tip's keypoint is where NumPy projects the tip of the scripted needle through the scripted camera."""
    names, states = names_of(folder), []
    focal = SIZE[1] / 2 / np.tan(np.radians(40) / 2)
    scripted = [sequence.frame(i) for i in range(FRAMES)]
    for line in lines_of(folder):
        at = scripted[line["frame"] // VIEWS]
        tip = at["needle"][:, :3] @ TIP_M + at["needle"][:, 3]
        x, y, z = at[line["camera"]][:, :3].T @ (tip - at[line["camera"]][:, 3])
        wanted = np.array([(SIZE[0] - 1) / 2 + focal * x / -z, (SIZE[1] - 1) / 2 - focal * y / -z])
        (found,) = [each for each in line["keypoints"] if names[each["instance"]] == "needle" and each["name"] == "tip"]
        check(np.abs(np.subtract(found["pixel"], wanted)).max() < 0.01, f"image {line['frame']}: the tip is at {found['pixel']}, not at {wanted}")
        check(abs(found["depth_m"] + z) < 1e-5, f"image {line['frame']}: depth {found['depth_m']} of the tip, not {-z}")
        states.append(found["state"])
        pose = next(each for each in line["instances"] if names[each["instance"]] == "needle")
        point = np.reshape(pose["cam_R_m2c"], (3, 3)) @ (1000 * TIP_M) + pose["cam_t_m2c"]
        check(np.abs(pixels_of(line["cam_K"], point[None])[0] - wanted).max() < 0.01, f"image {line['frame']}: the pose puts the tip elsewhere")
    return states


def expect_labels(folder):
    """The example's reader finds what the files hold."""
    check_bop(folder)
    number = bop.objects(folder)["needle"]
    corner = np.abs(bop.vertices(folder, number)).max(0)
    check(np.allclose(corner, [8.3 + 1.12 * 0.34, 8.3 + 0.34, 1.12 * 0.34], atol=0.02), f"the needle's model reaches to {corner} mm")
    found = bop.labels(folder, number)
    check(len(found) >= FRAMES * VIEWS - 1, f"{len(found)} images show the needle")
    for each in found:
        scene, image = os.path.dirname(os.path.dirname(each["file"])), int(os.path.basename(each["file"])[:6])
        truth = BopImage(scene, image)
        gt = next(i for i, pose in enumerate(truth.poses) if pose["obj_id"] == number)
        mask = truth.mask("mask_visib", gt)
        rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
        check(each["box"] == [columns[0], rows[0], np.ptp(columns) + 1, np.ptp(rows) + 1], f"{each['file']}: {each['box']}")
        check(np.allclose(each["translation"], truth.poses[gt]["cam_t_m2c"]) and np.allclose(each["k"], truth.k), each["file"])
        color = truth.color.astype(int)
        check((bop.read_png(each["file"]) == color).all(), f"{each['file']}: the example reads other pixels")
        check(color.std() > 15 and color[..., 0].mean() > 1.3 * color[..., 2].mean(), f"{each['file']} shows no red tissue")
        if mask.sum() > 20:  # steel is grey, tissue is red
            redness = color[..., 0] - color[..., 2]
            check(redness[mask].mean() < 0.8 * redness.mean(), f"{each['file']}: the needle is not where its mask is")


def expect_training_set(folder):
    """Images of the network, decoded by several processes, in the order of their labels."""
    read, vertices = train.read_set(os.path.join(folder, "train"))
    wanted = bop.labels(os.path.join(folder, "train"), bop.objects(os.path.join(folder, "train"))["needle"], train.LEAST_VISIBLE)
    check(len(read["images"]) == len(wanted) > 0 and len(vertices) > 500, f"{len(read['images'])} images")
    for image, translation, each in zip(read["images"], read["translation"], wanted):
        check((image == bop.read_png(each["file"])).all() and np.allclose(translation, each["translation"]), each["file"])


def example(test):
    script(test, "make.py", "--size", "abc", code=2)
    said = script(test, "record.py", test.path("x.mcap"), "--tissues", "3", "--show", "1-3", code=2)
    check("the scene has the tissues 0 to 2 only" in said, said)
    first, again = made(test, "first"), made(test, "again", "--shards", "2")
    unseen = motion.Sequence(2, 0, range(1, 3), VIEWS)
    states = expect_tip(os.path.join(first, "train"), motion.Sequence(1, 0, range(1), VIEWS)) + expect_tip(os.path.join(first, "test"), unseen)
    check("visible" in states, f"no image shows the tip: {states}")
    for part in ("train", "test"):
        expect_labels(os.path.join(first, part))
        check(names_of(os.path.join(first, part)) == names_of(os.path.join(again, part)), "names")
        images, others = tree(os.path.join(first, part, "train")), tree(os.path.join(again, part, "train"))
        check(set(images) == set(others), f"files: {sorted(set(images) ^ set(others))[:5]}")
        for name in images:  # a colour image names its recording
            if os.path.basename(os.path.dirname(name)) == "rgb":
                rows = [read_png(os.path.join(folder, part, "train", name)).rows for folder in (first, again)]
                check(rows[0] == rows[1], f"{name}: the same seed gives other pixels")
            else:
                check(images[name] == others[name], f"{name}: the same seed gives other bytes")
    said = script(test, "make.py", "--out", first, "--seed", "7", code=1)
    check("is of other options: name another folder" in said, said)
    expect_training_set(first)
    said = script(test, "train.py", test.path("nothing"), code=1)
    check("nothing" in said and "make.py makes the data set" in said, said)
    for folder in (first, again):
        manifest = read_json(os.path.join(folder, "train", "manifest.json"))
        check((manifest["frames"], manifest["cameras"]) == (FRAMES, VIEWS), f"{manifest}")
    with open(os.path.join(first, "needle.glb"), "rb") as one, open(os.path.join(again, "needle.glb"), "rb") as other:
        check(one.read() == other.read(), "the scene has other bytes")


def errors(_):
    """Angle, distance and MSSD of known poses."""
    rotation, shift = motion.turn(np.array([0.6, 0, 0.8]), 1.1), np.array([3.0, -4.0, 90.0])
    for angle in (1e-9, 1e-4, 0.5, 3.0, np.pi):
        turned = rotation @ motion.turn(np.array([0, 0.8, -0.6]), angle)
        check(np.isclose(poses.rotation_error_deg(turned, rotation), np.degrees(angle), rtol=1e-6), f"{angle}")
    check(np.isclose(poses.translation_error(shift + [3, 0, 4], shift), 5), "the distance")
    around = np.linspace(np.pi, 2 * np.pi, 201)
    arc = 8.3 * np.column_stack([np.cos(around), np.sin(around), 0 * around])
    check(np.isclose(poses.mssd(rotation, shift + [0, 2, 0], rotation, shift, arc), 2), "MSSD of a translation")
    about_z, about_x, flip = (motion.turn(np.array(axis), angle) for axis, angle in (((0, 0, 1.0), 0.3), ((1.0, 0, 0), 0.3), ((0, 1.0, 0), np.pi)))
    check(np.isclose(poses.mssd(rotation @ about_z, shift, rotation, shift, arc), 2 * 8.3 * np.sin(0.15)), "MSSD of a turn about the arc's centre")
    check(np.isclose(poses.mssd(rotation @ about_x, shift, rotation, shift, arc), 2 * 8.3 * np.sin(0.15)), "MSSD of a turn about a diameter")
    check(np.isclose(poses.mssd(rotation @ flip, shift, rotation, shift, arc), 2 * 8.3), "MSSD of a needle that is held the other way")
    check(poses.mssd(rotation @ flip, shift, rotation, shift, arc, poses.needle_symmetries()) < 1e-9, "MSSD with symmetries")
    many = [np.repeat(each[None], 5, 0) for each in (rotation, shift)]
    moved = many[1] + np.array([1, 2, 3, 4, 100])[:, None] * [0, 0, 1.0]
    found = {name: (median, mean) for name, _, median, mean in poses.table(many[0], moved, *many, arc)}
    check(np.allclose(found["translation"], (3, 22)) and np.allclose(found["MSSD"], (3, 22)) and np.allclose(found["rotation"], 0), f"{found}")
    found = {name: median for name, _, median, _ in poses.table(many[0] @ flip, many[1], *many, arc)}
    check(np.isclose(found["rotation"], 180) and found["rotation, tip and tail exchangeable"] < 1e-5, f"{found}")


if __name__ == "__main__":
    main({"errors": errors, "example": example}, ["fire3dv"])
