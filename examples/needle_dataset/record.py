#!/usr/bin/env python3
"""Records scripted sequences of the needle scene into one MCAP file: poses of needle, thread, instruments, cameras and lamps,
and the tissue, its tint and the lamps' light of each sequence."""
import argparse
import concurrent.futures
import functools
import os
import subprocess
import sys
import time

import numpy as np

import fire3dv
import motion
import scene

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_common import count, expect, run, whole

#: Illuminance of a lamp at 1 m, at which its brightness factor counts; it stands at about 8 cm.
CANDELA = 0.030
PAUSE_S = 0.004  # after a frame, so that none is dropped for a newer one


def span(text):
    first, _, last = text.partition("-")
    if whole(first) > whole(last):
        raise argparse.ArgumentTypeError(f"{text!r} is no range such as 0-5")
    return range(whole(first), whole(last) + 1)


def node_names(views):
    return [scene.NEEDLE, scene.THREAD, *(part for name in scene.INSTRUMENTS for part in scene.parts(name)), *scene.joints(),
            *scene.views(views), *scene.LAMPS]


def sequence_of(seed, frames, shown, views, number):
    """All poses of a sequence, (frames, nodes, 3, 4) float32, and its looks."""
    made = motion.Sequence(seed, number, shown, views)
    poses = [made.frame(i) for i in range(frames)]
    return np.array([[each[name] for name in node_names(views)] for each in poses], np.float32), made.looks()


def set_looks(stream, looks, tissues):
    for i, name in enumerate(scene.surfaces(tissues)):
        stream.set_visible(name, i == looks["tissue"])
    stream.set_base_color(scene.surfaces(tissues)[looks["tissue"]], [*np.clip(looks["tint"], 0, 1), 1])
    for name, brightness, shadow in zip(scene.LAMPS, looks["brightness"], (True, False)):
        stream.set_light(name, fire3dv.LightKind.SPOT, looks["lamp_color"], CANDELA * brightness, inner_cone_rad=0.30,
                         outer_cone_rad=0.85, casts_shadow=shadow)


def publish(uri, sequences, tissues, views):
    """Returns the number of frames."""
    frames = 0
    with fire3dv.Stream(uri, adapter_name="needle") as stream:
        stream.describe(node_names(views), nominal_rate_hz=1 / motion.FRAME_S)
        end = time.monotonic() + 30
        while stream.poll().welcome != 0:
            expect(time.monotonic() < end, f"no recorder answers at {uri}")
            time.sleep(0.01)
        for poses, looks in sequences:
            set_looks(stream, looks, tissues)
            time.sleep(10 * PAUSE_S)
            for i, frame in enumerate(poses):
                stream.publish(int(round(frames * motion.FRAME_S * 1e9)), frame, fire3dv.FRAME_DISCONTINUITY if i == 0 else 0)
                frames += 1
                time.sleep(PAUSE_S)
    return frames


def uri_of(recorder):
    """Where the recorder listens, from what it says."""
    said = ""
    for line in recorder.stderr:
        said += line
        if "listening on " in line:
            return line.partition("listening on ")[2].strip()
    raise SystemExit(f"error: the recorder does not listen: {said.strip()}")


def record(path, program, seed, count_of, frames, tissues, shown, views):
    """tissues: their number in the scene; shown: indices of those that sequences choose from."""
    make = functools.partial(sequence_of, seed, frames, shown, views)
    with concurrent.futures.ProcessPoolExecutor() as pool:
        sequences = list(pool.map(make, range(count_of)))
    command = [program, "--from", "tcp://127.0.0.1:0", "--out", path, "--until-end"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as recorder:
        try:
            published = publish(uri_of(recorder), sequences, tissues, views)
        except BaseException:
            recorder.terminate()
            raise
        said = recorder.stderr.read()
        expect(recorder.wait() == 0, f"{path} lacks frames; record it again on a machine with less load: {said.strip()}")
    print(f"{path}: {count_of} sequences, {published} frames")


def main():
    parser = argparse.ArgumentParser(description=__doc__.replace("\n", " "))
    parser.add_argument("out", metavar="FILE.mcap", help="recording to write")
    parser.add_argument("--seed", type=whole, default=1, help="the same number gives the same motion (default: %(default)s)")
    parser.add_argument("--sequences", type=count, default=40, help="(default: %(default)s)")
    parser.add_argument("--frames", type=count, default=30, help="of each sequence (default: %(default)s)")
    scene.add_options(parser)
    parser.add_argument("--show", type=span, metavar="FIRST-LAST", help="tissue surfaces to choose from, such as 0-5 (default: all)")
    parser.add_argument("--bin", default=".", metavar="DIR", help="folder of fire3dv-record (default: the current one)")
    options = parser.parse_args()
    shown = options.show or range(options.tissues)
    if shown[-1] >= options.tissues:
        parser.error(f"argument --show: the scene has the tissues 0 to {options.tissues - 1} only: see --tissues")
    record(options.out, os.path.join(options.bin, "fire3dv-record"), options.seed, options.sequences, options.frames, options.tissues,
           shown, options.views)


if __name__ == "__main__":
    run(main)
