#!/usr/bin/env python3
"""All measurements of recordings in one run, as a Markdown page: docs/benchmarks/recording.md.

    tools/lab/bench/scripts/recording.py --out docs/benchmarks/recording.md --modules node_modules
    tools/lab/bench/scripts/recording.py --quick                            # to see that it works; prints the page
    tools/lab/bench/scripts/recording.py --check                            # is what must hold of a long recording so?

The rows of npm's reader need node, and --modules: a folder with @mcap/core, @mcap/support, @mcap/nodejs, flatbuffers and
flatbuffers_reflection.
"""
import argparse
import contextlib
import datetime
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

import transport_faults
from transport import machine

PROGRAMS = ("fire3dv-bench", "fire3dv-record", "fire3dv-inspect")
HERE = pathlib.Path(__file__).resolve().parents[4]
MOST_SEEK_MS, MOST_RSS_MB = 50, 64


def fail(text):
    sys.exit(f"recording.py: {text}")


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        fail(f"{' '.join(map(str, command))} ended with {done.returncode}:\n{done.stderr[-2000:]}")
    return json.loads(done.stdout)


@contextlib.contextmanager
def recording(programs, folder, *options):
    """What making it came to, and the file, which is gone afterwards."""
    path = os.path.join(folder, "bench.mcap")
    try:
        yield run(programs["fire3dv-bench"], "record-write", path, *options), path
    finally:
        with contextlib.suppress(OSError):
            os.unlink(path)


def writes(programs, folder, seconds, rounds):
    yield "| layout | packed with | million poses/s | of CPU time | bytes a pose | of raw |"
    yield "|---" * 6 + "|"
    ways = [("bare frames", "raw", "none", ()), ("a frame a message (ours)", "frames", "zstd", ()),
            ("a frame a message (ours)", "frames", "lz4", ()), ("a frame a message (ours)", "frames", "none", ()),
            ("ours, and Foxglove's transforms", "frames", "zstd", ("--foxglove",)),
            ("a pose a message", "poses", "zstd", ()), ("a pose a message", "poses", "lz4", ()),
            ("a pose a message", "poses", "none", ())]
    results = {way: [] for way in ways}
    for _ in range(rounds):  # interleaved, so that other load affects all variants
        for way in ways:
            _, layout, compression, more = way
            with recording(programs, folder, "--seconds", seconds, "--layout", layout, "--compression", compression,
                           *more) as (made, _):
                results[way].append(made)
    raw = results[ways[0]][0]["bytes_per_pose"]
    for way, made in results.items():
        per_s, per_cpu_s = (statistics.median(m[key] for m in made) / 1e6 for key in ("poses_per_s", "poses_per_cpu_s"))
        size = made[0]["bytes_per_pose"]
        yield f"| {way[0]} | {way[2]} | {per_s:.2f} | {per_cpu_s:.2f} | {size:.1f} | {100 * size / raw:.0f} % |"


def reads(programs, folder, modules, seconds, seeks, rounds):
    yield "| packed with | reader | open ms | seek ms, median | longest | messages/s | MB/s of messages | peak memory MB |"
    yield "|---" * 8 + "|"
    for compression in ("zstd", "lz4", "none"):
        with recording(programs, folder, "--seconds", seconds, "--compression", compression) as (_, path):
            ours, theirs = [], []
            for _ in range(rounds):
                ours.append(run(programs["fire3dv-bench"], "record-read", path, "--seeks", seeks))
                if modules:
                    theirs.append(run("node", HERE / "tests/e2e/record/mcap_oracle.mjs", modules, "time", path, seeks))
            for name, rows in (("ours", ours), ("@mcap/core, indexed", theirs)):
                if rows:
                    yield read_row(compression, name, {key: statistics.median(r[key] for r in rows) for key in rows[0]})
            if theirs:
                seek, read = (statistics.median(t[key] / o[key] for o, t in zip(ours, theirs))
                              for key in ("seek_median_ms", "read_s"))
                yield f"| {compression} | **ratio** | | **{seek:.1f}** | | **{read:.1f}** | | |"


def read_row(compression, name, row):
    return (f"| {compression} | {name} | {row['open_ms']:.1f} | {row['seek_median_ms']:.2f} | {row['seek_longest_ms']:.2f} | "
            f"{row['messages_per_s']:.0f} | {row['mb_per_s']:.0f} | {row['peak_rss_mb']:.0f} |")


def long_one(programs, folder, seconds, seeks, made_before=None):
    """An hour of 100 nodes at 1000 Hz; most of it stands still, so that a disk need not hold 17 GB. Its bytes, and the reader."""
    def look(path):
        read = run(programs["fire3dv-bench"], "record-read", path, "--seeks", seeks, "--seek-only")
        return os.path.getsize(path), read
    if made_before:
        return look(made_before)
    with recording(programs, folder, "--seconds", seconds, "--motion", "rest") as (_, path):
        return look(path)


def publish_pairs(programs, folder, rounds, seconds):
    """The transports' table: the publisher alone with a reader, and with a recorder instead, in turns."""
    yield "| link | p50 us, inspected | recorded | p99 us | recorded | p99.9 us | recorded | p99.9, ratio of pairs (range) | calls |"
    yield "|---" * 9 + "|"
    for link in ("shm", "tcp", "udp"):
        uri = transport_faults.fresh_uri(link)
        publisher = transport_faults.Publisher(programs["fire3dv-bench"], uri, 1000, 100)
        before, during = [], []
        try:
            for number in range(rounds):
                path = os.path.join(folder, f"{link}{number}.mcap")
                for rows, command in ((before, [programs["fire3dv-inspect"], uri, "--seconds", "86000"]),
                                      (during, [programs["fire3dv-record"], "--from", uri, "--out", path])):
                    reader = transport_faults.Reader(command)
                    try:
                        publisher.wait_for_reader()
                        publisher.ask()
                        time.sleep(seconds)
                        rows.append(publisher.ask())
                    finally:
                        reader.end()
                    while publisher.ask()["renderers"]:  # waits until the publisher has no readers
                        time.sleep(0.02)
                os.unlink(path)
        finally:
            publisher.end()
        row = transport_faults.table_row(f"{link}://", "", before, during)
        yield row.replace("|  |", "|", 1)


def page(arguments, programs, folder):
    quick = arguments.quick
    commit = subprocess.run(["git", "-C", str(HERE), "describe", "--always", "--dirty"], capture_output=True, text=True,
                            check=False).stdout.strip() or "unknown"
    yield "# Recordings"
    yield ""
    yield f"`tools/lab/bench/scripts/recording.py{' --quick' if quick else ''}`, {datetime.date.today()}, commit {commit}, {machine()}"
    yield ""
    yield "What each table measures: [README.md](README.md#recordings)."
    yield "\n## Writing, and how long files are\n"
    seconds, rounds = (1, 1) if quick else (arguments.seconds, arguments.rounds)
    yield from writes(programs, folder, seconds, rounds)
    yield "\n## Reading and seeking\n"
    yield from reads(programs, folder, arguments.modules, seconds, 10 if quick else 100, rounds)
    yield "\n## An hour\n"
    seconds = 20 if quick else 3600
    size, read = long_one(programs, folder, seconds, 20 if quick else 1000, arguments.hour)
    yield (f"{seconds * 1000} frames of 100 poses, {size / 1e6:.0f} MB in {read['chunks']} chunks, zstd; opened in "
           f"{read['open_ms']:.1f} ms. A seek takes {read['seek_median_ms']:.2f} ms (median), {read['seek_longest_ms']:.2f} ms "
           f"(longest of {20 if quick else 1000}), {read['seek_longest_cpu_ms']:.2f} ms of CPU time at most; peak memory {read['peak_rss_mb']:.1f} MB.")
    yield "\n## A publisher that is recorded\n"
    yield from publish_pairs(programs, folder, 1 if quick else 5, 0.5 if quick else 3)


def check(programs, folder):
    size, read = long_one(programs, folder, 3600, 300)
    print(f"{size / 1e6:.0f} MB, {read}")
    # thread CPU time, independent of other load
    if read["seek_longest_cpu_ms"] > MOST_SEEK_MS or read["peak_rss_mb"] > MOST_RSS_MB:
        fail(f"more than {MOST_SEEK_MS} ms for a seek, or {MOST_RSS_MB} MB")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", default="build/lab/bin", help="folder of the programs")
    parser.add_argument("--out", help="where the page goes; without, it is printed")
    parser.add_argument("--modules", help="a node_modules folder")
    parser.add_argument("--hour", help="made before: fire3dv-bench record-write FILE --seconds 3600 --motion rest")
    parser.add_argument("--seconds", type=float, default=20, help="of each recording")
    parser.add_argument("--rounds", type=int, default=3, help="of each row")
    parser.add_argument("--quick", action="store_true", help="little of everything")
    parser.add_argument("--check", action="store_true", help="an hour's recording alone; fails where its seeks are too slow")
    arguments = parser.parse_args()
    programs = {name: os.path.join(arguments.programs, name) for name in PROGRAMS}
    for path in programs.values():
        if not os.access(path, os.X_OK):
            fail(f"{path} is missing: build it, or name its folder with --programs")
    if arguments.modules and not shutil.which("node"):
        fail("--modules needs node")
    with tempfile.TemporaryDirectory(prefix="fire3dv-recording-") as folder:
        if arguments.check:
            check(programs, folder)
            return
        out = sys.stdout if arguments.out is None else open(arguments.out, "w", encoding="utf-8")
        try:
            for line in page(arguments, programs, folder):
                print(line, file=out, flush=True)
        except transport_faults.Trouble as trouble:
            fail(str(trouble))


if __name__ == "__main__":
    main()
