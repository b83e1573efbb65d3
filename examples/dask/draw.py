#!/usr/bin/env python3
"""Draws a data set or the frames of a recording on the workers of a Dask cluster, then joins the parts.

    draw.py --scheduler tcp://HOST:8786 --shards 16 --out SET dataset FILE.mcap SCENE --format bop --camera front

Each shard is a task. A task whose worker ends is done again by another worker, which continues what is there. Inputs and
the folder of --out have to be where all workers see them by the same name."""
import argparse
import ctypes
import os
import signal
import subprocess
import sys
import time

from distributed import Client, as_completed

LOCKED = "another run is writing to"  # by a worker that is gone, whose program has not ended yet
WAIT_S = 60


def end_with_worker():
    """The program stops in order when its worker is killed."""
    pr_set_pdeathsig = 1
    ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGTERM)


def draw_shard(program, words, folder, shard, shards):
    """Runs on a worker. Returns the folder of the part."""
    command = [program, *words, "--shard", f"{shard}/{shards}", "--out", folder]
    end = time.monotonic() + WAIT_S
    while True:
        done = subprocess.run(command, text=True, errors="replace", stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              preexec_fn=end_with_worker)
        if done.returncode == 0:
            return folder
        if LOCKED not in done.stderr or time.monotonic() > end:
            raise RuntimeError(f"shard {shard}/{shards}: {done.stderr.strip().splitlines()[-1] if done.stderr.strip() else done.returncode}")
        time.sleep(1)


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
        tasks = [client.submit(draw_shard, options.fire3dv, options.words, part, shard, options.shards, pure=False, retries=1)
                 for shard, part in enumerate(parts, 1)]
        for count, task in enumerate(as_completed(tasks), 1):
            if task.status != "finished":
                sys.exit(f"draw.py: error: {task.exception()}; the same command continues")
            print(f"{count} of {len(parts)} parts are drawn", flush=True)
    os.execvp(options.fire3dv, [options.fire3dv, "join", *parts, "--out", out])


if __name__ == "__main__":
    main()
