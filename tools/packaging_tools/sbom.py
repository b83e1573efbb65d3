#!/usr/bin/env python3
"""Bill of materials of a build, as SPDX 2.3: what its programs are linked with, what is compiled in, what wheels carry.

    sbom.py --commit HASH --out FILE BUILD [ARTEFACT...]   BUILD: a finished build; artefacts: packages, wheels, archives
    sbom.py --check FILE                                   fails if the structure of a document is wrong

Packages are those of Debian: from the shared libraries of the programs, the headers of their objects (as ninja recorded
them), and the licences in wheels. Licences are those of the copyright files. SOURCE_DATE_EPOCH in the environment is the
date.
"""
import argparse
import glob
import hashlib
import json
import os
import re
import subprocess
import sys
import urllib.parse
import zipfile

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from packaging_tools import debian, spdx
from packaging_tools.elf import resolved
import version

FONT = "fonts-dejavu-core"  # renderer/passes/markers: embedded, without a header
# Source packages that are loaded at run time, where present: renderer/sinks/video/libav.cpp, renderer/dataset/layouts/hdf5_library.cpp
LOADED = {"ffmpeg", "hdf5"}
NOT_IN_RELEASES = re.compile(r"tests/|tools/lab/")
OWN = re.compile(r"libfire3dv-client\.so")


def fail(sentence):
    sys.exit(f"sbom.py: {sentence}")


def programs(build):
    """Programs that are installed, and the client library."""
    with open(os.path.join(version.ROOT, "cmake", "Install.cmake"), encoding="utf-8") as file:
        names = re.search(r"set\(installed_programs ([^)]*)\)", file.read()).group(1).split()
    found = [path for path in (os.path.join(build, "bin", name) for name in names) if os.path.exists(path)]
    libraries = [path for path in glob.glob(os.path.join(build, "lib", "libfire3dv-client.so")) if os.path.exists(path)]
    if not found or not libraries:
        fail(f"{build} holds no programs or no client library: build it first")
    return found + libraries


def header_packages(build):
    """Packages of the headers that objects of a release include."""
    listing = subprocess.run(("ninja", "-C", build, "-t", "deps"), check=True, text=True, capture_output=True).stdout
    paths, is_used = set(), False
    for line in listing.splitlines():
        if line.startswith("    "):
            if is_used:
                paths.add(line.strip())
        elif line:
            is_used = not NOT_IN_RELEASES.match(line)
    return {debian.owner(path) for path in paths if path.startswith("/usr/")} - {""}


def linked_packages(files):
    """Packages of all shared libraries that the files need."""
    names = {}
    for path in files:
        for library, place in resolved(path).items():
            if not OWN.match(library):
                names[place] = library
    owners = {place: debian.owner(place) for place in names}
    for place, name in owners.items():
        if not name:
            fail(f"{place} is from no Debian package: its version and licence are unknown")
    return set(owners.values())


def wheel_packages(path):
    """Packages whose copyright files a wheel carries."""
    with zipfile.ZipFile(path) as wheel:
        return {found.group(1) for found in (re.fullmatch(r"\w+/licences/([^/]+)", name) for name in wheel.namelist()) if found}


class Bill:
    def __init__(self, commit):
        number = version.stated(*version.SOURCE)
        self.document = spdx.Document(f"fire3dv-{number}", f"https://spdx.org/spdxdocs/fire3dv-{number}-{commit}",
                                      int(os.environ.get("SOURCE_DATE_EPOCH", "0")), f"fire3dv-release-{number}")
        self._number = number
        self.root = self.document.package(spdx.identifier("fire3dv"), "fire3dv", number, "Apache-2.0", copyrightText="The FIRE-3DV authors",
                                          comment=f"commit {commit}", supplier="Organization: The FIRE-3DV authors")
        self.document.relate("SPDXRef-DOCUMENT", "DESCRIBES", self.root)

    def debian(self, name):
        each = debian.package(name)
        licence, texts = debian.licences(name)
        purl = f"pkg:deb/debian/{name}@{urllib.parse.quote(each.version)}?arch={each.architecture}"
        return self.document.package(
            spdx.identifier("debian", name), name, each.version, licence, texts, supplier="Organization: Debian",
            sourceInfo=f"source package {each.source}",
            externalRefs=[{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": purl}])

    def add_build(self, build):
        linked = linked_packages(programs(build))
        sources = {debian.package(name).source for name in linked}
        for name in linked:
            self.document.relate(self.root, "DYNAMIC_LINK", self.debian(name))
        for name in header_packages(build) | {FONT}:
            source = debian.package(name).source
            if source in LOADED:
                self.document.relate(self.debian(name), "OPTIONAL_DEPENDENCY_OF", self.root)
            elif source not in sources:  # no shared library of it is linked: the code is compiled or linked in
                self.document.relate(self.root, "STATIC_LINK", self.debian(name))

    def add_artefact(self, path):
        with open(path, "rb") as file:
            digest = hashlib.sha256(file.read()).hexdigest()
        name = os.path.basename(path)
        key = self.document.package(spdx.identifier("file", name), name, self._number, "NOASSERTION", packageFileName=name,
                                    checksums=[{"algorithm": "SHA256", "checksumValue": digest}])
        self.document.relate("SPDXRef-DOCUMENT", "DESCRIBES", key)
        self.document.relate(key, "GENERATED_FROM", self.root)
        if name.endswith(".whl"):
            for inner in wheel_packages(path):
                self.document.relate(key, "CONTAINS", self.debian(inner))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", metavar="FILE")
    parser.add_argument("--commit", metavar="HASH", default="unknown")
    parser.add_argument("--out", metavar="FILE")
    parser.add_argument("build", nargs="?")
    parser.add_argument("artefacts", nargs="*")
    arguments = parser.parse_args()
    if arguments.check:
        with open(arguments.check, encoding="utf-8") as file:
            document = json.load(file)
    elif arguments.build and arguments.out:
        bill = Bill(arguments.commit)
        bill.add_build(os.path.realpath(arguments.build))
        for artefact in arguments.artefacts:
            bill.add_artefact(artefact)
        document = bill.document.json()
        with open(arguments.out, "w", encoding="utf-8") as file:
            json.dump(document, file, indent=1)
            file.write("\n")
    else:
        parser.error("BUILD and --out, or --check are needed")
    wrong = list(spdx.faults(document))
    if wrong:
        fail("\n".join(wrong))


if __name__ == "__main__":
    main()
