"""Test of the Python module: frames and edits arrive, and errors raise with the library's message.

python_module_test.py STREAM_DUMP shm|tcp
"""
import array
import json
import math
import os
import subprocess
import sys

import fire3dv

HANG_LIMIT_S = 120


def expect_error(code, text, call):
    try:
        call()
    except fire3dv.Error as error:
        assert error.code == code, (error.code, error)
        assert text in str(error), error
        return
    raise AssertionError(f"nothing was raised, expected: {text}")


def pose(x):
    return [1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0]


listen = f"shm://test-python-{os.getpid()}" if sys.argv[2] == "shm" else "tcp://127.0.0.1:0"
dump = subprocess.Popen([sys.argv[1], listen, str(HANG_LIMIT_S)], stdout=subprocess.PIPE, text=True)
uri = dump.stdout.readline().strip()
with fire3dv.Stream(uri, adapter_name="python", scene_budget_bytes=200_000) as stream:
    expect_error(fire3dv.ERROR_STATE, "call describe()", lambda: stream.publish(0, [pose(0)]))
    stream.describe(["a", "b"], world_from_stream=[1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7], nominal_rate_hz=100)
    while not stream.poll().renderers:  # the frames below need a receiver
        pass
    stream.set_visible("door", False)
    stream.set_base_color("door", [0.25, 0.5, 1, 1])
    stream.set_light("lamp", fire3dv.SPOT, intensity=800, inner_cone_rad=0.25, outer_cone_rad=0.5, casts_shadow=False)
    stream.set_camera("eye", math.pi / 3, near_m=0.5)
    stream.add_node("part", parent="door", parent_from_node=pose(3), asset_glb=b"glTF\0\2")
    stream.remove_node("wall")
    stream.set_vertices("cloth", [[0, 0, 0], [1, 2, 3]], normals=array.array("f", [0, 0, 1, 0, 1, 0]))
    stream.clear("door", fire3dv.LIGHT)
    expect_error(fire3dv.ERROR_ARGUMENT, "rgba[1]", lambda: stream.set_base_color("door", [0, 2, 0, 1]))
    expect_error(fire3dv.ERROR_ARGUMENT, "NUL", lambda: stream.remove_node("a\0b"))
    expect_error(fire3dv.ERROR_BUDGET, "budget is 200000", lambda: stream.add_node("big", asset_glb=bytes(300_000)))
    expect_error(fire3dv.ERROR_ARGUMENT, "11 numbers", lambda: stream.publish(0, [pose(0), pose(0)[1:]][1:]))
    expect_error(fire3dv.ERROR_ARGUMENT, "stream_from_body has 1 poses; describe() named 2", lambda: stream.publish(0, [pose(0)]))
    stream.publish(1000, array.array("f", pose(1) + pose(2)))
    stream.publish_some(2000, [0, 1], [pose(3), pose(4)])
    stream.publish_some(3000, [1], [pose(5)])
    assert stream.poll().sequence == 3
    assert stream.wait_ack(1, 0) is False
expect_error(fire3dv.ERROR_ARGUMENT, "nonsense", lambda: fire3dv.Stream("nonsense"))

messages = [json.loads(line) for line in dump.stdout]
assert dump.wait() == 0
description = next(m for m in messages if m["type"] == "StreamDescription")
assert description["node_names"] == ["a", "b"] and description["adapter_name"] == "python"
assert description["world_from_stream"][3] == 5
edits = {(m["node"], m["property"]): m["value"] for m in messages if m["type"] == "SceneEdit"}
assert edits[("door", "visible")] == {"type": "Visible", "visible": False}
assert edits[("door", "base_color")]["rgba"] == [0.25, 0.5, 1, 1]
assert edits[("lamp", "light")]["kind"] == 2 and edits[("lamp", "light")]["casts_shadow"] is False
assert abs(edits[("eye", "camera")]["vertical_fov_rad"] - math.pi / 3) < 1e-6
assert edits[("part", "node")]["asset_glb"] == list(b"glTF\0\2")
assert edits[("part", "node")]["parent_from_node"] == pose(3) and edits[("part", "node")]["parent"] == "door"
assert edits[("wall", "node")] == {"type": "NodeRemoved"}
assert edits[("cloth", "vertices")] == {"type": "Vertices", "positions": [[0, 0, 0], [1, 2, 3]],
                                        "normals": [[0, 0, 1], [0, 1, 0]]}
assert edits[("door", "light")] == {"type": "Cleared"}
assert len(edits) == 8
frames = [m for m in messages if m["type"] == "PoseFrame"]
assert frames, "no frame came"
assert frames[-1]["sequence"] == 3 and frames[-1]["scene_version"] == 8
assert [row[3] for row in frames[-1]["poses"]][-1] == 5
print("ok")
