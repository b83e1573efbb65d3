"""Checks of LeRobot data sets: Parquet by Python alone and by npm's hyparquet, videos by the program ffmpeg, and what
lerobot.datasets (version 0.6) reads from them."""
import json
import os
import shutil
import subprocess

import numpy as np

from dataset_runs import METRE, command_of, join, lines_of, names_of, run, scene_of
from dataset_test import expect_on_cube
from harness import HANG_S, Program, check, vulkan_environment
from label_readers import decode_rle, pixels_of, read_color, read_gray, read_json
from label_scene import CENTRES, CUBE_HALF, SIZE
from parquet_reader import read_parquet

#: Environment variable with the folder node_modules that holds npm's hyparquet.
MODULES = "FIRE3DV_PARQUET_NODE_MODULES"
HYPARQUET = """
import { readFileSync } from "node:fs";
const { parquetReadObjects } = await import(process.argv[1] + "/hyparquet/src/index.js");
const data = readFileSync(process.argv[2]);
const file = data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength);
const rows = await parquetReadObjects({ file });
console.log(JSON.stringify(rows, (key, value) => typeof value === "bigint" ? Number(value) : value));
"""
DEPTH_MAX_CODE = 4095
UNIT_MM = 50.0  # to 204.75 m


def read_table(path):
    """Columns by name; also as hyparquet reads them, if it is there."""
    columns, metadata = read_parquet(path)
    modules, node = os.environ.get(MODULES), shutil.which("node")
    if modules and node:
        done = subprocess.run([node, "--input-type=module", "-e", HYPARQUET, os.path.abspath(modules), path], capture_output=True, text=True,
                              timeout=HANG_S, check=False)
        check(done.returncode == 0, done.stderr)
        rows = json.loads(done.stdout)
        check(list(rows[0]) == list(columns), f"hyparquet: columns {list(rows[0])}")
        for name, values in columns.items():
            check([row[name] for row in rows] == values, f"hyparquet: {name} of {path}")
    else:
        print(f"left out: hyparquet ({MODULES} names the node_modules with it)", flush=True)
    return columns, metadata


def decode_video(path, pixel_format, shape, kind):
    """Frames of a video, and what the program ffprobe says of it."""
    done = subprocess.run(["ffmpeg", "-v", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", pixel_format, "-"], capture_output=True,
                          timeout=HANG_S, check=False)
    check(done.returncode == 0 and not done.stderr, f"{path}: {done.stderr}")
    said = subprocess.run(["ffprobe", "-v", "error", "-show_entries", "stream=codec_name,pix_fmt,r_frame_rate,width,height:packet=pts_time,flags",
                           "-of", "json", path], capture_output=True, timeout=HANG_S, check=True)
    return np.frombuffer(done.stdout, kind).reshape(-1, *shape), json.loads(said.stdout)


def dequantize(codes, info):
    """lerobot.datasets.depth_utils.dequantize_depth, in metres."""
    low, high, shift = info["video.depth_min"], info["video.depth_max"], info["video.shift"]
    if not info["video.use_log"]:
        return low + codes * (high - low) / DEPTH_MAX_CODE
    return np.exp(np.log(low + shift) + codes * (np.log(high + shift) - np.log(low + shift)) / DEPTH_MAX_CODE) - shift


def expect_statistics(values, stats, what, shape):
    """numpy's own of the rows (n, components)."""
    values = np.asarray(values, float).reshape(len(values), -1)
    wanted = {"min": values.min(0), "max": values.max(0), "mean": values.mean(0), "std": values.std(0)}
    wanted |= {f"q{q:02}": np.quantile(values, q / 100, axis=0) for q in (1, 10, 50, 90, 99)}
    for name, numbers in wanted.items():
        own = np.array(stats[name])
        check(own.shape == shape and np.allclose(own.ravel(), numbers, rtol=1e-5, atol=1e-6), f"{what}: {name} is {own.ravel()}, not {numbers}")


def check_set(folder, fps, frames):
    """Layout and contents of a whole set. Returns info.json, the columns of the frames, and depth in metres by key."""
    info, stats = read_json(os.path.join(folder, "meta", "info.json")), read_json(os.path.join(folder, "meta", "stats.json"))
    check(info["codebase_version"] == "v3.0" and info["fps"] == fps and info["total_frames"] == frames and info["total_episodes"] == 1, f"{info}")
    path = os.path.join(folder, info["data_path"].format(chunk_index=0, file_index=0))
    data, _ = read_table(path)
    features = info["features"]
    numbers = [key for key, feature in features.items() if feature["dtype"] != "video"]
    check(list(data) == numbers and set(stats) == set(features), f"{list(data)}")
    for key in numbers:
        (count,) = features[key]["shape"]
        check(all((len(row) if isinstance(row, list) else 1) == count for row in data[key]) and (count > 1) == isinstance(data[key][0], list), key)
        expect_statistics(data[key], stats[key], key, (count,))
        check(stats[key]["count"] == [frames] and (not features[key]["names"] or len(features[key]["names"]) == count), key)
    check(data["index"] == data["frame_index"] == list(range(frames)) and data["episode_index"] == data["task_index"] == [0] * frames, "indices")
    check(np.array_equal(np.float32(data["timestamp"]), np.float32(np.arange(frames) / fps)), f"{data['timestamp']}")

    tasks, metadata = read_table(os.path.join(folder, "meta", "tasks.parquet"))
    pandas = json.loads(metadata["pandas"])
    check(pandas["index_columns"] == ["task"] and [each["name"] for each in pandas["columns"]] == list(tasks), f"{pandas}")
    episodes, _ = read_table(os.path.join(folder, "meta", "episodes", "chunk-000", "file-000.parquet"))
    check(episodes["tasks"] == [tasks["task"]] and tasks["task_index"] == [0] and episodes["length"] == episodes["dataset_to_index"] == [frames],
          f"{tasks}")
    depth = {}
    for key, feature in features.items():
        for name in stats[key]:
            check(episodes[f"stats/{key}/{name}"] == [stats[key][name]], f"stats/{key}/{name} of the episode")
        if feature["dtype"] != "video":
            continue
        check(episodes[f"videos/{key}/from_timestamp"] == [0] and abs(episodes[f"videos/{key}/to_timestamp"][0] - frames / fps) < 1e-9, key)
        path = os.path.join(folder, info["video_path"].format(video_key=key, chunk_index=0, file_index=0))
        is_depth, about = feature["info"]["is_depth_map"], feature["info"]
        height, width, channels = feature["shape"]
        pixels, said = decode_video(path, "gray12le" if is_depth else "rgb24", (height, width, channels), "<u2" if is_depth else np.uint8)
        (stream,) = said["streams"]
        check((stream["codec_name"], stream["pix_fmt"]) == (about["video.codec"], about["video.pix_fmt"]) and stream["r_frame_rate"] == f"{fps}/1"
              and (stream["width"], stream["height"]) == (width, height) == SIZE, f"{stream}")
        check(np.allclose([float(each["pts_time"]) for each in said["packets"]], np.arange(frames) / fps, atol=1e-4), f"{key}: times")
        check(all(each["flags"].startswith("K") for each in said["packets"][::about["video.g"]]), f"{key}: key frames")
        loose = "images/{:02}_" + key.removeprefix("observation.images.").removesuffix("_depth") + "/{:06}"
        camera = [other for other in features if features[other]["dtype"] == "video"].index(key) // 2
        for frame in range(frames):
            begin = os.path.join(folder, loose.format(camera, frame))
            if is_depth:
                check(np.array_equal(pixels[frame, ..., 0], read_gray(begin + ".depth.png")), f"{key}: codes of frame {frame}")
            else:
                check(np.abs(pixels[frame].astype(int) - read_color(begin + ".png")).mean() < 2, f"{key}: colours of frame {frame}")
        if is_depth:
            depth[key] = dequantize(pixels[..., 0].astype(float), about)
            expect_statistics(depth[key].reshape(-1, 1), stats[key], key, (1, 1, 1))
        else:
            lossless = [read_color(os.path.join(folder, loose.format(camera, frame)) + ".png") for frame in range(frames)]
            expect_statistics(np.concatenate(lossless).reshape(-1, 3) / 255, stats[key], key, (3, 1, 1))
        check(stats[key]["count"] == [frames], key)
    return info, data, depth


def lerobot_is_right(test, shards_are_the_whole):
    task = 'Push the "red" cube'
    whole = shards_are_the_whole(test, "lerobot", "--task", task, "--depth-scale", UNIT_MM)
    info, data, depth = check_set(whole, 20, 4)
    check(read_table(os.path.join(whole, "meta", "tasks.parquet"))[0]["task"] == [task], "the task")
    # Steps of --depth-scale, from 0 m.
    about = info["features"]["observation.images.front_depth"]["info"]
    check(not about["video.use_log"] and about["video.depth_min"] == 0 and abs(about["video.depth_max"] - DEPTH_MAX_CODE * UNIT_MM / METRE) < 1e-9, f"{about}")
    lines = lines_of(whole)
    state = np.array(data["observation.state"])
    names = info["features"]["observation.state"]["names"]
    check(state.shape[1] == len(names) and len(names) % 7 == 0 and np.array_equal(data["action"][:-1], data["observation.state"][1:])
          and data["action"][-1] == data["observation.state"][-1], f"{names}")
    for frame in range(4):
        for camera, key in enumerate(("front", "side")):
            line = lines[2 * frame + camera]
            k, pose = data[f"camera.{camera}.intrinsics"][frame], np.reshape(data[f"camera.{camera}.world_from_camera"][frame], (4, 4))
            check(np.allclose(k, line["cam_K"]), f"{k}")
            for each in line["instances"]:
                name = names_of(whole)[each["instance"]]
                mask = decode_rle({"size": [SIZE[1], SIZE[0]], "counts": each["counts"]})
                if name not in ("red", "blue") or not mask.any():
                    continue
                # The state has the node's pose in the world; the depth image lies on the cube at that pose.
                at = names.index(f"{name}.x")
                place, (x, y, z, w) = state[frame, at:at + 3], state[frame, at + 3:at + 7]
                rotation = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
                world = np.eye(4)
                world[:3, :3], world[:3, 3] = rotation, place
                model = np.linalg.inv(pose) @ world
                check(np.allclose(model[:3, :3].ravel(), each["cam_R_m2c"], atol=1e-5) and
                      np.allclose(model[:3, 3] * METRE, each["cam_t_m2c"], atol=0.05), f"{name}: {model}")
                expect_on_cube(k, depth[f"observation.images.{key}_depth"][frame] * METRE, model[:3, :3], model[:3, 3] * METRE, mask,
                               CENTRES[name], name, UNIT_MM)

    # A known point, of the scene at rest, which has no state.
    still = test.path("lerobot still")
    run(test, still, "--format", "lerobot", inputs=[scene_of(test)])
    info, data, depth = check_set(still, 30, 1)
    check("observation.state" not in data and "action" not in data, f"{list(data)}")
    corner = np.linalg.inv(np.reshape(data["camera.0.world_from_camera"][0], (4, 4))) @ [*np.add(CENTRES["red"], CUBE_HALF), 1]
    (line,) = lines_of(still)
    (point,) = [each for each in line["keypoints"] if each["name"] == "front corner"]
    check(np.allclose(pixels_of(data["camera.0.intrinsics"][0], corner[None, :3])[0], point["pixel"], atol=1e-3), f"{point}")

    program = Program(test, "verify", [test.programs_at["fire3dv"], "verify", still, scene_of(test), "--cache", "off"], vulkan_environment())
    program.expect_exit()
    check("".join(program.out).startswith("identical: 1 image"), f"{program.out}")

    for arguments, reason in ((("--rate", "29.97"), "lerobot takes a whole number of frames a second"),):
        said = run(test, test.path("none"), "--format", "lerobot", *arguments, code=2)
        check(reason in said, said)
    said = run(test, test.path("none"), "--format", "coco", "--task", "x", code=2)
    check("--task is for --format lerobot" in said, said)
    words = list(map(str, command_of(test, test.path("none"), "--format", "lerobot")))
    words[words.index("--size") + 1] = "63x64"
    program = Program(test, "dataset", words, vulkan_environment())
    program.expect_exit(1)
    said = program.stderr_text()
    check("have an even number of pixels on each side" in said and not os.path.exists(test.path("none")), said)

    # A part may come from others.
    with open(os.path.join(still, "images", "00_front", "000000.depth.png"), "r+b") as file:
        file.seek(60)
        file.write(b"\0\0\0\0")
    said = join(test, still, "--out", test.path("lerobot joined badly"), code=1)
    check("000000.depth.png is no depth image of this set" in said, said)
