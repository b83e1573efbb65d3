#!/usr/bin/env python3
"""End-to-end test of examples/dask: a scheduler and four workers, one of which is killed, draw the bytes of a single run."""
import glob
import os
import shutil
import signal
import sys

from dataset_runs import RUN, command_of, expect_same, run
from harness import Program, check, main, vulkan_environment, wait_until

WORKERS, SHARDS = 4, 6


def children_of(process):
    found = []
    for path in glob.glob(f"/proc/{process}/task/*/children"):
        try:
            with open(path, encoding="utf-8") as file:
                found += file.read().split()
        except OSError:  # the thread has ended
            pass
    return found


def a_killed_worker_changes_nothing(test):
    if not shutil.which("dask-scheduler") or not shutil.which("dask-worker"):
        print("left out: Dask is not installed (Debian: python3-distributed)", flush=True)
        return
    whole, out, file = test.path("whole"), test.path("set"), test.path("scheduler.json")
    run(test, whole, "--format", "coco", *RUN)
    environment = vulkan_environment() | {"DASK_DISTRIBUTED__WORKER__DAEMON": "False"}
    local = ["--scheduler-file", file, "--no-dashboard"]
    Program(test, "scheduler", ["dask-scheduler", *local, "--host", "127.0.0.1", "--port", "0"], environment)
    workers = [Program(test, f"worker {i}", ["dask-worker", *local, "--no-nanny", "--nthreads", "1", "--host", "127.0.0.1",
                                             "--local-directory", test.path(f"worker{i}")], environment) for i in range(WORKERS)]
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "examples", "dask", "draw.py")
    words = list(map(str, command_of(test, "OUT", "--format", "coco", *RUN)))[1:]
    at = words.index("--out")
    # Relative names, which are not of the workers' folders.
    words = [os.path.relpath(word, test.folder) if os.path.isabs(word) else word for word in words]
    draw = Program(test, "draw", [sys.executable, script, "--scheduler-file", file, "--shards", str(SHARDS), "--out", out,
                                  "--fire3dv", test.programs_at["fire3dv"], *words[:at], *words[at + 2:]], environment, cwd=test.folder)
    victim = wait_until(lambda: f"a worker that draws; it said:\n{draw.stderr_text()}",
                        lambda: next((worker for worker in workers if children_of(worker.process.pid)), None) or not draw.alive())
    check(victim is not True, f"it ended:\n{draw.stderr_text()}")
    victim.signal(signal.SIGKILL)
    victim.wait()
    draw.expect_exit()
    check(f"{SHARDS} of {SHARDS} parts are drawn" in "\n".join(draw.out), f"{draw.out}")
    expect_same(out, whole, "parts of Dask's workers")

    failing = Program(test, "failing", [sys.executable, script, "--scheduler-file", file, "--shards", "2", "--out", test.path("failed"),
                                        "--fire3dv", test.programs_at["fire3dv"], "dataset", "no such file.glb", "--format", "coco"],
                      environment, cwd=test.folder)
    failing.expect_exit(1)
    said = failing.stderr_text()
    for wanted in ("part 1 of 2 on", "part 2 of 2 on", "exit status", "no such file.glb", "2 of 2 parts are missing"):
        check(wanted in said, f"{wanted} is not in\n{said}")


if __name__ == "__main__":
    main({"dask": a_killed_worker_changes_nothing}, ("fire3dv", "make"))
