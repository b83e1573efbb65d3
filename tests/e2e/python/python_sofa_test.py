"""Test of fire3dv.sofa with a stand-in of the objects that SofaPython3 gives: SOFA itself is not run. The stand-in deforms
and cuts a small mesh; positions and labels of the images agree with its arrays.

python_sofa_test.py FIRE3DV [CASE...]
"""
import os
import struct
import sys
import time
import types
import warnings

import numpy as np

import fire3dv
import fire3dv.sofa
from harness import HANG_S, main, vulkan_environment
from image_reader import check

SIDE = 7  # vertices along a side of the sheet
MILLIMETRE = 0.001
TISSUE = "Default Diffuse 1 0.8 0.1 0.1 1 Ambient 1 0.2 0.2 0.2 1 Specular 1 1 1 1 1 Emissive 0 0 0 0 0 Shininess 1 45 "
PIXEL = (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1\x08\2\0\0\0\x90wS\xde\0\0\0\x0cIDATx\x9cc\xf8\xcf\xc0\0\0\3\1\1\0\xc9\xfe\x92\xef"
         b"\0\0\0\0IEND\xaeB`\x82")


class Data:
    def __init__(self, value):
        self.set(value)

    def set(self, value):
        """Arrays are views of SOFA's memory that cannot be written to."""
        self.value = np.array(value) if isinstance(value, (list, np.ndarray)) else value
        if isinstance(self.value, np.ndarray):
            self.value.flags.writeable = False


class Object:
    """A component: Data fields by name, as attributes and by findData."""

    def __init__(self, kind, name, template="", **fields):
        self._kind, self._name, self._template, self.path = kind, name, template, name
        self._fields = {key: Data(value) for key, value in fields.items()}

    def __getattr__(self, name):
        fields = self.__dict__.get("_fields", {})
        if name not in fields:
            raise AttributeError(name)
        return fields[name]

    def findData(self, name):
        return self._fields.get(name)

    def getName(self):
        return self._name

    def getClassName(self):
        return self._kind

    def getTemplateName(self):
        return self._template

    def getPathName(self):
        return self.path


class Node(Object):
    def __init__(self, name, **fields):
        super().__init__("DAGNode", name, **fields)
        self.objects, self.children = [], []

    def addObject(self, item):
        item.path = f"{self.path.rstrip('/')}/{item.getName()}"
        self.objects.append(item)
        return item

    def addChild(self, name):
        child = Node(name)
        child.path = f"{self.path.rstrip('/')}/{name}"
        self.children.append(child)
        return child


def sheet(time_s):
    """(n, 3), millimetres: a square of 60 mm that waves."""
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(-30, 30, SIDE), np.linspace(-30, 30, SIDE)))
    return np.column_stack([x + 4 * np.sin(7 * time_s), y, 6 * np.sin(0.1 * x + 9 * time_s)])


def scene():
    """A sheet of quads and triangles, whose last column of vertices is split as at the border of a texture, a rod, a camera."""
    root = Node("root", time=0.0)
    root.path = "/"
    quads = [(i + SIDE * j, i + 1 + SIDE * j, i + 1 + SIDE * (j + 1), i + SIDE * (j + 1))
             for j in range(SIDE - 1) for i in range(SIDE - 1)]
    split = list(range(SIDE * SIDE)) + [SIDE * j + 3 for j in range(SIDE)]
    right = {SIDE * j + 3: SIDE * SIDE + j for j in range(SIDE)}  # vertices of the split column, for what is right of it
    quads = [tuple(right.get(v, v) if (q[0] % SIDE) >= 3 else v for v in q) for q in quads]
    triangles = [t for q in quads[:4] for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]
    visu = root.addChild("Liver").addChild("Visu")
    visu.addObject(Object("MeshTopology", "topology", position=sheet(0), triangles=np.array(triangles)))
    coordinates = np.random.default_rng(1).uniform(size=(len(split), 2))
    model = visu.addObject(Object("OglModel", "VisualModel", "Vec3d", position=sheet(0), triangles=np.array(triangles, np.uint32),
                                  quads=np.array(quads[4:], np.uint32), vertPosIdx=np.array(split, np.uint32),
                                  vertNormIdx=np.array(split, np.uint32), texcoords=coordinates, material=TISSUE, texturename="",
                                  enable=True))
    tool = root.addChild("Tool")
    rigid = tool.addObject(Object("MechanicalObject", "dofs", "Rigid3d", position=np.array([[10, 0, 50, 0, 0, 0, 1.0]])))
    tool.addObject(Object("MechanicalObject", "points", "Vec3d", position=np.zeros((4, 3))))
    root.addObject(Object("InteractiveCamera", "camera", position=np.array([0, 0, 150.0]), orientation=np.array([0, 0, 0, 1.0]),
                          fieldOfView=40.0, zNear=0.1, zFar=1000.0))
    root.addObject(Object("DirectionalLight", "sun", direction=np.array([0, 0, 1.0]), color=np.array([1, 1, 1, 1.0])))
    return root, model, rigid


def corners_of(model):
    """(n, 3, 3) metres: corners of all triangles as the arrays have them."""
    quads = model.quads.value.reshape(-1, 4)
    faces = np.concatenate([model.triangles.value.reshape(-1, 3), quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    split = model.findData("vertPosIdx").value
    places = model.position.value if len(split) == 0 else model.position.value[split]
    return MILLIMETRE * places[faces]


def check_against_arrays(image, model, step):
    """Each pixel of the mesh lies on a triangle of the arrays, and each triangle's middle is in the image, if nothing hides it."""
    number = {name: n for n, name in image.names().items()}["SOFA/Liver.Visu.VisualModel/mesh"]
    mask = image.instance == number
    places = image.position[mask][:, :3].astype(float)
    corners = corners_of(model)
    check(mask.sum() > 500, f"step {step}: the mesh has {mask.sum()} pixels")
    origin, across, along = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(across, along)
    distance = np.einsum("pfk,fk->pf", places[:, None] - origin, normal / np.linalg.norm(normal, axis=1, keepdims=True))
    offset = places[:, None] - origin
    size2 = (normal ** 2).sum(1)
    u = np.einsum("pfk,fk->pf", np.cross(offset, along[None]), normal) / size2
    v = np.einsum("pfk,fk->pf", np.cross(across[None], offset), normal) / size2
    outside = np.maximum(np.maximum(-u, -v), u + v - 1)
    error = np.where(outside < 0.02, np.abs(distance), np.inf).min(1)
    check(error.max() < 2e-5, f"step {step}: a pixel is {1000 * error.max():.4f} mm off the arrays' triangles")
    camera = np.array([0, 0, 0.15])
    middles = corners.mean(1)
    pixels = 0.5 * np.array(mask.shape)[::-1] + (middles - camera)[:, :2] * (1, -1) / (camera[2] - middles[:, 2:]) * image.fy
    inside = mask[pixels[:, 1].astype(int), pixels[:, 0].astype(int)]
    check(inside.all(), f"step {step}: {(~inside).sum()} triangles of the arrays are not in the image")
    return mask


def images(test):
    os.environ.update(vulkan_environment())
    path = test.path("empty.glb")
    fire3dv.sofa.write_scene(path)
    root, model, rigid = scene()
    with fire3dv.Renderer(path, program=test.programs_at["fire3dv"], start_timeout_s=HANG_S,
                          arguments=["--validation", "--cache", "off", "--ground", "off"]) as renderer, renderer.stream("SOFA") as stream:
        controller = fire3dv.sofa.Fire3dvController(node=root, stream=stream, metres_per_unit=MILLIMETRE)
        controller.onSimulationInitDoneEvent({})
        publisher = controller.publisher
        request = stream.request_image(160, 120, node="camera", when="every_nth", outputs=["color", "instance", "position"])
        quads = model.quads.value
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for step in range(7):
                time_s = 0.02 * step
                root.time.set(time_s)
                model.position.set(sheet(time_s))
                hole = None
                if step == 3:  # cut: triangles are gone
                    hole = corners_of(model)[-1].mean(0)
                    model.quads.set(quads[:-2])
                elif step == 5:  # other vertices, too: none is split any more
                    model.quads.set(np.zeros((0, 4), np.uint32))
                    model.triangles.set(np.minimum(model.triangles.value, SIDE * SIDE - 1)[:6])
                    model.findData("vertPosIdx").set(np.zeros(0, np.uint32))
                    model.findData("vertNormIdx").set(np.zeros(0, np.uint32))
                    triangles = [(SIDE * j, SIDE * j + 5, SIDE * (j + 1)) for j in range(5)]
                    model.triangles.set(np.array(triangles, np.uint32))
                rigid.position.set(np.array([[10 + step, 0, 50, 0, 0, np.sin(0.3), np.cos(0.3)]]))
                [image] = publisher.step([request], HANG_S)
                with image:
                    check(image.sim_time_ns == round(1e9 * time_s), f"{image.sim_time_ns}")
                    mask = check_against_arrays(image, model, step)
                    if hole is not None:
                        column, row = 80 + hole[0] / (0.15 - hole[2]) * image.fy, 60 - hole[1] / (0.15 - hole[2]) * image.fy
                        check(not mask[int(row), int(column)], "what was cut away is still there")
                    if step == 0:
                        red, green, _ = (image.color[mask][:, k].astype(float).mean() for k in range(3))
                        check(red > 90 and red > 2 * green, f"the mesh has the colour {red:.0f} {green:.0f}")
            model.enable.set(False)
            root.time.set(1.0)
            [image] = publisher.step([request], HANG_S)
            with image:
                check((image.instance == 0).all(), "a visual model that is not enabled is shown")
            root.children.pop(0)
            root.objects.pop()  # the light
            [image] = publisher.step([request], HANG_S)
            with image:
                check((image.instance == 0).all(), "a visual model that was removed is shown")
        check(publisher.names == ["SOFA", "camera", "Tool.dofs"], f"{publisher.names}")


def cuts(test):
    """A model whose triangles change while images are drawn is in each of them: the old mesh stays until the new one is there."""
    os.environ.update(vulkan_environment())
    path = test.path("empty.glb")
    fire3dv.sofa.write_scene(path)
    root, model, _ = scene()
    plain = {name: np.zeros(0, np.uint32) for name in ("vertPosIdx", "vertNormIdx")}
    meshes = []
    for cells in (2, 4):
        x, y = (a.ravel() for a in np.meshgrid(np.linspace(-30, 30, cells), np.linspace(-30, 30, cells)))
        corner = (np.arange(cells - 1)[:, None] * cells + np.arange(cells - 1)).ravel()
        meshes.append((np.column_stack([x, y, 0 * x]), np.column_stack([corner, corner + 1, corner + cells + 1, corner + cells])))
    model.triangles.set(np.zeros((0, 3), np.uint32))
    model.texcoords.set(np.zeros((0, 2)))
    for name, value in plain.items():
        model.findData(name).set(value)
    with fire3dv.Renderer(path, program=test.programs_at["fire3dv"], start_timeout_s=HANG_S,
                          arguments=["--validation", "--cache", "off", "--ground", "off", "--samples", "1", "--shadows", "off"]) as renderer, \
            renderer.stream("SOFA") as stream, warnings.catch_warnings():
        warnings.simplefilter("error")
        publisher = fire3dv.sofa.Publisher(stream, root, metres_per_unit=MILLIMETRE, lights=False)
        request, reference, frame, images = None, None, 0, 0
        while images < 40 or frame < 60:
            places, quads = meshes[frame // 10 % 2]
            model.position.set(places + (0, 0, 1e-4 * (frame % 2)))  # vertices come with each frame
            model.quads.set(quads.astype(np.uint32))
            root.time.set(0.02 * frame)
            publisher.publish()
            frame += 1
            if request is None:
                request = stream.request_image(64, 48, node="camera", when="every_nth", outputs=["instance"])
            image = request.poll() if reference is not None else request.wait(HANG_S)
            while image is not None:
                with image:
                    mask = np.isin(image.instance, [n for n, name in image.names().items() if name.endswith("VisualModel/mesh")])
                    reference = mask if reference is None else reference
                    check(reference.sum() > 300, f"the model has {reference.sum()} pixels")
                    check((mask == reference).all(), f"the model has {mask.sum()} pixels in the image of frame {image.sequence}")
                    images += 1
                image = request.poll()
            time.sleep(0.005)


def numbers(test):
    """Poses, lights, materials, times, textures and faults, without a renderer."""
    root, model, rigid = scene()
    sent = {}
    with fire3dv.Stream("udp://127.0.0.1:9") as stream:
        for name in ("describe", "publish", "set_camera", "set_light", "add_node", "set_vertices"):
            stream.__dict__[name] = lambda *arguments, name=name, **more: sent.setdefault(name, []).append((arguments, more))
        publisher = fire3dv.sofa.Publisher(stream, root, metres_per_unit=MILLIMETRE)
        rigid.position.set(np.array([[1, 2, 3, 0, 0, np.sin(np.pi / 4), np.cos(np.pi / 4)], [4, 5, 6, 0, 0, 0, 1.0]]))
        publisher.publish()
        names = ["SOFA", "camera", "sun", "Tool.dofs 0", "Tool.dofs 1"]
        (described, more), = sent["describe"]
        check(described[0] == names and np.allclose(more["world_from_stream"], MILLIMETRE * np.eye(3, 4)), f"{described} {more}")
        check(np.allclose(more["body_from_node"][1], 1000 * np.eye(3, 4)) and np.allclose(more["body_from_node"][3], np.eye(3, 4)), f"{more}")
        time_ns, poses, flags = sent["publish"][-1][0]
        check((time_ns, flags) == (0, 1) and np.allclose(poses[0], np.eye(3, 4)), f"{time_ns} {flags} {poses[0]}")
        check(np.allclose(poses[3], [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3]], atol=1e-6), f"{poses[3]}")
        check(np.allclose(poses[2][:, 2], [0, 0, 1]), f"the light shines along {-poses[2][:, 2]}")
        (arguments, _), = sent["set_light"]
        check(arguments[:3] == ("sun", fire3dv.LightKind.DIRECTIONAL, (1, 1, 1)) and np.isclose(arguments[3], np.pi), f"{arguments}")
        (arguments, _), = sent["set_camera"]
        check(np.allclose(arguments[1:], (np.radians(40), 1e-4)), f"{arguments}")
        check(len(sent.get("set_vertices", [])) == 0, "vertices are sent beside the mesh that has them")
        root.time.set(0.5)
        publisher.publish()
        check("set_vertices" not in sent and sent["publish"][-1][0][::2] == (500_000_000, 0), f"what has not moved is sent: {sent['publish'][-1]}")
        model.position.set(sheet(0.5))
        publisher.publish()
        (name, places), _ = sent["set_vertices"][-1]
        check(name == "SOFA/Liver.Visu.VisualModel/mesh" and np.allclose(places, sheet(0.5)[model.vertPosIdx.value], atol=1e-5), name)
        root.time.set(0.1)
        publisher.publish()
        check(sent["publish"][-1][0][2] == fire3dv.FRAME_DISCONTINUITY, "a reset is no discontinuity")
        material = fire3dv.sofa._visual._material(TISSUE)
        check(np.allclose(material["pbrMetallicRoughness"]["baseColorFactor"], [0.6038, 0.01002, 0.01002, 1], atol=1e-4), f"{material}")
        check(np.isclose(material["pbrMetallicRoughness"]["roughnessFactor"], (2 / 47) ** 0.25) and "alphaMode" not in material, f"{material}")
        check(fire3dv.sofa._visual._material("Default Diffuse 1 0 0 1 0.5 Shininess 0 45")["alphaMode"] == "BLEND", "glass is opaque")
        with open(test.path("skin.png"), "wb") as file:
            file.write(PIXEL)
        model.texturename.set(test.path("skin.png"))
        publisher.publish()
        glb = sent["add_node"][-1][1]["asset_glb"]
        check(PIXEL in glb and struct.unpack_from("<I", glb, 8)[0] == len(glb) and b"baseColorTexture" in glb, "the texture is not in the asset")
        model.texturename.set("/nowhere.png")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            publisher.publish()
        check(len(caught) == 1 and "/nowhere.png" in str(caught[0].message) and "/Liver/Visu/VisualModel" in str(caught[0].message), f"{caught}")

        def bad_triangle():
            model.triangles.set(np.array([[0, 1, 900]]))

        def bad_vertex():
            model.position.set(np.where(np.arange(SIDE * SIDE)[:, None] == 5, np.nan, sheet(0)))

        def bad_shape():
            model.position.set(np.zeros((4, 2)))
        for change, text in ((bad_triangle, "/Liver/Visu/VisualModel has the triangle [0, 1, 900], but 56 vertices"),
                             (bad_vertex, "a vertex of /Liver/Visu/VisualModel is not finite"), (bad_shape, "position has the shape (4, 2)")):
            saved = model.triangles.value
            change()
            expect_fault(publisher.publish, text)
            model.triangles.set(saved)
        expect_fault(lambda: fire3dv.sofa.Publisher(stream, root, metres_per_unit=0), "metres_per_unit is 0; a number above 0")
        expect_fault(lambda: fire3dv.sofa.Fire3dvController(node=root), "needs uri or stream")


def expect_fault(call, text):
    try:
        call()
    except fire3dv.ArgumentError as error:
        check(text in str(error), f"{error}")
    else:
        check(False, f"nothing was raised: {text}")


def controller(test):
    """Where SOFA can be imported, the controller is one of its class, which gets its own arguments."""
    module, core = types.ModuleType("Sofa"), types.ModuleType("Sofa.Core")

    class Controller:
        def __init__(self, *arguments, **named):
            self.made_with = arguments, named
    core.Controller = Controller
    kept = {"fire3dv.sofa": sys.modules.pop("fire3dv.sofa")}
    sys.modules.update({"Sofa": module, "Sofa.Core": core})
    try:
        import importlib
        sofa = importlib.import_module("fire3dv.sofa")
        root, _, _ = scene()
        with fire3dv.Stream("udp://127.0.0.1:9") as stream:
            made = sofa.Fire3dvController(name="fire3dv", node=root, stream=stream, rate_hz=50.0)
            check(isinstance(made, Controller) and made.made_with == ((), {"name": "fire3dv"}), f"{made.made_with}")
            made.onUpdateMappingEndEvent({"dt": 0.02})
            check(made.publisher.names[0] == "SOFA" and "1 visual models" in repr(made.publisher), repr(made.publisher))
    finally:
        for name in ("Sofa", "Sofa.Core", "fire3dv.sofa"):
            sys.modules.pop(name, None)
        sys.modules.update(kept)


if __name__ == "__main__":
    main({"numbers": numbers, "controller": controller, "images": images, "cuts": cuts}, ["fire3dv"])
