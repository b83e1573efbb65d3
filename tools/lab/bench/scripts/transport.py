#!/usr/bin/env python3
"""All measurements of the transports in one run, as a Markdown page: docs/benchmarks/transport.md.

    tools/lab/bench/scripts/transport.py --out docs/benchmarks/transport.md
    tools/lab/bench/scripts/transport.py --quick                            # to see that it works; prints the page

The pairs' last rows need root, or a kernel that lets users mount, for a disk without room. Rows of tls:// need openssl.
"""
import argparse
import datetime
import os
import pathlib
import platform
import secrets
import shutil
import subprocess
import sys
import tempfile

import pose_age
import transport_faults

LINKS = ("shm", "tcp", "udp")
PROGRAMS = ("fire3dv-bench", "fire3dv-inspect", "fire3dv")


def fail(text):
    sys.exit(f"transport.py: {text}")


def bench(programs, *arguments):
    command = [programs["fire3dv-bench"], *arguments]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        fail(f"{' '.join(command)} ended with {result.returncode}:\n{result.stderr[-2000:]}")
    return result.stdout.rstrip()


def protection(folder):
    """Options of one-way for its rows with a key and with a certificate."""
    key = os.path.join(folder, "key")
    with open(os.open(key, os.O_WRONLY | os.O_CREAT, 0o600), "w", encoding="ascii") as file:
        file.write(secrets.token_hex(32))
    options = ["--key-file", key]
    if shutil.which("openssl"):
        certificate, private = os.path.join(folder, "cert.pem"), os.path.join(folder, "cert.key")
        made = subprocess.run(["openssl", "req", "-x509", "-newkey", "ed25519", "-nodes", "-days", "1", "-subj", "/CN=localhost",
                               "-addext", "subjectAltName=DNS:localhost", "-keyout", private, "-out", certificate],
                              capture_output=True, text=True, check=False)
        if made.returncode != 0:
            fail(f"openssl makes no certificate:\n{made.stderr[-1000:]}")
        os.chmod(private, 0o600)
        options += ["--tls-cert", certificate, "--tls-key", private]
    return options


def rows_of_test(program):
    """The table rows that a test prints beside its verdict."""
    result = subprocess.run([program], capture_output=True, text=True, check=False)
    if result.returncode != 0:
        fail(f"{program} ended with {result.returncode}:\n{result.stdout[-2000:]}")
    return [line for line in result.stdout.splitlines() if line.startswith("|")]


def machine():
    model = platform.processor() or platform.machine()
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        model = next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), model)
    return f"{model}, {len(os.sched_getaffinity(0))} cores, Linux {platform.release()}, load {os.getloadavg()[0]:.1f} at the start"


def page(arguments, programs, folder):
    quick = arguments.quick
    some = LINKS[:1] if quick else LINKS  # links of measurements that start a renderer
    disk = os.path.join(folder, "disk")
    os.mkdir(disk)
    scene = os.path.join(folder, "bodies.glb")
    pose_age.write_scene(scene, 100)
    rounds, seconds = (1, 0.2) if quick else (arguments.rounds, arguments.seconds)
    here = pathlib.Path(__file__).resolve().parents[4]
    commit = subprocess.run(["git", "-C", str(here), "describe", "--always", "--dirty"], capture_output=True, text=True,
                            check=False).stdout.strip() or "unknown"

    def renderer(uri):
        return [programs["fire3dv"], scene, "--headless", "--listen", uri, "--play", "latest", "--cache", "off",
                "--size", "320x180", "--out", disk, *arguments.option]

    yield "# Transports"
    yield ""
    yield f"`tools/lab/bench/scripts/transport.py{' --quick' if quick else ''}`, {datetime.date.today()}, commit {commit}, {machine()}"
    yield ""
    yield "What each table measures: [README.md](README.md#transports)."
    yield "\n## What one publish costs\n"
    yield bench(programs, "transport", "3" if quick else "301")
    yield "\n## One way\n"
    one_way = ["--rounds", "2", "--frames", "10"] if quick else ["--rounds", "101"]
    yield bench(programs, "one-way", *one_way, *protection(folder))
    yield "\n## Ingest\n"
    yield bench(programs, "ingest", "--seconds", "0.05" if quick else "3")
    yield "\n## A publisher whose reader is in trouble\n"
    yield (f"100 poses at 1000 Hz; {rounds} pairs a row, of {seconds:g} s before and as long during the trouble. Out of disk is the "
           "renderer, the other readers are fire3dv-inspect.\n")
    yield from transport_faults.tables(programs, rounds, seconds, 1000, 100, renderer, disk, LINKS, some)
    killed, many = (os.path.join(arguments.tests, name) for name in ("killed_writers_test", "many_adapters_test"))
    if not quick:
        yield "\n## Simulators that are killed\n"
        yield from rows_of_test(killed)
        yield "\n## 64 adapters at 1000 Hz, 100 poses each\n"
        yield "| link | published, each, Hz | read, all, Hz | million poses/s | least share beside mean | memory grew by | dropped |"
        yield "|---" * 7 + "|"
        yield from rows_of_test(many)
    yield "\n## Pose age\n"
    yield (f"From the publisher's call to the submission of the frame that shows the poses, in shares of frames by ms. "
           f"{' '.join(arguments.option) or 'The default device'}, 320x180.\n")
    yield from pose_age.tables(programs, scene, 0.5 if quick else 10, 100, folder, ["--size", "320x180", *arguments.option], some)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", default="build/lab/bin", help="folder of the programs")
    parser.add_argument("--tests", default="build/release/tests", help="folder of the tests, two of which print tables")
    parser.add_argument("--out", help="where the page goes; without, it is printed")
    parser.add_argument("--rounds", type=int, default=5, help="pairs of each row")
    parser.add_argument("--seconds", type=float, default=10, help="of each half of a pair")
    parser.add_argument("--quick", action="store_true", help="little of everything")
    parser.add_argument("--option", action="append", default=[], help="for the renderer; may be given several times")
    arguments = parser.parse_args()
    programs = {name: os.path.join(arguments.programs, name) for name in PROGRAMS}
    for path in programs.values():
        if not os.access(path, os.X_OK):
            fail(f"{path} is missing: build it, or name its folder with --programs")
    out = sys.stdout if arguments.out is None else open(arguments.out, "w", encoding="utf-8")
    with tempfile.TemporaryDirectory(prefix="fire3dv-transport-") as folder:
        try:
            for line in page(arguments, programs, folder):
                print(line, file=out, flush=True)
        except transport_faults.Trouble as trouble:
            fail(str(trouble))


if __name__ == "__main__":
    main()
