#!/usr/bin/env python3
"""Interoperability test with the official packages of MCAP and Foxglove: they read our recordings, and we read theirs."""
import json
import os
import shutil
import subprocess
import sys

from harness import HANG_S, main
from mcap_file import McapFile
from image_reader import check

HERE = os.path.dirname(os.path.abspath(__file__))


def run(*command, code=0):
    done = subprocess.run(command, capture_output=True, text=True, timeout=HANG_S, check=False)
    check(done.returncode == code, f"{command} ended with {done.returncode}, not {code}:\n{done.stderr}")
    return done.stdout


def oracle(*arguments, code=0):
    return run(NODE, os.path.join(HERE, "mcap_oracle.mjs"), MODULES, *arguments, code=code)


def reads_ours(test):
    for compression in ("zstd", "lz4", "none"):
        path, expected = test.path(f"{compression}.mcap"), test.path(f"{compression}.jsonl")
        with open(expected, "w", encoding="utf-8") as lines:
            lines.write(run(test.programs_at["sample"], path, compression))
        print(f"{compression}: {oracle('check', path, expected).strip()}")


def notices_damage(test):
    """Negative control: a pose with a wrong last bit and a damaged chunk are detected."""
    path, expected = test.path("file.mcap"), test.path("expected.jsonl")
    lines = run(test.programs_at["sample"], path, "none").splitlines()
    frame = json.loads(lines[100])
    frame["poses"]["link_1"][3] *= 1 + 1e-6
    lines[100] = json.dumps(frame)
    with open(expected, "w", encoding="utf-8") as file:
        file.write("\n".join(lines))
    oracle("check", path, expected, code=1)
    with open(path, "r+b") as file:
        file.seek(os.path.getsize(path) // 2)
        byte = file.read(1)
        file.seek(-1, os.SEEK_CUR)
        file.write(bytes([byte[0] ^ 1]))
    done = subprocess.run([NODE, os.path.join(HERE, "mcap_oracle.mjs"), MODULES, "check", path, expected],
                          capture_output=True, text=True, timeout=HANG_S, check=False)
    check("CRC" in done.stderr or "crc" in done.stderr, f"a flipped bit gave: {done.stderr}")


def writes_for_us(test):
    ours, theirs = test.path("ours.mcap"), test.path("theirs.mcap")
    run(test.programs_at["sample"], ours, "zstd")
    oracle("write", ours, theirs)
    said = [json.loads(run(test.programs_at["inspect"], "--json", path)) for path in (ours, theirs)]
    check(all(each["sound"] and each["has_summary"] for each in said), f"inspect says {said[1]}")
    for key in ("messages", "streams", "attachments", "start_ns", "end_ns"):
        check(said[0][key] == said[1][key], f"{key}: {said[0][key]} of ours, {said[1][key]} of theirs")
    topics = [{t["topic"]: t for t in each["topics"]} for each in said]
    check(topics[0] == topics[1], f"topics: {topics}")
    again = test.path("again.mcap")
    run(test.programs_at["record"], "recover", theirs, "-o", again)
    check([m[1:] for m in McapFile(again).messages] == [m[1:] for m in McapFile(ours).messages], "messages are others")


if __name__ == "__main__":
    MODULES = sys.argv.pop(1)
    NODE = shutil.which("node")
    if not NODE or not os.path.isdir(os.path.join(MODULES, "@mcap")):
        print("needs node, and npm's @mcap/core @mcap/support @mcap/nodejs flatbuffers flatbuffers_reflection; "
              "FIRE3DV_MCAP_NODE_MODULES names their folder")
        sys.exit(1)
    main({f.__name__: f for f in (reads_ours, notices_damage, writes_for_us)}, ["sample", "inspect", "record"])
