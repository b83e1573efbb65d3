"""End-to-end test of scalars: the example of docs/scalars.md is inspected, recorded, and replayed with every value.

python_scalars_test.py FIRE3DV_INSPECT FIRE3DV_RECORD FIRE3DV_REPLAY STREAM_DUMP [CASE...]
"""
import json
import math
import os
import subprocess
import sys

import fire3dv
from harness import HANG_S, Program, main, wait_until
from image_reader import check
from readme_commands import code_blocks
from stream_lines import StreamLines

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../.."))
STEPS = 1000


def run(test, name, *arguments):
    done = subprocess.run([test.programs_at[name], *arguments], capture_output=True, text=True, timeout=HANG_S)
    check(done.returncode == 0, f"{name} {arguments} ended with {done.returncode}:\n{done.stderr}")
    return done.stdout


def raised(kind, text, call):
    try:
        call()
    except kind as error:
        check(text in str(error), f"{text!r} is not in: {error}")
        return
    raise AssertionError(f"nothing was raised, expected: {text}")


def example(test):
    """The example of docs/scalars.md, paced: recorded, and replayed with every value; inspected while it waits."""
    with open(os.path.join(ROOT, "docs/scalars.md"), encoding="utf-8") as file:
        snippet = code_blocks(file.read(), "python")[0]
    uri, path = test.fresh_uri("shm"), test.path("scalars.mcap")
    check(snippet.count("shm://demo") == 1 and snippet.count("        stream.publish(") == 1, snippet)
    paced = snippet.replace("shm://demo", uri).replace("        stream.publish(", "        time.sleep(0.001); stream.publish(")
    recorder = Program(test, "recorder", [test.programs_at["record"], "--from", uri, "--out", path, "--until-end"])
    recorder.wait_err("listening on")
    simulator = Program(test, "simulator", [sys.executable, "-W", "error", "-c", "import time\n" + paced])
    def inspected():
        streams = json.loads(run(test, "inspect", uri, "--json", "--seconds", "1"))["streams"]
        return {f"{s['group']}/{s['name']}": s for stream in streams for s in stream["scalars"]}

    last = math.cos(5e-3 * (STEPS - 1))
    listed = wait_until("the last step", lambda: (seen := inspected()) and abs(seen["joints/hinge"]["last"] - last) < 1e-12
                        and seen)
    check(sorted(listed) == ["energy/kinetic", "energy/potential", "joints/hinge"], f"inspect lists {listed}")
    hinge = listed["joints/hinge"]
    check(hinge["unit"] == "rad" and hinge["count"] >= 1 and hinge["min"] <= last <= hinge["max"], f"inspect says {hinge}")
    simulator.process.stdin.write("\n")
    simulator.process.stdin.flush()
    simulator.expect_exit()
    recorder.expect_exit()

    uri = test.fresh_uri("shm")
    lines = StreamLines(test.programs_at["dump"], uri)
    run(test, "replay", path, "--to", uri, "--wait")
    edits = [m for m in lines.end() if m["type"] == "SceneEdit"]
    declared = {m["version"]: m for m in edits if m["property"] == "scalars"}
    energy = [m["value"] for m in edits if m["property"] == "scalar_values" and m["node"] == "energy"]
    check([d["value"]["names"] for d in declared.values() if d["node"] == "energy"] == [["kinetic", "potential"]], declared)
    times = [v["sim_time_ns"] for v in energy]
    # On a busy machine a reader may be overrun, which leaves out values but never changes their order.
    check(times == sorted(set(times)) and times[-1] == (STEPS - 1) * 1_000_000, f"times: {times}")
    check(len(times) > 0.8 * STEPS, f"{len(times)} of {STEPS} samples were recorded and replayed")
    for value in energy:
        kinetic = math.sin(5e-9 * value["sim_time_ns"])**2
        check(declared[value["declaration"]]["node"] == "energy", value)
        check(abs(value["values"][0] - kinetic) < 1e-12 and abs(sum(value["values"]) - 1) < 1e-12, value)


def arguments(test):
    """Values in their forms; names that appear later; errors that name the argument."""
    uri = test.fresh_uri("shm")
    lines = StreamLines(test.programs_at["dump"], uri)
    with fire3dv.Stream(uri) as stream:
        stream.describe([])
        stream.scalars("arm", 1, {"b": 1, "a": 2.5}, units={"a": "N m", "other": "s"})
        stream.scalars("arm", 2, {"a": 3})
        stream.scalars("arm", 3, {"c": math.inf}, units={"c": "J"})
        stream.declare_scalars("leg", ("x", "y"))
        stream.set_scalars("leg", -1, [1, 2])
        stream.set_scalars("leg", 0, (math.nan, 2))
        raised(fire3dv.StateError, "not declared", lambda: stream.set_scalars("never", 0, [1]))
        raised(fire3dv.ArgumentError, "count is 3", lambda: stream.set_scalars("leg", 0, [1, 2, 3]))
        raised(fire3dv.ArgumentError, "values['a'] is 'x'", lambda: stream.scalars("arm", 4, {"a": "x"}))
        raised(fire3dv.ArgumentError, "lists of texts", lambda: stream.declare_scalars("leg", "xy"))
        raised(fire3dv.ArgumentError, "sim_time_ns is 0.5", lambda: stream.scalars("arm", 0.5, {"a": 1}))
        raised(fire3dv.BudgetError, "at most 4096", lambda: stream.declare_scalars("many", map(str, range(4097))))
        stream.clear_scalars("leg")
        stream.clear_scalars("never")
        raised(fire3dv.StateError, "not declared", lambda: stream.set_scalars("leg", 0, [1, 2]))
        stream.publish(5, [])
        lines.wait_for("the end", lambda m: m["type"] == "PoseFrame")
    values = [m["value"] for m in lines.end() if m["type"] == "SceneEdit"]
    check([(v["names"], v["units"]) for v in values if v["type"] == "Scalars"] ==
          [(["b", "a"], ["", "N m"]), (["b", "a", "c"], ["", "N m", "J"]), (["x", "y"], ["", ""])], values)
    check([v["values"] for v in values if v["type"] == "ScalarValues"] ==
          [[1, 2.5], [None, 3], [None, None, None], [1, 2], [None, 2]], values)


if __name__ == "__main__":
    main({"example": example, "arguments": arguments}, ["inspect", "record", "replay", "dump"])
