"""Minimal systems by debootstrap, and machines made of them: layers of folders, with devices, entered by chroot."""
import os
import re
import shutil
import subprocess
import sys

from packaging_tools.bare_cases import USERS

UBUNTU = {"jammy", "noble", "questing", "resolute"}
PACKAGES = "python3,python3-venv,python3-numpy"
DEVICES = ("null", "zero", "full", "random", "urandom", "tty")
MAKE = """set -euo pipefail
say() { printf 'bare_wheel.py: %s\\n' "$*"; }
die() { printf 'bare_wheel.py: %s\\n' "$*" >&2; exit 1; }
. "$1/bare_system.sh"
directory=$(bare_directory "$3")
make_bare_system "$2" "$directory" "${@:4}"
"""
TOOLS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def make_root(suite, roots, mirror):
    """ROOTS/SUITE, where it is missing, and its users."""
    if not mirror and suite in UBUNTU:
        sys.exit("bare_wheel.py: name Ubuntu's packages by --mirror URL")
    ubuntu = ["--components=main,universe", "--keyring=/usr/share/keyrings/ubuntu-archive-keyring.gpg"]
    root = os.path.join(roots, suite)
    os.makedirs(roots, exist_ok=True)
    made = subprocess.run(("unshare", "--mount", "bash", "-c", MAKE, "bash", TOOLS, suite, root, mirror, "--include=" + PACKAGES,
                           *(ubuntu if suite in UBUNTU else [])), check=False)
    if made.returncode:
        sys.exit(1)
    with open(os.path.join(root, "etc/passwd"), "r+", encoding="utf-8") as passwd:
        text = passwd.read()
        for name, number in USERS.items():
            if not re.search(rf"^{name}:", text, re.MULTILINE):
                passwd.write(f"{name}:x:{number}:{number}::/home/{name}:/bin/sh\n")
            os.makedirs(os.path.join(root, "home", name), exist_ok=True)
            os.chown(os.path.join(root, "home", name), number, number)


def mount(*words):
    subprocess.run(("mount", *words), check=True)


class Machine:
    """layers: folders, the uppermost first; what is written goes to a folder of scratch, which the end removes. A context manager."""

    def __init__(self, layers, wheels, scratch, shm):
        """shm: size of /dev/shm as of tmpfs' option size; None: there is none."""
        self._scratch, self._wheels, self._layers, self._shm = scratch, wheels, layers, shm
        self._upper, self._work, self.folder = (os.path.join(scratch, name) for name in ("upper", "work", "root"))
        self._mounts = []

    def _mount(self, target, *words):
        os.makedirs(target, exist_ok=True)
        mount(*words, target)
        self._mounts.append(target)

    def __enter__(self):
        for folder in (self._upper, self._work):
            os.makedirs(folder)
        layers = f"lowerdir={':'.join(self._layers)},upperdir={self._upper},workdir={self._work}"
        self._mount(self.folder, "-t", "overlay", "-o", layers, "overlay")
        self._mount(self.folder + "/proc", "-t", "proc", "proc")
        self._mount(self.folder + "/tmp", "-t", "tmpfs", "-o", "mode=1777", "tmpfs")
        self._mount(self.folder + "/wheels", "-o", "bind,ro", "--bind", self._wheels)
        self._mount(self.folder + "/dev", "-t", "tmpfs", "-o", "mode=755", "tmpfs")
        for name in DEVICES:
            open(f"{self.folder}/dev/{name}", "w", encoding="ascii").close()
            self._mount_file(name)
        os.symlink("/proc/self/fd", self.folder + "/dev/fd")
        if self._shm:
            self._mount(self.folder + "/dev/shm", "-t", "tmpfs", "-o", f"mode=1777,size={self._shm}", "tmpfs")
        if os.path.isdir("/usr/share/i18n"):  # sources of locales, for cases that make one
            self._mount(self.folder + "/usr/share/i18n", "-o", "bind,ro", "--bind", "/usr/share/i18n")
        return self

    def _mount_file(self, name):
        mount("--bind", f"/dev/{name}", f"{self.folder}/dev/{name}")
        self._mounts.append(f"{self.folder}/dev/{name}")

    def make_read_only(self):
        mount("-o", "remount,ro", self.folder)

    def keep_as(self, name):
        """What was written becomes a layer for later machines: SCRATCH/name."""
        self._close()
        os.rename(self._upper, os.path.join(self._scratch, name))

    def _close(self):
        while self._mounts:
            subprocess.run(("umount", "-l", self._mounts.pop()), check=True)

    def __exit__(self, *_):
        self._close()
        for folder in (self._upper, self._work):
            shutil.rmtree(folder, ignore_errors=True)
