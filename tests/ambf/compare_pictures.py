"""Image comparison of AMBF's own renderer with fire3dv, from the same camera and of the same bodies.

tests/ambf/pictures_plugin.cpp has written AMBF's images to a folder: one of all objects and one of each object. This
script renders the same views with fire3dv, from a scene that fire3dv-convert made of the same launch file. For all
objects together and for each alone it prints the intersection over union of the silhouettes and the distance of their
centroids. A silhouette is the set of pixels that differ from the image without objects.

    tests/ambf/compare_pictures.py --pictures FOLDER --scene SCENE.glb --out FOLDER BUILD
"""
import argparse
import glob
import json
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "adapters/generic/python"))
WORLD_FROM_STREAM = [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0]
FEW = 20  # pixels; smaller silhouettes are not significant


class Image:
    def __init__(self, path):
        data = open(path, "rb").read() if path.endswith(".ppm") else subprocess.run(
            ["ffmpeg", "-loglevel", "error", "-i", path, "-f", "image2pipe", "-c:v", "ppm", "-pix_fmt", "rgb24", "-"],
            check=True, capture_output=True).stdout
        fields = data.split(maxsplit=3)
        self.width, self.height = int(fields[1]), int(fields[2])
        self.pixels = data[-self.width * self.height * 3:]

    def rows(self):
        step = self.width * 3
        return (self.pixels[i:i + step] for i in range(0, len(self.pixels), step))


def covered(image, none):
    """Returns the indices of the pixels that differ from the image without objects."""
    found = set()
    for y, (row, bare) in enumerate(zip(image.rows(), none.rows())):
        if row == bare:
            continue
        found.update(y * image.width + x for x in range(image.width)
                     if max(abs(a - b) for a, b in zip(row[3 * x:3 * x + 3], bare[3 * x:3 * x + 3])) > 2)
    return found


def middle(pixels, width):
    return (sum(p % width for p in pixels) / len(pixels), sum(p // width for p in pixels) / len(pixels))


def compared(name, theirs, ours, width):
    either = len(theirs | ours)
    line = {"name": name, "theirs": len(theirs), "ours": len(ours), "iou": len(theirs & ours) / either if either else 1}
    if theirs and ours:
        (ax, ay), (bx, by) = middle(theirs, width), middle(ours, width)
        line["apart_px"] = ((ax - bx) ** 2 + (ay - by) ** 2) ** 0.5
    return line


def draw(args, told):
    """Renders one image of all objects, one of none, and one of each object; returns their files in this order."""
    import fire3dv
    shown = [o for o in told["objects"] if o["drawn"]]
    keys = [o["key"] for o in shown]
    uri = f"shm://pictures-{os.getpid()}"
    names = [o["key"] for o in told["objects"]]
    poses = [x for o in told["objects"] for x in o["pose"]]
    os.makedirs(args.out, exist_ok=True)
    for old in glob.glob(os.path.join(args.out, "*.png")):
        os.remove(old)
    command = [os.path.join(args.build, "bin/fire3dv"), args.scene, "--listen", uri, "--headless", "--lockstep",
               "--camera", told["camera"], "--size", f"{told['width']}x{told['height']}", "--out", args.out,
               "--exit-when-done", *args.options]
    renderer = subprocess.Popen(command)
    with fire3dv.Stream(uri, adapter_name="pictures") as stream:
        stream.describe(names, world_from_stream=WORLD_FROM_STREAM)
        # First image: all objects. Second: none. Then one object at a time.
        for number in range(len(shown) + 2):
            if number == 1:
                for key in keys:
                    stream.set_visible(key, False)
            if number > 2:
                stream.set_visible(keys[number - 3], False)
            if number > 1:
                stream.set_visible(keys[number - 2], True)
            stream.publish(number, poses)
            while not stream.wait_ack(number + 1, 1000):
                if renderer.poll() is not None:
                    sys.exit(f"fire3dv ended with {renderer.returncode}")
        message = stream.poll().welcome_message
    renderer.wait()
    print("the renderer says:", message)
    files = sorted(glob.glob(os.path.join(args.out, "*.png")))
    if len(files) < len(shown) + 2:
        sys.exit(f"{len(files)} images came of {len(shown) + 2} frames")
    return shown, files[len(files) - len(shown) - 2:]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", required=True, help="folder that pictures_plugin.cpp wrote to")
    parser.add_argument("--scene", required=True, help="the same scene, converted")
    parser.add_argument("--out", required=True, help="folder for our pictures")
    parser.add_argument("build", help="build folder of this project")
    parser.add_argument("options", nargs="*", help="more options of fire3dv, behind --")
    args = parser.parse_args()
    os.environ.setdefault("FIRE3DV_CLIENT_LIBRARY",
                          glob.glob(os.path.join(args.build, "lib*/**/libfire3dv-client.so"), recursive=True)[0])
    with open(os.path.join(args.pictures, "pictures.json"), encoding="utf-8") as file:
        told = json.load(file)
    shown, files = draw(args, told)
    theirs = lambda name: Image(os.path.join(args.pictures, f"{name}.ppm"))
    bare_theirs, bare_ours, width = theirs("none"), Image(files[1]), told["width"]
    lines = [compared("everything", covered(theirs("all"), bare_theirs), covered(Image(files[0]), bare_ours), width)]
    for number, one in enumerate(shown):
        lines.append(compared(one["key"], covered(theirs(number), bare_theirs), covered(Image(files[number + 2]), bare_ours),
                              width))
    for line in lines:
        if line["theirs"] or line["ours"]:
            print(f"{line['theirs']:8} {line['ours']:8} pixels  {line['iou']:.4f} in common  "
                  f"{line.get('apart_px', float('nan')):6.3f} px apart  {line['name']}")
    # Ghost objects are sensor volumes without a visible body: printed above, excluded from the sum.
    seen = [line for line, one in zip(lines[1:], shown) if line["theirs"] >= FEW and one["kind"] == 0]
    print(f"{len(seen)} rigid bodies of at least {FEW} pixels: {min(line['iou'] for line in seen):.4f} in common at least, "
          f"{max(line.get('apart_px', float('inf')) for line in seen):.3f} px apart at most")


if __name__ == "__main__":
    main()
