"""Test of fire3dv.mujoco with a model of plain attributes, as of Python's package mujoco: names agree with those of
fire3dv-convert, and images show bodies where the data has them.

python_mujoco_test.py FIRE3DV [CASE...]; fire3dv-convert is beside it.
"""
import os
import subprocess
import sys
import types

import numpy as np

import fire3dv
import fire3dv.mujoco
from harness import HANG_S, main, vulkan_environment
from image_reader import check, ranges_about, read_png
from readme_commands import code_blocks, section_of

BODIES = ["world", "red", "", "body_2", "blue ball", ""]
CAMERAS = ["eye", "", "red"]
GEOMS = ["floor", "red", "", "", "blue", "", "collision"]
MJCF = """<mujoco><worldbody>
  <light name="red" pos="0 0 4" dir="0 0 -1"/> <camera name="eye" pos="0 -3 1"/>
  <geom name="floor" type="plane" size="2 2 0.1" rgba="0.5 0.5 0.5 1" pos="0 0 -1"/>
  <body name="red"><freejoint/><geom name="red" type="sphere" size="0.1" rgba="1 0 0 1"/></body>
  <body><freejoint/><geom type="sphere" size="0.1"/></body>
  <body name="body_2"><freejoint/><geom type="sphere" size="0.1" rgba="0 0 0 0"/><camera pos="0 0 1"/>
    <camera name="red"/>
    <body name="blue ball" pos="0 0 1"><geom name="blue" type="box" size="0.1 0.1 0.1" rgba="0 0 1 1"/></body>
  </body>
  <body><freejoint/><geom type="sphere" size="0.1"/><geom name="collision" type="sphere" size="0.1" group="3"/></body>
</worldbody></mujoco>
"""


def model_of():
    """The attributes of mjModel that the package documents, for MJCF."""
    table, addresses = b"test model\0", {}
    lights = ["red"]
    for kind, names in (("body", BODIES), ("cam", CAMERAS), ("light", lights), ("geom", GEOMS)):
        addresses[kind] = []
        for name in names:
            addresses[kind].append(len(table))
            table += name.encode() + b"\0"
    rgba = np.tile(np.float32([0.5, 0.5, 0.5, 1]), (len(GEOMS), 1))
    rgba[3] = 0
    return types.SimpleNamespace(
        nbody=len(BODIES), ncam=len(CAMERAS), nlight=1, ngeom=len(GEOMS), names=table, geom_rgba=rgba,
        mat_rgba=np.zeros((0, 4)), geom_matid=np.full(len(GEOMS), -1), geom_group=np.array([0, 0, 0, 0, 0, 0, 3]),
        **{f"name_{kind}adr": np.array(rows, np.int32) for kind, rows in addresses.items()})


def data_of(model, source, time=0.0):
    def turns(count):
        quaternions = source.normal(size=(count, 4))
        quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
        return fire3dv.pose(wxyz=quaternions)[..., :3].astype(float).reshape(count, 9)
    data = types.SimpleNamespace(time=time)
    for prefix, count in (("", model.nbody), ("cam_", model.ncam), ("geom_", model.ngeom)):
        setattr(data, f"{prefix}xpos", source.uniform(-1, 1, (count, 3)))
        setattr(data, f"{prefix}xmat", turns(count))
    data.xpos[0], data.xmat[0] = 0, np.eye(3).ravel()
    return data


def write_model(test):
    path = test.path("model.xml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(MJCF)
    return path


def names(test):
    converter = os.path.join(os.path.dirname(test.programs_at["fire3dv"]), "fire3dv-convert")
    bodies, cameras, geoms = fire3dv.mujoco.node_names(model_of())
    check(bodies == ["world", "red", "body_2 body", "body_2", "blue ball", "body_5"], f"{bodies}")
    listed = subprocess.run([converter, write_model(test), "--list", "--geoms"], capture_output=True, text=True, check=True)
    nodes = [line.split("\t")[0].strip() for line in listed.stdout.splitlines()]
    for kind, found in (("bodies", bodies), ("cameras", cameras)):
        check(set(found) <= set(nodes), f"{kind} {found} are not all of {nodes}")
    shown = [name for i, name in enumerate(geoms) if fire3dv.mujoco._is_shown(model_of(), i)]
    check(len(shown) == 5 and sorted([*bodies, *cameras, *shown, "overview", "free camera", "red light"]) == sorted(nodes),
          f"{bodies} {cameras} {shown} are not the nodes {nodes}")
    # Without the table of names, by the accessors of later versions.
    model = model_of()
    del model.name_bodyadr
    model.body = lambda i: types.SimpleNamespace(name=BODIES[i])
    check(fire3dv.mujoco.node_names(model)[0] == bodies, "accessors give other names")


def images(test):
    """Each body is seen where xpos has it, through a camera of the model, which moves, too."""
    os.environ.update(vulkan_environment())
    source, model = np.random.default_rng(5), model_of()
    size, fx = (160, 120), 100
    with fire3dv.Renderer(write_model(test), program=test.programs_at["fire3dv"], start_timeout_s=HANG_S,
                          arguments=["--validation", "--cache", "off"]) as renderer, renderer.stream("MuJoCo") as stream:
        publisher = fire3dv.mujoco.Publisher(stream, model)
        check(publisher.names == ["red", "body_2 body", "body_2", "blue ball", "body_5", "eye", "camera_1", "red camera"],
              f"{publisher.names}")
        seen = 0
        for step in range(3):
            data = data_of(model, source, time=0.5 * step)
            eye = fire3dv.look_at((0.3 * step, -4, 1), (0, 0, 0), up=(0, 0, 1))
            data.cam_xpos[0], data.cam_xmat[0] = eye[:, 3], eye[:, :3].ravel()
            request = stream.request_image(*size, node="eye", fx=fx, outputs=["instance", "depth"], when="every_nth")
            [image] = publisher.step(data, [request], HANG_S)
            with request, image:
                check(image.sequence == stream.sequence == step + 1, f"frame {image.sequence} of step {step}")
                check(image.sim_time_ns == 500_000_000 * step, f"{image.sim_time_ns} ns")
                ids = {name: number for number, name in image.names().items()}
                for body, name in ((1, "red"), (2, "body_2 body"), (4, "blue ball"), (5, "body_5")):
                    if name not in ids:
                        continue  # behind another, or outside
                    right, up, back = eye[:, :3].T @ (data.xpos[body] - eye[:, 3])
                    y, x = np.nonzero(image.instance == ids[name])
                    at = (size[0] - 1) / 2 + fx * right / -back, (size[1] - 1) / 2 - fx * up / -back
                    found = (x.min() + x.max()) / 2, (y.min() + y.max()) / 2
                    if len(x) < 12 or min(x.min(), y.min()) == 0 or x.max() == size[0] - 1 or y.max() == size[1] - 1:
                        continue
                    near = image.depth[y, x].min()
                    check(abs(near + back - (-0.1)) < 0.12, f"{name} is {near} m away, not {-back}")
                    seen += np.abs(np.subtract(at, found)).max() < 1.5
        check(seen >= 8, f"only {seen} bodies are where they should be")


def contact_of(pos, frame, address, dim=3, friction=(0.5, 0.25, 0, 0, 0), geoms=(0, 1)):
    return types.SimpleNamespace(pos=np.array(pos, float), frame=np.array(frame, float).ravel(), efc_address=address, dim=dim,
                                 friction=np.array(friction), geom1=geoms[0], geom2=geoms[1])


def visual_of(model, cone):
    """The attributes of mjModel that decorations have, besides those of model_of."""
    named = types.SimpleNamespace
    model.vis = named(scale=named(contactwidth=0.3, forcewidth=0.1), map=named(force=0.005),
                      rgba=named(contactpoint=[1, 0.5, 0, 1], contactgap=[0, 0, 1, 0.5], contactforce=[0.7, 0.9, 0.9, 1]))
    model.stat, model.opt = named(meansize=0.5, meanmass=2.0), named(cone=cone)
    model.geom_bodyid = np.array([0, 1, 2])
    return model


def contacts(test):
    """Markers of contacts and forces in the viewer's sizes and colours; forces of both kinds of friction cones by hand."""
    up = [[0, 0, 1], [1, 0, 0], [0, 1, 0]]  # rows: normal, tangents
    for cone, efc_force in ((1, [100, 20, -10, 4]), (0, [35, 15, 40, 10, 4])):
        # Of a pyramid: the normal is the sum of its edges, a tangent their difference times friction: (35 - 15) * 0.5 = 10.
        normal, first, second = (100, 20, -10) if cone else (100, 10, 7.5)
        model = visual_of(model_of(), cone)
        last = len(efc_force) - 1
        data = types.SimpleNamespace(ncon=5, efc_force=np.array(efc_force, float), contact=[
            contact_of([1, 2, 3], up, 0), contact_of([0, 0, 1], up, 0, geoms=(2, 1)), contact_of([0, 0, 2], up, -1),
            contact_of([4, 5, 6], up, last, dim=1, geoms=(-1, 2)), contact_of([np.nan, 0, 0], up, 0)])
        called = []
        stream = types.SimpleNamespace(points=lambda *a, **k: called.append((a, k)), arrows=lambda *a, **k: called.append((a, k)),
                                       clear_marker=called.append)
        markers = fire3dv.mujoco._Contacts(stream, model, ["contacts", "forces"])
        markers.publish(data)
        (points, point_options), (arrows, arrow_options) = called
        check(points[0] == "contacts/points" and points[1].tolist() == [[1, 2, 3], [0, 0, 1], [0, 0, 2], [4, 5, 6]], f"{points}")
        active, gap = [255, 128, 0, 255], [0, 0, 255, 128]
        check(points[2].tolist() == [active, active, gap, active], f"{points[2]}")
        check(point_options == {"size_m": 2 * 0.3 * 0.5, "overlaid": True}, f"{point_options}")
        metres = 0.005 / 2  # a newton
        force = metres * np.array([first, second, normal])
        check(arrows[0] == "contacts/forces" and arrows[1].tolist() == [[1, 2, 3], [0, 0, 1], [4, 5, 6]], f"{arrows}")
        check(np.allclose(arrows[2], [force, -force, metres * np.array([0, 0, 4])]), f"{arrows[2]}")
        check(arrows[3].tolist() == [[178, 230, 230, 255]] and arrow_options == {"width_m": 2 * 0.1 * 0.5, "overlaid": True},
              f"{arrows[3]} {arrow_options}")
        data.ncon, called[:] = 0, []
        markers.publish(data)
        markers.publish(data)
        check(called == ["contacts/points", "contacts/forces"], f"markers without contacts: {called}")
        fire3dv.mujoco._Contacts(stream, model, ["forces"]).publish(data)
        check(len(called) == 2, "an empty marker was set")
    for show, names in (("contacts,forces", ["contacts", "forces"]), (["forces"], ["forces"]), ("", []), ((), [])):
        check(fire3dv.mujoco._shown_of(show) == names, f"{show}")
    try:
        fire3dv.mujoco._shown_of("contacts,joints")
    except fire3dv.ArgumentError as error:
        check("show has 'joints'; use \"contacts\", \"forces\" or \"contacts,forces\"" in str(error), f"{error}")
    else:
        check(False, "joints were taken")


# Python's mujoco, as far as the example uses it: bodies of an MJCF file that fall. Positions are not those of a simulation.
STAND_IN = """
import types, xml.etree.ElementTree
import numpy as np

class MjModel:
    @staticmethod
    def from_xml_path(path):
        world = xml.etree.ElementTree.parse(path).getroot().find("worldbody")
        bodies, cameras, lights, geoms = ["world"], [], [], []
        def visit(node):
            for child in node:
                lists = {"body": bodies, "camera": cameras, "light": lights, "geom": geoms}
                if child.tag in lists:
                    lists[child.tag].append(child.get("name", ""))
                if child.tag == "body":
                    visit(child)
        visit(world)
        self, named = MjModel(), types.SimpleNamespace
        self.nbody, self.ncam, self.nlight, self.ngeom = map(len, (bodies, cameras, lights, geoms))
        for kind, names in (("body", bodies), ("camera", cameras), ("light", lights), ("geom", geoms)):
            setattr(self, kind, lambda i, names=names: named(name=names[i]))
        self.geom_bodyid = np.zeros(self.ngeom, int)
        self.vis = named(scale=named(contactwidth=0.3, forcewidth=0.1), map=named(force=0.005),
                         rgba=named(contactpoint=[1, 0, 0, 1], contactgap=[0, 0, 1, 1], contactforce=[1, 1, 1, 1]))
        self.stat, self.opt = named(meansize=0.1, meanmass=1.0), named(cone=0)
        return self

class MjData:
    def __init__(self, model):
        self.time, self.ncon, self.contact, self.efc_force = 0.0, 0, [], np.zeros(0)
        for prefix, count in (("", model.nbody), ("cam_", model.ncam), ("geom_", model.ngeom)):
            setattr(self, prefix + "xpos", np.zeros((count, 3)))
            setattr(self, prefix + "xmat", np.tile(np.eye(3).ravel(), (count, 1)))
        self.xpos[1:, 2] = 1
        self.cam_xpos[:] = [0, -2, 0.5]
        self.cam_xmat[:] = [1, 0, 0, 0, 0, -1, 0, 1, 0]

def mj_step(model, data):
    data.time += 0.1
    data.xpos[1:, 2] = 1 - 0.5 * data.time ** 2
"""


def example(test):
    """The example of the package's README, as it stands, with a stand-in of mujoco."""
    os.environ.update(vulkan_environment())
    os.environ["FIRE3DV"] = test.programs_at["fire3dv"]
    page = os.path.join(os.path.dirname(os.path.dirname(fire3dv.__file__)), "README.md")
    [snippet] = code_blocks(section_of(page, "MuJoCo"), "python")
    check("publisher.step(data, [camera])" in snippet and 'show="contacts,forces"' in snippet, snippet)
    with open(test.path("mujoco.py"), "w", encoding="utf-8") as file:
        file.write(STAND_IN)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([test.folder, os.environ["PYTHONPATH"]])}
    done = subprocess.run([sys.executable, "-W", "error", "-c", snippet], cwd=test.folder, env=environment,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    check(done.returncode == 0, done.stdout)
    picture = read_png(test.path("falling.png"))
    check((picture.width, picture.height) == (640, 480) and picture.text["SimTimeNs"] == "1000000000", f"{picture.text}")
    reds = picture.box_of(ranges_about((200, 30, 30), 60))
    check(reds is not None and abs((reds[0] + reds[2]) / 2 - 320) < 3, f"the ball is at {reds}")


def faults(test):
    model, source = model_of(), np.random.default_rng(1)
    with fire3dv.Stream("udp://127.0.0.1:9") as stream:
        publisher = fire3dv.mujoco.Publisher(stream, model, cameras=False, geoms=True)
        check(publisher.names[5:] == ["floor", "red geom", "geom_2", "blue", "geom_5"], f"{publisher.names}")
        data = data_of(model, source)
        data.xpos, data.geom_xpos = data.xpos.astype(np.float32), data.geom_xpos.astype(np.float32)
        poses = publisher.poses(data)
        check((poses[:5, :, 3] == data.xpos[1:]).all() and (poses[5:, :, 3] == data.geom_xpos[[0, 1, 2, 4, 5]]).all(), "positions")
        check(np.allclose(poses[:5, :, :3].reshape(5, 9), data.xmat[1:]), "rotations")
        flags = []
        stream.publish = lambda _, __, given: flags.append(given)  # of publish() and step()
        for data.time in (1.0, 2.0, 0.5, 0.6, 0.7):
            if data.time == 0.7:
                publisher.jump()
            publisher.publish(data)
        check(flags == [1, 0, 1, 0, 1], f"{flags}")
        for change, text in ((lambda: data.xpos.__setitem__((4, 1), np.nan), "pose of 'blue ball' is not finite at 0.7 s"),
                             (lambda: setattr(data, "xpos", data.xpos[:3]), "data.xpos has the shape (3, 3)")):
            change()
            try:
                publisher.publish(data)
            except fire3dv.ArgumentError as error:
                check(text in str(error), f"{error}")
            else:
                check(False, f"nothing was raised: {text}")
        check("10 nodes" in repr(publisher), repr(publisher))


if __name__ == "__main__":
    main({"names": names, "images": images, "contacts": contacts, "example": example, "faults": faults}, ["fire3dv"])
