"""Reader of BOP data sets by NumPy alone: colour images and the poses and boxes of one object."""
import json
import os
import struct
import zlib

import numpy as np


def read_png(path):
    """Pixels (height, width, channels) uint8 of a PNG of 8 bits without interlacing, whose rows have the filters None, Sub and Up."""
    with open(path, "rb") as file:
        data = file.read()
    at, parts, header = 8, [], None
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            parts.append(body)
        at += 12 + length
    width, height, depth, color, _, _, interlaced = header or (0,) * 7
    channels = {0: 1, 2: 3, 6: 4}.get(color, 0)
    if data[:8] != b"\x89PNG\r\n\x1a\n" or depth != 8 or channels == 0 or interlaced:
        raise ValueError(f"{path} is no PNG of 8 bits that this reader knows; fire3dv dataset writes such")
    raw = np.frombuffer(zlib.decompress(b"".join(parts)), np.uint8).reshape(height, 1 + width * channels)
    filters, rows = raw[:, 0], raw[:, 1:].reshape(height, width, channels).copy()
    if not set(filters) <= {0, 1, 2}:
        raise ValueError(f"{path} has filters {sorted(set(filters))}; this reader knows 0, 1 and 2")
    for y in range(height):
        if filters[y] == 1:
            rows[y] = np.cumsum(rows[y], axis=0, dtype=np.uint8)
        elif filters[y] == 2 and y > 0:
            rows[y] += rows[y - 1]
    return rows


def _json(*path):
    with open(os.path.join(*path), encoding="utf-8") as file:
        return json.load(file)


def objects(folder):
    """Numbers of objects by the name of a node that has them."""
    return {each["name"]: each["obj_id"] for each in _json(folder, "dataset.json")["instances"]}


def vertices(folder, number):
    """Vertices (n, 3) of a model in millimetres."""
    with open(os.path.join(folder, "models", f"obj_{number:06}.ply"), "rb") as file:
        header, body = file.read().split(b"end_header\n", 1)
    count = next(int(line.split()[2]) for line in header.decode().splitlines() if line.startswith("element vertex"))
    return np.frombuffer(body, "<f4", 6 * count).reshape(-1, 6)[:, :3].astype(float)


def labels(folder, number, least_visible=0.0, split="train"):
    """Images of all scenes that show the object: its file, camera matrix, box of the visible part (left, top, width, height in
    pixels), visible share, and pose from the model to the camera in millimetres."""
    found = []
    for scene in sorted(os.listdir(os.path.join(folder, split))):
        at = os.path.join(folder, split, scene)
        cameras, poses, infos = (_json(at, f"{name}.json") for name in ("scene_camera", "scene_gt", "scene_gt_info"))
        for image in sorted(poses, key=int):
            for each, info in zip(poses[image], infos[image]):
                if each["obj_id"] != number or info["px_count_visib"] == 0 or info["visib_fract"] < least_visible:
                    continue
                found.append({"file": os.path.join(at, "rgb", f"{int(image):06}.png"), "k": np.reshape(cameras[image]["cam_K"], (3, 3)),
                              "box": info["bbox_visib"], "visible": info["visib_fract"], "rotation": np.reshape(each["cam_R_m2c"], (3, 3)),
                              "translation": np.array(each["cam_t_m2c"])})
    return found
