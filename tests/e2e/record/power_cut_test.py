"""Power-cut test: flushed frames are in the recording, whole and in order; replaced files are the old or the new one.

FIRE3DV_POWER_CUTS is the number of cuts. Times are on the writer's own clock, independent of the machine's load.
"""
import collections
import os
import random
import shutil
import signal
import struct
import subprocess

from harness import Program, check, main
from mcap_file import McapFile, pose_frame
from power_cut import FLUSH, Disk, operations_of

CUTS = int(os.environ.get("FIRE3DV_POWER_CUTS", "20"))
FRAMES, FLUSH_MS = 600, 100
SEED = 20


def run_writer(test, name, kill_at):
    """Returns the operations of a run that is killed after operation kill_at (0: after its end)."""
    folder, journal = test.path(name), test.path(name + ".journal")
    os.makedirs(os.path.join(folder, "replaced"))
    done = subprocess.run([test.programs_at["writer"], folder, str(FRAMES), str(FLUSH_MS)], capture_output=True, text=True,
                          timeout=240, env=preloaded(test, folder, journal, kill_at))
    check(done.returncode == (-signal.SIGKILL if kill_at else 0), f"the writer ended with {done.returncode}: {done.stderr}")
    shutil.rmtree(folder)
    result = operations_of(journal)
    os.unlink(journal)
    return result


def preloaded(test, folder, journal, kill_at):
    return {**os.environ, "LD_PRELOAD": test.programs_at["shim"], "LOSE_UNSYNCED_FOLDER": folder,
            "LOSE_UNSYNCED_JOURNAL": journal, "LOSE_UNSYNCED_KILL_AT": str(kill_at)}


def recover(test, content):
    """Returns the recording that fire3dv-record recover makes of the rest; None if it cannot."""
    cut, whole = test.path("cut.mcap"), test.path("whole.mcap")
    with open(cut, "wb") as file:
        file.write(content)
    if os.path.exists(whole):
        os.unlink(whole)
    done = subprocess.run([test.programs_at["record"], "recover", cut, "-o", whole], capture_output=True, text=True, timeout=240)
    check(done.returncode in (0, 1), f"recover ended with {done.returncode}: {done.stderr}")
    return McapFile(whole) if done.returncode == 0 else None


def sequences_of(recording):
    return [pose_frame(message)[1] for _, message in recording.of("poses")] if recording else []


def progress_of(operations):
    """Returns the frames and replacements that were complete before the power cut."""
    files = {o.inode for o in operations if os.path.basename(o.path) == "progress"}
    data = b"".join(o.data for o in operations if o.inode in files)
    return struct.unpack("=QQ", data[-16:]) if data else (0, 0)


def check_cut(test, operations, generator, seen):
    disk = Disk()
    for operation in operations:
        disk.do(operation)
    frames, replacements = progress_of(operations)
    left = disk.after_cut(generator)
    sequences = sequences_of(recover(test, left["run.mcap"])) if "run.mcap" in left else []
    due = max(0, frames - FLUSH_MS)
    check(sequences == sorted(set(sequences)), f"frames are not in order: {sequences}")
    check(sequences[:due] == list(range(1, due + 1)),
          f"{frames} frames were recorded, and those until {due} are due; there are {len(sequences)}")
    if "settings" in left:
        lines = left["settings"].decode().split()
        check(len(left["settings"]) >= 5000 and len(set(lines)) == 1, f"settings is no version of the file: {lines[:3]}...")
        check(int(lines[0]) in (replacements, replacements + 1), f"settings is {lines[0]}, not {replacements} or the next")
    else:
        check(replacements == 0, f"settings is missing after {replacements} replacements")
    seen["frames lost"] += frames > len(sequences)
    seen["frames kept"] += len(sequences) > 0


def recordings_and_replaced_files(test):
    generator, seen = random.Random(SEED), collections.Counter()
    total = len(run_writer(test, "whole", 0))
    for cut in range(CUTS):
        kill_at = generator.randint(1, total)
        check_cut(test, run_writer(test, f"cut{cut}", kill_at), generator, seen)
    check(seen["frames lost"] > 0 and seen["frames kept"] > 0, f"the cuts were none: {seen}")


def recorder_program(test):
    """fire3dv-record flushes periodically: a cut run recovers all messages up to the last flush."""
    generator = random.Random(SEED)
    flushed_frames = 0
    for cut in range(max(2, CUTS // 20)):
        folder, journal = test.path(f"recorder{cut}"), test.path(f"recorder{cut}.journal")
        os.mkdir(folder)
        uri = test.fresh_uri("tcp")
        recording = Program(test, "recorder", [test.programs_at["record"], "--from", uri, "--out",
                                               os.path.join(folder, "run.mcap"), "--sync", "0.2"],
                            env=preloaded(test, folder, journal, generator.randint(12, 40)))
        uri = recording.wait_err(r"listening on (\S+)").group(1)
        source = Program(test, "source", [test.programs_at["source"], uri, "arm", str(10**6), "500", "20"])
        recording.expect_exit(-signal.SIGKILL)
        source.kill()
        operations = operations_of(journal)
        disk, flushed = Disk(), b""
        for operation in operations:
            disk.do(operation)
            if operation.kind == FLUSH:
                flushed = disk.names[os.path.join(folder, "run.mcap")].content()
        path = test.path("flushed.mcap")
        with open(path, "wb") as file:
            file.write(flushed)
        expected = McapFile(path, whole=False).messages if flushed else []
        recovered = recover(test, disk.after_cut(generator).get("run.mcap", b""))
        got = recovered.messages if recovered else []
        check([m[2:] for m in got[:len(expected)]] == [m[2:] for m in expected],
              f"{len(expected)} messages were flushed, and are not the first of the {len(got)} that were recovered")
        flushed_frames += len(expected)
    check(flushed_frames > 0, "the recorder flushed nothing")


if __name__ == "__main__":
    main({f.__name__: f for f in (recordings_and_replaced_files, recorder_program)}, ("record", "source", "writer", "shim"))
