#!/usr/bin/env python3
"""End-to-end test of `fire3dv dataset`: HDF5 files, tar archives and LeRobot data sets, opened by h5py, Python's tarfile, a reader
of Parquet and ffmpeg."""
import fcntl
import io
import json
import os
import tarfile

import numpy as np

from dataset_runs import DEPTH_UNIT_MM, METRE, command_of, expect_same, join, lines_of, names_of, run, scene_of
from dataset_test import expect_on_cube
from harness import Program, check, main, vulkan_environment
from label_readers import decode_rle, pixels_of, read_color, read_gray
from label_scene import CENTRES, CUBE_HALF, SIZE
from lerobot_checks import lerobot_is_right

SHORT = ("--rate", 20, "--end", 0.15, "--camera", "front", "--camera", "side")  # eight images


def shards_are_the_whole(test, form, *arguments):
    whole = test.path(f"{form} whole")
    run(test, whole, "--format", form, *SHORT, *arguments)
    parts = [test.path(f"{form} part{i}") for i in (1, 2)]
    for i, part in enumerate(parts, 1):
        run(test, part, "--format", form, *SHORT, *arguments, "--shard", f"{i}/2")
    joined = test.path(f"{form} joined")
    join(test, *parts, "--out", joined)
    expect_same(joined, whole, "joined shards")
    check("all images are there already" in run(test, whole, "--format", form, *SHORT, *arguments), "it was drawn again")
    expect_same(joined, whole, "a run with nothing to draw")
    return whole


def expect_corner(k, world_from_camera, pixel, what):
    """The red cube's front corner is a keypoint: its pixel is where the camera sees that point of the world."""
    corner = np.add(CENTRES["red"], CUBE_HALF)
    at = np.linalg.inv(world_from_camera) @ [*corner, 1]
    check(np.allclose(pixels_of(k, at[None, :3])[0], pixel, atol=1e-3), f"{what}: {pixel}")


def hdf5_is_right(test):
    try:
        import h5py
    except ImportError:
        print("left out: h5py is not installed (Debian: python3-h5py)", flush=True)
        return
    still, plain = test.path("hdf5"), test.path("plain")
    for form, folder in (("hdf5", still), ("folder", plain)):
        run(test, folder, "--format", form, "--license", "CC0", inputs=[scene_of(test)])
    line, = lines_of(still)
    names = names_of(still)
    with h5py.File(os.path.join(still, "images", "000000.hdf5")) as file:
        check(file.attrs["camera"] == "front" and file.attrs["license"] == "CC0", f"{dict(file.attrs)}")
        arrays = {name: file[name][()] for name in ("colors", "depth", "instance", "semantic", "normals", "cam_K", "world_from_camera")}
        check(arrays["depth"].dtype == np.float32 and arrays["normals"].dtype == np.float16, "types")
        at = os.path.join(plain, "00_front", "000000")
        check(np.array_equal(arrays["colors"], read_color(at + ".png")), "colors")
        for name in ("depth", "instance", "semantic"):
            check(np.array_equal(arrays[name], np.load(f"{at}.{name}.npy")), name)
        check(np.array_equal(arrays["normals"], np.load(at + ".normal.npy")[..., :3]), "normals")
        instances = {name: values[()] for name, values in file["instances"].items()}
        for i, each in enumerate(line["instances"]):
            pose = instances["camera_from_model"][i]
            check(np.allclose(pose[:3, :3].ravel(), each["cam_R_m2c"]) and np.allclose(pose[:3, 3] * METRE, each["cam_t_m2c"]), f"{pose}")
            for name in ("instance", "obj_id", "class", "bbox_visib", "bbox_obj", "px_count_visib", "px_count_all", "visib_fract", "truncated"):
                check(np.array_equal(instances[name][i], each[name]), f"{name}: {instances[name][i]}")
            name = names[each["instance"]]
            if name in ("red", "blue"):
                expect_on_cube(arrays["cam_K"], arrays["depth"] * METRE, pose[:3, :3], pose[:3, 3] * METRE,
                               arrays["instance"] == each["instance"], CENTRES[name], name)
        points = [each["name"] for each in line["keypoints"]]
        corner = points.index("front corner")
        check(file["keypoints/state"][corner] == 2 and file["keypoints/state"][points.index("back corner")] == 1, "states")
        expect_corner(arrays["cam_K"], arrays["world_from_camera"], file["keypoints/pixel"][corner], "hdf5")

    with open(os.path.join(still, "images", "000000.hdf5"), "rb") as image:
        fcntl.flock(image, fcntl.LOCK_EX)  # the HDF5 library would refuse it, as on file systems without locks
        join(test, still, "--out", test.path("joined locked"))
    links_of_a_part_are_refused(test, h5py, still)
    whole = shards_are_the_whole(test, "hdf5")
    with h5py.File(os.path.join(whole, "data.hdf5")) as data:
        check(sorted(data) == ["00_front", "01_side"] and data["00_front/depth"].attrs["unit"].startswith("m "), f"{sorted(data)}")
        for camera, group in enumerate(data.values()):
            check(group["colors"].shape == (4, SIZE[1], SIZE[0], 3), f"{group['colors'].shape}")
            for i in range(4):
                with h5py.File(os.path.join(whole, "images", f"{2 * i + camera:06}.hdf5")) as image:
                    for name in ("colors", "depth", "instance", "semantic", "normals", "cam_K", "world_from_camera"):
                        check(np.array_equal(group[name][i], image[name][()]), f"{name} of image {i}")
    # A file that cannot be opened, as beyond the limit of open files, is told from an image of the background.
    os.rename(os.path.join(whole, "images", "000002.hdf5"), test.path("away.hdf5"))
    with h5py.File(os.path.join(whole, "data.hdf5")) as data:
        group = data["00_front"]
        for name in ("depth", "normals", "cam_K", "world_from_camera"):
            check(np.isnan(group[name][1]).all() and not np.isnan(group[name][2]).any(), f"{name} of a missing image")
        for name in ("instance", "semantic"):
            check((group[name][1] == 4294967295).all(), f"{name} of a missing image")
    with open(os.path.join(whole, "README.md"), encoding="utf-8") as readme:
        check("`ulimit -n`" in readme.read(), "README.md says nothing of the limit")


def links_of_a_part_are_refused(test, h5py, still):
    """A part may come from others: values in other files are not read for the page."""
    image = os.path.join(still, "images", "000000.hdf5")
    size, secret = os.path.getsize(image), test.path("secret.hdf5")
    os.rename(image, secret)
    for kind in ("link", "virtual"):
        with h5py.File(image, "w") as file:
            if kind == "link":
                file["colors"] = h5py.ExternalLink(secret, "/colors")
            else:
                layout = h5py.VirtualLayout((SIZE[1], SIZE[0], 3), np.uint8)
                layout[:] = h5py.VirtualSource(secret, "colors", (SIZE[1], SIZE[0], 3))
                file.create_virtual_dataset("colors", layout)
        with open(image, "ab") as file:  # the size that the list says
            file.truncate(size)
        with h5py.File(image) as file:
            check(file["colors"].shape == (SIZE[1], SIZE[0], 3), kind)
        said = join(test, still, "--out", test.path(f"joined {kind}"), code=1)
        check("000000.hdf5 has no array /colors of" in said, said)
        os.remove(image)


def slurm_tasks_draw_parts(test):
    """The scripts of examples/slurm, as Slurm runs each task."""
    whole, out, joined = test.path("slurm whole"), test.path("tasks"), test.path("slurm joined")
    run(test, whole, "--format", "coco", *SHORT)
    scripts = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "examples", "slurm")
    os.mkdir(out)
    for task in (1, 2):
        environment = vulkan_environment() | {"FIRE3DV": test.programs_at["fire3dv"], "FIRE3DV_COMMAND": "dataset",
                                              "SLURM_ARRAY_TASK_ID": str(task), "SLURM_ARRAY_TASK_COUNT": "2"}
        words = list(map(str, command_of(test, "OUT", "--format", "coco", *SHORT)))[2:]
        at = words.index("--out")
        program = Program(test, "task", ["bash", os.path.join(scripts, "render.sbatch"), *words[:at], out, *words[at + 2:]], environment)
        program.expect_exit()
    program = Program(test, "join", ["bash", os.path.join(scripts, "join.sbatch"), out, joined], environment)
    program.expect_exit()
    expect_same(joined, whole, "parts of Slurm's tasks")


def samples_of(path):
    """Samples of an archive: contents by extension, by key, in order; as WebDataset groups them."""
    samples = {}
    with tarfile.open(path, "r:") as tar:
        for member in tar:
            check(member.isreg() and (member.uid, member.gid, member.mtime, member.mode) == (0, 0, 0, 0o644), f"{member}")
            key, extension = member.name.split(".", 1)
            check(key in samples or extension == "png", f"{member.name} is away from its sample")
            samples.setdefault(key, {})[extension] = tar.extractfile(member).read()
    return samples


def webdataset_is_right(test):
    whole = shards_are_the_whole(test, "webdataset", "--tar-size", 0.1)
    check(not os.path.exists(os.path.join(whole, "images")), "files of images stay")
    with open(os.path.join(whole, "shards.json"), encoding="utf-8") as file:
        shards = json.load(file)
    check(len(shards) >= 2 and sum(each["images"] for each in shards) == 8, f"{shards}")
    lines = lines_of(whole)
    samples = {}
    for each in shards:
        path = os.path.join(whole, each["name"])
        check(os.path.getsize(path) == each["bytes"] <= 100_000, f"{each}")
        samples |= samples_of(path)
    check(list(samples) == [f"{i:06}" for i in range(8)], f"{list(samples)}")
    loose = test.path("loose.png")

    def decode(reader, data):
        with open(loose, "wb") as file:
            file.write(data)
        return reader(loose)

    for line, sample in zip(lines, samples.values()):
        check(list(sample) == ["png", "depth.png", "instance.png", "json"], f"{list(sample)}")
        labels = json.load(io.BytesIO(sample["json"]))
        check(decode(read_color, sample["png"]).shape == (SIZE[1], SIZE[0], 3), "colours")
        depth = decode(read_gray, sample["depth.png"]) * labels["depth_scale"]
        indices = decode(read_gray, sample["instance.png"])
        check(labels["depth_scale"] == DEPTH_UNIT_MM and labels["instances"] == line["instances"], f"{labels}")
        check(labels["camera"] == ("front", "side")[line["frame"] % 2] and labels["frame"] == line["frame"] // 2, f"{labels}")
        for i, each in enumerate(labels["instances"]):
            mask = indices == i + 1
            check(np.array_equal(mask, decode_rle({"size": list(mask.shape), "counts": each["counts"]})), f"{each}")
            name = names_of(whole)[each["instance"]]
            if name in ("red", "blue") and mask.any():
                expect_on_cube(labels["cam_K"], depth, np.reshape(each["cam_R_m2c"], (3, 3)), np.array(each["cam_t_m2c"]), mask,
                               CENTRES[name], name)

    # A known point, of the scene at rest.
    still = test.path("still")
    run(test, still, "--format", "webdataset", inputs=[scene_of(test)])
    labels = json.loads(samples_of(os.path.join(still, "shard-000000.tar"))["000000"]["json"])
    camera_from_world = np.eye(4)
    camera_from_world[:3] = np.c_[np.reshape(labels["cam_R_w2c"], (3, 3)), np.array(labels["cam_t_w2c"]) / METRE]
    (corner,) = [each for each in labels["keypoints"] if each["name"] == "front corner"]
    expect_corner(labels["cam_K"], np.linalg.inv(camera_from_world), corner["pixel"], "webdataset")

    # Archives of another size are archives of another set, and a finished one is no part.
    said = run(test, still, "--format", "webdataset", "--tar-size", 2, inputs=[scene_of(test)], code=1)
    check("holds frames of another run" in said, said)
    said = join(test, still, "--out", test.path("joined"), code=1)
    check("is a finished data set" in said, said)
    os.remove(os.path.join(still, "shard-000000.tar"))  # then it is drawn again
    check("1 image drawn" in run(test, still, "--format", "webdataset", inputs=[scene_of(test)]), "it was not drawn again")
    check(len(samples_of(os.path.join(still, "shard-000000.tar"))) == 1, "the sample")
    said = run(test, test.path("none"), "--format", "coco", "--tar-size", 2, inputs=[scene_of(test)], code=2)
    check("--tar-size is for --format webdataset" in said, said)


if __name__ == "__main__":
    main({"hdf5": hdf5_is_right, "webdataset": webdataset_is_right, "lerobot": lambda test: lerobot_is_right(test, shards_are_the_whole), "slurm": slurm_tasks_draw_parts}, ("fire3dv", "make"))
