"""End-to-end test of recordings: published messages are in the file, replays repeat them, and files survive faults."""
import json
import os
import re
import resource
import signal
import subprocess

from harness import Program, check, main, wait_until
from mcap_file import McapFile, body_of, pose_frame

NODES = 20


def run(test, name, *arguments, code=0, stdin=None, **options):
    """Runs a program until it ends; returns its standard output."""
    done = subprocess.run([test.programs_at[name], *map(str, arguments)], capture_output=True, text=True, timeout=240,
                          input=stdin, **options)
    check(done.returncode == code, f"{name} {arguments} ended with {done.returncode}, not {code}:\n{done.stderr}")
    test.said = done.stderr
    return done.stdout


def recorder(test, uri, path, *arguments, **options):
    program = Program(test, "recorder", [test.programs_at["record"], "--from", uri, "--out", path, *arguments], **options)
    program.uri = program.wait_err(r"listening on (\S+)").group(1)
    return program


def source(test, uri, frames, rate, name="arm", waits=True):
    return Program(test, f"source {name}", [test.programs_at["source"], uri, name, str(frames), str(rate), str(NODES),
                                            *(["wait"] if waits else [])])


def check_frames(file, frames):
    """Each frame holds the published poses and occurs once. The link may have lost frames."""
    sequences = []
    for _, message in file.of("poses"):
        _, sequence, sim_time_ns, xs = pose_frame(message)
        sequences.append(sequence)
        check(sim_time_ns == sequence * 10**6 and len(xs) == NODES, f"frame {sequence} is another one")
        check(all(abs(x - sequence - i / 1000) < 1e-3 for i, x in enumerate(xs)), f"poses of frame {sequence} are wrong")
    check(sequences == sorted(set(sequences)) and sequences and sequences[-1] <= frames, f"sequences: {sequences}")
    return sequences


def round_trip(test, transport):
    frames = 300
    first, second = test.path("first.mcap"), test.path("second.mcap")
    uri = test.fresh_uri(transport)
    recording = recorder(test, uri, first, "--until-end")
    publisher = source(test, uri, frames, 200)
    publisher.expect_exit()
    recording.expect_exit()
    recorded = McapFile(first)
    sequences = check_frames(recorded, frames)
    if transport == "tcp":  # shared memory may overrun on a busy machine; a connection rarely drops a frame
        check(len(sequences) >= 0.8 * frames, f"{len(sequences)} of {frames} frames are in the file")
    said = json.loads(run(test, "inspect", "--json", first))
    poses = next(t for t in said["topics"] if t["topic"] == "/arm/poses")
    check(said["sound"] and said["messages"] == len(recorded.messages) and poses["frames"] == len(sequences)
          and poses["missing"] == sequences[-1] - sequences[0] + 1 - len(sequences), f"inspect says {said}")
    control = [message for _, message in recorded.of("control")]
    check([body_of(m)[0] for m in (control[0], control[-1])] == [1, 7], "it does not begin and end as a stream")
    check(sum(body_of(m)[0] == 8 for m in control) >= 10, "edits are missing")

    uri = test.fresh_uri(transport)
    again = recorder(test, uri, second, "--until-end")
    run(test, "replay", first, "--to", again.uri, "--wait", "--verbatim")
    again.expect_exit()
    replayed = McapFile(second)
    # On a busy machine a link may lose a frame, or an edit that a newer one replaced. All received messages
    # are recorded ones.
    for role in ("poses", "control"):
        known = {message for _, message in recorded.of(role)}
        came = [message for _, message in replayed.of(role)]
        check(came and all(m in known for m in came), f"{role} came back changed")
        check(len(came) >= 10, f"{role}: {len(came)} of {len(known)} came back")
    check(replayed.of("control")[0][1] == control[0], "the description came back changed")


def round_trip_shm(test):
    round_trip(test, "shm")


def round_trip_tcp(test):
    round_trip(test, "tcp")


def steps_and_parts(test):
    """--step plays a frame per input line, and --start first sends the state at that time."""
    path, stepped = test.path("steps.mcap"), test.path("stepped.mcap")
    uri = test.fresh_uri("tcp")
    recording = recorder(test, uri, path, "--until-end", "--attach", test.scene)
    source(test, uri, 100, 100).expect_exit()
    recording.expect_exit()
    recorded = McapFile(path)
    with open(test.scene, "rb") as scene:
        check(recorded.attachments == [("squares.glb", "model/gltf-binary", scene.read())], "the scene is another one")
    begin = recorded.messages[0][2]
    start_s = 0.5
    expected = [m for t, m in recorded.of("poses") if t >= begin + start_s * 1e9]
    uri = test.fresh_uri("shm")
    again = recorder(test, uri, stepped, "--until-end")
    run(test, "replay", path, "--to", uri, "--wait", "--verbatim", "--step", "--start", start_s, stdin="\n" * 3)
    again.expect_exit()
    replayed = McapFile(stepped)
    poses = [pose_frame(m)[1] for _, m in replayed.of("poses")]
    check(poses == [pose_frame(m)[1] for m in expected[:3]], f"three steps gave {poses}")
    kinds = [body_of(m)[0] for _, m in replayed.of("control")]
    check(kinds[0] == 1 and 8 in kinds and kinds[-1] == 7, f"before them came {kinds}")


def step_ends(test):
    """A signal ends --step while it waits for a line."""
    path, stepped = test.path("steps.mcap"), test.path("stepped.mcap")
    uri = test.fresh_uri("tcp")
    recording = recorder(test, uri, path, "--until-end")
    source(test, uri, 20, 100).expect_exit()
    recording.expect_exit()
    again = recorder(test, test.fresh_uri("tcp"), stepped, "--until-end")
    replay = subprocess.Popen([test.programs_at["replay"], path, "--to", again.uri, "--wait", "--step"],
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        replay.stdin.write(b"\n")
        replay.stdin.flush()
        wait_until("a frame", lambda: os.path.getsize(stepped) > 8 and McapFile(stepped, whole=False).of("poses"))
        replay.send_signal(signal.SIGTERM)
        check(replay.wait(timeout=120) == 0, f"it ended with {replay.returncode}")
    finally:
        replay.kill()
        replay.communicate()
    again.expect_exit()
    check(len(McapFile(stepped).of("poses")) == 1, "one line gave another number of frames")


def streams_in_order(test):
    """Each --to belongs to the --stream at the same position, independent of their order in the file."""
    path = test.path("two.mcap")
    uri = test.fresh_uri("tcp")
    recording = recorder(test, uri, path)
    sources = [source(test, recording.uri, 20, 100, name) for name in ("a", "b")]
    for each in sources:
        each.expect_exit()
    recording.process.send_signal(signal.SIGINT)
    recording.expect_exit()
    names = ("b", "a")
    again = [recorder(test, test.fresh_uri("tcp"), test.path(f"{name}.mcap"), "--until-end") for name in names]
    to = [word for name, each in zip(names, again) for word in ("--stream", name, "--to", each.uri)]
    run(test, "replay", path, "--wait", *to)
    for name, each in zip(names, again):
        each.expect_exit()
        said = json.loads(run(test, "inspect", "--json", test.path(f"{name}.mcap")))
        check(list(said["streams"]) == [name], f"{name} took {said['streams']}")


def killed(test):
    """After kill -9 every written chunk is present, and recover makes a whole file of them."""
    path, whole = test.path("killed.mcap"), test.path("whole.mcap")
    uri = test.fresh_uri("shm")
    source(test, uri, 10**6, 200, waits=False)
    recording = recorder(test, uri, path)
    wait_until("three chunks", lambda: os.path.getsize(path) > 8 and len(McapFile(path, whole=False).chunks) >= 3)
    recording.kill()
    cut = McapFile(path, whole=False)
    check(cut.end is None, "it was finished before it was killed")
    check_frames(cut, 10**6)
    run(test, "inspect", path, code=1)
    print(run(test, "record", "recover", path, "-o", whole).strip())
    mended = McapFile(whole)
    check([m[2:] for m in mended.messages] == [m[2:] for m in cut.messages], "what was recovered is something else")
    run(test, "inspect", whole)
    with open(path, "r+b") as file:  # truncated at any position
        file.truncate(cut.chunks[-1][2] + 100)
    os.unlink(whole)
    run(test, "record", "recover", path, "-o", whole)
    check(len(McapFile(whole).chunks) == len(cut.chunks) - 1, "the cut chunk is not the one that is missing")


def full_disk(test):
    """A write beyond the file size limit is a reported error, and the chunks in the file are whole."""
    path = test.path("full.mcap")
    uri = test.fresh_uri("shm")
    source(test, uri, 10**6, 500, waits=False)
    limit = 1_400_000  # two chunks or three, of a second each
    child = Program(test, "recorder", ["prlimit", f"--fsize={limit}", test.programs_at["record"], "--from", uri, "--out",
                                       path, "--compression", "none"])
    child.expect_exit(1)
    check(child.find_err("cannot be written: File too large"), f"it said:\n{child.stderr_text()}")
    check(os.path.getsize(path) <= limit, "it grew all the same")
    kept = McapFile(path, whole=False)
    check(kept.chunks and check_frames(kept, 10**6), "nothing is left")
    counts = re.search(r'"arm": \d+ nodes, (\d+) frames?,.* (\d+) edits?', "\n".join(child.out))
    edits = sum(body_of(m)[0] == 8 for _, m in kept.of("control"))
    check(counts and [int(n) for n in counts.groups()] == [len(kept.of("poses")), edits],
          f"the file has {len(kept.of('poses'))} frames and {edits} edits, and it reports {child.out}")
    run(test, "record", "recover", path, "-o", test.path("kept.mcap"))
    McapFile(test.path("kept.mcap"))


def disk_without_room(test):
    """A disk with room for less than a chunk: no frame is in the file, none is reported, and inspect says so."""
    path = test.path("tiny.mcap")
    uri = test.fresh_uri("shm")
    source(test, uri, 10**6, 500, waits=False)
    child = Program(test, "recorder", ["prlimit", "--fsize=40000", test.programs_at["record"], "--from", uri, "--out", path,
                                       "--compression", "none"])
    child.expect_exit(1)
    check(child.find_err(r"^fire3dv-record: error: .*tiny\.mcap cannot be written: File too large"), child.stderr_text())
    check(any('"arm": 20 nodes, 0 frames' in line for line in child.out), f"it reports {child.out}")
    said = run(test, "inspect", path, code=1)
    check("no frames" in said and "1970" not in said and "checksums are right" not in said, said)
    as_json = json.loads(run(test, "inspect", "--json", path, code=1))
    check(as_json["frames"] == 0 and as_json["sound"], f"inspect says {as_json}")


def nothing_published(test):
    """A URI without a publisher is an error after the time limit."""
    said = run(test, "inspect", test.fresh_uri("shm"), "--seconds", "0.3", code=1)
    check("no streams" in said and "nothing was published at shm://" in test.said and "0.3 s" in test.said, said + test.said)


def splits(test):
    """Each file of a series is complete by itself."""
    uri = test.fresh_uri("tcp")
    recording = recorder(test, uri, test.path("part.mcap"), "--until-end", "--split-mb", "0.05")
    source(test, uri, 200, 200).expect_exit()
    recording.expect_exit()
    parts = sorted(name for name in os.listdir(test.folder) if name.startswith("part_"))
    check(len(parts) >= 3, f"the files are {parts}")
    sequences = []
    for part in parts:
        file = McapFile(test.path(part))
        sequences += check_frames(file, 200)
        first = file.messages[0]
        check(body_of(first[4])[0] == 1, f"{part} does not begin with a description")
    check(sequences == sorted(set(sequences)), "a frame is in two files")


def thread_limit(test):
    """A thread that cannot be started is an error that names the limit, and no abort. Root has no such limit."""
    os.chmod(test.folder, 0o777)

    def limited():
        if os.getuid() == 0:
            os.setgroups([])
            os.setgid(54321)
            os.setuid(54321)
        resource.setrlimit(resource.RLIMIT_NPROC, (1, 1))
    for uri in ("tcp://127.0.0.1:0", test.fresh_uri("shm")):
        done = subprocess.run([test.programs_at["record"], "--from", uri, "--out", test.path("none.mcap")], preexec_fn=limited,
                              capture_output=True, text=True, timeout=240)
        check(done.returncode == 1 and re.search(r"^fire3dv-record: error: .* thread cannot be started: .*ulimit -u, now 1", done.stderr, re.M),
              f"{uri}: it ended with {done.returncode}:\n{done.stderr}")


def nothing_saved(test):
    """A recording without any whole chunk: recover says so and leaves no file."""
    path, whole = test.path("header.mcap"), test.path("nothing.mcap")
    recording = recorder(test, test.fresh_uri("shm"), path)
    recording.process.send_signal(signal.SIGTERM)
    recording.expect_exit()
    with open(path, "r+b") as file:
        file.truncate(100)
    run(test, "record", "recover", path, "-o", whole, code=1)
    check("nothing could be saved" in test.said and not os.path.exists(whole), test.said)


def usage(test):
    path = test.path("there.mcap")
    open(path, "w").close()
    for arguments, code, sentence in (
            (("--from", "shm://x"), 2, "--out"),
            (("--out", path), 2, "--from"),
            (("--from", "shm://x", "--out", path), 1, "is there already"),
            (("--from", "shm://x", "--out", test.path("y.mcap"), "--split-mb", "nan"), 2, "nan"),
            (("--from", "shm://x", "--out", test.path("y.mcap"), "--attach", "/nowhere.glb"), 1, "/nowhere.glb"),
            (("--from", "shm://x", "--out", "/nowhere/x.mcap"), 1, "cannot be made"),
            (("--from", "nothing://x", "--out", test.path("y.mcap")), 1, "nothing"),
            (("recover", path, "-o", test.path("z.mcap")), 1, "is not an MCAP file")):
        run(test, "record", *arguments, code=code)
        check(sentence in test.said, f"record {arguments} said: {test.said}")
    for arguments, code, sentence in (
            ((path, "--to", "shm://x"), 1, "is not an MCAP file"),
            ((test.path("none.mcap"), "--to", "shm://x"), 1, "cannot be opened"),
            ((path, "--to", "shm://x", "--speed", "nan"), 2, "nan"),
            ((path, "--to", "shm://x", "--stream", "a", "--stream", "a"), 2, "named twice"),
            ((path, "--to", "shm://x", "--start", "-1"), 2, "-1")):
        run(test, "replay", *arguments, code=code)
        check(sentence in test.said, f"replay {arguments} said: {test.said}")
    run(test, "inspect", path, code=1)
    run(test, "inspect", path, "shm://x", code=2)
    check(not os.path.exists(test.path("y.mcap")), "a recording that never began left a file")
    check(os.path.getsize(path) == 0, "a file that was there was written to")


if __name__ == "__main__":
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    main({f.__name__: f for f in (usage, round_trip_shm, round_trip_tcp, steps_and_parts, step_ends, streams_in_order, killed, full_disk,
                                 disk_without_room, nothing_published, nothing_saved, thread_limit, splits)},
         ("record", "replay", "inspect", "source"))
