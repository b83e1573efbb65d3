#!/usr/bin/env python3
"""Start-up time to the first image, with and without a cache.

    start.py --scene 7M-textured.glb
    start.py --scene 223K.glb --runs 7 -- --samples 1 --shadows off     # further options are fire3dv's own
    start.py --scene 223K.glb --beside "f3d --dry-run --output {image} {scene}"     # beside another program's, in alternation

Each run is a process of its own, which writes one image. Cold runs find an empty cache, warm ones that of the run before; a
driver's own cache of compiled shaders is warm in both, after one run that does not count. Between a cold and a warm one is one
more, not counted, which finds what the cold one has just written and may still be on its way to the disk. Prints a Markdown table of medians:
points in time after the program's begin, as fire3dv says them, and the whole process with its processor time. Beside another program
it prints the ratio of the whole processes, of each cold and warm start to the other's run after them: above 1 FIRE-3DV is the faster one.
"""
import argparse
import os
import pathlib
import re
import resource
import shlex
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

STAGES = ("renderer", "scene", "scene on the device", "first image")


def run(program, scene, cache, out, options):
    """Milliseconds by stage; the whole process and its processor time."""
    command = [program, scene, "--headless", "--frames", "1", "--out", out, "--cache", cache, *options]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.perf_counter()
    result = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    took = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    said = re.search(r"^  start +(.*)$", result.stderr, re.MULTILINE)
    if result.returncode != 0 or not said:
        sys.exit(f"start.py: {' '.join(command)} ended with {result.returncode}:\n{result.stderr[-2000:]}")
    times = {}
    for part in said.group(1).split(", "):
        name, ms = re.fullmatch(r"(.*) (\d+) ms", part).groups()
        times[name.replace(" from the cache", "")] = float(ms)
    times["process"] = 1000 * took
    times["CPU"] = 1000 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return times, "scene from the cache" in said.group(1)


def run_other(command, scene, image):
    """Milliseconds of the whole process of a program that writes one image."""
    if os.path.exists(image):
        os.remove(image)
    begin = time.perf_counter()
    result = subprocess.run([part.format(scene=scene, image=image) for part in shlex.split(command)], capture_output=True, text=True,
                            errors="replace", check=False)
    took = time.perf_counter() - begin
    if result.returncode != 0 or not os.path.exists(image):
        sys.exit(f"start.py: {command} ended with {result.returncode} and without an image:\n{result.stderr[-2000:]}")
    return 1000 * took


def ratio_row(kind, ours, others):
    ratios = sorted(other / times["process"] for times, other in zip(ours, others))
    return (f"| {kind} | {statistics.median(t['process'] for t in ours):.0f} | {statistics.median(others):.0f} "
            f"| {statistics.median(ratios):.2f} | {ratios[0]:.2f} | {ratios[-1]:.2f} |")


def main():
    options = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", required=True)
    parser.add_argument("--runs", type=int, default=5, help="of each kind")
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--beside", metavar="COMMAND", help="of another program; {scene} and {image} stand for files")
    parser.add_argument("--program", default=str(pathlib.Path("build/release/bin/fire3dv")))
    arguments = parser.parse_args([a for a in sys.argv[1:sys.argv.index("--")]] if "--" in sys.argv else None)
    options = ["--size", arguments.size, *options]
    rows, others = {"cold": [], "warm": []}, []
    with tempfile.TemporaryDirectory(prefix="fire3dv-start-") as folder:
        cache, out = os.path.join(folder, "cache"), os.path.join(folder, "out")
        image = os.path.join(folder, "other.png")
        run(arguments.program, arguments.scene, cache, out, options)
        if arguments.beside:
            run_other(arguments.beside, arguments.scene, image)
        for _ in range(arguments.runs):
            shutil.rmtree(cache, ignore_errors=True)
            rows["cold"].append(run(arguments.program, arguments.scene, cache, out, options)[0])
            run(arguments.program, arguments.scene, cache, out, options)
            times, kept = run(arguments.program, arguments.scene, cache, out, options)
            if not kept:
                print("start.py: the scene is too small to be kept: cold and warm are the same", file=sys.stderr)
            rows["warm"].append(times)
            if arguments.beside:
                others.append(run_other(arguments.beside, arguments.scene, image))
    columns = (*STAGES, "process", "CPU")
    print("| start | " + " | ".join(f"{c}, ms" for c in columns) + " |")
    print("|---" * (len(columns) + 1) + "|")
    for kind, runs in rows.items():
        print(f"| {kind} | " + " | ".join(f"{statistics.median(r[c] for r in runs):.0f}" for c in columns) + " |")
    if arguments.beside:
        print("\n| start | FIRE-3DV ms | other ms | ratio | from | to |\n|---|---|---|---|---|---|")
        print("\n".join(ratio_row(kind, runs, others) for kind, runs in rows.items()))
    print(f"\n{arguments.scene}, {arguments.runs} runs of each kind, options: {' '.join(options)}")


if __name__ == "__main__":
    main()
