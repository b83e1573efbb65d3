#!/usr/bin/env python3
"""Makes docs/images/markers.png, or measures frames of 100,000 points, or of 64,000 markers:
tools/marker_image.py BIN FILE.png | --bench | --bench-markers

BIN is the folder of the built programs. Needs NumPy and ffmpeg, and FIRE3DV_CLIENT_LIBRARY if the client is not installed.
"""
import glob
import math
import os
import subprocess
import sys
import tempfile
import time

import numpy as np

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
sys.path.insert(0, os.path.join(ROOT, "adapters/generic/python"))
import fire3dv  # noqa: E402


def show_all(stream):
    """One marker of each kind around the arm of bullet_arm, whose world has +Y up."""
    turn = np.linspace(0, 4 * math.pi, 200)
    spiral = np.stack([0.5 * np.cos(turn), 0.1 + 0.06 * turn, 0.5 * np.sin(turn)], axis=1).astype(np.float32)
    grid = np.stack(np.meshgrid(np.linspace(-1, 1, 140), np.linspace(-1, 1, 140)), axis=-1).reshape(-1, 2)
    height = 0.08 * np.sin(5 * grid[:, 0]) * np.cos(4 * grid[:, 1])
    cloud = np.stack([1.3 * grid[:, 0], 0.12 + height, 1.3 * grid[:, 1] - 0.4], axis=1).astype(np.float32)
    warm = np.clip((height + 0.08) / 0.16, 0, 1)[:, None]
    colors = np.rint(255 * (warm * [1.0, 0.45, 0.1] + (1 - warm) * [0.1, 0.5, 0.9])).astype(np.uint8)
    stream.points("lidar/ground", cloud, colors, size_px=2)
    stream.line_strip("plan/spiral", spiral, colors=(0.2, 0.9, 0.3), width_px=3)
    feet = np.array([[-0.9, 0.2, 0.5], [-0.6, 0.2, 0.6], [-0.3, 0.2, 0.7]], np.float32)
    stream.arrows("contacts/forces", feet, [[0, 0.45, 0], [0.05, 0.6, 0], [0, 0.3, 0.1]], colors=(1, 0.7, 0), width_m=0.03)
    stream.axes("frames/all", [[0.9, 0.25, 0.6], [0.9, 0.7, 0.6]], rotations=[[0, 0, 0, 1], [0.2, 0.4, 0, 0.9]], sizes=0.3,
                width_px=4)
    upright = [[-0.7071, 0, 0, 0.7071]]
    stream.boxes("regions/goal", [[0.75, 0.35, -0.4]], sizes=0.35, colors=(0.2, 0.6, 1, 0.45))
    stream.spheres("regions/ball", [[-0.75, 0.5, -0.5]], sizes=0.3, colors=(0.85, 0.2, 0.5))
    stream.cylinders("regions/post", [[-1.05, 0.4, -0.1]], [0.14, 0.14, 0.5], rotations=upright, colors=(0.5, 0.8, 0.9))
    stream.capsules("regions/limb", [[1.15, 0.5, 0.0]], [0.14, 0.14, 0.35], rotations=upright, colors=(0.8, 0.75, 0.3))
    stream.triangles("regions/flag", [[0.45, 0.6, -0.6], [0.75, 0.7, -0.6], [0.45, 0.8, -0.6]], colors=(0.9, 0.3, 0.2))
    stream.text("regions/names", ["goal", "ball \u2300 0.3 m"], [[0.75, 0.65, -0.4], [-0.75, 0.75, -0.5]], size_m=0.09)
    stream.image("camera/depth", depth_of_a_ball(128, 96), size_m=0.4, position=(-0.64, 0.2, 0.95),
                 rotation=(-0.17, 0.13, 0, 0.98))
    stream.lines("regions/mast", [[0.45, 0.1, -0.6], [0.45, 0.8, -0.6]], colors=(0.9, 0.9, 0.9), width_px=3)


def depth_of_a_ball(width, height):
    """Depth in colours, near ones warm, of a ball of 0.5 m on a floor 0.65 m below the camera."""
    x, y = np.meshgrid((np.arange(width) - width / 2 + 0.5) / width, (np.arange(height) - height / 2 + 0.5) / width)
    wall, radius, centre = 4.0, 0.5, np.array([0.15, 0.15, 2.2])
    depth = np.minimum(wall, 0.65 / np.maximum(y, 1e-6))
    # |t * ray - centre| = radius, with depth 1 along the ray
    a, b, c = x * x + y * y + 1, x * centre[0] + y * centre[1] + centre[2], centre @ centre - radius**2
    meets = b * b > a * c
    depth[meets] = ((b - np.sqrt(np.maximum(b * b - a * c, 0))) / a)[meets]
    near = np.clip((wall - depth) / (wall - 1.4), 0, 1)
    stops = np.array([[0.19, 0.07, 0.43], [0.13, 0.45, 0.85], [0.15, 0.8, 0.6], [0.95, 0.85, 0.2], [0.85, 0.2, 0.1]])
    channels = [np.interp(near, np.linspace(0, 1, len(stops)), stops[:, i]) for i in range(3)]
    return np.rint(255 * np.stack(channels, axis=-1)).astype(np.uint8)


def renderer(programs, folder, size):
    """A renderer of the scene of bullet_arm that draws each frame once, into the folder."""
    scene = os.path.join(folder, "arm.glb")
    subprocess.run([f"{programs}/bullet_arm", "--write-scene", scene], check=True, stdout=subprocess.DEVNULL)
    return fire3dv.Renderer(scene, program=f"{programs}/fire3dv", on_request=False, size=size, log=sys.stderr,
                            arguments=["--cache", "off", "--out", folder, "--lockstep"])


def show(stream, sim_time_ns):
    sequence = stream.publish(sim_time_ns, [])
    if not stream.wait_ack(sequence, 60_000):
        sys.exit(f"marker_image.py: frame {sequence} was not shown within a minute")


def image(programs, path):
    with tempfile.TemporaryDirectory() as folder:
        with renderer(programs, folder, (960, 540)) as process, process.stream("markers") as stream:
            stream.describe([])
            show_all(stream)
            show(stream, 0)
        # A palette of 256 colours keeps the file small.
        subprocess.run(["ffmpeg", "-y", "-v", "error", "-i", sorted(glob.glob(f"{folder}/*.png"))[-1], "-filter_complex",
                        "split[a][b];[a]palettegen=reserve_transparent=0[p];[b][p]paletteuse=dither=none", "-frames:v", "1",
                        "-compression_level", "9", path], check=True)


def bench(programs):
    """Prints the milliseconds of a frame in lockstep, without points and with 100,000 that all change."""
    frames, warm, points = 25, 5, 100_000
    random = np.random.default_rng(1)
    cloud = random.uniform(-1, 1, (points, 3)).astype(np.float32)
    colors = random.integers(0, 256, (points, 4), np.uint8)
    colors[:, 3] = 255
    for count in (0, points):
        with tempfile.TemporaryDirectory() as folder:
            with renderer(programs, folder, (640, 480)) as process, process.stream("bench") as stream:
                stream.describe([])
                for frame in range(frames):
                    if frame == warm:  # pipelines are compiled
                        begin = time.perf_counter()
                    cloud[:, 0] += 0.001
                    stream.points("cloud", cloud[:count], colors[:count], size_px=3)
                    show(stream, frame)
                spent = time.perf_counter() - begin
        print(f"{count} points: {1000 * spent / (frames - warm):.1f} ms a frame")


def set_many(stream, count, share_in_view):
    """Small markers of all kinds but texts: a share around the origin, the rest far to the side."""
    kinds = [lambda s, n, p: s.points(n, p, size_px=4), lambda s, n, p: s.lines(n, [p[0], p[0] + 0.02]),
             lambda s, n, p: s.arrows(n, p, [[0, 0.05, 0]]), lambda s, n, p: s.axes(n, p, sizes=0.05),
             lambda s, n, p: s.boxes(n, p, sizes=0.02), lambda s, n, p: s.spheres(n, p, sizes=0.02),
             lambda s, n, p: s.capsules(n, p, [0.02, 0.02, 0.03]), lambda s, n, p: s.triangles(n, p + TRIANGLE)]
    random = np.random.default_rng(1)
    places = random.uniform(-1, 1, (count, 1, 3)).astype(np.float32)
    places[int(count * share_in_view):, 0, 0] += 1000
    for i in range(count):
        kinds[i % len(kinds)](stream, f"many/{i}", places[i])


TRIANGLE = np.array([[0, 0, 0], [0.03, 0, 0], [0, 0.03, 0]], np.float32)


def bench_markers(programs):
    """Prints the milliseconds of a frame in lockstep: without markers, with 640 in view, with 63,360 more out of view, and
    with all in view. A stream has at most 65,536."""
    frames, warm = 25, 5
    for count, share in ((0, 0), (640, 1), (64_000, 0.01), (64_000, 1)):
        with tempfile.TemporaryDirectory() as folder:
            with renderer(programs, folder, (640, 480)) as process, process.stream("bench") as stream:
                stream.describe([])
                set_many(stream, count, share)
                for frame in range(frames):
                    if frame == warm:  # pipelines are compiled, markers are uploaded
                        begin = time.perf_counter()
                    show(stream, frame)
                spent = time.perf_counter() - begin
        print(f"{count} markers, {int(count * share)} in view: {1000 * spent / (frames - warm):.1f} ms a frame", flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    if sys.argv[2] == "--bench":
        bench(sys.argv[1])
    elif sys.argv[2] == "--bench-markers":
        bench_markers(sys.argv[1])
    else:
        image(sys.argv[1], sys.argv[2])
