#!/usr/bin/env python3
"""A stereo endoscope with the lenses of a calibration, moved before a scene that fire3dv has loaded: left and right
images of the same frame, in lockstep, and the calibration as OpenCV has it.

stereo_endoscope.py [--to URI] [--out FOLDER] [--frames N] [--size WxH] [--center X,Y,Z] [--distance M]"""
import argparse
import json
import os
import sys

import numpy as np

import fire3dv

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_common import count, expect, looking, place, positive, run, size, write_png

BASELINE_M = 0.005  # distance between the optical centres
# Lens coefficients as from a calibration: k1 k2 p1 p2 k3 of OpenCV's plumb_bob model.
LENS = {"left": (-0.32, 0.11, 0.0008, -0.0005, -0.02), "right": (-0.31, 0.10, -0.0006, 0.0004, -0.018)}


def camera_matrix(width, height):
    """fx, fy, cx, cy in pixels; the centre of the top left pixel is (0, 0)."""
    return 0.8 * width, 0.8 * width, 0.5 * (width - 1) + 1.5, 0.5 * (height - 1) - 1.0


def tip_pose(frame, frames, center, distance):
    """world_from_endoscope, (3, 4): it orbits its target; -Z is the view direction, +Y up."""
    angle = np.radians(25) * np.sin(2 * np.pi * frame / frames)
    eye = center + distance * np.array([np.sin(angle), 0.3, np.cos(angle)])
    return looking(eye, center).astype(np.float32)


def write_calibration(path, width, height):
    fx, fy, cx, cy = camera_matrix(width, height)
    sides = {side: {"K": [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], "D": list(k)} for side, k in LENS.items()}
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"width": width, "height": height, **sides,
                   # p_right = R p_left + T in OpenCV axes: X right, Y down, Z forward
                   "R": np.eye(3).tolist(), "T": [-BASELINE_M, 0, 0]}, file, indent=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--to", default="shm://demo", help="where fire3dv listens (default: %(default)s)")
    parser.add_argument("--out", default="stereo", help="folder of the images (default: %(default)s)")
    parser.add_argument("--frames", type=count, default=30)
    parser.add_argument("--size", type=size, default="640x480")
    parser.add_argument("--center", type=place, default="0,0.5,0", help="what it looks at, in metres; --center=-1,0,0 where it begins with a minus")
    parser.add_argument("--distance", type=positive, default=2.0)
    parser.add_argument("--timeout", type=positive, default=60.0, help="seconds to wait for an image")
    options = parser.parse_args()
    width, height = options.size
    os.makedirs(options.out, exist_ok=True)
    write_calibration(os.path.join(options.out, "calibration.json"), width, height)
    fx, fy, cx, cy = camera_matrix(width, height)

    with fire3dv.Stream(options.to, adapter_name="stereo_endoscope") as stream:
        stream.add_node("endoscope")  # adds the node, since the scene has none
        stream.set_light("endoscope", fire3dv.LightKind.SPOT, intensity=3 * options.distance ** 2, outer_cone_rad=0.9)
        stream.describe(["endoscope"])
        cameras = {}  # from frame 1 on: the node does not exist before
        for side, x in (("left", -BASELINE_M / 2), ("right", BASELINE_M / 2)):
            cameras[side] = stream.request_image(
                width, height, node="endoscope", parent_from_camera=[1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0], when="every_nth", sequence=1,
                fx=fx, fy=fy, cx=cx, cy=cy, near_m=0.01, lens="plumb_bob", lens_coefficients=LENS[side])
        for frame in range(options.frames):
            sim_time_ns = frame * 33_000_000
            pose = tip_pose(frame, options.frames, options.center, options.distance)
            images = stream.step(sim_time_ns, [pose], list(cameras.values()), options.timeout)
            places = []
            for side, image in zip(cameras, images):
                with image:
                    expect((image.sequence, image.sim_time_ns, image.lost) == (stream.sequence, sim_time_ns, 0),
                           f"the {side} image shows frame {image.sequence}, not {stream.sequence}")
                    expect(image.lens == "plumb_bob" and np.allclose(image.lens_coefficients, LENS[side]),
                           f"the {side} image has another lens")
                    places.append(np.reshape(image.world_from_camera, (3, 4))[:, 3])
                    write_png(os.path.join(options.out, f"{side}_{frame:03}.png"), image["color_srgb8"][..., :3])
            apart = np.linalg.norm(places[1] - places[0])
            expect(abs(apart - BASELINE_M) < 1e-5, f"the cameras are {apart} m apart, not {BASELINE_M}")
    print(f"{options.out}: {options.frames} pairs, each of one frame")


if __name__ == "__main__":
    run(main)
