#!/usr/bin/env python3
"""Output test of tools/lab/bench/scripts/transport.py --quick: the page has every table and every row. It asserts no time."""
import os
import re
import subprocess
import sys

from harness import HANG_S, main, vulkan_environment
from image_reader import check

LINKS = ("shm://", "tcp://", "udp://")


def tables_of(page):
    """Returns the rows of cells by the heading above them."""
    tables, heading = {}, None
    for line in page.splitlines():
        if line.startswith("## "):
            heading = line[3:]
            tables[heading] = []
        elif line.startswith("|") and not line.startswith("|---"):
            tables[heading].append([cell.strip() for cell in line.strip("|").split("|")])
    return tables


def numbers(cells):
    return [float(re.match(r"-?[\d.]+", cell)[0]) for cell in cells]


def page(test):
    script = os.path.join(os.path.dirname(__file__), "..", "..", "..", "tools", "lab", "bench", "scripts", "transport.py")
    out = test.path("page.md")
    result = subprocess.run([sys.executable, script, "--quick", "--programs", os.path.dirname(test.programs_at["fire3dv-bench"]),
                             "--option=--no-validation", "--out", out], capture_output=True, text=True, timeout=2 * HANG_S,
                            env=vulkan_environment(), check=False)
    check(result.returncode == 0 and result.stderr == "", f"ended with {result.returncode}:\n{result.stdout}{result.stderr}")
    with open(out, encoding="utf-8") as file:
        text = file.read()
    tables = tables_of(text)
    publish = tables["What one publish costs"][1:]
    check([row[0] for row in publish] == ["1"] * 3 + ["100"] * 3 + ["1000"] * 3, f"{publish}")
    check(all(value > 0 for row in publish for value in numbers(row[2:])), f"{publish}")
    one_way = {row[0]: row[1:] for row in tables["One way"][1:]}
    check({"memcpy into a slot", "Asio: TCP socket", "udp:// with a key", *LINKS} <= set(one_way), f"{one_way.keys()}")
    check(one_way["Asio: TCP socket"][2::3] == ["1.00"] * 3, f"a baseline is 1: {one_way}")
    ingest = tables["Ingest"][1:]
    check([(row[0], row[1]) for row in ingest] == [(link, n) for n in ("100", "1000", "10000") for link in LINKS], f"{ingest}")
    check(all(numbers(row[2:3])[0] >= 0 for row in ingest), f"{ingest}")
    trouble = tables["A publisher whose reader is in trouble"][1:]
    may_mount = "A full disk was not tried" not in text
    check([row[0] for row in trouble] == [*LINKS * 3, *["shm://"] * may_mount], f"{trouble}")
    check(not may_mount or trouble[-1][1] == "out of disk", f"{trouble}")
    check(all(value >= 0 for row in trouble for value in numbers(row[2:])), f"{trouble}")
    age = tables["Pose age"][1:]
    check([row[:2] for row in age] == [["shm://", "60"], ["shm://", "1000"]], f"{age}")
    check(all(int(row[2]) > 0 and 90 < sum(numbers(row[5:])) < 110 for row in age), f"{age}")


def publisher(test):
    """fire3dv-bench publish: the fields that scripts read."""
    command = [test.programs_at["fire3dv-bench"], "publish"]
    result = subprocess.run([*command, test.fresh_uri("shm"), "--rate", "2000"], input="\n", capture_output=True, text=True,
                            timeout=HANG_S, check=False)
    check(result.returncode == 0 and result.stdout.startswith('{"calls":'), f"{result}")
    result = subprocess.run([*command, "carrier://pigeon"], input="", capture_output=True, text=True, timeout=HANG_S, check=False)
    check(result.returncode == 1 and "carrier" in result.stderr, f"{result}")


if __name__ == "__main__":
    main({"page": page, "publisher": publisher}, ["fire3dv-bench"])
