#!/usr/bin/env python3
"""Wheels: fire3dv, with the Python package, the programs and all that they need; fire3dv-cpu, Mesa's software driver.

    wheel.py BUILD OUTPUT_DIR        fire3dv: of a Release build
    wheel.py --cpu OUTPUT_DIR        fire3dv-cpu: of this machine's Mesa (package mesa-vulkan-drivers)

The client library is linked again from its static libraries, with OpenSSL and libsodium inside. Programs keep their shared
libraries, which are carried beside them (packaging_tools/elf.py). The tag manylinux_2_N (PEP 600) is that of the newest glibc
symbol version in any file but those that only replace a missing library of the system. Needs patchelf.
"""
import argparse
import glob
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time

from packaging_tools import archive
from packaging_tools.elf import GLIBC, Carrier, glibc_minor, needed, run
from packaging_tools.older_glibc import lower

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

LIBRARY = "libfire3dv-client.so.0"
PROGRAMS = ("fire3dv", "fire3dv-convert", "fire3dv-inspect", "fire3dv-record", "fire3dv-replay", "bullet_arm")
ADAPTERS = ("fire3dv-drake", "fire3dv-gazebo", "fire3dv-mujoco", "fire3dv-ros2")  # where the build has them
DRIVER = "libvulkan_lvp.so"


def in_build(build, name):
    found = glob.glob(os.path.join(build, "**", name), recursive=True)
    if len(found) != 1:
        sys.exit(f"wheel.py: {build} holds {len(found)} files {name}, one is needed: build the target fire3dv_client_inside")
    return found[0]


def compiler(build):
    with open(os.path.join(build, "CMakeCache.txt"), encoding="utf-8") as cache:
        return re.search(r"^CMAKE_CXX_COMPILER:\w+=(.+)$", cache.read(), re.MULTILINE).group(1)


def static_libraries(gxx):
    """Files of OpenSSL, libsodium, and the libraries that the distribution's OpenSSL needs (zlib and Zstandard, or none)."""
    flags = run("pkg-config", "--static", "--libs-only-l", "libssl", "libcrypto", "libsodium").split()
    for name in (flag[2:] for flag in flags if flag not in ("-ldl", "-lpthread", "-lm")):
        path = run(gxx, f"-print-file-name=lib{name}.a").strip()
        if not os.path.isabs(path):
            sys.exit(f"wheel.py: lib{name}.a is missing: run tools/setup.sh")
        yield path


def link_library(build, path):
    gxx = compiler(build)
    inner = [in_build(build, f"libfire3dv_{name}.a") for name in ("robot", "transport", "wire", "base")]
    run(gxx, "-shared", "-o", path, f"-Wl,-soname,{LIBRARY}",
        f"-Wl,--version-script={os.path.join(ROOT, 'adapters', 'generic', 'src', 'exports.map')}",
        "-Wl,--whole-archive", in_build(build, "libfire3dv_client_inside.a"), "-Wl,--no-whole-archive", *inner, *static_libraries(gxx),
        "-static-libstdc++", "-static-libgcc", "-Wl,--gc-sections,--no-undefined,-z,relro,-z,now,-s")


def platform_tag(files):
    """The tag manylinux_2_N_ARCH, of the newest glibc symbol version that any of the files needs."""
    minor = max(map(glibc_minor, files))
    if not minor:
        sys.exit("wheel.py: no file needs glibc: there is no tag for them")
    return f"manylinux_2_{minor}_{sysconfig.get_platform().rsplit('-', 1)[-1]}"


def debian_package(path):
    """Name of the Debian package of a file; "" if it has none."""
    for pattern in (path, os.path.realpath(path), "*" + os.path.realpath(path)):  # /lib is a link to /usr/lib
        found = subprocess.run(("dpkg", "-S", pattern), text=True, capture_output=True, check=False).stdout
        if found:
            return found.split(":")[0]
    return ""


def write_licences(sources, folder):
    """Copyright files of the Debian packages that the files are from."""
    os.makedirs(folder)
    for source in sources:
        name = debian_package(source)
        copyright_file = f"/usr/share/doc/{name}/copyright"
        if not name or not os.path.exists(copyright_file):
            sys.exit(f"wheel.py: {source} has no copyright file below /usr/share/doc")
        shutil.copyfile(copyright_file, os.path.join(folder, name))


def copy_programs(build, package):
    """Programs of the build, and their libraries, into the folders bin and lib of the package folder."""
    carrier = Carrier(package, given=[LIBRARY])
    own = []
    for name in (*PROGRAMS, *ADAPTERS):
        path = os.path.join(os.path.realpath(build), "bin", name)
        if os.path.exists(path):
            carrier.program(path)
            own.append(path)
        elif name in PROGRAMS:
            sys.exit(f"wheel.py: {path} is missing: build the target {name}")
    carrier.what_drivers_need()
    write_licences(set(carrier.sources) - set(own), os.path.join(package, "licences"))
    return carrier


def pip_wheel(source, output, **environment):
    with tempfile.TemporaryDirectory() as made:
        run(sys.executable, "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check", "--no-index", "--no-deps",
            "--no-build-isolation", "--wheel-dir", made, source, env={**os.environ, **environment})
        [wheel] = glob.glob(os.path.join(made, "*.whl"))
        archive.normalise(wheel, int(os.environ.get("SOURCE_DATE_EPOCH", time.time())))
        shutil.move(wheel, os.path.join(output, os.path.basename(wheel)))


def copy_tree(name, target):
    shutil.copytree(os.path.join(ROOT, "adapters", "generic", name), target,
                    ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"))


def make_main_wheel(build, output, folder):
    library, package, files = (os.path.join(folder, name) for name in (LIBRARY, "python", "files"))
    os.makedirs(files)
    link_library(build, library)
    foreign = [name for name in needed(library) if not GLIBC.fullmatch(name)]
    if foreign:
        sys.exit(f"wheel.py: the library needs {', '.join(foreign)}, which is not part of glibc")
    carrier = copy_programs(build, files)
    copy_tree("python", package)
    with open(os.path.join(package, "LICENSE"), "w", encoding="utf-8") as licence:  # setuptools adds it to the metadata
        for part in (os.path.join("cmake", "package", "python", "NOTICE"), "LICENSE"):
            with open(os.path.join(ROOT, part), encoding="utf-8") as file:
                licence.write(file.read())
    pip_wheel(package, output, FIRE3DV_CLIENT_LIBRARY=library, FIRE3DV="", FIRE3DV_WHEEL_FILES=files,
              FIRE3DV_WHEEL_PLATFORM=platform_tag([library, *carrier.files(with_fallbacks=False)]))


def make_driver_wheel(output, folder):
    manifests = glob.glob("/usr/share/vulkan/icd.d/lvp_icd*.json")
    if not manifests:
        sys.exit("wheel.py: Mesa's software driver is missing: apt install mesa-vulkan-drivers")
    with open(manifests[0], encoding="utf-8") as file:
        manifest = json.load(file)
    package = os.path.join(folder, "python-cpu")
    copy_tree("python-cpu", package)
    inner = os.path.join(package, "fire3dv_cpu")
    named = manifest["ICD"]["library_path"]
    [driver] = [named] if os.path.isabs(named) else glob.glob(f"/usr/lib/*/{DRIVER}")
    carrier = Carrier(inner)
    target = carrier.program(driver, folder="lib")
    manifest["ICD"]["library_path"] = "./" + os.path.basename(target)
    with open(os.path.join(inner, "lib", "lvp_icd.json"), "w", encoding="utf-8") as file:
        json.dump(manifest, file, indent=2)
    lower(carrier.files(), os.path.join(inner, "lib"))
    write_licences(carrier.sources, os.path.join(inner, "licences"))
    pip_wheel(package, output, FIRE3DV_WHEEL_PLATFORM=platform_tag(carrier.files(with_fallbacks=False)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?")
    parser.add_argument("output_dir")
    parser.add_argument("--cpu", action="store_true")
    args = parser.parse_args()
    if bool(args.build) == args.cpu:
        parser.error("name a build, or --cpu")
    if not shutil.which("patchelf"):
        sys.exit("wheel.py: patchelf is missing: run tools/setup.sh")
    os.makedirs(args.output_dir, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        if args.cpu:
            make_driver_wheel(args.output_dir, folder)
        else:
            make_main_wheel(args.build, args.output_dir, folder)


if __name__ == "__main__":
    main()
