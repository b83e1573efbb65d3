#!/usr/bin/env python3
"""End-to-end test of `fire3dv dataset`: inputs that lie elsewhere, odd texts, cameras and keypoints."""
import json
import os
import shutil

import numpy as np

from dataset_runs import RUN, expect_same, join, lines_of, recording, run, scene_of, whole_run
from harness import Program, check, main, vulkan_environment
from label_readers import decode_rle, read_json
from label_scene import cube, write_bodies, write_label_scene


def moved_inputs(test, name):
    """The same recording and scene in another folder."""
    folder = test.path(name)
    os.mkdir(folder)
    return [shutil.copy(path, folder) for path in (recording(test), scene_of(test))]


def parts_of_other_machines_join(test):
    """Paths of inputs, devices and caches differ; bytes do not."""
    whole = whole_run(test, "coco")
    parts = [test.path(f"moved part{i}") for i in (1, 2)]
    run(test, parts[0], "--format", "coco", *RUN, "--shard", "1/2", inputs=moved_inputs(test, "elsewhere"))
    run(test, parts[1], "--format", "coco", *RUN, "--shard", "2/2", "--async-compute", "off", "--headless")
    joined = test.path("moved joined")
    join(test, *parts, "--out", joined)
    expect_same(joined, whole, "parts of other machines")
    command = read_json(os.path.join(whole, "dataset.json"))["command"]
    check(command.startswith("fire3dv dataset made.mcap labels.glb --tone-map none"), command)
    check(test.folder not in command and "--cache" not in command, command)

    # A folder of others is not joined into.
    foreign = test.path("foreign")
    os.mkdir(foreign)
    with open(os.path.join(foreign, "letter.txt"), "w", encoding="utf-8") as file:
        file.write("mine")
    said = join(test, *parts, "--out", foreign, code=1)
    check("is not empty" in said and os.listdir(foreign) == ["letter.txt"], said)

    # The same run goes on with moved inputs.
    said = run(test, joined, "--format", "coco", *RUN, inputs=moved_inputs(test, "moved once more"))
    check("all images are there already" in said, said)


def texts_are_printable(test):
    """A licence that is not UTF-8, and an alpha limit that the README states."""
    out = test.path("texts")
    run(test, out, "--format", "coco", "--license", "caf\udce9", "--label-alpha", "0.7", inputs=[scene_of(test)])
    (licence,) = read_json(os.path.join(out, "annotations.json"))["licenses"]
    check(licence["name"] == "caf?" == read_json(os.path.join(out, "dataset.json"))["license"], f"{licence}")
    readme = open(os.path.join(out, "README.md"), encoding="utf-8").read()
    check("more alpha than 0.7 (" in readme and "Licence: caf?" in readme, readme)


def the_first_camera_is_named(test):
    """A scene with a default view begins with it, and not with its first camera."""
    scene = test.path("view.glb")
    write_label_scene(scene, scene_extras={"viewFrom": [0, 0, 1]})
    out = test.path("view")
    run(test, out, "--format", "coco", inputs=[scene])
    check(read_json(os.path.join(out, "dataset.json"))["cameras"] == ["auto"], "the title")
    check(lines_of(out)[0]["camera"] == "auto", f"{lines_of(out)[0]['camera']}")




def overlay_cameras_are_checked(test):
    """A camera that the overlay file adds is known once the scene has it."""
    overlay = test.path("overlay.json")
    for camera, code, said in (({"half_extent": [80, 45], "near": 1, "far": 500}, 1, 'camera "view" is orthographic'),
                               ({"vertical_fov": 0.6, "near": 1}, 0, "1 image drawn")):
        with open(overlay, "w", encoding="utf-8") as file:
            json.dump({"fire3dv_overlay": {"version": 2, "scene": "labels.glb",
                                           "edits": [{"add": "view", "camera": camera, "translation": [0, 0, 150],
                                                      "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}]}}, file)
        out = test.path(f"overlay {code}")
        text = run(test, out, "--format", "coco", "--overlay", overlay, "--camera", "view", inputs=[scene_of(test)], code=code)
        check(said in text, text)
    check(read_json(os.path.join(out, "dataset.json"))["cameras"] == ["view"], "the title")


def twins_have_their_own_keypoints(test):
    """Two nodes of one name: each has the points of its own extras."""
    scene, out = test.path("twins.glb"), test.path("twins")
    bodies = [("twin", cube((x, 0, 0), 5), [0.7, 0.7, 0.7], 1, {"extras": {"semantic": 1, "keypoints": points}})
              for x, points in ((-20, {"tip": [-20, 0, 5]}), (20, {"tip": [20, 0, 5], "top": [20, 5, 5]}), (60, {}))]
    write_bodies(scene, bodies)
    run(test, out, "--format", "coco", "--camera", "front", inputs=[scene])
    points = {(each["instance"], each["name"]): each["pixel"] for each in lines_of(out)[0]["keypoints"]}
    check(set(points) == {(1, "tip"), (2, "tip"), (2, "top")} and len(lines_of(out)[0]["keypoints"]) == 3, f"{points}")
    coco = read_json(os.path.join(out, "annotations.json"))
    check(coco["categories"][0]["keypoints"] == ["tip", "top"], f"{coco['categories']}")
    for each in coco["annotations"]:
        values = np.reshape(each["keypoints"], (2, 3))
        wanted = {1: 1, 2: 2, 3: 0}[each["instance"]]
        check(each["num_keypoints"] == np.count_nonzero(values[:, 2]) == wanted, f"{each}")
        if wanted:  # in the middle of its own cube
            columns = np.flatnonzero(decode_rle(each["segmentation"]).any(0))
            check(abs(values[0, 0] - columns.mean()) < 3, f"{values} is not in {columns}")

    # A side file replaces points of the same node and name.
    side = test.path("side.json")
    with open(side, "w", encoding="utf-8") as file:
        json.dump({"twin": {"tip": [0, 5, 5]}}, file)
    out = test.path("side")
    run(test, out, "--format", "coco", "--keypoints", side, "--camera", "front", inputs=[scene])
    names = sorted((each["instance"], each["name"]) for each in lines_of(out)[0]["keypoints"])
    check(names == [(1, "tip"), (2, "tip"), (2, "top"), (3, "tip")], f"{names}")


def words_without_effect(test):
    said = run(test, test.path("scale"), "--format", "yolo", inputs=[scene_of(test)])
    check("warning: --depth-scale has no effect: the format yolo has no depth images with a scale" in said, said)
    program = Program(test, "dataset", [test.programs_at["fire3dv"], "dataset", "", "--format", "bop", "--out", test.path("empty")],
                      vulkan_environment())
    check(program.wait() == 2 and "name a recording or a scene first" in program.stderr_text(), program.stderr_text())


if __name__ == "__main__":
    main({"machines": parts_of_other_machines_join, "texts": texts_are_printable, "camera": the_first_camera_is_named,
          "overlay": overlay_cameras_are_checked,
          "keypoints": twins_have_their_own_keypoints, "words": words_without_effect}, ("fire3dv", "make"))
