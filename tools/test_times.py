#!/usr/bin/env python3
"""Processor time of CI's parts against their budget, and targets of tests.

  test_times.py --budget TIMES   prints the table of a file with lines NAME CPU_SECONDS WALL_SECONDS
  test_times.py --targets-of LABEL [--without REGEX] BUILD_DIR  prints what to build to run the tests of a label, without
                                 those that have a label of the regular expression
  test_times.py --targets-matching REGEX BUILD_DIR  the same for tests by name
"""
import argparse
import json
import os
import subprocess
import sys

# CPU-seconds on two cores, from nothing; a part that exceeds its budget is named in the last lines.
BUDGET = {"set-up": 100, "build": 1300, "sanitizer-build": 1200, "e2e": 1100, "render": 550, "unit": 60, "sanitizers": 520}


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


def print_budget(path):
    with open(path, encoding="utf-8") as file:
        parts = [(name, float(cpu), float(wall)) for name, cpu, wall in (line.split() for line in file)]
    print("\nTime of CI's parts (a part beside another one, such as the sanitizer build, takes longer by the clock)")
    print(f"  {'part':<16}{'CPU s':>8}{'budget':>8}{'wall s':>8}")
    for name, cpu, wall in parts:
        print(f"  {name:<16}{cpu:>8.0f}{BUDGET.get(name, 0):>8}{wall:>8.0f}")
    print(f"  {'all':<16}{sum(cpu for _, cpu, _ in parts):>8.0f}{sum(BUDGET.values()):>8}")
    for name, cpu, _ in parts:
        if cpu > BUDGET.get(name, 0):
            print(f"over its budget: {name} took {cpu:.0f} CPU-seconds of {BUDGET.get(name, 0)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--budget", metavar="TIMES")
    parser.add_argument("--targets-of", metavar="LABEL")
    parser.add_argument("--without", metavar="REGEX")
    parser.add_argument("--targets-matching", metavar="REGEX")
    parser.add_argument("build_dir", nargs="?")
    arguments = parser.parse_args()
    if arguments.budget:
        print_budget(arguments.budget)
    elif not arguments.build_dir:
        parser.error("one of --budget, --targets-of and --targets-matching is needed, the last two with BUILD_DIR")
    elif arguments.targets_of:
        without = ["-LE", f"^({arguments.without})$"] if arguments.without else []
        print_targets(arguments.build_dir, "-L", f"^{arguments.targets_of}$", *without)
    elif arguments.targets_matching:
        print_targets(arguments.build_dir, "-R", arguments.targets_matching)
    else:
        parser.error("one of --budget, --targets-of and --targets-matching is needed")


if __name__ == "__main__":
    sys.exit(main())
