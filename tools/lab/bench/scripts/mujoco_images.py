#!/usr/bin/env python3
"""A step with colour, depth and labels in lockstep, by FIRE-3DV and by MuJoCo's own offscreen renderer, in alternation.

    mujoco_images.py --programs build/lab/bin panda/scene.xml humanoid100.xml [--sizes 64x64,640x480] [--blocks 7] [--seconds 200]

For each model, kind of shadows and size a renderer is started, fire3dv-mujoco-compare takes turns between both, and a row of a Markdown
table is printed: medians in milliseconds, and the median over turns of MuJoCo's time to ours, above 1 where FIRE-3DV is the faster one. Shadows:

  off   --shadows off; MuJoCo draws none
  map   --shadows map, and MuJoCo's maps of its default 4096 texels
  ray   as by default, with rays where maps cannot tell, beside MuJoCo's maps

One sample a pixel both, and no smoothing afterwards. What does not fit into --seconds is left out, and said.
"""
import argparse
import os
import subprocess
import sys
import tempfile
import time

SHADOWS = {"off": ("off", "0"), "map": ("map", "4096"), "ray": ("auto", "4096")}


def rows(arguments, folder):
    def program(name):
        return os.path.join(arguments.programs, name)
    begin = time.monotonic()
    for number, model in enumerate(arguments.models):
        scene = os.path.join(folder, f"{number}.glb")
        subprocess.run([program("fire3dv-mujoco"), model, "--scene", scene], check=True, stderr=subprocess.DEVNULL)
        for shadows in arguments.shadows.split(","):
            ours, texels = SHADOWS[shadows]
            for size in arguments.sizes.split(","):
                if time.monotonic() - begin > arguments.seconds:
                    print(f"left out: {model}, {size}, shadows {shadows}", file=sys.stderr)
                    continue
                uri = f"shm://mujoco-images-{os.getpid()}"
                renderer = subprocess.Popen([program("fire3dv"), scene, "--headless", "--on-request", "--listen", uri, "--samples", "1",
                                             "--fxaa", "off", "--shadows", ours], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
                try:
                    result = subprocess.run([program("fire3dv-mujoco-compare"), model, "--to", uri, "--speed", "--images",
                                             f"free camera:{size}", "--blocks", str(arguments.blocks), "--frames", str(arguments.frames),
                                             "--shadow-texels", texels,
                                             *(["--no-reflections"] if arguments.no_reflections else [])], stdout=subprocess.PIPE,
                                            stderr=subprocess.PIPE, text=True, check=False)
                finally:
                    renderer.terminate()
                    renderer.wait()
                if result.returncode != 0:
                    sys.exit(f"mujoco_images.py: {model}, {size}: {result.stderr}")
                _, _, _, _, *times = (cell.strip() for cell in result.stdout.strip().strip("|").split("|"))
                # Model collections name every scene file "scene", so the folder's name is used.
                name = os.path.splitext(os.path.basename(model))[0]
                name = os.path.basename(os.path.dirname(os.path.abspath(model))) if name == "scene" else name
                yield f"| {name} | {size} | {shadows} | " + " | ".join(times) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("models", nargs="+", help="MJCF files")
    parser.add_argument("--programs", default="build/lab/bin", help="folder of the programs (default: %(default)s)")
    parser.add_argument("--sizes", default="64x64,256x256,640x480")
    parser.add_argument("--shadows", default="off,map,ray")
    parser.add_argument("--blocks", type=int, default=7, help="turns of each renderer")
    parser.add_argument("--frames", type=int, default=5, help="in each turn")
    parser.add_argument("--seconds", type=float, default=3600, help="begin nothing after so many")
    parser.add_argument("--no-reflections", action="store_true", help="MuJoCo's floors do not reflect, as ours do not")
    arguments = parser.parse_args()
    print("| model | size | shadows | FIRE-3DV, ms | MuJoCo, ms | MuJoCo / FIRE-3DV |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for row in rows(arguments, folder):
            print(row, flush=True)


if __name__ == "__main__":
    main()
