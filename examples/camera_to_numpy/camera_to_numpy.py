#!/usr/bin/env python3
"""A camera that circles a scene, its images as NumPy arrays: in lockstep, each with the frame that it shows.

camera_to_numpy.py [--to URI] [--out FOLDER] [--images N] [--size WxH] [--center X,Y,Z] [--distance M]"""
import argparse
import math
import os
import sys

import numpy as np

import fire3dv

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_common import count, expect, looking, place, positive, run, size


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--to", default="shm://demo", help="where fire3dv listens (default: %(default)s)")
    parser.add_argument("--out", default="images", help="folder for .npy files (default: %(default)s)")
    parser.add_argument("--images", type=count, default=8)
    parser.add_argument("--size", type=size, default="320x240")
    parser.add_argument("--center", type=place, default="0,0.5,0", help="what the camera looks at, in metres; --center=-1,0,0 where it begins with a minus")
    parser.add_argument("--distance", type=positive, default=3.0)
    parser.add_argument("--timeout", type=positive, default=60.0, help="seconds to wait for an image")
    options = parser.parse_args()
    width, height = options.size
    os.makedirs(options.out, exist_ok=True)

    with fire3dv.Stream(options.to, adapter_name="camera_to_numpy") as stream:
        stream.describe([])  # no nodes: this program moves nothing. A simulator would list its bodies here and publish
                             # their poses
        for number in range(options.images):
            angle = 2 * math.pi * number / options.images
            eye = options.center + options.distance * np.array([math.sin(angle), 0.4, math.cos(angle)])
            sequence = stream.publish(number * 10_000_000, [])
            request = stream.request_image(width, height, parent_from_camera=looking(eye, options.center), fx=0.9 * width)
            with request.wait(options.timeout) as image:
                color = np.array(image["color_srgb8"])  # a copy, since the renderer reuses the image's memory
                expect(image.sequence >= sequence, f"the image shows frame {image.sequence}, which is older than {sequence}")
            np.save(os.path.join(options.out, f"color_{number:03}.npy"), color)
            print(f"frame {image.sequence}: {color.shape} {color.dtype}, mean {color[..., :3].mean():.1f}")


if __name__ == "__main__":
    run(main)
