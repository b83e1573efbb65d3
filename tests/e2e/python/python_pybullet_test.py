"""Test of fire3dv.pybullet with a stand-in of the functions of the package pybullet: scenes of visual shapes, names of
links, and images that show bodies where the simulation has them.

python_pybullet_test.py FIRE3DV [CASE...]; fire3dv-convert is beside it.
"""
import os
import warnings

import numpy as np

import fire3dv
import fire3dv.pybullet
from harness import HANG_S, main, vulkan_environment
from image_reader import check

SPHERE, BOX, CYLINDER, MESH, PLANE, CAPSULE = 2, 3, 4, 5, 6, 7
UNTURNED = (0.0, 0.0, 0.0, 1.0)
HALF_TURN_Z = (0.0, 0.0, 1.0, 0.0)
OBJ = "v -0.1 -0.1 0\nv 0.1 -0.1 0\nv 0.1 0.1 0\nv -0.1 0.1 0\nf 1 2 3\nf 1 3 4\n"


class StandIn:
    """Two cubes of one file, an arm of a base and two links, and a floor. Results have the shapes of pybullet's manual."""

    def __init__(self):
        self.cubes = {1: (0.0, 0.0, 0.5), 4: (1.0, 0.0, 0.5)}
        self.arm = {-1: ((0.0, 2.0, 0.2), UNTURNED), 0: ((0.0, 2.0, 0.6), UNTURNED), 1: ((0.0, 2.0, 1.0), HALF_TURN_Z)}
        self.mesh = b""
        self.clients = set()

    def _seen(self, physicsClientId=0):
        self.clients.add(physicsClientId)

    def getNumBodies(self, **client):
        self._seen(**client)
        return 4

    def getBodyUniqueId(self, index, **client):
        self._seen(**client)
        return [0, 1, 4, 7][index]  # ids have gaps where bodies were removed

    def getBodyInfo(self, body, **client):
        self._seen(**client)
        return {0: (b"planeLink", b"plane"), 1: (b"baseLink", b"cube"), 4: (b"baseLink", b"cube"), 7: (b"foot", b"arm")}[body]

    def getNumJoints(self, body, **client):
        return 2 if body == 7 else 0

    def getJointInfo(self, body, joint, **client):
        return (joint, b"joint", 0, 7, 6, 1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, (b"upper arm", b"hand & tool")[joint], (0, 0, 1),
                (0, 0, 0), UNTURNED, joint - 1)

    def getDynamicsInfo(self, body, link, **client):
        inertial = (0.1, 0.0, 0.3) if body == 7 and link == -1 else (0.0, 0.0, 0.0)
        return (1.0, 0.5, (1, 1, 1), inertial, UNTURNED, 0.0, 0.0, 0.0, -1.0, -1.0)

    def getVisualShapeData(self, body, **client):
        def shape(link, kind, sizes, file=b"", place=(0.0, 0.0, 0.0), turn=UNTURNED, rgba=(1.0, 1.0, 1.0, 1.0)):
            return (body, link, kind, sizes, file, place, turn, rgba)
        if body == 0:
            return (shape(-1, PLANE, (0.0, 0.0, 1.0), rgba=(0.5, 0.5, 0.5, 1)),)
        if body in self.cubes:
            return (shape(-1, BOX, (0.4, 0.4, 0.4), rgba=(1.0, 0.0, 0.0, 1.0)),)
        return (shape(-1, CYLINDER, (0.4, 0.2), rgba=(0, 1, 0, 1)), shape(0, CAPSULE, (0.2, 0.1), rgba=(0, 0, 1, 1)),
                shape(1, SPHERE, (0.15, 0, 0), place=(0.3, 0.0, 0.0), rgba=(1, 1, 0, 1)),
                *((shape(1, MESH, (2.0, 2.0, 2.0), self.mesh, place=(0.0, 0.0, 0.3)),) if self.mesh else ()))

    def getBasePositionAndOrientation(self, body, **client):
        if body in self.cubes:
            return self.cubes[body], UNTURNED
        place, turn = self.arm[-1] if body == 7 else ((0.0, 0.0, 0.0), UNTURNED)
        return (np.add(place, (0.1, 0.0, 0.3)) if body == 7 else place), turn  # of the centre of mass

    def getLinkState(self, body, link, computeForwardKinematics=False, **client):
        check(computeForwardKinematics, "the link's pose is of the last step")
        place, turn = self.arm[link]
        return (np.add(place, 5), UNTURNED, (5, 5, 5), UNTURNED, place, turn)


NAMES = ["planeLink", "baseLink 1", "baseLink 4", "foot", "upper arm", "hand & tool"]


def numbers(test):
    """Names, poses of link frames, times and faults, without a renderer."""
    client = StandIn()
    with fire3dv.Stream("udp://127.0.0.1:9") as stream:
        publisher = fire3dv.pybullet.Publisher(stream, client, physics_client=3)
        check([link.name for link in publisher.links] == NAMES and client.clients == {3}, f"{publisher.links} {client.clients}")
        poses = publisher.poses()
        places = [[0, 0, 0], [0, 0, 0.5], [1, 0, 0.5], [0, 2, 0.2], [0, 2, 0.6], [0, 2, 1]]
        check(np.allclose(poses[:, :, 3], places, atol=1e-6), f"{poses[:, :, 3]}")
        check(np.allclose(poses[5, :, :3], np.diag([-1, -1, 1])) and np.allclose(poses[3, :, :3], np.eye(3)), f"{poses}")
        sent = []
        stream.publish = lambda time_ns, _, flags: sent.append((time_ns, flags))
        for time_ns in (10, 20, 5, 6):
            publisher.publish(time_ns)
        publisher.jump()
        publisher.publish(7)
        check(sent == [(10, 1), (20, 0), (5, 1), (6, 0), (7, 1)], f"{sent}")
        check("6 links" in repr(publisher), repr(publisher))
        arm = fire3dv.pybullet.Publisher(stream, client, bodies=[7, 1])
        check([link.name for link in arm.links] == ["foot", "upper arm", "hand & tool", "baseLink"], f"{arm.links}")
        for arguments, text in (({"client": client, "bodies": [2]}, "bodies has 2; the simulation has [0, 1, 4, 7]"),
                                ({}, "pybullet cannot be imported")):
            try:
                fire3dv.pybullet.Publisher(stream, **arguments)
            except fire3dv.ArgumentError as error:
                check(text in str(error), f"{error}")
            else:
                check(False, f"nothing was raised: {text}")
    client.mesh = b"nowhere.obj"
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        fire3dv.pybullet.write_scene(test.path("bad.urdf"), client)
        client.getVisualShapeData = lambda body: ((body, -1, MESH, (1, 1, 1), b"", (0, 0, 0), UNTURNED, (1, 1, 1, 1)),)
        fire3dv.pybullet.write_scene(test.path("none.urdf"), client, bodies=[1])
    texts = [str(each.message) for each in caught]
    check(len(texts) == 2 and "nowhere.obj is not found: add its folder" in texts[0] and "a mesh without a file of body 1" in texts[1],
          f"{texts}")
    check(all(each.category is fire3dv.SceneWarning for each in caught), f"{caught}")


def images(test):
    """Each shape is where the simulation has it, through a camera in the simulation's frame."""
    os.environ.update(vulkan_environment())
    client, folder = StandIn(), os.path.dirname(test.path("square.obj"))
    with open(test.path("square.obj"), "w", encoding="utf-8") as file:
        file.write(OBJ)
    client.mesh = b"square.obj"
    scene = test.path("world.urdf")
    links = fire3dv.pybullet.write_scene(scene, client, search_paths=[folder])
    check([link.name for link in links] == NAMES, f"{links}")
    size, fx = (160, 120), 100
    with fire3dv.Renderer(scene, program=test.programs_at["fire3dv"], start_timeout_s=HANG_S,
                          arguments=["--validation", "--cache", "off"]) as renderer, renderer.stream("PyBullet") as stream:
        publisher = fire3dv.pybullet.Publisher(stream, client)
        for step, (x, eye, target) in enumerate(((0.0, (0.5, -3.0, 1.0), (0.5, 0, 0.5)), (-0.5, (0.5, -3.0, 1.0), (0.3, 0, 0.5)),
                                                 (0.0, (0.0, 2.0, 4.0), (0.0, 2.01, 0)))):
            client.cubes[1] = (x, 0.0, 0.5)
            view = fire3dv.look_at(eye, target, up=(0, 0, 1))
            camera = stream.request_image(*size, fx=fx, parent_from_camera=view, when="every_nth", outputs=["depth", "instance"])
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                [image] = publisher.step(step * 1_000_000, [camera], HANG_S)
            with camera, image:
                seen = image.names()
                camera_from_stream = image.opencv_camera_from_stream
                expected = {"baseLink 1": (x, 0, 0.5), "baseLink 4": (1.0, 0, 0.5)} if step < 2 else {}
                for name, place in expected.items():
                    number = {other: n for n, other in seen.items()}[name]
                    rows, columns = np.nonzero(image.instance == number)
                    right, down, ahead = (camera_from_stream @ (*place, 1))[:3]
                    at = (size[0] - 1) / 2 + fx * right / ahead, (size[1] - 1) / 2 + fx * down / ahead
                    found = (columns.min() + columns.max()) / 2, (rows.min() + rows.max()) / 2
                    check(np.abs(np.subtract(at, found)).max() < 2.5, f"{name} is at {found}, not at {at}")
                if step == 2:  # from above: the square of the mesh at 1.3 m, 0.4 m wide, and the sphere beside it, turned
                    check("hand & tool" in seen.values(), f"{seen}")
                    middle = image.depth[size[1] // 2, size[0] // 2]
                    check(abs(middle - (4 - 1.3)) < 0.01, f"the mesh is {middle} m below the camera")
                    side = camera_from_stream @ (-0.3, 2.0, 1.15, 1)
                    pixel = int(size[1] / 2 + fx * side[1] / side[2]), int(size[0] / 2 + fx * side[0] / side[2])
                    check(abs(image.depth[pixel] - (4 - 1.15)) < 0.02, f"the sphere is {image.depth[pixel]} m below the camera")


if __name__ == "__main__":
    main({"numbers": numbers, "images": images}, ["fire3dv"])
