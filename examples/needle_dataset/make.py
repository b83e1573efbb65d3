#!/usr/bin/env python3
"""Makes the needle data set: the scene, a recording of sequences to train with and one of unseen sequences, and both as
labelled data sets. What follows -- goes to fire3dv dataset, such as --ray-effects ao,reflections."""
import argparse
import json
import os
import shutil
import subprocess
import sys
import time

import scene

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_common import count, expect, run, size, whole

FOLDER = os.path.dirname(os.path.abspath(__file__))
#: Light from the lamps and the walls of the cavity alone, and a fixed exposure.
DRAWING = ("--environment-sun", "off", "--environment-intensity", "0.75", "--exposure", "1", "--bloom", "0.03")


def call(*words):
    expect(subprocess.run([str(word) for word in words], check=False).returncode == 0, f"{os.path.basename(str(words[0]))} failed: see above")


def python(script, *words):
    call(sys.executable, os.path.join(FOLDER, script), *words)


def inputs(options):
    """The scene, and the two recordings. Tissue surfaces of the test are in no image of the training, if there are three or more."""
    last = options.tissues - 1
    unseen = min(2, last) if last > 1 else 0
    spans = {"train": (0, last - unseen), "test": (last - unseen + 1 if unseen else 0, last)}
    common = ("--tissues", options.tissues, "--views", options.views)
    python("scene.py", os.path.join(options.out, "needle.glb"), "--environment", os.path.join(options.out, "cavity.hdr"), "--texels", options.texels,
           "--cells", options.cells, *common)
    for name, sequences, seed in (("train", options.sequences, options.seed), ("test", options.test_sequences, options.seed + 1)):
        python("record.py", os.path.join(options.out, f"{name}.mcap"), "--seed", seed, "--sequences", sequences, "--frames", options.frames, *common,
               "--show", "{}-{}".format(*spans[name]), "--bin", options.bin)


def begin(options):
    """Makes the inputs, or finds those of the same options, with which an interrupted run continues."""
    settings = {key: value for key, value in vars(options).items() if key not in ("out", "bin", "shards", "further")}
    path = os.path.join(options.out, "settings.json")
    if os.path.exists(options.out):
        expect(os.path.exists(path), f"{options.out} is there already, and no unfinished data set: name another folder")
        with open(path, encoding="utf-8") as file:
            expect(json.load(file) == json.loads(json.dumps(settings)), f"{options.out} is of other options: name another folder")
        print(f"{options.out}: scene and recordings are there already")
        return
    os.makedirs(options.out)
    inputs(options)
    with open(path, "w", encoding="utf-8") as file:
        json.dump(settings, file)


def in_shards(command, out, shards):
    """Draws parts by several processes at once, and joins them."""
    parts = [f"{out}.part{i + 1}" for i in range(shards)]
    running = [subprocess.Popen([*command, "--out", part, "--shard", f"{i + 1}/{shards}"]) for i, part in enumerate(parts)]
    expect(all([each.wait() == 0 for each in running]), "fire3dv dataset failed: see above")
    call(command[0], "join", *parts, "--out", out)
    for part in parts:
        shutil.rmtree(part)


def draw(options, name):
    """Draws a set, unless it is complete. Returns the number of its images that this has drawn or completed."""
    path = [os.path.join(options.out, file) for file in (f"{name}.mcap", "needle.glb", "cavity.hdr", name)]
    if os.path.exists(os.path.join(path[3], "index.html")):
        print(f"{path[3]} is there already")  # its page is written last
        return 0
    labelled = [scene.NEEDLE, scene.THREAD, *(part for each in scene.INSTRUMENTS for part in scene.parts(each))]
    scale = ("--depth-scale", "0.01") if options.format in ("bop", "webdataset") else ()  # a hundredth of a millimetre: to 0.65 m
    command = [os.path.join(options.bin, "fire3dv"), "dataset", *path[:2], "--format", options.format, *scale, "--environment", path[2], *DRAWING,
               "--size", "{}x{}".format(*options.size), *(word for view in scene.views(options.views) for word in ("--camera", view)),
               *(word for node in labelled for word in ("--object", node)), *options.further]
    if options.shards > 1:
        in_shards(command, path[3], options.shards)
    else:
        call(*command, "--out", path[3])
    return (options.sequences if name == "train" else options.test_sequences) * options.frames * options.views


def main():
    parser = argparse.ArgumentParser(description=__doc__.replace("\n", " "), usage="%(prog)s [options] [-- OPTION...]")
    parser.add_argument("--out", default="needle", help="folder of the scene, the recordings, and the sets train and test (default: %(default)s)")
    parser.add_argument("--bin", default=".", metavar="DIR", help="folder of fire3dv and fire3dv-record (default: the current one)")
    parser.add_argument("--seed", type=whole, default=1, help="the same number gives the same data set (default: %(default)s)")
    parser.add_argument("--sequences", type=count, default=40, help="to train with (default: %(default)s)")
    parser.add_argument("--test-sequences", type=count, default=10, help="unseen ones (default: %(default)s)")
    parser.add_argument("--frames", type=count, default=30, help="of each sequence, each drawn from all views (default: %(default)s)")
    parser.add_argument("--size", type=size, default="640x480")
    parser.add_argument("--format", default="bop", help="of fire3dv dataset; train.py reads %(default)s (default: %(default)s)")
    parser.add_argument("--texels", type=count, default=1024, help="side of the tissues' textures (default: %(default)s)")
    parser.add_argument("--cells", type=count, default=192, help="side of the tissues' grids (default: %(default)s)")
    parser.add_argument("--shards", type=count, default=1, help="processes that draw at once; a GPU serves several (default: %(default)s)")
    scene.add_options(parser)
    parser.add_argument("further", nargs="*", metavar="OPTION", help="of fire3dv dataset, after --")
    options = parser.parse_args()
    begin(options)
    started = time.monotonic()
    images = sum([draw(options, name) for name in ("train", "test")])
    print(f"{options.out}: {images} images, {60 * images / (time.monotonic() - started):.0f} a minute")


if __name__ == "__main__":
    run(main)
