#!/usr/bin/env python3
"""Version of the project: stated by project(fire3dv VERSION ...) in CMakeLists.txt, repeated where no build step can put it.

    version.py             prints it
    version.py --check     fails where another file states another one
    version.py --set X.Y.Z writes it everywhere; CHANGELOG.md gets a section, docs/upgrading.md is yours to write
    version.py --notes     prints its section of CHANGELOG.md, without the heading
"""
import argparse
import glob
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
NUMBER = r"(\d+\.\d+\.\d+)"
SOURCE = ("CMakeLists.txt", rf"(?m)^project\(fire3dv VERSION {NUMBER} ")
# Files, by pattern, and the text around the version; each file must have it.
REPEATED = [
    ("docs/man/*.1.md", rf'(?m)^% ".*" "FIRE-3DV {NUMBER}" '),
    ("adapters/generic/python*/fire3dv*/__init__.py", rf'(?m)^__version__ = "{NUMBER}"$'),
]
HEADING = rf"(?m)^## {NUMBER}, (.+)$"  # the newest version comes first


def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def write(path, text):
    with open(os.path.join(ROOT, path), "w", encoding="utf-8") as file:
        file.write(text)


def stated(path, pattern):
    found = re.search(pattern, read(path))
    return found.group(1) if found else None


def repeated():
    for pattern, text in REPEATED:
        paths = sorted(glob.glob(pattern, root_dir=ROOT))
        if not paths:
            sys.exit(f"version.py: no file matches {pattern}")
        yield from ((path, text) for path in paths)


def differences(version):
    for path, pattern in [*repeated(), ("CHANGELOG.md", HEADING)]:
        found = stated(path, pattern)
        if found != version:
            yield f"{path}: {found or 'no version'} instead of {version}, of CMakeLists.txt (tools/version.py --set {version})"
    series = ".".join(version.split(".")[:2])
    if not re.search(rf"(?m)^## From \S+ to {re.escape(series)}$", read("docs/upgrading.md")):
        yield f'docs/upgrading.md: no section "From ... to {series}"'


def notes(version):
    section = re.search(rf"(?ms)^## {re.escape(version)}, [^\n]+\n+(.*?)(?=^## |\Z)", read("CHANGELOG.md"))
    if not section:
        sys.exit(f"version.py: CHANGELOG.md has no section of {version}")
    return section.group(1).strip() + "\n"


def set_version(version):
    for path, pattern in [SOURCE, *repeated()]:
        text = read(path)
        found = re.search(pattern, text)
        if not found:
            sys.exit(f"version.py: {path} states no version")
        write(path, text[:found.start(1)] + version + text[found.end(1):])
    text = read("CHANGELOG.md")
    if stated("CHANGELOG.md", HEADING) != version:
        write("CHANGELOG.md", re.sub(r"(?m)^## ", f"## {version}, not yet released\n\n## ", text, count=1))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    action = parser.add_mutually_exclusive_group()
    action.add_argument("--check", action="store_true")
    action.add_argument("--set", metavar="X.Y.Z")
    action.add_argument("--notes", action="store_true")
    arguments = parser.parse_args()
    if arguments.set:
        if not re.fullmatch(NUMBER, arguments.set):
            parser.error("--set needs three numbers, such as 1.2.3")
        set_version(arguments.set)
    version = stated(*SOURCE)
    if arguments.check:
        wrong = list(differences(version))
        print("\n".join(wrong), end="\n" if wrong else "")
        return 1 if wrong else 0
    print(notes(version) if arguments.notes else version, end="" if arguments.notes else "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
