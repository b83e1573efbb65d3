"""End-to-end test of fire3dv.Batch: worlds of a batch against batches of one world and against single images, masks, links,
limits, and errors of wrong shapes.

python_batch_test.py FIRE3DV [CASE...]
"""
import os
import subprocess
import sys

import numpy

import fire3dv
from fire3dv.batch import BatchRequest, _of_quaternions
from harness import HANG_S, PLAIN_IMAGES, main, vulkan_environment
from image_reader import check, read_png, write_scene

NODES = ["red", "green", "blue"]
WORLDS = 33
SIZE = (40, 24)
OUTPUTS = ("color", "depth", "instance", "normal")
CAMERA = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 50]
VIEW = {"camera_poses": [CAMERA], "camera_matrices": [[20, 0, 19.5], [0, 20, 11.5], [0, 0, 1]]}
SMALL = {"camera_poses": [CAMERA], "vertical_fov_rad": 1.2}


BOX = "<visual><origin xyz='0.25 0 0.4'/><geometry><box size='0.5 0.2 0.2'/></geometry></visual>"
URDF = f"""<robot name="arm"><link name="base"/><link name="upper">{BOX}</link><link name="fore">{BOX}</link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/>
    <axis xyz="0 0 1"/></joint></robot>
"""


def raised(kind, text, call):
    try:
        call()
    except kind as error:
        check(text in str(error), f"{text!r} is not in: {error}")
        return str(error)
    raise AssertionError(f"no {kind.__name__} was raised, expected: {text}")


def renderer_of(test, *arguments, **options):
    os.environ.update(vulkan_environment())
    return fire3dv.Renderer(test.scene, program=test.programs_at["fire3dv"], start_timeout_s=HANG_S,
                            arguments=["--validation", "--cache", "off", *arguments], **options)


def random_poses(worlds=WORLDS):
    """Turned squares, some in the shadow of others. (W, 3, 7), quaternions w x y z."""
    numbers = numpy.random.default_rng(5)
    poses = numpy.zeros((worlds, len(NODES), 7), numpy.float32)
    poses[..., :3] = numbers.uniform((-30, -10, -8), (30, 10, 8), (worlds, len(NODES), 3))
    turns = numbers.normal(size=(worlds, len(NODES), 4)) * 0.3 + (1, 0, 0, 0)
    poses[..., 3:] = turns / numpy.linalg.norm(turns, axis=-1, keepdims=True)
    return poses


def bytes_of(images, view):
    return {name: images[name][view].tobytes() for name in images}


def worlds(test):
    """World k of a batch equals a batch of that world: of 1, 2 and 33 worlds, permuted, masked, over shm and tcp."""
    poses = random_poses()
    with renderer_of(test, "--samples", "1") as renderer, renderer.stream("worlds") as stream:
        one = stream.batch(1, SIZE, NODES, outputs=OUTPUTS, **VIEW)
        check("1 worlds, 1 views of 40x24" in repr(one) and one.nodes == tuple(NODES), repr(one))
        alone = [bytes_of(one.render(poses[k:k + 1], timeout_s=HANG_S), 0) for k in range(WORLDS)]
        check(len({images["color"] for images in alone}) == WORLDS, "worlds are alike, which proves nothing")
        two = stream.batch(2, SIZE, outputs=OUTPUTS, **VIEW).render(poses[5:7], timeout_s=HANG_S)
        check([bytes_of(two, v) for v in range(2)] == alone[5:7], "two worlds differ from each alone")

        order = [(7 * v + 3) % WORLDS for v in range(WORLDS)] + [4, 4]
        batch = stream.batch(WORLDS, SIZE, views=order, outputs=OUTPUTS, **VIEW)
        first = batch.request(poses)
        images = batch.render(poses[::-1], timeout_s=HANG_S)  # while the first is on its way
        for v, world in enumerate(order):
            check(bytes_of(images, v) == alone[WORLDS - 1 - world], f"view {v} of world {world}, reversed")
        images = first.wait(HANG_S)
        shapes = {name: (images[name].shape, images[name].dtype.str) for name in images}
        check(shapes == {"color": ((35, 24, 40, 4), "|u1"), "depth": ((35, 24, 40, 1), "<f4"),
                         "instance": ((35, 24, 40, 1), "<u4"), "normal": ((35, 24, 40, 4), "<f2")}, f"{shapes}")
        check(not images["color"].flags.writeable and images["color"].flags.c_contiguous, "writable or not contiguous")
        for v, world in enumerate(order):
            check(bytes_of(images, v) == alone[world], f"view {v} of world {world}")
        kept = images["color"].tobytes()

        active = numpy.random.default_rng(1).random(WORLDS) < 0.4
        check(0 < active.sum() < WORLDS, f"{active}")
        masked = batch.render(poses, active=active, timeout_s=HANG_S)
        for v, world in enumerate(order):
            for name in OUTPUTS:
                is_right = masked[name][v].tobytes() == alone[world][name] if active[world] else not masked[name][v].view("u1").any()
                check(is_right, f"{name} of view {v} of world {world}, active: {active[world]}")
        none = batch.render(poses, active=numpy.zeros(WORLDS), timeout_s=HANG_S)
        check(not any(none[name].view("u1").any() for name in OUTPUTS), "without an active world there are pixels")
        check(images["color"].tobytes() == kept, "a later batch has changed an array that is held")

        # Shared by all worlds, and cameras of their own: each view as the view of a batch of one.
        moved = numpy.tile(numpy.array(CAMERA, numpy.float32), (WORLDS, 1))
        moved[:, 3] = numpy.linspace(-9, 9, WORLDS)
        matrices = numpy.tile(numpy.array(VIEW["camera_matrices"], numpy.float32), (WORLDS, 1, 1))
        matrices[:, 0, 0] = numpy.linspace(15, 30, WORLDS)
        shared = stream.batch(WORLDS, SIZE, outputs=OUTPUTS, camera_poses=moved, camera_matrices=matrices)
        images = shared.render(poses[:1], timeout_s=HANG_S)
        for v in (0, 16, 32):
            again = one.render(poses[:1], camera_poses=moved[v:v + 1], camera_matrices=matrices[v:v + 1], timeout_s=HANG_S)
            check(bytes_of(again, 0) == bytes_of(images, v), f"view {v} with a camera of its own")
        check(len({images["depth"][v].tobytes() for v in range(WORLDS)}) == WORLDS, "cameras are alike")

    with renderer_of(test, "--samples", "1", uri="tcp://127.0.0.1:0") as renderer, renderer.stream("worlds") as stream:
        check(renderer.uri.startswith("tcp://"), renderer.uri)
        images = stream.batch(WORLDS, SIZE, NODES, outputs=OUTPUTS, **VIEW).render(poses, timeout_s=HANG_S)
        check([bytes_of(images, v) for v in range(WORLDS)] == alone, "over tcp there are other images")


def single(test):
    """A world has the pixels of single images of a stream that publishes its poses; nodes without poses rest."""
    outputs = ("color", "depth", "instance")
    poses = random_poses(4)
    matrices = _of_quaternions(poses, "poses", True)
    placed = numpy.array([0, 0, 1, 0, 0, 1, 0, -3, -1, 0, 0, 20, ], numpy.float32)  # looks from the side
    with renderer_of(test, *PLAIN_IMAGES, "--fxaa", "off") as renderer:
        for world_from_stream in (None, [0, 1, 0, 2, -1, 0, 0, 1, 0, 0, 1, 3]):
            offsets = numpy.tile(numpy.array([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 2], numpy.float32), (3, 1))
            offsets[:, 3] = (1, -2, 3)
            with renderer.stream("single") as stream:
                stream.describe(NODES, world_from_stream=world_from_stream, body_from_node=offsets)
                batch = stream.batch(4, SIZE, outputs=outputs, **VIEW)
                wrist = stream.batch(4, SIZE, ["blue", "red"], outputs=outputs, node="red", camera_poses=[placed],
                                     camera_matrices=VIEW["camera_matrices"])
                images = batch.render(poses, timeout_s=HANG_S)
                on_red = wrist.render(poses[:, (2, 0)], timeout_s=HANG_S)
                for k in range(4):
                    stream.publish(k, matrices[k])
                    camera = {"fx": 20, "outputs": outputs}
                    with stream.request_image(*SIZE, parent_from_camera=CAMERA, **camera).wait(HANG_S) as image:
                        for name in outputs:
                            check(image[name].tobytes() == images[name][k].tobytes(), f"{name} of world {k}")
                    stream.publish(k, numpy.stack([matrices[k, 0], matrices[k, 1] * 0 + (1, 0, 0, 999, 0, 1, 0, 999, 0, 0, 1, 0),
                                                   matrices[k, 2]]))
                    with stream.request_image(*SIZE, node="red", parent_from_camera=placed, **camera).wait(HANG_S) as image:
                        seen = image["instance"] * (on_red["instance"][k, ..., 0] != 2)  # green rests there
                        check((seen == on_red["instance"][k, ..., 0] * (on_red["instance"][k, ..., 0] != 2)).all(),
                              f"from the red node of world {k}")


def limits(test):
    """What does not fit is refused with the number that does, which is then drawn."""
    with renderer_of(test, *PLAIN_IMAGES, "--peer-limit", "gpu-bytes=1MiB") as renderer:
        with renderer.stream("limits") as stream:
            def draw(worlds):
                batch = stream.batch(worlds, (8, 8), NODES, views=[worlds - 1], outputs=["depth"], **SMALL)
                return batch.render(random_poses(1), timeout_s=HANG_S)
            text = raised(fire3dv.RefusedError, "2000 worlds do not fit, ", lambda: draw(2000))
            fits = int(text.partition("do not fit, ")[2].partition(" do")[0])
            check(1 < fits < 2000 and "gpu-bytes" in text, text)
            check(numpy.isfinite(draw(fits)["depth"]).any(), "nothing is drawn")
            raised(fire3dv.RefusedError, f"{fits + 1} worlds do not fit, {fits} do", lambda: draw(fits + 1))
            check(numpy.isfinite(draw(2)["depth"]).any(), "a refused batch takes the worlds of others with it")
            for output in ("motion", "boxes2d", "linear"):
                raised(fire3dv.RefusedError, "is not available in batches", lambda: stream.batch(
                    1, (8, 8), outputs=[output], **SMALL).render(random_poses(1), timeout_s=HANG_S))
            raised(fire3dv.RefusedError, "view 0: no scene node is called \"nobody\"", lambda: stream.batch(
                1, (8, 8), node="nobody", **SMALL).render(random_poses(1), timeout_s=HANG_S))
        with renderer.stream("names") as stream:  # also of nodes that the scene lacks
            stream.describe(NODES + [f"other {i}" for i in range(4000)])
            poses = numpy.tile(numpy.eye(3, 4, dtype=numpy.float32), (1, 4003, 1, 1))
            text = raised(fire3dv.RefusedError, "8 worlds do not fit, 2 do", lambda: stream.batch(
                8, (8, 8), outputs=["depth"], **SMALL).render(poses, timeout_s=HANG_S))
            check("gpu-bytes" in text, text)
    with renderer_of(test, *PLAIN_IMAGES, "--raster", "forward") as renderer, renderer.stream("forward") as stream:
        raised(fire3dv.RefusedError, "batches: several cameras at once need the visibility path", lambda: stream.batch(
            1, (8, 8), NODES, outputs=["color"], **SMALL).render(random_poses(1), timeout_s=HANG_S))


def shapes(test):
    """Wrong arguments are errors that name the argument and its shape, before anything is sent."""
    poses = random_poses(2)
    numbers = numpy.random.default_rng(2).normal(size=(5, 7)).astype(numpy.float32)
    numbers[:, 3:] /= numpy.linalg.norm(numbers[:, 3:], axis=1, keepdims=True)
    xyzw = numbers[:, [0, 1, 2, 4, 5, 6, 3]]
    wanted = fire3dv.pose(numbers[:, :3], wxyz=numbers[:, 3:]).reshape(5, 12)
    check(numpy.abs(_of_quaternions(numbers, "q", True) - wanted).max() < 1e-6, "wxyz")
    check(numpy.abs(_of_quaternions(xyzw, "q", False) - wanted).max() < 1e-6, "xyzw")
    argument, state = fire3dv.ArgumentError, fire3dv.StateError
    with fire3dv.Stream("shm://batch_shapes") as stream:
        raised(state, "no nodes yet", lambda: stream.batch(2, SIZE, **VIEW))
        batch = stream.batch(2, SIZE, NODES, **VIEW)
        check(stream._node_names == NODES, "the stream is not described")
        for text, call in {
            "worlds is 0": lambda: stream.batch(0, SIZE, **VIEW),
            "size is 64": lambda: stream.batch(2, 64, **VIEW),
            "outputs is 'colour'": lambda: stream.batch(2, SIZE, outputs=["colour"], **VIEW),
            "nodes[1] is 'pink', which is none": lambda: stream.batch(2, SIZE, ["red", "pink"], **VIEW),
            "views[1] is 2; there are worlds 0 to 1": lambda: stream.batch(2, SIZE, views=[0, 2], **VIEW),
            "views has the shape (1, 1)": lambda: stream.batch(2, SIZE, views=[[0]], **VIEW),
            "vertical_fov_rad, or a node": lambda: stream.batch(2, SIZE),
            "exclude each other": lambda: stream.batch(2, SIZE, vertical_fov_rad=1, **VIEW),
            "without skew": lambda: stream.batch(2, SIZE, camera_matrices=numpy.ones((3, 3))),
            "camera_poses has the shape (3, 12); its leading dimension is 1 (shared) or 2":
                lambda: batch.render(poses, camera_poses=numpy.tile(CAMERA, (3, 1))),
            "poses has the shape (3, 7); (W, B, 12)": lambda: batch.render(poses[0]),
            "poses has the shape (2, 2, 7); it has 2 nodes, the batch 3": lambda: batch.render(poses[:, :2]),
            "poses has the shape (3, 3, 12); its leading dimension is 1 (shared) or 2, the number of worlds":
                lambda: batch.render(numpy.tile(CAMERA, (3, 3, 1))),
            "poses must hold numbers": lambda: batch.render("poses"),
            "poses[1][2] has a quaternion of the length 0": lambda: batch.render(
                numpy.concatenate([poses[:1], numpy.concatenate([poses[1:, :2], poses[1:, 2:] * 0], axis=1)])),
            "active has the shape (3,); (2,) is needed": lambda: batch.render(poses, active=[1, 0, 1]),
            "batch.poses[5]": lambda: batch.render(numpy.where(numpy.arange(72).reshape(2, 3, 12) == 65, numpy.nan, 1)),
            "1 to 8192 pixels": lambda: stream.batch(2, (9000, 8), **VIEW).render(poses),
            "come back in one batch": lambda: stream.batch(2, (8192, 8192), **VIEW).render(poses),
        }.items():
            raised(argument if "one batch" not in text else fire3dv.Error, text, call)
        request = batch.request(poses)
        request.close()
        raised(argument, "no image of request 1 is to come", lambda: request.wait(0.01))
        late = batch.request(poses)
        raised(fire3dv.Timeout, "no renderer is reached", lambda: late.wait(0.01))
        raised(fire3dv.Timeout, "no renderer is reached", lambda: batch.render(poses, timeout_s=0.01))
        rendered = BatchRequest(batch, late.id + 1)  # taken back by render()
        raised(argument, f"no image of request {rendered.id} is to come", lambda: rendered.wait(0.01))

        camera, views = numpy.array([CAMERA], numpy.float32), numpy.array([1, 0], numpy.uint32)
        kept = stream.batch(2, SIZE, views=views, camera_poses=camera, camera_matrices=VIEW["camera_matrices"])
        camera[:], views[:] = numpy.nan, 7
        kept.request(poses).close()
        stream.describe(NODES)
        batch.request(poses).close()
        stream.describe(NODES[::-1])
        raised(state, "describe() has given the stream other nodes", lambda: batch.render(poses))
        stream.describe(NODES)
    raised(state, "closed", lambda: batch.render(poses))


def turns(test):
    """Other images come between the submissions of a batch, and a batch that is taken back ends."""
    poses = random_poses(1)
    views = [0] * 1536  # at most 32 of them are 16,384 rows, the limit of a submission
    with renderer_of(test, *PLAIN_IMAGES) as renderer, renderer.stream("turns") as stream:
        stream.describe(NODES)
        stream.publish(0, _of_quaternions(poses[0], "poses", True))
        batch = stream.batch(1, (8, 512), NODES, views=views, outputs=["color"], **SMALL)
        small = stream.batch(1, (8, 8), NODES, outputs=["color"], **SMALL)
        small.render(poses, timeout_s=HANG_S)

        def single():
            stream.request_image(8, 8, fx=8, parent_from_camera=CAMERA).wait(HANG_S).close()
        single()
        request, singles = batch.request(poses), 0
        while True:
            single()
            singles += 1
            try:
                images = request.wait(0)
                break
            except fire3dv.Timeout:
                pass
        # Two come before and after a batch that holds the renderer until its end.
        check(singles > 3, f"{singles} images of a stream were drawn during a batch of 48 submissions or more")
        check(len({images["color"][v].tobytes() for v in range(len(views))}) == 1 and images["color"].any(), "views of one world differ")
        request = batch.request(poses)
        single()
        request.close()
        check(small.render(poses, timeout_s=HANG_S)["color"].any(), "nothing is drawn after a batch that was taken back")


def example(test):
    """The program of examples/batch_worlds with a robot of two links."""
    robot, picture = test.path("robot.urdf"), test.path("worlds.png")
    with open(robot, "w", encoding="utf-8") as file:
        file.write(URDF)
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../examples/batch_worlds/batch_worlds.py")
    done = subprocess.run([sys.executable, script, robot, "--worlds", "6", "--size", "16x16", "--steps", "2", "--out", picture],
                          env={**os.environ, **vulkan_environment(), "FIRE3DV": test.programs_at["fire3dv"]},
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=HANG_S, text=True)
    lines = done.stdout.splitlines()
    check(done.returncode == 0 and len(lines) == 2 and "color (6, 16, 16, 4), " in lines[1], done.stdout)
    tiles = read_png(picture)
    check((tiles.width, tiles.height) == (32, 48), f"{tiles.width}x{tiles.height}")
    rows = numpy.frombuffer(b"".join(tiles.rows), numpy.uint8).reshape(3, 16, 2, 16, 3).swapaxes(1, 2).reshape(6, -1)
    check(len({row.tobytes() for row in rows}) == 6, "worlds are alike")


def scene_of(case):
    def run(test):
        test.scene = test.path("squares.glb")
        write_scene(test.scene, sun=True)
        case(test)
    return run


if __name__ == "__main__":
    main({case.__name__: scene_of(case) for case in (worlds, single, limits, shapes, turns, example)}, ["fire3dv"])
