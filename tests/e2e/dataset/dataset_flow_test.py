#!/usr/bin/env python3
"""End-to-end test of flow in data sets: against the poses of both images, disparity, and the same bytes however a set is drawn."""
import json
import os
import shutil
import struct

import numpy as np

from dataset_runs import expect_same, join, lines_of, names_of, run
from harness import check, main
from label_readers import pixels_of, points_of, read_json, read_tiff
from label_scene import FOCAL_PX, SIZE, write_label_scene

APART = 2
#: Frames 11 to 21 of the recording, one from each. "green" is hidden from frame 20 on.
SHORT = ("--start", 0.1, "--end", 0.2, "--camera", "front")


class Labels:
    def __init__(self, folder, number):
        at = os.path.join(folder, "00_front", f"{number:06}.")
        self.depth, self.instances = np.load(at + "depth.npy"), np.load(at + "instance.npy")
        self.flow = {to: np.load(f"{at}flow_{to}.npy") for to in ("forward", "backward")}
        self.occlusion = {to: np.load(f"{at}occlusion_{to}.npy") for to in ("forward", "backward")}
        self.json = read_json(at + "json")

    def pose(self, instance):
        each = next((each for each in self.json["instances"] if each["instance"] == instance), None)
        return each and (np.reshape(each["cam_R_m2c"], (3, 3)), np.array(each["cam_t_m2c"]) / 1000)


def short_set(test):
    folder = os.path.join(test.folder, "flow")
    if not os.path.exists(folder):
        run(test, folder, "--format", "folder", "--flow-frames", APART, *SHORT)
    return folder


def flow_follows_the_poses(test):
    folder = short_set(test)
    images = [Labels(folder, number) for number in range(len(lines_of(folder)))]
    names = names_of(folder)
    v, u = np.mgrid[:SIZE[1], :SIZE[0]]
    moved, hidden, compared, others = 0, 0, 0, 0
    for number, image in enumerate(images):
        check(image.flow["forward"].shape == (*SIZE[::-1], 2) and image.occlusion["forward"].dtype == np.uint8, "shapes")
        for to, other in (("forward", number + APART), ("backward", number - APART)):
            flow, occlusion = image.flow[to], image.occlusion[to]
            what = f"image {number} {to}"
            if not 0 <= other < len(images):
                check(np.isnan(flow).all() and (occlusion == 2).all(), f"{what}: there is no image")
                continue
            other = images[other]
            background = image.instances == 0
            check((flow[background] == 0).all() and (occlusion[background] == 0).all(), f"{what}: the background")
            for instance in np.unique(image.instances[~background]):
                mask, then = image.instances == instance, other.pose(instance)
                rotation, translation = image.pose(instance)
                if then is None and names[instance] == "green":
                    check(np.isnan(flow[mask]).all() and (occlusion[mask] == 1).all(), f"{what}: a hidden node")
                    hidden += mask.sum()
                    continue
                points = (points_of(image.json["cam_K"], image.depth)[mask] - translation) @ rotation
                pixels = pixels_of(np.reshape(image.json["cam_K"], (3, 3)), points @ then[0].T + then[1])
                wanted = pixels - np.stack([u[mask], v[mask]], 1)
                away = np.abs(wanted - flow[mask]).max()
                check(away < 0.01, f"{what}, {names[instance]}: flow is {away} pixels wrong")
                moved += (np.abs(wanted).max(1) > 0.2).sum()
                # What is said to be seen there, is seen there: but at edges.
                x, y = np.rint(pixels).astype(int).T
                inside = (x >= 0) & (y >= 0) & (x < SIZE[0]) & (y < SIZE[1])
                check((occlusion[mask][~inside] == 2).all(), f"{what}: outside")
                seen = occlusion[mask][inside] == 0
                same = other.instances[y[inside], x[inside]] == instance
                others += (~same[seen]).sum()
                compared += seen.sum()
    check(others < 0.02 * compared, f"{others} of {compared} pixels show another body")
    check(moved > 2000 and hidden > 5 and compared > 10000, f"{moved} pixels moved, {hidden} hidden, {compared} compared")


def parts_are_the_whole(test):
    """Shards and continued runs draw the images before and after theirs; the scene changes within the recording."""
    arguments = ("--format", "folder", "--flow-frames", 1, "--rate", 20, "--camera", "front", "--camera", "side")
    folder = test.path("whole")
    run(test, folder, *arguments)
    parts = [test.path(f"part{i}") for i in (1, 2, 3)]
    for i, part in enumerate(parts, 1):
        run(test, part, *arguments, "--shard", f"{i}/3")
    joined = test.path("joined")
    join(test, *parts, "--out", joined)
    expect_same(joined, folder, "joined shards")

    out = test.path("continued")
    shutil.copytree(folder, out)
    path = os.path.join(out, "frames.jsonl")
    with open(path, encoding="utf-8") as file:
        kept = [line for number, line in enumerate(file) if number % 7 != 3]
    with open(path, "w", encoding="utf-8") as file:
        file.writelines(kept)
    said = run(test, out, *arguments)
    check(f"{len(kept)} images are there already" in said, said)
    expect_same(out, folder, "a continued run")


def c3vd_has_flow(test):
    folder, labels = test.path("c3vd"), short_set(test)
    run(test, folder, "--format", "c3vd", "--flow-frames", APART, *SHORT)
    at = os.path.join(folder, "00_front")
    numbers = range(len(lines_of(folder)))
    check([os.path.exists(os.path.join(at, f"{number:04}_flow.tiff")) for number in numbers] == [number >= APART for number in numbers], "files")
    for number in numbers[APART:]:
        units = read_tiff(os.path.join(at, f"{number:04}_flow.tiff"))
        image = Labels(labels, number)
        shown = (image.occlusion["backward"] == 0) & (image.instances > 0)
        check((units[~shown] == 0).all() and (units[..., 2] == 0).all(), f"image {number}: no flow is 0")
        flow = units[shown][:, :2] / 65535 * 40 - 20
        check(shown.any() and np.abs(flow - np.clip(image.flow["backward"][shown], -20, 20)).max() < 1e-3, f"image {number}: flow")
    readme = open(os.path.join(folder, "README.md"), encoding="utf-8").read()
    check("flow.tiff" in readme and "2 frames earlier" in readme, readme)


def add_cameras(path, more):
    """Adds cameras to a glb, which are like "front": name, and how far they are displaced in its axes."""
    with open(path, "rb") as file:
        data = file.read()
    (length,) = struct.unpack_from("<I", data, 12)
    document, rest = json.loads(data[20:20 + length]), data[20 + length:]
    front = next(node for node in document["nodes"] if node["name"] == "front")
    x, _, _, w = front["rotation"]
    down = 2 * np.arctan2(x, w)
    for name, (dx, dy, dz) in more:
        offset = [dx, dy * np.cos(down) - dz * np.sin(down), dy * np.sin(down) + dz * np.cos(down)]
        node = {**front, "name": name, "translation": np.add(front["translation"], offset).tolist()}
        document["nodes"].append(node)
        document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), b"JSON") + text + rest)


def stereo_pairs_have_disparity(test):
    """Disparity is fx * baseline / depth, and takes each pixel to the same body in the other image."""
    scene, folder, baseline = test.path("stereo.glb"), test.path("stereo"), 6.0
    write_label_scene(scene)
    add_cameras(scene, [("right", (baseline, 0, 0)), ("above", (0, 5, 0)), ("behind", (0, 0, 5))])
    run(test, folder, "--format", "folder", "--camera", "front", "--camera", "right", "--stereo-pairs", inputs=[scene])
    images = []
    for at in ("00_front", "01_right"):
        at = os.path.join(folder, at, "000000.")
        images.append([np.load(at + f"{kind}.npy") for kind in ("depth", "instance", "disparity")])
        check(abs(read_json(at + "json")["baseline_m"] - baseline) < 1e-4, "the baseline")
    for sign, (depth, instances, disparity), (other_depth, others, _) in ((-1, *images), (1, *reversed(images))):
        surface = instances > 0
        wanted = FOCAL_PX["front"] * baseline / depth[surface]
        check((disparity[~surface] == 0).all() and np.abs(disparity[surface] - wanted).max() < 1e-4 and np.ptp(wanted) > 1, "disparity")
        v, u = np.nonzero(surface)
        x = np.rint(u + sign * disparity[surface]).astype(int)
        inside = (x >= 0) & (x < SIZE[0])
        v, u, x = v[inside], u[inside], x[inside]
        same = np.abs(other_depth[v, x] - depth[v, u]) < 0.02 * depth[v, u]
        check(same.mean() > 0.9, f"{(~same).sum()} of {same.size} pixels are of another surface")
    for cameras, code, wanted in ((("front", "above"), 1, "they are not side by side"), (("front", "side"), 1, "their intrinsics differ"),
                                  (("right", "front"), 1, "name the left one first"), (("front",), 2, "name the cameras of each pair")):
        names = [word for name in cameras for word in ("--camera", name)]
        said = run(test, test.path("+".join(cameras)), "--format", "folder", "--stereo-pairs", *names, inputs=[scene], code=code)
        check(wanted in said, said)


def bad_input(test):
    for arguments, code, wanted in ((("--format", "coco", "--flow-frames", 1), 2, "the format coco has no files for flow"),
                                    (("--format", "folder", "--flow-frames", 1001), 2, "--flow-frames must be from 0 to 1000"),
                                    (("--format", "folder", "--flow-frames", 1000, *SHORT), 1, "at most 256: choose a smaller --size")):
        said = run(test, test.path("bad"), *arguments, code=code)
        check(wanted in said, said)


if __name__ == "__main__":
    def flow_and_c3vd(test):
        flow_follows_the_poses(test)
        c3vd_has_flow(test)
    main({"flow": flow_and_c3vd, "parts": parts_are_the_whole, "stereo": stereo_pairs_have_disparity,
          "bad_input": bad_input}, ("fire3dv", "make"))
