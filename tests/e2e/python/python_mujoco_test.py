"""Test of fire3dv.mujoco with a model of plain attributes, as of Python's package mujoco: names agree with those of
fire3dv-convert, and images show bodies where the data has them.

python_mujoco_test.py FIRE3DV [CASE...]; fire3dv-convert is beside it.
"""
import os
import subprocess
import types

import numpy as np

import fire3dv
import fire3dv.mujoco
from harness import HANG_S, main, vulkan_environment
from image_reader import check

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
            sequence = publisher.publish(data)
            with stream.request_image(*size, node="eye", fx=fx, outputs=["instance", "depth"], sequence=sequence).wait(HANG_S) as image:
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
        stream.publish = lambda _, __, given: flags.append(given)
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
    main({"names": names, "images": images, "faults": faults}, ["fire3dv"])
