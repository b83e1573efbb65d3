#!/usr/bin/env python3
"""Test durations against CI's time budget.

  test_times.py --setup S --builds S --sanitizers S --log CTEST_OUTPUT BUILD_DIR   prints the table
  test_times.py --targets-of LABEL [--without REGEX] BUILD_DIR  prints what to build to run the tests of a label
  test_times.py --targets-matching REGEX BUILD_DIR  the same for tests by name
"""
import argparse
import json
import os
import re
import subprocess
import sys

# Minutes. A test counts for the first of these labels that it has.
BUDGET = [("set-up", 5), ("builds", 12), ("render", 10), ("e2e", 6), ("fuzz", 4), ("slack", 3)]
LABELS = ["fuzz", "e2e", "render"]


# Format: "1/3 Test #1: test_png ......   Passed    0.03 sec"; failed tests have ***Failed before the time.
TEST_LINE = re.compile(r"^ *\d+/\d+ +Test +#\d+: +(\S+) .*?([0-9.]+) sec *$")


def listed_tests(build_dir, *selection):
    listing = subprocess.run(["ctest", "--test-dir", build_dir, "--show-only=json-v1", *selection],
                             check=True, capture_output=True, text=True).stdout
    return json.loads(listing)["tests"]


def print_targets(build_dir, *selection):
    build_dir = os.path.abspath(build_dir)
    known = subprocess.run(["ninja", "-C", build_dir, "-t", "targets", "all"],
                           check=True, capture_output=True, text=True).stdout
    outputs = {line.rsplit(":", 1)[0] for line in known.splitlines()}
    found = set()
    for test in listed_tests(build_dir, *selection):
        # Programs that are not built yet have no command in the listing.
        for word in test.get("command", [os.path.join(build_dir, "tests", test["name"])]):
            path = os.path.relpath(word, build_dir) if word.startswith(build_dir + "/") else None
            if path in outputs:
                found.add(path)
    for path in sorted(found):
        print(path)


def test_seconds(build_dir, log_path):
    labels_of = {test["name"]: next((p["value"] for p in test.get("properties", []) if p["name"] == "LABELS"), [])
                 for test in listed_tests(build_dir)}
    seconds = dict.fromkeys(LABELS + ["slack"], 0.0)
    with open(log_path, encoding="utf-8", errors="replace") as log:
        for match in filter(None, map(TEST_LINE.match, log)):
            labels = labels_of.get(match.group(1), [])
            seconds[next((label for label in LABELS if label in labels), "slack")] += float(match.group(2))
    return seconds


def print_table(arguments):
    seconds = test_seconds(arguments.build_dir, arguments.log)
    seconds["set-up"] = arguments.setup
    seconds["builds"] = arguments.builds
    seconds["slack"] += arguments.sanitizers
    notes = {"builds": "Release, and the CPU-side tests with sanitizers", "render": "label render",
             "e2e": "label e2e", "fuzz": "label fuzz", "slack": "unit and conformance tests, sanitizer runs"}
    print("\nCI's time budget (test times are summed over tests that ran side by side)")
    print(f"  {'part':<8}{'minutes':>9}{'of':>6}")
    for part, minutes in BUDGET:
        used = seconds[part] / 60
        over = "  OVER BUDGET" if used > minutes else ""
        print(f"  {part:<8}{used:>9.1f}{minutes:>6}  {notes.get(part, '')}{over}".rstrip())
    total = sum(seconds.values()) / 60
    print(f"  {'all':<8}{total:>9.1f}{sum(minutes for _, minutes in BUDGET):>6}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--targets-of")
    parser.add_argument("--without", metavar="REGEX")
    parser.add_argument("--targets-matching")
    parser.add_argument("--setup", type=float, default=0)
    parser.add_argument("--builds", type=float, default=0)
    parser.add_argument("--sanitizers", type=float, default=0)
    parser.add_argument("--log")
    parser.add_argument("build_dir")
    arguments = parser.parse_args()
    if arguments.targets_of:
        without = ["-E", arguments.without] if arguments.without else []
        print_targets(arguments.build_dir, "-L", f"^{arguments.targets_of}$", *without)
    elif arguments.targets_matching:
        print_targets(arguments.build_dir, "-R", arguments.targets_matching)
    elif arguments.log is None:
        parser.error("one of --log, --targets-of and --targets-matching is needed")
    else:
        print_table(arguments)


if __name__ == "__main__":
    sys.exit(main())
