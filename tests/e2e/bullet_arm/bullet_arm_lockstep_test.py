#!/usr/bin/env python3
"""Lockstep test of the example simulator and the renderer: ten images over each transport, with validation layers."""
import os

from harness import TRANSPORTS, Program, main, shown, vulkan_environment
from image_reader import check, read_png

IMAGES = 10


def arm(test, transport):
    scene = test.path("arm.glb")
    Program(test, "bullet_arm", [test.programs_at["bullet_arm"], "--write-scene", scene]).expect_exit(0)
    uri = test.fresh_uri(transport)
    renderer = test.renderer("--lockstep", "--exit-when-done", "--camera", "camera_front", scene=scene, listen=[uri])
    # Every 24th step at 240 Hz; the first image shows the arm at time 0.
    simulator = Program(test, "bullet_arm", [test.programs_at["bullet_arm"], "--to", uri, "--lockstep", "--lockstep-every",
                                             "24", "--publish-every", "24", "--seconds", str((IMAGES - 1) / 10)],
                        env=vulkan_environment())
    simulator.expect_exit(0)
    renderer.expect_exit(0)
    frames = [f for f in renderer.frames() if f["streams"]]
    check([shown(f, "bullet_arm")["sequence"] for f in frames] == list(range(1, IMAGES + 1)),
          f"not each of {IMAGES} frames once: {[f['streams'] for f in frames]}")
    pictures = set()
    for frame in frames:
        picture = read_png(os.path.join(renderer.folder, frame["file"]))
        colours = {picture.pixel(x, y) for y in range(picture.height) for x in range(picture.width)}
        check(len(colours) > 200, f"{frame['file']} is as good as blank: {len(colours)} colours")
        pictures.add(tuple(picture.rows))
    check(len(pictures) == IMAGES, f"only {len(pictures)} different images")


if __name__ == "__main__":
    main({transport: lambda test, t=transport: arm(test, t) for transport in TRANSPORTS}, ["fire3dv", "bullet_arm"])
