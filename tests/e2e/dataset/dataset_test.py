#!/usr/bin/env python3
"""End-to-end test of `fire3dv dataset`: labels against closed forms, rules of the formats, and the same bytes however it runs."""
import json
import os
import shutil
import signal
import subprocess

import numpy as np

from dataset_runs import DEPTH_UNIT_MM, METRE, RUN, expect_same, join, lines_of, names_of, recording, run, scene_of, start, whole_run
from harness import Program, check, main, vulkan_environment, wait_until
from label_readers import BopImage, box_of, check_bop, decode_rle, pixels_of, points_of, read_color, read_json, read_ply, read_tiff
from label_scene import CENTRES, CUBE_HALF, CUBES, FOCAL_PX, SIZE, SLAB, SPHERE_RADIUS, write_cubes, write_label_scene


def expect_centroid(k, rotation, translation_mm, mask, what):
    """A small sphere's centroid is where its centre is projected to: half a pixel would be an error."""
    centre = rotation @ (np.array(CENTRES["green"]) * METRE) + translation_mm
    wanted = pixels_of(k, centre[None])[0]
    v, u = np.nonzero(mask)
    away = np.array([u.mean(), v.mean()]) - wanted
    check(np.abs(away).max() < 0.25, f"{what}: the sphere's centroid is {away} pixels away")
    return away


def expect_on_cube(k, depth_mm, rotation, translation_mm, mask, centre, what, unit_mm=DEPTH_UNIT_MM):
    """Pixels with their depths lie on the faces of the cube that is put where the pose says."""
    points = (points_of(k, depth_mm)[mask] - translation_mm) @ rotation - np.array(centre) * METRE
    away = np.abs(points).max(1) - CUBE_HALF * METRE
    check(np.abs(away).max() < 4 * unit_mm, f"{what}: {np.abs(away).max():.1f} mm from the cube's faces")


def bop_is_right(test):
    folder = whole_run(test, "bop")
    labels = check_bop(folder)
    lines, names = lines_of(folder), names_of(folder)
    check(labels == sum(len(line["instances"]) for line in lines) > 60, f"{labels} labels")
    check([line["frame"] for line in lines] == list(range(len(lines))) and len(lines) == 2 * 16, f"{len(lines)} images")
    aways = []
    for line in lines:
        scene, number = line["frame"] % 2, line["frame"] // 2
        image = BopImage(os.path.join(folder, "train", f"{scene:06}"), number)
        focal = FOCAL_PX[["front", "side"][scene]]
        check(np.allclose(image.k, [[focal, 0, (SIZE[0] - 1) / 2], [0, focal, (SIZE[1] - 1) / 2], [0, 0, 1]], atol=1e-3), f"K: {image.k}")
        for gt, (pose, each) in enumerate(zip(image.poses, line["instances"])):
            rotation, translation = np.reshape(pose["cam_R_m2c"], (3, 3)), np.array(pose["cam_t_m2c"])
            mask, name = image.mask("mask_visib", gt), names[each["instance"]]
            what = f"image {line['frame']}, {name}"
            if name == "green" and each["visib_fract"] == 1 and not each["truncated"]:
                aways.append(expect_centroid(image.k, rotation, translation, mask, what))
            elif name in ("red", "blue") and mask.any():
                expect_on_cube(image.k, image.depth, rotation, translation, mask, CENTRES[name], what)
    check(len(aways) >= 10 and np.abs(np.mean(aways, 0)).max() < 0.06, f"{len(aways)} spheres, on average {np.mean(aways, 0)} away")
    # World to camera: the scene's camera, in OpenCV's axes.
    camera = lines[0]
    rotation = np.reshape(camera["cam_R_w2c"], (3, 3))
    eye = -rotation.T @ np.array(camera["cam_t_w2c"]) / METRE
    check(np.allclose(eye, (0, 10, 150), atol=1e-4), f"the camera is at {eye}")
    check(np.allclose(rotation[1], [0, -np.cos(0.05), np.sin(0.05)], atol=1e-6), f"down is {rotation[1]}")


def models_have_the_scale_of_their_nodes(test):
    folder = whole_run(test, "bop")
    description = read_json(os.path.join(folder, "dataset.json"))
    slab = next(each for each in description["instances"] if each["name"] == SLAB)
    vertices, _ = read_ply(os.path.join(folder, "models", f"obj_{slab['obj_id']:06}.ply"))
    check(np.allclose(np.ptp(vertices[:, :3], 0), np.array([180, 4, 60]) * METRE, rtol=1e-4), f"the slab: {np.ptp(vertices[:, :3], 0)}")
    check(slab["class"] == 7, f"{slab}")


def odd_names_stay_texts(test):
    folder = whole_run(test, "bop")
    check(not os.path.exists(os.path.join(test.folder, "slab ")), "a node's name became a path")
    page = open(os.path.join(folder, "index.html"), encoding="utf-8").read()
    check("<b>" not in page and "&lt;b&gt;" in page, "a node's name became mark-up")
    check("http://" not in page and "https://" not in page and page.count("data:image/jpeg") == 24, "the page is not self-contained")
    readme = open(os.path.join(folder, "README.md"), encoding="utf-8").read()
    check("fire3dv dataset" in readme and "not stated" in readme and "OpenCV" in readme, readme)


def shards_are_the_whole(test, form="bop"):
    folder = whole_run(test, form)
    parts = [test.path(f"{form} part{i}") for i in (1, 2)]
    for i, part in enumerate(parts, 1):
        run(test, part, "--format", form, *RUN, "--shard", f"{i}/2", *(["--devices", "0,0"] if i == 2 else []))
        check(not os.path.exists(os.path.join(part, "index.html")), "a part claims to be the whole")
    joined = test.path(f"{form} joined")
    join(test, *reversed(parts), "--out", joined)
    expect_same(joined, folder, "joined shards")
    check("name a folder" in join(test, *parts, "--out", test.path("x.mp4"), code=1), "a video of labels")
    said = join(test, parts[0], "--out", test.path("x"), code=1)
    check("render again with --shard 2/2" in said, said)


def a_killed_run_is_gone_on_with(test, form="bop"):
    folder = whole_run(test, form)
    out = test.path(f"{form} killed")
    program = start(test, out, "--format", form, *RUN)
    path = os.path.join(out, "frames.jsonl")
    wait_until(lambda: f"images; it said:\n{program.stderr_text()}",
               lambda: os.path.exists(path) and len(open(path, "rb").read().splitlines()) >= 3 or not program.alive())
    program.signal(signal.SIGKILL)
    program.wait()
    kept = lines_of(out)
    # What a power cut may leave: a listed file of another size.
    with open(os.path.join(out, kept[1]["file"]), "ab") as file:
        file.write(b"x")
    with open(path, "a", encoding="utf-8") as file:
        file.write('{"frame":7,"instances":[')
    said = run(test, out, "--format", form, *RUN)
    check(f"{len(kept) - 1} images are there already" in said, said)
    expect_same(out, folder, "what was gone on with")
    check("all images are there already" in run(test, out, "--format", form, *RUN), "it was drawn again")
    said = run(test, out, "--format", form, *RUN, "--license", "CC0", code=1)
    check("holds frames of another run" in said and "license" in said, said)


def each_recorded_frame_is_drawn(test):
    out = test.path("recorded")
    run(test, out, "--format", "bop", "--start", 0.1, "--end", 0.15)
    lines = lines_of(out)
    arms = [next(each for each in line["streams"] if each["stream"] == "arm")["sim_time_ns"] for line in lines]
    check(arms == [at * 10_000_000 for at in range(11, 17)], f"{arms}")


def a_scene_is_drawn_at_rest(test):
    out = test.path("still")
    run(test, out, "--format", "bop", "--object", "red", "--object", SLAB, "--license", "CC BY 4.0", inputs=[scene_of(test)])
    (line,) = lines_of(out)
    check([each["instance"] for each in line["instances"]] == [1, 4] and line["streams"] == [], f"{line}")
    check(check_bop(out) == 2, "labels")
    check("CC BY 4.0" in open(os.path.join(out, "README.md"), encoding="utf-8").read(), "the licence is missing")


def coco_is_right(test):
    folder = whole_run(test, "coco")
    coco, lines = read_json(os.path.join(folder, "annotations.json")), lines_of(folder)
    check([image["id"] for image in coco["images"]] == list(range(1, len(lines) + 1)), "ids of images")
    check([each["id"] for each in coco["annotations"]] == list(range(1, len(coco["annotations"]) + 1)), "ids of annotations")
    categories = {each["id"]: each for each in coco["categories"]}
    check({number: each["name"] for number, each in categories.items()} == {1: "class 1", 2: "green", 7: SLAB}, f"{categories}")
    check(categories[1]["keypoints"] == ["back corner", "front corner"], f"{categories[1]}")
    seen, aways, covered, names = {"visible": 0, "hidden": 0}, [], 0, names_of(folder)
    for image in coco["images"]:
        k = np.reshape(image["cam_K"], (3, 3))
        colours = read_color(os.path.join(folder, image["file_name"])).astype(int)
        check(colours.shape[:2] == (image["height"], image["width"]), image["file_name"])
        for each in (each for each in coco["annotations"] if each["image_id"] == image["id"]):
            mask = decode_rle(each["segmentation"])
            check(mask.shape == colours.shape[:2] and each["area"] == mask.sum() > 0 and each["bbox"] == box_of(mask), f"{each}")
            rotation, translation, name = np.reshape(each["cam_R_m2c"], (3, 3)), np.array(each["cam_t_m2c"]), names[each["instance"]]
            if name in ("green", "blue"):  # its pixels have its colour
                channel = {"green": 1, "blue": 2}[name]
                others = np.delete(colours[mask], channel, 1).max(1)
                check((colours[mask][:, channel] >= others).mean() > 0.7, f"image {image['id']}, {name}: pixels of another colour")  # edges are smoothed
                covered += mask.sum()
            if name == "red":
                points = np.array([[*np.add(CENTRES["red"][:2], CUBE_HALF), side * CUBE_HALF] for side in (-1, 1)]) * METRE
                wanted = pixels_of(k, points @ rotation.T + translation)
                values = np.reshape(each["keypoints"], (2, 3))
                for (x, y, state), at in zip(values, wanted):
                    inside = -0.5 < at[0] < SIZE[0] - 0.5 and -0.5 < at[1] < SIZE[1] - 0.5
                    check((state > 0) == inside, f"image {image['id']}: {at} has the state {state}")
                    check(not inside or np.allclose((x, y), at, atol=1e-2), f"image {image['id']}: {x}, {y} is not {at}")
                    seen["visible" if state == 2 else "hidden"] += inside
                # From the front the near corner is seen before the far one.
                check(values[1, 2] != 1 or values[0, 2] != 2 or image["camera"] != "front", f"image {image['id']}: {values}")
            if name == "green" and each["visibility"] == 1 and not each["truncated"]:
                aways.append(expect_centroid(k, rotation, translation, mask, f"image {image['id']}"))
    check(min(seen.values()) > 3 and covered > 1000, f"keypoints: {seen}, pixels: {covered}")
    check(len(aways) >= 10 and np.abs(np.mean(aways, 0)).max() < 0.06, f"{len(aways)} spheres, on average {np.mean(aways, 0)} away")


def opencv_reads_coco(test):
    """Boxes from masks by OpenCV are those of the file."""
    try:
        import cv2
    except ImportError:
        print("left out: OpenCV is not installed (Debian: python3-opencv)", flush=True)
        return
    coco = read_json(os.path.join(whole_run(test, "coco"), "annotations.json"))
    for each in coco["annotations"]:
        check(list(cv2.boundingRect(decode_rle(each["segmentation"]).astype(np.uint8))) == each["bbox"], f"{each}")
    image = cv2.imread(os.path.join(whole_run(test, "coco"), coco["images"][0]["file_name"]))
    check(image.shape == (SIZE[1], SIZE[0], 3), f"{image.shape}")


def c3vd_is_right(test):
    """Points of the depth images lie on the bodies, in the world; the scene is small enough for the range of 100 mm."""
    folder, scene = test.path("c3vd"), test.path("small.glb")
    write_label_scene(scene, scale=4e-4)
    run(test, folder, "--format", "c3vd", "--camera", "front", "--camera", "side", inputs=[scene])
    for index, name in enumerate(("front", "side")):
        at = os.path.join(folder, f"{index:02}_{name}")
        check(sorted(os.listdir(at)) == ["0000_depth.tiff", "0000_normals.tiff", "0_color.png", "cam.txt", "pose.txt"], f"{os.listdir(at)}")
        k = np.loadtxt(os.path.join(at, "cam.txt"))
        depth_mm = read_tiff(os.path.join(at, "0000_depth.tiff")) / 65535 * 100
        normals = read_tiff(os.path.join(at, "0000_normals.tiff")) / 65535 * 2 - 1
        world_from_camera = np.loadtxt(os.path.join(at, "pose.txt"), delimiter=",").reshape(4, 4).T
        check(depth_mm.shape == SIZE[::-1] and normals.shape == (*SIZE[::-1], 3), f"{depth_mm.shape}")
        surface = depth_mm < 100
        check(500 < surface.sum() < surface.size and np.allclose(normals[~surface], -1), "surfaces and background")
        points = points_of(k, depth_mm)[surface] @ world_from_camera[:3, :3].T + world_from_camera[:3, 3]
        away = [np.abs(np.abs(points - np.array(CENTRES[cube]) * 0.4).max(1) - CUBE_HALF * 0.4) for cube in ("red", "blue")]
        away.append(np.abs(np.linalg.norm(points - np.array(CENTRES["green"]) * 0.4, axis=1) - SPHERE_RADIUS * 0.4))
        near = np.min(away, 0) < 0.03  # of a ball of flat triangles, too
        slab = points[:, 1] < -9
        check((near | slab).all(), f"{name}: {(~(near | slab)).sum()} of {len(near)} points are on no body")
        world_normals = normals[surface] @ world_from_camera[:3, :3].T
        check(np.allclose(np.linalg.norm(world_normals, axis=1), 1, atol=2e-3), "normals are not of length 1")
        top = slab & (world_normals[:, 1] > 0.5)
        check(top.sum() > 100 and np.allclose(world_normals[top], (0, 1, 0), atol=2e-3), f"{name}: the slab's normal")


def folders_are_right(test):
    folder = test.path("folder")
    run(test, folder, "--format", "folder", inputs=[scene_of(test)])
    at = os.path.join(folder, "00_front")
    labels = read_json(os.path.join(at, "000000.json"))
    depth, instances, classes, normals = (np.load(os.path.join(at, f"000000.{kind}.npy")) for kind in ("depth", "instance", "semantic", "normal"))
    check(depth.shape == instances.shape == classes.shape == normals.shape[:2] == SIZE[::-1], f"{depth.shape}")
    check(np.array_equal(np.isfinite(depth), instances > 0) and set(np.unique(instances)) == {0, 1, 2, 3, 4}, "planes")
    for each in labels["instances"]:
        mask = instances == each["instance"]
        check(np.array_equal(decode_rle({"size": list(mask.shape), "counts": each["counts"]}), mask), f"{each}")
        check((classes[mask] == each["class"]).all(), "classes")
    red = labels["instances"][0]
    expect_on_cube(labels["cam_K"], depth * METRE, np.reshape(red["cam_R_m2c"], (3, 3)), np.array(red["cam_t_m2c"]), instances == 1, CENTRES["red"], "red")
    states = {each["name"]: each["state"] for each in labels["keypoints"]}
    check(states == {"front corner": "visible", "back corner": "hidden", "far away": "outside"}, f"{states}")

    # Points of a side file; wrong ones are refused.
    side, out = test.path("points.json"), test.path("side")
    for content, code, said in (({"blue": {"tip": [0, -16, 9]}}, 0, ""), ({"nope": {"tip": [0, 0, 0]}}, 1, 'no node of the scene has the name or path "nope"'),
                                ({"blue": {"tip": [0, 1]}}, 1, '"tip" is not three numbers')):
        with open(side, "w", encoding="utf-8") as file:
            json.dump(content, file)
        check(said in run(test, out, "--format", "folder", "--keypoints", side, inputs=[scene_of(test)], code=code), f"{content}")
    (line,) = lines_of(out)
    check([each["state"] for each in line["keypoints"] if each["name"] == "tip"] == ["visible"], f"{line['keypoints']}")


def hidden_parts_count(test):
    """Silhouettes are the masks of bodies that are drawn alone: of one behind another, one hidden altogether, one over the border."""
    def run_cubes(form, names):
        scene, folder = test.path(f"{'+'.join(names)}.glb"), test.path(f"{form} of {'+'.join(names)}")
        write_cubes(scene, names)
        run(test, folder, "--format", form, "--camera", "front", inputs=[scene])
        return folder

    def planes(folder):
        at = os.path.join(folder, "00_front", "000000.")
        instances = np.load(at + "instance.npy")
        return {name: instances == number for number, name in names_of(folder).items()}, at

    visible, at = planes(run_cubes("folder", list(CUBES)))
    alone = {"near": visible["near"]}
    for names in (["far", "border"], ["hidden"]):  # none before another
        alone |= planes(run_cubes("folder", names))[0]
    labels = read_json(at + "json")["instances"]
    listed = ["far", "near", "hidden", "border"]
    masks = np.unpackbits(np.load(at + "amodal.npy"), axis=2, count=SIZE[0]).astype(bool)
    bop, coco = run_cubes("bop", list(CUBES)), run_cubes("coco", list(CUBES))
    check(check_bop(bop) == len(labels) == len(masks) == len(listed), f"{len(masks)} masks, {labels}")
    image = BopImage(os.path.join(bop, "train", "000000"), 0)
    annotations = {each["instance"]: each for each in read_json(os.path.join(coco, "annotations.json"))["annotations"]}
    for gt, (name, label, info) in enumerate(zip(listed, labels, image.infos)):
        whole, seen = int(alone[name].sum()), int(visible[name].sum())
        check(label["instance"] == 1 + list(CUBES).index(name), f"{label}")
        check(np.array_equal(masks[gt], alone[name]) and np.array_equal(image.mask("mask", gt), alone[name]), f"{name}: silhouette")
        wanted = {"px_count_all": whole, "px_count_visib": seen, "visib_fract": seen / whole, "bbox_obj": box_of(alone[name]),
                  "bbox_visib": box_of(visible[name]) if seen else [-1] * 4}
        for of in (label, info):
            check({key: of[key] for key in wanted} == wanted, f"{name}: {of} is not {wanted}")
        check(label["truncated"] == (name == "border"), f"{label}")
        if name == "hidden":
            check(seen == 0 and label["instance"] not in annotations, f"{name}: {seen} pixels")
            continue
        each = annotations.pop(label["instance"])
        check((each["amodal_bbox"], each["amodal_area"], each["visibility"], each["area"]) == (wanted["bbox_obj"], whole, seen / whole, seen), f"{each}")
        check((0.2 < each["visibility"] < 0.8) == (name == "far") and each["truncated"] == label["truncated"], f"{each}")
    check(not annotations, f"{annotations}")

    # YOLO: classes 1, 2 and 4 of five are seen, and are numbered from 0.
    yolo = run_cubes("yolo", list(CUBES))
    with open(os.path.join(yolo, "data.yaml"), encoding="utf-8") as file:
        check([f'  {i}: "{name}"' for i, name in enumerate(CUBES)] == file.read().splitlines()[-5:], "data.yaml")
    wanted = []
    for index, name in enumerate(CUBES):
        if name in listed and visible[name].any():
            left, top, width, height = box_of(visible[name])
            wanted.append([index, (left + width / 2) / SIZE[0], (top + height / 2) / SIZE[1], width / SIZE[0], height / SIZE[1]])
    boxes = np.loadtxt(os.path.join(yolo, "labels", "train", "000000.txt"))
    check(boxes.shape == (3, 5) and np.allclose(boxes, wanted, atol=1e-7), f"{boxes} are not {wanted}")
    check(read_color(os.path.join(yolo, "images", "train", "000000.png")).shape[:2] == SIZE[::-1], "the image's size")


def bad_input(test):
    out, scene = test.path("nowhere"), scene_of(test)
    plain = test.path("file")
    open(plain, "w").close()
    file, bag, hdf5 = recording(test), test.path("bag"), test.path("states.hdf5")
    os.mkdir(bag)
    open(os.path.join(bag, "metadata.yaml"), "w").close()
    with open(hdf5, "wb") as states:
        states.write(b"\x89HDF\r\n\x1a\n" + bytes(8))
    for arguments, code, sentence in (
            ([], 2, "name a recording or a scene first"),
            ([scene, "--out", out], 2, "--format: name one of: bop coco yolo c3vd folder hdf5 webdataset"),
            ([scene, "--out", out, "--format", "png"], 2, "--format"),
            ([scene, "--format", "bop"], 2, "--out: name a folder"),
            ([scene, "--format", "bop", "--out", out, "--shard", "2/1"], 2, "--shard 2/1"),
            ([scene, "--format", "bop", "--out", out, "--outputs", "depth"], 2, "--format decides"),
            ([scene, "--format", "bop", "--out", out, "--end", "2"], 2, "--animate"),
            ([scene, "--format", "bop", "--out", out, "--depth-scale", "0"], 2, "--depth-scale"),
            ([scene, "--format", "bop", "--out", out, "--camera", "nope"], 1, "--camera nope"),
            ([scene, "--format", "bop", "--out", out, "--object", "bleu"], 1, '--object: no node has the name or path "bleu"; did you mean "blue"?'),
            ([scene, file, "--format", "bop", "--out", out], 2, f"the recording comes first, then the scene: fire3dv dataset {file} {scene}"),
            ([bag, scene, "--format", "bop", "--out", out], 2, f"{bag} holds states of another program, which fire3dv relabel draws: fire3dv relabel {bag} SCENE"),
            ([hdf5, "--format", "bop", "--out", out], 2, f"fire3dv relabel {hdf5} SCENE"),
            ([scene, "--format", "bop", "--out", "x.mcap"], 2, "a data set is a folder"),
            ([file, scene, "--format", "folder", "--out", out, "--flow-frames", "1", "--devices", "0,0"], 1, "flow and motion compare images of one device"),
            ([test.scene, "--format", "bop", "--out", out], 1, "is orthographic"),
            ([scene, "--format", "bop", "--out", plain + "/x"], 1, "file/x")):
        program = Program(test, "dataset", [test.programs_at["fire3dv"], "dataset", *arguments], vulkan_environment())
        check(program.wait() == code, f"{arguments} ended with {program.process.returncode}:\n{program.stderr_text()}")
        check(sentence in program.stderr_text(), f"{arguments} said:\n{program.stderr_text()}")
        check(not os.path.exists(out), f"{arguments} left a folder")

    disk = test.path("disk")
    os.mkdir(disk)
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "fire3dv-test", disk], capture_output=True).returncode != 0:
        print("left out: a disk that is full, which takes root to make", flush=True)
        return
    try:
        path = os.path.join(disk, "full")
        said = run(test, path, "--format", "bop", *RUN, code=1)
        check("No space left on device; free some" in said, said)
        for line in lines_of(path):
            check(os.path.getsize(os.path.join(path, line["file"])) == line["bytes"][0], f"half an image is listed: {line['file']}")
        shutil.rmtree(path)
    finally:
        subprocess.run(["umount", disk], check=True)


if __name__ == "__main__":
    def all_of(*parts):
        def run_all(test):
            for part in parts:
                part(test)
        return run_all
    # One folder for all comparisons with the reference run, which is drawn once.
    main({"bop": all_of(bop_is_right, models_have_the_scale_of_their_nodes, odd_names_stay_texts, shards_are_the_whole,
                        a_killed_run_is_gone_on_with),
          "coco": all_of(coco_is_right, opencv_reads_coco), "c3vd": c3vd_is_right, "folder": folders_are_right, "hidden": hidden_parts_count,
          "inputs": all_of(each_recorded_frame_is_drawn, a_scene_is_drawn_at_rest), "bad_input": bad_input},
         ("fire3dv", "make"))
