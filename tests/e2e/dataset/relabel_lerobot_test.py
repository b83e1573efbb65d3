#!/usr/bin/env python3
"""End-to-end test of `fire3dv relabel` with joint positions of LeRobot data sets. The oracle is forward kinematics in NumPy."""
import json
import os
import random
import struct

import numpy as np

from harness import Program, check, main, vulkan_environment
from label_readers import read_json
from parquet_reader import read_parquet
from parquet_writer import Long, compact, varint, write_parquet
from relabel_test import matrix, poses_of, quaternion, relabel

URDF = """<robot name="arm">
  <link name="base"><visual><geometry><box size="0.2 0.2 0.1"/></geometry></visual></link>
  <link name="arm"><visual><geometry><box size="0.3 0.05 0.05"/></geometry></visual></link>
  <link name="tool"><visual><geometry><box size="0.05 0.05 0.1"/></geometry></visual></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.5"/><axis xyz="0 0 1"/>
    <limit lower="-4" upper="4" effort="1" velocity="1"/></joint>
  <joint name="lift" type="prismatic"><parent link="arm"/><child link="tool"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>
"""
FPS, EPISODES, ROWS = 25, 5, 40


def urdf_of(test):
    path = test.path("arm.urdf")
    with open(path, "w", encoding="utf-8") as file:
        file.write(URDF)
    return path


def states(episode):
    """turn in degrees, a gripper of no joint, and lift."""
    t = np.arange(ROWS) / FPS + episode
    return np.stack((100 * np.sin(t), 50 + 0 * t, 0.1 * np.cos(3 * t)), 1)


def write_set(folder, version="v3.0", names=("turn.pos", "gripper.pos", "lift.pos"), table=None, **options):
    """Episodes 0 and 1 in one file, the others in a second one. table: rows of each episode."""
    table = table or [states(episode) for episode in range(EPISODES)]
    os.makedirs(os.path.join(folder, "meta", "episodes", "chunk-000"))
    os.makedirs(os.path.join(folder, "data", "chunk-000"))
    width = table[0].shape[1]
    info = {"codebase_version": version, "fps": FPS, "total_episodes": len(table), "chunks_size": 1000,
            "features": {"observation.state": {"dtype": "float32", "shape": [width], "names": names}}}
    with open(os.path.join(folder, "meta", "info.json"), "w", encoding="utf-8") as file:
        json.dump(info, file)

    def columns(episodes):
        rows = {"episode_index": ("q", []), "frame_index": ("q", []), "timestamp": ("f", []), "observation.state": ("f", [])}
        for episode in episodes:
            for frame, row in enumerate(table[episode]):
                for name, value in zip(rows, (episode, frame, frame / FPS, [float(np.float32(each)) for each in row])):
                    rows[name][1].append(value)
        return rows

    if version.startswith("v2"):
        for episode in range(len(table)):
            write_parquet(os.path.join(folder, "data", "chunk-000", f"episode_{episode:06}.parquet"), columns([episode]), **options)
        return folder
    parts = [range(len(table))[:2], range(len(table))[2:]] if len(table) > 2 else [range(len(table))]
    for i, part in enumerate(parts):
        write_parquet(os.path.join(folder, "data", "chunk-000", f"file-{i:03}.parquet"), columns(part), **options)
        write_parquet(os.path.join(folder, "meta", "episodes", "chunk-000", f"file-{i:03}.parquet"),
                      {"episode_index": ("q", list(part)), "length": ("q", [ROWS] * len(part)), "data/chunk_index": ("q", [0] * len(part)),
                       "data/file_index": ("q", [i] * len(part))}, codec="snappy")
    return folder


def expect_poses(recording, turn_rad, lift_m):
    names, _, frames = poses_of(recording)
    check(sorted(names) == ["arm", "base", "tool"] and len(frames) == len(turn_rad), f"{names}, {len(frames)} frames")
    worst = 0
    for i, (time_ns, poses) in enumerate(frames):
        check(time_ns == round(i * 1e9 / FPS), f"{time_ns} ns is frame {i}")
        arm = matrix([0, 0, 0.5], quaternion((0, 0, 1), turn_rad[i]))
        wanted = {"base": np.eye(4), "arm": arm, "tool": arm @ matrix([0.3, 0, lift_m[i]], [0, 0, 0, 1])}
        for name, pose in zip(names, poses):
            worst = max(worst, np.abs(pose - wanted[name][:3]).max())
    check(worst < 1e-6, f"poses differ by {worst}")


def poses_are_those_of_the_joints(test):
    """All codecs, encodings and versions give the same poses."""
    scene = urdf_of(test)
    for i, (version, options) in enumerate((("v3.0", {"codec": "snappy", "dictionary": True}), ("v3.0", {"codec": "zstd", "pages": 2}),
                                            ("v3.1", {"split": True, "codec": "gzip", "group_rows": 30}), ("v2.1", {"codec": "snappy"}),
                                            ("v3.0", {"page_rows": 7, "group_rows": 50, "codec": "snappy"}), ("v2.0", {}))):
        folder, recording = write_set(test.path(f"set{i}"), version, **options), test.path(f"{i}.mcap")
        said = relabel(test, folder, scene, "--episode", 3, "--joint-unit", "deg", "--out", recording)
        table = np.float32(states(3)).astype(float)
        expect_poses(recording, np.radians(table[:, 0]), table[:, 2])
        check('numbers that are no joints of the scene: "gripper.pos"' in said and f"{ROWS} frames of 3 nodes" in said and "states of episode 3 of 5" in said,
              said)


def names_are_mapped(test):
    scene, table = urdf_of(test), [states(0)[:, (0, 2)]]
    turn, lift = np.float32(table[0]).astype(float).T
    for i, (names, arguments, reason) in enumerate(((None, (), "numbers without names are the robot's positions in order"), (["turn", "lift"], (), None),
                                                    ({"motors": ["left_turn", "left_lift"]}, ("--prefix", "left_"), None))):
        said = relabel(test, write_set(test.path(f"set{i}"), names=names, table=table), scene, "--joint-unit", "deg", *arguments, "--out",
                       test.path(f"{i}.mcap"))
        expect_poses(test.path(f"{i}.mcap"), np.radians(turn), lift)
        check(reason is None or reason in said, said)
    said = relabel(test, write_set(test.path("lift"), names=["x", "lift"], table=table), scene, "--out", test.path("lift.mcap"))
    check('joints without positions stay as in the scene: "turn"' in said and 'no joints of the scene: "x"' in said, said)
    expect_poses(test.path("lift.mcap"), 0 * turn, lift)


def our_own_set_comes_back(test):
    """States that --format lerobot has written move the same robot to the same poses."""
    scene, first, again, folder = urdf_of(test), test.path("first.mcap"), test.path("again.mcap"), test.path("ours")
    relabel(test, write_set(test.path("set"), codec="snappy"), scene, "--episode", 1, "--joint-unit", "deg", "--out", first)
    program = Program(test, "dataset", [test.programs_at["fire3dv"], "dataset", first, scene, "--format", "lerobot", "--rate", str(FPS), "--end", "0.3",
                                        "--camera", "auto", "--size", "32x32", "--samples", "1", "--shadows", "off", "--cache", "off", "--out", folder],
                      vulkan_environment())
    program.expect_exit()
    info = read_json(os.path.join(folder, "meta", "info.json"))
    check(info["features"]["observation.state"]["names"] == ["turn", "lift"], f"{info['features']['observation.state']}")
    columns, _ = read_parquet(os.path.join(folder, "data", "chunk-000", "file-000.parquet"))
    table = np.float32(states(1)).astype(float)[:8]
    state = np.array(columns["observation.state"])
    check(np.abs(state - np.stack((np.radians(table[:, 0]), table[:, 2]), 1)).max() < 1e-6, f"{state}")
    relabel(test, folder, scene, "--out", again)
    expect_poses(again, np.radians(table[:, 0]), table[:, 2])


def a_wrong_choice_is_named(test):
    scene, out = urdf_of(test), test.path("no.mcap")
    folder = write_set(test.path("set"))

    def expect(reason, *arguments, at=folder, to=scene):
        said = relabel(test, at, to, *arguments, "--out", out, code=1)
        check(reason in said, said)

    expect("it has 5 episodes, 0 to 4: choose one by --episode")
    expect("it has 5 episodes, 0 to 4, and not 5: choose one by --episode", "--episode", 5)
    expect('no number of it is a joint of the scene: "a", "b"; the scene\'s joints are "turn", "lift"',
           at=write_set(test.path("names"), names=["a", "b"], table=[states(0)[:, :2]]))
    expect('two of its numbers are of "turn"', at=write_set(test.path("twice"), names=["turn", "turn.pos"], table=[states(0)[:, :2]]))
    expect("rows have 2 numbers, and meta/info.json has 3 names", at=write_set(test.path("few"), table=[states(0)[:, :2]]))
    expect("its numbers have no names, and rows have 3 of them", at=write_set(test.path("unnamed"), names=None, table=[states(0)]))
    expect("its compression is LZ4 raw; Snappy, gzip and Zstandard are read", at=write_set(test.path("lz4"), table=[states(0)], codec="lz4"))
    expect('version "v1.6" is not read', at=write_set(test.path("old"), version="v1.6", table=[states(0)]))
    expect('the position of joint "turn" is not finite', at=write_set(test.path("nan"), table=[states(0) * np.nan]))
    os.remove(os.path.join(folder, "data", "chunk-000", "file-001.parquet"))
    expect("file-001.parquet", "--episode", 4)
    check(not os.path.exists(out), "a file of a failed import")


def runs_file(groups, rows, shared):
    """Episodes' Parquet with a run of one number in each group; shared: all groups have the same bytes."""
    page = b"\1" + varint(rows << 1) + b"\0"
    pages = (compact({1: 2, 2: 8, 3: 8, 7: {1: 1, 2: 0}})[1] + struct.pack("<q", 7) +
             compact({1: 0, 2: len(page), 3: len(page), 5: {1: rows, 2: 8, 3: 4, 4: 4}})[1] + page)
    body = b"PAR1" + pages * (1 if shared else groups)
    chunks = [compact({1: [{3: {4: 0, 5: Long(rows), 7: Long(len(pages)), 9: Long(4 + (0 if shared else i) * len(pages))}}], 3: Long(rows)})[1]
              for i in range(groups)]
    footer = bytes([0x29, 0x2C]) + compact({4: "r", 5: 1})[1] + compact({1: 2, 3: 0, 4: "episode_index"})[1]
    footer += bytes([0x29, 0xFC]) + varint(groups) + b"".join(chunks) + b"\0"
    return body + footer + struct.pack("<I", len(footer)) + b"PAR1"


def small_files_cost_little(test):
    """Files of few bytes that claim much work."""
    scene, folder, out = urdf_of(test), write_set(test.path("set"), table=[states(0)]), test.path("no.mcap")
    flags = b"\x1b" + varint(1 << 62) + b"\x11\0"  # a map of booleans
    for content, reason in ((b"PAR1" + flags + struct.pack("<I", len(flags)) + b"PAR1", "its metadata is damaged"),
                            (runs_file(9999, 1 << 25, True), "its columns have more bytes than the file"),
                            (runs_file(99, 1 << 25, False), 'column "episode_index": the columns that are read have more than 4 GiB')):
        with open(os.path.join(folder, "meta/episodes/chunk-000/file-000.parquet"), "wb") as file:
            file.write(content)
        said = relabel(test, folder, scene, "--out", out, code=1)
        check(reason in said and not os.path.exists(out), said)


def hostile_files_end(test):
    scene, folder = urdf_of(test), write_set(test.path("set"), table=[states(0)], codec="snappy", dictionary=True)
    chance = random.Random(3)
    for i in range(12):
        name = ("data/chunk-000/file-000.parquet", "meta/episodes/chunk-000/file-000.parquet", "meta/info.json")[i % 3]
        path, out = os.path.join(folder, name), test.path(f"{i}.mcap")
        with open(path, "rb") as file:
            whole = file.read()
        damaged = bytearray(whole[:chance.randrange(len(whole))] if i % 4 == 0 else whole)
        for _ in range(chance.randrange(1, 20)):
            damaged[chance.randrange(4, len(damaged))] = chance.randrange(256)
        with open(path, "wb") as file:
            file.write(damaged)
        program = Program(test, "relabel", [test.programs_at["fire3dv"], "relabel", folder, scene, "--out", out, "--cache", "off"], vulkan_environment())
        code = program.wait()
        check(code in (0, 1) and (code == 0) == os.path.exists(out), f"exit status {code}: {program.stderr_text()}")
        with open(path, "wb") as file:
            file.write(whole)


if __name__ == "__main__":
    main({"poses": poses_are_those_of_the_joints, "names": names_are_mapped, "own": our_own_set_comes_back, "choices": a_wrong_choice_is_named,
          "hostile": hostile_files_end, "costly": small_files_cost_little}, ("fire3dv",))
