#!/usr/bin/env python3
"""Wheel of the Python package, with a client library that needs no other library than the C library.

    wheel.py BUILD OUTPUT_DIR

BUILD is a Release build. The library is linked again from its static libraries, with OpenSSL and libsodium inside. Its glibc
symbols decide the tag manylinux_2_N (PEP 600): the wheel runs on every distribution with glibc 2.N or newer.
"""
import argparse
import glob
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LIBRARY = "libfire3dv-client.so.0"
SYSTEM_LIBRARIES = re.compile(r"lib(c|m|dl|pthread|rt)\.so\.\d+|ld-linux[\w.-]*")  # parts of glibc


def run(*command, **options):
    done = subprocess.run(command, text=True, capture_output=True, check=False, **options)
    if done.returncode:
        sys.exit(f"wheel.py: {' '.join(command)} failed ({done.returncode}):\n{done.stdout}{done.stderr}")
    return done.stdout


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


def platform_tag(library):
    """The tag manylinux_2_N_ARCH, of the newest glibc symbol version that the library needs."""
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", run("readelf", "-dW", library))
    foreign = [name for name in needed if not SYSTEM_LIBRARIES.fullmatch(name)]
    if foreign:
        sys.exit(f"wheel.py: the library needs {', '.join(foreign)}, which is not part of glibc")
    versions = [int(minor) for minor in re.findall(r"Name: GLIBC_2\.(\d+)", run("readelf", "-VW", library))]
    if not versions:
        sys.exit("wheel.py: the library needs no glibc: there is no tag for it")
    return f"manylinux_2_{max(versions)}_{sysconfig.get_platform().rsplit('-', 1)[-1]}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("output_dir")
    args = parser.parse_args()
    os.makedirs(args.output_dir, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        library, package = os.path.join(folder, LIBRARY), os.path.join(folder, "python")
        link_library(args.build, library)
        shutil.copytree(os.path.join(ROOT, "adapters", "generic", "python"), package,
                        ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"))
        with open(os.path.join(package, "LICENSE"), "w", encoding="utf-8") as licence:  # setuptools adds it to the metadata
            for part in (os.path.join("cmake", "package", "python", "NOTICE"), "LICENSE"):
                with open(os.path.join(ROOT, part), encoding="utf-8") as file:
                    licence.write(file.read())
        run(sys.executable, "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check", "--no-index", "--no-deps",
            "--no-build-isolation", "--wheel-dir", args.output_dir, package,
            env={**os.environ, "FIRE3DV_CLIENT_LIBRARY": library, "FIRE3DV": "", "FIRE3DV_WHEEL_PLATFORM": platform_tag(library)})


if __name__ == "__main__":
    main()
