#!/usr/bin/env python3
"""A stereo endoscope in a cavity of tissue: two wide-angle lenses with the coefficients of a calibration behind a round
field stop, and the light at their tip. Left and right images are of the same frame, in lockstep; the calibration is
written as OpenCV has it.

stereo_endoscope.py --write-scene SCENE.glb
stereo_endoscope.py [--to URI] [--out FOLDER] [--frames N] [--size WxH] [--center X,Y,Z] [--distance M]
                    [--calibration FILE [FILE]]"""
import argparse
import json
import os
import sys

import numpy as np

import cavity
import fire3dv

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_common import count, expect, looking, place, positive, run, size, write_png

BASELINE_M = 0.005  # distance between the optical centres
HALF_ANGLE = np.radians(42)  # of the round view
# Coefficients as from cv2.fisheye.calibrate: k1 k2 k3 k4.
LENS = {"left": (-0.021, 0.0064, -0.0021, 0.0003), "right": (-0.019, 0.0058, -0.0017, 0.0002)}
CANDELA_AT_1_M = 5.0  # intensity of the light for a target at 1 m; it goes with the square of the distance


def camera_matrix(width, height):
    """fx, fy, cx, cy in pixels; the centre of the top left pixel is (0, 0). The round view fills the height."""
    focal = 0.48 * height / HALF_ANGLE
    return focal, focal, 0.5 * (width - 1) + 1.5, 0.5 * (height - 1) - 1.0


def behind_field_stop(color, matrix):
    """The image with black outside of the circle that the optics show; its border is soft over two pixels."""
    focal, _, cx, cy = matrix
    y, x = np.mgrid[:color.shape[0], :color.shape[1]]
    share = np.clip(0.5 * (focal * HALF_ANGLE - np.hypot(x - cx, y - cy)) + 0.5, 0, 1)
    return (color * share[..., None]).astype(np.uint8)


def tip_pose(frame, frames, center, distance):
    """world_from_endoscope, (3, 4): it turns about its target; -Z is the view direction, +Y up."""
    angle = np.radians(14) * np.sin(2 * np.pi * frame / frames)
    eye = center + distance * np.array([np.sin(angle), 0.22, np.cos(angle)])
    return looking(eye, center).astype(np.float32)


def calibrated_cameras(files, width, height):
    """Arguments of Stream.request_image for left and right, by camera files of ROS, OpenCV or Kalibr."""
    cameras = fire3dv.read_calibration(*files, size=(width, height))
    expect(len(cameras) == 2, f"{', '.join(files)}: {len(cameras)} cameras, not 2: name the files of both eyes")
    return {side: camera.request(width, height) for side, camera in zip(("left", "right"), cameras)}


def usual_cameras(width, height):
    fx, fy, cx, cy = camera_matrix(width, height)
    return {side: {"width": width, "height": height, "fx": fx, "fy": fy, "cx": cx, "cy": cy, "lens": "fisheye", "lens_coefficients": LENS[side],
                   "parent_from_camera": [1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0]}
            for side, x in (("left", -BASELINE_M / 2), ("right", BASELINE_M / 2))}


def write_calibration(path, width, height):
    fx, fy, cx, cy = camera_matrix(width, height)
    sides = {side: {"K": [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], "D": list(k)} for side, k in LENS.items()}
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"width": width, "height": height, "model": "fisheye", **sides,
                   # p_right = R p_left + T in OpenCV axes: X right, Y down, Z forward
                   "R": np.eye(3).tolist(), "T": [-BASELINE_M, 0, 0]}, file, indent=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write-scene", metavar="SCENE.glb", help="write the cavity for fire3dv, and nothing else")
    parser.add_argument("--to", default="shm://demo", help="where fire3dv listens (default: %(default)s)")
    parser.add_argument("--out", default="stereo", help="folder of the images (default: %(default)s)")
    parser.add_argument("--frames", type=count, default=30)
    parser.add_argument("--size", type=size, default="640x480")
    parser.add_argument("--center", type=place, default=cavity.TARGET,
                        help="what it looks at, in metres; --center=-1,0,0 where it begins with a minus (default: the needle)")
    parser.add_argument("--distance", type=positive, default=0.075, help="from the tip to the target, in metres (default: %(default)s)")
    parser.add_argument("--calibration", metavar="FILE", nargs="+",
                        help="camera files of ROS (two), OpenCV or Kalibr in place of the example's lenses; then no field stop is painted")
    parser.add_argument("--timeout", type=positive, default=60.0, help="seconds to wait for an image")
    options = parser.parse_args()
    if options.write_scene:
        cavity.write_scene(options.write_scene)
        return
    width, height = options.size
    os.makedirs(options.out, exist_ok=True)
    if options.calibration:
        wanted = calibrated_cameras(options.calibration, width, height)
    else:
        wanted = usual_cameras(width, height)
        write_calibration(os.path.join(options.out, "calibration.json"), width, height)

    with fire3dv.Stream(options.to, adapter_name="stereo_endoscope") as stream:
        stream.add_node("endoscope")  # adds the node, since the scene has none
        stream.set_light("endoscope", fire3dv.LightKind.SPOT, (1, 0.96, 0.9), CANDELA_AT_1_M * options.distance ** 2,
                         inner_cone_rad=0.35, outer_cone_rad=1.0)
        stream.describe(["endoscope"])
        cameras = {}  # from frame 1 on: the node does not exist before
        for side, arguments in wanted.items():
            cameras[side] = stream.request_image(node="endoscope", when="every_nth", sequence=1, near_m=0.002, **arguments)
        for frame in range(options.frames):
            sim_time_ns = frame * 33_000_000
            pose = tip_pose(frame, options.frames, options.center, options.distance)
            images = stream.step(sim_time_ns, [pose], list(cameras.values()), options.timeout)
            places = []
            for side, image in zip(cameras, images):
                with image:
                    expect((image.sequence, image.sim_time_ns, image.lost) == (stream.sequence, sim_time_ns, 0),
                           f"the {side} image shows frame {image.sequence}, not {stream.sequence}")
                    lens, coefficients = wanted[side]["lens"], wanted[side]["lens_coefficients"]
                    expect(image.lens == lens and np.allclose(image.lens_coefficients[:len(coefficients)], coefficients),
                           f"the {side} image has another lens")
                    places.append(np.reshape(image.world_from_camera, (3, 4))[:, 3])
                    color = image["color_srgb8"][..., :3]
                    if not options.calibration:
                        color = behind_field_stop(color, camera_matrix(width, height))
                    write_png(os.path.join(options.out, f"{side}_{frame:03}.png"), color)
            apart = np.linalg.norm(places[1] - places[0])
            left, right = (np.reshape(arguments["parent_from_camera"], (3, 4))[:, 3] for arguments in wanted.values())
            baseline = np.linalg.norm(right - left)
            expect(abs(apart - baseline) < 1e-5, f"the cameras are {apart} m apart, not {baseline}")
    print(f"{options.out}: {options.frames} pairs, each of one frame")


if __name__ == "__main__":
    run(main)
