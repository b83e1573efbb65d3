#!/usr/bin/env python3
"""A camera that circles a scene, its images as NumPy arrays: in lockstep, each with the frame that it shows.

camera_to_numpy.py [--to URI] [--out FOLDER] [--images N] [--size WxH] [--center X,Y,Z] [--distance M]"""
import argparse
import math
import os

import numpy as np

import fire3dv


def look_at(eye, target):
    """world_from_camera, (3, 4): it looks along its -Z, +Y is up."""
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross([0, 1, 0], back)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(back, right), back, eye]).astype(np.float32)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--to", default="shm://demo", help="where fire3dv listens (default: %(default)s)")
    parser.add_argument("--out", default="images", help="folder for .npy files (default: %(default)s)")
    parser.add_argument("--images", type=int, default=8)
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--center", default="0,0.5,0", help="what the camera looks at, in metres")
    parser.add_argument("--distance", type=float, default=3.0)
    parser.add_argument("--timeout", type=float, default=60.0, help="seconds to wait for an image")
    options = parser.parse_args()
    width, height = (int(side) for side in options.size.split("x"))
    center = np.array([float(x) for x in options.center.split(",")])
    os.makedirs(options.out, exist_ok=True)

    with fire3dv.Stream(options.to, adapter_name="camera_to_numpy") as stream:
        stream.describe([])  # nothing is moved here; a simulation would name its bodies, and publish their poses
        for number in range(options.images):
            angle = 2 * math.pi * number / options.images
            eye = center + options.distance * np.array([math.sin(angle), 0.4, math.cos(angle)])
            sequence = stream.publish(number * 10_000_000, [])
            request = stream.request_image(width, height, parent_from_camera=look_at(eye, center), fx=0.9 * width)
            with request.wait(options.timeout) as image:
                color = np.array(image["color_srgb8"])  # a copy: the image itself goes back to the renderer
                assert image.sequence >= sequence
            np.save(os.path.join(options.out, f"color_{number:03}.npy"), color)
            print(f"frame {image.sequence}: {color.shape} {color.dtype}, mean {color[..., :3].mean():.1f}")


if __name__ == "__main__":
    main()
