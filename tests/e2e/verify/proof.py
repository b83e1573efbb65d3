#!/usr/bin/env python3
"""The proof of `fire3dv verify` at length, not run by CI: thousands of random images, drawn in shards by workers of which some
are killed and continued, joined, and all drawn again.

    python3 tests/e2e/verify/proof.py build/ci/bin/fire3dv --images 10000 --size 64x64

Each image has its own camera, bodies, materials, lights and background, from ranges. Prints one line with what was measured.
NumPy; the scene is that of the data set tests. Exit status 0: all images are identical.
"""
import argparse
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../dataset"))
from label_scene import write_label_scene  # noqa: E402

RANGES = """
cameras:
  "*": {look_at: [0, 10, 0], look_at_offset_m: [[-20, 20], [-20, 20], 0], distance_m: {log: [60, 200]}, azimuth_deg: [-180, 180],
        elevation_deg: [-60, 70], roll_deg: {normal: [0, 20]}, fov_deg: [20, 60], noise: [0, 5]}
nodes:
  red: {move_m: [[-30, 30], [-20, 20], [-30, 30]], rotation: uniform, visible: 0.9}
  blue: {move_m: [[-30, 30], [-20, 20], [-30, 30]], rotation: uniform}
  green: {move_m: [[-30, 30], [-20, 20], [-30, 30]]}
materials:
  "*": {base_color: [[0, 1], [0, 1], [0, 1]], roughness: [0.1, 1], metallic: [0, 1]}
environment: {intensity: [0.3, 1.5], rotation_deg: [0, 360]}
background: {color: [[0, 1], [0, 1], [0, 1]]}
"""


def arguments_of():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("program", help="fire3dv")
    parser.add_argument("--images", type=int, default=10000)
    parser.add_argument("--size", default="64x64")
    parser.add_argument("--shards", type=int, default=8)
    parser.add_argument("--workers", type=int, default=2, help="at the same time")
    parser.add_argument("--kills", type=int, default=4, help="shards whose worker is killed once, at a random moment")
    parser.add_argument("--format", default="coco")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", metavar="DIR", help="folder of all files; default: a temporary one")
    return parser.parse_args()


def listed(folder):
    path = os.path.join(folder, "frames.jsonl")
    if not os.path.exists(path):
        return 0
    with open(path, "rb") as file:
        return file.read().count(b"\n")


class Proof:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.scene, self.ranges = os.path.join(folder, "scene.glb"), os.path.join(folder, "ranges.yaml")
        write_label_scene(self.scene, keypoints=True)
        with open(self.ranges, "w", encoding="utf-8") as file:
            file.write(RANGES)
        self.random = random.Random(options.seed)
        self.kill_at = {shard: self.random.random() for shard in self.random.sample(range(1, options.shards + 1), min(options.kills, options.shards))}
        self.killed, self.faults, self.lock = 0, [], threading.Lock()

    def command(self, *words):
        return [self.options.program, *map(str, words), "--cache", "off"]

    def part(self, shard):
        return os.path.join(self.folder, f"part{shard}")

    def draw(self, shard):
        """One worker; killed after a share of its images, if the shard is chosen, and started again."""
        command = self.command("dataset", self.scene, "--format", self.options.format, "--out", self.part(shard), "--size", self.options.size,
                               "--images", self.options.images, "--randomize", self.ranges, "--seed", self.options.seed,
                               "--camera", "front", "--shard", f"{shard}/{self.options.shards}")
        wanted = self.kill_at.get(shard, 2) * self.options.images / self.options.shards
        for attempt in range(2):
            with open(os.path.join(self.folder, f"part{shard}.log"), "ab") as log:
                process = subprocess.Popen(command, stdout=log, stderr=log)
            while attempt == 0 and shard in self.kill_at and process.poll() is None:
                if listed(self.part(shard)) >= max(1, wanted):
                    process.kill()
                    with self.lock:
                        self.killed += 1
                    break
                time.sleep(0.02)
            code = process.wait()
            if code == 0:
                return
        with self.lock:
            self.faults.append(f"shard {shard} ended with {code}: see {self.folder}/part{shard}.log")

    def run(self):
        pending = list(range(1, self.options.shards + 1))

        def work():
            while True:
                with self.lock:
                    if not pending:
                        return
                    shard = pending.pop(0)
                self.draw(shard)
        begun = time.monotonic()
        workers = [threading.Thread(target=work) for _ in range(self.options.workers)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        drawn = time.monotonic() - begun
        if self.faults:
            sys.exit("error: " + "; ".join(self.faults))
        whole = os.path.join(self.folder, "set")
        subprocess.run([self.options.program, "join", *map(self.part, range(1, self.options.shards + 1)), "--out", whole], check=True)
        begun = time.monotonic()
        verified = subprocess.run(self.command("verify", whole, self.scene, "--randomize", self.ranges), stdout=subprocess.PIPE, text=True)
        took = time.monotonic() - begun
        print(verified.stdout, end="")
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        outcome = "all identical" if verified.returncode == 0 else f"exit status {verified.returncode}"
        print(f"{self.options.images} images of {self.options.size}, {self.options.shards} shards, {self.options.workers} workers, {self.killed} killed and "
              f"continued: {outcome}; drawn in {drawn:.0f} s, verified in {took:.0f} s, {used.ru_utime + used.ru_stime:.0f} CPU-seconds")
        return verified.returncode


def main():
    options = arguments_of()
    options.program = os.path.abspath(options.program)
    folder = options.keep or tempfile.mkdtemp(prefix="fire3dv-proof-")
    os.makedirs(folder, exist_ok=True)
    try:
        sys.exit(Proof(options, folder).run())
    finally:
        if not options.keep:
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
