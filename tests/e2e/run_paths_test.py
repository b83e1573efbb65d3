#!/usr/bin/env python3
"""Library search paths (DT_RUNPATH, DT_RPATH) of all programs and libraries below a folder.

    run_paths_test.py --readelf READELF [--outside FOLDER ...] FOLDER

Each element must be absolute or begin with $ORIGIN. The dynamic linker takes an empty or a relative element for the current
directory, so that a program loads whatever library somebody has put there. --outside: no element may lie below this folder.
"""
import argparse
import os
import re
import subprocess
import sys

ET_EXEC, ET_DYN = 2, 3


def is_program_or_library(path):
    if os.path.islink(path) or not os.path.isfile(path):
        return False
    with open(path, "rb") as file:
        head = file.read(18)
    return head[:4] == b"\x7fELF" and int.from_bytes(head[16:18], "little" if head[5] == 1 else "big") in (ET_EXEC, ET_DYN)


def binaries_below(folder):
    for root, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if name not in ("CMakeFiles", "_deps")]
        for name in names:
            path = os.path.join(root, name)
            if is_program_or_library(path):
                yield path


def search_paths(readelf, path):
    """Returns (DT_RPATH or DT_RUNPATH, its elements) of a file."""
    output = subprocess.run([readelf, "-dW", path], check=True, capture_output=True, text=True).stdout
    for tag, value in re.findall(r"\((RPATH|RUNPATH)\)[^\[\n]*\[(.*)\]$", output, re.MULTILINE):
        yield f"DT_{tag}", value.split(":")


def fault_of(element, outside):
    if element == "":
        return "has an empty element, which is the current directory"
    if element not in ("$ORIGIN", "${ORIGIN}") and not element.startswith(("/", "$ORIGIN/", "${ORIGIN}/")):
        return f"has the relative element {element}"
    for folder in outside:
        if element == folder or element.startswith(folder + "/"):
            return f"has the element {element}, which lies below {folder}"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--readelf", default="readelf")
    parser.add_argument("--outside", action="append", default=[], metavar="FOLDER")
    parser.add_argument("folder")
    args = parser.parse_args()
    # Self-test of the rule: a check that never fails would pass every build.
    assert fault_of("", []) and fault_of("lib", []) and fault_of("/b/lib", ["/b"]) and not fault_of("/bb/lib", ["/b"])
    assert not fault_of("$ORIGIN/../lib", []) and not fault_of("/usr/lib/x", [])
    faults, binaries, with_path = [], 0, 0
    for path in sorted(binaries_below(args.folder)):
        binaries += 1
        for tag, elements in search_paths(args.readelf, path):
            with_path += 1
            found = sorted({fault for element in elements if (fault := fault_of(element, args.outside))})
            faults += [f"{path}: {tag} [{':'.join(elements)}] {fault}" for fault in found]
    if not binaries:
        faults.append(f"{args.folder} holds no program and no library")
    for fault in faults:
        print(fault, file=sys.stderr)
    print(f"run_paths: {binaries} programs and libraries, {with_path} with a search path, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
