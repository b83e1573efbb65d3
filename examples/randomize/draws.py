#!/usr/bin/env python3
"""Draws of `fire3dv dataset --draws`: places of bodies that keep a distance, which ranges of a file cannot say.

    draws.py draws.jsonl --images 1000 --names needle clamp --apart 0.05 --box 0.1
    fire3dv dataset scene.glb --format coco --out set --images 1000 --randomize randomize.yaml --draws draws.jsonl

The file of --randomize names the same parameters, as in `nodes: {needle: {move_m: [0, 0, 0]}}`, and has all
others. docs/randomization.md has the lines' format.
"""
import argparse
import json
import math
import random


def place(names, apart, box):
    """Offsets in metres in a cube, each farther than `apart` from all others: drawn again until they are."""
    for _ in range(100_000):
        places = {name: [random.uniform(-box / 2, box / 2) for _ in range(3)] for name in names}
        points = list(places.values())
        if all(math.dist(a, b) >= apart for i, a in enumerate(points) for b in points[:i]):
            return places
    raise SystemExit(f"{len(names)} bodies that are {apart} m apart do not fit into {box} m: choose a larger --box")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out")
    parser.add_argument("--images", type=int, required=True, help="of each camera")
    parser.add_argument("--cameras", type=int, default=1, help="of the set: so many images in succession show a frame")
    parser.add_argument("--names", nargs="+", required=True, help="nodes of the scene")
    parser.add_argument("--apart", type=float, default=0.05, help="metres")
    parser.add_argument("--box", type=float, default=0.2, help="edge of the cube in metres")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    random.seed(options.seed)
    with open(options.out, "w", encoding="utf-8") as file:
        for image in range(options.images):
            places = place(options.names, options.apart, options.box)
            drawn = {f"nodes.{name}.move_m": offset for name, offset in places.items()}
            file.write(json.dumps({"frame": image * options.cameras, "drawn": drawn}) + "\n")


if __name__ == "__main__":
    main()
