#!/usr/bin/env python3
"""FIRE-3DV beside another program on the same scenes, in alternation: medians of both, and the ratio of each round.

A command is a template: {scene} stands for the file. It is run as it stands, without a shell. What is compared is

  row      the median in milliseconds that a command prints itself, in the sixth column of a table row (`| program | scene
           | settings | size | frames | median ms | ...`), as `fire3dv-bench images` does; both sides have to include
           reading the image back
  process  how long the whole command takes; one run of each comes before those that count

A display that the other program needs is started around this script, so that it is not timed:

    xvfb-run -a peers.py --scene 223K.glb --ours "build/lab/bin/fire3dv-bench images {scene} --samples 1 --shadows off" \\
             --peer "ogre_bench --scene {scene} --shadows 0" --name "OGRE 1.12"
    xvfb-run -a peers.py --value process --scene 223K.glb --ours "fire3dv {scene} --headless --frames 1 --size 640x480 --out images" \\
             --peer "f3d --quiet --resolution 640,480 --output b.png {scene}" --name "f3d 1.3"
"""
import argparse
import pathlib
import shlex
import statistics
import subprocess
import sys
import time


def fail(text):
    sys.exit(f"peers.py: {text}")


def run(command):
    """Seconds that it took, and what it printed."""
    begin = time.perf_counter()
    try:
        result = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    except OSError as error:
        fail(f"{command[0]} cannot be run: {error.strerror}")
    took = time.perf_counter() - begin
    if result.returncode != 0:
        fail(f"{shlex.join(command)} ended with {result.returncode}:\n{result.stderr[-2000:]}")
    return took, result.stdout


def median_of_row(command, text):
    rows = [line for line in text.splitlines() if line.startswith("|")]
    cells = rows[-1].split("|")[1:-1] if rows else []
    try:
        value = float(cells[5])
    except (IndexError, ValueError):
        fail(f"{shlex.join(command)} printed no row whose sixth column is a number:\n{text[-2000:]}")
    if not value > 0:
        fail(f"{shlex.join(command)} printed a median of {value} ms")
    return value


def measure(command, value):
    took, text = run(command)
    return 1000 * took if value == "process" else median_of_row(command, text)


def commands_for(template, scene):
    try:
        command = shlex.split(template)
    except ValueError as error:
        fail(f"{template!r} is not a command: {error}")
    if not any("{scene}" in word for word in command):
        fail(f"{template!r} lacks {{scene}}")
    return [word.replace("{scene}", str(scene)) for word in command]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", type=pathlib.Path, action="append", required=True, help="may be given several times")
    parser.add_argument("--ours", required=True, help="command of FIRE-3DV")
    parser.add_argument("--peer", required=True, help="command of the other program")
    parser.add_argument("--name", default="peer", help="what the other program is called in the table")
    parser.add_argument("--value", choices=("row", "process"), default="row", help="what is compared")
    parser.add_argument("--rounds", type=int, default=5, help="alternations (default 5)")
    options = parser.parse_args()
    if not 1 <= options.rounds <= 1000:
        parser.error("--rounds must be 1 to 1000")
    for scene in options.scene:
        if not scene.is_file():
            fail(f"{scene} is not a file")

    print(f"| scene | FIRE-3DV ms | {options.name} ms | times faster: median of {options.rounds} rounds | from | to |")
    print("|---|---|---|---|---|---|", flush=True)
    for scene in options.scene:
        sides = [commands_for(options.ours, scene), commands_for(options.peer, scene)]
        if options.value == "process":
            for command in sides:
                run(command)  # warm-up of caches
        rounds = [[measure(command, options.value) for command in sides] for _ in range(options.rounds)]
        ours, peer = zip(*rounds)
        ratios = [theirs / own for own, theirs in rounds]
        print(f"| {scene.stem} | {statistics.median(ours):.1f} | {statistics.median(peer):.1f} | "
              f"{statistics.median(ratios):.2f} | {min(ratios):.2f} | {max(ratios):.2f} |", flush=True)


if __name__ == "__main__":
    main()
