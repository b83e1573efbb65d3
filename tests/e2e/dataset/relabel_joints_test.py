#!/usr/bin/env python3
"""End-to-end test of `fire3dv relabel` with positions of joints in HDF5 files of h5py, as robomimic and LIBERO have them. The
oracle is forward kinematics in NumPy."""
import os
import random

import h5py
import numpy as np

from harness import Program, check, main, vulkan_environment
from relabel_test import matrix, poses_of, quaternion, relabel

MODEL = """<mujoco model="bench">
  <worldbody>
    <geom name="floor" type="box" size="1 1 0.01"/>
    <body name="arm" pos="0 0 0.5">
      <joint name="turn" type="hinge" axis="0 0 1"/>
      <geom type="box" size="0.3 0.05 0.05"/>
      <body name="tool" pos="0.3 0 0">
        <joint name="lift" type="slide" axis="0 0 1"/>
        <geom type="box" size="0.05 0.05 0.1"/>
        <body name="wrist" pos="0 0 -0.1"><joint name="ball" type="ball"/><geom type="box" size="0.02 0.02 0.02"/></body>
      </body>
    </body>
    <body name="cube" pos="0 0.5 0.2"><freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>
  </worldbody>
</mujoco>
"""
ROWS = 300


def states():
    """Time, qpos (turn, lift, ball w x y z, cube x y z w x y z) and qvel."""
    t = 0.05 * np.arange(ROWS)
    table = np.zeros((ROWS, 1 + 13 + 11))
    table[:, 0], table[:, 1], table[:, 2] = t, np.sin(t), 0.1 * np.cos(t)
    for i, time in enumerate(t):
        x, y, z, w = quaternion((1, 2, 3), 0.3 * time)
        table[i, 3:7] = w, x, y, z
        x, y, z, w = quaternion((0, 1, 1), -0.2 * time)
        table[i, 7:14] = 0.1 * time, 0.5, 0.2 + 0.05 * np.sin(time), w, x, y, z
    table[:, 14:] = 7  # velocities are not used
    return table


def model_of(test):
    path = test.path("model.xml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(MODEL)
    return path


def write(test, name, demos):
    path = test.path(name)
    with h5py.File(path, "w") as file:
        for demo, table in demos.items():
            group = file.create_group(f"data/{demo}")
            group.attrs["model_file"] = MODEL
            group.create_dataset("states", data=table, chunks=(min(7, len(table)), table.shape[1]), compression="gzip")
            group.create_dataset("actions", data=np.zeros((len(table), 4)))
    return path


def poses_are_those_of_the_joints(test):
    table = states()
    demos = {f"demo_{i}": table[:5] for i in range(12)}
    demos["demo_10"] = table
    recording = test.path("out.mcap")
    said = relabel(test, write(test, "demo.hdf5", demos), model_of(test), "--demo", "demo_10", "--out", recording)
    names, _, frames = poses_of(recording)
    check(sorted(names) == ["arm", "cube", "tool", "wrist"] and len(frames) == ROWS, f"{names}, {len(frames)} frames")
    check(f"{ROWS} frames of 4 nodes" in said and "demo_10" in said, said)
    worst = 0
    for row, (time_ns, poses) in zip(table, frames):
        check(time_ns == round(row[0] * 1e9), f"{time_ns} is not {row[0]}")
        arm = matrix([0, 0, 0.5], quaternion((0, 0, 1), row[1]))
        tool = arm @ matrix([0.3, 0, row[2]], [0, 0, 0, 1])
        w, x, y, z = row[3:7]
        wrist = tool @ matrix([0, 0, -0.1], [x, y, z, w])
        w, x, y, z = row[10:14]
        wanted = {"arm": arm, "tool": tool, "wrist": wrist, "cube": matrix(row[7:10], [x, y, z, w])}
        for name, pose in zip(names, poses):
            worst = max(worst, np.abs(pose - wanted[name][:3]).max())
    check(worst < 1e-6, f"poses differ by {worst}")
    print(f"{len(frames)} frames, poses within {worst:.1e}")


def a_wrong_choice_is_named(test):
    path, out = write(test, "some.hdf5", {"demo_2": states(), "demo_10": states(), "demo_1": states()}), test.path("no.mcap")
    for arguments, reason in (((), "has 3 demonstrations, demo_1 to demo_10: choose one by --demo"),
                              (("--demo", "demo_3"), 'has no demonstration "demo_3", but demo_1 to demo_10')):
        said = relabel(test, path, model_of(test), *arguments, "--out", out, code=1)
        check(reason in said, said)
    wrong = {"columns": (states()[:, :-1], "have 24 numbers; the scene's joints need 25 (time, 13 of qpos, 11 of qvel)"),
             "back": (np.vstack((states()[:3], states()[:1])), "row 3: its time is not after that of the row before"),
             "nan": (np.where(np.arange(25) == 2, np.nan, states()[:3]), 'row 0: the position of joint "lift" is not finite'),
             "zero": (np.where((np.arange(25) > 2) & (np.arange(25) < 7), 0, states()[:3]), "has a quaternion without length"),
             "none": (states()[:0], "there is no row"),
             "line": (np.zeros(25)[:, None][:, 0:0] + np.zeros((25, 0)), "has 0 columns")}
    for name, (table, reason) in wrong.items():
        if table.size == 0:
            with h5py.File(test.path(f"{name}.hdf5"), "w") as file:
                file.create_dataset("data/demo_0/states", data=table)
        else:
            write(test, f"{name}.hdf5", {"demo_0": table})
        said = relabel(test, test.path(f"{name}.hdf5"), model_of(test), "--out", out, code=1)
        check(reason in said, f"{name}: {said}")
    with h5py.File(test.path("link.hdf5"), "w") as file:
        file.create_group("data/demo_0")["states"] = h5py.ExternalLink("some.hdf5", "/data/demo_1/states")
    os.mkfifo(test.path("pipe"))  # who opens it waits without end
    for name, target in (("group", "some.hdf5"), ("pipe link", "pipe")):
        with h5py.File(test.path(f"{name}.hdf5"), "w") as file:
            file["data"] = h5py.ExternalLink(target, "/data")
    with h5py.File(test.path("texts.hdf5"), "w") as file:
        file.create_dataset("data/demo_0/states", data=np.full((3, 25), b"x"))
    for name, reason in (("link", "has no array /data/demo_0/states"), ("group", "has no group /data"), ("pipe link", "has no group /data"),
                         ("texts", "cannot be read as numbers")):
        said = relabel(test, test.path(f"{name}.hdf5"), model_of(test), "--out", out, code=1)
        check(reason in said, f"{name}: {said}")
    check(not os.path.exists(out), "a file of a failed import")


def hostile_files_end(test):
    with open(write(test, "sound.hdf5", {"demo_0": states()[:20]}), "rb") as file:
        data = file.read()
    chance = random.Random(3)
    for i in range(20):
        damaged = bytearray(data[:chance.randrange(len(data))] if i % 4 == 0 else data)
        for _ in range(chance.randrange(1, 20)):
            damaged[chance.randrange(8, len(damaged))] = chance.randrange(256)
        with open(test.path("damaged.hdf5"), "wb") as file:
            file.write(damaged)
        out = test.path(f"{i}.mcap")
        program = Program(test, "relabel", [test.programs_at["fire3dv"], "relabel", test.path("damaged.hdf5"), model_of(test), "--out", out,
                                            "--cache", "off"], vulkan_environment())
        code = program.wait()
        check(code in (0, 1) and (code == 0) == os.path.exists(out), f"exit status {code}: {program.stderr_text()}")


if __name__ == "__main__":
    main({"poses": poses_are_those_of_the_joints, "choice": a_wrong_choice_is_named, "hostile": hostile_files_end}, ("fire3dv",))
