"""Test of clients in C and Python, and of the MuJoCo adapter, whose renderer answers requests with lies: no image reaches the program, and no
exception other than fire3dv.Error.

python_lying_renderer_test.py LYING_RENDERER IMAGE_EXAMPLE [FIRE3DV_MUJOCO MODEL]
"""
import ctypes
import glob
import subprocess
import sys
import tempfile

import fire3dv
from fire3dv import _library as c
from fire3dv.image import Handle, Image

RENDERER, EXAMPLE, *MUJOCO = sys.argv[1:]
LIES = {"planes": "it has no outputs instead of color_srgb8", "output": "it has depth_f32 instead of color_srgb8",
        "size": "it has 1 x 1 pixels instead of 320 x 240 pixels", "lens": "it has another lens than its request",
        "sequence": "it shows frame 18446744073709551615, but 1 is the newest that was published"}


class Renderer:
    def __init__(self, lie):
        self.process = subprocess.Popen([RENDERER, "tcp://127.0.0.1:0", lie], stdout=subprocess.PIPE, text=True)
        self.uri = self.process.stdout.readline().strip()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()


def python_image(uri):
    with fire3dv.Stream(uri, "test") as stream:
        stream.describe(["node"])
        stream.publish(1, [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]])
        request = stream.request_image(320, 240, fx=300)
        try:
            image = request.wait(30 if uri_is_honest else 2)
            return image.color.sum(), stream.poll().images_dropped
        except fire3dv.Error as error:
            return str(error), stream.poll().images_dropped


def mujoco_images(uri):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([*MUJOCO, "--to", uri, "--images", "chaser:32x24", "--duration", "0.1", "--out", folder], check=True,
                       capture_output=True, timeout=120)
        return len(glob.glob(folder + "/**/*.png", recursive=True))


for lie, why in {"none": None, **LIES}.items():
    uri_is_honest = why is None
    with Renderer(lie) as renderer:
        example = subprocess.run([EXAMPLE, renderer.uri], capture_output=True, text=True, timeout=120)
        assert example.returncode == 0, (lie, example)
        result, dropped = python_image(renderer.uri)
        if uri_is_honest:
            assert example.stdout == f"sum {320 * 240 * 4 * 7}\n", example
            assert (result, dropped) == (320 * 240 * 4 * 7, 0), result
        else:
            assert why in example.stdout, (lie, example)
            assert why in result and dropped == 1, (lie, result, dropped)
        if MUJOCO:
            assert (mujoco_images(renderer.uri) > 0) == uri_is_honest, lie

# An image of a library that knows more lenses and outputs than this module.
plane = c.ImagePlane(1 << 20, 0, 0, 0, None)
raw = c.Image(lens=9, plane_count=1, planes=ctypes.pointer(plane))


class Borrowed(Handle):
    def __del__(self):
        pass


try:
    Image(Borrowed(ctypes.pointer(raw)))
    raise AssertionError("an unknown lens was accepted")
except fire3dv.Error as error:
    assert "lens 9" in str(error), error
raw.lens = 0
assert "color" not in Image(Borrowed(ctypes.pointer(raw)))
