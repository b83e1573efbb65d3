#!/usr/bin/env python3
"""End-to-end test of `fire3dv verify`: images of each command are identical; each change is named; hostile texts open no file."""
import json
import os
import shutil
import signal
import struct
import zlib

import numpy as np

from dataset_randomize_test import ball_scene
from dataset_runs import RUN, join, recording, run, scene_of, start
from harness import Program, check, main, vulkan_environment, wait_until
from label_scene import SIZE

SHARED = ("--cache", "off", "--samples", "1", "--shadows", "off", "--size", f"{SIZE[0]}x{SIZE[1]}")
IDENTICAL, DIFFERENT, UNCHECKED = 0, 1, 2


def execute(test, name, *arguments, code=0):
    program = Program(test, name, [test.programs_at["fire3dv"], *map(str, arguments)], vulkan_environment())
    program.expect_exit(code)
    return program


def verify(test, *arguments, code=IDENTICAL):
    """Standard output and the log, in this order."""
    program = execute(test, "verify", "verify", *arguments, "--cache", "off", code=code)
    return "".join(line.rstrip("\n") + "\n" for line in program.out) + program.stderr_text()


# --- PNG files -------------------------------------------------------------------------------------------------------

def chunks_of(path):
    with open(path, "rb") as file:
        data = file.read()
    at, chunks = 8, []
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        chunks.append((kind, data[at + 8:at + 8 + length]))
        at += 12 + length
    return chunks


def write_chunks(path, chunks):
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for kind, body in chunks:
            file.write(struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)))


def provenance_of(path):
    text, = [body for kind, body in chunks_of(path) if kind == b"tEXt" and body.startswith(b"Provenance\0")]
    return json.loads(text.split(b"\0", 1)[1])


def with_provenance(path, out, text):
    """A copy with another text, of JSON or bytes; None: without."""
    chunks = [chunk for chunk in chunks_of(path) if not chunk[1].startswith(b"Provenance\0")]
    if text is not None:
        body = text if isinstance(text, bytes) else json.dumps(text).encode()
        chunks.insert(1, (b"tEXt", b"Provenance\0" + body))
    write_chunks(out, chunks)
    return out


def edit_pixel(path, x, y):
    """Turns the lowest bit of a pixel's red. Returns the pixel before. Rows have the filters none, sub or up."""
    chunks = chunks_of(path)
    width, height = struct.unpack(">II", chunks[0][1][:8])
    channels = {2: 3, 6: 4}[chunks[0][1][9]]
    packed = b"".join(body for kind, body in chunks if kind == b"IDAT")
    data, stride = bytearray(zlib.decompress(packed)), width * channels + 1
    rows = [bytearray(width * channels)]
    for at in range(0, stride * height, stride):
        row, above = bytearray(data[at + 1:at + stride]), rows[-1]
        check(data[at] in (0, 1, 2), f"filter {data[at]}")
        for i in range(len(row)):
            add = (0, row[i - channels] if i >= channels else 0, above[i])[data[at]]
            row[i] = (row[i] + add) & 255
        rows.append(row)
    before = tuple(rows[y + 1][channels * x:channels * x + 3])
    rows[y + 1][channels * x] ^= 1
    body = zlib.compress(b"".join(b"\0" + bytes(row) for row in rows[1:]))
    others = [chunk for chunk in chunks if chunk[0] != b"IDAT"]
    write_chunks(path, [*others[:-1], (b"IDAT", body), others[-1]])
    return before


def edit_json(path, part, key, value):
    """Changes a member of a part. Returns what it was."""
    with open(path, encoding="utf-8") as file:
        document = json.load(file)
    before, part(document)[key] = part(document)[key], value
    with open(path, "w", encoding="utf-8") as file:
        json.dump(document, file)
    return before


# --- cases -----------------------------------------------------------------------------------------------------------

def still_image(test):
    folder = test.path("still")
    if not os.path.exists(folder):
        execute(test, "still", scene_of(test), "--headless", "--frames", 1, "--out", folder, "--exposure", "0.75", *SHARED)
    return os.path.join(folder, "frame_000000.png")


def images_of_live_runs_are_identical(test):
    image = still_image(test)
    said = verify(test, image, scene_of(test))
    check(said.startswith(f"identical: {image}\n") and "build" not in said.split("fire3dv:")[0], said)
    known = provenance_of(image)
    check(known["command"] == "fire3dv" and ["exposure", "0.75"] in known["options"], f"{known}")
    check("llvmpipe" in known["machine"]["device"] and known["build"]["version"] and len(known["build"]["build_id"]) >= 16, f"{known}")
    # A scene beside the image is found by its name.
    check("identical" in verify(test, shutil.copy(image, test.path("beside.png"))), "the scene beside the image")
    # Of a recording that is played: the frame is found by the streams that the image shows.
    folder = test.path("played")
    execute(test, "played", scene_of(test), "--replay", recording(test), "--step", "--headless", "--frames", 7, "--out", folder, *SHARED)
    played = os.path.join(folder, "frame_000006.png")
    said = verify(test, played, recording(test), scene_of(test))
    check(said.startswith("identical"), said)
    # Arrays, by the line that names them.
    folder = test.path("arrays of a live run")
    execute(test, "arrays", scene_of(test), "--headless", "--frames", 1, "--out", folder, "--outputs", "color,depth,normal", *SHARED)
    for name in ("depth.npy", "normal.npy", "png"):
        said = verify(test, os.path.join(folder, f"frame_000000.{name}"), scene_of(test))
        check(said.startswith("identical"), said)
    path = os.path.join(folder, "frame_000000.depth.npy")
    depth = np.load(path)
    depth[3, 5] = 1
    np.save(path, depth)
    said = verify(test, path, scene_of(test), code=DIFFERENT)
    check("depth.npy: pixel (5, 3) is 1 in the file and " in said, said)
    said = verify(test, played, scene_of(test), code=UNCHECKED)
    check("the recording that was drawn is not named" in said, said)


def each_change_is_named(test):
    image, scene = still_image(test), scene_of(test)
    edited = shutil.copy(image, test.path("edited.png"))
    red, green, blue = edit_pixel(edited, 33, 7)
    said = verify(test, edited, scene, code=DIFFERENT)
    check(f"pixel (33, 7) is {red ^ 1} {green} {blue} in the file and {red} {green} {blue} here" in said, said)
    said = verify(test, image, scene, "--exposure", 2, code=DIFFERENT)
    check("setting --exposure is 0.75 in the file and 2 here" in said, said)
    said = verify(test, image, test.scene, code=DIFFERENT)
    check("scene is " in said and " in the file and " in said, said)
    # Another build alone is no difference of the image; it is named in both cases.
    known = provenance_of(image)
    known["build"]["commit"] = "of-old"
    said = verify(test, with_provenance(image, test.path("old.png"), known), scene)
    check(said.startswith("identical") and "build: commit is of-old in the file" in said, said)
    known["machine"]["device"] = "another device"
    said = verify(test, with_provenance(edited, test.path("old.png"), known), scene, code=DIFFERENT)
    check("pixel (33, 7)" in said and "machine: device is another device in the file and llvmpipe" in said, said)


def hostile_texts_open_nothing(test):
    image, scene, out = still_image(test), scene_of(test), test.path("hostile.png")
    good = provenance_of(image)
    secret, fifo = test.path("secret.glb"), test.path("fifo.glb")
    shutil.copy(scene, secret)
    os.mkfifo(fifo)  # a reader would wait without end

    def refused(text, reason, *arguments):
        said = verify(test, with_provenance(image, out, text), *arguments, code=UNCHECKED)
        check("cannot be checked: " in said and reason in said, said)

    refused(None, "has no provenance", scene)
    refused(b"not JSON", "is not the JSON", scene)
    refused(b"[" * 60000, "is not the JSON", scene)
    refused(b" " * 70000, "70000 bytes", scene)
    refused(b" " * (2 << 20), "a chunk is larger than the limit", scene)
    refused({**good, "version": 99}, "another version", scene)
    refused({**good, "command": "rm"}, "command", scene)
    for name in (secret, f"../{os.path.basename(test.folder)}/secret.glb", fifo, os.path.basename(fifo), "..", ""):
        refused({**good, "files": {"scene": name}}, "scene")
    for option in ("out", "record", "environment", "overlay", "cache", "config", "assets", "listen", "keypoints", "scene=x"):
        refused({**good, "options": [[option, secret]]}, f'the option "--{option}"', scene)
        refused({**good, "command": "dataset", "options": [[option, secret]]}, f'the option "--{option}"', scene)
    # A file beside the image is never an option, though no folder comes before its name.
    shutil.copy(scene, test.path("--frame-all"))
    with_provenance(image, out, {**good, "files": {"scene": "--frame-all"}})
    program = Program(test, "verify", ["bash", "-c", f"cd '{test.folder}' && exec '{test.programs_at['fire3dv']}' verify hostile.png --cache off"],
                      vulkan_environment())
    program.expect_exit(IDENTICAL)
    check("./--frame-all" in program.stderr_text() + "".join(program.out), program.stderr_text())
    with open(out, "wb") as file:
        file.write(b"no image")
    check("cannot be checked" in verify(test, out, scene, code=UNCHECKED), "no PNG")
    check("cannot be checked" in verify(test, test.path("absent.png"), scene, code=UNCHECKED), "no file")
    check("name an image or a folder" in verify(test, code=UNCHECKED), "no name")


def data_sets_are_identical(test):
    """Drawn in two shards, one of which is killed and continued."""
    inputs, form = [recording(test), scene_of(test)], ("--format", "coco", *RUN)
    parts = [test.path(f"part{i}") for i in (1, 2)]
    run(test, parts[0], *form, "--shard", "1/2")
    program, path = start(test, parts[1], *form, "--shard", "2/2"), os.path.join(parts[1], "frames.jsonl")
    wait_until("images", lambda: os.path.exists(path) and len(open(path, "rb").read().splitlines()) >= 3 or not program.alive())
    program.signal(signal.SIGKILL)
    program.wait()
    run(test, parts[1], *form, "--shard", "2/2")
    whole = test.path("whole")
    join(test, *parts, "--out", whole)
    said = verify(test, whole, *inputs)
    images = sorted(os.listdir(os.path.join(whole, "images")))
    check(len(images) > 30 and said.startswith(f"identical: {len(images)} images of {whole}\n"), said)
    check("\n  identical, too: dataset.json, annotations.json\n  not compared: README.md, index.html\n" in said, said)
    said = verify(test, parts[1], *inputs, "--sample", 4)
    check(said.startswith("identical: 4 images") and "too: dataset.json\n" in said and "which fire3dv join writes" in said, said)
    # A list of labels that does not follow from its images.
    before = edit_json(os.path.join(whole, "annotations.json"), lambda coco: coco["annotations"][3]["bbox"], 2, 77)
    edit_json(os.path.join(whole, "dataset.json"), lambda sheet: sheet["objects"][1], "diameter_mm", 5)
    said = verify(test, whole, *inputs, "--sample", 2, code=DIFFERENT)
    for wanted in (f'annotations.json: field "annotations[3].bbox[2]" is 77 in the file and {before} here',
                   'dataset.json: field "objects[1].diameter_mm" is 5', "2 images of 2 identical", "labels of images that are not drawn again"):
        check(wanted in said, f"{wanted}:\n{said}")
    # One image alone, by its own text.
    said = verify(test, os.path.join(whole, "images", images[-1]), *inputs)
    check(said.startswith("identical"), said)
    edit_pixel(os.path.join(whole, "images", images[5]), 0, 89)
    text = open(os.path.join(whole, "frames.jsonl"), encoding="utf-8").read().splitlines()
    line = json.loads(text[9])
    line["cam_t_w2c"][0] += 1
    text[9] = json.dumps(line)
    with open(os.path.join(whole, "frames.jsonl"), "w", encoding="utf-8") as file:
        file.write("\n".join([*text[:20], *text[21:]]) + "\n")
    os.remove(os.path.join(whole, "images", images[30]))
    said = verify(test, whole, *inputs, code=DIFFERENT)
    for wanted in (f"{images[5]}: pixel (0, 89) is ", 'image 9: field "cam_t_w2c[', "image 20 is not in the list", images[30],
                   f"{len(images) - 4} images of {len(images)} identical", "files of the whole set, since 1 image is missing"):
        check(wanted in said, f"{wanted}:\n{said}")
    said = verify(test, parts[0], *inputs, "--camera", "front", code=DIFFERENT)
    check("cameras is " in said, said)
    said = verify(test, parts[0], os.path.join(test.folder, "cut.mcap"), scene_of(test), code=UNCHECKED)
    check("cut.mcap" in said, said)
    other = test.path("other.mcap")
    with open(recording(test), "rb") as file, open(other, "wb") as out:
        out.write(file.read()[:-400])  # its index is gone
    said = verify(test, parts[0], other, scene_of(test), code=DIFFERENT)
    check("recording is " in said, said)


RANDOMIZED = """
cameras:
  front: {azimuth_deg: [-60, 60], elevation_deg: [-40, 70], look_at: ball, distance_m: [40, 90], noise: 4}
nodes:
  ball: {move_m: [[-50, 50], [-20, 20], 0]}
materials:
  ball: {base_color: {choice: [[0.9, 0.1, 0.1], [0.1, 0.9, 0.1]]}}
background: {color: [[0, 1], [0, 1], [0, 1]]}
"""


def formats_are_identical(test):
    """Archives, arrays with flow, and randomised images with noise."""
    inputs, short = [recording(test), scene_of(test)], ("--rate", 20, "--end", 0.15, "--camera", "front")
    tar = test.path("tar")
    run(test, tar, "--format", "webdataset", "--tar-size", 0.1, *short)
    check(not os.path.exists(os.path.join(tar, "images")), "the images are not packed")
    said = verify(test, tar, *inputs)
    check(said.startswith("identical: 4 images"), said)
    archive = os.path.join(tar, "shard-000000.tar")
    with open(archive, "r+b") as file:
        data = file.read()
        at = data.index(b'"cam_K"')
        file.seek(at)
        file.write(b'"cam_L"')
    said = verify(test, tar, *inputs, code=DIFFERENT)
    check('000000.json: field "cam_K" is absent' in said and "3 images of 4 identical" in said and "shards.json" in said, said)
    arrays = test.path("arrays")
    run(test, arrays, "--format", "folder", "--flow-frames", 1, *short)
    said = verify(test, arrays, *inputs)
    check(said.startswith("identical: 4 images"), said)
    depth = np.load(os.path.join(arrays, "00_front", "000002.depth.npy"))
    depth[40, 80] = 2.5
    np.save(os.path.join(arrays, "00_front", "000002.depth.npy"), depth)
    said = verify(test, arrays, *inputs, code=DIFFERENT)
    check("000002.depth.npy: pixel (80, 40) is 2.5 in the file and " in said, said)
    # The file of ranges is named again; its digest is compared.
    plan, drawn, ball = test.path("ranges.yaml"), test.path("drawn"), ball_scene(test)
    with open(plan, "w", encoding="utf-8") as file:
        file.write(RANDOMIZED)
    run(test, drawn, "--format", "bop", "--randomize", plan, "--seed", 5, "--images", 4, "--camera", "front", inputs=[ball])
    said = verify(test, drawn, ball, code=UNCHECKED)
    check("it was drawn with --randomize FILE.yaml: repeat that option" in said and "--seed" not in said, said)
    said = verify(test, drawn, ball, "--randomize", plan)
    check(said.startswith("identical: 4 images"), said)
    train = os.path.join(drawn, "train", "000000")
    edit_json(os.path.join(train, "scene_gt.json"), lambda poses: poses["2"][0]["cam_t_m2c"], 1, 0)
    edit_json(os.path.join(train, "scene_gt_info.json"), lambda infos: infos["1"][0], "px_count_all", 1)
    os.remove(os.path.join(train, "scene_camera.json"))
    said = verify(test, drawn, ball, "--randomize", plan, code=DIFFERENT)
    for wanted in ('scene_gt.json: field "2[0].cam_t_m2c[1]" is 0 in the file and ', 'scene_gt_info.json: field "1[0].px_count_all" is 1 in the file',
                   "scene_camera.json", "4 images of 4 identical", "models/obj_000001.ply"):
        check(wanted in said, f"{wanted}:\n{said}")
    image = os.path.join(drawn, "train", "000000", "rgb", "000003.png")
    check(verify(test, image, ball, "--randomize", plan).startswith("identical"), "one randomised image")
    with open(plan, "a", encoding="utf-8") as file:
        file.write("# another file\n")
    said = verify(test, drawn, ball, "--randomize", plan, code=DIFFERENT)
    check("randomization is " in said, said)


def frames_of_recordings_are_identical(test):
    folder = test.path("frames")
    execute(test, "render", "render", recording(test), scene_of(test), "--fps", 10, "--end", 0.3, "--out", folder, "--exposure=2", *SHARED)
    said = verify(test, folder, recording(test), scene_of(test))
    check(said.startswith("identical: 4 images"), said)
    said = verify(test, os.path.join(folder, "frame_000003.png"), recording(test), scene_of(test))
    check(said.startswith("identical"), said)
    arrays = test.path("arrays of a recording")
    execute(test, "render", "render", recording(test), scene_of(test), "--fps", 10, "--end", 0.3, "--out", arrays, "--outputs", "color,motion,depth", *SHARED)
    said = verify(test, arrays, recording(test), scene_of(test))
    check(said.startswith("identical: 4 images"), said)
    path = os.path.join(arrays, "frame_000002.depth.npy")
    depth = np.load(path)
    depth[3, 5] = 1
    np.save(path, depth)
    said = verify(test, path, recording(test), scene_of(test), code=DIFFERENT)
    check("depth.npy: pixel (5, 3) is 1 in the file and " in said, said)
    video = test.path("video.mkv")
    execute(test, "video", "render", recording(test), scene_of(test), "--fps", 10, "--end", 0.3, "--out", video, "--codec", "ffv1", *SHARED)
    said = verify(test, video, recording(test), scene_of(test))
    check(said.startswith(f"identical: {video}"), said)
    with open(video, "r+b") as file:
        at = len(file.read()) // 2
        file.seek(at)
        byte = file.read(1)
        file.seek(at)
        file.write(bytes([byte[0] ^ 255]))
    said = verify(test, video, recording(test), scene_of(test), code=DIFFERENT)
    check(f"byte {at} differs" in said, said)
    said = verify(test, folder, recording(test), scene_of(test), "--fps", 20, code=DIFFERENT)
    check("setting --fps is 10 in the file and 20 here" in said, said)


if __name__ == "__main__":
    main({"live": images_of_live_runs_are_identical, "changes": each_change_is_named, "hostile": hostile_texts_open_nothing,
          "datasets": data_sets_are_identical, "formats": formats_are_identical, "frames": frames_of_recordings_are_identical}, ("fire3dv", "make"))
