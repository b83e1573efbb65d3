"""ELF files of a wheel: the libraries that programs need, carried beside them under names of their own.

A carried library gets a name that holds its digest, as by auditwheel: a driver of the system that is loaded into the same
process then has its own copies. Libraries of FALLBACKS must be the system's where it has them, since a driver or a window
system shares them with us: each group lies in a folder of its own, which fire3dv/_programs.py adds to the search path
only if the system has none.
"""
import hashlib
import os
import re
import shutil
import subprocess
import sys

GLIBC = re.compile(r"lib(c|m|dl|pthread|rt|resolv|util)\.so\.\d+|ld-linux[\w.-]*")
FALLBACKS = {
    "stdcxx": re.compile(r"lib(stdc\+\+|gcc_s)\.so\.\d+"),
    "vulkan": re.compile(r"libvulkan\.so\.1"),
    "x11": re.compile(r"lib(X11|xcb|Xau|Xdmcp|bsd|md)\.so\.\d+"),
    "xext": re.compile(r"libXext\.so\.6"),
    "glvnd": re.compile(r"lib(EGL|GLdispatch)\.so\.\d+"),
}
# NVIDIA's Vulkan driver loads them, also without a display: without libEGL it has no vkCreateInstance. Containers often lack both.
DRIVERS_NEED = ("libEGL.so.1", "libXext.so.6")

LOADED = ("libvulkan.so.1",)  # loaded when a program starts, by its name: renderer/gpu/loader


def run(*command, **options):
    done = subprocess.run(command, text=True, capture_output=True, check=False, **options)
    if done.returncode:
        sys.exit(f"wheel.py: {' '.join(command)} failed ({done.returncode}):\n{done.stdout}{done.stderr}")
    return done.stdout


def needed(path):
    """Names of the libraries that the file needs by itself."""
    return re.findall(r"\(NEEDED\).*\[(.*)\]", run("readelf", "-dW", path))


def glibc_minor(path):
    """N of the newest symbol version GLIBC_2.N that the file needs, weak ones aside; 0: none."""
    return max(map(int, re.findall(r"Name: GLIBC_2\.(\d+)  Flags: none", run("readelf", "-VW", path))), default=0)


def resolved(path):
    """Files of all libraries that the file needs, by name, as the dynamic linker of this machine finds them."""
    text = run("ldd", path)
    missing = re.findall(r"^\s*(\S+) => not found", text, re.MULTILINE)
    if missing:
        sys.exit(f"wheel.py: {path} needs {', '.join(missing)}, which this machine lacks")
    return dict(re.findall(r"^\s*(\S+) => (/\S+)", text, re.MULTILINE))


def loaded(path):
    """Files of the libraries that the program loads when it starts, by name."""
    with open(path, "rb") as file:
        data = file.read()
    names = [name for name in LOADED if name.encode() + b"\0" in data]
    listed = run("ldconfig", "-p") if names else ""
    files = {name: re.search(rf"^\s*{re.escape(name)} \(libc6,(?:x86-64|AArch64).* => (/\S+)", listed, re.MULTILINE) for name in names}
    missing = [name for name, file in files.items() if not file]
    if missing:
        sys.exit(f"wheel.py: {path} loads {', '.join(missing)}, which this machine lacks")
    return {name: file.group(1) for name, file in files.items()}


def fallback_of(name):
    return next((group for group, pattern in FALLBACKS.items() if pattern.fullmatch(name)), None)


def _copy(source, target, *patches):
    """patches: arguments of patchelf, one run each: it mixes up the values of several options."""
    shutil.copyfile(source, target)
    os.chmod(target, 0o755)
    run("strip", "--strip-unneeded", target)
    for patch in filter(None, patches):
        run("patchelf", *patch, target)


class Carrier:
    """Copies programs and libraries into the package folder, and makes them find each other there."""

    def __init__(self, package, given=()):
        """given: names of libraries that are in the package folder already."""
        self.package, self.given = package, set(given)
        self.sources = {}  # file of this machine: file in the package
        self._names = {}  # name of a library: its name in the package

    def program(self, source, folder="bin"):
        """Copies a program, or a library that is loaded by its path, and what it needs. Returns its new path."""
        for name, library in {**resolved(source), **loaded(source)}.items():
            self._library(name, library)
        target = os.path.join(self.package, folder, os.path.basename(source))
        os.makedirs(os.path.dirname(target), exist_ok=True)
        up = os.path.relpath(self.package, os.path.dirname(target))
        _copy(source, target, self._replacements(source), ("--set-rpath", f"$ORIGIN/{up}/lib:$ORIGIN/{up}"))
        self.sources[source] = target
        return target

    def what_drivers_need(self):
        """Copies libraries that no program of ours needs."""
        known = dict(re.findall(r"^\s*(\S+) \(libc6,x86-64.*\) => (/\S+)", run("/sbin/ldconfig", "-p"), re.MULTILINE))
        for name in DRIVERS_NEED:
            if name not in known:
                sys.exit(f"wheel.py: {name} is missing: run tools/setup.sh")
            self._library(name, known[name])

    def files(self, with_fallbacks=True):
        return [target for source, target in self.sources.items() if with_fallbacks or not fallback_of(os.path.basename(target))]

    def _replacements(self, path):
        pairs = [(name, self._names[name]) for name in needed(path) if self._names.get(name, name) != name]
        return [word for old, new in pairs for word in ("--replace-needed", old, new)]

    def _library(self, name, source):
        if GLIBC.fullmatch(name) or name in self.given or name in self._names:
            return
        group = fallback_of(name)
        if group:
            self._names[name] = name
            target = os.path.join(self.package, "lib", group, name)
        else:
            with open(source, "rb") as file:
                digest = hashlib.sha256(file.read()).hexdigest()[:8]
            stem, rest = name.split(".so", 1)
            self._names[name] = f"{stem}-{digest}.so{rest}"
            target = os.path.join(self.package, "lib", self._names[name])
        for inner, file in resolved(source).items():
            self._library(inner, file)
        os.makedirs(os.path.dirname(target), exist_ok=True)
        if group:
            _copy(source, target)
        else:
            _copy(source, target, self._replacements(source), ("--set-soname", self._names[name]), ("--set-rpath", "$ORIGIN"))
        self.sources[source] = target
