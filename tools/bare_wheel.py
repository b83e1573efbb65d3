#!/usr/bin/env python3
"""Tries the wheels on bare machines: in a minimal system with nothing but Python, as an ordinary user, without a network.

    bare_wheel.py SUITE ROOTS WHEELS [CASE...]     all cases, or these
    bare_wheel.py --list                           what the cases are

SUITE is a release of Debian (bookworm, trixie, sid) or Ubuntu (jammy, noble). ROOTS/SUITE is made by debootstrap where it is missing: the
packages python3, python3-venv and python3-numpy (no other registry is asked). --mirror URL: where packages are from; for Ubuntu it is
needed, and so is the package ubuntu-keyring. WHEELS is a folder with fire3dv-*.whl and fire3dv_cpu-*.whl.

Each case runs in a copy of the system that is thrown away, and prints a row: seconds of `pip install`, seconds from the start of
`fire3dv demo` to its first image and to its end, the largest process, the exit status, and what was said. Needs root. Exit status 1: a
case went wrong.
"""
import argparse
import glob
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from packaging_tools.bare_cases import CASES, HOME, USERS, Case  # noqa: E402
from packaging_tools.bare_root import Machine, make_root  # noqa: E402

LONGEST_S = 900  # of one command; a hang is a failure


class Run:
    """A command in a machine: its exit status, text, seconds, the time of its first image, and its largest process."""

    def __init__(self, machine, command, user, environment, images=""):
        before = time.time()
        self.first_s = None
        words = ["chroot", f"--userspec={user}:{user}", machine.folder, "/usr/bin/env", "-i",
                 *[f"{name}={value}" for name, value in environment.items()], "/bin/sh", "-c", command]
        with tempfile.TemporaryFile() as output:
            process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                                       start_new_session=True)
            timer = threading.Timer(LONGEST_S, process.kill)
            timer.start()
            usage = None
            while usage is None:
                ended, status, resources = os.wait4(process.pid, os.WNOHANG)
                usage = resources if ended else None
                if self.first_s is None and images and glob.glob(machine.folder + images):
                    self.first_s = time.time() - before
                time.sleep(0.02)
            timer.cancel()
            process.returncode = os.waitstatus_to_exitcode(status)
            self.status, self.seconds, self.largest_mib = process.returncode, time.time() - before, usage.ru_maxrss / 1024
            output.seek(0)
            self.text = output.read().decode(errors="replace").strip()


def environment_of(case):
    variables = {"PATH": "/usr/local/bin:/usr/bin:/bin", "HOME": HOME, "LANG": "C.UTF-8", **case.environment}
    return {name: value for name, value in variables.items() if value is not None}


def say(case, install, demo, wrong):
    def seconds(value):
        return "-" if value is None else f"{value:.1f}"
    text = demo.text.replace(HOME, "~").splitlines()
    print(f"| {case.name} | {seconds(install and install.seconds)} | {seconds(demo.first_s)} | {seconds(demo.seconds)} | "
          f"{demo.largest_mib:.0f} | {demo.status} | {text[-1] if text else ''} |{' WRONG: ' + wrong if wrong else ''}", flush=True)
    if wrong or os.environ.get("FIRE3DV_BARE_VERBOSE"):
        print("    " + "\n    ".join((install.text.splitlines() if install else []) + text), flush=True)


def fault_of(case, demo, machine):
    """What differs from the case's promise; "" if nothing does."""
    if demo.status != case.status:
        return f"exit status {demo.status}, not {case.status}"
    for word in case.says:
        if word not in demo.text:
            return f"it does not say: {word}"
    for word in ("Traceback", *case.says_not):
        if word in demo.text:
            return f"it says: {word}"
    if case.images:
        found = glob.glob(machine.folder + case.images)
        if len(found) < case.image_count:
            return f"{len(found)} images, not {case.image_count}"
        with open(found[0], "rb") as image:
            if image.read(8) != b"\x89PNG\r\n\x1a\n":
                return f"{found[0]} is no PNG file"
    return ""


def run_case(case: Case, root, wheels, installed, scratch):
    """installed: layers of a machine where the wheels are installed and caches filled; None where a case needs neither, or makes them.
    Returns whether it went as promised."""
    layers = [*(installed if installed and not case.install else []), root]
    with Machine(layers, wheels, scratch, shm=case.shm) as machine:
        variables, install = environment_of(case), None
        if case.install or not installed:
            install = Run(machine, case.install or CASES["plain"].install, case.user, variables)
            if install.status:
                say(case, install, install, "the installation failed")
                return False
        if case.prepare:
            prepared = Run(machine, case.prepare, 0, {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin"})
            if prepared.status:
                sys.exit(f"bare_wheel.py: {case.name}: {prepared.text}")
        if case.read_only:
            machine.make_read_only()
        demo = Run(machine, case.command, case.user, variables, case.images)
        wrong = fault_of(case, demo, machine)
        say(case, install, demo, wrong)
        if case.name == "plain":
            shutil.rmtree(machine.folder + os.path.dirname(case.images))  # those of later machines are their own
            machine.keep_as("plain")
        return not wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="list the cases")
    parser.add_argument("--mirror", default="")
    parser.add_argument("suite", nargs="?")
    parser.add_argument("roots", nargs="?")
    parser.add_argument("wheels", nargs="?")
    parser.add_argument("cases", nargs="*")
    args = parser.parse_args()
    if args.list:
        print("\n".join(f"{case.name:20} {case.what}" for case in CASES.values()))
        return 0
    unknown = [name for name in args.cases if name not in CASES]
    if not args.wheels or unknown:
        parser.error(f"no case is called {unknown[0]}: see --list" if unknown else "a suite, a folder of roots and a folder of wheels are needed")
    if os.getuid():
        sys.exit("bare_wheel.py: run as root: chroot and mounts need it")
    if os.environ.get("FIRE3DV_BARE_WHEEL") != "entered":  # mounts and the network are those of this process and its children alone
        command = ["unshare", "--mount", "--net", "--ipc", "--propagation", "private", "--", sys.executable, *sys.argv]
        make_root(args.suite, args.roots, args.mirror)  # needs the network
        return subprocess.call(command, env={**os.environ, "FIRE3DV_BARE_WHEEL": "entered"})
    subprocess.run(("ip", "link", "set", "lo", "up"), check=True)
    root, wheels = os.path.realpath(os.path.join(args.roots, args.suite)), os.path.realpath(args.wheels)
    names = args.cases or list(CASES)
    print(f"{args.suite}: {', '.join(os.path.basename(path) for path in sorted(glob.glob(wheels + '/*.whl')))}, users {USERS}\n"
          "| case | pip install, s | first image, s | end, s | largest process, MiB | exit | last line |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="bare-wheel-") as scratch:
        subprocess.run(("mount", "-t", "tmpfs", "tmpfs", scratch), check=True)
        good, installed = True, None
        for case in sorted((CASES[name] for name in names), key=lambda case: case.name != "plain"):
            if installed is None and not case.install and case.name != "plain":
                run_case(CASES["plain"], root, wheels, None, scratch)
            good = run_case(case, root, wheels, installed, scratch) and good
            kept = os.path.join(scratch, "plain")
            installed = [kept] if os.path.exists(kept) else installed
        subprocess.run(("umount", "-l", scratch), check=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
