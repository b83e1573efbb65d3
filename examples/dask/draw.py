#!/usr/bin/env python3
"""Draws a data set or the frames of a recording on the workers of a Dask cluster, then joins the parts.

    draw.py --scheduler tcp://HOST:8786 --shards 16 --out SET dataset FILE.mcap SCENE --format bop --camera front

Each shard is a task. A task whose worker ends is done again by another worker, which continues what is there. The working
folder, inputs and the folder of --out have to be where all workers see them by the same name."""
import argparse
import ctypes
import os
import signal
import socket
import subprocess
import sys
import time

from distributed import CancelledError, Client, as_completed

LINES = 5  # of a failed program that are printed
LOCKED = "another run is writing to"  # by a worker that is gone, whose program has not ended yet
WAIT_S = 60


def end_with_worker():
    """The program stops in order when its worker is killed."""
    pr_set_pdeathsig = 1
    ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGTERM)


def ending(done):
    """Why a program has failed: its errors, or else its last lines, and how it ended."""
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    errors = [line for line in lines if "error:" in line]
    how = f"signal {-done.returncode}" if done.returncode < 0 else f"exit status {done.returncode}"
    return "\n  ".join([how, *(errors or lines)[-LINES:]])


def draw_shard(program, words, working, folder, shard, shards):
    """Runs on a worker, in the working folder of this program. Returns the folder of the part."""
    command = [program, *words, "--shard", f"{shard}/{shards}", "--out", folder]
    where = f"part {shard} of {shards} on {socket.gethostname()}"
    end = time.monotonic() + WAIT_S
    while True:
        try:
            done = subprocess.run(command, text=True, errors="replace", stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, cwd=working,
                                  preexec_fn=end_with_worker)
        except OSError as fault:
            raise RuntimeError(f"{where}: {program} cannot be started in {working}: {fault.strerror} ({fault.filename})") from None
        if done.returncode == 0:
            return folder
        if LOCKED not in done.stderr or time.monotonic() > end:
            raise RuntimeError(f"{where}: {ending(done)}")
        time.sleep(1)


def failure(task):
    """Text of a task that has no result."""
    try:
        return str(task.exception())
    except CancelledError:
        return "a task was cancelled by the scheduler"


def main():
    parser = argparse.ArgumentParser(description="Draws on the workers of a Dask cluster.")
    parser.add_argument("--scheduler", help="address, such as tcp://HOST:8786")
    parser.add_argument("--scheduler-file", help="file that dask-scheduler --scheduler-file writes")
    parser.add_argument("--shards", type=int, default=16, help="number of parts: several for each worker")
    parser.add_argument("--out", required=True, help="folder of the set (a video for render); parts are beside it, in NAME.parts")
    parser.add_argument("--fire3dv", default="fire3dv", help="path of the program on the workers")
    parser.add_argument("words", nargs=argparse.REMAINDER, help="dataset or render, and its arguments without --out and --shard")
    options = parser.parse_args()
    if not options.words or options.words[0] not in ("dataset", "render"):
        parser.error("name a command: dataset or render")
    if not options.scheduler and not options.scheduler_file:
        parser.error("name a scheduler: --scheduler or --scheduler-file")
    out = os.path.abspath(options.out)
    parts = [os.path.join(out + ".parts", f"shard_{shard:04}") for shard in range(1, options.shards + 1)]
    with Client(options.scheduler, scheduler_file=options.scheduler_file) as client:
        tasks = [client.submit(draw_shard, options.fire3dv, options.words, os.getcwd(), part, shard, options.shards, pure=False, retries=1)
                 for shard, part in enumerate(parts, 1)]
        drawn = 0
        for task in as_completed(tasks):
            if task.status == "finished":
                drawn += 1
                print(f"{drawn} of {len(parts)} parts are drawn", flush=True)
            else:
                print(f"draw.py: error: {failure(task)}", file=sys.stderr, flush=True)
    if drawn < len(parts):
        sys.exit(f"draw.py: error: {len(parts) - drawn} of {len(parts)} parts are missing; the same command draws them")
    os.execvp(options.fire3dv, [options.fire3dv, "join", *parts, "--out", out])


if __name__ == "__main__":
    main()
