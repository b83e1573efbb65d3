#!/usr/bin/env python3
"""End-to-end test of robot description and mesh files: the command line of fire3dv-convert, such files as scenes of fire3dv
with cached conversion, streams that move links, and refusals.

convert_test.py FIRE3DV FIRE3DV_CONVERT [CASE...]
"""
import glob
import json
import math
import os
import re
import shutil
import struct
import subprocess
import time
import zipfile

from harness import Program, main, vulkan_environment
from image_reader import check
from mcap_file import McapFile

TREE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
ROBOTS = os.path.join(TREE, "tests", "assets", "robots")
PANDA = next((path for path in (os.path.join(root, "robots", "franka_emika_panda") for root in
                                (os.environ.get("FIRE3DV_ASSETS", ""), os.path.join(TREE, "..", "shared", "assets")))
              if os.path.isdir(path)), None)
SIZE = (200, 150)
# The stream frame is that of URDF and MJCF (Z up); glTF is Y up.
Z_UP = [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0]

# Two tiny boxes fix the scene bounds. They frame a scene without cameras, independent of the arm's pose.
ARM = """<robot name="two links"><link name="base">
<visual><origin xyz="-1.2 -1.2 -1"/><geometry><box size="0.01 0.01 0.01"/></geometry></visual>
<visual><origin xyz="1.2 1.2 1.5"/><geometry><box size="0.01 0.01 0.01"/></geometry></visual>
<visual><geometry><box size="0.5 0.5 0.2"/></geometry></visual></link>
<joint name="a" type="continuous"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.1" rpy="{} 0 0"/><axis xyz="1 0 0"/></joint>
<link name="arm"><visual><origin xyz="0 0 0.4"/><geometry><box size="0.2 0.1 0.8"/></geometry>
<material name="red"><color rgba="1 0.1 0.1 1"/></material></visual></link>
<joint name="b" type="fixed"><parent link="arm"/><child link="hand"/><origin xyz="0 0 0.9"/></joint>
<link name="hand"><visual><geometry><sphere radius="0.2"/></geometry></visual>{}</link></robot>
"""
MISSING = '<visual><geometry><mesh filename="hand.obj"/></geometry></visual>'
TETRAHEDRON = "v 0 0 0\nv 0.5 0 0\nv 0 0.5 0\nv 0 0 0.5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def write(test, name, text):
    with open(test.path(name), "w", encoding="utf-8") as file:
        file.write(text)
    return test.path(name)


def convert(test, *arguments, code=0):
    done = subprocess.run([test.programs_at["convert"], *arguments], capture_output=True, text=True, timeout=600)
    check(done.returncode == code, f"{arguments} ended with {done.returncode}, not {code}:\n{done.stderr}")
    for line in done.stderr.splitlines():
        check(re.match("fire3dv-convert: (info|warning|error): ", line), f"{arguments} says {line!r}")
    return done


def document_of(path):
    with open(path, "rb") as file:
        data = file.read()
    length, = struct.unpack_from("<I", data, 12)
    return json.loads(data[20:20 + length])


def draw(test, scene, *arguments, cache="off"):
    """Returns the rows of the image and the text on stderr."""
    renderer = test.renderer("--frames", "1", "--shadows", "map", "--cache", cache, *arguments, scene=scene, size=SIZE)
    renderer.expect_exit(0)
    return renderer.picture(renderer.frames()[0]).rows, renderer.err


def different(a, b):
    """Returns the fraction of pixels that differ visibly."""
    pixels = far = 0
    for row_a, row_b in zip(a, b):
        for at in range(0, len(row_a), 3):
            pixels += 1
            far += any(abs(row_a[at + i] - row_b[at + i]) > 16 for i in range(3))
    return far / pixels


def command_line(test):
    arm = write(test, "arm.urdf", ARM.format(0, MISSING))
    done = convert(test, arm, "-o", test.path("arm.glb"), "--sources", test.path("arm.sources"), "--list")
    check(done.stdout.split("\n")[:3] == ["base\t36 triangles", "  arm\t12 triangles", "    hand\t2208 triangles"], done.stdout)
    check("link \"hand\": " in done.stderr and "hand.obj" in done.stderr, done.stderr)
    check(re.search(r"arm\.glb: 4 nodes, 2256 triangles, 0 cameras, 1 light, \d+ bytes, 1 warning\n$", done.stderr), done.stderr)
    check([node["name"] for node in document_of(test.path("arm.glb"))["nodes"]] == ["two links", "base", "arm", "hand", "light from above"],
          "nodes of the file")
    with open(test.path("arm.sources"), encoding="utf-8") as file:
        check(re.search(r"^source 0 .* \S*hand\.obj$", file.read(), re.MULTILINE), "a missing source is recorded as such")
    check(convert(test, test.path("arm.glb"), "--list").stdout.splitlines() ==
          ["two links", "  base\t36 triangles", "    arm\t12 triangles", "      hand\t2208 triangles", "  light from above\tlight"],
          "the nodes of a .glb")
    twice = subprocess.run([test.programs_at["convert"], arm, "-o", "-"], capture_output=True, timeout=600, check=True).stdout
    with open(test.path("arm.glb"), "rb") as file:
        check(file.read() == twice, "the standard output gets the same bytes")
    for code, said, arguments in (
            (2, "name the file to write", [arm]), (2, "--sources needs", [arm, "-o", "-", "--sources", "x"]),
            (2, "-l: must be numbers", [arm, "-o", "x", "-l", "1,,2"]), (2, "--nonsense", [arm, "--nonsense"]),
            (1, "is no AMBF launch file", [arm, "-o", test.path("x"), "-l", "1"]),
            (1, "cannot open", [test.path("gone.urdf"), "-o", test.path("x")]),
            (1, "not a regular file", ["/dev/zero", "-o", test.path("x")]),
            (1, "cannot write", [arm, "-o", test.path("no/such/folder/x.glb")])):
        check(said in convert(test, *arguments, code=code).stderr, f"{arguments}: {said}")
    check(not os.path.exists(test.path("x")), "nothing is written on a failure")
    os.symlink("linked.glb", test.path("link.glb"))
    write(test, "linked.glb", "old")
    os.chmod(test.path("linked.glb"), 0o640)
    convert(test, arm, "-o", test.path("link.glb"))
    check(os.path.islink(test.path("link.glb")), "a link stays one")
    with open(test.path("linked.glb"), "rb") as file:
        check(file.read() == twice, "and what it leads to is written")
    check(os.stat(test.path("linked.glb")).st_mode & 0o777 == 0o640, "with the mode that it had")
    umask = os.umask(0)
    os.umask(umask)
    convert(test, arm, "-o", test.path("new.glb"))
    check(os.stat(test.path("new.glb")).st_mode & 0o777 == 0o666 & ~umask, "a new file has the umask's mode")
    os.mkfifo(test.path("pipe"))
    reading = subprocess.Popen(["cat", test.path("pipe")], stdout=subprocess.PIPE)
    convert(test, arm, "-o", test.path("pipe"))
    check(reading.communicate(timeout=600)[0] == twice, "a pipe is written to")
    check("not a regular file" in convert(test, arm, "-o", test.path("pipe"), "--sources", test.path("x"), code=1).stderr, "kept")
    evil = write(test, "evil.urdf", ARM.format(0, "").replace('name="hand"', 'name="\033]0;hand\177"').replace('link="hand"', 'link="\033]0;hand\177"'))
    done = convert(test, evil, "--list")
    check("]0;hand" in done.stdout and not re.search("[\\x00-\\x08\\x0b-\\x1f\\x7f]", done.stdout + done.stderr), repr(done.stdout))


def kept(test):
    cache = test.path("cache")
    arm = write(test, "arm.urdf", ARM.format(0, MISSING))
    time.sleep(0.1)  # a file written less than a time stamp's resolution ago is not cached

    def converted():
        files = glob.glob(os.path.join(cache, "scenes", "*.converted.glb"))
        check(len(files) == 1, f"kept: {files}")
        return os.stat(files[0]).st_ino

    first, said = draw(test, arm, cache=cache)
    inode = converted()
    again, said_again = draw(test, arm, cache=cache)
    check(converted() == inode and first == again, "the second start takes what was kept")
    for lines in (said, said_again):
        check(any("warning: " in line and "hand.obj" in line for line in lines), "what is missing is said at every start")
    write(test, "hand.obj", TETRAHEDRON)  # the missing file of the first attempt exists now
    time.sleep(0.1)
    whole, said = draw(test, arm, cache=cache)
    check(converted() != inode and whole != first, "a mesh that has come is shown")
    check(not any("hand.obj" in line for line in said), "and no longer missed")
    inode = converted()
    write(test, "arm.urdf", ARM.format(1, MISSING))
    check(draw(test, arm, cache=cache)[0] != whole and converted() != inode, "a changed description is read anew")
    for path in glob.glob(os.path.join(cache, "scenes", "*.converted.glb")):
        with open(path, "wb") as file:
            file.write(b"glTF")  # damage the cache entry
    check(draw(test, arm, cache=cache)[0] != whole, "a damaged one is rebuilt")
    for path in glob.glob(os.path.join(cache, "scenes", "*.conversion")):
        with open(path, encoding="utf-8") as file:
            lines = file.read().split("\n")
        check(lines[2].endswith("fire3dv-convert"), lines)
        program = test.path("other")
        shutil.copy(test.programs_at["convert"], program)
        status = os.stat(program)
        lines[2] = f"source 1 {status.st_size} {status.st_ino} {status.st_mtime_ns} {status.st_ctime_ns} {program}"
        write(test, path, "\n".join(lines))
    inode = converted()
    draw(test, arm, cache=cache)
    check(converted() != inode, "what another converter made is rebuilt")


def without_cache(test):
    arm = write(test, "arm.urdf", ARM.format(0, ""))
    convert(test, arm, "-o", test.path("arm.glb"))
    before = sorted(os.listdir(test.folder))
    rows, _ = draw(test, arm)
    check(sorted(name for name in os.listdir(test.folder) if not name.startswith("images")) == before, "nothing is left behind")
    check(rows == draw(test, test.path("arm.glb"))[0], "the same picture as of the file")
    launch = os.path.join(TREE, "tests", "assets", "adf", "launch.yaml")
    _, first = draw(test, launch, "--models", "0")
    _, all_models = draw(test, launch, "--models", "all")
    nodes = [int(re.search(r": (\d+) nodes, ", "\n".join(lines)).group(1)) for lines in (first, all_models)]
    check(nodes[0] < nodes[1], f"nodes of one and of all models: {nodes}")


def unkept(test):
    """A convertible file is drawn even if the cache cannot be written."""
    arm = write(test, "arm.urdf", ARM.format(0, ""))
    cache = test.path("cache")
    plain, _ = draw(test, arm, cache=cache)
    path, = glob.glob(os.path.join(cache, "scenes", "*.converted.glb"))
    os.remove(path)
    os.mkdir(path)  # a folder that rename() cannot replace
    rows, said = draw(test, arm, cache=cache)
    check(rows == plain, "the same picture")
    check(any("it is not cached for the next start: cannot write" in line for line in said), said)
    for closed in ("<&-", ">&-", "<&- >&-"):
        run = subprocess.run(["sh", "-c", f'exec "$@" {closed}', "sh", test.programs_at["fire3dv"], arm, "--headless", "--frames",
                              "1", "--size", "64x64", "--cache", "off", "--out", test.path("closed")],
                             env=vulkan_environment(), capture_output=True, text=True, timeout=600)
        check(run.returncode == 0, f"{closed}: {run.stderr}")


def recorded(test):
    """--record-scene attaches the conversion of a description, with and without a cache, and the recording is replayed."""
    import fire3dv
    arm = write(test, "arm.urdf", ARM.format(0, ""))
    convert(test, arm, "-o", test.path("arm.glb"))
    pose = poses_of(test.path("arm.glb"))["arm"]
    with open(test.path("arm.glb"), "rb") as file:
        expected = file.read()
    for number, cache in enumerate(("off", test.path("cache"))):
        path, uri = test.path(f"run{number}.mcap"), test.fresh_uri("shm")
        common = ["--headless", "--size", "64x36", "--cache", cache]
        run = Program(test, "fire3dv", [test.programs_at["fire3dv"], arm, "--listen", uri, "--record", path, "--record-scene",
                                        "--exit-when-done", *common], env=vulkan_environment())
        with fire3dv.Stream(uri, adapter_name="joints") as stream:
            stream.describe(["arm"], world_from_stream=Z_UP)
            stream.publish(1000, [pose])
            check(stream.wait_ack(1, 240_000), "the frame is shown")
        run.expect_exit()
        check(McapFile(path).attachments == [("arm.glb", "model/gltf-binary", expected)], "the attachment is another one")
        again = Program(test, "fire3dv", [test.programs_at["fire3dv"], "--replay", path, *common, "--camera", "nope"],
                        env=vulkan_environment())
        check(again.wait() == 1, again.stderr_text())
        check(again.find_err(f"error: --camera nope: arm.glb in {path} has no") and "fire3dv-scene-" not in again.stderr_text(),
              again.stderr_text())


def refused(test):
    def failing(program, scene, *arguments, code=1):
        run = Program(test, "fire3dv", [program, scene, "--headless", "--frames", "1", "--cache", "off", *arguments],
                      env=vulkan_environment())
        check(run.wait() == code, f"{scene} ended with {run.process.returncode}:\n{run.stderr_text()}")
        return run.err[-1]

    fire3dv = test.programs_at["fire3dv"]
    check("line 2: " in failing(fire3dv, write(test, "bad.urdf", '<robot name="r">\n<link></robot>')), "a line is named")
    robot = write(test, "robot.xacro", '<robot name="$(arg a)">\n<xacro:m/></robot>')
    check("line 2, <xacro:m>: " in failing(fire3dv, robot, "--xacro-arg", "a=b"), "a line of xacro is named")
    check("--xacro-arg a=VALUE" in failing(fire3dv, robot), "a missing argument is named")
    check("gone.xml" in failing(fire3dv, test.path("gone.xml")), "a missing file is named")
    check("needs a scene that is a description" in failing(fire3dv, test.scene, "--models", "0", code=2), "no description")
    check("must be numbers" in failing(fire3dv, os.path.join(TREE, "tests/assets/adf/launch.yaml"), "--models", "x"), "-l")

    # The program uses the fire3dv-convert in its own folder, or none. It resolves symbolic links to itself,
    # so this test copies it.
    alone = test.path("alone")
    os.mkdir(alone)
    copy = os.path.join(alone, "fire3dv")
    try:
        os.link(fire3dv, copy)
    except OSError:
        shutil.copy(fire3dv, copy)
    arm = write(test, "arm.urdf", ARM.format(0, ""))
    check("which is not beside fire3dv" in failing(copy, arm), "no converter")
    for body, said in (("kill -SEGV $$", "crashed (Segmentation fault)"),
                       ("echo 'fire3dv-convert: a sentence' >&2; exit 1", "fire3dv: error: a sentence"),
                       ("exit 3", "failed without a reason"),
                       ("yes 'fire3dv-convert: warning: x' | head -100000 >&2; printf junk", "the conversion of " + arm)):
        write(test, "alone/fire3dv-convert", "#!/bin/sh\n" + body + "\n")
        os.chmod(os.path.join(alone, "fire3dv-convert"), 0o755)
        check(said in failing(copy, arm), f"{body}: {said}")
    write(test, "alone/fire3dv-convert", "#!/bin/sh\nexec sleep 1000\n")
    run = Program(test, "fire3dv", [copy, arm, "--headless", "--frames", "1", "--cache", "off"], env=vulkan_environment())
    run.wait_err("device 0")  # wait until it runs
    run.signal(15)
    check(run.wait() == 1 and "it was interrupted" in run.stderr_text(), f"a stop ends a conversion:\n{run.stderr_text()}")


def meshes(test):
    """Mesh files as scenes: each shows an orange cube, and the converter's file gives the same image."""
    faces = ((0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2),
             (1, 3, 7), (1, 7, 5))
    corners = [(i & 1, i >> 1 & 1, i >> 2 & 1) for i in range(8)]
    write(test, "cube.mtl", "newmtl orange\nKd 1 0.5 0\n")
    write(test, "cube.obj", "mtllib cube.mtl\n" + "".join("v %d %d %d\n" % corner for corner in corners) + "usemtl orange\n" +
          "".join("f %d %d %d\n" % tuple(i + 1 for i in face) for face in faces))
    write(test, "cube.ply", "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
          "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 12\n"
          "property list uchar int vertex_indices\nend_header\n" + "".join("%d %d %d 255 128 0\n" % corner for corner in corners) +
          "".join("3 %d %d %d\n" % face for face in faces))
    with open(test.path("cube.stl"), "wb") as file:
        file.write(b" " * 80 + struct.pack("<I", len(faces)))
        for face in faces:
            file.write(struct.pack("<12fH", 0, 0, 0, *corners[face[0]], *corners[face[1]], *corners[face[2]], 0x8000 | 31 << 10 | 16 << 5))
    model = ('<model unit="meter"><resources><basematerials id="5"><base name="orange" displaycolor="#FF8000"/></basematerials>'
             '<object id="1" pid="5" pindex="0"><mesh><vertices>' + "".join('<vertex x="%d" y="%d" z="%d"/>' % corner for corner in corners) +
             "</vertices><triangles>" + "".join('<triangle v1="%d" v2="%d" v3="%d"/>' % face for face in faces) +
             '</triangles></mesh></object></resources><build><item objectid="1"/></build></model>')
    with zipfile.ZipFile(test.path("cube.3mf"), "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", model)
    for name in ("cube.obj", "cube.ply", "cube.stl", "cube.3mf"):
        rows, said = draw(test, test.path(name))
        check(any(f"{name}: " in line and ", 12 triangles, " in line for line in said), said)
        at = 3 * (SIZE[0] // 2)
        red, green, blue = rows[SIZE[1] // 2][at:at + 3]
        check(red > 1.2 * green and green > 1.2 * blue, f"{name}: {red} {green} {blue}")
        convert(test, test.path(name), "-o", test.path("cube.glb"))
        check(draw(test, test.path("cube.glb"))[0] == rows, f"{name}: the same picture as of its conversion")
    convert(test, test.path("cube.stl"), "--unit", "in", "--up", "y", "-o", test.path("inches.glb"))
    accessors = document_of(test.path("inches.glb"))["accessors"]
    check(any([round(x, 6) for x in accessor.get("max", [])] == [0.0254] * 3 for accessor in accessors), accessors)
    renderer = test.renderer("--frames", "1", "--unit", "mm", "--up", "y", scene=test.path("cube.stl"), size=SIZE)
    renderer.expect_exit(0)
    # A cube of 70 mm in a file without a unit is a cube of 70 m.
    write(test, "large.obj", "".join("v %d %d %d\n" % tuple(70 * x for x in corner) for corner in corners) +
          "".join("f %d %d %d\n" % tuple(i + 1 for i in face) for face in faces))
    hint = "large.obj: its meshes are 121 m large: if these are millimetres, set --unit mm"
    for unit in ((), ("--unit", "mm")):
        said = draw(test, test.path("large.obj"), *unit)[1]
        check(any(hint in line for line in said) == (not unit), said)
    png = test.path("image.stl")
    with open(png, "wb") as file:
        file.write(b"\x89PNG\r\n")
    for code, said, arguments in ((2, "needs a scene that is a mesh file", [test.scene, "--unit", "mm"]),
                                  (2, "--unit", [test.path("cube.stl"), "--unit", "yard"]),
                                  (1, "remove --up and --unit", [test.path("cube.3mf"), "--unit", "mm"]),
                                  (1, "is a PNG image", [png]),
                                  (1, "an FBX scene", [write(test, "a.fbx", "; FBX 7.3.0")]),
                                  (1, "a folder; name a scene in it", [test.folder])):
        run = Program(test, "fire3dv", [test.programs_at["fire3dv"], *arguments, "--headless", "--frames", "1", "--cache", "off"],
                      env=vulkan_environment())
        check(run.wait() == code and said in run.stderr_text(), f"{arguments}: {said}:\n{run.stderr_text()}")


def matrix_of(node):
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    t = node.get("translation", [0, 0, 0])
    return [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), t[0],
            2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), t[1],
            2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), t[2]]


def product(a, b):
    return [sum(a[4 * r + k] * b[4 * k + c] for k in range(3)) + (a[4 * r + 3] if c == 3 else 0)
            for r in range(3) for c in range(4)]


def poses_of(glb):
    """Returns the poses of all nodes below the root, in its frame, as a simulator would publish them."""
    nodes, poses = document_of(glb)["nodes"], {}

    def visit(index, above):
        pose = product(above, matrix_of(nodes[index]))
        poses[nodes[index]["name"]] = pose
        for child in nodes[index].get("children", []):
            visit(child, pose)
    for child in nodes[0]["children"]:
        visit(child, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0])
    return poses


def move(test, at_rest, posed, links, *view):
    """A stream that poses these links makes the first scene equal to the second, which rests in that pose."""
    import fire3dv
    convert(test, posed, "-o", test.path("posed.glb"))
    poses = poses_of(test.path("posed.glb"))
    wanted, _ = draw(test, posed, *view)
    rest, _ = draw(test, at_rest, *view)
    uri = test.fresh_uri("shm")
    renderer = test.renderer("--lockstep", "--exit-when-done", "--shadows", "map", *view, listen=[uri], scene=at_rest, size=SIZE)
    with fire3dv.Stream(uri, adapter_name="joints") as stream:
        stream.describe(links, world_from_stream=Z_UP)
        stream.publish(1000, [poses[link] for link in links])
        check(stream.wait_ack(1, 240_000), "the frame is shown")
        check(stream.poll().unmatched_names == 0, stream.poll().welcome_message)
    renderer.expect_exit(0)
    frame = next(frame for frame in renderer.frames() if frame["streams"])
    moved = renderer.picture(frame).rows
    parts = different(moved, wanted), different(rest, wanted)
    print(f"{os.path.basename(at_rest)}: moved {parts[0]:.2%}, at rest {parts[1]:.2%} of the pixels off", flush=True)
    check(parts[0] < 0.002 and parts[1] > 0.01, f"moved and at rest: {parts}")


def sdf(test):
    """A world of Gazebo with an included model, its model folder, and a stream under Gazebo's names."""
    box = ('<model name="crate"><link name="l"><pose>{} 0 0.5 0 0 0</pose><visual name="v"><geometry><box><size>1 1 1</size></box>'
           "</geometry><material><diffuse>1 0.1 0.1 1</diffuse></material></visual></link></model>")
    world = ('<sdf version="1.9"><world name="w"><gui><camera name="c"><pose>-8 0 1 0 0 0</pose></camera></gui>'
             '<include><uri>model://crate</uri><pose>0 {} 0 0 0 0</pose></include></world></sdf>')
    os.makedirs(test.path("models/crate"))
    write(test, "models/crate/model.config", '<model><name>crate</name><sdf version="1.9">model.sdf</sdf></model>')
    crate = write(test, "models/crate/model.sdf", f'<sdf version="1.9">{box.format(0)}</sdf>')
    if "SDF" not in convert(test, "--version").stdout:
        check("it was built without libsdformat 12" in convert(test, crate, "--list", code=1).stderr, "the reason")
        return
    example = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../examples/gazebo_world/table.sdf")
    check("warning" not in convert(test, example, "--list").stderr, "the example is read as a whole")
    folder = os.path.join(test.path("models"), "crate")
    check("crate/l/v\t12 triangles" in convert(test, folder, "--list").stdout, "a model folder")
    check(draw(test, folder)[0] == draw(test, crate)[0], "the same picture of the folder and of its file")
    missing = convert(test, write(test, "gone.sdf", world.format(0).replace("crate", "gone")), "--list").stderr
    check("gone.sdf, line 1: <include> is left out: \"model://gone\" is not found in " in missing, missing)
    paths = ["--package-path", test.path("models")]
    at_rest, _ = draw(test, write(test, "rest.world", world.format(0)), *paths)
    moved, _ = draw(test, write(test, "moved.world", world.format(2)), *paths)
    check(at_rest != moved, "an included model is moved")


def passed_on(test):
    """Options of fire3dv-convert that fire3dv has, too."""
    cases = os.path.join(os.path.dirname(__file__), "../unit/convert/cases")
    turned = os.path.join(cases, "gltf_up.urdf")
    convert(test, turned, "--gltf-up", "ignore", "-o", test.path("ignored.glb"))
    ignored = draw(test, turned, "--gltf-up", "ignore")[0]
    check(ignored == draw(test, test.path("ignored.glb"))[0] != draw(test, turned)[0], "--gltf-up is passed on")
    stl = test.path("fan.stl")
    around = [(math.cos(0.3 * i), math.sin(0.3 * i)) for i in range(22)]
    with open(stl, "w", encoding="utf-8") as file:
        file.write("solid fan\n")
        for (x, y), (u, v) in zip(around, around[1:]):
            for triangle in ((x, y, 0), (u, v, 0), (u, v, 2)), ((x, y, 0), (u, v, 2), (x, y, 2)):
                corners = "".join("vertex %f %f %f\n" % corner for corner in triangle)
                file.write(f"facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
        file.write("endsolid fan\n")
    convert(test, stl, "--smooth-angle", "0", "-o", test.path("flat.glb"))
    flat = draw(test, stl, "--smooth-angle", "0")[0]
    check(flat == draw(test, test.path("flat.glb"))[0] != draw(test, stl)[0], "--smooth-angle is passed on")
    model = os.path.join(cases, "mjcf_parent/scene/task.xml")
    draw(test, model)
    for code, said, arguments in ((1, "--package-path", [model, "--confined"]),
                                  (2, "needs a scene that is a description or a mesh file", [test.scene, "--confined"]),
                                  (2, "is not a number from 0 to 180", [stl, "--smooth-angle", "181"])):
        run = Program(test, "fire3dv", [test.programs_at["fire3dv"], *arguments, "--headless", "--frames", "1", "--cache", "off"],
                      env=vulkan_environment())
        check(run.wait() == code and said in run.stderr_text(), f"{arguments}: {said}:\n{run.stderr_text()}")


def cameras(test):
    """Cameras with intrinsics: where MuJoCo draws the ball, which is on the axis of each."""
    scene = os.path.join(os.path.dirname(__file__), "../unit/convert/cases/mjcf_intrinsics.xml")
    for camera, centre, half in (("centred", (160, 120), (30, 30)), ("off", (120, 150), (30, 30)), ("anis", (160, 120), (15, 30))):
        renderer = test.renderer("--frames", "1", "--camera", camera, "--outputs", "color,boxes2d", "--cache", "off", "--samples", "1",
                                 scene=scene, size=(320, 240))
        renderer.expect_exit(0)
        (box,) = renderer.frames()[0]["boxes2d"]
        x0, y0, x1, y1 = box["box"]
        is_there = all(abs(a - b) <= 1.5 for a, b in zip(((x0 + x1) / 2, (y0 + y1) / 2, (x1 - x0) / 2, (y1 - y0) / 2), (*centre, *half)))
        check(is_there, f"{camera}: {box}")


def moved_urdf(test):
    move(test, write(test, "rest.urdf", ARM.format(0, "")), write(test, "posed.urdf", ARM.format(1.2, "")), ["arm"])


def moved_mjcf(test):
    with open(os.path.join(ROBOTS, "arm.xml"), encoding="utf-8") as file:
        text = file.read()
    shutil.copytree(os.path.join(ROBOTS, "arm_description"), test.path("arm_description"))
    rest = write(test, "rest.xml", text)
    posed = write(test, "posed.xml", text.replace('qpos="0.5 0.9 0.03 0.03', 'qpos="-0.4 1.6 0.03 0.03'))
    move(test, rest, posed, ["upper arm", "forearm"])  # the fingers follow


def moved_panda(test):
    if not PANDA:
        print("not tried: shared/assets/robots is missing", flush=True)
        return
    with open(os.path.join(PANDA, "panda.xml"), encoding="utf-8") as file:
        text = file.read()
    shutil.copytree(os.path.join(PANDA, "assets"), test.path("assets"))
    rest = write(test, "rest.xml", text)
    posed, count = re.subn(r"(<key [^>]*qpos=['\"])[^'\"]*", r"\g<1>0.5 0.3 -0.4 -1.2 0.3 2 0.4 0.01 0.01", text)
    check(count == 1, "the model's keyframe")
    links = [f"link{i}" for i in range(8)] + ["hand", "left_finger", "right_finger"]
    # The overview depends on the pose; MuJoCo's camera does not.
    move(test, rest, write(test, "posed.xml", posed), links, "--camera", "free camera")


if __name__ == "__main__":
    main({"command_line": command_line, "kept": kept, "without_cache": without_cache, "unkept": unkept, "recorded": recorded,
          "refused": refused, "meshes": meshes, "sdf": sdf, "cameras": cameras, "passed_on": passed_on, "moved_urdf": moved_urdf, "moved_mjcf": moved_mjcf, "moved_panda": moved_panda}, ["fire3dv", "convert"])
