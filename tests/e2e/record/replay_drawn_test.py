#!/usr/bin/env python3
"""End-to-end test of recordings in the renderer: it records received messages, and a replay draws the images of the live
run.
"""
import os
import resource
import signal
import subprocess

from harness import HANG_S, Program, check, main, shown, vulkan_environment, wait_until
from mcap_file import McapFile, body_of, pose_frame

FRAMES = 24
HIDDEN_FROM = 16


def record_live(test, path, *arguments):
    """A recorded lockstep run; returns its renderer."""
    uri = test.fresh_uri("tcp")
    publisher = test.publisher(uri, nodes=("red", "green"))
    live = test.renderer("--lockstep", "--exit-when-done", "--record", path, *arguments, listen=[uri])
    publisher.do(f"lockstep {HIDDEN_FROM}")
    publisher.do("hide green")
    publisher.do(f"lockstep {FRAMES - HIDDEN_FROM}")
    publisher.quit()
    live.expect_exit()
    return live


def pictures(renderer):
    """Returns (sequence, pixels) of each image that shows a frame."""
    return [(shown(f, "arm")["sequence"], renderer.picture(f).rows) for f in renderer.frames() if shown(f, "arm")]


def live_is_replay(test):
    """Each frame once, with identical bytes, and with the scene attached to the recording."""
    path = test.path("live.mcap")
    live = pictures(record_live(test, path, "--record-scene", "--foxglove"))
    check([s for s, _ in live] == list(range(1, FRAMES + 1)), f"live drew {[s for s, _ in live]}")
    check(live[0][1] != live[1][1] and live[HIDDEN_FROM - 1][1] != live[-1][1], "its pictures are all alike")
    file = McapFile(path)
    with open(test.scene, "rb") as scene:
        check(file.attachments == [("squares.glb", "model/gltf-binary", scene.read())], "the scene is another one")
    check([pose_frame(m)[1] for _, m in file.of("poses")] == list(range(1, FRAMES + 1)), "frames are missing in the file")
    kinds = [body_of(m)[0] for _, m in file.of("control")]
    check(kinds == [1, 8, 7], f"control messages are {kinds}")

    again = test.renderer("--step", "--exit-when-done", scene=f"--replay={path}")
    again.expect_exit()
    replayed = pictures(again)
    check([s for s, _ in replayed] == [s for s, _ in live], f"the replay drew {[s for s, _ in replayed]}")
    different = [s for (s, a), (_, b) in zip(live, replayed) if a != b]
    check(not different, f"pictures of frames {different} are not the same")

    # Paced replay that is recorded again: every message is equal except for its publish time.
    copy = test.path("copy.mcap")
    paced = test.renderer("--speed", "4", "--exit-when-done", "--record", copy, "--replay", path)
    paced.expect_exit()
    sequences = [s for s, _ in pictures(paced)]
    check(sequences == sorted(sequences), f"paced, it drew {sequences}")
    check([pose_frame(m)[1:3] for _, m in McapFile(copy).of("poses")] == [pose_frame(m)[1:3] for _, m in file.of("poses")],
          "the recording of the replay has other frames")

    # From a start time on: first the state at that time.
    times = [t for t, _ in file.of("poses")]
    start_s = (times[19] - min(m[2] for m in file.messages)) / 1e9 + 1e-6
    late = test.renderer("--step", "--exit-when-done", "--start", f"{start_s:.9f}", "--replay", path)
    late.expect_exit()
    check([(s, rows == live[s - 1][1]) for s, rows in pictures(late)] == [(s, True) for s in range(20, FRAMES + 1)],
          "from the middle on it drew something else")


def full_disk(test):
    """A recording beyond the file size limit is reported, and the renderer goes on. Its counts are those of the file."""
    path = test.path("full.mcap")
    uri = test.fresh_uri("shm")
    publisher = test.publisher(uri)
    publisher.do("stream 500")
    # The driver writes files of its own before: the limit applies once the program draws.
    renderer = Program(test, "fire3dv", [test.programs_at["fire3dv"], test.scene, "--headless", "--size", "32x18", "--shadows", "off", "--cache",
                                         "off", "--listen", uri, "--record", path],
                       {**vulkan_environment(), "MESA_SHADER_CACHE_DISABLE": "true"})
    wait_until("a chunk", lambda: os.path.exists(path) and os.path.getsize(path) > 1000 and McapFile(path, whole=False).chunks)
    resource.prlimit(renderer.process.pid, resource.RLIMIT_FSIZE, (os.path.getsize(path) + 100,) * 2)
    renderer.wait_err("recording ended: .*File too large")
    later = publisher.do("publish 3")
    publisher.wait_status("later frames to be shown", lambda s: s["acked"] == later["sequence"])
    renderer.signal(signal.SIGTERM)
    renderer.expect_exit(1)
    said = [line for line in renderer.err if "recording ended" in line]
    check(len(said) == 1, f"it was said {len(said)} times")
    counts = renderer.find_err(r"(\d+) frames? of 1 stream recorded in .*; \d+ messages missing")
    check(counts, renderer.stderr_text())
    kept = McapFile(path, whole=False).of("poses")
    check(kept and int(counts.group(1)) == len(kept), f"the file has {len(kept)} frames: {counts.group(0)}")
    check(renderer.find_err(r"error: the recording is incomplete: .*full\.mcap cannot be written: File too large"),
          renderer.stderr_text())


def full_image_folder(test):
    """An image that cannot be written ends the run with an error, and the reported count is that of the list."""
    folder = test.path("full")
    renderer = Program(test, "fire3dv", [test.programs_at["fire3dv"], test.scene, "--headless", "--size", "32x18", "--shadows", "off", "--cache",
                                         "off", "--out", folder, "--outputs", "color,depth", "--frames", "100000"],
                       {**vulkan_environment(), "MESA_SHADER_CACHE_DISABLE": "true"})
    log = os.path.join(folder, "frames.jsonl")
    wait_until("an image", lambda: os.path.exists(log) and os.path.getsize(log) > 100)
    resource.prlimit(renderer.process.pid, resource.RLIMIT_FSIZE, (os.path.getsize(log) + 5000,) * 2)
    renderer.expect_exit(1)
    check(renderer.find_err("error: cannot write .*full/frames.jsonl: File too large"), renderer.stderr_text())
    with open(log, encoding="ascii") as file:
        whole = sum(line.endswith("\n") for line in file)
    counts = renderer.find_err(r"(\d+) images in .*full; \d+ of (\d+) images missing")
    check(counts and int(counts.group(1)) == whole < int(counts.group(2)), f"{whole} are listed:\n{renderer.stderr_text()}")


def usage(test):
    path, plain = test.path("there.mcap"), test.path("plain.mcap")
    open(path, "w").close()
    record_live(test, plain)
    for arguments, code, words in (
            (("--replay", path), 1, ("is not an MCAP file",)),
            (("--replay", test.path("none.mcap")), 1, ("none.mcap", "cannot be opened")),
            (("--replay", plain), 1, ("no scene is attached", "SCENE.glb --replay")),
            ((test.scene, "--replay", plain, "--stream", "boat"), 1, ("boat", "it has \"arm\"")),
            ((test.scene, "--replay", plain, "--start", "2", "--end", "1"), 1, ("--start", "--end")),
            ((test.scene, "--replay", plain, "--speed", "nan"), 2, ("--speed", "nan")),
            ((test.scene, "--loop"), 2, ("--loop needs a recording",)),
            ((test.scene, "--record", test.path("x.mcap")), 2, ("--record needs a --listen URI",)),
            ((test.scene, "--listen", "shm://x", "--foxglove"), 2, ("--foxglove needs a --record file",)),
            ((test.scene, "--replay", plain, "--record", path), 1, ("--record", "is there already")),
            ((test.scene, "--replay", plain, "--step", "--play", "interpolate"), 2, ("--step", "exclude"))):
        result = subprocess.run([test.programs_at["fire3dv"], *arguments, "--headless", "--size", "32x18", "--cache", "off"],
                                capture_output=True, text=True, timeout=HANG_S, env=vulkan_environment(), check=False)
        check(result.returncode == code and all(word in result.stderr for word in words),
              f"{arguments} ended with {result.returncode} and said:\n{result.stderr}")
    check(not os.path.exists(test.path("x.mcap")), "a recording that never began left a file")


if __name__ == "__main__":
    main({f.__name__: f for f in (live_is_replay, full_disk, full_image_folder, usage)}, ["fire3dv", "publisher"], plain_images=True)
