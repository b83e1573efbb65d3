"""End-to-end test of fire3dv.Image: planes by attribute, names of instances, files, and warnings about node names.

python_images_test.py FIRE3DV [CASE...]
"""
import json
import math
import os
import struct
import subprocess
import sys
import time
import warnings
import zlib

import numpy

import fire3dv
from fire3dv._files import gray_png, png
from fire3dv._scene_names import SceneNames
from greedy_scene import Binary, write_glb
from harness import HANG_S, PLAIN_IMAGES, main, vulkan_environment
from image_reader import SIZE, check, read_gray_png, read_png, write_scene
from readme_commands import code_blocks

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../.."))
CAMERA = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 50]  # with fx 50 a unit of the scene is a pixel
ALL = ("color", "linear", "depth", "instance", "semantic", "normal", "motion", "boxes2d", "boxes3d", "albedo",
       "roughness", "metallic", "position", "occlusion")


def raised(kind, text, call):
    try:
        call()
    except kind as error:
        check(text in str(error), f"{text!r} is not in: {error}")
        return
    raise AssertionError(f"no {kind.__name__} was raised, expected: {text}")


def renderer_of(test, scene, *arguments):
    os.environ.update(vulkan_environment())
    plain = () if "path" in arguments else PLAIN_IMAGES
    return fire3dv.Renderer(scene, program=test.programs_at["fire3dv"], start_timeout_s=HANG_S,
                            arguments=["--validation", "--cache", "off", "--tone-map", "none", *plain, *arguments])


def planes(test):
    with renderer_of(test, test.scene) as renderer, renderer.stream("planes") as stream:
        check("not described" in repr(stream), repr(stream))
        stream.describe(["red"])
        stream.publish(1_500_000_000, [fire3dv.pose((-20, 0, 0))])
        with stream.request_image(*SIZE, parent_from_camera=CAMERA, fx=50, outputs=ALL) as request:
            image = request.wait(HANG_S)
            check("ImageRequest 1 of <fire3dv.Stream to shm://" in repr(request), repr(request))
        with image:
            check(f"{SIZE[0]}x{SIZE[1]} of color_srgb8" in repr(image) and "frame 1 at 1.5 s>" in repr(image), repr(image))
            for name in ALL:
                full = fire3dv.ALIASES.get(name, name)
                same = image[name], image[full], getattr(image, name)
                check(len({(a.ctypes.data, a.shape, a.dtype) for a in same}) == 1, f"{name} is another array by another name")
                check(name in image and full in image and full in image.outputs, name)
            names = image.names()
            check(sorted(names.values()) == ["blue", "green", "red"], f"{names}")
            [red] = [number for number, name in names.items() if name == "red"]
            y, x = numpy.nonzero(image.instance == red)
            check(abs(x.mean() + 0.5 - SIZE[0] / 2 + 20) < 1 and abs(y.mean() + 0.5 - SIZE[1] / 2 + 30) < 1, "red is elsewhere")
            check((numpy.median(image.color[y, x], axis=0) == (255, 0, 0, 255)).all(), "red is of another colour")
            check(numpy.abs(image.depth[y, x] - 50).max() < 1e-3, "red is at another depth")
            check(image.names(test.scene) == names, "the file gives other names")

            files = {"png": test.path("image.PNG"), "depth": test.path("depth.npy"), "boxes": test.path("boxes.npy")}
            image.save(files["png"])
            image.save(files["depth"], "depth")
            image.save(files["boxes"], output="boxes2d")
            picture = read_png(files["png"])
            check(b"".join(picture.rows) == image.color[..., :3].tobytes(), "the PNG has other pixels")
            check(picture.text == {"Epoch": f"{image.epoch:016x}", "Sequence": "1", "SimTimeNs": "1500000000"}, picture.text)
            check((numpy.load(files["depth"]) == image.depth).all(), "depth.npy has other numbers")
            check((numpy.load(files["boxes"]) == image.boxes2d).all(), "boxes.npy has other boxes")
            with open(files["png"], "rb") as file:
                check(file.read() == image._repr_png_(), "Jupyter shows another image")
            raised(fire3dv.ArgumentError, "holds color, depth, instance or semantic; write normal to a .npy",
                   lambda: image.save("x.png", "normal"))
            raised(fire3dv.ArgumentError, "name one of them as output", lambda: image.save("x.npy"))
            raised(fire3dv.ArgumentError, "neither with .png nor with .npy", lambda: image.save("x.jpg"))
            raised(KeyError, "occlusion exist); request_image", lambda: image["deep"])
        raised(fire3dv.StateError, "closed", lambda: image.depth)
        check(image._repr_png_() is None and "closed>" in repr(image), repr(image))
        image.release()  # the older name

        with stream.request_image(8, 8, fx=50, outputs=["depth"]).wait(HANG_S) as image:
            raised(AttributeError, "the image has no color_srgb8; request_image(outputs=...) asked for: depth_f32",
                   lambda: image.color)
            check(not hasattr(image, "instance") and image._repr_png_() is None, "there is more than depth")
            raised(fire3dv.StateError, "add \"instance\"", image.names)
            image.save(test.path("only.npy"))
            check((numpy.load(test.path("only.npy")) == image.depth).all(), "only.npy has other numbers")
        # Without a Renderer, the file must be named.
        other = fire3dv.Image(image_handle(stream))
        raised(fire3dv.StateError, "names(scene=\"FILE\")", other.names)
        raised(FileNotFoundError, "none.glb", lambda: other.names(test.path("none.glb")))


def image_handle(stream):
    return stream.request_image(8, 8, fx=50, outputs=["instance"]).wait(HANG_S)._handle


def pixels(test):
    """PNG files of random pixels and of the smallest sizes."""
    source = numpy.random.default_rng(1)
    for width, height in ((1, 1), (1, 7), (7, 1), (33, 20)):
        color = source.integers(0, 256, (height, width, 4), numpy.uint8)
        path = test.path("random.png")
        with open(path, "wb") as file:
            file.write(png(color[::-1], {"Key": "value"}))
        check(b"".join(read_png(path).rows) == color[::-1, :, :3].tobytes(), f"{width}x{height}: other pixels")
        values = source.integers(0, 65536, (height, width), numpy.uint16)
        with open(path, "wb") as file:
            file.write(gray_png(values, {"Key": "value"}))
        rows, text = read_gray_png(path)
        check((numpy.array(rows) == values).all() and text == {"Key": "value"}, f"{width}x{height}: other grey")
    check(zlib.crc32(b"IEND") == struct.unpack(">I", png(color, {})[-4:])[0], "the end is damaged")


class Planes(fire3dv.Image):
    """An image with planes of ours."""

    def __init__(self, **planes):
        self._handle, self._mine = True, planes
        self.epoch = self.sequence = self.sim_time_ns = 0

    def _array(self, output):
        return self._mine[fire3dv.ALIASES.get(output, output).split("_")[0]]


def gray(test):
    """Depth in millimetres and labels as 16-bit PNG files, at the ends of their ranges."""
    path = test.path("gray.png")
    metres = [0.0001, 0.0006, 1.2344, 1.2346, 65.5354, 65.536, 1e30, math.inf, math.nan]
    image = Planes(depth=numpy.array([metres], numpy.float32))
    image.save(path, "depth")
    rows, text = read_gray_png(path)
    check(rows == [(1, 1, 1234, 1235, 65535, 0, 0, 0, 0)], f"{rows}")
    check(text == {"Epoch": "0" * 16, "Sequence": "0", "SimTimeNs": "0", "Unit": "millimetre"}, f"{text}")
    Planes(instance=numpy.array([[0, 1, 65535]], numpy.uint32)).save(path, "instance_u32")
    check(read_gray_png(path)[0] == [(0, 1, 65535)], "other labels")
    image = Planes(semantic=numpy.array([[0, 65536]], numpy.uint32))
    raised(fire3dv.ArgumentError, "the semantic 65536 does not fit into 16 bits; write it to a .npy file",
           lambda: image.save(path, "semantic"))


Z_UP = [[1, 0, 0, 10], [0, 0, 1, 20], [0, -1, 0, 30]]  # world_from_stream, with an offset


def frames(test):
    """Poses of the camera in the world, in a stream with Z up, and of OpenCV, against numbers by hand."""
    eye, target = (1.0, -4.0, 2.0), (1.0, 0.0, 2.0)  # looks along the stream's +Y, its up is Z
    for scale in (1, 0.01):  # metres, and centimetres
        world_from_stream = numpy.array(Z_UP, float)
        world_from_stream[:, :3] *= scale
        with renderer_of(test, test.scene) as renderer, renderer.stream() as stream:
            stream.describe([], world_from_stream=world_from_stream)
            stream.publish(0, [])
            given = fire3dv.look_at(eye, target, up=(0, 0, 1))
            with stream.request_image(64, 48, fx=50, fy=40, cx=30, cy=20, parent_from_camera=given).wait(HANG_S) as image:
                pass
        check(numpy.allclose(image.world_from_stream, world_from_stream), f"{image.world_from_stream}")
        check(numpy.allclose(image.stream_from_camera, given, atol=1e-3), f"{image.stream_from_camera}")  # of float32
        # (x, y, z) of the stream is (x, z, -y) of the world.
        place = [10 + scale * 1, 20 + scale * 2, 30 + scale * 4]
        check(numpy.allclose(image.world_from_camera, [1, 0, 0, place[0], 0, 1, 0, place[1], 0, 0, 1, place[2]], atol=1e-5),
              f"{image.world_from_camera}")
        check(numpy.allclose(image.camera_matrix, [[50, 0, 30], [0, 40, 20], [0, 0, 1]]), f"{image.camera_matrix}")
        # In OpenCV's camera: x to the right of the view (the stream's x), y down (-z), z ahead (y).
        point = numpy.array([1.5, 0.0, 1.0, 1])
        seen = image.opencv_camera_from_stream @ point
        check(numpy.allclose(seen, [0.5, 1.0, 4.0, 1], atol=1e-3), f"{seen}")
        in_world = numpy.append(world_from_stream @ point, 1)
        seen_in_metres = image.opencv_camera_from_world @ in_world
        check(numpy.allclose(seen_in_metres[:3], scale * seen[:3], atol=1e-5), f"{seen_in_metres}")
        check(image.opencv_camera_from_world.shape == (4, 4) and image.stream_from_camera.dtype == numpy.float64, "shapes")
    words = fire3dv.Image.__doc__
    fields = ("request", "epoch", "sequence", "sim_time_ns", "number", "lost", "width", "height", "fx", "fy", "cx", "cy",
              "near_m", "far_m", "lens", "lens_coefficients", "f_number", "focus_distance_m", "hidden_streams", "world_from_camera")
    check(set(fields) == {name for name in vars(image) if not name.startswith("_")}, "other fields than in this list")
    for name in fields:
        check(name in words, f"help(fire3dv.Image) does not say what {name} is")
    for output in ("boxes2d", "boxes3d"):
        for name, *_ in fire3dv.OUTPUTS[output][0]:
            check(name in getattr(fire3dv.Image, output).__doc__ or name == "reserved", f"{output}.{name}")


def names(test):
    """Instance ids and names against the list that the renderer writes: order of the file, roots, instances, other scenes."""
    binary = Binary()
    mesh = {"primitives": [{**binary.quad(0.4), "material": 0}]}
    places = binary.accessor(struct.pack("<6f", -3, 2, 0, -1, 2, 0), 5126, 2, "VEC3")
    nodes = [{"name": "leaf", "mesh": 0, "translation": [3, 0, 0]}, {"name": "hidden", "mesh": 0},
             {"name": "second", "children": [4, 0]}, {"name": "grid", "mesh": 0, "extensions": {
                 "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}},
             {"mesh": 0, "translation": [0, -2, 0]}, {"name": "first", "mesh": 0, "children": [3]}]
    glb = test.path("names.glb")
    write_glb(glb, binary.document(
        scenes=[{"nodes": [1]}, {"nodes": [5, 2, 0]}], nodes=nodes, meshes=[mesh], materials=[{}],
        extensionsUsed=["EXT_mesh_gpu_instancing"]) | {"scene": 1}, binary.bytes)
    check(SceneNames(glb).names() == ["first", "grid", "grid", "grid", "second", "", "leaf"], f"{SceneNames(glb).names()}")
    arm = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../assets/robots/arm_description/urdf/arm.urdf")
    for scene, view in ((glb, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 8]), (arm, fire3dv.look_at((2, 1.5, 2), (0, 0.3, 0)))):
        with renderer_of(test, scene) as renderer, renderer.stream() as stream:
            stream.describe([])
            stream.publish(0, [])
            with stream.request_image(96, 96, fx=80, parent_from_camera=view, outputs=["instance", "boxes2d"]).wait(HANG_S) as image:
                shown = image.names()
                check(set(shown) == set(image.boxes2d["instance"].tolist()), f"{shown}")
        folder = test.path("listed")
        subprocess.run([test.programs_at["fire3dv"], scene, "--cache", "off", "--headless", "--size", "16x16", "--frames", "1",
                        "--outputs", "instance", "--out", folder], check=True, stderr=subprocess.DEVNULL)
        with open(os.path.join(folder, "instances.jsonl"), encoding="utf-8") as file:
            listed = {entry["instance"]: entry["name"] for entry in map(json.loads, file)}
        if scene == glb:  # the renderer's instances have no names of their own
            check(shown == {1: "first", 3: "grid", 4: "grid", 6: "", 7: "leaf"}, f"{shown}")
            check(listed == {**shown, 3: "", 4: ""}, f"{listed}")
        else:
            check(len(shown) >= 2 and shown.items() <= listed.items(), f"{shown} are not of {listed}")
    for text, fault in ((b"glTF\2", "is no glTF file"), (b"[]", "its JSON is not an object"),
                        (b'{"nodes":[{"children":[0]}],"scenes":[{"nodes":[3]}]}', "is not a valid glTF file")):
        with open(test.path("bad.gltf"), "wb") as file:
            file.write(text)
        raised(fire3dv.ArgumentError, fault, SceneNames(test.path("bad.gltf")).names)


def warned(test):
    """A wrong name is reported once for each describe(), with the name, at the line of the program."""
    with renderer_of(test, test.scene) as renderer, renderer.stream() as stream:
        for action in ("poll", "publish", "image", "close"):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                stream.add_node("mine")
                stream.describe(["red", "rot", "mine", "grün"])
                poses = [fire3dv.pose()] * 4
                sequence = stream.publish(0, poses)
                if action == "image":
                    stream.request_image(8, 8, fx=50, sequence=sequence).wait(HANG_S).close()
                end = time.monotonic() + HANG_S
                while not caught and action != "close" and time.monotonic() < end:
                    stream.poll() if action == "poll" else stream.publish(0, poses)
                check(caught or action == "close", f"{action}: no warning came")
                if action == "close":
                    time.sleep(1)  # the answer must be there; a busy machine only makes this case weaker
                    stream.close()
                for _ in range(3 if stream.is_open else 0):
                    stream.poll()
            texts = [str(w.message) for w in caught]
            check(texts == ["the scene has no node, or several, for 2 of the 4 nodes of describe(): rot, grün"]
                  or action == "close" and not texts, f"{action}: {texts}")
            check(all(w.filename == __file__ and w.category is fire3dv.SceneWarning for w in caught), f"{caught}")
    with renderer_of(test, test.scene) as renderer, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with renderer.stream() as stream:
            stream.describe(["red"])
            stream.publish(0, [numpy.zeros((3, 4))])
            caught.clear()  # that of the library itself
            stream.request_image(8, 8, fx=50, sequence=1).wait(HANG_S).close()
            end = time.monotonic() + HANG_S
            while not caught and time.monotonic() < end:
                stream.poll()
        check(len(caught) == 1 and "the renderer says: this stream has poses of zeros only for 1 node" in str(caught[0].message),
              f"{[str(w.message) for w in caught]}")
    with renderer_of(test, test.scene) as renderer, warnings.catch_warnings():
        warnings.simplefilter("error")
        with renderer.stream() as stream:  # no warning where all is right
            stream.describe(["red", "blue"])
            stream.publish(0, [fire3dv.pose()] * 2)
            stream.request_image(8, 8, fx=50, sequence=1).wait(HANG_S).close()


def text_of(caught):
    return "\n".join(str(each.message) for each in caught)


def advised(test):
    """Edits without effect, each once; a name that several nodes have, with the paths that it may mean."""
    write_scene(test.path("pole.glb"), squares={"pole": ((1, 1, 1), 0)})
    with open(test.path("pole.glb"), "rb") as file:
        pole = file.read()
    with renderer_of(test, test.scene) as renderer, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with renderer.stream() as stream:
            stream.describe(["red"])
            poses = [fire3dv.pose()]
            stream.publish(0, poses)
            stream.add_node("broken", asset_glb=b"abc")
            check(len(caught) == 1 and "asset_glb of the node 'broken' is no .glb file" in text_of(caught), text_of(caught))
            stream.set_base_color("nope", (1, 0, 0, 1))
            stream.set_light("nada", fire3dv.POINT)
            stream.set_visible("none", False)
            stream.set_base_color("red", (1, 0, 0, 0.3))
            expected = ["no scene node is called \"nope\"", "no scene node is called \"nada\"", "no scene node is called \"none\"",
                        "the node \"red\" stays opaque"]
            end = time.monotonic() + HANG_S
            while not all(text in text_of(caught) for text in expected) and time.monotonic() < end:
                stream.publish(0, poses)
                time.sleep(0.02)
            for _ in range(20):
                stream.publish(0, poses)
                stream.poll()
            check(all(text_of(caught).count(text) == 1 for text in expected), text_of(caught))
            check(len(caught) == 1 + len(expected), text_of(caught))
            check(all(each.filename == __file__ and each.category is fire3dv.SceneWarning for each in caught), f"{caught}")

            caught.clear()
            for i in range(2):
                stream.add_node(f"env{i}", asset_glb=pole)
            stream.describe(["pole", "env1/pole"])
            wanted = "write paths: \"pole\" is \"env0/pole\" or \"env1/pole\""
            while wanted not in text_of(caught) and time.monotonic() < end:
                stream.publish(0, poses * 2)
                time.sleep(0.02)
            check("the scene has no node, or several, for 2 of the 2 nodes of describe(): pole" in text_of(caught)
                  or "for 1 of the 2 nodes" in text_of(caught), text_of(caught))
            check(text_of(caught).count(wanted) == 1, text_of(caught))


def added(test):
    """Nodes that a stream adds have names in the images that show them, also after others have gone."""
    write_scene(test.path("part.glb"), squares={"part": ((1, 1, 1), 0)}, place=0)
    with open(test.path("part.glb"), "rb") as file:
        part = file.read()
    with renderer_of(test, test.scene) as renderer, renderer.stream() as stream:
        for i in range(3):
            stream.add_node(f"box {i}", asset_glb=part, parent_from_node=fire3dv.pose((-40 + 30 * i, 0, 1)))
        stream.describe([])
        found = []
        for step in range(3):
            sequence = stream.publish(step, [])
            image = stream.request_image(*SIZE, parent_from_camera=CAMERA, fx=50, outputs=["instance"], sequence=sequence).wait(HANG_S)
            found.append(image)
            if step == 0:
                check(image.names(test.scene).keys() < image.names().keys(), "the file has names of added nodes")
                stream.remove_node("box 0")
            elif step == 1:
                stream.add_node("box 3", asset_glb=part, parent_from_node=fire3dv.pose((-40, 0, 1)))
        boxes = [sorted(name for name in image.names().values() if name.startswith("box")) for image in found]
        for image, names_of_image in zip(found, boxes):
            ids = {name: number for number, name in image.names().items()}
            for name in names_of_image:
                columns = numpy.nonzero(image.instance == ids[name])[1]
                place = -40 + 30 * (int(name[4]) % 3)
                check(abs(columns.mean() + 0.5 - SIZE[0] / 2 - place * 50 / 49) < 1, f"{name} is at column {columns.mean()}")
    check(boxes == [["box 0/part", "box 1/part", "box 2/part"], ["box 1/part", "box 2/part"],
                    ["box 1/part", "box 2/part", "box 3/part"]], f"{boxes}")


LENS = {"f_number": 0.125, "focus_distance_m": 1}
LENS_OPTIONS = ("--f-number", "0.125", "--focus-distance", "1")
VIEW = {"parent_from_camera": CAMERA, "fx": 50}
FOV = 2 * math.atan(SIZE[1] / 100)


def taken(stream, **request):
    """Returns the color of an image, and the lens that it names."""
    with stream.request_image(*SIZE, **request).wait(HANG_S) as image:
        return image.color.copy(), (image.f_number, image.focus_distance_m)


def still_stream(renderer):
    stream = renderer.stream("lens")
    stream.describe([])
    stream.publish(0, [])
    return stream


def lens(test):
    """A lens by request, by a camera of the stream and by options gives the same bytes; each image names its lens."""
    recording = test.path("lens.mcap")
    with renderer_of(test, test.scene, "--record", recording) as renderer, still_stream(renderer) as stream:
        sharp, used = taken(stream, **VIEW)
        check(used == (0, 0), f"a pinhole says {used}")
        blurred, used = taken(stream, **VIEW, **LENS)
        check(used == (0.125, 1) and (blurred != sharp).any(), f"the request's lens: {used}")

        stream.set_camera("front", FOV)
        stream.publish(1_000_000_000, [])
        check((taken(stream, node="front", fx=50)[0] == sharp).all(), "the camera without a lens blurs")
        stream.set_camera("front", FOV, **LENS)
        stream.publish(2_000_000_000, [])
        for name, request in (("the camera's lens", {}), ("its own projection", {"fx": 0})):
            image, used = taken(stream, node="front", **{"fx": 50, **request})
            check(used == (0.125, 1) and (image != sharp).any(), f"{name}: {used}")
            check(request or (image == blurred).all(), f"{name} gives other bytes than the request's")
        image, used = taken(stream, node="front", fx=50, f_number=0.25, focus_distance_m=2)
        check(used == (0.25, 2) and (image != blurred).any(), f"the camera's lens replaces the request's: {used}")
        with stream.request_image(*SIZE, node="front", fx=50, outputs=["depth"]).wait(HANG_S) as image:
            check((image.f_number, image.focus_distance_m) == (0, 0), "depth is of a pinhole, and says a lens")
        focus = {1: blurred.tobytes()}
        for second, metres in ((3, 2), (4, 50)):
            stream.set_camera("front", FOV, f_number=0.125, focus_distance_m=metres)
            sequence = stream.publish(second * 1_000_000_000, [])
            image, used = taken(stream, node="front", fx=50, sequence=sequence)
            check(used == (0.125, metres), f"the moving focus: {used}")
            focus[metres] = image.tobytes()
        check(len(set(focus.values())) == 3, "the focus does not move")
        def loss(image):
            return numpy.abs(numpy.frombuffer(image, numpy.uint8).astype(int) - sharp.ravel()).mean()
        check(loss(focus[50]) < 0.02 * loss(focus[1]), f"in focus: {loss(focus[50])}, off focus: {loss(focus[1])}")
        raised(fire3dv.ArgumentError, "focus_distance_m is 0 beside f_number 2; a lens needs both",
               lambda: stream.request_image(8, 8, fx=50, f_number=2))

    with renderer_of(test, test.scene, *LENS_OPTIONS) as renderer, still_stream(renderer) as stream:
        image, used = taken(stream, **VIEW)
        check(used == (0.125, 1) and (image == blurred).all(), f"the options' lens gives other bytes: {used}")
        check(taken(stream, **VIEW, f_number=0.25, focus_distance_m=2)[1] == (0.25, 2), "options replace the request's lens")
    with renderer_of(test, test.scene, "--raster", "forward") as renderer, still_stream(renderer) as stream:
        raised(fire3dv.RefusedError, "draws no depth of field", lambda: taken(stream, **VIEW, **LENS))
        check(taken(stream, **VIEW)[1] == (0, 0), "the forward path says a lens")
    traced = []
    for arguments, request in (((), LENS), (LENS_OPTIONS, {})):
        with renderer_of(test, test.scene, "--render", "path", "--spp", "4", "--bounces", "0", *arguments) as renderer:
            with still_stream(renderer) as stream:
                if request:
                    pinhole = taken(stream, **VIEW)[0]
                traced.append(taken(stream, **VIEW, **request))
    check(traced[0][1] == traced[1][1] == (0.125, 1), f"paths: {traced[0][1]}, {traced[1][1]}")
    check((traced[0][0] == traced[1][0]).all() and (traced[0][0] != pinhole).any(), "paths have another lens by request")

    frames = []
    for number, arguments in enumerate(((), LENS_OPTIONS)):
        folder = test.path(f"rendered{number}")
        subprocess.run([test.programs_at["fire3dv"], "render", recording, test.scene, "--out", folder, "--fps", "1", "--cache",
                        "off", "--size", f"{SIZE[0]}x{SIZE[1]}", *arguments], check=True, stderr=subprocess.DEVNULL)
        frames.append([read_png(os.path.join(folder, f"frame_{second:06}.png")).rows for second in range(5)])
    check(frames[0][1] != frames[0][2] != frames[0][3], "a recording shows no lens")
    check(frames[0][2] == frames[1][1], "the lens of a recorded camera is another one than by options")
    check(frames[0][2:] == frames[1][2:], "options replace the lens of a recorded camera")


def lens_example(test):
    """The example of docs/camera-effects.md."""
    with open(os.path.join(ROOT, "docs/camera-effects.md"), encoding="utf-8") as file:
        snippet = code_blocks(file.read(), "python")[0]
    with renderer_of(test, test.scene) as renderer:
        check(snippet.count("shm://demo") == 1 and snippet.count("camera_front") == 2, snippet)
        done = subprocess.run([sys.executable, "-W", "error", "-c",
                               snippet.replace("shm://demo", renderer.uri).replace("camera_front", "front")],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=HANG_S, text=True)
    check(done.returncode == 0 and done.stdout.splitlines() == ["focus at 1 m", "focus at 2 m", "focus at 4 m"], done.stdout)


if __name__ == "__main__":
    main({"planes": planes, "pixels": pixels, "gray": gray, "frames": frames, "names": names, "warned": warned, "advised": advised, "added": added, "lens": lens, "lens_example": lens_example},
         ["fire3dv"])
