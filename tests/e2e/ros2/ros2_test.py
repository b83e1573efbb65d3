"""ROS 2 adapter against publishers on Cyclone DDS and Fast DDS: frames, robots, times, hostile messages, load.

All programs run in a network namespace with nothing but a loopback interface, so that tests do not see each other.
"""
import json
import math
import os
import sys
import time

from harness import main, wait_until
from hosts import SKIPPED, why_not
from image_reader import check
from ros2_system import SECOND, Ros, at, end, write
from stream_lines import StreamLines

URDF = """<robot name="arm">
  <link name="base"><visual><geometry><box size="1 1 0.1"/></geometry></visual></link>
  <link name="upper"><visual><geometry><box size="0.1 0.1 1"/></geometry></visual></link>
  <link name="tool"/>
  <link name="finger"/>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.5"/><axis xyz="0 0 1"/></joint>
  <joint name="flange" type="fixed"><parent link="upper"/><child link="tool"/><origin xyz="1 0 0"/></joint>
  <joint name="grip" type="prismatic"><parent link="tool"/><child link="finger"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/><mimic joint="shoulder" multiplier="0.5" offset="0.25"/></joint>
</robot>
"""


# --- frames --------------------------------------------------------------------------------------------------------------

def frames_late_adapter(test):
    """The adapter starts last: static transforms of two broadcasters reach it, moving ones follow."""
    ros = Ros(test)
    first, second = ros.side("first", wait=False), ros.side("second", opens=["tf_static"], wait=False)
    first.send("tf_static", ("map", "odom", 0, 1, 0, 0))
    second.send("tf_static", ("base", "laser", 0, 0, 0, 0.5))
    adapter = ros.adapter("--no-description")
    first.wait_readers("tf")
    half = math.sqrt(0.5)
    for i in range(5):
        first.send("tf", ("odom", "base", 10 + i, 2 + i, 0, 0, 0, 0, half, half))
        time.sleep(0.1)
    # Until map is known, odom is the fixed frame.
    frame = ros.wait_frame("the newest poses", lambda f: f[1] == 14 * SECOND and set(f[2]) == {"odom", "base", "laser"})
    check(at(frame[2]["laser"], 7, 0, 0.5) and abs(frame[2]["laser"][4] - 1) < 1e-6, str(frame))
    end(adapter)


def frames_late_publisher(test):
    """The publisher starts last, is killed and starts again; the adapter says what is missing."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description")
    adapter.wait_err(r"no transform was received for 3 s in domain \d+.*no other participant.*rmw_zenoh is not DDS")
    side = ros.side()
    side.send("tf_static", ("map", "flag", 0, 3))
    side.send("tf", ("map", "base", 5, 1))
    ros.wait_frame("the first run", lambda f: f[1] == 5 * SECOND and at(f[2]["base"], 1) and at(f[2]["flag"], 3))
    side.kill()
    again = ros.side("again")
    again.send("tf", ("map", "base", 6, 2))
    ros.wait_frame("the second run", lambda f: f[1] == 6 * SECOND and at(f[2]["base"], 2) and at(f[2]["flag"], 3))
    check(not adapter.find_err("two publishers"), adapter.stderr_text())
    adapter.kill()  # restart of the adapter
    ros.lines.end()
    ros.lines = StreamLines(test.programs_at["stream_dump"], ros.uri)
    adapter = ros.adapter("--no-description")
    again.send("tf_static", ("map", "flag", 0, 4))
    again.wait_readers("tf")
    wait_until("the adapter to receive", lambda: again.send("tf", ("map", "base", 7, 3)) or ros.named_frames())
    ros.wait_frame("the third run", lambda f: at(f[2].get("flag", [0] * 12), 4) and at(f[2].get("base", [0] * 12), 3))
    end(adapter)


def frames_grow(test):
    """A set of frames that grows makes few descriptions; unconnected frames and their publisher are named."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description")
    side = ros.side()
    for i in range(20):
        side.send("tf", *[("map", f"f{k}", 1 + i / 100, k) for k in range(i + 1)])
        time.sleep(0.01)
    ros.wait_frame("all frames", lambda f: len(f[2]) == 20)
    check(len(ros.descriptions()) <= 4, f"{len(ros.descriptions())} descriptions")
    side.send("tf", ("island", "boat", 2, 0))
    adapter.wait_err(r'frame "boat" of .*publisher.* has no path to the fixed frame "map": nobody publishes a parent of "island"')
    side.send("tf", ("map", "island", 2, 100))
    ros.wait_frame("the island", lambda f: at(f[2].get("boat", [0] * 12), 100))
    end(adapter)


def frames_names(test):
    """Fixed frame, prefix, namespace and remapping."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description", "--fixed-frame", "odom", "--frame-prefix", "r1/", "--ros-args", "-r", "__ns:=/fleet",
                          "-r", "/tf:=tf", "-p", "use_sim_time:=true")
    side = ros.side(opens=["tf /fleet/tf", "tf_static"])
    side.send("tf_static", ("map", "odom", 0, 50))
    side.send("tf", ("odom", "r1/base", 1, 1), ("odom", "r2/base", 1, 2), ("map", "r1/post", 1, 7))
    frame = ros.wait_frame("frames of r1", lambda f: len(f[2]) == 2)
    check(at(frame[2]["base"], 1) and at(frame[2]["post"], -43), str(frame))
    end(adapter)
    for wrong in (["--ros-args", "-r", "a"], ["--ros-args", "-r", "a b:=c"], ["--domain", "233"], ["--namespace", "a//b"],
                  ["--ros-args", "--nonsense"], ["--ros-args", "-r"]):
        ros.adapter(*wrong).expect_exit(2)
    for variable in ("ROS_DOMAIN_ID", "ROS_LOCALHOST_ONLY", "ROS_AUTOMATIC_DISCOVERY_RANGE"):
        wrong = ros.adapter(env={variable: "nonsense"})
        wrong.expect_exit(1)
        check(wrong.find_err(f"error: {variable}=.nonsense"), wrong.stderr_text())


def frames_ranges(test):
    """Discovery ranges of ROS 2 meet a publisher with its library's defaults; OFF meets nobody."""
    for env in ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, {"ROS_LOCALHOST_ONLY": "1"}, {"ROS_STATIC_PEERS": "127.0.0.1;;"},
                {"CYCLONEDDS_URI": "<CycloneDDS><Domain><Tracing><Verbosity>none</Verbosity></Tracing></Domain></CycloneDDS>"}):
        ros = Ros(test)
        adapter = ros.adapter("--no-description", env=env)
        side = ros.side()
        side.send("tf", ("map", "base", 1, 1))
        ros.wait_frame(f"a frame with {env}", lambda f: at(f[2]["base"], 1))
        end(adapter)
    ros = Ros(test)
    side = ros.side(wait=False)
    adapter = ros.adapter(env={"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"})
    adapter.wait_err(r"range off \(ROS_AUTOMATIC_DISCOVERY_RANGE=OFF\).*no other participant was discovered")
    check(side.do("readers tf") == "ok 0", "a reader was found")
    end(adapter)


# --- robots --------------------------------------------------------------------------------------------------------------

def read_node_names(path):
    with open(path, "rb") as file:
        data = file.read()
    length = int.from_bytes(data[12:16], "little")
    return [node.get("name") for node in json.loads(data[20:20 + length])["nodes"]]


def scalars_of(ros):
    """Returns {group: ([(name, unit), ...], newest values)}."""
    groups = {}
    for message in list(ros.lines.messages):
        value = message.get("value", {}) if message["type"] == "SceneEdit" else {}
        if value.get("type") == "Scalars":
            groups[message["node"]] = list(zip(value["names"], value["units"])), None
        elif value.get("type") == "ScalarValues":
            groups[message["node"]] = groups[message["node"]][0], value["values"]
    return groups


def robot_joints(test):
    """Joint states without /tf: forward kinematics with mimic; then /tf takes over."""
    ros = Ros(test)
    scene = test.path("robot.glb")
    side = ros.side(opens=["robot_description", "joint_states", "tf", "tf_static"], wait=False)
    side.do("text " + write(test, "arm.urdf", URDF))
    adapter = ros.adapter("--write-scene", scene)
    adapter.wait_err(r"wrote \S*robot.glb; to draw it: fire3dv \S*robot.glb --listen shm://")
    check({"base", "upper", "tool", "finger"} <= set(read_node_names(scene)), str(read_node_names(scene)))
    side.wait_readers("joint_states", "tf")
    stamp = 100

    def move():
        nonlocal stamp
        stamp += 1
        side.do(f"joints {stamp * SECOND} shoulder {math.pi / 2} nonsense 3 tool nan")
        time.sleep(0.05)
        return adapter.find_err("computed from joint states") and any(len(f[2]) == 4 for f in ros.named_frames())
    wait_until("poses from joints", move)
    frame = ros.wait_frame("the four links", lambda f: len(f[2]) == 4)
    reach = math.pi / 4 + 0.25
    check(at(frame[2]["base"], 0, 0, 0) and at(frame[2]["upper"], 0, 0, 0.5) and at(frame[2]["tool"], 0, 1, 0.5) and
          at(frame[2]["finger"], 0, 1 + reach, 0.5), str(frame))
    groups = scalars_of(ros)
    check(groups["joint_positions"][0] == [("shoulder", "rad"), ("nonsense", ""), ("tool", "")] and
          groups["joint_positions"][1] == [math.pi / 2, 3, None] and len(groups) == 1, str(groups))
    # Another set of joints has groups of its own.
    side.do(f"moving_joints {stamp * SECOND} grip 0.5 2 -3 shoulder 1 4 5")
    groups = wait_until(lambda: f"efforts, not {scalars_of(ros)}",
                        lambda: len(scalars_of(ros)) == 4 and all(values for _, values in scalars_of(ros).values()) and scalars_of(ros))
    for name, units, values in (("positions", ("m", "rad"), [0.5, 1]), ("velocities", ("m/s", "rad/s"), [2, 4]), ("efforts", ("N", "N m"), [-3, 5])):
        check(groups[f"joint_{name} 2"] == (list(zip(("grip", "shoulder"), units)), values), str(groups))
    # Odometry places the robot.
    side.send("tf_static", ("odom", "base", 0, 10))
    wait_until("the odometry", lambda: move() and at(ros.named_frames()[-1][2].get("tool", [0] * 12), 10, 1, 0.5))
    # A robot_state_publisher comes.
    for i in range(3):
        side.send("tf", ("base", "upper", 300 + i, 0, 0, 7), ("upper", "tool", 300 + i, 2), ("tool", "finger", 300 + i, 3))
        time.sleep(0.2)
    adapter.wait_err("joint states are not used")

    def publish():
        nonlocal stamp
        stamp += 1
        side.send("tf", ("base", "upper", 300 + stamp, 0, 0, 7), ("upper", "tool", 300 + stamp, 2), ("tool", "finger", 300 + stamp, 3))
        time.sleep(0.05)
        return at(ros.named_frames()[-1][2].get("finger", [0] * 12), 15, 0, 7)
    wait_until("poses from /tf", publish)
    check(not adapter.find_err("two publishers"), adapter.stderr_text())
    end(adapter)


def robot_links(test):
    """Only links are nodes; another description replaces the first; one that cannot be read is said."""
    ros = Ros(test)
    scene = test.path("robot.glb")
    adapter = ros.adapter("--write-scene", scene)
    side = ros.side(opens=["robot_description", "tf", "tf_static"])
    side.do("text " + write(test, "arm.urdf", URDF))
    adapter.wait_err("the robot has 4 links")
    side.send("tf", ("map", "base", 1, 1), ("base", "camera_optical_frame", 1, 1), ("base", "upper", 1, 0, 0, 2))
    frame = ros.wait_frame("two links", lambda f: len(f[2]) == 2)
    check(set(frame[2]) == {"base", "upper"} and at(frame[2]["upper"], 1, 0, 2), str(frame))
    adapter.wait_err('2 of 4 links of the robot, such as "tool", have no transform')
    for name, text in (("empty.urdf", ""), ("broken.urdf", "<robot name='x'><link name='a'>"), ("binary.urdf", "\x01\x02"),
                       ("missing.urdf", "<robot name='m'><link name='base'><visual><geometry><mesh filename='package://no/x.stl'/>"
                        "</geometry></visual></link></robot>")):
        side.do("text " + write(test, name, text))
        time.sleep(0.3)
    adapter.wait_err("error: .*(/robot_description|not)")
    adapter.wait_err('warning: /robot_description: link "base": the package "no" is not found')
    adapter.wait_err("the robot has no joints")
    check(adapter.alive(), adapter.stderr_text())
    end(adapter)
    check(not [name for name in os.listdir(os.environ.get("XDG_RUNTIME_DIR") or os.environ.get("TMPDIR") or "/tmp")
               if name.startswith("fire3dv-ros2-")], "a folder of a conversion was left behind")


def robot_unwritten(test):
    """A scene file that cannot be written is said; poses go on, and the next description is tried again."""
    ros = Ros(test)
    scene = test.path("later/robot.glb")
    adapter = ros.adapter("--write-scene", scene)
    side = ros.side(opens=["robot_description", "tf", "tf_static"])
    side.do("text " + write(test, "arm.urdf", URDF))
    adapter.wait_err(r"warning: cannot write \S*later/robot.glb.*; poses go on")
    side.send("tf", ("map", "base", 1, 1), ("base", "upper", 1, 0, 0, 2))
    ros.wait_frame("two links", lambda f: set(f[2]) == {"base", "upper"})
    os.mkdir(test.path("later"))
    side.do("text " + write(test, "arm.urdf", URDF + "<!-- again -->"))
    adapter.wait_err("wrote ")
    check("upper" in read_node_names(scene), str(read_node_names(scene)))
    end(adapter)


def robot_meshes(test):
    """Meshes of packages: by ROS's own variable, by --package-path, and a package that is missing."""
    folder = test.path("ament/share/tri/meshes")
    os.makedirs(folder)
    with open(os.path.join(folder, "tri.stl"), "w", encoding="ascii") as file:
        file.write("solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n")
    with open(test.path("ament/share/tri/package.xml"), "w", encoding="ascii") as file:
        file.write("<package><name>tri</name></package>\n")
    urdf = write(test, "tri.urdf", URDF.replace('<link name="tool"/>', '<link name="tool"><visual><geometry><mesh '
                                                'filename="package://tri/meshes/tri.stl"/></geometry></visual></link>'))
    for number, (arguments, env, is_found) in enumerate((
            ([], {"AMENT_PREFIX_PATH": test.path("ament")}, True), (["--package-path", test.path("ament/share")], {}, True), ([], {}, False))):
        ros = Ros(test)
        scene = test.path(f"robot{number}.glb")
        adapter = ros.adapter("--write-scene", scene, *arguments, env=env)
        side = ros.side(opens=["robot_description"])
        side.do("text " + urdf)
        adapter.wait_err("wrote ")
        check(bool(adapter.find_err('the package "tri" is not found')) != is_found, adapter.stderr_text())
        end(adapter)


def robot_of_a_stranger(test):
    """Meshes by absolute paths are read below folders that the user named, and nowhere else."""
    mesh = test.path("private/tri.stl")
    os.makedirs(os.path.dirname(mesh))
    with open(mesh, "w", encoding="ascii") as file:
        file.write("solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n")
    urdf = write(test, "stranger.urdf", URDF.replace('<link name="tool"/>', '<link name="tool"><visual><geometry><mesh '
                                                     f'filename="file://{mesh}"/></geometry></visual></link>'))
    for number, arguments in enumerate(([], ["--package-path", os.path.dirname(mesh)])):
        ros = Ros(test)
        adapter = ros.adapter("--write-scene", test.path(f"robot{number}.glb"), *arguments)
        ros.side(opens=["robot_description"]).do("text " + urdf)
        adapter.wait_err("wrote ")
        said = adapter.find_err('link "tool": "file://.*private/tri.stl" lies outside the folders .*--package-path')
        check(bool(said) != bool(arguments), adapter.stderr_text())
        end(adapter)


# --- times ---------------------------------------------------------------------------------------------------------------

def times_common(test):
    """A frame that is stamped ahead: all poses of a frame are of one time; a silent one is held."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description")
    side = ros.side()
    for i in range(30):
        side.send("tf", ("map", "odom", 11 + i / 10, 100 + i), ("odom", "base", 10 + i / 10, i / 10))
        time.sleep(0.02)
    ros.wait_frame("the end", lambda f: f[1] == 12.9 * SECOND)
    for _, time_ns, poses in ros.named_frames():
        seconds = time_ns / SECOND
        if seconds < 11.05:
            continue
        odom = 100 + (seconds - 11) * 10
        check(at(poses["odom"], odom) and at(poses["base"], odom + seconds - 10), f"{seconds} {poses}")
    time.sleep(1.1)
    side.send("tf", ("map", "odom", 20, 500))
    ros.wait_frame("the other frame alone", lambda f: f[1] == 20 * SECOND and at(f[2]["base"], 502.9))
    adapter.wait_err("no transform for 3 s: the last poses stay")
    end(adapter)


def times_back(test):
    """A recording that loops, and /clock that goes back: a new description, a discontinuity."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description")
    side = ros.side(opens=["tf", "tf_static", "clock"])
    side.send("tf_static", ("base", "laser", 0, 1))
    for i in range(40):
        side.send("tf", ("map", "base", 100 + i / 20, i))
        time.sleep(0.01)
    ros.wait_frame("the first round", lambda f: f[1] >= 101 * SECOND)
    for i in range(40):
        side.send("tf", ("map", "base", 50 + i / 20, 1000 + i))
        time.sleep(0.01)
    adapter.wait_err("went back in time: poses start again")
    frame = ros.wait_frame("the second round", lambda f: f[1] <= 52 * SECOND)
    check(frame[0] == 1 and frame[2]["base"][3] >= 1000 and at(frame[2]["laser"], frame[2]["base"][3] + 1), str(frame))
    side.do(f"clock {60 * SECOND}")
    side.send("tf", ("map", "base", 60, 1))
    ros.wait_frame("time 60", lambda f: f[1] == 60 * SECOND)
    time.sleep(1.1)
    side.do(f"clock {1 * SECOND}")
    adapter.wait_err("/clock went back in time")
    side.send("tf", ("map", "base", 1, 5))
    frame = ros.wait_frame("time 1", lambda f: f[1] == 1 * SECOND)
    check(frame[0] == 1 and at(frame[2]["base"], 5) and at(frame[2]["laser"], 6), str(frame))
    end(adapter)


def times_two_publishers(test):
    """Two publishers of one frame, and of /clock, are named."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description")
    opens = ["tf", "clock"]
    first, second = ros.side("first", opens=opens), ros.side("second", opens=opens)

    def both():
        both.t += 0.1
        for side, x in ((first, 0), (second, 5)):
            side.send("tf", ("map", "base", both.t + x / 100, x))
            side.do(f"clock {round((both.t + 1000 * x) * SECOND)}")
        time.sleep(0.01)
        return adapter.find_err('frame "base" has two publishers, .*, and .*|frame "base" has two publishers') and \
            adapter.find_err("/clock has two publishers")
    both.t = 10
    wait_until("both warnings", both)
    check(not adapter.find_err("went back"), adapter.stderr_text())
    end(adapter)


# --- hostile messages ------------------------------------------------------------------------------------------------------

def wait_marker(ros, name, wanted):
    """Returns the first edit of this marker that is wanted."""
    def edits():
        return [m for m in list(ros.lines.messages) if m["type"] == "SceneEdit" and m["node"] == name]
    return wait_until(lambda: f"{name}; {edits()[-2:]} {ros.current.stderr_text()}", lambda: next(filter(wanted, edits()), None))


def markers_shown(test):
    """Markers are placed where their frame is, replaced by name, and cleared; unknown frames are named."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description", "--markers", "/markers")
    side = ros.side(opens=("tf", "tf_static"))
    side.do("open markers")
    wait_until("a reader of markers", lambda: side.do("readers markers") != "ok 0")
    side.send("tf_static", ("map", "base", 0, 5, 0, 0))
    ros.wait_frame("base", lambda f: set(f[2]) == {"base"})

    side.do("marker forces 3 0 base 1 2 3")
    shown = wait_marker(ros, "markers/forces/3", lambda m: m["value"]["type"] == "Marker")
    value = shown["value"]
    check(value["kind"] == 5 and value["sizes"] == [[1, 2, 3]] and value["colors"] == [0xff0000ff], str(value))
    check([value["parent_from_marker"][i] for i in (3, 7, 11)] == [6, 2, 3], f"map is 5 m from base: {value}")
    side.do("marker forces 4 0 nowhere 1 2 3")
    adapter.wait_err('frame "nowhere" is not connected to the fixed frame')
    side.do("marker forces 3 2 base 0 0 0")
    wait_marker(ros, "markers/forces/3", lambda m: m["version"] > shown["version"] and m["value"]["type"] == "Cleared")
    end(adapter)


def markers_kept(test):
    """Markers end with their lifetime, wait for their frame, and stay where they are when the fixed frame changes."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description", "--markers", "/markers")
    side = ros.side(opens=("tf", "tf_static"))
    side.do("open markers")
    wait_until("a reader of markers", lambda: side.do("readers markers") != "ok 0")
    side.send("tf", ("odom", "base", 10, 5))
    ros.wait_frame("base", lambda f: f[1] == 10 * SECOND and set(f[2]) == {"base"})
    side.do("marker a 1 0 base 1 2 3", f"marker a 2 0 odom 1 0 0 {2 * SECOND}", f"marker a 3 0 odom 2 0 0 {60 * SECOND}", "marker a 4 0 map 3 0 0")
    short = wait_marker(ros, "markers/a/2", lambda m: m["value"]["type"] == "Marker")
    check(short["value"]["lifetime_ns"] == 2 * SECOND, str(short))
    adapter.wait_err('frame "map" is not connected to the fixed frame "odom"')
    side.send("tf", ("odom", "base", 20, 9))
    wait_marker(ros, "markers/a/2", lambda m: m["version"] > short["version"] and m["value"]["type"] == "Cleared")
    side.send("tf_static", ("map", "odom", 0, 100))

    def placed(x, y, z):
        return lambda m: m["value"]["type"] == "Marker" and [m["value"]["parent_from_marker"][i] for i in (3, 7, 11)] == [x, y, z]
    wait_marker(ros, "markers/a/1", placed(106, 2, 3))  # where base was
    moved = wait_marker(ros, "markers/a/3", placed(102, 0, 0))
    check(moved["value"]["lifetime_ns"] == 50 * SECOND, f"what is left of 60 s: {moved}")
    wait_marker(ros, "markers/a/4", placed(3, 0, 0))
    end(adapter)


def memory_mib(program):
    with open(f"/proc/{program.process.pid}/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS")) / 1024


def hostile_values(test):
    """Bad numbers, names, loops and stamps are refused by name; the good frame goes on."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description")
    side = ros.side(opens=["tf", "tf_static", "clock", "joint_states", "robot_description"])
    bad = [("map", "nan_rotation", 1, 0, 0, 0, "nan", 0, 0, 1), ("map", "inf", 1, "inf"), ("map", "long_rotation", 1, 0, 0, 0, 0, 0, 0, 2),
           ("map", "zero_rotation", 1, 0, 0, 0, 0, 0, 0, 0), ("self", "self", 1, 0), ('""', "orphan", 1, 0), ("map", '""', 1, 0),
           ("map", "huge", 1, 1e300), ("map", "@10000000", 1, 0), ("@10000000", "child_of_long", 1, 0),
           ("b", "a", 1, 0), ("a", "b", 1, 0), ("b", "below_loop", 1, 0), ("map", "unstamped", 0, 9),
           ("map", "past", -2147483648, 1), ("map", "future", 2147483647, 1)]
    for transform in bad:
        side.send("tf", transform)
        side.send("tf_static", transform)
    side.do("clock -5")
    side.do("joints 0 a nan")
    side.do("send tf")  # empty
    for i in range(40):
        side.send("tf", ("map", "good", 10 + i / 20, i))
        time.sleep(0.02)
    ros.wait_frame("the good frame", lambda f: at(f[2].get("good", [0] * 12), 39))
    for pattern in ('frame "nan_rotation" from .* is refused: a number is NaN', "refused: its quaternion has not length 1",
                    'frame "b?a?" .*loop of parents|loop of parents'):
        adapter.wait_err(pattern)
    names = ros.descriptions()[-1]
    check(not {"nan_rotation", "inf", "self", "a", "b", "below_loop", "orphan", "huge"} & set(names), str(names))
    check(max(map(len, names)) < 256 and len(adapter.err) < 60, f"{len(adapter.err)} lines")
    end(adapter)


def hostile_sizes(test):
    """10 MB strings again and again: memory stays bounded, nothing is left open."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description")
    side = ros.side()
    for i in range(3):
        side.send("tf", ("map", "@10000000", 1 + i, 0))
    side.send("tf", ("map", "good", 1, 1))
    ros.wait_frame("the good frame", lambda f: "good" in f[2])
    before, files = memory_mib(adapter), len(os.listdir(f"/proc/{adapter.process.pid}/fd"))
    for i in range(30):
        side.send("tf", ("map", "@10000000", 10 + i, 0))
        side.send("tf", ("map", "good", 10 + i, i))
    ros.wait_frame("the end", lambda f: at(f[2]["good"], 29))
    after = memory_mib(adapter)
    check(after < before + 150, f"memory grew from {before:.0f} to {after:.0f} MiB")
    check(len(os.listdir(f"/proc/{adapter.process.pid}/fd")) <= files + 2, "descriptors leak")
    end(adapter)


def hostile_bytes(test):
    """Damaged encodings of each message (Fast DDS only): nothing crashes, and good messages go on."""
    ros = Ros(test)
    adapter = ros.adapter("--write-scene", test.path("robot.glb"))
    kinds = ["tf", "tf_static", "clock", "joint_states", "robot_description"]
    side = ros.side(opens=kinds)
    side.do("text " + write(test, "arm.urdf", URDF))
    adapter.wait_err("the robot has 4 links")
    side.send("tf", ("map", "base", 100, 1))
    side.send("tf_static", ("base", "upper", 0, 1))
    side.do(f"clock {100 * SECOND}")
    side.do(f"joints {100 * SECOND} shoulder 1 grip 2")
    for seed in range(20):
        for kind in kinds[:4]:
            if "unsupported" in side.do(f"damaged {kind} 100 {seed}"):
                return end(adapter)
        side.do(f"damaged robot_description 1 {seed}")

    def good():
        good.seconds += 1
        side.send("tf", ("map", "base", good.seconds, 7))
        time.sleep(0.05)
        check(adapter.alive(), adapter.stderr_text())
        return any(at(f[2].get("base", [0] * 12), 7) for f in ros.named_frames()[-3:])
    good.seconds = 2_000_000_000
    wait_until("a good frame", good)
    end(adapter)


def hostile_types(test):
    """Another type under a known name is said."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description", "--markers", "/arrows", "--points", "/cloud", "--path", "/plan", "--map", "/map")
    side = ros.side(opens=[], wait=False)
    for topic, kind in (("/tf", "tf2_msgs/msg/TFMessage"), ("/arrows", "visualization_msgs/msg/MarkerArray"),
                        ("/cloud", "sensor_msgs/msg/PointCloud2"), ("/plan", "nav_msgs/msg/Path"),
                        ("/map", "nav_msgs/msg/OccupancyGrid")):
        side.do(f"open_wrong {topic}")
        adapter.wait_err(rf"{topic} has the type std_msgs/msg/String at .*, not {kind}: nothing is received from there")
    good = ros.side("good")
    good.send("tf", ("map", "base", 1, 1))
    ros.wait_frame("the good frame", lambda f: "base" in f[2])
    end(adapter)


# --- many frames -----------------------------------------------------------------------------------------------------------

def large_chain(test):
    """2,000 frames, each the parent of the next."""
    ros = Ros(test)
    adapter = ros.adapter("--no-description")
    side = ros.side()

    def publish():
        publish.t += 1
        side.do(f"chain 2000 {publish.t * SECOND} 0.5", "send tf")
        time.sleep(0.05)
        return any(len(f[2]) == 2000 for f in ros.named_frames()[-1:])
    publish.t = 1
    wait_until("2,000 frames", publish)
    check(at(ros.named_frames()[-1][2]["f2000"], 1000), "the end of the chain")
    end(adapter)


def cpu_seconds(program):
    with open(f"/proc/{program.process.pid}/stat", encoding="ascii") as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def large_rate(test):
    """500 frames a thousand times a second, in one message or in ten. Prints a table; the counts are checked."""
    print("| frames | messages a round | rounds sent | frames published | one core |")
    print("|---|---|---|---|---|")
    for per_message in (500, 50):
        ros = Ros(test)
        adapter = ros.adapter("--no-description")
        side = ros.side()
        wait_until("the first frames", lambda s=side, r=ros: s.do("load 500 100 0.5 500") and r.named_frames())
        time.sleep(0.5)
        used, begun, seen = cpu_seconds(adapter), time.monotonic(), len(ros.named_frames())
        side.do("load 500 1000 5 " + str(per_message))
        wall = time.monotonic() - begun
        last = (1 + 5) * SECOND
        ros.wait_frame("the last round", lambda f, t=last: f[1] == t)
        used = cpu_seconds(adapter) - used
        for _, time_ns, poses in ros.named_frames()[seen:]:
            check(len({round(p[7]) for p in poses.values()}) == 1, f"the frame of {time_ns} ns mixes rounds")
        end(adapter)
        published = int(adapter.find_err(r": (\d+) frames published").group(1))
        print(f"| 500 | {500 // per_message} | 5000 in {wall:.1f} s | {published} | {100 * used / wall:.0f} % |", flush=True)
        ros.lines.end()


CASES = {case.__name__: case for case in (
    frames_late_adapter, frames_late_publisher, frames_grow, frames_names, frames_ranges, robot_joints, robot_links, robot_unwritten,
    robot_meshes,
    robot_of_a_stranger,
    times_common, times_back, markers_shown, markers_kept, times_two_publishers, hostile_values, hostile_sizes, hostile_bytes, hostile_types, large_chain, large_rate)}

if __name__ == "__main__":
    reason = why_not()
    if reason:
        print(f"skipped: {reason}")
        sys.exit(SKIPPED)
    main(CASES, ["fire3dv-ros2", "stream_dump", "publisher"])
