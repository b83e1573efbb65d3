"""Runs of `fire3dv dataset` on the scene with closed forms, for the end-to-end tests of data sets."""
import json
import os
import subprocess

from harness import HANG_S, Program, check, vulkan_environment
from label_readers import read_json
from label_scene import SIZE, write_label_scene

METRE = 1000.0  # in millimetres
DEPTH_UNIT_MM = 4.0


def scene_of(test):
    path = os.path.join(test.folder, "labels.glb")
    if not os.path.exists(path):
        write_label_scene(path, keypoints=True)
    return path


def recording(test):
    path = os.path.join(test.folder, "made.mcap")
    if not os.path.exists(path):
        subprocess.run([test.programs_at["make"], path, test.scene], check=True, timeout=HANG_S)
    return path


def command_of(test, out, *arguments, inputs=None):
    inputs = inputs if inputs is not None else [recording(test), scene_of(test)]
    depth_scale = () if "--depth-scale" in arguments else ("--depth-scale", DEPTH_UNIT_MM)
    return [test.programs_at["fire3dv"], "dataset", *inputs, "--out", out, "--cache", "off", "--tone-map", "none", "--ground", "off",
            "--shadows", "off", "--samples", "1", "--size", f"{SIZE[0]}x{SIZE[1]}", *depth_scale, *map(str, arguments)]


def start(test, out, *arguments, **options):
    return Program(test, "dataset", list(map(str, command_of(test, out, *arguments, **options))), vulkan_environment())


def run(test, out, *arguments, code=0, **options):
    program = start(test, out, *arguments, **options)
    program.expect_exit(code)
    return program.stderr_text()


def join(test, *arguments, code=0):
    program = Program(test, "join", [test.programs_at["fire3dv"], "join", *map(str, arguments)], vulkan_environment())
    program.expect_exit(code)
    return program.stderr_text()


def tree(folder):
    """All files with their bytes."""
    found = {}
    for at, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(at, name)
            with open(path, "rb") as file:
                found[os.path.relpath(path, folder)] = file.read()
    return found


def expect_same(folder, wanted, what):
    ours, theirs = tree(folder), tree(wanted)
    check(set(ours) == set(theirs), f"{what}: files {sorted(set(ours) ^ set(theirs))[:8]}")
    differing = [name for name in ours if ours[name] != theirs[name]]
    check(not differing, f"{what}: other bytes in {differing[:8]}")


def lines_of(folder):
    with open(os.path.join(folder, "frames.jsonl"), encoding="utf-8") as file:
        return [json.loads(line) for line in file]


def names_of(folder):
    """Names of instances by number."""
    return {each["instance"]: each["name"] for each in read_json(os.path.join(folder, "dataset.json"))["instances"]}


RUN = ("--rate", 20, "--camera", "front", "--camera", "side")


def whole_run(test, form):
    folder = os.path.join(test.folder, f"whole {form}")
    if not os.path.exists(folder):
        run(test, folder, "--format", form, *RUN)
    return folder
