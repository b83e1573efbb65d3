"""Readers and checkers of data sets by NumPy alone, from the documentation of the formats."""
import json
import os
import struct

import numpy as np

from image_reader import check, png_parts, read_png


def read_json(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def read_gray(path):
    """Pixels of a grey PNG of 8 or 16 bits, with the filters None and Up."""
    (width, height, depth, colour, *_, interlaced), raw, _ = png_parts(path)
    check(colour == 0 and depth in (8, 16) and not interlaced, f"{path}: no grey PNG")
    rows = np.frombuffer(raw, np.uint8).reshape(height, 1 + width * depth // 8)
    pixels = rows[:, 1:].copy()
    check(set(rows[:, 0]) <= {0, 2}, f"{path}: filters {set(rows[:, 0])}")
    for y in range(1, height):
        if rows[y, 0] == 2:
            pixels[y] += pixels[y - 1]
    return pixels if depth == 8 else pixels.reshape(height, -1).view(">u2").astype(np.uint16)


def read_color(path):
    picture = read_png(path)
    return np.frombuffer(b"".join(picture.rows), np.uint8).reshape(picture.height, picture.width, 3)


def read_ply(path):
    """Vertices (n, 6) and triangles (m, 3) of a binary PLY."""
    with open(path, "rb") as file:
        data = file.read()
    header, body = data.split(b"end_header\n", 1)
    counts = {line.split()[1]: int(line.split()[2]) for line in header.decode().splitlines() if line.startswith("element")}
    vertices = np.frombuffer(body, "<f4", 6 * counts["vertex"]).reshape(-1, 6)
    faces = np.frombuffer(body, [("n", "u1"), ("v", "<i4", 3)], offset=24 * counts["vertex"])
    check(len(faces) == counts["face"] and (faces["n"] == 3).all(), f"{path}: faces")
    return vertices, faces["v"]


def read_tiff(path):
    """Pixels of an uncompressed TIFF of 16 bits with one strip."""
    with open(path, "rb") as file:
        data = file.read()
    check(data[:4] == b"II*\0", f"{path}: no TIFF")
    (at,) = struct.unpack_from("<I", data, 4)
    (count,) = struct.unpack_from("<H", data, at)
    tags = {}
    for i in range(count):
        tag, kind, values, value = struct.unpack_from("<HHII", data, at + 2 + 12 * i)
        check(kind in (3, 4) and (not tags or tag > max(tags)), f"{path}: tag {tag}")
        tags[tag] = struct.unpack_from(f"<{values}H", data, value) if values > 1 else (value,)
    (width,), (height,), (first,), (size,), (channels,) = (tags[tag] for tag in (256, 257, 273, 279, 277))
    check(tags[258] == (16,) * channels and tags[259] == (1,) and tags[262] == (2 if channels == 3 else 1,), f"{path}: {tags}")
    check(size == 2 * width * height * channels and first + size == len(data), f"{path}: {tags}")
    pixels = np.frombuffer(data, "<u2", size // 2, first)
    return pixels.reshape((height, width) if channels == 1 else (height, width, channels))


def decode_rle(segmentation):
    """Mask of COCO's compressed run lengths, from the description in its API."""
    counts, text, at = [], segmentation["counts"].encode(), 0
    while at < len(text):
        value, shift, more = 0, 0, True
        while more:
            bits = text[at] - 48
            at += 1
            value |= (bits & 31) << shift
            shift += 5
            more = bits & 32
            if not more and bits & 16:
                value -= 1 << shift
        counts.append(value + (counts[-2] if len(counts) > 2 else 0))
    height, width = segmentation["size"]
    flat = np.repeat(np.arange(len(counts)) % 2, counts).astype(bool)
    check(len(flat) == height * width, f"{len(flat)} pixels in a mask")
    return flat.reshape((height, width), order="F")


def box_of(mask):
    """Left, top, width, height in pixels."""
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    return [int(columns[0]), int(rows[0]), int(columns[-1] - columns[0] + 1), int(rows[-1] - rows[0] + 1)]


def pixels_of(k, points):
    """Pixels (n, 2) of points (n, 3) in the camera's axes; the first pixel's centre is (0, 0)."""
    projected = points @ np.reshape(k, (3, 3)).T
    return projected[:, :2] / projected[:, 2:]


def points_of(k, depth):
    """Points (h, w, 3) in the camera's axes, of depths along its axis."""
    v, u = np.mgrid[:depth.shape[0], :depth.shape[1]]
    rays = np.dstack([u, v, np.ones_like(u)]) @ np.linalg.inv(np.reshape(k, (3, 3))).T
    return rays * depth[..., None]


class BopImage:
    """Image of a BOP scene with its labels; lengths in millimetres."""

    def __init__(self, scene, number):
        self.scene, self.number = scene, number
        key = str(number)
        self.camera, self.poses, self.infos = (read_json(os.path.join(scene, f"{name}.json"))[key]
                                               for name in ("scene_camera", "scene_gt", "scene_gt_info"))
        self.k = np.reshape(self.camera["cam_K"], (3, 3))
        self.depth = read_gray(os.path.join(scene, "depth", f"{number:06}.png")) * self.camera["depth_scale"]

    def mask(self, kind, gt):
        return read_gray(os.path.join(self.scene, kind, f"{self.number:06}_{gt:06}.png")) > 0

    @property
    def color(self):
        return read_color(os.path.join(self.scene, "rgb", f"{self.number:06}.png"))


def check_models(folder):
    infos = read_json(os.path.join(folder, "models", "models_info.json"))
    names = sorted(os.listdir(os.path.join(folder, "models")))
    check(names == sorted([f"obj_{int(key):06}.ply" for key in infos] + ["models_info.json"]), f"models: {names}")
    for key, info in infos.items():
        vertices, faces = read_ply(os.path.join(folder, "models", f"obj_{int(key):06}.ply"))
        points = vertices[:, :3].astype(float)
        low, size = points.min(0), np.ptp(points, 0)
        wanted = [info[f"min_{axis}"] for axis in "xyz"], [info[f"size_{axis}"] for axis in "xyz"]
        check(np.allclose(low, wanted[0], rtol=1e-5, atol=1e-3) and np.allclose(size, wanted[1], rtol=1e-5, atol=1e-3), f"object {key}: {info}")
        diameter = max(np.linalg.norm(points - point, axis=1).max() for point in points)
        check(abs(diameter - info["diameter"]) < 1e-4 * diameter, f"object {key}: {diameter} is not {info['diameter']}")
        corners = points[faces]
        outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        check((np.einsum("ij,ij->i", outward, vertices[faces, 3:].mean(1)) >= 0).all(), f"object {key}: triangles are turned")
    return infos


def check_bop(folder, split="train"):
    """The rules of BOP's description of its format, for all images. Returns the number of labelled instances."""
    infos = check_models(folder)
    camera = read_json(os.path.join(folder, "camera.json"))
    check(set(camera) == {"cx", "cy", "depth_scale", "fx", "fy", "height", "width"}, f"camera.json: {camera}")
    labels = 0
    for scene in sorted(os.listdir(os.path.join(folder, split))):
        check(len(scene) == 6 and scene.isdigit(), scene)
        at = os.path.join(folder, split, scene)
        cameras, poses, gt_infos = (read_json(os.path.join(at, f"{name}.json")) for name in ("scene_camera", "scene_gt", "scene_gt_info"))
        numbers = sorted(map(int, cameras))
        check(set(cameras) == set(poses) == set(gt_infos) and numbers, f"{scene}: other images in other lists")
        files = {kind: sorted(os.listdir(os.path.join(at, kind))) for kind in ("rgb", "depth", "mask", "mask_visib")}
        masks = [f"{number:06}_{gt:06}.png" for number in numbers for gt in range(len(poses[str(number)]))]
        check(files["rgb"] == files["depth"] == [f"{number:06}.png" for number in numbers], f"{scene}: {files['rgb']}")
        check(files["mask"] == files["mask_visib"] == masks, f"{scene}: masks")
        for number in numbers:
            image = BopImage(at, number)
            labels += check_bop_image(image, camera, infos)
    return labels


def check_bop_image(image, camera, infos):
    height, width = image.depth.shape
    check((width, height) == (camera["width"], camera["height"]) and image.color.shape[:2] == image.depth.shape, "sizes")
    check(len(image.poses) == len(image.infos), "poses and infos")
    rotation = np.reshape(image.camera["cam_R_w2c"], (3, 3))
    check(np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6), f"R_w2c: {rotation}")
    union = np.zeros(image.depth.shape, bool)
    for gt, (pose, info) in enumerate(zip(image.poses, image.infos)):
        rotation = np.reshape(pose["cam_R_m2c"], (3, 3))
        check(np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-5) and np.linalg.det(rotation) > 0, f"R_m2c: {rotation}")
        check(str(pose["obj_id"]) in infos and len(pose["cam_t_m2c"]) == 3 and pose["cam_t_m2c"][2] > -infos[str(pose["obj_id"])]["diameter"], f"{pose}")
        whole, visible = image.mask("mask", gt), image.mask("mask_visib", gt)
        check(not (visible & ~whole).any() and not (visible & union).any(), "masks")
        union |= visible
        check(info["px_count_all"] == whole.sum() and info["px_count_visib"] == visible.sum(), f"{info}")
        check(info["px_count_valid"] == (whole & (image.depth > 0)).sum(), f"{info}: valid")
        check(abs(info["visib_fract"] - visible.sum() / whole.sum()) < 1e-9, f"{info}: share")
        check(info["bbox_obj"] == box_of(whole), f"{info} is not {box_of(whole)}")
        check(info["bbox_visib"] == (box_of(visible) if visible.any() else [-1] * 4), f"{info}: visible")
    return len(image.poses)
