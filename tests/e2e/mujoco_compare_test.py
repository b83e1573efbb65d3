#!/usr/bin/env python3
"""Comparison with MuJoCo's own renderer as the reference: labels and depth of the same model and camera.

mujoco_compare_test.py FIRE3DV FIRE3DV_MUJOCO FIRE3DV_MUJOCO_COMPARE [CASE...]; exits with 77 without OpenGL.
"""
import os
import signal
import sys

from harness import Program, main, vulkan_environment
from image_reader import check

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
CRANE = os.path.join(ROOT, "tests", "assets", "robots", "crane.xml")
ASSETS = os.environ.get("FIRE3DV_ASSETS") or os.path.join(ROOT, "..", "shared", "assets")


def agreement(test, model, camera, objects):
    scene, uri = test.path("model.glb"), test.fresh_uri("shm")
    Program(test, "fire3dv-mujoco", [test.programs_at["fire3dv-mujoco"], model, "--scene", scene]).expect_exit(0)
    renderer = Program(test, "fire3dv", [
        test.programs_at["fire3dv"], scene, "--validation", "--cache", "off", "--headless", "--on-request", "--samples", "1",
        "--fxaa", "off", "--listen", uri], vulkan_environment())
    renderer.wait_err("listening on")
    program = Program(test, "fire3dv-mujoco-compare", [
        test.programs_at["fire3dv-mujoco-compare"], model, "--to", uri, "--images", f"{camera}:320x240", "--frames", "3"])
    if program.wait() == 77:
        print(program.stderr_text())
        sys.exit(77)
    check(program.wait() == 0, f"it ended with {program.wait()}")
    renderer.signal(signal.SIGTERM)
    renderer.expect_exit(0)
    row = [cell.strip() for cell in program.out[0].strip().strip("|").split("|")]
    seen, beyond, same, inside, *errors = (float(cell) for cell in row[4:])
    check(seen == objects, f"{seen:.0f} objects are seen, not {objects}")
    check(beyond < 20 and same > 99.9 and inside == 100, f"labels differ: {row}")
    check(errors[0] < 2e-5 and errors[1] < 5e-4 and errors[2] < 2e-3, f"depths differ: {row}")


def gripper(test):
    """Uses the model of the collection, if available."""
    model = os.path.join(ASSETS, "robots", "robotiq_2f85", "scene.xml")
    if not os.path.exists(model):
        print(f"gripper: skipped, {model} is not there")
        return
    agreement(test, model, "free camera", 17)


main({"crane": lambda test: agreement(test, CRANE, "chaser", 7), "gripper": gripper},
     ["fire3dv", "fire3dv-mujoco", "fire3dv-mujoco-compare"])
