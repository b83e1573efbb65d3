#!/usr/bin/env python3
"""End-to-end test of `fire3dv dataset --randomize`: draws against their definition, images against the draws, the same bytes in parts."""
import json
import os
import shutil
import struct
import subprocess
import sys
import zlib

import numpy as np

from dataset_runs import expect_same, join, lines_of, recording, run, scene_of, tree
from harness import check, main
from label_readers import pixels_of, read_color
from label_scene import SIZE, cube, sphere, write_bodies

IMAGES, SEED = 6, 5
FILE = """
cameras:
  front:
    look_at: ball
    look_at_offset_m: [[-4, 4], [-2, 2], 0]
    distance_m: {log: [40, 90]}
    azimuth_deg: [-60, 60]
    elevation_deg: [-40, 70]
    roll_deg: {normal: [0, 20]}
    fov_deg: [20, 40]
nodes:
  ball: {move_m: [[-50, 50], [-20, 20], 0], rotation: uniform}
materials:
  ball: {base_color: {choice: [[0.9, 0.1, 0.1], [0.1, 0.9, 0.1]]}, roughness: [0.2, 1]}
environment: {intensity: [0.5, 1]}
background: {color: [[0, 1], [0, 1], [0, 1]]}
"""
MASK = (1 << 64) - 1
STEP = 0x9E3779B97F4A7C15


def mix(value):
    value = (value ^ value >> 30) * 0xBF58476D1CE4E5B9 & MASK
    value = (value ^ value >> 27) * 0x94D049BB133111EB & MASK
    return value ^ value >> 31


def uniforms(seed, frame, name, count):
    """Numbers in [0, 1) of a parameter, by docs/randomization.md."""
    text = 0xCBF29CE484222325
    for byte in name.encode():
        text = (text ^ byte) * 0x100000001B3 & MASK
    state = mix(mix(mix(seed + STEP & MASK) ^ (frame + STEP & MASK)) ^ text)
    return [(mix(state + STEP * (i + 1) & MASK) >> 11) * 2.0 ** -53 for i in range(count)]


def ball_scene(test):
    path = os.path.join(test.folder, "ball.glb")
    if not os.path.exists(path):
        write_bodies(path, [("ball", sphere((0, 0, 0), 3.0), [0.8, 0.8, 0.8], 1, {"translation": [5, 6, 7]})])
    return path


def write(test, name, text):
    path = os.path.join(test.folder, name)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def draw(test, out, *arguments, text=FILE, images=IMAGES, seed=SEED, **options):
    plan = write(test, "randomize.yaml", text)
    options.setdefault("inputs", [ball_scene(test)])
    counted = ("--images", images) if images else ()
    return run(test, out, "--randomize", plan, "--seed", seed, *counted, "--camera", "front", *arguments, **options)


def whole(test):
    folder = os.path.join(test.folder, "randomised")
    if not os.path.exists(folder):
        draw(test, folder, "--format", "folder")
    return folder


def srgb(linear):
    linear = np.asarray(linear)
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def images_show_their_draws(test):
    folder = whole(test)
    lines = lines_of(folder)
    check(len(lines) == IMAGES, f"{len(lines)} images")
    for frame, line in enumerate(lines):
        drawn = line["drawn"]
        value = {name: drawn[f"cameras.front.{name}"] for name in ("distance_m", "azimuth_deg", "elevation_deg", "fov_deg", "look_at_offset_m")}
        (u,) = uniforms(SEED, frame, "cameras.front.azimuth_deg", 1)
        check(abs(value["azimuth_deg"] - (-60 + 120 * u)) < 1e-9, f"azimuth {value['azimuth_deg']}")
        (u,) = uniforms(SEED, frame, "cameras.front.distance_m", 1)
        check(abs(value["distance_m"] - 40 * (90 / 40) ** u) < 1e-9, f"distance {value['distance_m']}")
        (u,) = uniforms(SEED, frame, "cameras.front.elevation_deg", 1)
        low, high = np.sin(np.radians((-40, 70)))
        check(abs(np.sin(np.radians(value["elevation_deg"])) - (low + (high - low) * u)) < 1e-9, "elevation")
        moved = drawn["nodes.ball.move_m"]
        wanted = [low + (high - low) * u for (low, high), u in zip(((-50, 50), (-20, 20)), uniforms(SEED, frame, "nodes.ball.move_m", 2))]
        check(np.allclose(moved, [*wanted, 0], atol=1e-9), f"moved {moved}")

        centre = np.add((5, 6, 7), moved)
        azimuth, elevation = np.radians((value["azimuth_deg"], value["elevation_deg"]))
        direction = np.array([np.sin(azimuth) * np.cos(elevation), np.sin(elevation), np.cos(azimuth) * np.cos(elevation)])
        eye = centre + value["look_at_offset_m"] + value["distance_m"] * direction
        k, rotation, translation = (np.array(line[name]) for name in ("cam_K", "cam_R_w2c", "cam_t_w2c"))
        rotation, translation = rotation.reshape(3, 3), translation / 1000
        check(np.allclose(-rotation.T @ translation, eye, atol=1e-3), f"image {frame}: the eye is {-rotation.T @ translation}, not {eye}")
        focal = SIZE[1] / 2 / np.tan(np.radians(value["fov_deg"]) / 2)
        check(abs(k[0] / focal - 1) < 1e-5 and abs(k[4] / focal - 1) < 1e-5, f"image {frame}: focal length {k[0]}, not {focal}")
        # The target of look_at is in the middle, and the ball where its centre is projected to.
        middle = pixels_of(k, (rotation @ (centre + value["look_at_offset_m"]) + translation)[None])[0]
        check(np.abs(middle - (np.array(SIZE) - 1) / 2).max() < 1e-2, f"image {frame}: looks at {middle}")
        at = os.path.join(folder, "00_front", f"{frame:06}.")
        instances, color = np.load(at + "instance.npy"), read_color(at + "png")
        v, u = np.nonzero(instances)
        away = np.array([u.mean(), v.mean()]) - pixels_of(k, (rotation @ centre + translation)[None])[0]
        check(len(u) > 30 and np.abs(away).max() < 0.6, f"image {frame}: the ball is {away} pixels away, {len(u)} pixels")
        background = color[instances == 0]
        off = np.abs(np.median(background, 0) - srgb(drawn["background.color"])).max()
        check(off <= 1, f"image {frame}: the background is {off} off")
        red = drawn["materials.ball.base_color"][0] > 0.5
        mean = color[instances > 0].mean(0)
        check((mean[0] > 2 * mean[1]) == red and (mean[1] > 2 * mean[0]) != red, f"image {frame}: colour {mean}")
    for name in ("cameras.front.roll_deg", "materials.ball.roughness", "environment.intensity"):
        check(len({line["drawn"][name] for line in lines}) == IMAGES, f"{name} is the same in several images")
    with open(os.path.join(folder, "index.html"), encoding="utf-8") as file:
        page = file.read()
    check("Drawn parameters" in page and "cameras.front.distance_m" in page and "nodes.ball.rotation [3]" in page, "index.html")
    with open(os.path.join(folder, "README.md"), encoding="utf-8") as file:
        readme = file.read()
    check("    look_at: ball" in readme and f"Seed {SEED}." in readme and "--randomize randomize.yaml --seed 5 --images 6" in readme, readme)


def parts_are_the_whole(test):
    folder = whole(test)
    parts = [test.path(f"part{i}") for i in (1, 2)]
    for i, part in enumerate(parts, 1):
        draw(test, part, "--format", "folder", "--shard", f"{i}/2")
    joined = test.path("joined")
    join(test, *parts, "--out", joined)
    expect_same(joined, folder, "joined shards")
    out = test.path("continued")
    shutil.copytree(folder, out)
    path = os.path.join(out, "frames.jsonl")
    with open(path, encoding="utf-8") as file:
        kept = [line for number, line in enumerate(file) if number not in (0, 3)]
    with open(path, "w", encoding="utf-8") as file:
        file.writelines(kept)
    draw(test, out, "--format", "folder")
    expect_same(out, folder, "a continued run")
    said = draw(test, out, "--format", "folder", seed=SEED + 1, code=1)
    check("seed is 5 there and 6 here" in said, said)


def colours_have_noise_and_exposure(test):
    text = """
cameras:
  front: {exposure_ev: {choice: [-2, 0]}, noise: 4}
background: {color: [0.2, 0.2, 0.2]}
materials: {ball: {base_color: [0.5, 0.5, 0.5], roughness: 1}}
"""
    plain, noisy = test.path("plain"), test.path("noisy")
    for out, used in ((plain, text.replace(", noise: 4", "")), (noisy, text)):
        draw(test, out, "--format", "folder", text=used)
    brightness = {}
    for frame, (line, other) in enumerate(zip(lines_of(plain), lines_of(noisy))):
        at = [os.path.join(folder, "00_front", f"{frame:06}.") for folder in (plain, noisy)]
        ours, theirs = (read_color(path + "png").astype(float) for path in at)
        instances = np.load(at[0] + "instance.npy")
        difference = (theirs - ours)[instances == 0]
        check(abs(difference.std() - 4) < 0.2 and abs(difference.mean()) < 0.2, f"noise: {difference.mean()}, {difference.std()}")
        check((instances == np.load(at[1] + "instance.npy")).all(), "labels have no noise")
        check(other["drawn"]["cameras.front.noise"] == 4, "the draw")
        brightness.setdefault(line["drawn"]["cameras.front.exposure_ev"], set()).add(round(ours[instances > 0].mean(), 6))
    said = draw(test, test.path("alpha"), "--format", "yolo", text="materials: {ball: {alpha: [0, 1]}}", images=1)
    check('warning: alpha has no effect where the material is opaque: "materials.ball"' in said, said)
    check(all(len(each) == 1 for each in brightness.values()) and min(brightness[-2]) < 0.7 * min(brightness[0]), f"{brightness}")


def recordings_keep_their_poses(test):
    text = "nodes: {red: {move_m: [[5, 9], 0, 0]}, green: {visible: 0.5}}\nmaterials: {\"*\": {roughness: [0, 1]}}\n"
    arguments = ("--format", "coco", "--rate", 20)
    out, same, bare = test.path("recording"), test.path("again"), test.path("bare")
    inputs = [recording(test), scene_of(test)]
    said = draw(test, out, *arguments, text=text, images=None, inputs=inputs)
    check("nodes.red.*: its place has no effect: a recorded stream moves the node" in said, said)
    draw(test, same, *arguments, text=text, images=None, inputs=inputs)
    expect_same(same, out, "another run")
    run(test, bare, "--camera", "front", *arguments, inputs=inputs)
    numbers = set()
    for line, plain in zip(lines_of(out), lines_of(bare)):
        poses = {each["instance"]: each["cam_t_m2c"] for each in plain["instances"]}
        shown = {each["instance"] for each in line["instances"] if each["px_count_visib"]}
        check(all(each["cam_t_m2c"] == poses[each["instance"]] for each in line["instances"] if each["instance"] in poses), "poses")
        numbers.add((line["drawn"]["nodes.green.visible"], 2 in shown))
    check((0, True) not in numbers and (1, True) in numbers and (0, False) in numbers, f"{numbers}")
    check("drawn" not in lines_of(bare)[0] and b"randomization" not in tree(bare)["manifest.json"], "a set without randomisation")


def the_example_runs(test):
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "examples", "randomize", "randomize.yaml")
    with open(path, encoding="utf-8") as file:
        said = draw(test, test.path("example"), "--format", "yolo", text=file.read(), images=2)
    check("warning: " + os.path.join(test.folder, "randomize.yaml") not in said, said)
    drawn = lines_of(test.path("example"))[1]["drawn"]
    check({"lights.key light.intensity", "materials.ball.roughness", "cameras.front.exposure_ev"} < set(drawn), f"{drawn}")


def cameras_follow_a_path(test):
    """Poses of a TUM file, between its lines; the lens blurs colours and no label."""
    half = np.radians(30) / 2
    poses = [(10, (0, 0, 60), (0, 0, 0, 1)), (11, (0, 10, 60), (0, 0, 0, 1)), (13, (20, 10, 60), (0, np.sin(half), 0, np.cos(half)))]
    turned = [(time, at, (w, z, -y, -x)) for time, at, (x, y, z, w) in poses]  # with a half turn about x: OpenCV's axes
    write(test, "path.txt", "# time x y z qx qy qz qw\n" + "".join(" ".join(map(str, (time, *at, *q))) + "\n" for time, at, q in turned))
    out, blurred = test.path("path"), test.path("lens")
    draw(test, out, "--format", "folder", text="cameras: {front: {path: path.txt}}\n")
    for line in lines_of(out):
        time = 10 + 3 * line["drawn"]["cameras.front.path_at"]
        way = np.interp(time, (11, 13), (0, 1))
        eye = np.array([20 * way, 10 * np.interp(time, (10, 11), (0, 1)), 60])
        angle = np.radians(30) * way
        right, down, forward = (np.cos(angle), 0, -np.sin(angle)), (0, -1, 0), (-np.sin(angle), 0, -np.cos(angle))
        rotation = np.reshape(line["cam_R_w2c"], (3, 3))
        check(np.allclose(rotation, [right, down, forward], atol=1e-5), f"path: {rotation} at {time} s")
        check(np.allclose(-rotation.T @ line["cam_t_w2c"] / 1000, eye, atol=1e-3), f"path: the eye at {time} s")
    sharp = "cameras: {front: {path: path.txt, f_number: 0.1, focus_distance_m: 3}}\n"
    draw(test, blurred, "--format", "folder", text=sharp)
    steps = []
    for frame in range(IMAGES):
        ours, theirs = (os.path.join(folder, "00_front", f"{frame:06}.") for folder in (out, blurred))
        instances = np.load(ours + "instance.npy")
        check((instances == np.load(theirs + "instance.npy")).all(), "labels are those of a pinhole")
        if (instances > 0).sum() > 50:
            steps.append([np.abs(np.diff(read_color(at + "png").astype(float), axis=1)).max() for at in (ours, theirs)])
    check(len(steps) > 1 and all(blur < 0.6 * sharp for sharp, blur in steps), f"largest steps of colours: {steps}")


def variants_are_drawn(test):
    scene = test.path("variants.glb")
    with open(ball_scene(test), "rb") as file:
        data = file.read()
    (size,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20:20 + size])
    document["extensionsUsed"] = ["KHR_materials_variants"]
    document["extensions"] = {"KHR_materials_variants": {"variants": [{"name": "red"}, {"name": "green"}]}}
    for name, color in (("red", [1, 0, 0, 1]), ("green", [0, 1, 0, 1])):
        document["materials"].append({"name": name, "pbrMetallicRoughness": {"baseColorFactor": color, "metallicFactor": 0}})
    document["meshes"][0]["primitives"][0]["extensions"] = {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}, {"material": 2, "variants": [1]}]}}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(scene, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, len(data) - size + len(text)) + struct.pack("<I4s", len(text), b"JSON") + text + data[20 + size:])
    text = "scene: {variant: {choice: [red, green]}}\nnodes: {ball: {move_m: [[-20, 20], 0, 0]}}\ncameras: {front: {look_at: ball}}\n"
    out = test.path("variants")
    draw(test, out, "--format", "folder", text=text, images=8, inputs=[scene])
    seen = set()
    for frame, line in enumerate(lines_of(out)):
        at = os.path.join(out, "00_front", f"{frame:06}.")
        mask = np.load(at + "instance.npy") > 0
        variant, mean = line["drawn"]["scene.variant"], read_color(at + "png")[mask].mean(0)
        check((mean[0] > 2 * mean[1]) == (variant == "red"), f"image {frame}: {variant}, {mean}")
        check(abs(np.nonzero(mask)[1].mean() - (SIZE[0] - 1) / 2) < 0.6, f"image {frame}: the ball is not in the middle")
        seen.add(variant)
    check(seen == {"red", "green"}, f"{seen}")
    parts = [test.path(f"variant{i}") for i in (1, 2)]
    for i, part in enumerate(parts, 1):
        draw(test, part, "--format", "folder", "--shard", f"{i}/2", "--devices", "0,0", text=text, images=8, inputs=[scene])
    joined = test.path("variants joined")
    join(test, *parts, "--out", joined)
    expect_same(joined, out, "joined shards with variants")
    said = draw(test, test.path("bad"), "--format", "coco", text="scene: {variant: blue}", inputs=[scene], code=1)
    check("randomize.yaml:1: scene.variant: " in said and "red" in said, said)


def maps_are_drawn(test):
    """Environment maps of one colour each light a white ball; the light of the drawn map is seen."""
    for name, rgbe in (("red.hdr", (128, 26, 26, 129)), ("green.hdr", (26, 128, 26, 129))):
        with open(os.path.join(test.folder, name), "wb") as file:
            file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n" + bytes(rgbe) * (16 * 32))
    text = "environment: {map: {choice: [red.hdr, green.hdr]}, intensity: [0.5, 1]}\n"
    arguments = ("--format", "folder", "--environment", os.path.join(test.folder, "red.hdr"))
    out = test.path("maps")
    draw(test, out, *arguments, text=text, images=5)
    seen = set()
    for frame, line in enumerate(lines_of(out)):
        at = os.path.join(out, "00_front", f"{frame:06}.")
        drawn, mean = line["drawn"]["environment.map"], read_color(at + "png")[np.load(at + "instance.npy") > 0].mean(0)
        check((mean[0] > 1.5 * mean[1]) == (drawn == "red.hdr") and (mean[1] > 1.5 * mean[0]) == (drawn == "green.hdr"), f"image {frame}: {drawn}, {mean}")
        seen.add(drawn)
    check(len(seen) == 2, f"{seen}")
    parts = [test.path(f"map{i}") for i in (1, 2)]
    for i, part in enumerate(parts, 1):
        draw(test, part, *arguments, "--shard", f"{i}/2", "--devices", "0,0", text=text, images=5)
    joined = test.path("maps joined")
    join(test, *parts, "--out", joined)
    expect_same(joined, out, "joined shards with maps")
    said = draw(test, test.path("bad"), *arguments, "--flow-frames", 1, text=text, code=1)
    check("environment.map: each map has a renderer of its own" in said, said)
    said = draw(test, test.path("bad"), *arguments, text="environment: {map: blue.hdr}", code=1)
    check("randomize.yaml:1: environment.map: " in said and "blue.hdr" in said, said)


def programs_draw(test):
    """Draws of a file of lines, such as those of another set or of a program."""
    folder = whole(test)
    again = test.path("again")
    draw(test, again, "--format", "folder", "--draws", os.path.join(folder, "frames.jsonl"), seed=99)
    labels = lambda line: {key: line[key] for key in ("frame", "drawn", "cam_K", "cam_R_w2c", "cam_t_w2c", "brightness", "instances")}
    check([labels(line) for line in lines_of(again)] == [labels(line) for line in lines_of(folder)], "the same draws, other labels")
    one = write(test, "one.jsonl", json.dumps({"frame": 2, "drawn": {"nodes.ball.move_m": [1, 2, 3]}}) + "\n")
    out = test.path("one")
    draw(test, out, "--format", "folder", "--draws", one)
    for ours, theirs in zip(lines_of(out), lines_of(folder)):
        check((labels(ours) == labels(theirs)) == (ours["frame"] != 2), "a single draw")
    check(lines_of(out)[2]["drawn"]["nodes.ball.move_m"] == [1, 2, 3], "the draw")
    for line, wanted in (("{}", "draws.jsonl:1: a line is"), ('{"frame": 0, "drawn": {"nodes.ball.scale": 2}}', '"nodes.ball.scale" is no parameter that'),
                         ('{"frame": 0, "drawn": {"background.color": [0, 2, 0]}}', "has a value that the field cannot have"),
                         ('{"frame": 0, "drawn": {"background.color": [0, null, 0]}}', "must be a number, a text, or up to four numbers")):
        said = draw(test, test.path("bad"), "--format", "coco", "--draws", write(test, "draws.jsonl", line), code=1)
        check(wanted in said and not os.path.exists(test.path("bad")), said)
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "examples", "randomize", "draws.py")
    made = os.path.join(test.folder, "made.jsonl")
    subprocess.run([sys.executable, program, made, "--images", "4", "--names", "red", "green", "--apart", "12", "--box", "20"], check=True)
    out = test.path("made")
    text = "nodes: {red: {move_m: [0, 0, 0]}, green: {move_m: [0, 0, 0]}}\n"
    draw(test, out, "--format", "coco", "--draws", made, text=text, images=4, inputs=[scene_of(test)])
    apart = [np.subtract(line["drawn"]["nodes.red.move_m"], line["drawn"]["nodes.green.move_m"]) for line in lines_of(out)]
    check(len(apart) == 4 and min(np.linalg.norm(apart, axis=1)) >= 12, f"{apart}")


def write_png(path, colour):
    """A picture of one colour, 4x4."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = (b"\0" + bytes(colour) * 4) * 4
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 4, 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def textures_are_drawn(test):
    """A plate without texture chooses one of a folder; a ball without coordinates cannot."""
    corners = [(-20, -20, 0), (20, -20, 0), (20, 20, 0), (-20, 20, 0)]
    plate = (corners, [(0, 0, 1)] * 4, [0, 1, 2, 0, 2, 3], [(0, 1), (1, 1), (1, 0), (0, 0)])
    scene = test.path("plate.glb")
    write_bodies(scene, [("plate", plate, [1, 1, 1], 1, {"translation": [0, 10, 0]}), ("ball", sphere((30, 10, 0), 3), [1, 1, 1], 2, {})])
    folder = os.path.join(test.folder, "pictures")
    os.mkdir(folder)
    write_png(os.path.join(folder, "red.png"), (200, 20, 20))
    write_png(os.path.join(folder, "green.png"), (20, 200, 20))
    write_png(os.path.join(test.folder, "rough.png"), (0, 255, 0))
    text = "materials: {plate: {base_color_texture: {folder: pictures}, roughness_texture: rough.png, base_color: [[0.5, 1], 1, 1]}}\n"
    out = test.path("textures")
    draw(test, out, "--format", "folder", text=text, inputs=[scene])
    seen, lookup = set(), {}
    for frame, line in enumerate(lines_of(out)):
        at = os.path.join(out, "00_front", f"{frame:06}.")
        drawn, factor = line["drawn"]["materials.plate.base_color_texture"], line["drawn"]["materials.plate.base_color"][0]
        mean = read_color(at + "png")[np.load(at + "instance.npy") == 1].mean(0)
        check((mean[0] > 1.5 * mean[1]) == (drawn == "pictures/red.png") and (mean[1] > 1.5 * mean[0]) == (drawn == "pictures/green.png"),
              f"image {frame}: {drawn}, {mean}")
        lookup.setdefault(drawn, []).append((factor, mean[0]))
        check(line["drawn"]["materials.plate.roughness_texture"] == "rough.png", "the only one")
        seen.add(drawn)
    check(len(seen) == 2, f"{seen}")
    red = sorted(lookup["pictures/red.png"])
    check(len(red) < 2 or red[0][1] < red[-1][1], f"the factor multiplies the texture: {red}")
    parts = [test.path(f"texture{i}") for i in (1, 2)]
    for i, part in enumerate(parts, 1):
        draw(test, part, "--format", "folder", "--shard", f"{i}/2", text=text, inputs=[scene])
    joined = test.path("textures joined")
    join(test, *parts, "--out", joined)
    expect_same(joined, out, "joined shards with textures")
    write_png(os.path.join(folder, "blue.png"), (20, 20, 200))
    said = draw(test, out, "--format", "folder", text=text, inputs=[scene], code=1)
    check("another" in said or "other" in said or "there" in said, said)
    with open(os.path.join(test.folder, "bad.png"), "wb") as file:
        file.write(b"no picture")
    for wrong, wanted in (("ball: {base_color_texture: rough.png}", "materials.ball.base_color_texture: its meshes have no texture coordinates"),
                          ("plate: {normal_texture: rough.png}", "materials.plate.normal_texture: the material has no normal map"),
                          ("plate: {base_color_texture: none.png}", "randomize.yaml:1: materials.plate.base_color_texture: "),
                          ("plate: {base_color_texture: bad.png}", "randomize.yaml:1: materials.plate.base_color_texture: "),
                          ("plate: {base_color_texture: plate.glb}", "is of no kind that can be read here"),
                          ("plate: {base_color_texture: {folder: nowhere}}", "the folder \"nowhere\" cannot be read")):
        said = draw(test, test.path("bad"), "--format", "coco", text="materials: {" + wrong + "}", inputs=[scene], code=1)
        check(wanted in said and not os.path.exists(test.path("bad")), said)


def turned(quaternion, point):
    x, y, z, w = quaternion
    axis = np.array([x, y, z])
    return point + 2 * np.cross(axis, np.cross(axis, point) + w * np.array(point))


def distractors_settle(test):
    """A ball and boxes fall onto a floor, whose top is at -18: they rest on it or on each other, whatever draws them."""
    scene, half, floor = test.path("floor.glb"), {"clutter/a.glb": 4.0, "clutter/b.glb": 2.0}, -18
    write_bodies(scene, [("ball", sphere((0, 0, 0), 3.0), [0.8, 0.8, 0.8], 1, {"translation": [0, 10, 0]}),
                         ("floor", cube((0, 0, 0), 1), [0.5, 0.5, 0.5], 2, {"translation": [0, -20, 0], "scale": [80, 2, 80]})])
    os.mkdir(os.path.join(test.folder, "clutter"))
    for file, size in half.items():
        write_bodies(os.path.join(test.folder, file), [("box", cube((0, 0, 0), size), [0.2, 0.3, 0.8], 9, {})])
    text = """
nodes: {ball: {move_m: [[-15, 15], [0, 10], [-15, 15]], settle: true}}
distractors:
  files: {folder: clutter}
  copies: 2
  count: [0, 4]
  position_m: [[-20, 20], [-5, 25], [-20, 20]]
  rotation: uniform
  scale: [0.5, 1]
  settle: true
"""
    out = test.path("settled")
    draw(test, out, "--format", "folder", text=text, inputs=[scene])
    counts, lowest = set(), []
    for line in lines_of(out):
        drawn = line["drawn"]
        shown = [name[:-len("visible")] for name, value in drawn.items() if name.endswith(".visible") and value]
        check(len(shown) == drawn["distractors.count"] and len([n for n in drawn if n.endswith(".visible")]) == 4, f"{drawn}")
        counts.add(len(shown))
        titles = [f"distractors.{file}#{copy}." for file in half for copy in (1, 2)]
        order = sorted(titles, key=lambda title: uniforms(SEED, line["frame"], title + "order", 1))
        check(set(shown) == set(order[:len(shown)]), f"image {line['frame']} shows {shown}, and the order is {order}")
        ball = np.array(drawn["nodes.ball.settled_m"])
        check(ball[1] > floor + 3 - 0.05 and (shown or abs(ball[1] - floor - 3) < 0.05), f"the ball is at {ball}")
        for name in shown:
            size = half[name[len("distractors."):-len("#1.")]] * drawn[name + "scale"]
            corners = [turned(drawn[name + "settled_rotation"], size * np.array([x, y, z])) + drawn[name + "settled_m"]
                       for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
            lowest.append((min(corner[1] for corner in corners) - floor) / size)
        seen = {each["instance"]: each for each in line["instances"]}
        check(set(seen) <= {1, 2}, f"distractors have labels: {seen}")
        if 1 in seen:  # in view
            place = np.reshape(line["cam_R_w2c"], (3, 3)) @ ball * 1000 + line["cam_t_w2c"]
            check(np.abs(place - seen[1]["cam_t_m2c"]).max() < 1, f"the label of the ball: {seen[1]['cam_t_m2c']}, not {place}")
    check(len(counts) > 1 and lowest and min(lowest) > -0.03 and min(np.abs(lowest)) < 0.03, f"counts {counts}, lowest corners {lowest}")
    parts = [test.path(f"settled{i}") for i in (1, 2, 3)]
    for i, part in enumerate(parts, 1):
        draw(test, part, "--format", "folder", "--shard", f"{i}/3", text=text, inputs=[scene])
    joined = test.path("settled joined")
    join(test, *parts, "--out", joined)
    expect_same(joined, out, "joined shards with physics")
    again = test.path("settled again")
    draw(test, again, "--format", "folder", "--draws", os.path.join(out, "frames.jsonl"), text=text, seed=99, inputs=[scene])
    labels = lambda line: {key: line[key] for key in ("frame", "drawn", "cam_R_w2c", "instances")}
    check([labels(line) for line in lines_of(again)] == [labels(line) for line in lines_of(out)], "given draws have settled poses")
    said = draw(test, test.path("labelled"), "--format", "coco", text=text + "  labels: true\n", images=2, inputs=[scene])
    with open(os.path.join(test.path("labelled"), "dataset.json"), encoding="utf-8") as file:
        names = [each["path"] for each in json.load(file)["instances"]]
    check(len(names) == 6 and sum("distractor" in name for name in names) == 4, f"{names}")
    said = draw(test, test.path("fallen"), "--format", "coco", text="nodes: {ball: {settle: true}, floor: {visible: 0}}", images=1, inputs=[scene])
    check("nodes.ball.settle: the node falls out of the scene" in said, said)
    for wrong, wanted in (("{count: 1}", "distractors: needs files"), ("{files: ball.glb, count: 1, copies: [1, 2]}", "copies must be a whole number"),
                          ("{files: none.glb, count: 1}", "randomize.yaml:1: distractors.files: "),
                          ("{files: ball.glb, count: 1, settle: 1}", "distractors.settle: must be true or false")):
        said = draw(test, test.path("bad"), "--format", "coco", text="distractors: " + wrong, inputs=[scene], code=1)
        check(wanted in said, said)


def bad_input(test):
    for text, wanted in (("nodes: {ball: {size: 2}}", "randomize.yaml:1: nodes.ball.size: no such field of nodes"),
                         ("\nnodes:\n  ball: {scale: [3, 2]}", "randomize.yaml:3: nodes.ball.scale: [3, 2] is no range"),
                         ("nodes: {bal: {scale: 2}}", "nodes: no node has the name \"bal\""),
                         ("cameras: {side: {look_at: ball}}", "cameras: no camera of the set has the name \"side\""),
                         ("cameras: {front: {path: none.txt}}", "randomize.yaml:1: path: "),
                         ("cameras: {front: {look_at: bal}}", "cameras.front.look_at: the scene has no single node \"bal\"")):
        said = draw(test, test.path("bad"), "--format", "coco", text=text, code=1)
        check(wanted in said, said)
    for arguments, wanted in ((("--seed", 1), "--seed is for --randomize"), (("--images", 3), "--images is for --randomize")):
        said = run(test, test.path("bad"), "--format", "coco", *arguments, inputs=[ball_scene(test)], code=2)
        check(wanted in said, said)
    said = draw(test, test.path("bad"), "--format", "coco", inputs=[recording(test), scene_of(test)], code=2)
    check("--images is for a scene at rest" in said, said)


if __name__ == "__main__":
    main({"draws": images_show_their_draws, "parts": parts_are_the_whole, "noise": colours_have_noise_and_exposure,
          "recording": recordings_keep_their_poses, "example": the_example_runs,
          "path": cameras_follow_a_path, "variants": variants_are_drawn, "maps": maps_are_drawn, "programs": programs_draw, "textures": textures_are_drawn,
          "settled": distractors_settle, "bad_input": bad_input}, ("fire3dv", "make"))
